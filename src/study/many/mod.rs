//! Many runs of one case: keys that take values, the product of these, and one result for each.
//!
//! A run is the case with one override more for each varied key, `KEY=VALUE` with the value as [`Axis`] has it. It is
//! therefore the same as a single run with these overrides.
//!
//! ```
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::study::many::{ManyRuns, Outcome};
//!
//! let axes = ["initial.x=0.5:1:3".parse()?, "scheme.sbp=SBP21,SBP42".parse()?];
//! let text = builtin::text("quartic").expect("it is built in");
//! let runs = ManyRuns::new("quartic", text, &[], axes.to_vec()).map_err(|error| error.to_string())?;
//! assert_eq!(runs.len(), 6);
//! assert_eq!(runs.values(3), ["0.75", "SBP42"]);
//! let case = runs.case(3).map_err(|error| error.to_string())?;
//! let Outcome::Solved(end) = runs.outcome(&case) else { panic!("it has a solution") };
//! assert_eq!(end.q.len(), 2);
//! # Ok::<(), String>(())
//! ```

mod axis;
mod end;

pub use axis::Axis;
pub use end::{End, Ending, Found, Outcome};

use rayon::prelude::*;

use crate::case::{Case, CaseError};
use crate::number::Extended;

/// More runs than this are taken for a typing mistake.
const MOST_RUNS: usize = 10_000_000;

/// A case with keys that vary.
#[derive(Debug, Clone)]
pub struct ManyRuns {
    name: String,
    text: String,
    overrides: Vec<String>,
    axes: Vec<Axis>,
    first: Case,
}

impl ManyRuns {
    /// The runs of the case `text`, changed by `overrides` and then by every combination of the values of `axes`.
    ///
    /// # Errors
    /// [`CaseError`] of the first run, if no run at all is a valid case, or if there are more than ten million.
    pub fn new(name: &str, text: &str, overrides: &[String], axes: Vec<Axis>) -> Result<Self, CaseError> {
        let runs = axes.iter().map(|axis| axis.values.len()).try_fold(1, usize::checked_mul);
        if runs.is_none_or(|runs| runs > MOST_RUNS) {
            let runs = runs.map_or_else(|| "too many".to_owned(), |runs| runs.to_string());
            let message = format!("{runs} runs: a table has at most {MOST_RUNS}");
            return Err(CaseError::without_place("command line", message));
        }
        let at = |run| parse(name, text, overrides, &axes, run);
        let first = at(0).or_else(|error| {
            let others = (1..product(&axes)).into_par_iter();
            others.find_map_first(|run| at(run).ok()).ok_or(error)
        })?;
        Ok(Self { name: name.to_owned(), text: text.to_owned(), overrides: overrides.to_vec(), axes, first })
    }

    /// The number of runs.
    #[allow(clippy::len_without_is_empty, reason = "there is always one that is valid")]
    pub fn len(&self) -> usize {
        product(&self.axes)
    }

    /// The keys that vary.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// The case of the first run that is valid.
    pub fn first(&self) -> &Case {
        &self.first
    }

    /// The values of the keys in a run, which counts from 0. The last key varies fastest.
    pub fn values(&self, run: usize) -> Vec<&str> {
        values(&self.axes, run)
    }

    /// The case of a run.
    ///
    /// # Errors
    /// [`CaseError`] if the values make it invalid, or give it other coordinates than the first valid run has: a table
    /// has one set of columns.
    pub fn case(&self, run: usize) -> Result<Case, CaseError> {
        let case = parse(&self.name, &self.text, &self.overrides, &self.axes, run)?;
        let [here, first] = [&case, &self.first].map(Case::coordinates);
        if here == first {
            return Ok(case);
        }
        let [here, first] = [here, first].map(|names| names.join(", "));
        let message = format!("its coordinates are {here}, and those of the table are {first}");
        Err(CaseError::without_place(&self.name, message))
    }

    /// Solves the case of a run.
    pub fn outcome(&self, case: &Case) -> Outcome {
        if case.settings.is_extended() { end::outcome::<Extended>(case) } else { end::outcome::<f64>(case) }
    }
}

fn product(axes: &[Axis]) -> usize {
    axes.iter().map(|axis| axis.values.len()).product()
}

fn values(axes: &[Axis], mut run: usize) -> Vec<&str> {
    let mut values: Vec<&str> = Vec::with_capacity(axes.len());
    for axis in axes.iter().rev() {
        let count = axis.values.len();
        values.push(&axis.values[run % count]);
        run /= count;
    }
    values.reverse();
    values
}

fn parse(name: &str, text: &str, overrides: &[String], axes: &[Axis], run: usize) -> Result<Case, CaseError> {
    let varied = axes.iter().zip(values(axes, run)).map(|(axis, value)| format!("{}={value}", axis.key));
    let all: Vec<String> = overrides.iter().cloned().chain(varied).collect();
    Case::parse(name, text, &all)
}
