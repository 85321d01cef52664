//! The rows of a table that is being made. Each is kept as soon as it is there, so that a table that is interrupted is
//! continued and not begun anew.
//!
//! The journal is the table itself with its rows in the order in which they were finished, below a line that says what
//! it is a table of; the events and samples of a row are in tables beside it, before the row is there. A row is written
//! at once, and then the file is only longer: of a program that is killed every row is there, but perhaps for the last
//! one. What is torn is cut off when the journal is opened again. Once a second all is brought to the disk, for the
//! case that the machine stops.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Context;
use csv::{ReaderBuilder, StringRecord};
use serde::{Deserialize, Serialize};

use super::super::files::{refused, refused_by_system};
use super::super::lock::try_lock;
use super::rows::{self, RowFile};
use super::{JOURNAL, JOURNAL_EVENTS, RowTable, RunRow, RunsSummary, TABLES};

/// The longest time that a row may be on its way to the disk.
const AT_RISK: Duration = Duration::from_secs(1);

/// The beginning of the first line of a journal.
const MARK: &[u8] = b"# ";

/// The identity of a table. Rows of the same table may stand in one file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// The program.
    pub program: String,
    /// Its version.
    pub version: String,
    /// The text of the case with what `--set` changes.
    pub case: String,
    /// The varied keys, as they were asked for.
    pub vary: Vec<String>,
    /// The part, if the table is one.
    pub part: Option<String>,
    /// Where samples are wanted, if they are, as it was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub samples: Option<String>,
    /// The files that the case is read from besides its text, each with its content.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

impl Identity {
    /// A table of this program.
    pub fn new(case: String, vary: Vec<String>, part: Option<String>, files: Vec<String>) -> Self {
        let [program, version] = [env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION")].map(str::to_owned);
        Self { program, version, case, vary, part, samples: None, files }
    }

    /// The same table with samples.
    #[must_use]
    pub fn with_samples(self, samples: Option<String>) -> Self {
        Self { samples, ..self }
    }

    /// The first line of its journal.
    fn line(&self) -> Vec<u8> {
        let json = serde_json::to_vec(self).expect("it has string keys only");
        [MARK, &json, b"\n"].concat()
    }

    /// The difference from another table, in words.
    fn difference(&self, other: &Self) -> Option<String> {
        let list = |vary: &[String]| vary.iter().map(|axis| format!("--vary {axis}")).collect::<Vec<_>>().join(" ");
        let part = |part: &Option<String>| part.as_ref().map_or("all rows".to_owned(), |part| format!("--part {part}"));
        if self == other {
            None
        } else if (&self.program, &self.version) != (&other.program, &other.version) {
            Some(format!("{} {}, and this is {} {}", other.program, other.version, self.program, self.version))
        } else if self.vary != other.vary {
            Some(format!("{}, and now it is {}", list(&other.vary), list(&self.vary)))
        } else if self.part != other.part {
            Some(format!("{}, and now it is {}", part(&other.part), part(&self.part)))
        } else if self.samples != other.samples {
            let [before, now] = [other, self].map(|table| table.samples.as_deref().unwrap_or("no samples"));
            Some(format!("{before}, and now it is {now}"))
        } else if self.case == other.case {
            let changed = self.files.iter().find(|file| !other.files.contains(file)).or(other.files.first());
            let name = changed.and_then(|file| file.rsplit_once(' ')).map_or("a file", |(name, _)| name);
            Some(format!("another content of {name}"))
        } else {
            Some("another text of the case, or another --set".to_owned())
        }
    }
}

/// An open journal. No other process can open it meanwhile.
#[derive(Debug)]
pub struct Journal {
    /// The rows and, if the table has any, their events and samples.
    tables: Vec<RowFile>,
    synced: Instant,
}

impl Journal {
    /// Opens the journal of tables in `folder`, which must be there, or begins it. With `force` a file that is no
    /// journal is replaced.
    ///
    /// # Errors
    /// [`Refused`](crate::output::Refused) if it is of another table, no journal, or in use; or an error of a file.
    pub fn open(folder: &Path, identity: &Identity, kinds: &[RowTable], force: bool) -> anyhow::Result<Self> {
        let (path, mut file) = opened(folder, JOURNAL)?;
        if !try_lock(&file).with_context(|| format!("cannot write {}", path.display()))? {
            let message = format!("another program is computing the rows of {}", path.display());
            return Err(refused_by_system(message, "wait for it, or choose another folder with --out"));
        }
        let (own, mut line) = (identity.line(), Vec::new());
        let read = BufReader::new(&mut file).read_until(b'\n', &mut line);
        read.with_context(|| format!("cannot read {}", path.display()))?;
        let json = line.strip_prefix(MARK).filter(|_| line.ends_with(b"\n"));
        let before: Option<Identity> = json.and_then(|json| serde_json::from_slice(json).ok());
        if let Some(difference) = before.as_ref().and_then(|before| identity.difference(before)) {
            let path = path.display();
            let message = format!("{path} has rows of another table: it was begun with {difference}");
            let help = "give the command that began that table to finish it, choose another folder with --out, or \
                        remove the file";
            return Err(refused(message, help));
        }
        // A program that was killed may have left a part of its first line.
        if before.is_none() && !own.starts_with(&line) && !force {
            let message = format!("{} is there already, and nothing says that this program wrote it", path.display());
            let help = "move it away, choose another folder with --out, or replace it with --force";
            return Err(refused_by_system(message, help));
        }
        let mut tables = vec![RowFile::read(&path, file, own.len() as u64)?];
        for kind in &kinds[1..] {
            let partial = TABLES.iter().find(|(name, _)| *name == kind.name).map_or(kind.name, |(_, partial)| partial);
            let (path, file) = opened(folder, partial)?;
            tables.push(RowFile::read(&path, file, 0)?);
        }
        let mut all = tables.iter().zip(kinds);
        if before.is_some() && all.all(|(table, kind)| table.header.iter().eq(&kind.header)) {
            let (runs, others) = tables.split_first_mut().expect("there are rows");
            runs.cut(|_| true)?;
            // They are written before their row, which the program may have been killed before.
            others.iter_mut().try_for_each(|table| table.cut(|row| runs.has(row)))?;
        } else {
            let first: [&[u8]; TABLES.len()] = [&own, &[], &[]];
            for ((table, kind), first) in tables.iter_mut().zip(kinds).zip(first).rev() {
                table.begin(first, &kind.header)?;
            }
        }
        Ok(Self { tables, synced: Instant::now() })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.tables[0].path
    }

    /// The number of rows that it has.
    pub fn count(&self) -> usize {
        self.tables[0].numbers().len()
    }

    /// Returns true if it has that row.
    pub fn has(&self, row: usize) -> bool {
        self.tables[0].has(row)
    }

    /// Keeps a row.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn keep(&mut self, row: &RunRow) -> anyhow::Result<()> {
        for (table, records) in self.tables.iter_mut().zip(&row.records).rev() {
            table.append(Some(row.row), records)?;
        }
        if self.synced.elapsed() >= AT_RISK {
            self.tables.iter().rev().try_for_each(RowFile::sync)?;
            self.synced = Instant::now();
        }
        Ok(())
    }

    /// Writes its rows in their order to the tables, and counts them. Returns the cells of each of some columns, in
    /// their order.
    ///
    /// # Errors
    /// If a row cannot be read, or a table cannot be written.
    pub fn write<W: Write>(
        &mut self,
        tables: Vec<(&str, W)>,
        summary: &mut RunsSummary,
        columns: &[String],
    ) -> anyhow::Result<Vec<Vec<String>>> {
        let order: Vec<(usize, usize)> = self.tables[0].numbers().map(|row| (row, 0)).collect();
        rows::write(&mut [&mut self.tables], order.into_iter(), tables, summary, columns)
    }

    /// The events of its rows in their order: the number of the run, which counts from 0, and their records.
    ///
    /// # Errors
    /// If they cannot be read.
    pub fn events(&mut self) -> anyhow::Result<Vec<(usize, Vec<StringRecord>)>> {
        let is_of_events = |table: &&mut RowFile| table.path.ends_with(JOURNAL_EVENTS);
        let Some(table) = self.tables.iter_mut().find(is_of_events) else { return Ok(Vec::new()) };
        let rows: Vec<usize> = table.numbers().collect();
        let of_row = |row: usize| {
            let records = table.row(row)?;
            let mut reader = ReaderBuilder::new().has_headers(false).from_reader(&*records);
            let cannot = || format!("cannot read {}", table.path.display());
            let events = reader.records().collect::<Result<_, _>>().with_context(cannot)?;
            Ok((row - 1, events))
        };
        rows.into_iter().map(of_row).collect()
    }

    /// Removes it, as its rows are in a table now.
    ///
    /// # Errors
    /// If it cannot be removed.
    pub fn remove(self) -> anyhow::Result<()> {
        // Not every system removes a file that is open, so each is closed before.
        let paths: Vec<PathBuf> = self.tables.into_iter().map(|table| table.path).collect();
        let remove =
            |path: &PathBuf| fs::remove_file(path).with_context(|| format!("cannot remove {}", path.display()));
        paths.iter().try_for_each(remove)
    }
}

/// The file of that name, which is made if there is none.
fn opened(folder: &Path, name: &str) -> anyhow::Result<(PathBuf, File)> {
    let path = folder.join(name);
    let file = File::options().read(true).write(true).create(true).truncate(false).open(&path);
    let file = file.with_context(|| format!("cannot write {}", path.display()))?;
    Ok((path, file))
}

#[cfg(test)]
mod tests {
    use std::cmp::Ordering;

    use super::super::JOURNAL_SAMPLES;
    use super::*;
    use crate::diagnostics::verdict::Grade;

    fn row(row: usize) -> RunRow {
        let events = if row % 2 == 1 { format!("{row},up\n{row},\"do\nwn\"\n") } else { String::new() };
        let samples = format!("{row},0.5\n").repeat(row % 3);
        let own = format!("{row},\"{row}.0\n\"\"\",converged\n");
        let records = [own, events, samples].map(String::into_bytes).to_vec();
        RunRow { row, records, status: "converged".to_owned(), verdict: Grade::Trusted }
    }

    fn open(folder: &Path) -> Journal {
        let identity = Identity::new("a = 1\n".to_owned(), vec!["b=1,2".to_owned()], None, Vec::new());
        let headers = ["row,x,status", "row,event", "row,gamma"].map(|names| names.split(',').map(str::to_owned));
        let kinds = headers.into_iter().zip(TABLES);
        let kinds: Vec<RowTable> =
            kinds.map(|(header, (name, _))| RowTable { name, header: header.collect() }).collect();
        Journal::open(folder, &identity, &kinds, false).unwrap()
    }

    #[test]
    fn whatever_length_a_killed_program_leaves_the_whole_rows_are_there() {
        let folder = tempfile::tempdir().unwrap();
        // In the order in which they are written.
        let paths = [JOURNAL_SAMPLES, JOURNAL_EVENTS, JOURNAL].map(|name| folder.path().join(name));
        let sizes = || paths.clone().map(|path| fs::read(path).map_or(0, |text| text.len()));
        // The contents of both files after each write, in the order of the writes.
        let mut journal = open(folder.path());
        let mut states = vec![([0; 3], 0), (sizes(), 0)];
        for (number, done) in [(3, 1), (1, 2), (2, 3)] {
            journal.keep(&row(number)).unwrap();
            states.push((sizes(), done));
        }
        drop(journal);
        let whole = paths.clone().map(|path| fs::read(path).unwrap());
        for pair in states.windows(2) {
            let ((few, before), (more, after)) = (pair[0], pair[1]);
            // One file after the other is written.
            let lengths = (0..3).flat_map(|file| {
                let others = move |length| {
                    [0, 1, 2].map(|other: usize| match other.cmp(&file) {
                        Ordering::Less => more[other],
                        Ordering::Equal => length,
                        Ordering::Greater => few[other],
                    })
                };
                (few[file]..=more[file]).map(others)
            });
            for lengths in lengths {
                for ((path, whole), length) in paths.iter().zip(&whole).zip(lengths) {
                    fs::write(path, &whole[..length]).unwrap();
                }
                let mut journal = open(folder.path());
                let expected = if lengths[2] == more[2] { after } else { before };
                assert_eq!(journal.count(), expected, "{lengths:?}");
                // It goes on from there, and what was there stays.
                journal.keep(&row(7)).unwrap();
                drop(journal);
                let mut journal = open(folder.path());
                assert_eq!(journal.count(), expected + 1);
                for number in [3, 1, 2][..expected].iter().chain(&[7]) {
                    let kept = [0, 1, 2].map(|table| journal.tables[table].row(*number).unwrap());
                    assert_eq!(kept[..], row(*number).records);
                }
            }
        }
    }
}
