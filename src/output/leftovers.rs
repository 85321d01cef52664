//! Temporary files of programs that were killed. A file gets its name when it is whole: until then it is called
//! `.NAME.XXXXXX`, with six letters or digits that nobody foretells, and its program holds a lock on it.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::path::Path;

use super::lock::try_lock;

/// The number of characters behind the last dot.
const SUFFIX: usize = 6;

/// Removes what is left in a folder of files with these names. Nobody makes such a file meanwhile.
pub(super) fn remove<'n>(folder: &Path, names: impl Iterator<Item = &'n str> + Clone) {
    let is_temporary = |file: &OsStr| {
        let of = |name: &str| file.to_str()?.strip_prefix('.')?.strip_prefix(name)?.strip_prefix('.');
        let is_random = |suffix: &str| suffix.len() == SUFFIX && suffix.chars().all(|c| c.is_ascii_alphanumeric());
        names.clone().any(|name| of(name).is_some_and(is_random))
    };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| is_temporary(&entry.file_name())) {
        let path = entry.path();
        let is_dead = File::open(&path).and_then(|file| try_lock(&file)).unwrap_or(false);
        if is_dead {
            // It is no harm if it stays.
            let _ = fs::remove_file(path);
        }
    }
}

/// Marks a temporary file as that of a living program. The system takes the mark away when the program ends.
pub(super) fn hold(file: &File) {
    // Without locks it looks like one that a killed program left, to another one that writes into the folder.
    let _ = try_lock(file);
}
