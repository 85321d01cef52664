//! The output files of a command. They appear all together, and each of them is complete.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use atomic_write_file::AtomicWriteFile;
use serde::{Deserialize, Serialize};

use super::json::json;
use super::leftovers;
use super::lock::FolderLock;
use crate::case::{MOST_OF_SUMMARY, read_text};

/// The summary of a command. It is put in place last and removed first: if it is there, all the others are there too.
pub const SUMMARY: &str = "summary.json";
/// The effective case, with every default.
pub const CASE: &str = "case.toml";
/// The record of the files that the program wrote into a folder. Only files that it lists may be replaced or removed.
const MANIFEST: &str = ".geodesic-ivp-manifest.json";
/// The states of a set: all files are there; or they are being replaced, or the program was killed while it did so, and
/// some may be missing.
const COMPLETE: &str = "complete";
const INCOMPLETE: &str = "incomplete";

/// The command and the case that the files of a folder come from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// The subcommand.
    pub command: String,
    /// The path of the case, or `<stdin>`, or the name of a built-in case in angle brackets.
    pub case: String,
}

/// The record.
#[derive(Serialize, Deserialize)]
struct Manifest {
    program: String,
    version: String,
    #[serde(flatten)]
    origin: Origin,
    state: String,
    /// Names of the files in the folder.
    files: Vec<String>,
}

/// Where files go, which command and case they belong to, and what they may replace.
#[derive(Debug, Clone)]
pub struct Target {
    /// The folder.
    pub folder: PathBuf,
    /// Command and case.
    pub origin: Origin,
    /// True if the program chose the folder, for this origin alone. Then files of another origin are not replaced.
    pub own: bool,
    /// True if files that the program did not write may be replaced.
    pub force: bool,
}

/// The set of files that a command writes into a folder. They are written under temporary names and put in place
/// together.
///
/// A set replaces the previous one completely; files that the program did not write are left alone. If several
/// processes write into the same folder, they put their sets in place one after the other. A process that is killed
/// leaves the previous set, its own set, or a part of one of them without its summary.
#[derive(Debug)]
pub struct OutputSet {
    target: Target,
    pending: Vec<(&'static str, AtomicWriteFile)>,
    /// Dropped last, when no file of the set is open any more.
    _made: MadeFolders,
}

/// The folders that a command has made, inner ones first. Those that are left empty are removed.
#[derive(Debug)]
struct MadeFolders(Vec<PathBuf>);

impl MadeFolders {
    /// Makes a folder and what is missing around it.
    fn make(folder: &Path) -> anyhow::Result<Self> {
        let missing = folder.ancestors().take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists());
        let made = Self(missing.map(Path::to_owned).collect());
        let cannot = || format!("cannot create the output directory {}", folder.display());
        fs::create_dir_all(folder).with_context(cannot)?;
        Ok(made)
    }
}

impl Drop for MadeFolders {
    fn drop(&mut self) {
        // A folder with files is not removed by this.
        self.0.iter().for_each(|folder| drop(fs::remove_dir(folder)));
    }
}

/// A refusal of what the user asks for, or because of what is in the way; and what to do about it.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct Refused {
    message: String,
    /// What to do about it; empty where that is obvious.
    pub help: String,
    /// True if the command is at fault, and not a file, the system or another process.
    pub is_usage: bool,
}

/// The refusal of a command that asks for what cannot be done, with what to do instead.
pub fn refused(message: impl Into<String>, help: impl Into<String>) -> anyhow::Error {
    Refused { message: message.into(), help: help.into(), is_usage: true }.into()
}

/// A refusal because of a file, a stream or the system, with what to do about it.
pub fn refused_by_system(message: impl Into<String>, help: impl Into<String>) -> anyhow::Error {
    Refused { message: message.into(), help: help.into(), is_usage: false }.into()
}

/// The record of `folder`, if there is one.
fn manifest_of(folder: &Path) -> anyhow::Result<Option<Manifest>> {
    let path = folder.join(MANIFEST);
    let text = match read_text(&path, MOST_OF_SUMMARY) {
        Ok(text) => text,
        Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
            return Ok(None);
        }
        Err(error) => return Err(error).with_context(|| format!("cannot read {}", path.display())),
    };
    let manifest: Manifest = serde_json::from_str(&text).with_context(|| {
        format!("{} is not a record of this program's files: remove it, or choose another folder", path.display())
    })?;
    // A record must not make the program touch anything outside the folder.
    if let Some(name) = manifest.files.iter().find(|name| Path::new(name).file_name() != Some(name.as_ref())) {
        anyhow::bail!("{} lists '{name}', which is not the name of a file", path.display());
    }
    Ok(Some(manifest))
}

/// The command and the case that the files of `folder` come from, if the program wrote there.
///
/// # Errors
/// If the folder's record cannot be read.
pub fn origin_of(folder: &Path) -> anyhow::Result<Option<Origin>> {
    Ok(manifest_of(folder)?.map(|manifest| manifest.origin))
}

impl Target {
    /// Records the files of the folder, in place of an earlier record and in a single step; without files, nothing.
    fn record(&self, state: &str, files: &[&str]) -> anyhow::Result<()> {
        let path = self.folder.join(MANIFEST);
        if files.is_empty() {
            return remove(&path).with_context(|| format!("cannot remove {}", path.display()));
        }
        let [program, version] = [env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION")].map(str::to_owned);
        let (origin, files) = (self.origin.clone(), files.iter().map(|&name| name.to_owned()).collect());
        let text = json(&Manifest { program, version, origin, state: state.to_owned(), files });
        let write = || {
            let mut file = AtomicWriteFile::open(&path)?;
            file.write_all(text.as_bytes())?;
            file.commit()
        };
        write().with_context(|| format!("cannot write {}", path.display()))
    }

    /// The record of the set that is in the folder, if there is one.
    fn before(&self, names: &[&str]) -> anyhow::Result<Option<Manifest>> {
        let before = manifest_of(&self.folder)?;
        if let Some(other) = before.as_ref().filter(|before| self.own && before.origin != self.origin) {
            let Origin { command, case } = &other.origin;
            anyhow::bail!("{} holds the results of {command} {case} by now", self.folder.display());
        }
        let mut foreign = Vec::new();
        for &name in names {
            let path = self.folder.join(name);
            if path.is_dir() {
                anyhow::bail!("cannot write {}: it is a directory", path.display());
            }
            let listed = before.as_ref().is_some_and(|before| before.files.iter().any(|listed| listed == name));
            if !(self.force || listed) && path.symlink_metadata().is_ok() {
                foreign.push(name);
            }
        }
        if foreign.is_empty() {
            return Ok(before);
        }
        let (folder, names) = (self.folder.display(), foreign.join(", "));
        let message = format!(
            "{folder} holds files of these names already, and nothing says that this program wrote them: {names}"
        );
        let help = "move them away, choose another folder with --out, or replace them with --force";
        Err(refused_by_system(message, help))
    }

    /// Removes a file of the previous set. With `through_links`, the target of a symbolic link is removed and not the
    /// link.
    fn take_away(&self, name: &str, through_links: bool) -> anyhow::Result<()> {
        let link = self.folder.join(name);
        let path = if through_links { fs::canonicalize(&link).unwrap_or(link) } else { link };
        // The program has not made a folder of that name.
        if path.is_dir() {
            return Ok(());
        }
        remove(&path).with_context(|| format!("cannot remove the outdated {}", path.display()))
    }
}

/// Removes a file that may be missing.
fn remove(path: &Path) -> io::Result<()> {
    fs::remove_file(path).or_else(|error| match error.kind() {
        io::ErrorKind::NotFound => Ok(()),
        _ => Err(error),
    })
}

impl OutputSet {
    /// Creates the folder, which is removed again if nothing comes into it, and opens the named files in it. A folder
    /// that cannot be written, or files that may not be replaced, are thus found before a long computation.
    ///
    /// # Errors
    /// If the folder cannot be made, a file in it cannot be written, or one of these names is a user's file.
    pub fn open(target: Target, names: &[&'static str]) -> anyhow::Result<Self> {
        let folder = &target.folder;
        let made = MadeFolders::make(folder)?;
        let _lock = FolderLock::wait(folder)?;
        let before = target.before(names)?;
        let recorded = before.iter().flat_map(|before| before.files.iter().map(String::as_str));
        leftovers::remove(folder, names.iter().copied().chain([MANIFEST]).chain(recorded));
        let incomplete = before.filter(|before| before.state == INCOMPLETE);
        // An incomplete set without its summary is removed. One with a summary is complete after all: the program was
        // killed before it could record that.
        if let Some(before) = incomplete.filter(|_| !folder.join(SUMMARY).exists()) {
            before.files.iter().try_for_each(|name| target.take_away(name, false))?;
            target.record(COMPLETE, &[])?;
        }
        let pending = names
            .iter()
            .map(|&name| {
                // A symbolic link is followed, so that its target is replaced and the link stays.
                let path = folder.join(name);
                let path = fs::canonicalize(&path).unwrap_or(path);
                let file = AtomicWriteFile::options().read(true).open(&path);
                let file = file.with_context(|| format!("cannot write {}", path.display()))?;
                leftovers::hold(file.as_file());
                Ok((name, file))
            })
            .collect::<anyhow::Result<_>>()?;
        Ok(Self { target, pending, _made: made })
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.target.folder
    }

    /// An opened file, to write to from any thread, and to read from what is written. It is not buffered.
    ///
    /// # Panics
    /// If `name` was not opened.
    pub fn writer(&self, name: &str) -> &File {
        let (_, file) = self.pending.iter().find(|(n, _)| *n == name).expect("the file was opened");
        file.as_file()
    }

    /// Writes a table into an opened file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_table(&self, name: &str, write: impl FnOnce(&File) -> csv::Result<()>) -> anyhow::Result<()> {
        write(self.writer(name)).with_context(|| format!("cannot write {name}"))
    }

    /// Writes the whole content of an opened file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_text(&self, name: &str, text: &str) -> anyhow::Result<()> {
        self.writer(name).write_all(text.as_bytes()).with_context(|| format!("cannot write {name}"))
    }

    /// Replaces the previous set by the files whose names satisfy `keep`, so that the folder never mixes the results of
    /// two commands. Returns the names of these files.
    ///
    /// # Errors
    /// If a file cannot be put in place, or a user's file has meanwhile taken its name.
    pub fn commit(self, keep: &dyn Fn(&str) -> bool) -> anyhow::Result<Vec<&'static str>> {
        let Self { target, mut pending, _made } = self;
        pending.retain(|(name, _)| keep(name));
        // Writing to the disk may take long, so it is done while the previous set is still there.
        for (name, file) in &pending {
            file.as_file().sync_all().with_context(|| format!("cannot write {name}"))?;
        }
        let names: Vec<&'static str> = pending.iter().map(|(name, _)| *name).collect();
        let folder = &target.folder;

        let _lock = FolderLock::wait(folder)?;
        let before = target.before(&names)?;
        let outdated = before.iter().flat_map(|before| before.files.iter().map(String::as_str));
        let mut all: Vec<&str> = outdated.filter(|name| !names.contains(name)).chain(names.iter().copied()).collect();
        if all.is_empty() {
            return Ok(names);
        }
        target.record(INCOMPLETE, &all)?;
        // The summary is removed first and put in place last.
        all.sort_by_key(|name| *name != SUMMARY);
        for name in all {
            target.take_away(name, names.contains(&name))?;
        }
        pending.sort_by_key(|(name, _)| *name == SUMMARY);
        for (name, file) in pending {
            file.commit().with_context(|| format!("cannot write {}", folder.join(name).display()))?;
        }
        target.record(COMPLETE, &names)?;
        Ok(names)
    }
}
