//! The row of a run of many: its end, and the largest deviations on the way.

use crate::case::Case;
use crate::diagnostics::Diagnostics;
use crate::diagnostics::verdict::Verdict;
use crate::geometry::Geometry;
use crate::number::Real;
use crate::solve::{Arithmetic, Status, WorldLine};
use crate::study::run::{NoRun, Wanted, run};
use crate::trajectory::Crossing;

/// The outcome of a run.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// At a critical point.
    Solved(Box<End>),
    /// Without one.
    Failed {
        /// The status with which the solve ended.
        status: Status,
        /// The message for people.
        message: String,
    },
}

/// Which of the ends that a case may have was met.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// The last value of γ.
    Gamma,
    /// The value of the coordinate t.
    Time,
    /// The formula of `grid.until` changed its sign.
    Until,
    /// The event of that name, which ends a run.
    Event(String),
}

/// The end of a world-line. All numbers are decimals with the digits of the run.
#[derive(Debug, Clone, PartialEq)]
pub struct End {
    /// Why it is there.
    pub ending: Ending,
    /// γ.
    pub gamma: String,
    /// Every coordinate.
    pub q: Vec<String>,
    /// dq/dγ of every coordinate with which the world-line can be continued.
    pub q_dot: Vec<String>,
    /// Largest deviations on the way, and the growth of small changes, if it was asked for, with their names: those of
    /// [`maxima_of`](End::maxima_of).
    pub maxima: Vec<(String, String)>,
    /// The estimated error, if an accuracy was asked for.
    pub error_estimate: Option<f64>,
    /// The verdict on the result.
    pub verdict: Verdict,
    /// The events of the case, in the order of γ.
    pub events: Vec<Found>,
}

/// An event that was met.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// Its name.
    pub event: String,
    /// γ, every coordinate, and every dq/dγ.
    pub state: Vec<String>,
}

impl End {
    /// The names of the largest deviations and of the growth that a run of `case` has.
    pub fn maxima_of(case: &Case) -> Vec<String> {
        let geometry: Geometry = case.geometry();
        let charges = geometry.ignorable().map(|a| &geometry.names()[a]);
        let invariants = case.invariants.iter().map(|(name, _)| name);
        names_of_maxima(charges, case.is_lifted(), invariants, case.settings.sensitivity)
    }
}

/// The names of deviations: those of the charges, of the equations, of K or the energy, of invariants; last those of
/// the growth, if there is one. They are the keys of `summary.json`, those of a charge with its coordinate.
fn names_of_maxima<'n>(
    charges: impl Iterator<Item = &'n String>,
    is_lifted: bool,
    invariants: impl Iterator<Item = &'n String>,
    is_sensitive: bool,
) -> Vec<String> {
    let of_charge = |name: &String| ["interior", "last", "corrected"].map(|at| format!("max_abs_delta_q_{name}_{at}"));
    let k = if is_lifted { "energy" } else { "k" };
    let mut names: Vec<String> = charges.flat_map(of_charge).collect();
    names.push("max_abs_delta_g_interior".to_owned());
    names.extend(["", "_ends"].map(|at| format!("max_abs_delta_{k}{at}")));
    names.extend(invariants.map(|name| format!("max_abs_delta_{name}")));
    names.push("gradient_norm".to_owned());
    names.extend(["lyapunov", "megno"].into_iter().filter(|_| is_sensitive).map(str::to_owned));
    names
}

/// Solves a case.
pub(super) fn outcome<S: Arithmetic>(case: &Case) -> Outcome {
    let setup = case.setup::<S>();
    let found = match run(case, &setup, Wanted::default()).0 {
        Ok(found) => found,
        Err(NoRun::Unsolved(failure, _)) => {
            return Outcome::Failed { status: failure.status, message: failure.to_string() };
        }
        Err(NoRun::Unsampled(_)) => unreachable!("a row has no samples"),
    };
    let (line, verdict) = (&found.line, found.judged(&setup, false, false).verdict);
    let all = |values: &[S]| values.iter().map(|value| value.to_decimal(line.digits)).collect::<Vec<_>>();
    let events = found.events.iter().map(|Crossing { watch, sample }| {
        let state = [&[sample.gamma][..], &sample.q, &sample.q_dot].concat();
        Found { event: case.events[*watch].name.clone(), state: all(&state) }
    });
    let end = line.end();
    Outcome::Solved(Box::new(End {
        ending: ending(case, line.ended_by),
        gamma: line.gamma_f().to_decimal(line.digits),
        q: all(&end.q),
        q_dot: all(&end.q_dot),
        maxima: maxima(line, &found.diagnostics),
        error_estimate: line.error_estimate,
        verdict,
        events: events.collect(),
    }))
}

/// The largest deviations, as decimals.
fn maxima<S: Real>(line: &WorldLine<S>, diagnostics: &Diagnostics<S>) -> Vec<(String, String)> {
    let Diagnostics { charges, max_delta_g, norm, energy, invariants, .. } = diagnostics;
    let names = line.geometry().names();
    let mut values: Vec<S> =
        charges.iter().flat_map(|charge| [charge.max_interior, charge.max_last, charge.max_corrected]).collect();
    values.push(*max_delta_g);
    let motion = energy.as_ref().unwrap_or(norm);
    values.extend([motion.max_interior, motion.max_ends]);
    values.extend(invariants.iter().map(|(_, invariant)| invariant.max_interior));
    values.push(line.gradient_norm);
    values.extend(line.sensitivity.iter().flat_map(|it| [it.lyapunov(), it.megno()]).map(S::from));
    let (charges, further) =
        (charges.iter().map(|charge| &names[charge.terms[0].0]), invariants.iter().map(|it| &it.0));
    let names = names_of_maxima(charges, energy.is_some(), further, line.sensitivity.is_some());
    names.into_iter().zip(values).map(|(name, value)| (name, value.to_decimal(line.digits))).collect()
}

/// The reason that ended a run, from the place of the formula that did.
fn ending(case: &Case, ended_by: Option<usize>) -> Ending {
    let own = usize::from(case.grid.until.is_some());
    let mut events = case.events.iter().filter(|event| event.until);
    match ended_by {
        None if case.grid.t_f.is_some() => Ending::Time,
        None => Ending::Gamma,
        Some(place) => match place.checked_sub(own).and_then(|place| events.nth(place)) {
            Some(event) => Ending::Event(event.name.clone()),
            None => Ending::Until,
        },
    }
}
