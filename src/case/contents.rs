//! The content of files that a case is read from besides its text, by which they are known again.

use toml_edit::{Document, Item};

use super::Case;
use super::dotted::found;
use super::files::{MOST_OF_TABLE, read_file};
use super::tables::absolute;

impl Case {
    /// The content of files that the runs of a case follow from besides its text, each with its name: tables, and the
    /// end of the run that it continues. The content is a number that another content has hardly ever.
    pub fn contents(&self) -> Vec<String> {
        let document = Document::parse(self.text.as_str()).ok();
        let path = |name: &str| {
            let root = document.as_ref()?.as_table();
            found(root, &format!("tables.{name}.file")).and_then(Item::as_str)
        };
        let of_table = |(name, _): &(String, _)| {
            let file = path(name)?;
            let bytes = read_file(&absolute(&self.folder, file), MOST_OF_TABLE).ok()?;
            Some(named(file, &bytes))
        };
        let end = self
            .from
            .as_ref()
            .zip(self.continues.as_ref())
            .and_then(|(end, summary)| Some(named(&summary.display().to_string(), &serde_json::to_vec(end).ok()?)));
        self.geometry_text.tables.iter().filter_map(of_table).chain(end).collect()
    }
}

/// A name, and a number for the content by the function FNV-1a of G. Fowler, L. C. Noll and K.-P. Vo, which is the same
/// on all machines.
pub fn named(name: &str, content: &[u8]) -> String {
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
    format!("{name} {:016x}", content.iter().fold(0xcbf2_9ce4_8422_2325, step))
}
