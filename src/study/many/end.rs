//! The row of a run of many: its end, and the largest deviations on the way.

use crate::case::Case;
use crate::diagnostics::Diagnostics;
use crate::diagnostics::verdict::Verdict;
use crate::geometry::Geometry;
use crate::number::Real;
use crate::solve::{Arithmetic, NoSolution, WorldLine};
use crate::study::run::{NoRun, Wanted, run};
use crate::trajectory::Crossing;

/// The end of a world-line. All numbers are decimals with the digits of the run.
#[derive(Debug, Clone, PartialEq)]
pub struct End {
    /// The reason, in the word of the column `ended_by`: `gamma_f`, `t_f`, `until` for the formula of `grid.until`, or
    /// the name of the event that ends a run.
    pub ended_by: String,
    /// γ, every coordinate, and every dq/dγ with which the world-line can be continued.
    pub state: Vec<String>,
    /// Largest deviations on the way, and the growth of small changes, if it was asked for, with their names: those of
    /// [`maxima_of`](End::maxima_of).
    pub maxima: Vec<(String, String)>,
    /// The estimated error, if an accuracy was asked for.
    pub error_estimate: Option<f64>,
    /// The verdict on the result.
    pub verdict: Verdict,
    /// The events of the case, in the order of γ: the name, then the state.
    pub events: Vec<(String, Vec<String>)>,
}

impl End {
    /// The names of the largest deviations and of the growth that a run of `case` has.
    ///
    /// They are the keys of `summary.json`, those of a charge with its coordinate.
    pub fn maxima_of(case: &Case) -> Vec<String> {
        let geometry: Geometry = case.geometry();
        let of_charge = |a: usize| {
            let name = &geometry.names()[a];
            ["interior", "last", "corrected"].map(|at| format!("max_abs_delta_q_{name}_{at}"))
        };
        let k = if case.is_lifted() { "energy" } else { "k" };
        let mut names: Vec<String> = geometry.ignorable().flat_map(of_charge).collect();
        names.push("max_abs_delta_g_interior".to_owned());
        names.extend(["", "_ends"].map(|at| format!("max_abs_delta_{k}{at}")));
        names.extend(case.invariants.iter().map(|(name, _)| format!("max_abs_delta_{name}")));
        names.push("gradient_norm".to_owned());
        names.extend(["lyapunov", "megno"].into_iter().filter(|_| case.settings.sensitivity).map(str::to_owned));
        names
    }
}

/// Solves a case.
pub(super) fn outcome<S: Arithmetic>(case: &Case) -> Result<End, NoSolution> {
    let setup = case.setup::<S>();
    let found = match run(case, &setup, Wanted::default()).0 {
        Ok(found) => found,
        Err(NoRun::Unsolved(failure, _)) => return Err(failure),
        Err(NoRun::Unsampled(_)) => unreachable!("a row has no samples"),
    };
    let (line, verdict) = (&found.line, found.judged(&setup, false, false).verdict);
    let state = |gamma: S, q: &[S], q_dot: &[S]| -> Vec<String> {
        std::iter::once(&gamma).chain(q).chain(q_dot).map(|value| value.to_decimal(line.digits)).collect()
    };
    let events = found.events.iter().map(|Crossing { watch, sample }| {
        (case.events[*watch].name.clone(), state(sample.gamma, &sample.q, &sample.q_dot))
    });
    let end = line.end();
    Ok(End {
        ended_by: ended_by(case, line.ended_by).to_owned(),
        state: state(line.gamma_f(), &end.q, &end.q_dot),
        maxima: maxima(case, line, &found.diagnostics),
        error_estimate: line.error_estimate,
        verdict,
        events: events.collect(),
    })
}

/// The largest deviations, as decimals.
fn maxima<S: Real>(case: &Case, line: &WorldLine<S>, diagnostics: &Diagnostics<S>) -> Vec<(String, String)> {
    let Diagnostics { charges, max_delta_g, norm, energy, invariants, .. } = diagnostics;
    let mut values: Vec<S> =
        charges.iter().flat_map(|charge| [charge.max_interior, charge.max_last, charge.max_corrected]).collect();
    values.push(*max_delta_g);
    let motion = energy.as_ref().unwrap_or(norm);
    values.extend([motion.max_interior, motion.max_ends]);
    values.extend(invariants.iter().map(|(_, invariant)| invariant.max_interior));
    values.push(line.gradient_norm);
    values.extend(line.sensitivity.iter().flat_map(|it| [it.lyapunov(), it.megno()]).map(S::from));
    End::maxima_of(case).into_iter().zip(values).map(|(name, value)| (name, value.to_decimal(line.digits))).collect()
}

/// The word for what ended a run, from the place of the formula that did.
fn ended_by(case: &Case, ended_by: Option<usize>) -> &str {
    let own = usize::from(case.grid.until.is_some());
    let mut events = case.events.iter().filter(|event| event.until);
    match ended_by {
        None if case.grid.t_f.is_some() => "t_f",
        None => "gamma_f",
        Some(place) => {
            place.checked_sub(own).and_then(|place| events.nth(place)).map_or("until", |event| event.name.as_str())
        }
    }
}
