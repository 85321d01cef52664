//! What a run of many leaves: where it ended, and the largest deviations on the way.

use crate::case::{AnyCase, Case, SceneCase};
use crate::diagnostics::Diagnostics;
use crate::diagnostics::verdict::Verdict;
use crate::geometry::Geometry;
use crate::number::Real;
use crate::number::norm::max_abs;
use crate::solve::Arithmetic;
use crate::solve::{Setup, Solution, Status, WorldLine, solve};
use crate::study::errors::run_error;
use crate::study::verdict::{of_solution, of_world_line};
use crate::trajectory::crossings;

/// How a run ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// At a critical point.
    Solved(Box<End>),
    /// Without one.
    Failed {
        /// How the solve ended.
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
    /// Largest deviations on the way, with their names: those of [`maxima_of`](End::maxima_of).
    pub maxima: Vec<(String, String)>,
    /// The estimated error, if an accuracy was asked for.
    pub error_estimate: Option<f64>,
    /// How far the result is to be believed.
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
    /// The names of the largest deviations that a run of `case` has.
    pub fn maxima_of(case: &AnyCase) -> Vec<String> {
        match case {
            AnyCase::One(_) => names_of_maxima(&["t"], false, &[]),
            AnyCase::Scene(case) => {
                let geometry: Geometry = case.geometry();
                let charges: Vec<&str> = geometry.ignorable().map(|a| geometry.names()[a].as_str()).collect();
                let invariants: Vec<&str> = case.invariants().iter().map(|(name, _)| name.as_str()).collect();
                names_of_maxima(&charges, case.is_lifted(), &invariants)
            }
        }
    }
}

/// The names of deviations: those of the charges, of the equations, of K or the energy, of invariants. They are the
/// keys of `summary.json`, those of a charge with its coordinate.
fn names_of_maxima(charges: &[&str], is_lifted: bool, invariants: &[&str]) -> Vec<String> {
    let of_charge = |name: &&str| ["interior", "last", "corrected"].map(|at| format!("max_abs_delta_q_{name}_{at}"));
    let k = if is_lifted { "energy" } else { "k" };
    let mut names: Vec<String> = charges.iter().flat_map(of_charge).collect();
    names.push("max_abs_delta_g_interior".to_owned());
    names.extend(["", "_ends"].map(|at| format!("max_abs_delta_{k}{at}")));
    names.extend(invariants.iter().map(|name| format!("max_abs_delta_{name}")));
    names.push("gradient_norm".to_owned());
    names
}

/// Solves a case of one coordinate.
pub(super) fn of_one<S: Arithmetic>(case: &Case) -> Outcome {
    let setup = Setup::from(case);
    let solution: Solution<S> = match solve(&setup) {
        Ok(solution) => solution,
        Err(failure) => return Outcome::Failed { status: failure.status, message: failure.to_string() },
    };
    let diagnostics = Diagnostics::new(&solution);
    let decimal = |value: S| value.to_decimal(solution.digits);
    let end = solution.end_state();
    let t_dot = solution.end().q_dot[0];
    Outcome::Solved(Box::new(End {
        ending: if case.grid.t_f.is_some() { Ending::Time } else { Ending::Gamma },
        gamma: decimal(solution.gamma_f()),
        q: [end.t, end.x].map(decimal).to_vec(),
        q_dot: [t_dot, end.x_dot].map(decimal).to_vec(),
        maxima: maxima(&solution, &diagnostics, None),
        error_estimate: solution.error_estimate,
        verdict: of_solution(&solution, &diagnostics.measures, run_error(&setup, &solution, &[]).as_ref()),
        events: Vec::new(),
    }))
}

/// Solves a scene.
pub(super) fn of_scene<S: Arithmetic>(case: &SceneCase) -> Outcome {
    let setup = case.setup();
    let line: WorldLine<S> = match solve(&setup) {
        Ok(line) => line,
        Err(failure) => return Outcome::Failed { status: failure.status, message: failure.to_string() },
    };
    let diagnostics = Diagnostics::of_scene(&line, &[], &mut case.observables(), case.is_lifted());
    let decimal = |value: S| value.to_decimal(line.digits);
    let all = |values: &[S]| values.iter().map(|&value| decimal(value)).collect::<Vec<_>>();
    let end = line.end();
    let found = crossings(&line, &mut case.watches()).into_iter().map(|crossing| {
        let sample = crossing.sample;
        let state = [&[sample.gamma][..], &sample.q, &sample.q_dot].concat();
        Found { event: case.events()[crossing.watch].name.clone(), state: all(&state) }
    });
    let error = run_error(&setup, &line, &[]);
    Outcome::Solved(Box::new(End {
        ending: ending(case, line.ended_by),
        gamma: decimal(line.gamma_f()),
        q: all(&end.q),
        q_dot: all(&end.q_dot),
        maxima: maxima(&line, &diagnostics, diagnostics.measures.energy.map(|energy| energy.max_ends)),
        error_estimate: line.error_estimate,
        verdict: of_world_line(&line, &diagnostics, error.as_ref(), None),
        events: found.collect(),
    }))
}

/// The largest deviations, as decimals. `energy` is that of the energy at the ends of windows, if there is one.
fn maxima<S: Real, M>(
    line: &WorldLine<S>,
    diagnostics: &Diagnostics<S, M>,
    energy: Option<S>,
) -> Vec<(String, String)> {
    let Diagnostics { charges, max_delta_g, norm, delta_energy, invariants, .. } = diagnostics;
    let names = line.geometry().names();
    let mut values: Vec<S> =
        charges.iter().flat_map(|charge| [charge.max_interior, charge.max_last, charge.max_corrected]).collect();
    values.push(*max_delta_g);
    values.extend(match (delta_energy, energy) {
        (Some(delta), Some(ends)) => [max_abs(delta), ends],
        _ => [norm.max_interior, norm.max_ends],
    });
    values.extend(invariants.iter().map(|invariant| max_abs(&invariant.delta)));
    values.push(line.gradient_norm);
    let charges: Vec<&str> = charges.iter().map(|charge| names[charge.terms[0].0].as_str()).collect();
    let further: Vec<&str> = invariants.iter().map(|invariant| invariant.name.as_str()).collect();
    let names = names_of_maxima(&charges, energy.is_some(), &further).into_iter();
    names.zip(values).map(|(name, value)| (name, value.to_decimal(line.digits))).collect()
}

/// What ended a run, from the place of the formula that did.
fn ending(case: &SceneCase, ended_by: Option<usize>) -> Ending {
    let own = usize::from(case.until().is_some());
    let mut events = case.events().iter().filter(|event| event.until);
    match ended_by {
        None if case.grid().t_f.is_some() => Ending::Time,
        None => Ending::Gamma,
        Some(place) => match place.checked_sub(own).and_then(|place| events.nth(place)) {
            Some(event) => Ending::Event(event.name.clone()),
            None => Ending::Until,
        },
    }
}
