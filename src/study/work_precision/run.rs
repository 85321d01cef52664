//! One method in one setting, ready to run.

use super::arena::Arena;
use super::family::Family;
use crate::case::{Form, SbpName, on_grid};
use crate::methods::{Failure, Output, Prepared, Setting, States, Trajectory, Windows};
use crate::solve::{Joint, NoSolution, WorldLine, solve};
use crate::study::subject::timed;

/// The result of a run, before the states are read from it.
enum Raw {
    Trajectory(Trajectory),
    WorldLine(Box<WorldLine>),
}

type Run<'a> = Box<dyn FnMut() -> Result<Raw, &'static str> + 'a>;

/// A run to be timed. It contains only the work that a user would have to do as well.
pub(super) struct Timed<'a>(Run<'a>);

impl<'a> Timed<'a> {
    /// A method in a setting.
    pub(super) fn new(arena: &'a Arena, family: &Family, setting: Setting, output: Output) -> Self {
        let (problem, count) = (&arena.problem, setting.count);
        Self(match *family {
            Family::Block(sbp, form) => solved(arena, (sbp, form), count + 1),
            Family::Elements(nodes) => solved(arena, (SbpName::Gll(nodes as u8), Form::Weak), count * (nodes - 1) + 1),
            Family::Accuracy => stepped(Windows::Accuracy.windows(problem, output, setting)),
            Family::Tolerance => stepped(Windows::Tolerance.windows(problem, output, setting)),
            Family::March(nodes) => stepped(Windows::Equal(nodes).windows(problem, output, setting)),
            Family::Peer(peer) => stepped(peer.prepared(problem, output, setting)),
            Family::Other(_) => Box::new(|| Err("elsewhere")),
        })
    }

    /// Runs it once. Returns the seconds that it takes, and what it finds at the marks of `output`, which coincide with
    /// ends of windows or with nodes.
    pub(super) fn attempt(&mut self, output: &Output) -> (f64, Result<Trajectory, &'static str>) {
        let (result, seconds) = timed(&mut self.0);
        let found = result.map(|raw| match raw {
            Raw::Trajectory(found) => found,
            Raw::WorldLine(line) => at_marks(&line, output),
        });
        (seconds, found)
    }

    /// The seconds that so many runs take. Their results are not looked at: a run that succeeded once succeeds again.
    pub(super) fn repeat(&mut self, runs: u32) -> f64 {
        let ((), seconds) = timed(|| (0..runs).for_each(|_| drop(std::hint::black_box((self.0)()))));
        seconds
    }
}

/// The states of a world-line at the marks of an output.
fn at_marks(line: &WorldLine, Output { intervals, marks }: &Output) -> Trajectory {
    let (windows, nodes) = (line.windows.len(), line.sbp().points());
    let (active, rows, start) = (line.geometry().active(), line.view(0).rows(), &line.place.start);
    let mut states = States::new(start.q.len(), marks.len());
    for &mark in marks {
        // The number of windows per interval is whole, unless there is one window.
        let end = if windows > 1 { Some(mark * windows / intervals) } else { (mark == *intervals).then_some(1) };
        if let Some(after) = end {
            let Joint { q, p } = line.joint(after);
            states.push(q, p);
            continue;
        }
        let node = mark * (nodes - 1) / intervals;
        let (mut q, mut p) = (start.q.clone(), start.p.clone());
        for (a, (q, row)) in q.iter_mut().zip(&rows).enumerate() {
            *q = if active.contains(&a) { row[node] } else { *q + row[node] };
        }
        line.p.iter().zip(active).for_each(|(row, &a)| p[a] = row[node]);
        states.push(&q, &p);
    }
    // An explicit recursion evaluates once per node and reports no iterations; otherwise the iterations are summed over
    // the windows.
    let sweeps = line.iterations.count.max(windows);
    Trajectory { states, evaluations: sweeps * nodes, steps: windows * nodes }
}

/// A method that computes states.
fn stepped(mut run: Prepared<'_>) -> Run<'_> {
    Box::new(move || run().map(Raw::Trajectory).map_err(Failure::as_str))
}

/// A call of `solve` with this many nodes in all.
fn solved(arena: &Arena, scheme: (SbpName, Form), nodes: usize) -> Run<'_> {
    match on_grid(&arena.setup, scheme, nodes, arena.length()) {
        Ok(setup) => Box::new(move || match solve(&setup) {
            Ok(line) => Ok(Raw::WorldLine(Box::new(line))),
            Err(NoSolution { status, .. }) => Err(status.as_str()),
        }),
        Err(_) => Box::new(|| Err("no-such-grid")),
    }
}
