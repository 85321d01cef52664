//! The rows of a table that is being made. Each is kept as soon as it is there, so that a table that is interrupted is
//! continued and not begun anew.
//!
//! The journal is a file of lines of JSON: what the table is of, then a row in each line, in the order in which they
//! were finished. A line is written at once and then the file is only longer: of a program that is killed every line is
//! there, but for the last one perhaps, which is cut off when the journal is opened again. Once a second it is brought
//! to the disk, for the case that the machine stops.

use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Context;
use serde::{Deserialize, Serialize};

use super::{JOURNAL, RunRow};

/// How long a row may be on its way to the disk.
const AT_RISK: Duration = Duration::from_secs(1);

/// What a table is of. Rows of the same table may stand in one file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// The program.
    pub program: String,
    /// Its version.
    pub version: String,
    /// The text of the case with what `--set` changes.
    pub case: String,
    /// What is varied, as it was asked for.
    pub vary: Vec<String>,
    /// The part, if the table is one.
    pub part: Option<String>,
}

impl Identity {
    /// A table of this program.
    pub fn new(case: String, vary: Vec<String>, part: Option<String>) -> Self {
        let [program, version] = [env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION")].map(str::to_owned);
        Self { program, version, case, vary, part }
    }

    /// What is different in another table, in words.
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
        } else {
            Some("another text of the case, or another --set".to_owned())
        }
    }
}

/// The journal in a folder cannot be continued.
#[derive(Debug, thiserror::Error)]
pub enum NotResumable {
    /// It is of another table.
    #[error("{} has rows of another table: it was begun with {difference}", path.display())]
    Other {
        /// The journal.
        path: PathBuf,
        /// What is different.
        difference: String,
    },
    /// It is no journal.
    #[error("{} is there already, and nothing says that this program wrote it", path.display())]
    NotOurs {
        /// The file.
        path: PathBuf,
    },
    /// Another process writes into it.
    #[error("another program is computing the rows of {}", path.display())]
    Busy {
        /// The journal.
        path: PathBuf,
    },
}

/// An open journal. No other process can open it meanwhile.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Where the line of each row begins, and its length.
    places: BTreeMap<usize, (u64, usize)>,
    /// The length of the file.
    length: u64,
    synced: Instant,
}

impl Journal {
    /// Opens the journal in `folder`, which must be there, or begins it. With `force` a file that is no journal is
    /// replaced.
    ///
    /// # Errors
    /// [`NotResumable`], or an error of the file.
    pub fn open(folder: &Path, identity: &Identity, force: bool) -> anyhow::Result<Self> {
        let path = folder.join(JOURNAL);
        let cannot = || format!("cannot write {}", path.display());
        let file = File::options().read(true).write(true).create(true).truncate(false).open(&path);
        let file = file.with_context(cannot)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(NotResumable::Busy { path }.into()),
            // Some network file systems have no locks. There the user must not run two processes in one folder.
            Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => {}
            Err(TryLockError::Error(error)) => return Err(error).with_context(cannot),
        }
        let mut journal = Self { path: path.clone(), file, places: BTreeMap::new(), length: 0, synced: Instant::now() };
        journal.resume(identity, force).with_context(|| format!("cannot read {}", path.display()))??;
        Ok(journal)
    }

    /// Reads what is there, and cuts off what is not whole.
    fn resume(&mut self, identity: &Identity, force: bool) -> io::Result<Result<(), NotResumable>> {
        let mut own = line_of(identity);
        let mut reader = BufReader::new(&self.file);
        let mut line = Vec::new();
        reader.read_until(b'\n', &mut line)?;
        let is_begun = line.ends_with(b"\n");
        let before: Option<Identity> = is_begun.then(|| serde_json::from_slice(&line).ok()).flatten();
        let is_first_line_torn = !is_begun && own.starts_with(&line);
        let mut length = 0;
        match before {
            Some(before) => {
                if let Some(difference) = identity.difference(&before) {
                    return Ok(Err(NotResumable::Other { path: self.path.clone(), difference }));
                }
                length += line.len() as u64;
                own.clear();
                loop {
                    line.clear();
                    reader.read_until(b'\n', &mut line)?;
                    let row = line.ends_with(b"\n").then(|| serde_json::from_slice::<RunRow>(&line).ok()).flatten();
                    let Some(row) = row else { break };
                    self.places.insert(row.row, (length, line.len()));
                    length += line.len() as u64;
                }
            }
            None if is_first_line_torn || force => {}
            None => return Ok(Err(NotResumable::NotOurs { path: self.path.clone() })),
        }
        self.file.set_len(length)?;
        self.length = length;
        self.write(&own)?;
        Ok(Ok(()))
    }

    fn write(&mut self, line: &[u8]) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(self.length))?;
        self.file.write_all(line)?;
        self.length += line.len() as u64;
        if self.synced.elapsed() >= AT_RISK {
            self.file.sync_data()?;
            self.synced = Instant::now();
        }
        Ok(())
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The numbers of the rows that it has.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.places.keys().copied()
    }

    /// Whether it has that row.
    pub fn has(&self, row: usize) -> bool {
        self.places.contains_key(&row)
    }

    /// Keeps a row.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn keep(&mut self, row: &RunRow) -> anyhow::Result<()> {
        let (line, place) = (line_of(row), self.length);
        self.write(&line).with_context(|| format!("cannot write {}", self.path.display()))?;
        self.places.insert(row.row, (place, line.len()));
        Ok(())
    }

    /// Reads a row that it has.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn row(&mut self, row: usize) -> anyhow::Result<RunRow> {
        let cannot = || format!("cannot read row {row} of {}", self.path.display());
        let &(place, length) = self.places.get(&row).with_context(cannot)?;
        let mut line = vec![0; length];
        self.file.seek(SeekFrom::Start(place)).with_context(cannot)?;
        self.file.read_exact(&mut line).with_context(cannot)?;
        serde_json::from_slice(&line).with_context(cannot)
    }

    /// Removes it, as its rows are in a table now.
    ///
    /// # Errors
    /// If it cannot be removed.
    pub fn remove(self) -> anyhow::Result<()> {
        let Self { path, file, .. } = self;
        // Not every system removes a file that is open.
        drop(file);
        fs::remove_file(&path).with_context(|| format!("cannot remove {}", path.display()))
    }
}

/// A line of JSON.
fn line_of(value: &impl Serialize) -> Vec<u8> {
    let mut line = serde_json::to_vec(value).expect("it has string keys only");
    line.push(b'\n');
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostics::verdict::Grade;

    fn row(row: usize) -> RunRow {
        let [status, cell] = ["converged".to_owned(), format!("{row}.0\n\"")];
        RunRow {
            row,
            status,
            verdict: Grade::Trusted,
            cells: vec![cell; 3],
            events: vec![vec!["up".to_owned()]; row % 2],
        }
    }

    fn identity() -> Identity {
        Identity::new("a = 1\n".to_owned(), vec!["b=1,2".to_owned()], None)
    }

    #[test]
    fn whatever_length_a_killed_program_leaves_the_whole_rows_are_there() {
        let folder = tempfile::tempdir().unwrap();
        let mut journal = Journal::open(folder.path(), &identity(), false).unwrap();
        let mut lengths = vec![journal.length];
        for number in [3, 1, 2] {
            journal.keep(&row(number)).unwrap();
            lengths.push(journal.length);
        }
        drop(journal);
        let path = folder.path().join(JOURNAL);
        let whole = fs::read(&path).unwrap();
        for length in 0..=whole.len() {
            fs::write(&path, &whole[..length]).unwrap();
            let mut journal = Journal::open(folder.path(), &identity(), false).unwrap();
            let expected = lengths[1..].iter().filter(|&&end| end <= length as u64).count();
            assert_eq!(journal.rows().len(), expected, "{length}");
            // It goes on from there, and what was there stays.
            journal.keep(&row(7)).unwrap();
            for number in [3, 1, 2][..expected].iter().chain(&[7]) {
                assert_eq!(journal.row(*number).unwrap(), row(*number));
            }
            drop(journal);
            let journal = Journal::open(folder.path(), &identity(), false).unwrap();
            assert_eq!(journal.rows().len(), expected + 1);
        }
    }

    #[test]
    fn another_table_is_not_continued() {
        let folder = tempfile::tempdir().unwrap();
        let open = |identity: &Identity, force| Journal::open(folder.path(), identity, force).map(drop);
        open(&identity(), false).unwrap();
        let version = Identity { version: "0.0.1".to_owned(), ..identity() };
        let case = Identity { case: "a = 2\n".to_owned(), ..identity() };
        let vary = Identity { vary: vec!["b=1,3".to_owned()], ..identity() };
        let part = Identity { part: Some("1/2".to_owned()), ..identity() };
        for (other, words) in
            [(version, "0.0.1"), (case, "text of the case"), (vary, "--vary b=1,3"), (part, "all rows")]
        {
            let error = open(&other, true).unwrap_err().to_string();
            assert!(error.contains("rows of another table") && error.contains(words), "{error}");
        }
        open(&identity(), false).unwrap();
        fs::write(folder.path().join(JOURNAL), "mine\n").unwrap();
        assert!(open(&identity(), false).unwrap_err().to_string().contains("nothing says that this program wrote it"));
        open(&identity(), true).unwrap();
        let journal = Journal::open(folder.path(), &identity(), false).unwrap();
        assert!(open(&identity(), false).unwrap_err().to_string().contains("another program"));
        journal.remove().unwrap();
        assert!(!folder.path().join(JOURNAL).exists());
    }
}
