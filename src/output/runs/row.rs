//! A row of `runs.csv`, and what its columns are.

use super::rows::{line_of, write_line};
use crate::diagnostics::verdict::{Grade, Reason};
use crate::number::Real;
use crate::output::tables::{event_header, state_header};
use crate::solve::Status;
use crate::study::many::{End, ManyRuns};

/// A run as a row of `runs.csv` and rows of `runs-events.csv`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunRow {
    /// The number of the run, from 1.
    pub row: usize,
    /// The line of `runs.csv`.
    pub record: Vec<u8>,
    /// The lines of `runs-events.csv`.
    pub events: Vec<u8>,
    /// Its status in a word.
    pub status: String,
    /// Its verdict.
    pub verdict: Grade,
}

/// The columns of the table: those that the first valid run has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Columns {
    /// The header of `runs.csv` and, if there are events, that of `runs-events.csv`.
    pub headers: Vec<Vec<String>>,
    maxima: Vec<String>,
}

impl Columns {
    /// The columns of a table of these runs.
    pub fn new(runs: &ManyRuns) -> Self {
        let (first, maxima) = (runs.first(), End::maxima_of(runs.first()));
        let texts = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
        let state = state_header(&first.coordinates());
        let keys = runs.axes.iter().map(|axis| axis.key.clone()).collect();
        let ending = texts(&["status", "exit_code", "ended_by"]);
        let estimate = first.settings.accuracy.map(|_| "error_estimate".to_owned()).into_iter().collect();
        let proof = if first.proof == Some(true) { texts(&["proof_status", "proof_radius"]) } else { Vec::new() };
        let verdict = texts(&["verdict", "message"]);
        let row = [texts(&["row"]), keys, ending, state, maxima.clone(), estimate, proof, verdict].concat();
        let of_event = || event_header(&first.coordinates(), first.settings.is_judged_on_its_way());
        let event = (!first.events.is_empty()).then(|| [texts(&["row", "event"]), of_event()].concat());
        Self { headers: [row].into_iter().chain(event).collect(), maxima }
    }

    /// The header of `runs.csv` as a line.
    pub fn header_line(&self) -> Vec<u8> {
        line_of(self.headers[0].iter().map(String::as_str))
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
        if let Some(end) = end {
            cells.extend([&end.ended_by].into_iter().chain(&end.state).cloned());
            // A charge that only some runs have is a column if the first one has it.
            let value = |name: &String| end.maxima.iter().find(|(other, _)| other == name);
            cells.extend(self.maxima.iter().map(|name| value(name).map_or_else(String::new, |(_, v)| v.clone())));
            cells.extend(end.error_estimate.map(|estimate| estimate.to_decimal(f64::MOST_DIGITS)));
            cells.extend(end.proof.iter().flat_map(|proof| {
                let radius = proof.radius.map_or_else(String::new, |radius| radius.to_decimal(f64::MOST_DIGITS));
                [proof.status.as_str().to_owned(), radius]
            }));
        }
        // What is not there is empty, and what only this run has is not in the table.
        cells.resize(self.headers[0].len() - 2, String::new());
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
        let mut events = Vec::new();
        for (event, state) in end.map_or(&[][..], |end| &end.events) {
            write_line([&number, event].into_iter().chain(state).map(String::as_str), &mut events);
        }
        let record = line_of(cells.iter().map(String::as_str));
        RunRow { row: run + 1, record, events, status: status.to_owned(), verdict }
    }
}
