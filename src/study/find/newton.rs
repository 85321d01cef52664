//! Damped Newton steps, which are Gauss–Newton steps where there are more equations than unknowns.
//!
//! A step is taken if the one that the same derivatives would make next is shorter, which neither the units of the
//! equations nor their scales change (P. Deuflhard, Newton Methods for Nonlinear Problems, 2004, sections 2.1.2 and
//! 4.3). It is halved where there is no run, and it never takes away more than half of the length of the run: a run of
//! no length returns, too.

use super::jacobian::Jacobian;
use super::least_squares::PseudoInverse;
use super::problem::{Evaluation, NoValue, Problem};
use super::states::Residuals;
use super::{Iterate, NotFound};
use crate::case::{Case, Goal};
use crate::number::norm::larger;
use crate::solve::Limit;
use crate::study::run::Run;
use crate::trajectory::Sampler;

/// So many steps are enough for any search that converges.
const MOST_STEPS: usize = 100;
/// A search ends where a step this much shorter is not accepted.
const LEAST_DAMPING: f64 = 1e-6;
/// A step is small beside the error of what was found below this part of it.
const SMALL: f64 = 0.1;
/// What moves by so small a part of what the first run did is at rest.
const AT_REST: f64 = 1e-6;
/// Residuals of up to so many times their error are none.
const ROOM: f64 = 2.0;

/// The last iterate of a search that converged.
#[derive(Debug)]
pub(super) struct Converged {
    pub(super) here: Evaluation,
    pub(super) jacobian: Jacobian,
    pub(super) inverse: PseudoInverse,
    /// By how much each unknown may be off.
    pub(super) errors: Vec<f64>,
    /// True if the residuals vanish up to their errors, and are not only least in the sum of their squares.
    pub(super) is_met: bool,
}

/// Derivatives at a point, and the step from there.
struct Linear {
    jacobian: Jacobian,
    inverse: PseudoInverse,
    step: Vec<f64>,
    length: f64,
    errors: Vec<f64>,
}

/// Searches from the values of the case. `tell` hears of every iterate.
///
/// # Errors
/// [`NotFound`], if the search does not converge.
pub(super) fn search(problem: &Problem, tell: &mut dyn FnMut(Iterate)) -> Result<Converged, NotFound> {
    let start: Vec<f64> = problem.find.unknowns.iter().map(|unknown| unknown.value).collect();
    let at_start = |none: NoValue| NotFound::at_start(&none.message, none.is_outside);
    let mut here = problem.evaluate(&start, true).map_err(at_start)?;
    let first_way = way(&here.run);
    let at_once = |none: NoValue| NotFound::on_the_way(&none.message, none.advice);
    let mut linear = Linear::new(problem, &here).map_err(at_once)?;
    let (mut damping, mut before): (f64, Option<f64>) = (1.0, None);
    for iteration in 0..MOST_STEPS {
        tell(Iterate {
            iteration,
            values: here.values.clone(),
            residuals: here.residuals.clone(),
            step: linear.length,
            damping: before.map(|_| damping),
        });
        let is_small =
            |share: f64| linear.step.iter().zip(&linear.errors).all(|(step, error)| step.abs() <= share * error);
        // Below the error of the run steps need not get shorter.
        let stays = before.is_some_and(|before| linear.length > 0.5 * before);
        // Beside a family of solutions little is known along it, and much of what is left.
        let is_enough = problem.is_least_squares() || is_met(&here, &linear.jacobian);
        if is_small(SMALL) && is_enough || is_small(1.0) && stays {
            if problem.find.goal == Goal::Periodic && way(&here.run) < AT_REST * first_way {
                return Err(NotFound::on_the_way(
                    "the search went to a point of rest, which returns at any time",
                    "begin nearer to an orbit, or fix a coordinate of it: leave that out of find.unknowns",
                ));
            }
            return ended(problem, here, linear);
        }
        before = Some(linear.length);
        (here, linear, damping) = stepped(problem, &here, &linear, damping)?;
    }
    Err(NotFound::on_the_way(
        &format!("the search has not converged in {MOST_STEPS} steps"),
        "begin nearer to what is to be found",
    ))
}

/// How far a run goes from its start, as far as a few places of it tell.
fn way(run: &Run) -> f64 {
    let line = &run.line;
    let (mut sampler, start, names) = (Sampler::new(line), &line.place.start.q, line.geometry().names());
    let samples = (1..8).filter_map(|k| sampler.at_gamma(line.gamma_at(line.length * f64::from(k) / 8.0)).ok());
    let places = line.geometry().active().iter().filter(|&&a| names[a] != "t");
    samples.fold(0.0, |most, sample| places.clone().fold(most, |most, &a| larger(most, (sample.q[a] - start[a]).abs())))
}

impl Linear {
    fn new(problem: &Problem, here: &Evaluation) -> Result<Self, NoValue> {
        let jacobian = Jacobian::new(problem, here)?;
        let matrix = &jacobian.matrix;
        // Of the least squares units of the unknowns are no matter: each changes them as much as the others.
        let scale = |(j, scale): (usize, &f64)| match matrix.column(j).norm() {
            norm if problem.is_least_squares() && norm > 0.0 => 1.0 / norm,
            _ => *scale,
        };
        let scales: Vec<f64> = problem.scales.iter().enumerate().map(scale).collect();
        let inverse = PseudoInverse::new(matrix, &scales, jacobian.share);
        let step: Vec<f64> = inverse.times(&here.residuals).iter().map(|step| -step).collect();
        let mut errors = inverse.at_most(&here.errors);
        let size = here.residuals.iter().map(|residual| residual * residual).sum::<f64>().sqrt();
        for (j, error) in errors.iter_mut().enumerate() {
            *error += f64::EPSILON * here.values[j].abs();
            if problem.is_least_squares() {
                // Where residuals stay, errors of derivatives move the place at which their sum of squares is least.
                *error += jacobian.share * size * inverse.matrix.row(j).norm();
            }
        }
        Ok(Self { length: length(problem, &step), jacobian, inverse, step, errors })
    }
}

/// The length of a step, every unknown divided by its scale.
fn length(problem: &Problem, step: &[f64]) -> f64 {
    step.iter().zip(&problem.scales).map(|(step, scale)| (step / scale).powi(2)).sum::<f64>().sqrt()
}

/// The next point with its derivatives, and the damping of the step to it; that of the step before was `before`.
fn stepped(
    problem: &Problem,
    here: &Evaluation,
    linear: &Linear,
    before: f64,
) -> Result<(Evaluation, Linear, f64), NotFound> {
    let mut damping = (4.0 * before).min(1.0).min(longest(problem, here, &linear.step));
    let mut reason = None;
    while damping >= LEAST_DAMPING {
        let values: Vec<f64> =
            here.values.iter().zip(&linear.step).map(|(value, step)| value + damping * step).collect();
        let is_nearer = |there: &Evaluation| {
            let next = linear.inverse.times(&there.residuals);
            // Where the errors of runs are all that is left, steps do not get shorter.
            let is_noise = next.iter().zip(&linear.errors).all(|(next, error)| next.abs() <= *error);
            is_noise || length(problem, &next) <= (1.0 - 0.25 * damping) * linear.length
        };
        match problem.evaluate(&values, true) {
            Ok(there) if is_nearer(&there) => match Linear::new(problem, &there) {
                Ok(next) => return Ok((there, next, damping)),
                Err(none) => reason = Some(none.message),
            },
            Ok(_) => {}
            Err(none) => reason = Some(none.message),
        }
        damping *= 0.5;
    }
    let reason = reason.map_or(String::new(), |reason| format!("; on the way there: {reason}"));
    Err(NotFound::on_the_way(
        &format!("no step, however short, leads nearer to what is to be met{reason}"),
        "begin nearer to what is to be found; there may be nothing to find",
    ))
}

/// The longest damping that leaves half of the length of the run.
fn longest(problem: &Problem, here: &Evaluation, step: &[f64]) -> f64 {
    let length_of = |case: &Case| match case.limit::<f64>() {
        Limit::Length(length) => {
            if case.is_backward() {
                -length
            } else {
                length
            }
        }
        Limit::Value { coordinate, value } => value - case.value::<f64>(&case.initial.q[coordinate]),
    };
    let now = length_of(&here.case);
    let mut damping = 1.0;
    while damping >= LEAST_DAMPING {
        let values: Vec<String> =
            here.values.iter().zip(step).map(|(value, step)| format!("{:?}", value + damping * step)).collect();
        // Where there is no such case, the step is shortened with the runs.
        if problem.case(&values, false).is_ok_and(|case| length_of(&case) / now >= 0.5) {
            break;
        }
        damping *= 0.5;
    }
    damping
}

/// True if the residuals vanish up to their errors.
fn is_met(here: &Evaluation, jacobian: &Jacobian) -> bool {
    // The unknowns are doubles: no others are nearer than what their last digits make of it.
    let of_digits = |i: usize| {
        let sizes = here.values.iter().enumerate().map(|(j, value)| (jacobian.matrix[(i, j)] * value).abs());
        f64::EPSILON * sizes.sum::<f64>()
    };
    let room = |i: usize| ROOM * (here.errors[i] + of_digits(i));
    here.residuals.iter().enumerate().all(|(i, residual)| residual.abs() <= room(i))
}

/// The end of a search whose steps have become small.
fn ended(problem: &Problem, here: Evaluation, linear: Linear) -> Result<Converged, NotFound> {
    let Linear { jacobian, inverse, step, errors, .. } = linear;
    let is_met = is_met(&here, &jacobian);
    let unknowns = here.values.len();
    if problem.is_least_squares() && inverse.rank < unknowns {
        return Err(NotFound::on_the_way(
            &format!("{} of {unknowns} directions of the unknowns are determined", inverse.rank),
            "take unknowns out, or give more to be met",
        ));
    }
    if !is_met && !problem.is_least_squares() {
        let names = Residuals::new(&here.case, &problem.find.goal).map_or_else(Vec::new, |states| states.names());
        let times = |k: &usize| here.residuals[*k].abs() / here.errors[*k];
        let worst = (0..here.residuals.len()).max_by(|a, b| times(a).total_cmp(&times(b)));
        let left = worst.map_or(String::new(), |k| format!("{} = {:.1e} is left", names[k], here.residuals[k]));
        return Err(NotFound::on_the_way(
            &format!("the search comes no nearer than this: {left}, and should be 0"),
            "begin nearer to what is to be found, or take more unknowns; there may be nothing to find",
        ));
    }
    let errors = errors.iter().zip(&step).map(|(error, step)| error + step.abs()).collect();
    Ok(Converged { here, jacobian, inverse, errors, is_met })
}
