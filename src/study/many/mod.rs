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
mod end;

pub use axis::Axis;
pub use end::End;

use rayon::prelude::*;

use crate::case::{Case, CaseError};
use crate::number::Extended;
use crate::solve::NoSolution;

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
        let runs = Self { name, text, overrides, axes, first: None };
        let first = runs.case(0).or_else(|error| {
            let others = (1..runs.len()).into_par_iter();
            others.find_map_first(|run| runs.case(run).ok()).ok_or(error)
        })?;
        Ok(Self { first: Some(first), ..runs })
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
        let case = Case::parse(&self.name, &self.text, &all)?;
        let Some(first) = self.first.as_ref().map(Case::coordinates).filter(|first| *first != case.coordinates())
        else {
            return Ok(case);
        };
        let [here, first] = [case.coordinates(), first].map(|names| names.join(", "));
        let message = format!("its coordinates are {here}, and those of the table are {first}");
        Err(CaseError::without_place(&self.name, message))
    }

    /// Solves the case of a run.
    ///
    /// # Errors
    /// [`NoSolution`] if it is not at a critical point.
    pub fn outcome(&self, case: &Case) -> Result<End, NoSolution> {
        if case.settings.is_extended() { end::outcome::<Extended>(case) } else { end::outcome::<f64>(case) }
    }
}
