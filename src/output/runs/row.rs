//! A row of `runs.csv`, and what its columns are.

use super::rows::{line_of, write_line};
use super::{RUNS, RUNS_EVENTS, RUNS_SAMPLES};
use crate::diagnostics::verdict::{Grade, Reason};
use crate::number::{Extended, Real};
use crate::output::hull::hull_header;
use crate::output::tables::{event_header, radius_cells, radius_of, state_header};
use crate::solve::Status;
use crate::study::many::{End, ManyRuns};

/// A run as a row of `runs.csv` and rows of the other tables.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunRow {
    /// The number of the run, from 1.
    pub row: usize,
    /// Its lines in each of the tables.
    pub records: Vec<Vec<u8>>,
    /// Its status in a word.
    pub status: String,
    /// Its verdict.
    pub verdict: Grade,
}

/// A table of many runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RowTable {
    /// Its file.
    pub name: &'static str,
    /// Its columns.
    pub header: Vec<String>,
}

/// The columns of the tables: those that the first valid run has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Columns {
    /// `runs.csv` and, if there are such, the tables of events and of samples.
    pub tables: Vec<RowTable>,
    maxima: Vec<String>,
    /// The coordinates whose ends from intervals are columns.
    spread: Vec<String>,
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
        let many = if first.has_hull() { first.geometry::<f64>().results() } else { 0 };
        let spread: Vec<String> = first.coordinates().into_iter().take(many).collect();
        let hull = hull_header(&spread).collect();
        let verdict = texts(&["verdict", "message"]);
        let row = [texts(&["row"]), keys, ending, state, maxima.clone(), estimate, proof, hull, verdict].concat();
        let of_event = || event_header(&first.coordinates(), first.settings.is_judged_on_its_way());
        let event = (!first.events.is_empty()).then(|| [texts(&["row", "event"]), of_event()].concat());
        let radii = first.coordinates().into_iter().filter(|_| first.proof == Some(true));
        let radii: Vec<String> = radii.map(|name| radius_of(&name)).collect();
        let of_sample = || [texts(&["row"]), state_header(&first.coordinates()), radii].concat();
        let sample = runs.samples.is_some().then(of_sample);
        let all = [(RUNS, Some(row)), (RUNS_EVENTS, event), (RUNS_SAMPLES, sample)];
        let tables = all.into_iter().filter_map(|(name, header)| Some(RowTable { name, header: header? }));
        Self { tables: tables.collect(), maxima, spread }
    }

    /// The cells of the ends of these coordinates.
    fn of_hull(&self, ends: &[(String, [f64; 2])]) -> impl Iterator<Item = String> {
        let of = |name: &String| ends.iter().find(|(other, _)| other == name).map_or([f64::NAN; 2], |(_, ends)| *ends);
        self.spread.iter().flat_map(move |name| of(name).map(|end| end.to_decimal(f64::MOST_DIGITS)))
    }

    /// The columns of `runs.csv`.
    pub fn header(&self) -> &[String] {
        &self.tables[0].header
    }

    /// The columns between which that of a coordinate lies for all starts and parameters, if it has such.
    pub fn ends_of(&self, column: &str) -> Option<[String; 2]> {
        let name = self.spread.iter().find(|name| *name == column)?;
        hull_header(std::slice::from_ref(name)).collect::<Vec<_>>().try_into().ok()
    }

    /// These as a line.
    pub fn header_line(&self) -> Vec<u8> {
        line_of(self.header().iter().map(String::as_str))
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
            let ends = end.hull.as_ref().and_then(|hull| hull.ends.as_ref().ok());
            cells.extend(ends.into_iter().flat_map(|ends| self.of_hull(ends)));
        }
        // What is not there is empty, and what only this run has is not in the table.
        cells.resize(self.header().len() - 2, String::new());
        let (verdict, message) = match end {
            Some(End { verdict, unsampled, hull, .. }) => {
                let unknown = hull.as_ref().and_then(|hull| hull.ends.as_ref().err());
                let unknown = unknown.map(|reason| format!("the ends from the intervals are not proved: {reason}"));
                let reasons = verdict.reasons.iter().map(Reason::to_string).chain(unsampled.clone()).chain(unknown);
                (verdict.grade, reasons.collect::<Vec<_>>().join("; "))
            }
            None => (Grade::Refused, message.to_owned()),
        };
        cells.push(verdict.as_str().to_owned());
        // A row is one line.
        cells.push(message.split_whitespace().collect::<Vec<_>>().join(" "));
        let row = line_of(cells.iter().map(String::as_str));
        let records = self.tables.iter().map(|table| match table.name {
            RUNS => row.clone(),
            RUNS_EVENTS => end.map_or_else(Vec::new, |end| events(&number, end)),
            _ => end.map_or_else(Vec::new, |end| samples(&number, end, &table.header)),
        });
        RunRow { row: run + 1, records: records.collect(), status: status.to_owned(), verdict }
    }
}

/// The lines of the events of a run with this number.
fn events(number: &str, end: &End) -> Vec<u8> {
    let mut lines = Vec::new();
    for (event, state) in &end.events {
        write_line([number, event].into_iter().chain(state.iter().map(String::as_str)), &mut lines);
    }
    lines
}

/// The lines of its samples. Decimals need no quotes.
fn samples(number: &str, end: &End, header: &[String]) -> Vec<u8> {
    let proved = end.proof.as_ref().map_or(&[][..], |proof| &proof.samples);
    let mut lines = Vec::new();
    for (k, state) in end.samples.iter().enumerate() {
        let radii = header.len() - 1 - state.split(',').count();
        let radii: Vec<String> = match end.digits > f64::MOST_DIGITS {
            true => radius_cells::<Extended>(proved.get(k), radii, end.digits).collect(),
            false => radius_cells::<f64>(proved.get(k), radii, end.digits).collect(),
        };
        let cells = [&[number.to_owned(), state.clone()], &radii[..]].concat();
        lines.extend_from_slice((cells.join(",") + "\n").as_bytes());
    }
    lines
}
