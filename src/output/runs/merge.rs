//! Joining the parts of a table. The joined table is the one that a single run would have written, byte for byte.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::super::files::{CASE, SUMMARY, refused};
use super::rows::{self, RowFile};
use super::{JOURNAL, RUNS, RunsSummary, TABLES};
use crate::case::{MOST_OF_CASE, MOST_OF_SUMMARY, read_text};

/// Rows that a message names at most.
const MOST_NAMED: usize = 5;

/// A part of a table, in its folder.
#[derive(Debug)]
pub struct Part {
    /// The folder.
    pub folder: PathBuf,
    /// The text of its case.
    pub case: String,
    summary: RunsSummary,
    names: Vec<&'static str>,
    /// The rows and, if the table has any, their events and samples.
    tables: Vec<RowFile>,
}

impl Part {
    /// The part in a folder.
    ///
    /// # Errors
    /// [`Refused`](crate::output::Refused) if there is none, or an error of the files.
    pub fn open(folder: &Path) -> anyhow::Result<Self> {
        let no_table = |reason: String| {
            let help = "name folders that `run --vary … --part K/N --out FOLDER` has written";
            refused(format!("{} has no table of runs: {reason}", folder.display()), help)
        };
        let unfinished = || {
            let message = format!("the table of {} is not finished: it has a {JOURNAL}", folder.display());
            refused(message, "finish it with the command that began it")
        };
        let is_begun = folder.join(JOURNAL).exists();
        let text = match read_text(&folder.join(SUMMARY), MOST_OF_SUMMARY) {
            Ok(text) => text,
            Err(_) if is_begun => return Err(unfinished()),
            Err(error) => return Err(no_table(format!("{SUMMARY}: {error}"))),
        };
        let summary = serde_json::from_str(&text).map_err(|error| match is_begun {
            true => unfinished(),
            false => no_table(format!("its {SUMMARY} is that of another command ({error})")),
        })?;
        let runs = RowFile::open(folder, RUNS)?.ok_or_else(|| no_table(format!("there is no {RUNS}")))?;
        let case = read_text(&folder.join(CASE), MOST_OF_CASE);
        let case = case.map_err(|error| no_table(format!("{CASE}: {error}")))?;
        let (mut names, mut tables) = (vec![RUNS], vec![runs]);
        for (name, _) in &TABLES[1..] {
            if let Some(table) = RowFile::open(folder, name)? {
                names.push(*name);
                tables.push(table);
            }
        }
        Ok(Self { folder: folder.to_owned(), summary, case, names, tables })
    }

    /// The names of its tables.
    pub fn table_names(&self) -> &[&'static str] {
        &self.names
    }

    /// The difference from another part, if they are not parts of one table.
    fn difference(&self, other: &Self) -> Option<&'static str> {
        let [one, two] = [&self.summary, &other.summary];
        let headers = |part: &Self| part.tables.iter().map(|table| table.header.clone()).collect::<Vec<_>>();
        if one.version != two.version {
            Some("versions of the program")
        } else if self.case != other.case {
            Some("cases")
        } else if (&one.vary, one.runs) != (&two.vary, two.runs) {
            Some("what varies")
        } else if one.samples != two.samples {
            Some("where samples are")
        } else if (&self.names, headers(self)) != (&other.names, headers(other)) {
            Some("columns")
        } else {
            None
        }
    }
}

/// The summary of the table that the parts make together, without its rows.
///
/// # Errors
/// If they are parts of different tables.
///
/// # Panics
/// Without parts.
pub fn joined(parts: &[Part]) -> anyhow::Result<RunsSummary> {
    let (first, others) = parts.split_first().expect("there is a part");
    for part in others {
        if let Some(what) = first.difference(part) {
            let [one, other] = [first, part].map(|part| part.folder.display());
            let message = format!("{one} and {other} are parts of different tables: {what}");
            let help = "join parts of one case, varied in one way, from one version of the program";
            return Err(refused(message, help));
        }
    }
    Ok(RunsSummary { part: None, ..first.summary.without_rows() })
}

/// Writes the rows of all parts in their order to tables, which have names: the rows to the first, and what a row has
/// several of to the others; and counts them in the summary.
///
/// # Errors
/// [`Refused`](crate::output::Refused) if a row is missing or there twice, or an error of the files.
pub fn join<W: Write>(parts: &mut [Part], tables: Vec<(&str, W)>, summary: &mut RunsSummary) -> anyhow::Result<()> {
    let mut order: BTreeMap<usize, usize> = BTreeMap::new();
    for (place, part) in parts.iter().enumerate() {
        for row in part.tables[0].numbers() {
            if let Some(before) = order.insert(row, place) {
                let [one, other] = [before, place].map(|place| parts[place].folder.display());
                let message = format!("row {row} is both in {one} and in {other}");
                return Err(refused(message, "name every part once"));
            }
        }
    }
    let total = parts[0].summary.runs;
    if let Some(row) = order.keys().find(|row| !(1..=total).contains(*row)) {
        let folder = parts[order[row]].folder.display();
        let message = format!("there is a row {row} in {folder}, but the whole table has {total} rows");
        return Err(refused(message, "compute this part again"));
    }
    if order.len() < total {
        // No more than are named: a damaged summary may ask for any number of rows.
        let missing: Vec<usize> = (1..=total).filter(|row| !order.contains_key(row)).take(MOST_NAMED + 1).collect();
        let named: Vec<Option<&str>> = parts.iter().map(|part| part.summary.part.as_deref()).collect();
        let message = format!("{} missing: {} of {total} rows are there", absent(&missing, &named), order.len());
        return Err(refused(message, "compute it with --part, and name all parts"));
    }
    let mut sources: Vec<&mut Vec<RowFile>> = parts.iter_mut().map(|part| &mut part.tables).collect();
    rows::write(&mut sources, order.into_iter(), tables, summary, &[]).map(drop)
}

/// The missing parts in words, if all tables are parts of one division, or else the missing rows.
fn absent(rows: &[usize], parts: &[Option<&str>]) -> String {
    let read = |part: &Option<&str>| {
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
            let named: Vec<String> = rows.iter().take(MOST_NAMED).map(usize::to_string).collect();
            let more = if rows.len() > named.len() { ", …" } else { "" };
            let (s, is) = if rows.len() == 1 { ("", "is") } else { ("s", "are") };
            format!("row{s} {}{more} {is}", named.join(", "))
        }
    }
}
