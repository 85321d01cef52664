//! From an `f64` root to one in extended precision: iterative refinement.
//!
//! The residual is evaluated with all digits, the linearised system is solved in `f64`. Each round gains the digits
//! that the `f64` solution is good for, ten and more where the system is well conditioned, and nothing is ever factored
//! in extended precision (N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., ch. 12).

use super::newton::{Equations, Failure, ROUNDING_UNITS, Root, relative, weigh};
use super::status::{IterationRecord, Status};
use crate::linalg::Singular;
use crate::number::Real;
use crate::number::norm::max_abs;

/// A round that leaves more than this share of the previous correction has nothing left to gain.
const LEAST_GAIN: f64 = 0.5;

/// Returns true if a round whose correction is `change` gains something on the one before.
pub(super) fn gains<S: Real>(change: S, before: S) -> bool {
    change <= S::from(LEAST_GAIN) * before
}

/// 10^−digits.
pub(super) fn tolerance<S: Real>(digits: u32) -> S {
    S::from_decimal(&format!("1e-{digits}")).expect("a power of ten is a decimal")
}

/// Refines `root` until a correction changes no coordinate by more than 10^−`digits` of its kind's size. The error that
/// then remains is smaller by the gain of another round. Where the corrections stop shrinking before, the residual must
/// be at the rounding level of `S`, as it must be in `f64`. `solve_linearised` overwrites a right-hand side r with the
/// solution J⁻¹r, J being the Jacobian of the system near the root.
pub(super) fn refine<S: Real>(
    system: &mut impl Equations<S>,
    mut solve_linearised: impl FnMut(&mut [f64]) -> Result<(), Singular>,
    root: Root,
    (digits, max_iterations): (u32, usize),
) -> Result<Root<S>, Failure> {
    let Root { unknowns, mut history } = root;
    let tolerance: S = tolerance(digits);
    let mut u: Vec<S> = unknowns.iter().map(|&u| S::from(u)).collect();
    let mut residual = vec![S::ZERO; u.len()];
    let mut step = unknowns;
    let mut previous: Option<Vec<S>> = None;
    let (mut correction, first) = (residual.clone(), history.len());
    let (status, outside) = loop {
        if let Err(outside) = system.residual(&u, &mut residual) {
            break (Status::OutsideDomain, Some(outside));
        }
        // Scaled, so that a residual of any size fits into the range of f64.
        let scale = max_abs(&residual);
        if scale == S::ZERO {
            return Ok(Root { unknowns: u, history });
        }
        for (step, &r) in step.iter_mut().zip(&residual) {
            *step = -(r / scale).to_f64();
        }
        if solve_linearised(&mut step).is_err() || !max_abs(&step).is_finite() {
            break (Status::Singular, None);
        }
        for (correction, &step) in correction.iter_mut().zip(&step) {
            *correction = scale * S::from(step);
        }
        let (changes, sizes) = (system.sizes(&correction), system.scales(&u));
        let small = |kind: usize| changes[kind] <= tolerance * sizes[kind];
        let shrinks = |kind: usize| {
            let previous = previous.as_ref().map_or(S::from(f64::INFINITY), |previous| previous[kind]);
            gains(changes[kind], previous)
        };
        let kinds = 0..changes.len();
        if !kinds.clone().all(|kind| small(kind) || shrinks(kind)) || history.len() - first >= max_iterations {
            let levels = system.rounding(&u);
            if levels.is_some_and(|levels| weigh(&levels, &residual).largest <= ROUNDING_UNITS) {
                // The type has no more digits to give; the iteration history says how many there are.
                return Ok(Root { unknowns: u, history });
            }
            break (Status::PrecisionNotReached, None);
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
    };
    let rough = |values: &[S]| values.iter().map(|value| value.to_f64()).collect();
    Err(Failure { status, unknowns: rough(&u), residual: rough(&residual), outside, history })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::OutsideGeometry;
    use crate::number::Extended;
    use crate::solve::newton::RoundingLevels;

    /// F(u) = u² − 2.
    struct Root2;

    impl Equations<Extended> for Root2 {
        fn residual(&mut self, u: &[Extended], out: &mut [Extended]) -> Result<(), OutsideGeometry> {
            out[0] = u[0] * u[0] - Extended::from(2.0);
            Ok(())
        }

        fn rounding(&self, _: &[Extended]) -> Option<RoundingLevels> {
            Some(vec![(0..1, Extended::EPSILON.to_f64())])
        }

        fn sizes(&self, u: &[Extended]) -> Vec<Extended> {
            vec![u[0].abs()]
        }
    }

    fn refined(solve: impl Fn(f64) -> Result<f64, Singular>) -> Result<Root<Extended>, Status> {
        let root = Root { unknowns: vec![1.5], history: vec![] };
        let solve = |right: &mut [f64]| solve(right[0]).map(|solution| right[0] = solution);
        refine(&mut Root2, solve, root, (40, 100)).map_err(|failure| failure.status)
    }

    #[test]
    fn a_root_gets_all_digits() {
        // The Jacobian is that at 1.5.
        let root = refined(|right| Ok(right / 3.0)).unwrap();
        let exact = Extended::from_decimal("1.41421356237309504880168872420969807856967187537694").unwrap();
        assert!((root.unknowns[0] - exact).abs().to_f64() < 1e-40);
        assert!(root.history.last().unwrap().relative_step < 1e-40);
    }

    #[test]
    fn a_system_without_a_solution_is_singular() {
        for solution in [Err(Singular), Ok(f64::NAN), Ok(f64::INFINITY)] {
            assert_eq!(refined(|_| solution).unwrap_err(), Status::Singular);
        }
    }
}
