//! Damped Newton iteration on a square system, shared by the doubled action and the physical limit, and from an `f64`
//! root to one in extended precision by iterative refinement.
//!
//! There the residual is evaluated with all digits, and the linearised system is solved in `f64`. Each round gains the
//! digits that the `f64` solution is good for, ten and more where the system is well conditioned, and nothing is ever
//! factored in extended precision (N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., ch. 12).

use super::status::{IterationRecord, Status};
use crate::geometry::OutsideGeometry;
use crate::linalg::Singular;
use crate::number::Real;
use crate::number::norm::max_abs;

/// A residual at most this many rounding units is zero to working precision.
pub(super) const ROUNDING_UNITS: f64 = 32.0;
/// Relative step below which quadratic convergence has nothing left to gain in `f64`.
const SMALL_STEP: f64 = 1e-8;
/// Share of the predicted decrease of the squared residual that a step must realise (Armijo).
const SUFFICIENT_DECREASE: f64 = 1e-4;
/// Smallest step length tried.
const LEAST_DAMPING: f64 = 1e-6;
/// A round of refinement that leaves more than this share of the previous correction has nothing left to gain.
const LEAST_GAIN: f64 = 0.5;

/// F(u) = 0 in numbers of one kind.
pub(super) trait Equations<S> {
    /// `out` = F(u).
    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), OutsideGeometry>;

    /// The rounding errors to be expected in F(u), entry by entry. `None` where F is not defined.
    fn rounding(&self, u: &[S]) -> Option<Vec<f64>>;

    /// Largest entry of each kind of coordinate in `u`; they have different units, so each is judged by itself.
    fn sizes(&self, u: &[S]) -> Vec<S>;

    /// The size that changes of each kind are relative to.
    fn scales(&self, u: &[S]) -> Vec<S> {
        self.sizes(u)
    }
}

/// Equations with a Jacobian that they factor themselves.
pub(super) trait NewtonSystem: Equations<f64> {
    /// `step` = −F′(u)⁻¹ F(u), where `residual` = F(u) is what [`Equations::residual`] was asked for last.
    fn newton_step(&mut self, u: &[f64], residual: &[f64], step: &mut [f64]) -> Result<(), Singular>;
}

/// The largest entry of a residual in units of the rounding errors to be expected, and the sum of their squares.
fn weigh<S: Real>(levels: &[f64], residual: &[S]) -> [f64; 2] {
    let (mut largest, mut sum_of_squares) = (0.0_f64, 0.0);
    for (r, level) in residual.iter().map(|r| r.to_f64()).zip(levels) {
        // Where nothing can be rounded (everything is zero) only zero is accepted.
        let weighed = if r == 0.0 { 0.0 } else { (r / level).abs() };
        largest = if weighed.is_nan() { f64::INFINITY } else { largest.max(weighed) };
        sum_of_squares += weighed * weighed;
    }
    [largest, sum_of_squares]
}

/// The largest of the changes, each relative to the size of its kind.
fn relative<S: Real>(changes: &[S], sizes: &[S]) -> f64 {
    let of = |(&change, &size): (&S, &S)| if change == S::ZERO { S::ZERO } else { change / size };
    changes.iter().zip(sizes).map(of).fold(S::ZERO, S::max).to_f64()
}

/// A zero of F.
#[derive(Debug, Clone)]
pub(super) struct Root<S = f64> {
    pub(super) unknowns: Vec<S>,
    pub(super) history: Vec<IterationRecord>,
}

/// Why no zero was found.
#[derive(Debug, Clone)]
pub(super) struct Failure {
    pub(super) status: Status,
    /// The last accepted iterate.
    pub(super) unknowns: Vec<f64>,
    pub(super) residual: Vec<f64>,
    /// The last trial point that left the domain in the step that failed, if any did.
    pub(super) outside: Option<OutsideGeometry>,
    pub(super) history: Vec<IterationRecord>,
}

impl Failure {
    /// A failure that has no iterate to show.
    pub(super) fn without_iterate(status: Status) -> Self {
        Self { status, unknowns: Vec::new(), residual: Vec::new(), outside: None, history: Vec::new() }
    }

    /// The failure of a recursion that ended at a point outside the domain.
    pub(super) fn outside(point: OutsideGeometry) -> Self {
        Self { outside: Some(point), ..Self::without_iterate(Status::OutsideDomain) }
    }
}

/// Solves F(u) = 0 from `guess`, damping by |F|².
///
/// A converged iteration means that the largest residual entry is at the rounding level, and that either the last
/// coordinate step was below the square root of the precision or the residual had already been at that level before the
/// step.
pub(super) fn solve(system: &mut impl NewtonSystem, guess: Vec<f64>, max_iterations: usize) -> Result<Root, Failure> {
    let (mut residual, mut unknowns, mut history) = (vec![0.0; guess.len()], guess, Vec::new());
    match iterate(system, max_iterations, [&mut unknowns, &mut residual], &mut history) {
        Ok(()) => Ok(Root { unknowns, history }),
        Err((status, outside)) => Err(Failure { status, unknowns, residual, outside, history }),
    }
}

/// Why there is no further iterate, with the point of a trial that left the domain.
type Stop = (Status, Option<OutsideGeometry>);

/// Changes `u` until it is a root, with its residual. On an error they are those of the last accepted iterate.
fn iterate(
    system: &mut impl NewtonSystem,
    max_iterations: usize,
    [u, residual]: [&mut Vec<f64>; 2],
    history: &mut Vec<IterationRecord>,
) -> Result<(), Stop> {
    if let Err(outside) = system.residual(u, residual) {
        residual.fill(f64::INFINITY);
        return Err((Status::OutsideDomain, Some(outside)));
    }
    let mut step = vec![0.0; u.len()];
    let (mut trial, mut trial_residual) = (u.clone(), residual.clone());
    let mut was_at_rounding = false;
    for iteration in 1..=max_iterations {
        let levels = system.rounding(u).ok_or((Status::OutsideDomain, None))?;
        if system.newton_step(u, residual, &mut step).is_err() || !max_abs(&step).is_finite() {
            return Err((Status::Singular, None));
        }
        let [_, before] = weigh(&levels, residual);
        let (damping, at_rounding) = damped(system, [u, &step], (&levels, before), [&mut trial, &mut trial_residual])?;
        std::mem::swap(u, &mut trial);
        std::mem::swap(residual, &mut trial_residual);
        let changes: Vec<f64> = system.sizes(&step).into_iter().map(|size| damping * size).collect();
        let change = changes.iter().copied().fold(0.0, f64::max);
        let sizes = system.scales(u);
        let relative_step = relative(&changes, &sizes) / damping;
        history.push(IterationRecord { iteration, residual: max_abs(residual), step: change, damping, relative_step });
        let small = changes.iter().zip(&sizes).all(|(change, size)| *change <= SMALL_STEP * size);
        if at_rounding && (was_at_rounding || (small && damping == 1.0)) {
            return Ok(());
        }
        was_at_rounding = at_rounding;
    }
    Err((Status::MaxIterations, None))
}

/// The damping of a step from `u` with which the residual, `before` there in units of `levels`, decreases enough, and
/// whether it is rounding then. The iterate and its residual are left in `trial`.
fn damped(
    system: &mut impl NewtonSystem,
    [u, step]: [&[f64]; 2],
    (levels, before): (&[f64], f64),
    [trial, residual]: [&mut [f64]; 2],
) -> Result<(f64, bool), Stop> {
    let (mut damping, mut last_outside) = (1.0, None);
    loop {
        for ((trial, u), step) in trial.iter_mut().zip(u).zip(step) {
            *trial = u + damping * step;
        }
        let status = match system.residual(trial, residual) {
            Ok(()) => {
                let [largest, after] = weigh(levels, residual);
                let at_rounding = largest <= ROUNDING_UNITS;
                let enough = (1.0 - 2.0 * SUFFICIENT_DECREASE * damping) * before;
                if at_rounding || after <= enough {
                    return Ok((damping, at_rounding));
                }
                Status::Stalled
            }
            Err(point) => {
                last_outside = Some(point);
                Status::OutsideDomain
            }
        };
        damping *= 0.5;
        if damping < LEAST_DAMPING {
            return Err((status, last_outside));
        }
    }
}

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
    let mut previous = vec![S::from(f64::INFINITY); system.sizes(&u).len()];
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
        let kinds = 0..changes.len();
        let goes_on = kinds.clone().all(|kind| small(kind) || gains(changes[kind], previous[kind]));
        if !goes_on || history.len() - first >= max_iterations {
            let levels = system.rounding(&u);
            if levels.is_some_and(|levels| weigh(&levels, &residual)[0] <= ROUNDING_UNITS) {
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
        previous = changes;
    };
    let rough = |values: &[S]| values.iter().map(|value| value.to_f64()).collect();
    Err(Failure { status, unknowns: rough(&u), residual: rough(&residual), outside, history })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// F(u) = atan(u − 1) with a step that may fail.
    struct Arctangent(fn(f64) -> Result<f64, Singular>);

    fn newton(u: f64) -> Result<f64, Singular> {
        Ok(-(u - 1.0).atan() * (1.0 + (u - 1.0).powi(2)))
    }

    impl Equations<f64> for Arctangent {
        fn residual(&mut self, u: &[f64], out: &mut [f64]) -> Result<(), OutsideGeometry> {
            out[0] = (u[0] - 1.0).atan();
            Ok(())
        }

        fn rounding(&self, _: &[f64]) -> Option<Vec<f64>> {
            Some(vec![f64::EPSILON])
        }

        fn sizes(&self, u: &[f64]) -> Vec<f64> {
            vec![u[0].abs()]
        }
    }

    impl NewtonSystem for Arctangent {
        fn newton_step(&mut self, u: &[f64], _: &[f64], step: &mut [f64]) -> Result<(), Singular> {
            step[0] = (self.0)(u[0])?;
            Ok(())
        }
    }

    #[test]
    fn a_step_is_damped_and_measured_as_a_whole() {
        let solved = |start: f64| solve(&mut Arctangent(newton), vec![start], 20).unwrap();
        let start = 3.0;
        let Root { unknowns, history } = solved(start);
        assert!((unknowns[0] - 1.0).abs() < 1e-15);
        let (first, last) = (&history[0], history.last().unwrap());
        let whole = newton(start).unwrap_or(0.0);
        // The whole step goes further away than it came from.
        assert_eq!((first.damping, first.step), (0.5, (0.5 * whole).abs()));
        let next = start + 0.5 * whole;
        assert!((first.relative_step - (whole / next).abs()).abs() < 1e-15);
        assert_eq!(first.residual, (next - 1.0).atan().abs());
        // It ends with a step that has nothing left to gain.
        assert!(last.damping == 1.0 && last.residual < 32.0 * f64::EPSILON, "{last:?}");
        // A root that is met by a step that was not small is looked at once more.
        assert_eq!([1.0 + 0.5 * SMALL_STEP, 1.0 + 1e-6].map(|start| solved(start).history.len()), [1, 2]);
    }

    #[test]
    fn a_system_without_a_step_is_singular() {
        let no_step: [fn(f64) -> Result<f64, Singular>; 3] =
            [|_| Err(Singular), |_| Ok(f64::NAN), |_| Ok(f64::INFINITY)];
        for step in no_step {
            let mut system = Arctangent(step);
            let Failure { status, unknowns, .. } = solve(&mut system, vec![3.0], 20).unwrap_err();
            assert_eq!((status, unknowns), (Status::Singular, vec![3.0]));
            let solve = |right: &mut [f64]| step(right[0]).map(|solution| right[0] = solution);
            let root = Root { unknowns: vec![3.0], history: Vec::new() };
            assert_eq!(refine(&mut system, solve, root, (16, 20)).unwrap_err().status, Status::Singular);
        }
    }
}
