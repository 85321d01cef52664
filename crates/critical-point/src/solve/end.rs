//! Runs that end where a coordinate reaches a value: the length of γ at which the last node is there.

use super::failure::NoSolution;
use super::places::Places;
use super::search::{self, Excess, NotFound, Search};
use super::status::{Iterations, Status};
use super::world_line::{Place, WorldLine};
use crate::scalar::Real;

/// The share of the whole way that counts as none has this many digits in `f64`; with more digits, all of them must
/// agree.
const DIGITS_OF_WAY: u32 = 14;
/// The same of the length of γ.
pub(super) const DIGITS_OF_LENGTH: u32 = 15;

/// The value of a coordinate that a run is to end at, as joints count it, and how well it is to be met.
#[derive(Debug, Clone, Copy)]
pub(super) struct Target<S> {
    pub(super) coordinate: usize,
    pub(super) value: S,
    /// Significant digits of the runs.
    pub(super) digits_of_runs: u32,
    /// Whether a share of the whole way counts as none, or else one of the length of γ.
    pub(super) is_of_way: bool,
}

impl<S: Real> Target<S> {
    /// The length that would do at constant speed.
    pub(super) fn guess<G>(&self, place: &Place<S, G>) -> S {
        (self.value - place.start.q[self.coordinate]) / place.start.q_dot[self.coordinate]
    }

    /// Newton's method on γ_f with the velocity at the end of each solution, kept inside the bracket found so far: the
    /// coordinate grows, or falls, with γ_f. A γ_f that has no solution (a horizon on the way) is an upper bound like
    /// one that ends too late.
    pub(super) fn search<G: Places<S>>(
        &self,
        place: &Place<S, G>,
        gamma_i: S,
        guess: S,
        solve_to: &mut dyn FnMut(S) -> Result<WorldLine<S, G>, NoSolution>,
    ) -> Result<WorldLine<S, G>, NoSolution> {
        let Self { coordinate, value, digits_of_runs, is_of_way } = *self;
        let double_digits = if is_of_way { DIGITS_OF_WAY } else { DIGITS_OF_LENGTH };
        let way = value - place.start.q[coordinate];
        let asked = Search {
            guess,
            limit: S::from(f64::INFINITY),
            digits: if S::IS_EXTENDED { digits_of_runs } else { double_digits },
            digits_of_runs,
            scale: is_of_way.then(|| way.abs()),
        };
        let excess = |line: &WorldLine<S, G>| {
            let end = line.last_joint();
            Excess {
                value: (end.q[coordinate] - value) * way.signum(),
                slope: Some(line.velocities(end)[coordinate] * way.signum()),
            }
        };
        search::search(asked, solve_to, excess).map_err(|error| not_reached(error, place, gamma_i))
    }
}

/// The failure of a search for the end of a run that starts at `place`.
pub(super) fn not_reached<S: Real, G: Places<S>>(
    error: NotFound<WorldLine<S, G>, NoSolution>,
    place: &Place<S, G>,
    gamma_i: S,
) -> NoSolution {
    let closest = match error {
        NotFound::Failed(failure) => return failure,
        NotFound::Missed(closest) => closest,
    };
    let Some(closest) = closest else {
        let at = place.geometry.place(gamma_i.to_f64(), &place.start.q);
        return NoSolution::new(Status::EndTimeNotReached, at);
    };
    let at = closest.geometry().place(closest.gamma_f().to_f64(), closest.last_joint().q);
    let Iterations { initial_guess, history, .. } = closest.iterations;
    NoSolution {
        iterations: Box::new(Iterations::of(initial_guess, history)),
        residual: closest.gradient_norm.to_f64(),
        ..NoSolution::new(Status::EndTimeNotReached, at)
    }
}
