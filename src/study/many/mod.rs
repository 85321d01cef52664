//! Many runs of one case: keys that take values, the product of these, and one result for each.
//!
//! A run is the case with one override more for each varied key, `KEY=VALUE` with the value as [`Axis`] has it. It is
//! therefore the same as a single run with these overrides.
//!
//! ```
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::study::many::ManyRuns;
//!
//! let axes = ["initial.x=0.5:1:3".parse()?, "scheme.sbp=SBP21,SBP42".parse()?];
//! let text = builtin::text("quartic").expect("it is built in");
//! let runs = ManyRuns::new("quartic", text, &[], axes.to_vec()).map_err(|error| error.to_string())?;
//! assert_eq!(runs.len(), 6);
//! assert_eq!(runs.values(3), ["0.75", "SBP42"]);
//! let case = runs.case(3).map_err(|error| error.to_string())?;
//! let end = runs.outcome(&case).map_err(|failure| failure.to_string())?;
//! assert_eq!(end.state.len(), 5);
//! # Ok::<(), String>(())
//! ```

mod axis;

pub use axis::Axis;

use rayon::prelude::*;

use crate::case::{Case, CaseError};
use crate::diagnostics::Diagnostics;
use crate::diagnostics::verdict::Verdict;
use crate::engine::Sensitivity;
use crate::geometry::Geometry;
use crate::number::{Extended, Real};
use crate::solve::{NoSolution, WorldLine};
use crate::study::proof::{Hull, ProofOfRun, hull, prove_run};
use crate::study::run::{NoRun, Run, Wanted, run};
use crate::study::sampling::Sampling;
use crate::trajectory::{Crossing, NoSamples, OutsideRun};

/// More runs than this are taken for a typing mistake.
const MOST_RUNS: usize = 10_000_000;

/// A case with keys that vary.
#[derive(Debug, Clone)]
pub struct ManyRuns {
    name: String,
    text: String,
    overrides: Vec<String>,
    /// The keys that vary.
    pub axes: Vec<Axis>,
    /// Where samples of each are wanted, if any are.
    pub samples: Option<Sampling>,
    first: Option<Case>,
}

impl ManyRuns {
    /// The runs of the case `text`, changed by `overrides` and then by every combination of the values of `axes`.
    ///
    /// # Errors
    /// [`CaseError`] of the first run, if no run at all is a valid case, or if there are more than ten million.
    pub fn new(name: &str, text: &str, overrides: &[String], axes: Vec<Axis>) -> Result<Self, CaseError> {
        let count = axes.iter().map(|axis| axis.values.len()).try_fold(1, usize::checked_mul);
        if count.is_none_or(|runs| runs > MOST_RUNS) {
            let runs = count.map_or_else(|| "too many".to_owned(), |runs| runs.to_string());
            let message = format!("{runs} runs: a table has at most {MOST_RUNS}");
            return Err(CaseError::without_place("command line", message));
        }
        let (name, text, overrides) = (name.to_owned(), text.to_owned(), overrides.to_vec());
        let runs = Self { name, text, overrides, axes, samples: None, first: None };
        let first = runs.case(0).or_else(|error| {
            let others = (1..runs.len()).into_par_iter();
            others.find_map_first(|run| runs.case(run).ok()).ok_or(error)
        })?;
        Ok(Self { first: Some(first), ..runs })
    }

    /// The same runs with samples of each.
    #[must_use]
    pub fn with_samples(self, samples: Option<Sampling>) -> Self {
        Self { samples, ..self }
    }

    /// The number of runs.
    #[allow(clippy::len_without_is_empty, reason = "there is always one that is valid")]
    pub fn len(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    /// The case of the first run that is valid.
    pub fn first(&self) -> &Case {
        self.first.as_ref().expect("one run is valid")
    }

    /// The values of the keys in a run, which counts from 0. The last key varies fastest.
    pub fn values(&self, mut run: usize) -> Vec<&str> {
        let mut values: Vec<&str> = Vec::with_capacity(self.axes.len());
        for axis in self.axes.iter().rev() {
            let count = axis.values.len();
            values.push(&axis.values[run % count]);
            run /= count;
        }
        values.reverse();
        values
    }

    /// The case of a run.
    ///
    /// # Errors
    /// [`CaseError`] if the values make it invalid, or give it other coordinates than the first valid run has: a table
    /// has one set of columns.
    pub fn case(&self, run: usize) -> Result<Case, CaseError> {
        let varied = self.axes.iter().zip(self.values(run)).map(|(axis, value)| format!("{}={value}", axis.key));
        let all: Vec<String> = self.overrides.iter().cloned().chain(varied).collect();
        let case = Case::parse_beside(&self.name, &self.text, &all, self.first.as_ref())?;
        let Some(first) = self.first.as_ref().map(Case::coordinates).filter(|first| *first != case.coordinates())
        else {
            return Ok(case);
        };
        let [here, first] = [case.coordinates(), first].map(|names| names.join(", "));
        let message = format!("its coordinates are {here}, and those of the table are {first}");
        Err(CaseError::without_place(&self.name, message))
    }

    /// The content of the files that the cases are read from besides their text. Of keys that vary, tables and
    /// `initial.from` name such files: all their values count, each with the first one of other keys.
    pub fn contents(&self) -> Vec<String> {
        let mut contents = self.first().contents();
        let mut count = 1;
        for axis in self.axes.iter().rev() {
            if axis.key.starts_with("tables") || axis.key == "initial.from" {
                let cases = (0..axis.values.len()).filter_map(|value| self.case(value * count).ok());
                contents.extend(cases.flat_map(|case| case.contents()));
            }
            count *= axis.values.len();
        }
        contents.sort();
        contents.dedup();
        contents
    }

    /// Solves the case of a run.
    ///
    /// # Errors
    /// [`NoSolution`] if it is not at a critical point.
    pub fn outcome(&self, case: &Case) -> Result<End, NoSolution> {
        match case.settings.is_extended() {
            true => outcome::<Extended>(case, self.samples.as_ref()),
            false => outcome::<f64>(case, self.samples.as_ref()),
        }
    }
}

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
    /// The proof of it, if one was asked for.
    pub proof: Option<ProofOfRun>,
    /// Where all motions from the intervals of the case end, if it has such.
    pub hull: Option<Hull>,
    /// The verdict on the result.
    pub verdict: Verdict,
    /// The events of the case, in the order of γ: the name, then the state and its errors, if these are columns.
    pub events: Vec<(String, Vec<String>)>,
    /// The digits of its numbers.
    pub digits: u32,
    /// The states at the samples that lie in the run, each as a line with commas between its numbers.
    pub samples: Vec<String>,
    /// Why others are missing, if some are.
    pub unsampled: Option<String>,
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
fn outcome<S: Real>(case: &Case, samples: Option<&Sampling>) -> Result<End, NoSolution> {
    let setup = case.setup::<S>();
    let stream = samples.and_then(|samples| samples.stream(case));
    let found = match run(case, &setup, Wanted { samples: stream, takes_part: true, ..Wanted::default() }).0 {
        Ok(found) => found,
        Err(NoRun::Unsolved(failure, _)) => return Err(failure),
        Err(NoRun::Unsampled(_)) => unreachable!("samples of a row may be missing"),
    };
    let (line, mut judged) = (&found.line, found.judged(&setup, false, false));
    if case.proof == Some(true) {
        prove_run(case, &found, &mut judged, f64::INFINITY, &mut |_| true);
    }
    let state = |gamma: S, q: &[S], q_dot: &[S]| -> Vec<String> {
        std::iter::once(&gamma).chain(q).chain(q_dot).map(|value| value.to_decimal(line.digits)).collect()
    };
    let cells = |event: &Crossing<S>| event.cells(line.digits, setup.settings.is_judged_on_its_way());
    let events = found.events.iter().map(|event| (case.events[event.watch].name.clone(), cells(event)));
    let end = line.end();
    Ok(End {
        ended_by: ended_by(case, line.ended_by).to_owned(),
        state: state(line.gamma_f(), &end.q, &end.q_dot),
        maxima: maxima(case, line, &found.diagnostics),
        error_estimate: line.error_estimate,
        proof: judged.proof,
        hull: case.has_hull().then(|| hull(case, &mut |_| true)),
        verdict: judged.verdict,
        events: events.collect(),
        digits: line.digits,
        samples: found.samples.iter().map(|at| state(at.gamma, &at.q, &at.q_dot).join(",")).collect(),
        unsampled: samples.and_then(|samples| unsampled(&found, samples.count())),
    })
}

/// Why not all of so many samples are there, if some are missing.
fn unsampled<S: Real>(run: &Run<S>, count: usize) -> Option<String> {
    match run.unsampled? {
        NoSamples::Turns => Some("no samples: t does not grow, or fall, all the way".to_owned()),
        NoSamples::Outside(OutsideRun { range: (from, to) }) => {
            let [from, to] = [from, to].map(|end| end.to_decimal(run.line.digits));
            let missing = count - run.samples.len();
            Some(format!("{missing} of {count} samples are not in the run, which covers {from} to {to}"))
        }
    }
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
    let growth = line.sensitivity.iter().map(Sensitivity::growth);
    values.extend(growth.flat_map(|growth| [growth.lyapunov, growth.megno]).map(S::from));
    End::maxima_of(case).into_iter().zip(values).map(|(name, value)| (name, value.to_decimal(line.digits))).collect()
}

/// The word for what ended a run, from the place of the formula that did.
fn ended_by(case: &Case, ended_by: Option<usize>) -> &str {
    match ended_by {
        None if case.grid.t_f.is_some() => "t_f",
        None => "gamma_f",
        Some(place) => {
            let event = case.watched_formulas().nth(place).and_then(|formula| formula.event);
            event.map_or("until", |event| case.events[event].name.as_str())
        }
    }
}
