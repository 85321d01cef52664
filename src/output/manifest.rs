//! The record of what the program wrote into a folder: what it lists, and nothing else, may be replaced or taken away.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use anyhow::Context;
use atomic_write_file::AtomicWriteFile;
use serde::{Deserialize, Serialize};

/// The record's name.
const NAME: &str = ".geodesic-ivp-manifest.json";

/// Which command made the files of a folder, of which case.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// The subcommand.
    pub command: String,
    /// The case: its path, or what stands for one.
    pub case: String,
}

/// Whether a folder's files belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum State {
    /// All that are listed are there.
    Complete,
    /// They are being replaced, or the program that did so was killed: some may be missing.
    Incomplete,
}

/// The record.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Manifest {
    program: String,
    version: String,
    #[serde(flatten)]
    pub(super) origin: Origin,
    pub(super) state: State,
    /// Names in the folder.
    pub(super) files: Vec<String>,
}

impl Manifest {
    pub(super) fn new(origin: Origin, state: State, files: Vec<String>) -> Self {
        let [program, version] = [env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION")].map(str::to_owned);
        Self { program, version, origin, state, files }
    }

    /// The record of `folder`, if there is one.
    ///
    /// # Errors
    /// If it cannot be read or is none.
    pub(super) fn read(folder: &Path) -> anyhow::Result<Option<Self>> {
        let path = folder.join(NAME);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
                return Ok(None);
            }
            Err(error) => return Err(error).with_context(|| format!("cannot read {}", path.display())),
        };
        let manifest: Self = serde_json::from_str(&text).with_context(|| {
            format!("{} is not a record of this program's files: remove it, or choose another folder", path.display())
        })?;
        // Nothing outside the folder is ever touched, whatever a record says.
        if let Some(name) = manifest.files.iter().find(|name| Path::new(name).file_name() != Some(name.as_ref())) {
            anyhow::bail!("{} lists '{name}', which is not the name of a file", path.display());
        }
        Ok(Some(manifest))
    }

    /// Puts the record in place, whole.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(super) fn write(&self, folder: &Path) -> anyhow::Result<()> {
        let path = folder.join(NAME);
        let write = || {
            let mut file = AtomicWriteFile::open(&path)?;
            file.write_all(super::summary::json(self).as_bytes())?;
            file.commit()
        };
        write().with_context(|| format!("cannot write {}", path.display()))
    }

    /// Takes the record away.
    ///
    /// # Errors
    /// If it is there and cannot be.
    pub(super) fn remove(folder: &Path) -> anyhow::Result<()> {
        let path = folder.join(NAME);
        super::files::remove(&path).with_context(|| format!("cannot remove {}", path.display()))
    }
}

/// Which command and case the files of `folder` are of, if the program wrote there.
///
/// # Errors
/// If the folder's record cannot be read.
pub fn origin_of(folder: &Path) -> anyhow::Result<Option<Origin>> {
    Ok(Manifest::read(folder)?.map(|manifest| manifest.origin))
}
