//! One method in one setting, ready to run.

use std::ops::ControlFlow;

use super::arena::{Arena, One, Place, Scene, World};
use super::family::Family;
use crate::case::scene::on_grid;
use crate::case::{Case, Form, SbpName, Scheme, Solver};
use crate::lobatto::flow::{Flow, FlowFailure};
use crate::lobatto::{Inside, March, MarchFailure, State as MarchState, Twofold, WeakRule};
use crate::methods::{Failure, Marks, Output, Problem, SceneState, Setting, State, Trajectory};
use crate::sampling::{Coordinate, SampleStream};
use crate::scalar::Real;
use crate::solve::{
    Joint, NoSolution, Settings, Setup, Solution, Space, System, WorldLine, solve, solve_window_by_window,
};

/// A run to be timed. It contains only the work that a user would have to do as well.
pub(super) struct Job<'a> {
    run: Box<dyn Fn() -> Result<Raw, &'static str> + 'a>,
}

/// The result of a run, before the states are read from it.
pub(super) enum Raw {
    Trajectory(Trajectory),
    Solution(Box<Solution>),
    SceneTrajectory(Trajectory<SceneState>),
    WorldLine(Box<WorldLine>),
}

/// The states of a run at the points of output.
pub(super) struct Outcome {
    pub(super) places: Vec<Place>,
    pub(super) evaluations: usize,
    pub(super) points: usize,
}

/// The case without what belongs to one scheme only: its windows, its solver, its expectations and D in place of D̄.
pub(in crate::study) fn plain(case: &Case) -> Case {
    let mut plain = case.clone();
    plain.grid.windows = 1;
    plain.scheme.regularised = true;
    plain.solver = Solver::default();
    plain.expect = None;
    plain
}

impl<'a> Job<'a> {
    pub(super) fn new(arena: &'a Arena, family: &Family, setting: Setting, output: Output) -> Self {
        let run = match &arena.world {
            World::One(one) => of_one(one, family, setting, output),
            World::Scene(scene) => of_scene(scene, family, setting, output),
        };
        Self { run }
    }

    pub(super) fn run(&self) -> Result<Raw, &'static str> {
        (self.run)()
    }
}

type Run<'a> = Box<dyn Fn() -> Result<Raw, &'static str> + 'a>;

/// For a family that there is not.
fn none<'a>(word: &'static str) -> Run<'a> {
    Box::new(move || Err(word))
}

fn of_one<'a>(one: &'a One, family: &Family, setting: Setting, output: Output) -> Run<'a> {
    let Setting { count, tolerance } = setting;
    match *family {
        Family::Block(sbp, form) => certified(one, (sbp, form), count + 1),
        Family::Elements(nodes) => certified(one, (SbpName::Gll(nodes as u8), Form::Weak), count * (nodes - 1) + 1),
        Family::March(nodes) => {
            let rule = WeakRule::shared(nodes);
            Box::new(move || march(&one.problem, rule, &output, count, tolerance))
        }
        Family::Accuracy => accuracy(one, output, tolerance),
        Family::Peer(peer) => Box::new(move || {
            let trajectory = peer.run(&one.problem, &output, setting);
            trajectory.map(Raw::Trajectory).map_err(Failure::as_str)
        }),
        Family::Other(_) => none("elsewhere"),
    }
}

fn of_scene<'a>(scene: &'a Scene, family: &Family, setting: Setting, output: Output) -> Run<'a> {
    let count = setting.count;
    match *family {
        Family::Block(sbp, form) => world_line(scene, (sbp, form), count + 1),
        Family::Elements(nodes) => world_line(scene, (SbpName::Gll(nodes as u8), Form::Weak), count * (nodes - 1) + 1),
        Family::Peer(peer) => Box::new(move || {
            let trajectory = peer.run(&scene.problem, &output, setting);
            trajectory.map(Raw::SceneTrajectory).map_err(Failure::as_str)
        }),
        Family::Accuracy => flow(scene, output, setting.tolerance),
        Family::March(_) => none("not-for-scenes"),
        Family::Other(_) => none("elsewhere"),
    }
}

/// A call of `solve` with this many nodes in all.
fn world_line<'a>(scene: &'a Scene, scheme: (SbpName, Form), nodes: usize) -> Run<'a> {
    let mut plain = scene.setup.clone();
    let (system, digits) = (System::PhysicalLimit, f64::MOST_DIGITS);
    plain.settings = Settings { system, digits, windows: 1, ..plain.settings };
    match on_grid(&plain, scheme, nodes, scene.problem.length) {
        Ok(setup) => Box::new(move || match solve(&setup) {
            Ok(line) => Ok(Raw::WorldLine(Box::new(line))),
            Err(failure) => Err(failure.status.as_str()),
        }),
        Err(_) => none("no-such-grid"),
    }
}

/// Certified windows for an accuracy, and the states inside them.
fn flow<'a>(scene: &'a Scene, output: Output, accuracy: f64) -> Run<'a> {
    let (geometry, start, length) = (&*scene.problem.space, &scene.problem.start, scene.problem.length);
    let marks: Vec<f64> = output.gamma(length).collect();
    Box::new(move || {
        let (mut states, mut points): (Vec<SceneState>, _) = (Vec::with_capacity(marks.len()), 0);
        let followed = Flow::new(geometry).certified().run(start, length, &mut [], accuracy, &mut |view| {
            if view.index == 0 {
                states.clear();
                points = 0;
            }
            points += view.points;
            let end = view.gamma + view.length;
            let is_inside = |mark: &&f64| **mark <= end || end >= length;
            let fractions = marks[states.len()..].iter().take_while(is_inside);
            let fractions: Vec<f64> = fractions.map(|mark| ((mark - view.gamma) / view.length).min(1.0)).collect();
            view.inside(&fractions, |q, p| {
                let mut momenta = start.p.clone();
                geometry.active().iter().zip(p).for_each(|(&a, &p)| momenta[a] = p);
                states.push(SceneState { q: q.to_vec(), p: momenta });
            });
            ControlFlow::Continue(())
        });
        let evaluations = match followed {
            Ok(followed) => followed.statistics.evaluations * (points / followed.statistics.windows.max(1)),
            Err(FlowFailure::OutsideDomain { .. }) => return Err("outside-domain"),
            Err(FlowFailure::NotConverged { .. }) => return Err("not-converged"),
            Err(FlowFailure::AccuracyNotReached { .. }) => return Err("accuracy-not-reached"),
            Err(FlowFailure::EvaluationLimit { .. }) => return Err("evaluation-limit"),
        };
        Ok(Raw::SceneTrajectory(Trajectory { states, evaluations, steps: points }))
    })
}

/// A call of `solve` with this many nodes in all.
fn certified<'a>(one: &'a One, scheme: (SbpName, Form), nodes: usize) -> Run<'a> {
    match one.case.on_grid(scheme, nodes, one.problem.length) {
        Ok(case) => Box::new(move || match solve(&case) {
            Ok(solution) => Ok(Raw::Solution(Box::new(solution))),
            Err(NoSolution { status, .. }) => Err(status.as_str()),
        }),
        Err(_) => none("no-such-grid"),
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
) -> Result<Raw, &'static str> {
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

/// A run with an accuracy. Its states are samples, of which t and x keep it.
fn accuracy<'a>(one: &'a One, output: Output, accuracy: f64) -> Run<'a> {
    let length = one.problem.length;
    let mut case = one.case.clone();
    (case.grid.gamma_f, case.grid.t_f, case.grid.n_gamma) = (Some(length.into()), None, 0);
    (case.grid.gamma_i, case.initial.t) = (0.0.into(), 0.0.into());
    (case.solver.accuracy, case.scheme) = (Some(accuracy.into()), Scheme::default());
    let setup = Setup::from(&case);
    Box::new(move || {
        let mut stream = SampleStream::new(Coordinate::Gamma, output.gamma(length).collect(), false);
        let mut nodes = 0;
        let last = solve_window_by_window(setup.clone(), &mut |window: &Solution| {
            nodes += window.x().len();
            stream.see(window);
        });
        let last = last.map_err(|failure| failure.status.as_str())?;
        let samples = stream.finish(&last).map_err(|_| "outside-run")?;
        let states = samples.iter().map(|sample| State { elapsed: sample.t, x: sample.x, w: sample.x_dot }).collect();
        let evaluations = last.iterations.count * last.x().len();
        Ok(Raw::Trajectory(Trajectory { states, evaluations, steps: nodes }))
    })
}

impl Raw {
    /// The states at the marks of `output`, which coincide with ends of windows or with nodes.
    pub(super) fn outcome(self, arena: &Arena, output: &Output) -> Result<Outcome, &'static str> {
        let solution = match self {
            Self::Trajectory(Trajectory { states, evaluations, steps }) => {
                let places = states.iter().map(|state| arena.place(state)).collect();
                return Ok(Outcome { places, evaluations, points: steps });
            }
            Self::SceneTrajectory(Trajectory { states, evaluations, steps }) => {
                let places = states.into_iter().map(|state| arena.place_of(state)).collect();
                return Ok(Outcome { places, evaluations, points: steps });
            }
            Self::WorldLine(line) => {
                return Ok(outcome_of(&line, output, |node| momenta_at(&line, node), |state| arena.place_of(state)));
            }
            Self::Solution(solution) => solution,
        };
        // The momentum of x is minus its velocity.
        let momenta = |node| vec![solution.invariants().q_t, -solution.sbp().derivative_at(solution.x(), node)];
        Ok(outcome_of(&solution, output, momenta, |SceneState { q, p }| {
            arena.place(&State { elapsed: q[0], x: q[1], w: -p[1] })
        }))
    }
}

/// The places of a world-line at the marks of `output`, which coincide with ends of windows or with nodes. `momenta`
/// gives p_a at a node of a run in one window.
fn outcome_of<G: Space<f64>>(
    line: &WorldLine<f64, G>,
    output: &Output,
    momenta: impl Fn(usize) -> Vec<f64>,
    place: impl Fn(SceneState) -> Place,
) -> Outcome {
    let (windows, nodes) = (line.windows.len(), line.sbp().points());
    let state = |&mark: &usize| {
        // The number of windows per interval is whole, unless there is one window.
        let end =
            if windows > 1 { Some(mark * windows / output.intervals) } else { (mark == output.intervals).then_some(1) };
        if let Some(after) = end {
            let Joint { q, p } = line.joint(after);
            return SceneState { q: q.to_vec(), p: p.to_vec() };
        }
        let node = mark * (nodes - 1) / output.intervals;
        let (rows, start) = (line.view(0).rows(), &line.place.start);
        let absolute = |a: usize| if line.geometry().active().contains(&a) { 0.0 } else { start.q[a] };
        SceneState { q: rows.iter().enumerate().map(|(a, row)| absolute(a) + row[node]).collect(), p: momenta(node) }
    };
    // An explicit recursion evaluates once per node and reports no iterations; otherwise the iterations are summed over
    // the windows.
    let sweeps = line.iterations.count.max(windows);
    Outcome {
        places: output.marks.iter().map(|mark| place(state(mark))).collect(),
        evaluations: sweeps * nodes,
        points: windows * nodes,
    }
}

/// p_a of a scene at a node of its first window.
fn momenta_at(line: &WorldLine, node: usize) -> Vec<f64> {
    let mut p = line.place.start.p.clone();
    for (row, &a) in line.p.iter().zip(line.geometry().active()) {
        p[a] = row[node];
    }
    p
}
