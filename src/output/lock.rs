//! One program at a time in a folder.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Context;

/// Held while files are put in place, and taken away afterwards; one that a killed program left behind binds nobody.
const NAME: &str = ".geodesic-ivp.lock";

/// Putting files in place takes milliseconds; a program that takes this long is not going to let go.
const PATIENCE: Duration = Duration::from_secs(30);

/// The only program in a folder, for as long as it lives.
#[derive(Debug)]
pub(super) struct FolderLock {
    path: PathBuf,
    /// The operating system lets go of the lock with the file, however the program ends.
    _file: File,
}

impl FolderLock {
    /// Waits until no other program is in `folder`.
    ///
    /// # Errors
    /// If the folder cannot be written to, or another program does not leave it.
    pub(super) fn wait(folder: &Path) -> anyhow::Result<Self> {
        let path = folder.join(NAME);
        let start = Instant::now();
        loop {
            let cannot = || format!("cannot write {}", path.display());
            let file = File::options().create(true).truncate(false).write(true).open(&path).with_context(cannot)?;
            match file.try_lock() {
                // The one before may have taken away the file that was just locked.
                Ok(()) if is_at(&file, &path) => return Ok(Self { path, _file: file }),
                Ok(()) => {}
                Err(TryLockError::WouldBlock) if start.elapsed() < PATIENCE => {
                    std::thread::sleep(Duration::from_millis(2));
                }
                Err(TryLockError::WouldBlock) => {
                    anyhow::bail!("another program has been writing into {} for {PATIENCE:?}", folder.display());
                }
                // Some network file systems know no locks: there two programs in one folder are the user's to avoid.
                Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => {
                    return Ok(Self { path, _file: file });
                }
                Err(TryLockError::Error(error)) => return Err(error).with_context(cannot),
            }
        }
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // While the lock is still held, so that nobody holds a lock on a file that is gone. If it stays, it does no harm.
        let _ = fs::remove_file(&self.path);
    }
}

/// Whether `path` still leads to `file`.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;

    let identity = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    match (file.metadata(), fs::metadata(path)) {
        (Ok(file), Ok(path)) => identity(file) == identity(path),
        _ => false,
    }
}

/// Elsewhere an open file cannot be taken away.
#[cfg(not(unix))]
fn is_at(_file: &File, _path: &Path) -> bool {
    true
}
