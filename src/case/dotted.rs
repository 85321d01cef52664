//! Values of a document by their dotted keys.

use toml_edit::{Item, Table, TableLike};

/// The value of a dotted key.
pub(super) fn found<'d>(root: &'d Table, path: &str) -> Option<&'d Item> {
    let (first, rest) = path.split_once('.').unwrap_or((path, ""));
    let within = |item: &'d Item, key: &str| item.as_table_like()?.get(key);
    rest.split('.').filter(|key| !key.is_empty()).try_fold(root.get(first)?, within)
}

/// Removes a dotted key.
pub(super) fn remove(root: &mut Table, path: &str) {
    let (tables, last) = path.rsplit_once('.').unwrap_or(("", path));
    let mut table: &mut dyn TableLike = root;
    for key in tables.split('.').filter(|key| !key.is_empty()) {
        let Some(inner) = table.get_mut(key).and_then(Item::as_table_like_mut) else { return };
        table = inner;
    }
    table.remove(last);
}
