//! One method in one setting, ready to run.

use std::cell::RefCell;
use std::time::Instant;

use super::arena::Place;
use super::course::Course;
use crate::case::{Form, SbpName, on_grid};
use crate::methods::{Failure, Output, PeerIn, Setting, Trajectory};
use crate::solve::{Joint, NoSolution, WorldLine};
use crate::study::line::{Judged, Raced};

/// A run to be timed. It contains only the work that a user would have to do as well.
pub(super) trait Job {
    /// Runs it once. Returns the seconds that it takes, and what it finds at the marks of `output`, which coincide with
    /// ends of windows or with nodes.
    fn attempt(&self, output: &Output) -> (f64, Result<Outcome, &'static str>);

    /// The seconds that so many runs take. Their results are not looked at: a run that succeeded once succeeds again.
    fn repeat(&self, runs: u32) -> f64;
}

/// The result of a run, before the states are read from it.
pub(super) enum Raw<G: Raced> {
    Trajectory(Trajectory<G::State>),
    WorldLine(Box<WorldLine<f64, G>>),
}

pub(super) type Run<'a, G> = Box<dyn FnMut() -> Result<Raw<G>, &'static str> + 'a>;

/// The states of a run at the points of output.
pub(super) struct Outcome {
    pub(super) places: Vec<Place>,
    pub(super) evaluations: usize,
    pub(super) points: usize,
}

/// A run on a world-line.
pub(super) struct Timed<'a, G: Raced> {
    pub(super) course: &'a Course<G>,
    pub(super) run: RefCell<Run<'a, G>>,
}

impl<G: Raced> Job for Timed<'_, G> {
    fn attempt(&self, output: &Output) -> (f64, Result<Outcome, &'static str>) {
        let mut run = self.run.borrow_mut();
        let start = Instant::now();
        let result = run();
        let seconds = start.elapsed().as_secs_f64();
        (seconds, result.map(|raw| self.outcome(raw, output)))
    }

    fn repeat(&self, runs: u32) -> f64 {
        let mut run = self.run.borrow_mut();
        let start = Instant::now();
        for _ in 0..runs {
            drop(std::hint::black_box(run()));
        }
        start.elapsed().as_secs_f64()
    }
}

impl<G: Raced> Timed<'_, G> {
    fn outcome(&self, raw: Raw<G>, output: &Output) -> Outcome {
        let place = |state: G::State| {
            let Judged { q, k, .. } = G::judged(&self.course.problem, state);
            Place { q, k }
        };
        match raw {
            Raw::Trajectory(Trajectory { states, evaluations, steps }) => {
                Outcome { places: states.into_iter().map(place).collect(), evaluations, points: steps }
            }
            Raw::WorldLine(line) => {
                let (windows, nodes) = (line.windows.len(), line.sbp().points());
                // An explicit recursion evaluates once per node and reports no iterations; otherwise the iterations are
                // summed over the windows.
                let sweeps = line.iterations.count.max(windows);
                let places = output.marks.iter().map(|&mark| place(state(&line, mark, output.intervals)));
                Outcome { places: places.collect(), evaluations: sweeps * nodes, points: windows * nodes }
            }
        }
    }
}

/// The state of a world-line at a mark among so many intervals.
fn state<G: Raced>(line: &WorldLine<f64, G>, mark: usize, intervals: usize) -> G::State {
    let (windows, nodes) = (line.windows.len(), line.sbp().points());
    // The number of windows per interval is whole, unless there is one window.
    let end = if windows > 1 { Some(mark * windows / intervals) } else { (mark == intervals).then_some(1) };
    if let Some(after) = end {
        let Joint { q, p } = line.joint(after);
        return G::state_of(q.to_vec(), p.to_vec());
    }
    let node = mark * (nodes - 1) / intervals;
    let (rows, start) = (line.view(0).rows(), &line.place.start);
    let absolute = |a: usize| if line.geometry().active().contains(&a) { 0.0 } else { start.q[a] };
    let q = rows.iter().enumerate().map(|(a, row)| absolute(a) + row[node]).collect();
    G::state_of(q, G::momenta_at(line, node))
}

/// For a family that there is not.
pub(super) fn none<'a, G: Raced>(word: &'static str) -> Run<'a, G> {
    Box::new(move || Err(word))
}

/// A method that computes states.
pub(super) fn peer<'a, G: Raced>(
    course: &'a Course<G>,
    peer: &'static (impl PeerIn<G> + ?Sized),
    setting: Setting,
    output: Output,
) -> Run<'a, G> {
    let mut run = peer.prepared(&course.problem, output, setting);
    Box::new(move || run().map(Raw::Trajectory).map_err(Failure::as_str))
}

/// A call of `solve` with this many nodes in all.
pub(super) fn solved<G: Raced>(course: &Course<G>, scheme: (SbpName, Form), nodes: usize) -> Run<'_, G> {
    match on_grid(&course.setup, scheme, nodes, course.problem.length) {
        Ok(setup) => Box::new(move || match G::solve(&setup) {
            Ok(line) => Ok(Raw::WorldLine(Box::new(line))),
            Err(NoSolution { status, .. }) => Err(status.as_str()),
        }),
        Err(_) => none("no-such-grid"),
    }
}
