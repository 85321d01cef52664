//! A row of `runs.csv`, and what its columns are.

use super::rows::line_of;
use crate::diagnostics::verdict::{Grade, Reason};
use crate::number::Real;
use crate::output::tables::state_header;
use crate::solve::Status;
use crate::study::many::{End, Ending, ManyRuns};

/// A run as a row of `runs.csv` and rows of `runs-events.csv`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunRow {
    /// The number of the run, from 1.
    pub row: usize,
    /// The line of `runs.csv`.
    pub record: Vec<u8>,
    /// The lines of `runs-events.csv`.
    pub events: Vec<u8>,
}

/// The columns of the table: those that the first valid run has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Columns {
    keys: Vec<String>,
    coordinates: Vec<String>,
    maxima: Vec<String>,
    has_estimate: bool,
    has_events: bool,
}

impl Columns {
    /// The columns of a table of these runs.
    pub fn new(runs: &ManyRuns) -> Self {
        Self {
            keys: runs.axes.iter().map(|axis| axis.key.clone()).collect(),
            coordinates: runs.first().coordinates(),
            maxima: End::maxima_of(runs.first()),
            has_estimate: runs.first().settings.accuracy.is_some(),
            has_events: !runs.first().events.is_empty(),
        }
    }

    /// Returns true if there is a table of events.
    pub fn has_events(&self) -> bool {
        self.has_events
    }

    /// The header of `runs.csv`.
    pub fn header(&self) -> Vec<String> {
        let before = ["status", "exit_code", "ended_by"].map(str::to_owned);
        let estimate = self.has_estimate.then(|| "error_estimate".to_owned());
        let keys = std::iter::once("row".to_owned()).chain(self.keys.iter().cloned());
        let result = before.into_iter().chain(state_header(&self.coordinates)).chain(self.maxima.iter().cloned());
        keys.chain(result).chain(estimate).chain(["verdict", "message"].map(str::to_owned)).collect()
    }

    /// The headers of `runs.csv` and of `runs-events.csv`; the second is empty if there are no events.
    pub fn headers(&self) -> [Vec<String>; 2] {
        let events = ["row", "event"].map(str::to_owned).into_iter().chain(state_header(&self.coordinates));
        [self.header(), events.filter(|_| self.has_events).collect()]
    }

    /// The row of a run, which counts from 0, from its end or else the status in a word, the exit code that a single
    /// run would have, and why it has none. Cells of what it does not have are empty.
    pub fn row(&self, runs: &ManyRuns, run: usize, outcome: Result<&End, (&str, u8, &str)>) -> RunRow {
        let (status, exit_code, message) = outcome.err().unwrap_or((Status::Converged.as_str(), 0, ""));
        let end = outcome.ok();
        let number = (run + 1).to_string();
        let mut cells = vec![number.clone()];
        cells.extend(runs.values(run).into_iter().map(str::to_owned));
        cells.extend([status.to_owned(), exit_code.to_string()]);
        match end {
            Some(end) => {
                cells.push(name_of(&end.ending).to_owned());
                cells.push(end.gamma.clone());
                cells.extend(end.q.iter().chain(&end.q_dot).cloned());
                // A charge that only some runs have is a column if the first one has it.
                let value = |name: &String| end.maxima.iter().find(|(other, _)| other == name);
                cells.extend(self.maxima.iter().map(|name| value(name).map_or_else(String::new, |(_, v)| v.clone())));
            }
            None => cells.extend(vec![String::new(); 2 + 2 * self.coordinates.len() + self.maxima.len()]),
        }
        if self.has_estimate {
            let estimate = end.and_then(|end| end.error_estimate);
            cells.push(estimate.map_or_else(String::new, |estimate| estimate.to_decimal(f64::MOST_DIGITS)));
        }
        let (verdict, message) = match end {
            Some(End { verdict, .. }) => {
                let reasons: Vec<String> = verdict.reasons.iter().map(Reason::to_string).collect();
                (verdict.grade, reasons.join("; "))
            }
            None => (Grade::Refused, message.to_owned()),
        };
        cells.push(verdict.as_str().to_owned());
        // A row is one line.
        cells.push(message.split_whitespace().collect::<Vec<_>>().join(" "));
        let line = |cells: &[String]| line_of(cells.iter().map(String::as_str));
        let events = end.map_or(&[][..], |end| &end.events).iter();
        let events = events.map(|found| [&[number.clone(), found.event.clone()][..], &found.state].concat());
        RunRow { row: run + 1, record: line(&cells), events: events.flat_map(|cells| line(&cells)).collect() }
    }
}

/// The word in the column `ended_by`.
fn name_of(ending: &Ending) -> &str {
    match ending {
        Ending::Gamma => "gamma_f",
        Ending::Time => "t_f",
        Ending::Until => "until",
        Ending::Event(name) => name,
    }
}
