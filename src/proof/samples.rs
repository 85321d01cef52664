//! The motion at given places on the way: in a window it is no further than ε from a polynomial.

use super::algebras::Row;
use super::end::coordinates;
use super::equations::Equations;
use super::proved::Proved;
use super::set::Set;
use super::{Coordinate, Motion};
use crate::number::Extended;
use crate::number::ball::Ball;

/// Lengths of γ are exact to their digits.
const OF_LENGTH: f64 = 1e-65;
/// About how many operations an unknown takes at a place, in those of a formula: a polynomial of 32 terms in balls.
const OPERATIONS: usize = 200;

/// The places, ascending, and what is known there.
pub(super) struct Samples<'m> {
    motion: &'m Motion<'m>,
    /// The coordinates at the first places; none where it is not known on which side of a joint it is.
    pub(super) found: Vec<Vec<Coordinate>>,
    unknowns: usize,
}

impl<'m> Samples<'m> {
    pub(super) fn new(motion: &'m Motion<'m>) -> Self {
        Self { motion, found: Vec::new(), unknowns: 0 }
    }

    /// The operations that they took.
    pub(super) fn operations(&self) -> f64 {
        (self.found.len() * self.unknowns * OPERATIONS) as f64
    }

    /// Looks at the places in a window that begins after `reached`.
    pub(super) fn take(&mut self, equations: &Equations<'_>, set: &Set, proved: &Proved, reached: f64) {
        self.unknowns = equations.unknowns;
        let end = Extended::from(reached) + Extended::from(proved.h);
        while let Some(&gamma) = self.motion.samples.get(self.found.len()).filter(|gamma| **gamma <= end) {
            let late = self.motion.late;
            let tau = Ball::of(gamma - Extended::from(reached), OF_LENGTH).widened(late);
            // Beyond the ends of the window the polynomial says nothing.
            let room = Extended::from(late);
            if gamma - room < Extended::from(reached) || gamma + room > end {
                self.found.push(Vec::new());
                continue;
            }
            let unknown = |k: usize| {
                let place = place(set.start[k], &proved.modes[k], proved.h, tau).widened(proved.added.epsilon[k]);
                (Extended::from(place.hi) + Extended::from(place.lo), place.rad)
            };
            let unknowns: Vec<(Extended, f64)> = (0..equations.unknowns).map(unknown).collect();
            self.found.push(coordinates(self.motion, equations, (gamma, late), &unknowns));
        }
    }
}

/// y_0 + (h/2) ∫v after a length τ of a window of the length h, from the coefficients of v.
fn place(start: f64, modes: &Row, h: f64, tau: Ball) -> Ball {
    let (one, whole) = (Ball::exact(1.0), |number: usize| Ball::exact(number as f64));
    let x = (tau + tau) / Ball::exact(h) - one;
    let (mut before, mut here) = (one, x);
    let mut sum = Ball::exact(modes[0]) * (one + x);
    for (k, &mode) in modes.iter().enumerate().skip(1) {
        let next = (whole(2 * k + 1) * x * here - whole(k) * before) / whole(k + 1);
        sum = sum + Ball::exact(mode) * (next - before) / whole(2 * k + 1);
        (before, here) = (here, next);
    }
    Ball::exact(start) + Ball::exact(0.5 * h) * sum
}
