//! Files that a case or a command names. All are read up to a limit, as there are files without an end.

use std::fs::File;
use std::io::{Error, ErrorKind, Read};
use std::path::Path;

/// A case is a page of text: no longer one is read.
pub const MOST_OF_CASE: u64 = 1 << 20;
/// The longest summary, and the longest record of a folder, that is read: one of 64 coordinates has some hundred lines.
pub const MOST_OF_SUMMARY: u64 = 1 << 24;
/// The longest table that is read, with the points of a function or with times.
pub const MOST_OF_TABLE: u64 = 1 << 28;

/// All bytes of a file.
///
/// # Errors
/// If it cannot be read, or has more than `most` bytes.
pub fn read_file(path: &Path, most: u64) -> Result<Vec<u8>, Error> {
    read_at_most(File::open(path)?, most)
}

/// All bytes that there are to read.
///
/// # Errors
/// If they cannot be read, or are more than `most`.
pub fn read_at_most(reader: impl Read, most: u64) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    reader.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 <= most {
        return Ok(bytes);
    }
    Err(Error::new(ErrorKind::FileTooLarge, format!("it has more than {most} bytes, and no more are read")))
}

/// The text of a file.
///
/// # Errors
/// If it cannot be read, is longer, or is no UTF-8.
pub fn read_text(path: &Path, most: u64) -> Result<String, Error> {
    String::from_utf8(read_file(path, most)?).map_err(|error| Error::new(ErrorKind::InvalidData, error))
}
