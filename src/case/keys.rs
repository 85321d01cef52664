//! The keys of a case file in words. The table of `docs/cases.md` is their only list: the manual page prints its rows,
//! and hints look for keys in it.

use std::sync::LazyLock;

const PAGE: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/cases.md"));

/// A key of a case file, or keys that are explained together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Key {
    /// Its dotted name; between several of them are commas.
    pub name: String,
    /// The kind of value that it takes.
    pub kind: String,
    /// Its default, `required`, or nothing.
    pub default: String,
    /// Its meaning.
    pub meaning: String,
}

/// Every key of a potential of x, table by table. A case has exactly one of `potential.free` to `potential.formula`.
pub static KEYS: LazyLock<Vec<Key>> = LazyLock::new(|| keys(false));

/// The keys that scenes have besides. q stands for any coordinate, and NAME for a name of the case's own.
pub static SCENE_KEYS: LazyLock<Vec<Key>> = LazyLock::new(|| keys(true));

/// The rows that are for scenes only, or those that are not: the last column says so.
fn keys(of_scenes: bool) -> Vec<Key> {
    let rows = rows::<5>(PAGE, "| key | takes | default | meaning | cases |");
    let rows = rows.filter(|row| (row[4] == "scenes") == of_scenes);
    rows.map(|[name, kind, default, meaning, _]| Key { name, kind, default, meaning }).collect()
}

/// The rows of the table of a page that has this heading, without the marks of code.
pub fn rows<const N: usize>(page: &'static str, heading: &str) -> impl Iterator<Item = [String; N]> {
    let rows = page.lines().skip_while(move |line| *line != heading).skip(2).take_while(|line| line.starts_with('|'));
    rows.map(|line| {
        let mut cells = line.trim_matches('|').split('|').map(|cell| cell.trim().replace('`', ""));
        std::array::from_fn(|_| cells.next().unwrap_or_default())
    })
}
