//! The driver of every method: over steps of equal length, or over steps that a tolerance chooses. A method only says
//! how it takes one; points of output, evaluations, limits and failures are the same for all.

use super::equations::{Counted, Equations, Work};
use super::{Failure, MOST_STEPS, Marks, Output, Problem, States, Trajectory};

/// The share that is taken of the step which the error allows.
const SAFETY: f64 = 0.9;
/// Steps shorter than this share of the whole length are not taken.
const LEAST_STEP: f64 = 1e-13;

/// A method on its way.
pub(super) trait Walker<E: Equations> {
    /// Copies the state at the end of the last step.
    fn state(&self, state: &mut E::Rows<f64>);

    /// Adds the states at these fractions of the last step, ascending and below 1. A method without a dense output is
    /// never asked: its steps end on the points of output.
    #[inline(always)]
    fn inside(&mut self, _equations: &mut Counted<E>, _fractions: &[f64], _states: &mut Vec<E::Rows<f64>>) {
        unreachable!("no dense output");
    }
}

/// A method that takes steps of equal length.
pub(super) trait EqualSteps<E: Equations>: Walker<E> + Sized {
    /// Takes so many steps, after which its state is asked for.
    fn advance(self, equations: &mut Counted<E>, steps: usize) -> Result<Self, Failure>;
}

/// A method of steps of equal length that has not begun.
pub(super) trait BeginEqual {
    /// It on its way.
    type Walk<'m, E: Equations>: EqualSteps<E>
    where
        Self: 'm;

    /// Begins at the start of the equations.
    fn begin<E: Equations>(&self, equations: &E) -> Self::Walk<'_, E>;
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
pub(super) trait AdaptiveSteps<E: Equations>: Walker<E> {
    /// Learns the rates at the start.
    fn begin(&mut self, equations: &mut Counted<E>, rates: &E::Rows<f64>);

    /// Tries a step of length `h`, and returns its error in units of the tolerance; `None` if it failed.
    fn attempt(&mut self, equations: &mut Counted<E>, h: f64) -> Option<f64>;

    /// Goes to the end of the step that was tried last.
    fn accept(&mut self, equations: &mut Counted<E>);
}

/// A method that estimates the error of its steps and has not begun.
pub(super) trait BeginAdaptive {
    /// The rule by which it chooses them.
    const CONTROL: Control;

    /// It on its way.
    type Walk<E: Equations>: AdaptiveSteps<E>;

    /// Begins at the start of the equations.
    fn begin<E: Equations>(&self, equations: &E, tolerance: f64) -> Self::Walk<E>;
}

/// The points of output so far.
struct Points<E: Equations> {
    points: States,
    /// Where the next ones are in the last step, in (0, 1].
    fractions: Vec<f64>,
    /// The states there.
    states: Vec<E::Rows<f64>>,
    /// The end of the last step.
    end: E::Rows<f64>,
}

impl<E: Equations> Points<E> {
    /// The start is known, if it is asked for.
    fn new(equations: &mut E, dimension: usize, output: &Output) -> Result<Self, Failure> {
        let start = equations.start();
        let mut points = States::new(dimension, output.marks.len());
        for _ in output.marks.iter().take_while(|&&mark| mark == 0) {
            equations.point(&start, &mut points)?;
        }
        Ok(Self { points, fractions: Vec::new(), states: Vec::new(), end: start })
    }

    /// Reads the next ones.
    #[inline(always)]
    fn read(&mut self, walker: &mut impl Walker<E>, equations: &mut Counted<E>) -> Result<(), Failure> {
        let Self { points, fractions, states, end } = self;
        let inside = fractions.partition_point(|&fraction| fraction < 1.0);
        if inside > 0 {
            states.clear();
            walker.inside(equations, &fractions[..inside], states);
            for state in &*states {
                equations.equations.point(state, points)?;
            }
        }
        if inside < fractions.len() {
            walker.state(end);
            equations.equations.point(end, points)?;
            points.repeat_last(fractions.len() - inside - 1);
        }
        fractions.clear();
        Ok(())
    }
}

/// The world-line in so many steps of equal length.
pub(super) fn equal_steps(
    problem: &Problem,
    output: &Output,
    steps: usize,
    method: &impl BeginEqual,
) -> Result<Trajectory, Failure> {
    let dimension = problem.start.q.len();
    problem.with_equations(Equal { dimension, output, steps, method })
}

struct Equal<'a, M> {
    dimension: usize,
    output: &'a Output,
    steps: usize,
    method: &'a M,
}

impl<M: BeginEqual> Work for Equal<'_, M> {
    type Output = Result<Trajectory, Failure>;

    #[inline(always)]
    fn with<E: Equations>(self, mut equations: E) -> Self::Output {
        let Self { dimension, output, steps, method } = self;
        let mut marks = Marks::new(output, steps);
        let mut walker = method.begin(&equations);
        let mut points = Points::new(&mut equations, dimension, output)?;
        let mut equations = Counted::new(equations);
        marks.skip_start();
        let mut done = 0;
        while let Some(next) = marks.step() {
            walker = walker.advance(&mut equations, next + 1 - done)?;
            done = next + 1;
            points.fractions.extend(std::iter::from_fn(|| marks.within(next)));
            points.read(&mut walker, &mut equations)?;
        }
        Ok(Trajectory { states: points.points, evaluations: equations.evaluations, steps: done })
    }
}

/// The world-line in steps that `tolerance` chooses.
pub(super) fn adaptive_steps(
    problem: &Problem,
    output: &Output,
    tolerance: f64,
    method: &impl BeginAdaptive,
) -> Result<Trajectory, Failure> {
    let dimension = problem.start.q.len();
    problem.with_equations(Adaptive { length: problem.length, dimension, output, tolerance, method })
}

struct Adaptive<'a, M> {
    length: f64,
    dimension: usize,
    output: &'a Output,
    tolerance: f64,
    method: &'a M,
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

impl<M: BeginAdaptive> Work for Adaptive<'_, M> {
    type Output = Result<Trajectory, Failure>;

    #[inline(always)]
    fn with<E: Equations>(self, mut equations: E) -> Self::Output {
        let Self { length, dimension, output, tolerance, method } = self;
        let Control { exponent, change: [least, most], after_failure, ends_on_output } = M::CONTROL;
        let mut walker = method.begin(&equations, tolerance);
        let mut points = Points::new(&mut equations, dimension, output)?;
        let mut equations = Counted::new(equations);
        let start = equations.equations.start();
        let mut rates = start.clone();
        equations.rates(&start, &mut rates);
        walker.begin(&mut equations, &rates);
        let pace = pace(&equations.equations, &start, &rates).max(1.0 / length);
        let mut h = (0.5 * tolerance.powf(exponent) / pace).min(length);
        let (mut accepted, mut attempts, mut gamma) = (0, 0, 0.0);
        let mut targets = output.gamma(length).skip(points.points.len()).peekable();
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
            let Some(error) = walker.attempt(&mut equations, step) else {
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
                points.fractions.push((target - gamma) / step);
            }
            gamma = here;
            points.read(&mut walker, &mut equations)?;
        }
        Ok(Trajectory { states: points.points, evaluations: equations.evaluations, steps: accepted })
    }
}
