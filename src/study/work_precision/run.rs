//! One method in one setting, ready to run.

use std::ops::ControlFlow;

use super::Arena;
use super::family::{Family, Setting, taylor_digits, taylor_order};
use crate::case::{Case, Form, SbpName, Solver};
use crate::lobatto::{Adaptive, Goal, March, MarchFailure, State as MarchState, Twofold, WeakRule};
use crate::methods::{self, Composition, Failure, Gauss, Output, State, Trajectory};
use crate::solve::{NoSolution, Solution, solve};

/// A run to be timed; nothing is prepared in it that a user would not have to prepare.
pub(super) struct Job<'a> {
    run: Box<dyn Fn() -> Result<Raw, &'static str> + 'a>,
}

/// What a run hands out before anything is read from it.
pub(super) enum Raw {
    Trajectory(Trajectory),
    Solution(Box<Solution>),
}

/// A run at the points of output.
pub(super) struct Outcome {
    pub(super) states: Vec<State>,
    pub(super) evaluations: usize,
    pub(super) points: usize,
}

/// The case without what belongs to one scheme only.
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
        let Setting { per_interval: steps, tolerance } = setting;
        let problem = &arena.problem;
        let count = steps * output.intervals;
        let composition = move |composition: Composition, output: Output| -> Box<dyn Fn() -> _> {
            Box::new(move || finish(composition.run(problem, &output, steps)))
        };
        let run: Box<dyn Fn() -> Result<Raw, &'static str> + 'a> = match *family {
            Family::Block(sbp, form) => certified(arena, (sbp, form), count + 1),
            Family::Elements(nodes) => {
                let name = SbpName::Gll(nodes as u8);
                certified(arena, (name, Form::Weak), count * (nodes - 1) + 1)
            }
            Family::March(nodes) => {
                let rule = WeakRule::shared(nodes);
                Box::new(move || march(arena, rule, &output, steps, tolerance))
            }
            Family::Adaptive => Box::new(move || adaptive(arena, &output, tolerance)),
            Family::Rk4 => Box::new(move || finish(methods::rk4(problem, &output, steps))),
            Family::Verlet => composition(Composition::VERLET, output),
            Family::KahanLi6 => composition(Composition::KAHAN_LI_6, output),
            Family::KahanLi8 => composition(Composition::KAHAN_LI_8, output),
            Family::KahanLi8Compensated => composition(Composition::KAHAN_LI_8.compensated(), output),
            Family::Gauss(stages) => {
                let gauss = Gauss { stages, tolerance };
                Box::new(move || finish(gauss.run(problem, &output, steps)))
            }
            Family::Dop853 => Box::new(move || finish(methods::dop853(problem, &output, tolerance))),
            Family::Radau5 => Box::new(move || finish(methods::radau5(problem, &output, tolerance))),
            Family::Taylor => {
                let (order, digits) = (taylor_order(tolerance), taylor_digits(tolerance));
                Box::new(move || finish(methods::taylor(problem, &output, order, digits)))
            }
            Family::Other(_) => Box::new(|| Err("elsewhere")),
        };
        Self { run }
    }

    pub(super) fn run(&self) -> Result<Raw, &'static str> {
        (self.run)()
    }
}

fn finish(result: Result<Trajectory, Failure>) -> Result<Raw, &'static str> {
    result.map(Raw::Trajectory).map_err(|failure| match failure {
        Failure::OutsideDomain => "outside-domain",
        Failure::Diverged => "diverged",
        Failure::TooManySteps => "too-many-steps",
        Failure::NotConverged => "not-converged",
    })
}

/// `solve` on so many nodes in all.
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
    }
}

fn start(arena: &Arena) -> MarchState {
    let initial = arena.problem.initial;
    MarchState { t: Twofold::ZERO, x: initial.x.into(), w: initial.x_dot.into() }
}

fn march(arena: &Arena, rule: &WeakRule, output: &Output, steps: usize, tolerance: f64) -> Result<Raw, &'static str> {
    let problem = &arena.problem;
    let windows = steps * output.intervals;
    let length = Twofold::from(problem.length) / Twofold::from(windows as f64);
    let mut states = Vec::with_capacity(output.marks.len());
    let mut wanted = output.marks.iter().map(|mark| mark * steps);
    let mut next = wanted.next();
    let mut march = March::new(&problem.metric, problem.q_t(), rule, length).with_tolerance(tolerance);
    let last = output.marks.last().map_or(0, |mark| mark * steps);
    let marched = march.run(start(arena), last, &mut |view| {
        if next == Some(view.index + 1) {
            states.push(State { elapsed: view.end.t.hi, x: view.end.x.hi, w: view.end.w.hi });
            next = wanted.next();
        }
        ControlFlow::Continue(())
    });
    let statistics = marched.map_err(failed)?.statistics;
    let nodes = rule.points();
    Ok(Raw::Trajectory(Trajectory { states, evaluations: statistics.evaluations * nodes, steps: last * nodes }))
}

/// By dense output, as accurate as the ends of the windows.
fn adaptive(arena: &Arena, output: &Output, accuracy: f64) -> Result<Raw, &'static str> {
    let problem = &arena.problem;
    let gammas: Vec<f64> = output.gamma(problem.length).collect();
    let mut states = Vec::with_capacity(gammas.len());
    let mut nodes = 0;
    let goal = Goal::Gamma(problem.length);
    let adapted = Adaptive::new(&problem.metric, problem.q_t()).run(start(arena), goal, accuracy, &mut |view| {
        if view.index == 0 {
            states.clear();
        }
        nodes = view.rule.points();
        let from = view.gamma.hi;
        let mut dense = None;
        while let Some(&gamma) = gammas.get(states.len()) {
            let share = (gamma - from) / view.length.hi;
            if share > 1.0 - 1e-12 {
                // At its end, or beyond it.
                if share < 1.0 + 1e-12 {
                    states.push(State { elapsed: view.end.t.hi, x: view.end.x.hi, w: view.end.w.hi });
                    continue;
                }
                break;
            }
            let point = dense.get_or_insert_with(|| view.dense()).at(share.max(0.0));
            states.push(State { elapsed: point.t, x: point.x, w: point.w });
        }
        ControlFlow::Continue(())
    });
    let adapted = adapted.map_err(failed)?;
    if states.len() < gammas.len() {
        // The last point is where the march ends, to rounding.
        let end = adapted.end;
        states.push(State { elapsed: end.t.hi, x: end.x.hi, w: end.w.hi });
    }
    let statistics = adapted.statistics;
    Ok(Raw::Trajectory(Trajectory {
        states,
        evaluations: statistics.evaluations * nodes,
        steps: statistics.windows * nodes,
    }))
}

impl Raw {
    /// The states at the marks of `output`, which are at ends of windows or on nodes.
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
                // Windows come in whole numbers an interval.
                let after = mark * windows / output.intervals;
                let end = solution.windows[after - 1].end;
                return State { elapsed: end.t, x: end.x, w: end.x_dot };
            }
            if mark == output.intervals {
                return State { elapsed: solution.duration(), x: solution.end.x, w: solution.end.x_dot };
            }
            let node = mark * (nodes - 1) / output.intervals;
            let w = solution.sbp().derivative_at(&solution.x, node);
            State { elapsed: solution.elapsed[node], x: solution.x[node], w }
        };
        // An explicit recursion evaluates once a node; otherwise iterations are summed over the windows.
        let sweeps = solution.iterations.max(windows);
        Ok(Outcome {
            states: output.marks.iter().map(state).collect(),
            evaluations: sweeps * nodes,
            points: windows * nodes,
        })
    }
}
