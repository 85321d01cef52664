//! The built-in cases: their files are compiled into the program, so that they are available in every folder. The page
//! in their folder has links to all of them, in sections.

use std::collections::HashMap;
use std::sync::LazyLock;

use include_dir::{Dir, include_dir};

static FILES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/cases");

/// A built-in case.
#[derive(Debug, Clone, Copy)]
pub struct BuiltIn {
    /// The name of its file without folder and extension.
    pub name: &'static str,
    /// The heading of its section.
    pub heading: &'static str,
    /// The folder of its file: `scenes` for those of several coordinates, `hard` for cases at the edge of what a scheme
    /// can do, or nothing.
    pub folder: &'static str,
    /// The text of its file.
    pub text: &'static str,
}

/// All built-in cases, section by section, in the order of their folders and names.
pub static ALL: LazyLock<Vec<BuiltIn>> = LazyLock::new(|| {
    // A search of the folder for each of them would compare every path with every other one.
    let folders = std::iter::once(&FILES).chain(FILES.dirs());
    let texts: HashMap<&str, &str> =
        folders.flat_map(Dir::files).filter_map(|file| Some((file.path().to_str()?, file.contents_utf8()?))).collect();
    let mut all = Vec::new();
    for section in texts["README.md"].split("\n## ").skip(1) {
        let heading = section.lines().next().unwrap_or_default();
        let links = section.split("[`").skip(1).filter_map(|link| link.split_once("`](")?.1.split_once(".toml)"));
        let built_in = |(path, _): (&'static str, &str)| {
            let (folder, name) = path.split_once('/').unwrap_or(("", path));
            BuiltIn { name, heading, folder, text: texts[format!("{path}.toml").as_str()] }
        };
        let mut cases: Vec<BuiltIn> = links.map(built_in).collect();
        cases.sort_by_key(|case| (case.folder, case.name));
        all.extend(cases);
    }
    all
});

/// Their names.
pub static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| ALL.iter().map(|case| case.name).collect());

/// The text of the built-in case `name`, if there is one.
pub fn text(name: &str) -> Option<&'static str> {
    ALL.iter().find(|case| case.name == name).map(|case| case.text)
}

/// The first line of a case file without its `#`: a sentence that says what the case is. Empty if that line is no
/// comment.
pub fn description(text: &str) -> &str {
    text.lines().next().and_then(|line| line.strip_prefix('#')).map_or("", str::trim)
}
