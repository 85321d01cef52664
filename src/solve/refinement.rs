//! From an `f64` root to one in extended precision: iterative refinement.
//!
//! The residual is evaluated with all digits, the linearised system is solved in `f64`. Each round gains the digits
//! that the `f64` solution is good for, ten and more where the system is well conditioned, and nothing is ever factored
//! in extended precision (N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., ch. 12).

use super::newton::{Failure, LinearFailure, ROUNDING_UNITS, Root, RoundingLevels, relative, weigh};
use super::status::{IterationRecord, Status};
use crate::number::Real;
use crate::number::norm::max_abs;

/// A round that leaves more than this share of the previous correction has nothing left to gain.
const LEAST_GAIN: f64 = 0.5;

/// A system that is refined.
pub(super) trait Refined<S> {
    /// A point where F is not defined.
    type Outside: Copy;

    /// `out` = F(u) in extended precision.
    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), Self::Outside>;

    /// Overwrites `right` with J⁻¹ `right`, J being the Jacobian of F near the root.
    fn solve_linearised(&mut self, right: &mut [f64]) -> Result<(), LinearFailure>;

    /// The rounding errors to be expected in F(u), a level for each block of entries. `None` where F is not defined.
    fn rounding(&self, u: &[S]) -> Option<RoundingLevels>;

    /// Largest entry of each kind of coordinate in `u`.
    fn sizes(&self, u: &[S]) -> Vec<S>;

    /// The size that changes of each kind are relative to.
    fn scales(&self, u: &[S]) -> Vec<S> {
        self.sizes(u)
    }
}

/// 10^−digits.
pub(super) fn tolerance<S: Real>(digits: u32) -> S {
    S::from_decimal(&format!("1e-{digits}")).expect("a power of ten is a decimal")
}

/// Refines `root` until a correction changes no coordinate by more than 10^−`digits` of its kind's size. The error that
/// then remains is smaller by the gain of another round. Where the corrections stop shrinking before, the residual must
/// be at the rounding level of `S`, as it must be in `f64`.
pub(super) fn refine<S: Real, R: Refined<S>>(
    system: &mut R,
    root: Root,
    digits: u32,
    max_iterations: usize,
) -> Result<Root<S>, Failure<R::Outside>> {
    let Root { unknowns, mut history } = root;
    let tolerance: S = tolerance(digits);
    let mut u: Vec<S> = unknowns.iter().map(|&u| S::from(u)).collect();
    let mut residual = vec![S::ZERO; u.len()];
    let mut step = unknowns;
    let mut previous: Option<Vec<S>> = None;
    let mut correction = residual.clone();
    let first = history.len();
    loop {
        if let Err(outside) = system.residual(&u, &mut residual) {
            return Err(failed(Status::OutsideDomain, Some(outside), &u, &residual, history));
        }
        // Scaled, so that a residual of any size fits into the range of f64.
        let scale = max_abs(&residual);
        if scale == S::ZERO {
            return Ok(Root { unknowns: u, history });
        }
        for (step, &r) in step.iter_mut().zip(&residual) {
            *step = -(r / scale).to_f64();
        }
        if system.solve_linearised(&mut step).is_err() || !max_abs(&step).is_finite() {
            return Err(failed(Status::Singular, None, &u, &residual, history));
        }
        for (correction, &step) in correction.iter_mut().zip(&step) {
            *correction = scale * S::from(step);
        }
        let (changes, sizes) = (system.sizes(&correction), system.scales(&u));
        let small = |kind: usize| changes[kind] <= tolerance * sizes[kind];
        let shrinks = |kind: usize| {
            let previous = previous.as_ref().map_or(S::from(f64::INFINITY), |previous| previous[kind]);
            changes[kind] <= S::from(LEAST_GAIN) * previous
        };
        let kinds = 0..changes.len();
        if !kinds.clone().all(|kind| small(kind) || shrinks(kind)) || history.len() - first >= max_iterations {
            let levels = system.rounding(&u);
            if levels.is_some_and(|levels| weigh(&levels, &residual).largest <= ROUNDING_UNITS) {
                // The type has no more digits to give; the iteration history says how many there are.
                return Ok(Root { unknowns: u, history });
            }
            return Err(failed(Status::PrecisionNotReached, None, &u, &residual, history));
        }
        u.iter_mut().zip(&correction).for_each(|(u, &correction)| *u += correction);
        let change = changes.iter().copied().fold(S::ZERO, S::max).to_f64();
        let iteration = history.len() + 1;
        let relative_step = relative(&changes, &sizes);
        let residual_size = scale.to_f64();
        history.push(IterationRecord { iteration, residual: residual_size, step: change, damping: 1.0, relative_step });
        if kinds.clone().all(small) {
            return Ok(Root { unknowns: u, history });
        }
        previous = Some(changes);
    }
}

fn failed<S: Real, O>(
    status: Status,
    outside: Option<O>,
    u: &[S],
    residual: &[S],
    history: Vec<IterationRecord>,
) -> Failure<O> {
    let rough = |values: &[S]| values.iter().map(|value| value.to_f64()).collect();
    Failure { status, unknowns: rough(u), residual: rough(residual), outside, history }
}

#[cfg(test)]
mod tests {
    use super::{Refined, refine};
    use crate::number::{Extended, Real};
    use crate::solve::newton::{LinearFailure, Root, RoundingLevels};
    use crate::solve::status::Status;

    /// F(u) = u² − 2 with the Jacobian at 1.5, or without one.
    struct Root2 {
        solve: fn(f64) -> Result<f64, LinearFailure>,
    }

    impl Refined<Extended> for Root2 {
        type Outside = ();

        fn residual(&mut self, u: &[Extended], out: &mut [Extended]) -> Result<(), ()> {
            out[0] = u[0] * u[0] - Extended::from(2.0);
            Ok(())
        }

        fn solve_linearised(&mut self, right: &mut [f64]) -> Result<(), LinearFailure> {
            right[0] = (self.solve)(right[0])?;
            Ok(())
        }

        fn rounding(&self, _: &[Extended]) -> Option<RoundingLevels> {
            Some(vec![(0..1, Extended::EPSILON.to_f64())])
        }

        fn sizes(&self, u: &[Extended]) -> Vec<Extended> {
            vec![u[0].abs()]
        }
    }

    fn refined(solve: fn(f64) -> Result<f64, LinearFailure>) -> Result<Root<Extended>, Status> {
        let root = Root { unknowns: vec![1.5], history: vec![] };
        refine(&mut Root2 { solve }, root, 40, 100).map_err(|failure| failure.status)
    }

    #[test]
    fn a_root_gets_all_digits() {
        let root = refined(|right| Ok(right / 3.0)).unwrap();
        let exact = Extended::from_decimal("1.41421356237309504880168872420969807856967187537694").unwrap();
        assert!((root.unknowns[0] - exact).abs().to_f64() < 1e-40);
        assert!(root.history.last().unwrap().relative_step < 1e-40);
    }

    #[test]
    fn a_system_without_a_solution_is_singular() {
        let none: [fn(f64) -> Result<f64, LinearFailure>; 3] =
            [|_| Err(LinearFailure), |_| Ok(f64::NAN), |_| Ok(f64::INFINITY)];
        for solve in none {
            assert_eq!(refined(solve).unwrap_err(), Status::Singular);
        }
    }
}
