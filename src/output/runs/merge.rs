//! Joining the parts of a table. The joined table is the one that a single run would have written, byte for byte.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::super::files::{CASE, SUMMARY};
use super::rows::{self, RowFile, Rows};
use super::{JOURNAL, RUNS, RUNS_EVENTS, RunsSummary};

/// Rows that a message names at most.
const MOST_NAMED: usize = 5;

/// Parts that do not make a table.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A folder has no table of runs.
    #[error("{} has no table of runs: {reason}", folder.display())]
    NoTable {
        /// The folder.
        folder: PathBuf,
        /// Why.
        reason: String,
    },
    /// The folder's table is not finished.
    #[error("the table of {} is not finished: it has a {JOURNAL}", folder.display())]
    Unfinished {
        /// The folder.
        folder: PathBuf,
    },
    /// Two folders have parts of different tables.
    #[error("{} and {} are parts of different tables: {what}", one.display(), other.display())]
    Different {
        /// One folder.
        one: PathBuf,
        /// The other folder.
        other: PathBuf,
        /// The difference.
        what: &'static str,
    },
    /// Two folders have the same row.
    #[error("row {row} is both in {} and in {}", one.display(), other.display())]
    Twice {
        /// The row.
        row: usize,
        /// One folder.
        one: PathBuf,
        /// The other folder.
        other: PathBuf,
    },
    /// Rows that no folder has.
    #[error("{missing} missing: {rows} of {runs} rows are there")]
    Missing {
        /// The missing part.
        missing: String,
        /// The rows that are there.
        rows: usize,
        /// The rows of the whole table.
        runs: usize,
    },
}

/// A part of a table, in its folder.
#[derive(Debug)]
pub struct Part {
    folder: PathBuf,
    summary: RunsSummary,
    case: String,
    rows: Rows,
}

/// The table that the parts make together.
#[derive(Debug, Clone)]
pub struct Joined {
    /// The summary of the table.
    pub summary: RunsSummary,
    /// Its case.
    pub case: String,
    /// True if it has events.
    pub has_events: bool,
}

impl Part {
    /// The part in a folder.
    ///
    /// # Errors
    /// [`MergeError`] if there is none, or an error of the files.
    pub fn open(folder: &Path) -> anyhow::Result<Self> {
        let no_table = |reason: String| MergeError::NoTable { folder: folder.to_owned(), reason };
        let unfinished = || MergeError::Unfinished { folder: folder.to_owned() };
        let text = match fs::read_to_string(folder.join(SUMMARY)) {
            Ok(text) => text,
            Err(_) if folder.join(JOURNAL).exists() => return Err(unfinished().into()),
            Err(error) => return Err(no_table(format!("{SUMMARY}: {error}")).into()),
        };
        let summary = serde_json::from_str(&text).map_err(|error| match folder.join(JOURNAL).exists() {
            true => unfinished(),
            false => no_table(format!("its {SUMMARY} is that of another command ({error})")),
        })?;
        let runs = RowFile::open(folder, RUNS)?.ok_or_else(|| no_table(format!("there is no {RUNS}")))?;
        let case = fs::read_to_string(folder.join(CASE));
        let case = case.map_err(|error| no_table(format!("{CASE}: {error}")))?;
        let rows = Rows { runs, events: RowFile::open(folder, RUNS_EVENTS)? };
        Ok(Self { folder: folder.to_owned(), summary, case, rows })
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The difference from another part, if they are not parts of one table.
    fn difference(&self, other: &Self) -> Option<&'static str> {
        let [one, two] = [&self.summary, &other.summary];
        let headers =
            |rows: &Rows| (rows.runs.header.clone(), rows.events.as_ref().map(|events| events.header.clone()));
        if one.version != two.version {
            Some("versions of the program")
        } else if self.case != other.case {
            Some("cases")
        } else if (&one.vary, one.runs) != (&two.vary, two.runs) {
            Some("what varies")
        } else if headers(&self.rows) != headers(&other.rows) {
            Some("columns")
        } else {
            None
        }
    }
}

impl Joined {
    /// The table that the parts make together.
    ///
    /// # Errors
    /// [`MergeError::Different`].
    ///
    /// # Panics
    /// Without parts.
    pub fn of(parts: &[Part]) -> Result<Self, MergeError> {
        let (first, others) = parts.split_first().expect("there is a part");
        let mut summary = RunsSummary {
            part: None,
            rows: 0,
            solved: 0,
            doubtful: 0,
            statuses: BTreeMap::new(),
            ..first.summary.clone()
        };
        for part in others {
            if let Some(what) = first.difference(part) {
                return Err(MergeError::Different { one: first.folder.clone(), other: part.folder.clone(), what });
            }
        }
        for RunsSummary { rows, solved, doubtful, statuses, .. } in parts.iter().map(|part| &part.summary) {
            summary.rows += rows;
            summary.solved += solved;
            summary.doubtful += doubtful;
            statuses.iter().for_each(|(status, count)| *summary.statuses.entry(status.clone()).or_default() += count);
        }
        Ok(Self { summary, case: first.case.clone(), has_events: first.rows.events.is_some() })
    }
}

/// Writes the rows of all parts in their order to `runs`, and their events to `events` if they have any.
///
/// # Errors
/// [`MergeError::Twice`], [`MergeError::Missing`], or an error of the files.
pub fn join<W: Write>(parts: &mut [Part], tables: (W, Option<W>)) -> anyhow::Result<()> {
    let mut order: BTreeMap<usize, usize> = BTreeMap::new();
    for (place, part) in parts.iter().enumerate() {
        for row in part.rows.runs.numbers() {
            if let Some(before) = order.insert(row, place) {
                let [one, other] = [before, place].map(|place| parts[place].folder.clone());
                return Err(MergeError::Twice { row, one, other }.into());
            }
        }
    }
    let total = parts[0].summary.runs;
    let (mut expected, mut missing) = (1, Missing::default());
    for &row in order.keys() {
        missing.add(expected..row);
        expected = row + 1;
    }
    missing.add(expected..total + 1);
    if missing.count > 0 {
        let parts: Vec<Option<String>> = parts.iter().map(|part| part.summary.part.clone()).collect();
        return Err(MergeError::Missing { missing: missing.of(&parts), rows: order.len(), runs: total }.into());
    }
    let mut sources: Vec<&mut Rows> = parts.iter_mut().map(|part| &mut part.rows).collect();
    rows::write(&mut sources, order.into_iter(), tables, |_| ())
}

/// Rows that are missing.
#[derive(Default)]
struct Missing {
    first: Vec<usize>,
    count: usize,
}

impl Missing {
    fn add(&mut self, rows: std::ops::Range<usize>) {
        self.count += rows.len();
        let room = MOST_NAMED.saturating_sub(self.first.len());
        self.first.extend(rows.take(room));
    }

    /// The missing parts in words, if all tables are parts of one division, or else the missing rows.
    fn of(&self, parts: &[Option<String>]) -> String {
        let read = |part: &Option<String>| {
            let (k, n) = part.as_ref()?.split_once('/')?;
            Some((k.parse::<usize>().ok()?, n.parse::<usize>().ok()?))
        };
        let known: Option<Vec<(usize, usize)>> = parts.iter().map(read).collect();
        let absent = known.and_then(|known| {
            let (_, n) = *known.first()?;
            let absent = (1..=n).filter(|k| !known.iter().any(|(other, _)| other == k));
            let absent: Vec<String> = absent.map(|k| format!("{k}/{n}")).collect();
            (known.iter().all(|(_, other)| *other == n) && !absent.is_empty()).then_some(absent)
        });
        match absent {
            Some(absent) if absent.len() == 1 => format!("part {} is", absent[0]),
            Some(absent) => format!("parts {} are", absent.join(", ")),
            None => {
                let rows: Vec<String> = self.first.iter().map(usize::to_string).collect();
                let more = if self.count > rows.len() { ", …" } else { "" };
                let (s, is) = if self.count == 1 { ("", "is") } else { ("s", "are") };
                format!("row{s} {}{more} {is}", rows.join(", "))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_named() {
        let mut missing = Missing::default();
        missing.add(2..3);
        missing.add(4..10);
        let part = |text: &str| Some(text.to_owned());
        assert_eq!(missing.of(&[part("1/3"), part("3/3")]), "part 2/3 is");
        assert_eq!(missing.of(&[part("2/3")]), "parts 1/3, 3/3 are");
        assert_eq!(missing.of(&[part("1/2"), part("2/4")]), "rows 2, 4, 5, 6, 7, … are");
        assert_eq!(missing.of(&[None]), "rows 2, 4, 5, 6, 7, … are");
        missing = Missing::default();
        missing.add(2..3);
        assert_eq!(missing.of(&[part("1/2"), part("2/2")]), "row 2 is");
    }
}
