//! The record of the files that the program wrote into a folder. Only files that it lists may be replaced or removed.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use anyhow::Context;
use atomic_write_file::AtomicWriteFile;
use serde::{Deserialize, Serialize};

/// The name of the record's file.
const NAME: &str = ".geodesic-ivp-manifest.json";

/// The command and the case that the files of a folder come from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// The subcommand.
    pub command: String,
    /// The path of the case, or `<stdin>`, or the name of a built-in case in angle brackets.
    pub case: String,
}

/// True if all files of a set are there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum State {
    /// All files that are listed are there.
    Complete,
    /// The files are being replaced, or the program was killed while it did so: some may be missing.
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
    /// Names of the files in the folder.
    pub(super) files: Vec<String>,
}

impl Manifest {
    pub(super) fn new(origin: &Origin, state: State, files: &[&str]) -> Self {
        let [program, version] = [env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION")].map(str::to_owned);
        let files = files.iter().map(|&name| name.to_owned()).collect();
        Self { program, version, origin: origin.clone(), state, files }
    }

    /// The record of `folder`, if there is one.
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
        // A record must not make the program touch anything outside the folder.
        if let Some(name) = manifest.files.iter().find(|name| Path::new(name).file_name() != Some(name.as_ref())) {
            anyhow::bail!("{} lists '{name}', which is not the name of a file", path.display());
        }
        Ok(Some(manifest))
    }

    /// Writes the record into `folder`, replacing an earlier one in a single step.
    pub(super) fn write(&self, folder: &Path) -> anyhow::Result<()> {
        let path = folder.join(NAME);
        let write = || {
            let mut file = AtomicWriteFile::open(&path)?;
            file.write_all(super::json::json(self).as_bytes())?;
            file.commit()
        };
        write().with_context(|| format!("cannot write {}", path.display()))
    }

    /// Removes the record of `folder`, if there is one.
    pub(super) fn remove(folder: &Path) -> anyhow::Result<()> {
        let path = folder.join(NAME);
        super::files::remove(&path).with_context(|| format!("cannot remove {}", path.display()))
    }
}

/// The command and the case that the files of `folder` come from, if the program wrote there.
///
/// # Errors
/// If the folder's record cannot be read.
pub fn origin_of(folder: &Path) -> anyhow::Result<Option<Origin>> {
    Ok(Manifest::read(folder)?.map(|manifest| manifest.origin))
}
