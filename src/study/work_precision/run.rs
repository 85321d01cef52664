//! One method in one setting, ready to run.

use std::cell::RefCell;
use std::time::Instant;

use super::course::Course;
use super::family::Family;
use crate::case::{Form, SbpName, on_grid};
use crate::engine::MOST_POINTS;
use crate::methods::{Failure, Output, Peer, Setting, State, Trajectory, Windows};
use crate::solve::{Joint, NoSolution, WorldLine, solve};
use crate::study::line::{Judged, judged, momenta_at};

/// Windows of one length, by their number of nodes.
static MARCHES: [Windows; MOST_POINTS + 1] = {
    let mut all = [Windows::Equal(0); MOST_POINTS + 1];
    let mut nodes = 0;
    while nodes <= MOST_POINTS {
        all[nodes] = Windows::Equal(nodes);
        nodes += 1;
    }
    all
};

/// The result of a run, before the states are read from it.
enum Raw {
    Trajectory(Trajectory),
    WorldLine(Box<WorldLine>),
}

type Run<'a> = Box<dyn FnMut() -> Result<Raw, &'static str> + 'a>;

/// The states of a run at the points of output.
pub(super) struct Outcome {
    pub(super) places: Vec<Place>,
    pub(super) evaluations: usize,
    pub(super) points: usize,
}

/// The coordinates of a point of a world-line, and its K.
pub(super) struct Place {
    pub(super) q: Vec<f64>,
    pub(super) k: f64,
}

/// A run to be timed. It contains only the work that a user would have to do as well.
pub(super) struct Timed<'a> {
    course: &'a Course,
    run: RefCell<Run<'a>>,
}

impl<'a> Timed<'a> {
    /// A method in a setting.
    pub(super) fn new(course: &'a Course, family: &Family, setting: Setting, output: Output) -> Self {
        let count = setting.count;
        let run: Run<'a> = match *family {
            Family::Block(sbp, form) => solved(course, (sbp, form), count + 1),
            Family::Elements(nodes) => solved(course, (SbpName::Gll(nodes as u8), Form::Weak), count * (nodes - 1) + 1),
            Family::Accuracy => peer(course, &Windows::Accuracy, setting, output),
            Family::Tolerance => peer(course, &Windows::Tolerance, setting, output),
            Family::March(nodes) => peer(course, &MARCHES[nodes], setting, output),
            Family::Peer(of) => peer(course, of, setting, output),
            Family::Other(_) => none("elsewhere"),
        };
        Self { course, run: run.into() }
    }

    /// Runs it once. Returns the seconds that it takes, and what it finds at the marks of `output`, which coincide with
    /// ends of windows or with nodes.
    pub(super) fn attempt(&self, output: &Output) -> (f64, Result<Outcome, &'static str>) {
        let mut run = self.run.borrow_mut();
        let start = Instant::now();
        let result = run();
        let seconds = start.elapsed().as_secs_f64();
        (seconds, result.map(|raw| self.outcome(raw, output)))
    }

    /// The seconds that so many runs take. Their results are not looked at: a run that succeeded once succeeds again.
    pub(super) fn repeat(&self, runs: u32) -> f64 {
        let mut run = self.run.borrow_mut();
        let start = Instant::now();
        for _ in 0..runs {
            drop(std::hint::black_box(run()));
        }
        start.elapsed().as_secs_f64()
    }

    fn outcome(&self, raw: Raw, output: &Output) -> Outcome {
        let place = |state: State<'_>| {
            let Judged { q, k, .. } = judged(&self.course.problem, state);
            Place { q, k }
        };
        match raw {
            Raw::Trajectory(Trajectory { states, evaluations, steps }) => {
                Outcome { places: states.iter().map(place).collect(), evaluations, points: steps }
            }
            Raw::WorldLine(line) => {
                let (windows, nodes) = (line.windows.len(), line.sbp().points());
                // An explicit recursion evaluates once per node and reports no iterations; otherwise the iterations are
                // summed over the windows.
                let sweeps = line.iterations.count.max(windows);
                let places = output.marks.iter().map(|&mark| {
                    let (q, p) = state(&line, mark, output.intervals);
                    place(State { q: &q, p: &p })
                });
                Outcome { places: places.collect(), evaluations: sweeps * nodes, points: windows * nodes }
            }
        }
    }
}

/// q and p of a world-line at a mark among so many intervals.
fn state(line: &WorldLine, mark: usize, intervals: usize) -> (Vec<f64>, Vec<f64>) {
    let (windows, nodes) = (line.windows.len(), line.sbp().points());
    // The number of windows per interval is whole, unless there is one window.
    let end = if windows > 1 { Some(mark * windows / intervals) } else { (mark == intervals).then_some(1) };
    if let Some(after) = end {
        let Joint { q, p } = line.joint(after);
        return (q.to_vec(), p.to_vec());
    }
    let node = mark * (nodes - 1) / intervals;
    let (rows, start) = (line.view(0).rows(), &line.place.start);
    let absolute = |a: usize| if line.geometry().active().contains(&a) { 0.0 } else { start.q[a] };
    let q = rows.iter().enumerate().map(|(a, row)| absolute(a) + row[node]).collect();
    (q, momenta_at(line, node))
}

/// For a family that there is not.
fn none<'a>(word: &'static str) -> Run<'a> {
    Box::new(move || Err(word))
}

/// A method that computes states.
fn peer<'a>(course: &'a Course, peer: &'static dyn Peer, setting: Setting, output: Output) -> Run<'a> {
    let mut run = peer.prepared(&course.problem, output, setting);
    Box::new(move || run().map(Raw::Trajectory).map_err(Failure::as_str))
}

/// A call of `solve` with this many nodes in all.
fn solved(course: &Course, scheme: (SbpName, Form), nodes: usize) -> Run<'_> {
    match on_grid(&course.setup, scheme, nodes, course.problem.length) {
        Ok(setup) => Box::new(move || match solve(&setup) {
            Ok(line) => Ok(Raw::WorldLine(Box::new(line))),
            Err(NoSolution { status, .. }) => Err(status.as_str()),
        }),
        Err(_) => none("no-such-grid"),
    }
}
