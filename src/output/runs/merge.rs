//! Joining the parts of a table. The joined table is the one that a single run would have written, byte for byte.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use csv::{Reader, StringRecord};

use super::super::files::{CASE, SUMMARY};
use super::table::Tables;
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
        /// What is different.
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
        /// What is missing.
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
    runs: Rows,
    events: Option<Rows>,
}

/// What the parts of a table are together.
#[derive(Debug, Clone)]
pub struct Joined {
    /// The summary of the table.
    pub summary: RunsSummary,
    /// Its case.
    pub case: String,
    /// Whether it has events.
    pub has_events: bool,
}

/// The rows of a table that begin with a number, one after the other.
#[derive(Debug)]
struct Rows {
    reader: Reader<File>,
    header: StringRecord,
    next: Option<(usize, StringRecord)>,
    path: PathBuf,
}

impl Rows {
    /// The table of that name; `None` if there is none.
    fn open(folder: &Path, name: &str) -> anyhow::Result<Option<Self>> {
        let path = folder.join(name);
        if !path.exists() {
            return Ok(None);
        }
        let cannot = || format!("cannot read {}", path.display());
        let mut reader = Reader::from_path(&path).with_context(cannot)?;
        let header = reader.headers().with_context(cannot)?.clone();
        let mut rows = Self { reader, header, next: None, path };
        rows.advance()?;
        Ok(Some(rows))
    }

    /// Reads the next row. Returns the one before it.
    fn advance(&mut self) -> anyhow::Result<Option<StringRecord>> {
        let cannot = || format!("cannot read {}", self.path.display());
        let mut record = StringRecord::new();
        let next = match self.reader.read_record(&mut record).with_context(cannot)? {
            true => {
                let number = record.get(0).and_then(|number| number.parse().ok());
                Some((number.with_context(|| format!("{} has a row without a number", self.path.display()))?, record))
            }
            false => None,
        };
        Ok(std::mem::replace(&mut self.next, next).map(|(_, record)| record))
    }

    fn number(&self) -> Option<usize> {
        self.next.as_ref().map(|(number, _)| *number)
    }
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
        let runs = Rows::open(folder, RUNS)?.ok_or_else(|| no_table(format!("there is no {RUNS}")))?;
        let case = fs::read_to_string(folder.join(CASE));
        let case = case.map_err(|error| no_table(format!("{CASE}: {error}")))?;
        Ok(Self { folder: folder.to_owned(), summary, case, runs, events: Rows::open(folder, RUNS_EVENTS)? })
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// What is different from another part, if they are not parts of one table.
    fn difference(&self, other: &Self) -> Option<&'static str> {
        let [one, two] = [&self.summary, &other.summary];
        let header = |events: &Option<Rows>| events.as_ref().map(|rows| rows.header.clone());
        if one.version != two.version {
            Some("versions of the program")
        } else if self.case != other.case {
            Some("cases")
        } else if (&one.vary, one.runs) != (&two.vary, two.runs) {
            Some("what varies")
        } else if self.runs.header != other.runs.header || header(&self.events) != header(&other.events) {
            Some("columns")
        } else {
            None
        }
    }
}

impl Joined {
    /// What the parts are together.
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
        Ok(Self { summary, case: first.case.clone(), has_events: first.events.is_some() })
    }
}

/// Writes the rows of all parts in their order to `runs`, and their events to `events` if they have any.
///
/// # Errors
/// [`MergeError::Twice`], [`MergeError::Missing`], or an error of the files.
pub fn join<W: Write>(parts: &mut [Part], (runs, events): (W, Option<W>)) -> anyhow::Result<()> {
    let cells = |header: &StringRecord| header.iter().map(str::to_owned).collect::<Vec<_>>();
    let header = cells(&parts[0].runs.header);
    let events_header = parts[0].events.as_ref().map(|events| cells(&events.header)).unwrap_or_default();
    let mut tables = Tables::new((runs, &header), events.map(|out| (out, events_header.as_slice())))?;
    let total = parts[0].summary.runs;
    let (mut expected, mut missing, mut rows) = (1, Missing::default(), 0);
    while let Some((row, place)) = next(parts)? {
        missing.add(expected..row);
        expected = row + 1;
        rows += 1;
        let part = &mut parts[place];
        if let Some(record) = part.runs.advance()? {
            tables.run(&record)?;
        }
        while let Some(events) = part.events.as_mut().filter(|events| events.number() == Some(row)) {
            if let Some(record) = events.advance()? {
                tables.event(&record)?;
            }
        }
    }
    missing.add(expected..total + 1);
    if missing.count > 0 {
        let parts: Vec<Option<String>> = parts.iter().map(|part| part.summary.part.clone()).collect();
        return Err(MergeError::Missing { missing: missing.of(&parts), rows, runs: total }.into());
    }
    tables.finish()
}

/// The smallest row that is not read yet, and the place of its part.
fn next(parts: &[Part]) -> Result<Option<(usize, usize)>, MergeError> {
    let heads = || parts.iter().enumerate().filter_map(|(place, part)| Some((part.runs.number()?, place)));
    let Some((row, place)) = heads().min() else { return Ok(None) };
    match heads().find(|&(other, at)| other == row && at != place) {
        Some((_, at)) => {
            let [one, other] = [place, at].map(|place| parts[place].folder.clone());
            Err(MergeError::Twice { row, one, other })
        }
        None => Ok(Some((row, place))),
    }
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

    /// What is missing, in words: the parts, if all tables are parts of one division, or else the rows.
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
