//! Windows as long as the requested accuracy needs, by [`crate::engine::lobatto::flow`].

use std::ops::ControlFlow;

use crate::action::Form;
use crate::engine::lobatto::flow::{Flow, FlowFailure, FlowView, PhasePoint, Stop};
use crate::geometry::{Direction, Geometry, Observable};
use crate::number::Real;
use crate::sbp::SbpName;
use crate::solve::failure::{At, NoSolution};
use crate::solve::piece::Piece;
use crate::solve::places::domain_of;
use crate::solve::run::{Observer, Run};
use crate::solve::setup::{Limit, Settings, Setup, System, Until};
use crate::solve::status::{InitialGuess, MOST_NODES, Status};
use crate::solve::world_line::WorldLine;

/// Solves a scene so that every coordinate is as accurate as asked for at all nodes. It is a solve in `f64`.
pub(crate) fn solve<S: Real>(
    setup: &Setup<S>,
    accuracy: f64,
    observer: Option<Observer<'_, S, Geometry<S>>>,
) -> Result<WorldLine<S>, NoSolution> {
    let place = &setup.rough;
    let (geometry, start) = (&*place.geometry, &place.start);
    let gamma_i = setup.gamma_i.to_f64();
    let norm = geometry.norm(&start.q, &start.q_dot);
    let (length, target) = match setup.limit {
        Limit::Length(length) => (length.to_f64(), None),
        Limit::Value { coordinate, value } => (f64::INFINITY, Some((coordinate, value.to_f64()))),
    };
    let formula = |until: &Until<S>| AtFormula { formula: until.rough.clone(), direction: until.direction, norm };
    let mut formulas: Vec<AtFormula> = setup.until.iter().map(formula).collect();
    let mut stops: Vec<&mut dyn Stop> = formulas.iter_mut().map(|stop| stop as &mut dyn Stop).collect();
    // A run to a value of a coordinate has no other end.
    let most = if target.is_some() { idle_limit(setup) } else { f64::INFINITY };
    let settings = Settings { system: System::PhysicalLimit, ..setup.settings };
    let mut run = Run::new(setup, &settings, observer);
    let mut ended = None;
    let flow = Flow::new(geometry).certified();
    let flow = target.map_or(flow, |(coordinate, value)| flow.to_value(coordinate, value));
    let followed = flow.run(start, length, &mut stops, accuracy, &mut |view| {
        if view.index == 0 {
            run.clear();
        }
        let end = view.gamma + view.length;
        let nodes = (view.index + 1) as f64 * view.points as f64;
        let at = || At::scene(gamma_i + end, Vec::new());
        if nodes > MOST_NODES {
            let needed = if length.is_finite() { nodes * (length / end).max(1.0) } else { nodes };
            ended = Some(NoSolution { needed, ..NoSolution::adaptive(Status::TooManyNodes, at()) });
        } else if end > most {
            ended = Some(NoSolution::adaptive(Status::EndTimeNotReached, at()));
        } else {
            ended = append(&mut run, view, geometry).err();
        }
        if ended.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    if let Some(failure) = ended {
        return Err(failure);
    }
    let followed = followed.map_err(|failure| no_world_line(geometry, gamma_i, failure))?;
    let mut line = run.line;
    line.length = S::from(followed.gamma);
    let last = line.windows.len() - 1;
    line.windows[last].gamma[1] = line.length;
    if let (Some((a, value)), Some(0)) = (target, followed.stopped_by) {
        // Rounding of the length of the last window is one of this coordinate.
        line.ended_at = Some((a, S::from(value)));
    }
    // The value of a coordinate stands before the formulas.
    line.ended_by = followed.stopped_by.and_then(|stop| stop.checked_sub(usize::from(target.is_some())));
    line.accuracy = Some(accuracy);
    line.error_estimate = Some(followed.error_estimate);
    line.windows_unproved = Some(followed.statistics.unproved);
    line.iterations.count = followed.statistics.evaluations;
    Ok(line)
}

/// A formula that changes its sign.
struct AtFormula {
    formula: Observable,
    direction: Direction,
    /// K at the start.
    norm: f64,
}

impl Stop for AtFormula {
    fn value(&mut self, point: PhasePoint<'_>) -> f64 {
        self.formula.at(point.q, point.q_dot, point.p, self.norm)
    }

    fn counts(&self, to_positive: bool) -> bool {
        self.direction.counts(to_positive)
    }
}

/// γ − γ_i beyond which a value that is not reached counts as one that never is.
fn idle_limit<S: Real>(setup: &Setup<S>) -> f64 {
    const TIMES: f64 = 1e9;
    let Limit::Value { coordinate, value } = setup.limit else { return f64::INFINITY };
    let start = &setup.rough.start;
    TIMES * ((value.to_f64() - start.q[coordinate]) / start.q_dot[coordinate]).abs()
}

fn append<S: Real>(
    run: &mut Run<'_, S, Geometry<S>>,
    view: &FlowView<'_>,
    geometry: &Geometry,
) -> Result<(), NoSolution> {
    let (n, active) = (geometry.dimension(), geometry.active());
    let row = |values: &[f64], last: f64| -> Vec<S> {
        let inner = values[..values.len() - 1].iter().chain(std::iter::once(&last));
        inner.map(|&value| S::from(value)).collect()
    };
    let q = (0..n).map(|a| {
        let [start, end] = [view.start.q[a], view.end.q[a]];
        let last = if active.contains(&a) { end.hi } else { (end - start).hi };
        row(&view.q(a), last)
    });
    let mut momenta = run.line.place.start.p.clone();
    for (place, &a) in active.iter().enumerate() {
        momenta[a] = S::from(view.end.p[place].hi);
    }
    let piece = Piece {
        q: q.collect(),
        p: (0..active.len()).map(|place| row(view.p(place), view.end.p[place].hi)).collect(),
        end: momenta,
        backward: Vec::new(),
        multipliers: Vec::new(),
        gradient_norm: S::from(view.gradient_norm.unwrap_or(f64::INFINITY)),
        initial_guess: InitialGuess::Extrapolation,
        history: Vec::new(),
    };
    run.line.sbp_name = SbpName::Gll(view.points as u8);
    run.line.form = Form::Weak;
    let operator = run.line.operators.element(view.points, S::from(view.length));
    run.append(piece, operator, S::from(view.gamma + view.length))
}

fn no_world_line(geometry: &Geometry, gamma_i: f64, failure: FlowFailure) -> NoSolution {
    let at =
        |gamma: f64, q: &[f64]| At::scene(gamma_i + gamma, named(geometry, geometry.active().iter().map(|&a| q[a])));
    match failure {
        FlowFailure::OutsideDomain { gamma, q, outside } => {
            let at = At { domain: domain_of(geometry, &outside), ..at(gamma, &q) };
            NoSolution::adaptive(Status::OutsideDomain, at)
        }
        FlowFailure::NotConverged { gamma, q } => NoSolution::adaptive(Status::Stalled, at(gamma, &q)),
        FlowFailure::AccuracyNotReached { gamma, q, estimate } => {
            let failure = NoSolution::adaptive(Status::AccuracyNotReached, at(gamma, &q));
            NoSolution { residual: estimate, ..failure }
        }
        FlowFailure::EvaluationLimit { gamma, q, evaluations, needed } => {
            let failure = NoSolution::adaptive(Status::EvaluationLimit, at(gamma, &q)).after(evaluations);
            NoSolution { needed, ..failure }
        }
    }
}

/// The active coordinates with their names.
fn named(geometry: &Geometry, values: impl IntoIterator<Item = f64>) -> Vec<(String, f64)> {
    geometry.active().iter().map(|&a| geometry.names()[a].clone()).zip(values).collect()
}
