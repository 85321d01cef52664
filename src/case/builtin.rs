//! The built-in cases: their files are compiled into the program, so that they are available in every folder. The page
//! in their folder has a section for each group, with links to its cases.

use std::sync::LazyLock;

use include_dir::{Dir, File, include_dir};

/// The purpose of a built-in case; cases are listed in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// The cases of the paper.
    Paper,
    /// Other potentials, forms and settings; each case shows one of them.
    Basic,
    /// Cases at the edge of what a scheme can do, and beyond it.
    Hard,
    /// Scenes of several coordinates that move by Newton's law.
    Newtonian,
    /// Scenes in relativity, light, and geodesics of curved spaces.
    Curved,
}

impl Group {
    /// Its heading in lists; basic and hard cases share one.
    pub fn heading(self) -> &'static str {
        match self {
            Self::Paper => "The paper's cases",
            Self::Basic | Self::Hard => "One coordinate: other potentials, settings and units",
            Self::Newtonian => "Newton's law in several coordinates",
            Self::Curved => "Relativity, black holes, light and curved spaces",
        }
    }

    /// Returns true if its cases are scenes of several coordinates.
    pub fn is_scene(self) -> bool {
        matches!(self, Self::Newtonian | Self::Curved)
    }
}

static FILES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/cases");

/// Every built-in case as (name, group, text of its file), in the order of the groups and of the names.
static ALL: LazyLock<Vec<(&str, Group, &str)>> = LazyLock::new(|| {
    let page = FILES.get_file("README.md").and_then(File::contents_utf8).expect("it is a page");
    let groups = [Group::Paper, Group::Basic, Group::Hard, Group::Newtonian, Group::Curved];
    let mut all = Vec::new();
    for (group, section) in groups.into_iter().zip(page.split("\n## ").skip(1)) {
        let links = section.split("[`").skip(1).filter_map(|link| link.split_once("`](")?.1.split_once(')'));
        let mut files: Vec<&File<'_>> = links.filter_map(|(path, _)| FILES.get_file(path)).collect();
        files.sort_by_key(|file| file.path().file_stem());
        let name = |file: &File<'static>| file.path().file_stem()?.to_str();
        all.extend(files.into_iter().filter_map(|file| Some((name(file)?, group, file.contents_utf8()?))));
    }
    all
});

/// The names of the built-in cases, group by group: their files' names without folder and extension.
pub static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| ALL.iter().map(|(name, ..)| *name).collect());

/// The text of the built-in case `name`, if there is one.
pub fn text(name: &str) -> Option<&'static str> {
    found(name).map(|(_, _, text)| *text)
}

/// The group of the built-in case `name`, if there is one.
pub fn group(name: &str) -> Option<Group> {
    found(name).map(|(_, group, _)| *group)
}

fn found(name: &str) -> Option<&'static (&'static str, Group, &'static str)> {
    ALL.iter().find(|(known, _, _)| *known == name)
}

/// The first line of a case file without its `#`: a sentence that says what the case is. Empty if that line is no
/// comment.
pub fn description(text: &str) -> &str {
    text.lines().next().and_then(|line| line.strip_prefix('#')).map_or("", str::trim)
}
