//! `[parameters]`: named numbers for all formulas of a case. For one version more they are also read in the tables
//! where they stood before, each beside some of the formulas.

use toml_edit::{Item, Key, Table};

use super::dotted::{found, remove};
use super::keys::{FORMER, PARAMETERS};

/// The former tables of a text.
pub(super) fn former(root: &Table) -> Vec<&'static str> {
    FORMER.into_iter().filter(|place| found(root, place).is_some()).collect()
}

/// Moves parameters from the former tables into the one for all formulas. Of two with one name that of the former table
/// stays there, which is a mistake, unless it `wins`. Returns the former tables.
pub(super) fn gather(root: &mut Table, wins: bool) -> Vec<&'static str> {
    let former = former(root);
    for place in &former {
        for (key, item) in entries(found(root, place)) {
            let all = root.entry(PARAMETERS).or_insert_with(toml_edit::table).as_table_like_mut();
            let Some(all) = all.filter(|all| wins || !all.contains_key(&key)) else { continue };
            all.remove(&key);
            all.entry_format(&key).or_insert(item);
            remove(root, &format!("{place}.{}", key.get()));
        }
        if found(root, place).and_then(Item::as_table_like).is_some_and(|rest| rest.is_empty()) {
            remove(root, place);
        }
    }
    former
}

/// The keys and values of a table. Comments stay with them; the blanks between those of an inline one do not.
fn entries(table: Option<&Item>) -> Vec<(Key, Item)> {
    let has_lines = table.and_then(Item::as_table).is_some_and(|table| !table.is_dotted());
    let entry = |(name, item): (&str, &Item)| {
        let own = table?.as_table_like()?.key(name).filter(|_| has_lines);
        let mut item = item.clone();
        if let Some(value) = item.as_value_mut().filter(|_| own.is_none()) {
            value.decor_mut().clear();
        }
        Some((own.cloned().unwrap_or_else(|| Key::new(name)), item))
    };
    table.and_then(Item::as_table_like).into_iter().flat_map(|table| table.iter()).filter_map(entry).collect()
}
