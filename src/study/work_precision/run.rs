//! One method in one setting, ready to run.

use super::Arena;
use crate::case::{Form, SbpName, on_grid};
use crate::methods::{Failure, Output, Prepared, Setting, States, Trajectory};
use crate::solve::{Joint, NoSolution, WorldLine, solve};
use crate::study::Method;

/// The result of a run, before the states are read from it.
pub(super) enum Found {
    Trajectory(Trajectory),
    WorldLine(Box<WorldLine>),
}

/// A run to be timed. It contains only the work that a user would have to do as well.
pub(super) type Job<'a> = Box<dyn FnMut() -> Result<Found, &'static str> + 'a>;

/// A method in a setting.
pub(super) fn job<'a>(arena: &'a Arena, method: &Method, setting: Setting, output: &Output) -> Job<'a> {
    let (problem, count) = (&arena.problem, setting.count);
    match *method {
        Method::Block(sbp, form) => solved(arena, (sbp, form), count + 1),
        Method::Elements(nodes) => solved(arena, (SbpName::Gll(nodes as u8), Form::Weak), count * (nodes - 1) + 1),
        Method::Peer(peer) => stepped(peer.prepared(problem, output.clone(), setting)),
        _ => match method.windows() {
            Some(windows) => stepped(windows.windows(problem, output.clone(), setting)),
            None => Box::new(|| Err("elsewhere")),
        },
    }
}

/// A method that computes states.
fn stepped(mut run: Prepared<'_>) -> Job<'_> {
    Box::new(move || run().map(Found::Trajectory).map_err(Failure::as_str))
}

/// A call of `solve` with this many nodes in all.
fn solved(arena: &Arena, scheme: (SbpName, Form), nodes: usize) -> Job<'_> {
    match on_grid(&arena.setup, scheme, nodes, arena.length()) {
        Ok(setup) => Box::new(move || match solve(&setup) {
            Ok(line) => Ok(Found::WorldLine(Box::new(line))),
            Err(NoSolution { status, .. }) => Err(status.as_str()),
        }),
        Err(_) => Box::new(|| Err("no-such-grid")),
    }
}

impl Found {
    /// What was found at the marks of an output, which coincide with ends of windows or with nodes.
    pub(super) fn at(self, Output { intervals, marks }: &Output) -> Trajectory {
        let line = match self {
            Self::Trajectory(found) => return found,
            Self::WorldLine(line) => line,
        };
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
        // An explicit recursion evaluates once per node and reports no iterations; otherwise the iterations are summed
        // over the windows.
        let sweeps = line.iterations.count.max(windows);
        Trajectory { states, evaluations: sweeps * nodes, steps: windows * nodes }
    }
}
