//! The pages, and what they are made of.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::ROOT;

/// A Markdown page.
pub(crate) struct Page {
    pub(crate) path: PathBuf,
    pub(crate) parts: Vec<Part>,
}

/// A page is a sequence of these.
pub(crate) enum Part {
    /// A line outside code blocks.
    Line(String),
    /// A code block.
    Block(Block),
}

/// A code block.
pub(crate) struct Block {
    /// The words behind the fence.
    pub(crate) info: String,
    pub(crate) text: String,
}

impl Page {
    pub(crate) fn read(path: PathBuf) -> Self {
        let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let mut parts = Vec::new();
        let mut lines = text.lines();
        while let Some(line) = lines.next() {
            match line.strip_prefix("```") {
                Some(info) => {
                    let body: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
                    parts.push(Part::Block(Block { info: info.trim().to_owned(), text: body.join("\n") + "\n" }));
                }
                None => parts.push(Part::Line(line.to_owned())),
            }
        }
        Self { path, parts }
    }

    /// Every page: README.md, CONTRIBUTING.md, docs/ and the index of the cases.
    pub(crate) fn all() -> Vec<Self> {
        let mut paths: Vec<PathBuf> = fs::read_dir(Path::new(ROOT).join("docs"))
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
            .collect();
        paths.sort();
        paths.extend(["README.md", "CONTRIBUTING.md", "cases/README.md"].map(|name| Path::new(ROOT).join(name)));
        paths.into_iter().map(Self::read).collect()
    }

    pub(crate) fn named(name: &str) -> Self {
        Self::read(Path::new(ROOT).join(name))
    }

    /// Its name for people.
    pub(crate) fn name(&self) -> String {
        self.path.strip_prefix(ROOT).unwrap().display().to_string()
    }

    pub(crate) fn lines(&self) -> impl Iterator<Item = &str> {
        self.parts.iter().filter_map(|part| match part {
            Part::Line(line) => Some(line.as_str()),
            Part::Block(_) => None,
        })
    }

    pub(crate) fn blocks(&self) -> impl Iterator<Item = &Block> {
        self.parts.iter().filter_map(|part| match part {
            Part::Line(_) => None,
            Part::Block(block) => Some(block),
        })
    }

    /// The cells of every row of its tables, without code marks.
    pub(crate) fn rows(&self) -> impl Iterator<Item = Vec<String>> {
        let rows = self.lines().filter_map(|line| line.strip_prefix('|')?.strip_suffix('|'));
        let cell = |cell: &str| cell.trim().replace('`', "").replace('\0', "|");
        rows.map(move |row| row.replace("\\|", "\0").split('|').map(cell).collect())
    }
}
