//! Errors along a long run, with about the same work for every method. They show a drift, a bounded oscillation, or the
//! random walk of rounding.

use super::trial::job;
use super::{Arena, Method, RowErrors};
use crate::case::{Form, SbpName};
use crate::methods::{Output, Peer, Setting, Trajectory};

/// Number of evaluations of the potential for each of the intervals into which a run is divided.
const EVALUATIONS: f64 = 200.0;

/// The number of steps is corrected at most so often.
const MOST_CORRECTIONS: usize = 4;
/// Number of Taylor steps of the reference that make an interval.
const PIECES: f64 = 3.0;
/// Number of points of output, evenly spaced in log γ.
const POINTS: usize = 200;

/// The errors of one method at one γ.
#[derive(Debug, Clone, PartialEq)]
pub struct DriftPoint {
    /// The method.
    pub method: Method,
    /// Its setting.
    pub setting: String,
    /// γ − γ_i.
    pub gamma: f64,
    /// The errors at that γ.
    pub errors: RowErrors,
}

/// Runs some of the `chosen` methods, each in one setting, and returns their errors along the world-line.
///
/// The setting costs about 200 evaluations per interval of the world-line, as a first run counts them; for an adaptive
/// method it is the tolerance that comes closest to that. An interval is three steps of the reference, each of which
/// covers about 0.6 radians of the motion. The states are taken at 200 values of γ, evenly spaced in log γ, at which
/// constant steps end. A method that fails is left out.
pub fn drift(arena: &Arena, chosen: &[Method]) -> Vec<DriftPoint> {
    let intervals = ((arena.scale() / PIECES).ceil() as usize).max(POINTS / 2);
    let mark = |k: usize| (intervals as f64).powf(k as f64 / (POINTS - 1) as f64).round() as usize;
    let mut marks: Vec<usize> = (0..POINTS).map(mark).collect();
    marks.dedup();
    let output = Output { intervals, marks };
    // Evaluations per step, roughly; 0 for adaptive methods.
    let methods = [
        (Method::Block(SbpName::Sbp21, Form::Strong), 1.0),
        (Method::Block(SbpName::Sbp42, Form::Strong), 2.0),
        (Method::Block(SbpName::Sbp42, Form::Weak), 2.0),
        (Method::Block(SbpName::Sbp84, Form::Weak), 2.0),
        (Method::March(8), 64.0),
        (Method::March(16), 176.0),
        (Method::Peer(Peer::Rk4), 4.0),
        (Method::Peer(Peer::Verlet), 1.0),
        (Method::Peer(Peer::KahanLi8), 17.0),
        (Method::Peer(Peer::KahanLi8Compensated), 17.0),
        (Method::Peer(Peer::Gauss(4)), 32.0),
        (Method::Peer(Peer::Gauss(8)), 88.0),
        (Method::Peer(Peer::Dop853), 0.0),
        (Method::Peer(Peer::Taylor), 0.0),
    ];
    let mut points = Vec::new();
    for (method, cost) in methods.into_iter().filter(|(method, _)| chosen.contains(method)) {
        let run = |setting: Setting| Some((setting, job(arena, &method, setting, &output)().ok()?));
        let Some((setting, outcome)) = in_budget(intervals, cost, run) else { continue };
        let evaluations = outcome.evaluations as f64 / arena.length();
        let label = format!("{evaluations:.0} evaluations a unit of gamma");
        let label = if setting.tolerance > 0.0 { format!("tol={:e}, {label}", setting.tolerance) } else { label };
        points.extend(output.gamma(arena.length()).zip(outcome.states.iter()).map(|(gamma, state)| DriftPoint {
            method: method.clone(),
            setting: label.clone(),
            gamma,
            errors: arena.error(gamma, state),
        }));
    }
    points
}

/// The run of so many `intervals` that costs about what it should, with its setting. A step costs `cost` evaluations,
/// roughly; 0 stands for an adaptive method.
fn in_budget(
    intervals: usize,
    cost: f64,
    run: impl Fn(Setting) -> Option<(Setting, Trajectory)>,
) -> Option<(Setting, Trajectory)> {
    if cost == 0.0 {
        let distance = |outcome: &Trajectory| (outcome.evaluations as f64 / intervals as f64 / EVALUATIONS).ln().abs();
        let all = (2..=15).filter_map(|digits| run(Setting::tolerance(10.0_f64.powi(-digits))));
        return all.min_by(|a, b| distance(&a.1).total_cmp(&distance(&b.1)));
    }
    let steps = |cost: f64| intervals * (EVALUATIONS / cost).round().max(1.0) as usize;
    let (mut setting, mut outcome) = run(Setting::steps(steps(cost)))?;
    // The number of iterations of a method depends on the motion, and on the length of its steps.
    for _ in 0..MOST_CORRECTIONS {
        let counted = steps(outcome.evaluations as f64 / setting.count as f64);
        if counted == setting.count {
            break;
        }
        (setting, outcome) = run(Setting::steps(counted))?;
    }
    Some((setting, outcome))
}
