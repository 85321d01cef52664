//! A lock on a folder, so that only one process at a time puts files in place there.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Context;

/// The file that is locked. It is removed afterwards. If a killed process leaves it behind, it is no longer locked.
const NAME: &str = ".geodesic-ivp.lock";

/// The time to wait for another process. Putting files in place takes milliseconds.
const PATIENCE: Duration = Duration::from_secs(30);

/// While this value exists, no other process puts files in place in the folder.
#[derive(Debug)]
pub(super) struct FolderLock {
    path: PathBuf,
    /// The operating system releases the lock when the file is closed, however the process ends.
    _file: File,
}

impl FolderLock {
    /// Waits until no other process has locked `folder`.
    pub(super) fn wait(folder: &Path) -> anyhow::Result<Self> {
        let path = folder.join(NAME);
        let start = Instant::now();
        loop {
            let cannot = || format!("cannot write {}", path.display());
            let file = File::options().create(true).truncate(false).write(true).open(&path).with_context(cannot)?;
            if !try_lock(&file).with_context(cannot)? {
                if start.elapsed() >= PATIENCE {
                    anyhow::bail!("another program has been writing into {} for {PATIENCE:?}", folder.display());
                }
                std::thread::sleep(Duration::from_millis(2));
            } else if is_at(&file, &path) {
                return Ok(Self { path, _file: file });
            }
            // The previous holder removed the file between its opening and its locking here.
        }
    }
}

/// Locks a file until it is closed. Returns false if another process has locked it.
pub(super) fn try_lock(file: &File) -> io::Result<bool> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Ok(false),
        // Some network file systems have no locks. There the user must not run two processes in one folder.
        Err(TryLockError::Error(error)) if error.kind() != io::ErrorKind::Unsupported => Err(error),
        Ok(()) | Err(TryLockError::Error(_)) => Ok(true),
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // The file is removed while the lock is still held: after its release, another process may have locked the
        // file. If it cannot be removed, it does no harm.
        let _ = fs::remove_file(&self.path);
    }
}

/// Returns true if `path` is still the path of `file`.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;

    let identity = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    match (file.metadata(), fs::metadata(path)) {
        (Ok(file), Ok(path)) => identity(file) == identity(path),
        _ => false,
    }
}

/// On other systems an open file cannot be removed.
#[cfg(not(unix))]
fn is_at(_file: &File, _path: &Path) -> bool {
    true
}
