//! What drives every method: over steps of equal length, or over steps that a tolerance chooses. A method only says how
//! it takes one; points of output, evaluations, limits and failures are the same for all.

use super::force::{Force, WithForce, dispatch};
use super::{Failure, MOST_STEPS, Marks, Output, Problem, State, Trajectory, check};

/// The share that is taken of the step which the error allows.
const SAFETY: f64 = 0.9;
/// Steps shorter than this share of the whole length are not taken.
const LEAST_STEP: f64 = 1e-13;

/// A force that counts how often it is evaluated.
pub(super) struct Counted<F> {
    force: F,
    pub(super) evaluations: usize,
}

impl<F: Force> Counted<F> {
    fn new(force: F) -> Self {
        Self { force, evaluations: 0 }
    }

    /// The force at a point, for a first guess, which does not count.
    #[inline(always)]
    pub(super) fn guess(&mut self, x: f64) -> (f64, f64) {
        self.force.at(x)
    }
}

impl<F: Force> Force for Counted<F> {
    #[inline(always)]
    fn at(&mut self, x: f64) -> (f64, f64) {
        self.evaluations += 1;
        self.force.at(x)
    }
}

/// A method on its way.
pub(super) trait Walker {
    /// The end of the last step.
    fn state(&self) -> State;

    /// Adds the states at these fractions of the last step, ascending and below 1. A method without a dense output is
    /// never asked: its steps end on the points of output.
    #[inline(always)]
    fn inside<F: Force>(&mut self, _force: &mut Counted<F>, _fractions: &[f64], _states: &mut Vec<State>) {
        unreachable!("no dense output");
    }
}

/// A method that takes steps of equal length.
pub(super) trait EqualSteps: Walker {
    /// Takes so many steps, after which its state is asked for.
    fn advance<F: Force>(&mut self, force: &mut Counted<F>, steps: usize) -> Result<(), Failure>;
}

/// How a tolerance chooses the steps of a method.
pub(super) struct Control {
    /// The error is as the length of the step to the inverse of this.
    pub(super) exponent: f64,
    /// By how much one step may be shorter or longer than the one before.
    pub(super) change: [f64; 2],
    /// By how much a step is shorter than one that failed.
    pub(super) after_failure: f64,
    /// Whether steps end on the points of output.
    pub(super) ends_on_output: bool,
}

/// A method that estimates the error of its steps.
pub(super) trait AdaptiveSteps: Walker {
    const CONTROL: Control;

    /// Learns u and a at the start.
    fn begin<F: Force>(&mut self, force: &mut Counted<F>, start: (f64, f64));

    /// Tries a step of length `h`, and returns its error in units of the tolerance; `None` if it failed.
    fn attempt<F: Force>(&mut self, force: &mut Counted<F>, h: f64) -> Option<f64>;

    /// Goes to the end of the step that was tried last.
    fn accept<F: Force>(&mut self, force: &mut Counted<F>);
}

/// The points of output so far.
struct Points<'a> {
    problem: &'a Problem,
    states: Vec<State>,
    /// Where the next ones are in the last step, in (0, 1].
    fractions: Vec<f64>,
}

impl<'a> Points<'a> {
    /// The start is known, if it is asked for.
    fn new(problem: &'a Problem, output: &Output) -> Self {
        let mut states = Vec::with_capacity(output.marks.len());
        states.extend(output.marks.iter().take_while(|&&mark| mark == 0).map(|_| problem.start()));
        Self { problem, states, fractions: Vec::new() }
    }

    /// Reads the next ones.
    #[inline(always)]
    fn read<F: Force>(&mut self, walker: &mut impl Walker, force: &mut Counted<F>) -> Result<(), Failure> {
        let Self { problem, states, fractions } = self;
        let known = states.len();
        let inside = fractions.partition_point(|&fraction| fraction < 1.0);
        if inside > 0 {
            walker.inside(force, &fractions[..inside], states);
        }
        states.resize(known + fractions.len(), walker.state());
        fractions.clear();
        states[known..].iter().try_for_each(|&state| check(&problem.metric, state))
    }
}

/// The world-line in so many steps of equal length.
pub(super) fn equal_steps(
    problem: &Problem,
    output: &Output,
    steps: usize,
    walker: impl EqualSteps,
) -> Result<Trajectory, Failure> {
    dispatch(&problem.metric, problem.q_t(), Equal { problem, output, steps, walker })
}

struct Equal<'a, W> {
    problem: &'a Problem,
    output: &'a Output,
    steps: usize,
    walker: W,
}

impl<W: EqualSteps> WithForce for Equal<'_, W> {
    type Output = Result<Trajectory, Failure>;

    #[inline(always)]
    fn with(self, force: impl Force) -> Self::Output {
        let Self { problem, output, steps, mut walker } = self;
        let mut force = Counted::new(force);
        let mut points = Points::new(problem, output);
        let mut marks = Marks::new(output, steps);
        marks.skip_start();
        let mut done = 0;
        while let Some(next) = marks.step() {
            walker.advance(&mut force, next + 1 - done)?;
            done = next + 1;
            points.fractions.extend(std::iter::from_fn(|| marks.within(next)));
            points.read(&mut walker, &mut force)?;
        }
        Ok(Trajectory { states: points.states, evaluations: force.evaluations, steps: done })
    }
}

/// The world-line in steps that `tolerance` chooses.
pub(super) fn adaptive_steps(
    problem: &Problem,
    output: &Output,
    tolerance: f64,
    walker: impl AdaptiveSteps,
) -> Result<Trajectory, Failure> {
    dispatch(&problem.metric, problem.q_t(), Adaptive { problem, output, tolerance, walker })
}

struct Adaptive<'a, W> {
    problem: &'a Problem,
    output: &'a Output,
    tolerance: f64,
    walker: W,
}

impl<W: AdaptiveSteps> WithForce for Adaptive<'_, W> {
    type Output = Result<Trajectory, Failure>;

    #[inline(always)]
    fn with(self, force: impl Force) -> Self::Output {
        let Self { problem, output, tolerance, mut walker } = self;
        let Control { exponent, change: [least, most], after_failure, ends_on_output } = W::CONTROL;
        let (start, length) = (problem.start(), problem.length);
        let mut force = Counted::new(force);
        let (u, a) = force.at(start.x);
        walker.begin(&mut force, (u, a));
        // A step on which the force changes x about as much as the tolerance allows.
        let pace = a.abs().sqrt().max(start.w.abs()).max(1.0 / length);
        let mut h = (0.5 * tolerance.powf(exponent) / pace).min(length);
        let (mut accepted, mut attempts, mut gamma) = (0, 0, 0.0);
        let mut points = Points::new(problem, output);
        let mut targets = output.gamma(length).skip(points.states.len()).peekable();
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
            let Some(error) = walker.attempt(&mut force, step) else {
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
            walker.accept(&mut force);
            accepted += 1;
            let here = if parts == 1.0 { goal } else { gamma + step };
            while let Some(target) = targets.next_if(|&target| target <= here) {
                points.fractions.push((target - gamma) / step);
            }
            gamma = here;
            points.read(&mut walker, &mut force)?;
        }
        Ok(Trajectory { states: points.states, evaluations: force.evaluations, steps: accepted })
    }
}
