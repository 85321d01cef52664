//! Output files that appear whole or not at all.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use atomic_write_file::AtomicWriteFile;

/// Files of one directory that are written beside their final names and put in place together.
#[derive(Debug)]
pub struct OutputSet {
    directory: PathBuf,
    pending: Vec<(&'static str, AtomicWriteFile)>,
}

impl OutputSet {
    /// Creates `directory` and opens the named files in it, so that an unwritable target is found before a long
    /// computation.
    ///
    /// # Errors
    /// If the directory cannot be made or a file in it cannot be written.
    pub fn open(directory: &Path, names: &[&'static str]) -> anyhow::Result<Self> {
        fs::create_dir_all(directory)
            .with_context(|| format!("cannot create the output directory {}", directory.display()))?;
        let pending = names
            .iter()
            .map(|&name| {
                let path = directory.join(name);
                if path.is_dir() {
                    anyhow::bail!("cannot write {}: it is a directory", path.display());
                }
                // Through a link to what it points to, which keeps its place and its mode.
                let path = fs::canonicalize(&path).unwrap_or(path);
                let file = AtomicWriteFile::open(&path).with_context(|| format!("cannot write {}", path.display()))?;
                Ok((name, file))
            })
            .collect::<anyhow::Result<_>>()?;
        Ok(Self { directory: directory.to_owned(), pending })
    }

    /// A file that was opened, unbuffered, to be written from any thread.
    ///
    /// # Panics
    /// If `name` was not opened.
    pub fn writer(&self, name: &str) -> impl Write + '_ {
        let (_, file) = self.pending.iter().find(|(n, _)| *n == name).expect("the file was opened");
        file.as_file()
    }

    /// Writes a whole file that was opened.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_text(&self, name: &str, text: &str) -> anyhow::Result<()> {
        self.writer(name).write_all(text.as_bytes()).with_context(|| format!("cannot write {name}"))
    }

    /// Puts the files whose names satisfy `keep` in place and removes any of the others left by an earlier run, so that
    /// the directory never mixes the results of two. Returns the names that are there now.
    ///
    /// # Errors
    /// If a file cannot be put in place.
    pub fn commit(self, keep: impl Fn(&str) -> bool) -> anyhow::Result<Vec<&'static str>> {
        let mut kept = Vec::new();
        for (name, file) in self.pending {
            let path = self.directory.join(name);
            if keep(name) {
                file.commit().with_context(|| format!("cannot write {}", path.display()))?;
                kept.push(name);
            } else {
                drop(file);
                match fs::remove_file(&path) {
                    Err(error) if error.kind() != io::ErrorKind::NotFound => {
                        return Err(error).with_context(|| format!("cannot remove the outdated {}", path.display()));
                    }
                    _ => {}
                }
            }
        }
        Ok(kept)
    }
}
