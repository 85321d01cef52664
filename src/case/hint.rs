//! Advice for mistakes in the keys of a case.

use super::keys::{Cases, KEYS, Key};
use crate::formula::similar::nearest;

/// The dotted names of the keys that stand in the tables of a case file, those of all cases first; what stands deeper
/// belongs to a potential, and names of coordinates and of the case's own are not among them.
fn known() -> impl Iterator<Item = &'static str> + Clone {
    let is_general = |key: &Key| matches!(key.cases, Cases::All | Cases::OfX);
    let keys = KEYS.iter().filter(move |key| is_general(key)).chain(KEYS.iter().filter(move |key| !is_general(key)));
    let keys = keys.filter(|key| key.is_fixed()).map(|key| key.name);
    keys.chain(["events", "invariants", "plot"]).filter(|name| name.matches('.').count() < 2)
}

/// The last part of a dotted key.
pub(super) fn last(key: &str) -> &str {
    key.rsplit_once('.').map_or(key, |(_, last)| last)
}

/// Returns the key that an unknown one of the table `path` was probably meant to be: one of this name in another table,
/// a similar one of `own`, those of this table, or a similar one of any table.
pub(super) fn for_key(key: &str, path: &str, own: &[&str]) -> Option<String> {
    let table = |name: &'static str| name.rsplit_once('.').map_or("", |(table, _)| table);
    let elsewhere = known().find(|name| last(name) == key && table(name) != path);
    let anywhere = || known().find(|name| nearest(key, known().map(last)) == Some(last(name)));
    elsewhere.or_else(|| nearest(key, own.iter().copied())).or_else(anywhere).map(str::to_owned)
}

/// Returns the word that an unknown one was probably meant to be, by the deserialiser's message about it.
pub(super) fn for_word(message: &str) -> Option<String> {
    let mut quoted = message.strip_prefix("unknown variant ")?.split('`').skip(1).step_by(2);
    let word = quoted.next()?;
    nearest(word, quoted).map(|meant| format!("did you mean `{meant}`?"))
}
