//! The search as a system of equations: a run for each set of values of the unknowns, and by how much it misses.

use super::states::{Ends, Gradient, Residuals, ends};
use crate::case::{Case, CaseError, Data, Find, Goal};
use crate::number::norm::larger;
use crate::number::{Extended, Real};
use crate::solve::{Setup, Status};
use crate::study::run::{Judged, NoRun, Run, Wanted, run};
use crate::study::sampling::stream;
use crate::trajectory::{NoSamples, OutsideRun};

/// A case whose unknowns are to be found.
#[derive(Debug)]
pub(super) struct Problem {
    /// The text of the case without what is to be found.
    pub(super) text: String,
    /// The case, whose formulas are compiled.
    given: Case,
    /// What is to be found, and what has to be met.
    pub(super) find: Find,
    /// The size of each unknown: its value in the case, or 1 where that is 0.
    pub(super) scales: Vec<f64>,
    /// True if runs carry the linearised equations.
    has_sensitivity: bool,
    /// True if derivatives come from these: the end of the run is where the case says, and not where a formula does.
    pub(super) is_linearised: bool,
}

/// A run with these values, and by how much it misses.
#[derive(Debug)]
pub(super) struct Evaluation {
    pub(super) values: Vec<f64>,
    pub(super) case: Case,
    pub(super) run: Run,
    /// The residuals, and by how much the errors of the run may have changed each.
    pub(super) residuals: Vec<f64>,
    pub(super) errors: Vec<f64>,
    /// The ends of the run with the gradients of the residuals there, if residuals depend on these alone.
    pub(super) at_ends: Option<(Ends, Vec<Gradient>)>,
    /// The error of the run, relative to the sizes of coordinates: what its numbers may jump by.
    pub(super) noise: f64,
}

/// The reason why there is no run with some values of the unknowns, or no use of it.
#[derive(Debug, Clone)]
pub(super) struct NoValue {
    pub(super) message: String,
    pub(super) advice: &'static str,
    /// True if the run leaves the domain.
    pub(super) is_outside: bool,
}

impl From<CaseError> for NoValue {
    fn from(error: CaseError) -> Self {
        Self::new(error.message)
    }
}

impl NoValue {
    fn new(message: impl Into<String>) -> Self {
        let advice = "begin with other numbers, or nearer to what is to be found";
        Self { message: message.into(), advice, is_outside: false }
    }

    /// No residual depends on this unknown.
    pub(super) fn independent(key: &str) -> Self {
        let advice = "take it out of find.unknowns, or meet something that depends on it";
        Self { advice, ..Self::new(format!("what is to be met does not depend on {key}")) }
    }
}

impl Problem {
    /// The problem of a case that has something to find.
    pub(super) fn new(case: &Case, find: &Find) -> Self {
        let ends_early = case.grid.until.is_some() || case.events.iter().any(|event| event.until);
        let is_carried = case.settings.accuracy.is_some() && !case.has_acting_events();
        let has_sensitivity = is_carried && !matches!(find.goal, Goal::Data(_));
        let size = |value: f64| if value == 0.0 { 1.0 } else { value.abs() };
        Self {
            text: case.text_of_run(),
            given: case.clone(),
            scales: find.unknowns.iter().map(|unknown| size(unknown.value)).collect(),
            has_sensitivity,
            is_linearised: has_sensitivity && !ends_early,
            find: find.clone(),
        }
    }

    /// The same where the last unknown is a number in which a family is followed, from these values on over a range.
    pub(super) fn followed(case: &Case, find: &Find, values: &[f64], range: f64) -> Self {
        let mut problem = Self::new(case, find);
        problem.scales = values.iter().map(|value| if *value == 0.0 { 1.0 } else { value.abs() }).collect();
        problem.scales.pop();
        problem.scales.push(range);
        problem
    }

    /// True if the least sum of squares is asked for, and not residuals of 0: of data, or of more formulas than there
    /// are unknowns.
    pub(super) fn is_least_squares(&self) -> bool {
        match &self.find.goal {
            Goal::Meet(conditions) => conditions.len() > self.scales.len(),
            Goal::Periodic => false,
            Goal::Data(_) => true,
        }
    }

    /// The case with these values, as decimals, of the unknowns.
    pub(super) fn case(&self, values: &[String], with_sensitivity: bool) -> Result<Case, CaseError> {
        let keys = self.find.unknowns.iter().map(|unknown| &unknown.key);
        let mut set: Vec<String> = keys.zip(values).map(|(key, value)| format!("{key}={value}")).collect();
        if with_sensitivity {
            set.push("solver.sensitivity=true".to_owned());
        }
        Case::parse_beside("the case", &self.text, &set, Some(&self.given))
    }

    /// Runs the case with these values.
    pub(super) fn evaluate(&self, values: &[f64], with_sensitivity: bool) -> Result<Evaluation, NoValue> {
        if values.iter().any(|value| !value.is_finite()) {
            return Err(NoValue::new("an unknown is no finite number"));
        }
        let decimals: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
        let case = self.case(&decimals, with_sensitivity && self.has_sensitivity)?;
        let setup: Setup = case.setup();
        let samples = match &self.find.goal {
            Goal::Data(data) => Some(stream(&case, data.by, data.places.clone())),
            _ => None,
        };
        let run = run(&case, &setup, Wanted { samples, ..Wanted::default() }).0.map_err(unsolved)?;
        let judged = run.judged(&setup, false, false);
        let unknown = || NoValue::new("the error of a run is not known: no second solve reaches its end");
        let noise = larger(judged.verdict.error.ok_or_else(unknown)?, f64::EPSILON);
        let values = values.to_vec();
        let (residuals, errors, at_ends) = match &self.find.goal {
            Goal::Data(data) => {
                let (residuals, errors) = of_data(data, &run, &judged).ok_or_else(unknown)?;
                (residuals, errors, None)
            }
            goal => {
                let outside = || NoValue::new("what is to be met has no value at the end of a run");
                let states = Residuals::new(&case, goal).expect("it depends on the ends");
                let ends = ends(&run);
                let residuals = states.at(&ends).ok_or_else(outside)?;
                let gradients = states.gradients(&ends).ok_or_else(outside)?;
                let errors = errors(&gradients, &ends, &judged).ok_or_else(unknown)?;
                (residuals.iter().map(|residual| residual.to_f64()).collect(), errors, Some((ends, gradients)))
            }
        };
        if residuals.iter().chain(&errors).any(|number| !number.is_finite()) {
            return Err(NoValue::new("what is to be met has no finite value at the end of a run"));
        }
        Ok(Evaluation { values, case, run, residuals, errors, at_ends, noise })
    }
}

/// By how much the errors of a run may change residuals with these gradients, and rounding of both ends.
fn errors(gradients: &[Gradient], ends: &Ends, judged: &Judged) -> Option<Vec<f64>> {
    let left = judged.left.as_ref()?;
    let weighted = |gradient: &[f64], off: &[f64]| -> f64 {
        gradient.iter().zip(off).filter(|(g, _)| **g != 0.0).map(|(g, off)| (g * off).abs()).sum()
    };
    let rounding = |gradient: &Gradient| -> f64 {
        let of_state = |(end, [q, p]): (usize, &[Vec<f64>; 2])| {
            let part = |gradient: &[f64], values: &[Extended]| -> f64 {
                gradient.iter().zip(values).map(|(g, value)| (g * value.to_f64()).abs()).sum()
            };
            part(q, &ends[end].q) + part(p, &ends[end].p)
        };
        f64::EPSILON * gradient.iter().enumerate().map(of_state).sum::<f64>()
    };
    let of_run = |gradient: &Gradient| weighted(&gradient[1][0], &left.q) + weighted(&gradient[1][1], &left.p);
    Some(gradients.iter().map(|gradient| of_run(gradient) + rounding(gradient)).collect())
}

/// By how many standard deviations the samples of a run differ from the data, coordinate by coordinate, and what its
/// errors make of that.
fn of_data(data: &Data, run: &Run, judged: &Judged) -> Option<(Vec<f64>, Vec<f64>)> {
    let most = judged.error.as_ref()?.at_most();
    let (mut residuals, mut errors) = (Vec::new(), Vec::new());
    for series in &data.series {
        for (k, (sample, value)) in run.samples.iter().zip(&series.values).enumerate() {
            let (a, sigma) = (series.coordinate, series.sigmas.as_ref().map_or(1.0, |sigmas| sigmas[k]));
            residuals.push((sample.q[a] - value) / sigma);
            errors.push((most.get(a).copied()? + f64::EPSILON * sample.q[a].abs()) / sigma);
        }
    }
    Some((residuals, errors))
}

fn unsolved(none: NoRun<f64>) -> NoValue {
    match none {
        NoRun::Unsolved(failure, _) => {
            let is_outside = failure.status == Status::OutsideDomain;
            NoValue { is_outside, ..NoValue::new(failure.to_string()) }
        }
        NoRun::Unsampled(NoSamples::Outside(OutsideRun { range: (from, to) })) => {
            NoValue::new(format!("the run covers {from} to {to}, and not all of the data"))
        }
        NoRun::Unsampled(NoSamples::Turns) => {
            NoValue::new("t does not grow, or fall, all the way: give the data by gamma")
        }
    }
}
