//! The schemes of one coordinate that are no call of `solve` on a grid.

use std::ops::ControlFlow;

use super::course::{Course, Marched};
use super::run::{Raw, Run};
use crate::engine::lobatto::{Inside, March, MarchFailure, State as MarchState, Twofold, WeakRule};
use crate::geometry::metric::Metric;
use crate::methods::{Marks, Output, Problem, Setting, State, Trajectory};
use crate::solve::{Limit, Solution, solve_window_by_window};
use crate::trajectory::{Coordinate, SampleStream};

impl Marched for Metric {
    fn march(course: &Course<Self>, nodes: usize, setting: Setting, output: Output) -> Run<'_, Self> {
        let (rule, Setting { count, tolerance }) = (WeakRule::shared(nodes), setting);
        Box::new(move || march(&course.problem, rule, &output, count, tolerance))
    }

    /// Its states are samples, of which t and x keep the accuracy.
    fn accuracy(course: &Course<Self>, accuracy: f64, output: Output) -> Run<'_, Self> {
        let (mut setup, length) = (course.setup.clone(), course.problem.length);
        (setup.origin, setup.limit) = (setup.origin.map(|(t, _)| (t, 0.0)), Limit::Length(length));
        setup.settings.accuracy = Some(accuracy);
        Box::new(move || {
            let mut stream = SampleStream::new(Coordinate::Gamma, output.gamma(length).collect(), false);
            let mut nodes = 0;
            let last = solve_window_by_window(&setup, &mut |window: &Solution| {
                nodes += window.x().len();
                stream.see(window);
            });
            let last = last.map_err(|failure| failure.status.as_str())?;
            let samples = stream.finish(&last).map_err(|_| "outside-run")?;
            let states =
                samples.iter().map(|sample| State { elapsed: sample.t, x: sample.x, w: sample.x_dot }).collect();
            let evaluations = last.iterations.count * last.x().len();
            Ok(Raw::Trajectory(Trajectory { states, evaluations, steps: nodes }))
        })
    }
}

fn failed(failure: MarchFailure) -> &'static str {
    match failure {
        MarchFailure::OutsideDomain { .. } => "outside-domain",
        MarchFailure::NotConverged { .. } => "not-converged",
        MarchFailure::AccuracyNotReached { .. } => "accuracy-not-reached",
        MarchFailure::TimeNotReached { .. } => "end-time-not-reached",
        MarchFailure::EvaluationLimit { .. } => "evaluation-limit",
    }
}

fn start(problem: &Problem) -> MarchState {
    let initial = problem.start;
    MarchState { t: Twofold::ZERO, x: initial.x.into(), w: initial.x_dot.into() }
}

fn march(
    problem: &Problem,
    rule: &WeakRule,
    output: &Output,
    windows: usize,
    tolerance: f64,
) -> Result<Raw<Metric>, &'static str> {
    let length = Twofold::from(problem.length) / Twofold::from(windows as f64);
    let mut states = Vec::with_capacity(output.marks.len());
    let mut marks = Marks::new(output, windows);
    let march = March::new(&problem.space, problem.q_t(), rule, length).with_tolerance(tolerance);
    let last = Marks::last(output, windows);
    let marched = march.run(start(problem), last, &mut |view| {
        let fractions = std::iter::from_fn(|| marks.within(view.index));
        view.inside(fractions, |Inside { t, x, w }| states.push(State { elapsed: t, x, w }));
        ControlFlow::Continue(())
    });
    let statistics = marched.map_err(failed)?.statistics;
    let nodes = rule.points();
    Ok(Raw::Trajectory(Trajectory { states, evaluations: statistics.evaluations * nodes, steps: last * nodes }))
}
