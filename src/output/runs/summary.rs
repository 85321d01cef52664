//! `summary.json` of many runs.

use std::collections::BTreeMap;

use csv::{ReaderBuilder, StringRecord};
use serde::{Deserialize, Serialize};

use super::super::hull::HULL;
use super::super::json::json;
use super::Identity;
use crate::diagnostics::verdict::Grade;
use crate::solve::Status;

/// The whole summary. It has no times, so that the same runs have the same summary.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunsSummary {
    /// Always `complete`.
    pub status: String,
    /// Version of the program.
    pub version: String,
    /// The case's title.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// The varied keys, as they were asked for.
    pub vary: Vec<String>,
    /// The number of runs that this makes.
    pub runs: usize,
    /// The part that the table is, K/N; absent if it is the whole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// Where samples were taken, as it was asked for; absent if there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub samples: Option<String>,
    /// The number of rows of the table.
    pub rows: usize,
    /// Rows with a solution.
    pub solved: usize,
    /// The number of those whose verdict is doubtful.
    pub doubtful: usize,
    /// The number of those whose end is proved; absent if there is none.
    #[serde(default, skip_serializing_if = "is_none")]
    pub proved: usize,
    /// The number of those of which it is proved where all motions from their intervals end; absent without intervals.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hulls: Option<usize>,
    /// The number of rows with each status.
    pub statuses: BTreeMap<String, usize>,
}

fn is_none(count: &usize) -> bool {
    *count == 0
}

impl RunsSummary {
    /// The summary of a table without rows.
    pub fn new(title: Option<&str>, identity: &Identity, runs: usize) -> Self {
        Self {
            status: "complete".to_owned(),
            version: identity.version.clone(),
            title: title.map(str::to_owned),
            vary: identity.vary.clone(),
            runs,
            part: identity.part.clone(),
            samples: identity.samples.clone(),
            rows: 0,
            solved: 0,
            doubtful: 0,
            proved: 0,
            hulls: None,
            statuses: BTreeMap::new(),
        }
    }

    /// The count of rows of a table that has no other summary.
    pub fn of_rows() -> Self {
        Self::new(None, &Identity::new(String::new(), Vec::new(), None, Vec::new()), 0)
    }

    /// The same table without rows.
    pub(super) fn without_rows(&self) -> Self {
        Self { rows: 0, solved: 0, doubtful: 0, proved: 0, hulls: None, statuses: BTreeMap::new(), ..self.clone() }
    }

    /// Counts rows, which are lines of the table with this header, and shows the cells of each.
    pub(super) fn see(&mut self, header: &StringRecord, lines: &[u8], mut each: impl FnMut(&StringRecord)) {
        // Coordinates, whose columns are between these two, may have any names.
        let status = header.iter().position(|cell| cell == "status");
        let verdict = header.iter().enumerate().filter(|(_, cell)| *cell == "verdict").map(|(place, _)| place).last();
        let hull = header.iter().position(|cell| cell.starts_with(HULL[0]));
        let mut cells = StringRecord::new();
        let mut reader = ReaderBuilder::new().has_headers(false).flexible(true).from_reader(lines);
        while reader.read_record(&mut cells).unwrap_or(false) {
            let cell = |place: Option<usize>| place.and_then(|place| cells.get(place)).unwrap_or_default();
            self.count(cell(status), cell(verdict));
            if hull.is_some() {
                *self.hulls.get_or_insert(0) += usize::from(!cell(hull).is_empty());
            }
            each(&cells);
        }
    }

    /// Counts a row with this status and verdict.
    pub fn count(&mut self, status: &str, verdict: &str) {
        self.rows += 1;
        self.solved += usize::from(status == Status::Converged.as_str());
        self.doubtful += usize::from(verdict == Grade::Doubtful.as_str());
        self.proved += usize::from(verdict == Grade::Proved.as_str());
        *self.statuses.entry(status.to_owned()).or_default() += 1;
    }

    /// The JSON text, with a final newline.
    pub fn to_json(&self) -> String {
        json(self)
    }
}
