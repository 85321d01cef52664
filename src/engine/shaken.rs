//! A start that is off by its last digits.
//!
//! Two marches of one start share what its numbers lack, and where both are better than rounding they differ by the
//! chance that they round in other ways. Where small changes grow, on the way to the top of a hill or near a circular
//! orbit of light, that difference says nothing: it is as often a tenth of the error as it is the error. So the march
//! that judges begins with every number off by a rounding, in the place of all roundings to come: the first ones grow
//! most, and what a slope is rounded by is the mean of many nodes, a tenth of this.
//!
//! Signs alternate, as a start may lie on a line that every multiple of it lies on. What rests stays at rest.

use super::rule::Order;
use super::window::Solver;
use crate::geometry::Start;
use crate::number::Compensated;

/// By how much a number is off, relative to it.
const ROUNDING: f64 = f64::EPSILON;

impl<const N: usize> Solver<'_, N> {
    /// Shakes the start by the last digits of positions, momenta and charges, but for times and for what rests.
    pub(super) fn shake(&mut self) {
        let Self { geometry, initial: Start { q, q_dot, p }, scales, rows, start, end, system, ignorable, .. } = self;
        let (m, forces) = (geometry.active().len(), geometry.forces(q, q_dot));
        let sign = |place: usize| if place.is_multiple_of(2) { ROUNDING } else { -ROUNDING };
        for (place, &a) in geometry.active().iter().enumerate() {
            let rests = p[a] == 0.0 && q_dot[a] == 0.0 && forces[a] == 0.0;
            if scales.clocks[place] || rests {
                continue;
            }
            for (row, part) in [(place, sign(place)), (m + place, -sign(place))] {
                let off = part * rows[row].start.high;
                rows[row].start.low += off;
                rows[row].end = rows[row].start;
            }
            start.q[a] = rows[place].start;
            start.p[place] = match system.order {
                Order::First => rows[m + place].start,
                Order::Second => start.p[place].plus_small(Compensated::from(-sign(place) * start.p[place].high)),
            };
        }
        end.clone_from(start);
        // That of s is no momentum of a motion.
        let mut charges = p.clone();
        for (place, &a) in ignorable.iter().enumerate().filter(|(_, a)| **a < geometry.results()) {
            charges[a] *= 1.0 - sign(place);
        }
        system.begin(&charges);
    }
}
