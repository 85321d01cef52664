//! This program's own engine as a method among others: steps of Gauss' method, windows of one length, and windows as
//! long as an accuracy needs.

use std::ops::ControlFlow;

use super::{Failure, Output, Peer, Prepared, Problem, Setting, States, Trajectory};
use crate::engine::{self, Accuracy, Engine, POINTS};
use crate::sbp::collocation::Collocation;
use crate::sbp::legendre::Family;

impl From<engine::Failure> for Failure {
    fn from(failure: engine::Failure) -> Self {
        match failure {
            engine::Failure::OutsideDomain(_) => Self::OutsideDomain,
            engine::Failure::Accuracy | engine::Failure::BeginAgain => Self::AccuracyNotReached,
            _ => Self::NotConverged,
        }
    }
}

/// A run to be made many times, of a method that is one of the engine.
pub(super) fn prepared(method: Peer, problem: &Problem, output: Output, setting: Setting) -> Prepared<'_> {
    let Problem { space: geometry, start, length, .. } = problem;
    let Setting { count, tolerance } = setting;
    let accurate = |accuracy| Engine::accurate(geometry, start, *length, accuracy);
    let engine = match method {
        Peer::Gauss(stages) => Engine::gauss(geometry, start, *length, count, stages, tolerance),
        Peer::Equal(points) => {
            let operators = Collocation::shared(Family::Lobatto, points);
            Engine::march(geometry, start, (*length, count), operators, tolerance)
        }
        Peer::Accuracy => accurate(Accuracy::Promised(tolerance)),
        _ => accurate(Accuracy::Local(tolerance)),
    };
    let Ok(mut engine) = engine else { return Box::new(|| Err(Failure::OutsideDomain)) };
    Box::new(move || run_over(method, problem, &mut engine, &output, count))
}

fn run_over(
    method: Peer,
    Problem { space: geometry, start, length, .. }: &Problem,
    engine: &mut Engine<'_>,
    output: &Output,
    count: usize,
) -> Result<Trajectory, Failure> {
    engine.rewind();
    let (points, nodes_per_step, is_equal) = match method {
        Peer::Gauss(stages) => (stages, 1, true),
        Peer::Equal(points) => (points, points, true),
        _ => (POINTS, POINTS, false),
    };
    let mut marks = output.gamma(*length).peekable();
    // Where windows have one length, the places of the points are known without rounding.
    let mut places = is_equal.then(|| output.places(count));
    let (mut q, mut p) = (start.q.clone(), start.p.clone());
    let mut momenta: Vec<f64> = geometry.active().iter().map(|&a| p[a]).collect();
    let mut states = States::new(q.len(), output.marks.len());
    let (mut windows, mut outcome) = (0, Ok(()));
    let run = engine.run(|mut window| {
        if window.index == 0 {
            states.clear();
            marks = output.gamma(*length).peekable();
        }
        if method == Peer::Accuracy && !window.gradient_norm().is_some_and(f64::is_finite) {
            outcome = Err(Failure::Diverged);
            return ControlFlow::Break(());
        }
        windows = window.index + 1;
        let (from, end, mut dense) = (window.gamma, window.gamma + window.length, None);
        while let Some(fraction) = match &mut places {
            Some(places) => places.next_if(|place| place.0 == window.index).map(|place| place.1),
            None => {
                let mark = marks.next_if(|&mark| mark <= end || end >= *length);
                mark.map(|mark| ((mark - from) / window.length).min(1.0))
            }
        } {
            dense.get_or_insert_with(|| window.dense()).at(fraction, &mut q, &mut momenta);
            if q.iter().chain(&momenta).any(|value| !value.is_finite()) {
                outcome = Err(Failure::Diverged);
                return ControlFlow::Break(());
            }
            geometry.active().iter().zip(&momenta).for_each(|(&a, momentum)| p[a] = *momentum);
            states.push(&q, &p);
        }
        // A certificate is one of the whole run.
        if is_equal && states.len() == output.marks.len() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    outcome?;
    run?;
    Ok(Trajectory { states, evaluations: engine.sweeps() * points, steps: windows * nodes_per_step })
}
