//! One method in one setting, ready to run.

use std::ops::ControlFlow;

use super::Arena;
use super::family::Family;
use crate::case::{Case, Form, SbpName, Scheme, Solver};
use crate::lobatto::{Inside, March, MarchFailure, State as MarchState, Twofold, WeakRule};
use crate::methods::{Failure, Marks, Output, Setting, State, Trajectory};
use crate::sampling::{Coordinate, SampleStream};
use crate::solve::{Joint, NoSolution, Setup, Solution, solve, solve_window_by_window};

/// A run to be timed. It contains only the work that a user would have to do as well.
pub(super) struct Job<'a> {
    run: Box<dyn Fn() -> Result<Raw, &'static str> + 'a>,
}

/// The result of a run, before the states are read from it.
pub(super) enum Raw {
    Trajectory(Trajectory),
    Solution(Box<Solution>),
}

/// The states of a run at the points of output.
pub(super) struct Outcome {
    pub(super) states: Vec<State>,
    pub(super) evaluations: usize,
    pub(super) points: usize,
}

/// The case without what belongs to one scheme only: its windows, its solver, its expectations and D in place of D̄.
pub(super) fn plain(case: &Case) -> Case {
    let mut plain = case.clone();
    plain.grid.windows = 1;
    plain.scheme.regularised = true;
    plain.solver = Solver::default();
    plain.expect = None;
    plain
}

impl<'a> Job<'a> {
    pub(super) fn new(arena: &'a Arena, family: &Family, setting: Setting, output: Output) -> Self {
        let Setting { count, tolerance } = setting;
        let problem = &arena.problem;
        let run: Box<dyn Fn() -> Result<Raw, &'static str> + 'a> = match *family {
            Family::Block(sbp, form) => certified(arena, (sbp, form), count + 1),
            Family::Elements(nodes) => {
                let name = SbpName::Gll(nodes as u8);
                certified(arena, (name, Form::Weak), count * (nodes - 1) + 1)
            }
            Family::March(nodes) => {
                let rule = WeakRule::shared(nodes);
                Box::new(move || march(arena, rule, &output, count, tolerance))
            }
            Family::Accuracy => accuracy(arena, output, tolerance),
            Family::Peer(peer) => Box::new(move || finish(peer.run(problem, &output, setting))),
            Family::Other(_) => Box::new(|| Err("elsewhere")),
        };
        Self { run }
    }

    pub(super) fn run(&self) -> Result<Raw, &'static str> {
        (self.run)()
    }
}

fn finish(result: Result<Trajectory, Failure>) -> Result<Raw, &'static str> {
    result.map(Raw::Trajectory).map_err(Failure::as_str)
}

/// A call of `solve` with this many nodes in all.
fn certified<'a>(
    arena: &'a Arena,
    scheme: (SbpName, Form),
    nodes: usize,
) -> Box<dyn Fn() -> Result<Raw, &'static str> + 'a> {
    match arena.case.on_grid(scheme, nodes, arena.problem.length) {
        Ok(case) => Box::new(move || match solve(&case) {
            Ok(solution) => Ok(Raw::Solution(Box::new(solution))),
            Err(NoSolution { status, .. }) => Err(status.as_str()),
        }),
        Err(_) => Box::new(|| Err("no-such-grid")),
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

fn start(arena: &Arena) -> MarchState {
    let initial = arena.problem.initial;
    MarchState { t: Twofold::ZERO, x: initial.x.into(), w: initial.x_dot.into() }
}

fn march(arena: &Arena, rule: &WeakRule, output: &Output, windows: usize, tolerance: f64) -> Result<Raw, &'static str> {
    let problem = &arena.problem;
    let length = Twofold::from(problem.length) / Twofold::from(windows as f64);
    let mut states = Vec::with_capacity(output.marks.len());
    let mut marks = Marks::new(output, windows);
    let march = March::new(&problem.metric, problem.q_t(), rule, length).with_tolerance(tolerance);
    let last = Marks::last(output, windows);
    let marched = march.run(start(arena), last, &mut |view| {
        let fractions = std::iter::from_fn(|| marks.within(view.index));
        view.inside(fractions, |Inside { t, x, w }| states.push(State { elapsed: t, x, w }));
        ControlFlow::Continue(())
    });
    let statistics = marched.map_err(failed)?.statistics;
    let nodes = rule.points();
    Ok(Raw::Trajectory(Trajectory { states, evaluations: statistics.evaluations * nodes, steps: last * nodes }))
}

/// A run with an accuracy. Its states are samples, of which t and x keep it.
fn accuracy<'a>(arena: &'a Arena, output: Output, accuracy: f64) -> Box<dyn Fn() -> Result<Raw, &'static str> + 'a> {
    let length = arena.problem.length;
    let mut case = arena.case.clone();
    (case.grid.gamma_f, case.grid.t_f, case.grid.n_gamma) = (Some(length.into()), None, 0);
    (case.grid.gamma_i, case.initial.t) = (0.0.into(), 0.0.into());
    (case.solver.accuracy, case.scheme) = (Some(accuracy.into()), Scheme::default());
    let setup = Setup::from(&case);
    Box::new(move || {
        let mut stream = SampleStream::new(Coordinate::Gamma, output.gamma(length).collect(), false);
        let mut nodes = 0;
        let last = solve_window_by_window(setup.clone(), &mut |window: &Solution| {
            nodes += window.x.len();
            stream.see(window);
        });
        let last = last.map_err(|failure| failure.status.as_str())?;
        let samples = stream.finish(&last).map_err(|_| "outside-run")?;
        let states = samples.iter().map(|sample| State { elapsed: sample.t, x: sample.x, w: sample.x_dot }).collect();
        let evaluations = last.iterations * last.x.len();
        Ok(Raw::Trajectory(Trajectory { states, evaluations, steps: nodes }))
    })
}

impl Raw {
    /// The states at the marks of `output`, which coincide with ends of windows or with nodes.
    pub(super) fn outcome(self, output: &Output) -> Result<Outcome, &'static str> {
        let solution = match self {
            Self::Trajectory(Trajectory { states, evaluations, steps }) => {
                return Ok(Outcome { states, evaluations, points: steps });
            }
            Self::Solution(solution) => solution,
        };
        let windows = solution.windows.len();
        let nodes = solution.sbp().points();
        let state = |&mark: &usize| {
            if windows > 1 {
                // The number of windows per interval is whole.
                let after = mark * windows / output.intervals;
                let Joint { t, x, x_dot } = solution.windows[after - 1].end;
                return State { elapsed: t, x, w: x_dot };
            }
            if mark == output.intervals {
                return State { elapsed: solution.duration(), x: solution.end.x, w: solution.end.x_dot };
            }
            let node = mark * (nodes - 1) / output.intervals;
            let w = solution.sbp().derivative_at(&solution.x, node);
            State { elapsed: solution.elapsed[node], x: solution.x[node], w }
        };
        // An explicit recursion evaluates once per node and reports no iterations; otherwise the iterations are summed
        // over the windows.
        let sweeps = solution.iterations.max(windows);
        Ok(Outcome {
            states: output.marks.iter().map(state).collect(),
            evaluations: sweeps * nodes,
            points: windows * nodes,
        })
    }
}
