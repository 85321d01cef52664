//! One method in one setting, ready to run.

use super::Arena;
use crate::case::{Form, SbpName, on_grid};
use crate::methods::{Failure, Output, Prepared, Setting, States, Trajectory};
use crate::solve::{Joint, WorldLine, solve};
use crate::study::Method;

/// A run to be timed: what a user would have to do as well. It returns what it finds at the marks of its output.
pub(super) type Job<'a> = Box<dyn FnMut() -> Result<Trajectory, &'static str> + 'a>;

/// A method in a setting.
pub(super) fn job<'a>(arena: &'a Arena, method: &Method, setting: Setting, output: &Output) -> Job<'a> {
    let (problem, count, output) = (&arena.problem, setting.count, output.clone());
    let ((sbp, form), nodes) = match *method {
        Method::Block(sbp, form) => ((sbp, form), count + 1),
        Method::Elements(nodes) => ((SbpName::Gll(nodes as u8), Form::Weak), count * (nodes - 1) + 1),
        Method::Peer(peer) => return stepped(peer.prepared(problem, output, setting)),
        _ => match method.windows() {
            Some(windows) => return stepped(windows.windows(problem, output, setting)),
            None => return Box::new(|| Err("elsewhere")),
        },
    };
    match on_grid(&arena.setup, (sbp, form), nodes, arena.length()) {
        Ok(setup) => Box::new(move || match solve(&setup) {
            Ok(line) => Ok(at_marks(&line, &output)),
            Err(failure) => Err(failure.status.as_str()),
        }),
        Err(_) => Box::new(|| Err("no-such-grid")),
    }
}

/// A method that computes states.
fn stepped(mut run: Prepared<'_>) -> Job<'_> {
    Box::new(move || run().map_err(Failure::as_str))
}

/// The states of a world-line at the marks of an output, which coincide with ends of windows or with nodes.
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
