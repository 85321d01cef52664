//! Writing to standard output, so that a failure to write is always reported.

use std::io::{self, StdoutLock, Write};

use super::report::Refusal;

/// Writes `text` and flushes it, so that a full disk is noticed before the program ends.
///
/// # Errors
/// If it cannot be written.
pub(super) fn write(text: &str) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    Ok(out.flush()?)
}

/// Writes `bytes`, which are the whole output of a command.
///
/// # Errors
/// If standard output is closed or cannot be written.
pub(super) fn write_data(bytes: &[u8]) -> anyhow::Result<()> {
    let mut out = for_data()?;
    out.write_all(bytes)?;
    Ok(out.flush()?)
}

/// Standard output for data that is not kept anywhere else.
///
/// # Errors
/// If it is closed.
pub(super) fn for_data() -> anyhow::Result<StdoutLock<'static>> {
    if is_closed() {
        let refusal = Refusal::input_output("standard output is closed: nothing takes the data");
        let help =
            "redirect it to a file or a pipe (/dev/null opened for reading and writing looks the same as closed)";
        return Err(refusal.help(help).into());
    }
    Ok(io::stdout().lock())
}

/// Returns true if standard output is closed.
///
/// Before `main` begins, the standard library opens /dev/null for reading and writing in place of a closed standard
/// stream. A user who redirects to /dev/null usually opens it for writing only. If it is open for both, standard output
/// is taken to be closed, since what is written to it is lost in any case.
#[cfg(target_os = "linux")]
fn is_closed() -> bool {
    use std::fs;
    use std::os::unix::fs::{FileTypeExt, MetadataExt};

    const ACCESS: u32 = 3;
    const READ_AND_WRITE: u32 = 2;
    let device = |path| {
        let metadata = fs::metadata(path).ok().filter(|metadata| metadata.file_type().is_char_device())?;
        Some(metadata.rdev())
    };
    let flags = || {
        let information = fs::read_to_string("/proc/self/fdinfo/1").ok()?;
        let flags = information.lines().find_map(|line| line.strip_prefix("flags:"))?;
        u32::from_str_radix(flags.trim(), 8).ok()
    };
    device("/dev/null").is_some_and(|null| device("/proc/self/fd/1") == Some(null))
        && flags().is_some_and(|flags| flags & ACCESS == READ_AND_WRITE)
}

/// On other systems the standard library gives no way to tell.
#[cfg(not(target_os = "linux"))]
fn is_closed() -> bool {
    false
}
