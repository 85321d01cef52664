//! A start that is off by its last digits.
//!
//! Two marches of one start share what its numbers lack, and where both are better than rounding they differ by the
//! chance that they round in other ways. Where small changes grow, on the way to the top of a hill or near a circular
//! orbit of light, that difference says nothing: it is as often a tenth of the error as it is the error. So the march
//! that judges begins with every number off by a rounding, in the place of all roundings to come: the first ones grow
//! most, and what a slope is rounded by is the mean of many nodes, a tenth of this.
//!
//! Signs alternate, as a start may lie on a line that every multiple of it lies on. What rests stays at rest.
//!
//! Both also share the doubles that stand for the decimals of a case, by which a force is wrong in the same way all the
//! time. So the march that judges has other ones: each constant of its formulas is the next double, which is further
//! from the one of the run than what both stand for. One with a short fraction, as 2 or 0.375, is what was written.

use super::rates::Rates;
use super::rule::Order;
use super::system::System;
use super::window::Solver;
use crate::geometry::{Geometry, Start};
use crate::number::Compensated;
use crate::number::vector::Nodes;

/// By how much a number of the start is off, relative to it.
const ROUNDING: f64 = f64::EPSILON;
/// The bits of the fraction of a double.
const FRACTION: u64 = (1 << (f64::MANTISSA_DIGITS - 1)) - 1;
/// A double that is rounded ends in so many zeros once in 65 536 times. What has no more digits than 36 bits is exact.
const ZEROS: u32 = 16;
/// A force that constants change by more has less than half of its digits.
const HALF: f64 = 1e-8;

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
        if !is_held_by_constants(geometry, [q, q_dot, p]) {
            system.shake();
        }
        system.begin(&charges);
    }
}

/// Returns true if a coordinate begins at rest, and if the force on it is nothing, or what its constants leave: with
/// others it would go elsewhere, or begin to move elsewhere in the tail of a pulse, where only shares are known.
fn is_held_by_constants(geometry: &Geometry, [q, q_dot, p]: [&[f64]; 3]) -> bool {
    let at_rest: Vec<usize> = geometry.active().iter().copied().filter(|&a| p[a] == 0.0 && q_dot[a] == 0.0).collect();
    if at_rest.is_empty() {
        return false;
    }
    let [plain, other]: [fn(f64) -> f64; 2] = [|constant| constant, moved];
    let [plain, other] = [plain, other].map(|of| Rates::with_constants(geometry, of).at(geometry, q, p));
    let force = |a: usize| q.len() + a;
    at_rest.into_iter().any(|a| (other[force(a)] - plain[force(a)]).abs() >= HALF * plain[force(a)].abs())
}

impl<const N: usize> System<'_, N> {
    /// Moves the constants of formulas.
    fn shake(&mut self) {
        let program = &self.geometry.hamiltonian.program;
        let constants = program.constants().map(|(register, constant)| (register, moved(constant)));
        constants.for_each(|(register, constant)| self.registers[register] = Nodes([constant; N]));
    }
}

/// The next double, to a side that a number has in common with its multiples by powers of two and with its opposite;
/// or the same one, where a fraction has so many zeros at its end that it is exact.
fn moved(constant: f64) -> f64 {
    let fraction = constant.to_bits() & FRACTION;
    if !constant.is_normal() || fraction.trailing_zeros() >= ZEROS {
        return constant;
    }
    let is_down = fraction.count_ones().is_multiple_of(2);
    f64::from_bits(if is_down { constant.to_bits() - 1 } else { constant.to_bits() + 1 })
}
