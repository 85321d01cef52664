//! Errors along a long run for about the same work: drift, bounded oscillation and the random walk of rounding.

use std::sync::atomic::{AtomicBool, Ordering};

use super::family::{Family, Setting};
use super::run::{Job, Outcome};
use super::{Arena, RowErrors};
use crate::case::{Form, SbpName};
use crate::methods::Output;

/// Evaluations of the potential for each of the intervals that a run is cut into.
const EVALUATIONS: f64 = 200.0;
/// Pieces of the reference, in each of which little happens, that make an interval.
const PIECES: f64 = 3.0;
/// Points of output, evenly spaced in log γ.
const POINTS: usize = 200;

/// The errors of one method at one γ.
#[derive(Debug, Clone, PartialEq)]
pub struct DriftPoint {
    /// The method.
    pub family: Family,
    /// Its setting.
    pub setting: String,
    /// γ − γ_i.
    pub gamma: f64,
    /// The errors there.
    pub errors: RowErrors,
}

/// Runs one setting of each of some of the `chosen` methods that costs about 200 evaluations per interval of the
/// world-line, where an interval is three steps of the reference, each about six tenths of a radian of the motion; for
/// an adaptive method it is the closest tolerance. A method that fails is left out. The state is taken at 200 values of
/// γ, evenly spaced in log γ; constant steps end there.
pub fn drift(arena: &Arena, chosen: &[Family], cancel: &AtomicBool) -> Vec<DriftPoint> {
    let intervals = ((arena.scale() / PIECES).ceil() as usize).max(POINTS / 2);
    let mark = |k: usize| (intervals as f64).powf(k as f64 / (POINTS - 1) as f64).round() as usize;
    let mut marks: Vec<usize> = (0..POINTS).map(mark).collect();
    marks.dedup();
    let output = Output { intervals, marks };
    // Evaluations of a step, measured where a method iterates.
    let families = [
        (Family::Block(SbpName::Sbp21, Form::Strong), 1.0),
        (Family::Block(SbpName::Sbp42, Form::Strong), 6.0),
        (Family::Block(SbpName::Sbp42, Form::Weak), 6.0),
        (Family::Block(SbpName::Sbp84, Form::Weak), 6.0),
        (Family::March(8), 8.0 * 8.0),
        (Family::March(16), 16.0 * 11.0),
        (Family::Rk4, 4.0),
        (Family::Verlet, 1.0),
        (Family::KahanLi8, 17.0),
        (Family::KahanLi8Compensated, 17.0),
        (Family::Gauss(4), 4.0 * 8.0),
        (Family::Gauss(8), 8.0 * 11.0),
        (Family::Dop853, 0.0),
        (Family::Taylor, 0.0),
    ];
    let mut points = Vec::new();
    for (family, cost) in families.into_iter().filter(|(family, _)| chosen.contains(family)) {
        if cancel.load(Ordering::Relaxed) {
            break;
        }
        let run = |setting: Setting| {
            let outcome = Job::new(arena, &family, setting, output.clone()).run().and_then(|raw| raw.outcome(&output));
            outcome.ok().map(|outcome| (setting, outcome))
        };
        let found = if cost > 0.0 {
            run(Setting::steps(intervals * (EVALUATIONS / cost).round().max(1.0) as usize))
        } else {
            let distance = |outcome: &Outcome| (outcome.evaluations as f64 / intervals as f64 / EVALUATIONS).ln().abs();
            let all = (2..=15).filter_map(|digits| run(Setting::tolerance(10.0_f64.powi(-digits))));
            all.min_by(|a, b| distance(&a.1).total_cmp(&distance(&b.1)))
        };
        let Some((setting, outcome)) = found else { continue };
        let evaluations = outcome.evaluations as f64 / arena.length();
        let label = format!("{evaluations:.0} evaluations a unit of gamma");
        let label = if setting.tolerance > 0.0 { format!("tol={:e}, {label}", setting.tolerance) } else { label };
        points.extend(output.gamma(arena.length()).zip(&outcome.states).map(|(gamma, state)| DriftPoint {
            family: family.clone(),
            setting: label.clone(),
            gamma,
            errors: arena.error(gamma, state),
        }));
    }
    points
}
