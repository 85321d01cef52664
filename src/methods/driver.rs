//! The driver of every method: over steps of equal length, or over steps that a tolerance chooses. A method only says
//! how it takes one; points of output, evaluations, limits and failures are the same for all.

use super::equations::Equations;
use super::potential::{Force, PotentialEquations, any_degree, boxed, low_degree, program};
use super::scene::SceneEquations;
use super::{Failure, MOST_STEPS, Output, Problem, Setting, States, Trajectory};

/// The share that is taken of the step which the error allows.
const SAFETY: f64 = 0.9;
/// Steps shorter than this share of the whole length are not taken.
const LEAST_STEP: f64 = 1e-13;

/// What is asked of a method.
pub(super) struct Task<'t> {
    pub(super) problem: &'t Problem,
    pub(super) output: &'t Output,
    pub(super) setting: Setting,
}

/// A method that is compiled for every kind of equations.
pub(super) trait Method {
    /// Does a task with its equations.
    fn integrate<E: Equations>(&self, equations: E, task: &Task<'_>) -> Result<Trajectory, Failure>;
}

impl Task<'_> {
    /// Does it by a method, which is compiled for the forces that are quickest to evaluate as a part of it, and once
    /// more for all others, out of line.
    pub(super) fn run(&self, method: &impl Method) -> Result<Trajectory, Failure> {
        let Problem { space, start, g00, .. } = self.problem;
        let q_t = start.p[0];
        match g00 {
            _ if space.c_squared.is_none() => method.integrate(SceneEquations::new(self.problem), self),
            Some(g) if g.len() <= 5 => self.in_potential(method, low_degree(g, q_t)),
            Some(g) => self.in_potential(method, boxed(any_degree(g, q_t))),
            None => self.in_potential(method, boxed(program(space.point(), q_t))),
        }
    }

    /// Room for its points.
    pub(super) fn states(&self) -> States {
        States::new(self.problem.start.q.len(), self.output.marks.len())
    }

    /// Compiled for the instructions of this machine.
    fn in_potential(&self, method: &impl Method, force: impl Force) -> Result<Trajectory, Failure> {
        let equations = PotentialEquations::new(self.problem, force);
        // Longer vectors than those of AVX2 would gain nothing on one particle.
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return simd.vectorize(
                #[inline(always)]
                || method.integrate(equations, self),
            );
        }
        method.integrate(equations, self)
    }
}

/// A method on its way.
pub(super) trait Walker<E: Equations> {
    /// The state at the end of the last step.
    fn state(&self) -> &E::Rows<f64>;

    /// The states at these fractions of the last step, ascending and below 1. A method without a dense output is never
    /// asked: its steps end on the points of output.
    #[inline(always)]
    fn inside(&mut self, _equations: &mut E, _fractions: &[f64]) -> Vec<E::Rows<f64>> {
        unreachable!("no dense output");
    }
}

/// A method that takes steps of equal length.
pub(super) trait EqualSteps<E: Equations>: Walker<E> + Sized {
    /// Takes so many steps, after which its state is asked for.
    fn advance(self, equations: &mut E, steps: usize) -> Result<Self, Failure>;
}

/// The rule by which a tolerance chooses the steps of a method.
pub(super) struct Control {
    /// The error is as the length of the step to the inverse of this.
    pub(super) exponent: f64,
    /// By how much one step may be shorter or longer than the one before.
    pub(super) change: [f64; 2],
    /// By how much a step is shorter than one that failed.
    pub(super) after_failure: f64,
    /// True if steps end on the points of output.
    pub(super) ends_on_output: bool,
}

/// A method that estimates the error of its steps.
pub(super) trait AdaptiveSteps<E: Equations>: Walker<E> + Sized {
    /// Learns the rates at the start.
    fn begin(&mut self, equations: &mut E, rates: &E::Rows<f64>);

    /// Tries a step of length `h`, and returns also its error in units of the tolerance; `None` if it failed. It takes
    /// itself: a method that works on rows of its own, not on those in a place that others know of, keeps them in
    /// registers.
    fn attempt(self, equations: &mut E, h: f64) -> (Self, Option<f64>);

    /// Goes to the end of the step that was tried last.
    fn accept(&mut self, equations: &mut E);
}

/// Reads the points of output at these fractions of the last step, in (0, 1].
#[inline(always)]
fn read<E: Equations>(
    points: &mut States,
    fractions: &mut Vec<f64>,
    walker: &mut impl Walker<E>,
    equations: &mut E,
) -> Result<(), Failure> {
    let inside = fractions.partition_point(|&fraction| fraction < 1.0);
    if inside > 0 {
        for state in walker.inside(equations, &fractions[..inside]) {
            equations.point(&state, points)?;
        }
    }
    if inside < fractions.len() {
        equations.point(walker.state(), points)?;
    }
    fractions.clear();
    Ok(())
}

/// The world-line in steps of equal length.
#[inline(always)]
pub(super) fn equal_steps<E: Equations>(
    mut equations: E,
    task: &Task<'_>,
    mut walker: impl EqualSteps<E>,
) -> Result<Trajectory, Failure> {
    let mut places = task.output.places(task.setting.count);
    let (mut states, mut fractions, mut done) = (task.states(), Vec::new(), 0);
    while let Some(&(next, _)) = places.peek() {
        walker = walker.advance(&mut equations, next + 1 - done)?;
        done = next + 1;
        fractions.extend(std::iter::from_fn(|| places.next_if(|place| place.0 == next)).map(|place| place.1));
        read(&mut states, &mut fractions, &mut walker, &mut equations)?;
    }
    Ok(Trajectory { states, evaluations: equations.evaluations(), steps: done })
}

/// The inverse of a length on which the motion changes about as much as a tolerance of 1 allows.
#[inline(always)]
fn pace<E: Equations>(equations: &E, start: &E::Rows<f64>, rates: &E::Rows<f64>) -> f64 {
    let (parts, start, rates) = (equations.parts(), start.as_ref(), rates.as_ref());
    let largest = |of: &[f64]| of.iter().fold(0.0, |largest: f64, v| largest.max(v.abs()));
    if parts.is_second_order {
        return largest(&rates[parts.driving()]).sqrt().max(largest(&rates[parts.unknowns()]));
    }
    parts.unknowns().fold(0.0, |pace: f64, k| pace.max(rates[k].abs() / (1.0 + start[k].abs())))
}

/// The world-line in steps that the tolerance chooses.
#[inline(always)]
pub(super) fn adaptive_steps<E: Equations>(
    mut equations: E,
    task: &Task<'_>,
    Control { exponent, change: [least, most], after_failure, ends_on_output }: Control,
    mut walker: impl AdaptiveSteps<E>,
) -> Result<Trajectory, Failure> {
    let (output, length, tolerance) = (task.output, task.problem.length, task.setting.tolerance);
    let (mut states, mut fractions) = (task.states(), Vec::new());
    let start = equations.start();
    let mut rates = start.clone();
    equations.rates(&start, &mut rates);
    walker.begin(&mut equations, &rates);
    let pace = pace(&equations, &start, &rates).max(1.0 / length);
    let mut h = (0.5 * tolerance.powf(exponent) / pace).min(length);
    let (mut accepted, mut attempts, mut gamma) = (0, 0, 0.0);
    let mut targets = output.gamma(length).peekable();
    let end = output.gamma(length).last().unwrap_or(0.0);
    while let Some(&next) = targets.peek() {
        let goal = if ends_on_output { next } else { end };
        let remaining = goal - gamma;
        // No short step is left over at the end.
        let parts = (remaining / h * (1.0 - 1e-12)).ceil().max(1.0);
        let step = if parts <= 2.0 { remaining / parts } else { h };
        attempts += 1;
        if attempts > MOST_STEPS || step < LEAST_STEP * length {
            return Err(Failure::TooManySteps);
        }
        let error;
        (walker, error) = walker.attempt(&mut equations, step);
        let Some(error) = error else {
            h = step * after_failure;
            continue;
        };
        let change = (SAFETY * error.powf(-exponent)).clamp(least, most);
        if error > 1.0 {
            h = step * change.min(1.0);
            continue;
        }
        // A step that was cut is no argument against longer ones.
        h = if step < h { (step * change).max(h) } else { step * change };
        walker.accept(&mut equations);
        accepted += 1;
        let here = if parts == 1.0 { goal } else { gamma + step };
        while let Some(target) = targets.next_if(|&target| target <= here) {
            fractions.push((target - gamma) / step);
        }
        gamma = here;
        read(&mut states, &mut fractions, &mut walker, &mut equations)?;
    }
    Ok(Trajectory { states, evaluations: equations.evaluations(), steps: accepted })
}
