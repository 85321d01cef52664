//! Windows as long, and a rule of as high an order, as the requested accuracy needs: weak spectral elements, marched by
//! [`crate::engine::lobatto::Adaptive`], every window certified on its action.

use std::ops::ControlFlow;

use crate::action::Form;
use crate::engine::lobatto::{Adaptive, Goal, MarchFailure, State, WindowView};
use crate::geometry::metric::Metric;
use crate::number::Real;
use crate::sbp::SbpName;
use crate::solve::failure::{At, NoSolution};
use crate::solve::run::{Observer, Run};
use crate::solve::setup::{Limit, Settings, Setup, System};
use crate::solve::solution::Solution;
use crate::solve::spectral::CertifiedRun;
use crate::solve::status::{MOST_NODES, Status};

/// A forecast from the beginning of a run may be too high by this factor.
const FORECAST: f64 = 3.0;

/// The number of nodes that a run will have, of which this many are `done`, if memory cannot hold them.
///
/// Windows become longer after the first few: a forecast is believed when they are a thousandth of what is allowed.
fn beyond_memory(nodes: usize, done: f64) -> Option<f64> {
    let (nodes, needed) = (nodes as f64, nodes as f64 / done);
    let foreseen = nodes > 1e-3 * MOST_NODES && needed > FORECAST * MOST_NODES;
    (nodes > MOST_NODES || foreseen).then_some(needed)
}

/// The settings of a run whose operator and windows are chosen here. The first window says which rule it is on.
fn chosen(settings: &Settings) -> Settings {
    let system = System::PhysicalLimit;
    Settings { system, form: Form::Weak, sbp: SbpName::Gll(2), digits: f64::MOST_DIGITS, ..*settings }
}

/// The run of a setup to an accuracy.
pub(crate) fn solve(
    setup: &Setup<f64, Metric>,
    accuracy: f64,
    observer: Option<Observer<'_, f64, Metric>>,
) -> Result<Solution, NoSolution> {
    let (goal, length) = match setup.limit {
        Limit::Length(length) => (Goal::Gamma(length), length),
        Limit::Value { coordinate, value } => (Goal::Time(value - setup.origin_of(coordinate)), 0.0),
    };
    let (metric, initial, gamma_i) = (setup.metric(), setup.initial(), setup.gamma_i);
    let start = State::from(initial);
    let is_kept = observer.is_none();
    let mut run = Run::new(setup, &chosen(&setup.settings), observer);
    (run.line.accuracy, run.line.length) = (Some(accuracy), length);
    let mut certified = CertifiedRun::new(run);
    let mut too_many = None;
    let march = Adaptive::new(metric, initial.invariants(metric).q_t).certified();
    let adapted = march.run(start, goal, accuracy, &mut |view: &WindowView<'_>| {
        let run = &mut certified.run;
        if view.index == 0 {
            run.clear();
        }
        let points = view.rule.points();
        let done = match goal {
            Goal::Gamma(length) => (view.gamma + view.length).hi / length,
            Goal::Time(duration) => (view.end.t - start.t).hi / duration,
        };
        if is_kept && let Some(needed) = beyond_memory((view.index + 1) * points, done) {
            too_many = Some((needed, view.gamma.hi, view.start.x.hi));
            return ControlFlow::Break(());
        }
        run.line.sbp_name = SbpName::Gll(points as u8);
        let operator = run.line.operators.element(points, view.length.hi);
        certified.append(view, (view.gamma + view.length).hi, operator)
    });
    let last = certified.run.line.windows.len().checked_sub(1);
    let last = last.map_or(initial.x, |last| certified.run.line.joint(last).q[1]);
    let mut solution = certified.finish()?;
    if let Some((needed, gamma, x)) = too_many {
        let at = At::x(gamma_i + gamma, x, metric.g00(x));
        return Err(NoSolution { needed, ..NoSolution::adaptive(Status::TooManyNodes, at) });
    }
    match adapted {
        Ok(adapted) => {
            if let Limit::Value { coordinate, value } = setup.limit {
                // t_i + (t_f − t_i), rounded twice, may be the neighbouring number.
                solution.ended_at = Some((coordinate, value));
            }
            solution.length = adapted.gamma.hi;
            solution.iterations.count = adapted.statistics.evaluations;
            solution.error_estimate = Some(adapted.error_estimate);
            solution.windows_unproved = Some(adapted.statistics.unproved);
            Ok(solution)
        }
        Err(failure) => Err(failed(setup, failure, last)),
    }
}

/// What the failure of a march means for the case. Where it does not say x, that is `last`.
fn failed(setup: &Setup<f64, Metric>, failure: MarchFailure, last: f64) -> NoSolution {
    let (metric, gamma_i) = (setup.metric(), setup.gamma_i);
    let at = |status, gamma: f64, x: f64| NoSolution::adaptive(status, At::x(gamma_i + gamma, x, metric.g00(x)));
    match failure {
        MarchFailure::OutsideDomain { gamma, x, g00, .. } => {
            NoSolution::adaptive(Status::OutsideDomain, At::x(gamma_i + gamma, x, g00))
        }
        MarchFailure::NotConverged { gamma, x, .. } => at(Status::Stalled, gamma, x),
        MarchFailure::AccuracyNotReached { gamma, estimate } => {
            NoSolution { residual: estimate, ..at(Status::AccuracyNotReached, gamma, last) }
        }
        MarchFailure::TimeNotReached { gamma, .. } => at(Status::EndTimeNotReached, gamma, last),
        MarchFailure::EvaluationLimit { gamma, x, evaluations, needed } => {
            NoSolution { needed, ..at(Status::EvaluationLimit, gamma, x).after(evaluations) }
        }
    }
}
