//! The files of the program: modules and the files of the engine import each other in one direction only, nothing comes
//! in two kinds, files and functions are short, and so are lines, as in the pages.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::pages::{Page, Part};
use crate::common::ROOT;

/// The rooms of the library, from low to high. The command layer stands above all of them.
const LAYERS: [&str; 16] = [
    "number",
    "formula",
    "linalg",
    "sbp",
    "geometry",
    "engine",
    "proof",
    "reference",
    "methods",
    "action",
    "solve",
    "diagnostics",
    "trajectory",
    "case",
    "study",
    "output",
];

const MOST_COLUMNS: usize = 120;
const MOST_LINES_OF_FILE: usize = 400;
const MOST_LINES_OF_FUNCTION: usize = 60;

/// The page that a script writes has longer lines.
const LONGER: &str = "docs/measured.md";

/// Every file of Rust in a folder of the project, by its path in there, and its text.
fn sources(folder: &str) -> Vec<(String, String)> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    let (root, mut files) = (Path::new(ROOT).join(folder), Vec::new());
    walk(&root, &mut files);
    let inside = |path: &Path| path.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/");
    files.iter().map(|path| (inside(path), fs::read_to_string(path).unwrap())).collect()
}

/// The text behind the item that it begins with, which ends with a semicolon or with its braces.
fn behind_item(text: &str) -> &str {
    let mut depth = 0;
    let end = text.find(|c| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        depth == 0 && (c == '}' || c == ';')
    });
    end.map_or("", |end| &text[end + 1..])
}

/// A program text without comments and without items that are for tests.
fn code(text: &str) -> String {
    let mut parts = text.split("#[cfg(test)]");
    let first = parts.next().unwrap_or_default();
    let text: String = std::iter::once(first).chain(parts.map(behind_item)).collect();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

#[test]
fn modules_import_only_what_is_below_them() {
    let rank = |name: &str| LAYERS.iter().position(|layer| *layer == name);
    let word = |rest: &str| rest.chars().take_while(|c| c.is_ascii_lowercase() || *c == '_').collect::<String>();
    let files = sources("src");
    let mut seen = 0;
    for (file, text) in &files {
        let module = file.split('/').next().unwrap();
        if ["cli", "main.rs", "lib.rs"].contains(&module) {
            continue;
        }
        let own = rank(module).unwrap_or_else(|| panic!("the module {module} has no layer"));
        for import in code(text).split("crate::").skip(1).map(word).filter(|name| !name.is_empty()) {
            let other = rank(&import).unwrap_or_else(|| panic!("{file}: crate::{import} has no layer"));
            assert!(other <= own, "{file}: {module} is below {import}");
            seen += 1;
        }
    }
    assert!(files.len() > 100 && seen > 200, "{} files, {seen} imports were found", files.len());
}

/// Returns what a file of a room imports from others of it: the first words of `use super::…`, but for names that
/// modules hand on.
fn neighbours(text: &str, file: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for import in code(text).split("use super::").skip(1) {
        let mut import = import.split(';').next().unwrap_or_default();
        let mut folder = Path::new(file).parent();
        while let Some(outer) = import.strip_prefix("super::") {
            (import, folder) = (outer, folder.and_then(Path::parent));
        }
        // In a list only single words name modules; in a path the first one does.
        let names: Vec<&str> = match import.strip_prefix('{') {
            Some(list) => list.trim_end_matches('}').split(',').collect(),
            None => vec![import],
        };
        for name in names.iter().filter_map(|name| name.split("::").next()).map(str::trim) {
            if name.starts_with(|c: char| c.is_ascii_lowercase()) {
                found.insert(folder.unwrap_or(Path::new("")).join(name).to_str().unwrap().replace('\\', "/"));
            }
        }
    }
    found
}

/// Files in a circle, if there is one: what is left after all files that import nothing that is left are taken away.
fn circle(mut graph: BTreeMap<String, BTreeSet<String>>) -> Vec<String> {
    loop {
        let rest: BTreeSet<String> = graph.keys().cloned().collect();
        graph.retain(|_, imports| !imports.is_disjoint(&rest));
        if graph.len() == rest.len() {
            return graph.into_keys().collect();
        }
    }
}

#[test]
fn files_of_a_room_import_each_other_in_one_direction() {
    for room in LAYERS.iter().chain(&["cli"]).filter(|room| Path::new("src").join(room).is_dir()) {
        let files = sources(&format!("src/{room}")).into_iter().map(|(file, text)| (file.replace(".rs", ""), text));
        // Modules only name their parts, and define what all of them share.
        let files = files.filter(|(name, _)| !name.ends_with("mod") && !name.ends_with("tests"));
        let graph: BTreeMap<_, _> = files.map(|(name, text)| (name.clone(), neighbours(&text, &name))).collect();
        if *room == "engine" {
            assert!(graph["sweeps"].contains("window") && graph["window"].contains("system"));
            let mut ring = graph.clone();
            ring.get_mut("system").unwrap().insert("sweeps".to_owned());
            assert!(circle(ring).len() > circle(graph.clone()).len());
        }
        let found = circle(graph);
        assert!(found.is_empty(), "{room}: in a circle, or above one: {found:?}");
    }
}

/// The public types, traits and functions of a text.
fn public(text: &str) -> impl Iterator<Item = &str> {
    let items = text.lines().filter_map(|line| line.trim_start().strip_prefix("pub "));
    items.filter_map(|item| {
        let item = item.strip_prefix("const ").unwrap_or(item);
        let named = ["struct ", "enum ", "trait ", "type ", "fn "].iter().find_map(|kind| item.strip_prefix(kind))?;
        named.split(|c: char| !c.is_alphanumeric() && c != '_').next()
    })
}

/// Solvers, references, samplers, diagnostics, tables and studies have the space-time as a parameter: what is there for
/// scenes has no twin for one coordinate.
#[test]
fn nothing_comes_in_two_kinds() {
    let files = sources("src");
    let names: BTreeSet<&str> = files.iter().flat_map(|(_, text)| public(text)).collect();
    assert!(names.contains("Sampler") && names.contains("solve") && names.contains("Case"), "{names:?}");
    let twins = |name: &str| match name.strip_prefix("Scene") {
        Some(bare) => [bare.to_owned(), format!("Reference{bare}")],
        None => [name.replacen("_scene", "", 1), name.replacen("scene_", "", 1)],
    };
    // What is left of `of_scene`, a way to make something, is no name.
    let has_twin =
        |name: &str| twins(name).iter().any(|twin| twin.len() > 2 && twin != name && names.contains(twin.as_str()));
    let found: Vec<_> = names.iter().filter(|name| name.to_lowercase().contains("scene") && has_twin(name)).collect();
    assert!(found.is_empty(), "{found:?}");
}

/// The functions of a formatted text: their first lines, and how many lines they have.
fn functions(text: &str) -> Vec<(&str, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let begins = |line: &str| {
        let words = line.trim_start();
        let restricted = words.split_once(") ").filter(|(visible, _)| visible.starts_with("pub("));
        let words = words.strip_prefix("pub ").or(restricted.map(|(_, rest)| rest)).unwrap_or(words);
        words.starts_with("fn ") || words.starts_with("const fn ")
    };
    let mut found = Vec::new();
    for (first, line) in lines.iter().enumerate().filter(|(_, line)| begins(line)) {
        let indent = &line[..line.len() - line.trim_start().len()];
        let is_end = |line: &&str| line.strip_prefix(indent).is_some_and(|rest| ["}", ");", ";"].contains(&rest));
        let is_short = line.ends_with(';') || line.ends_with('}');
        let count = if is_short { 1 } else { 1 + lines[first..].iter().position(is_end).unwrap_or(0) };
        found.push((*line, count));
    }
    found
}

#[test]
fn files_and_functions_are_short() {
    let mut seen = 0;
    for (file, text) in sources("src") {
        let count = text.lines().count();
        assert!(count <= MOST_LINES_OF_FILE, "{file} has {count} lines");
        for (first, count) in functions(&text) {
            seen += 1;
            assert!(count <= MOST_LINES_OF_FUNCTION, "{file}: {first} has {count} lines");
        }
    }
    assert!(seen > 500, "{seen} functions");
    let long = format!("    fn long() {{\n{}    }}\n", "        f();\n".repeat(70));
    assert_eq!(functions(&long), [("    fn long() {", 72)]);
}

fn is_long(line: &str) -> bool {
    line.chars().count() > MOST_COLUMNS && !line.contains("://")
}

/// The long lines of a page. Rows of tables cannot be broken, nor can what the program prints.
fn long_in_page(page: &Page) -> impl Iterator<Item = &str> {
    let lines = page.parts.iter().flat_map(|part| match part {
        Part::Line(line) if line.starts_with('|') => Vec::new(),
        Part::Line(line) => vec![line.as_str()],
        Part::Block(block) if block.info == "text" => Vec::new(),
        Part::Block(block) => block.text.lines().collect(),
    });
    lines.filter(|line| is_long(line))
}

#[test]
fn lines_of_pages_and_programs_fit_into_120_columns() {
    let mut long = Vec::new();
    for folder in ["src", "tests", "examples", "benches"] {
        for (file, text) in sources(folder) {
            long.extend(text.lines().filter(|line| is_long(line)).map(|line| format!("{folder}/{file}: {line}")));
        }
    }
    for page in Page::all().into_iter().chain([Page::named("CHANGELOG.md")]).filter(|page| page.name() != LONGER) {
        long.extend(long_in_page(&page).map(|line| format!("{}: {line}", page.name())));
    }
    assert!(long.is_empty(), "more than {MOST_COLUMNS} columns:\n{}", long.join("\n"));
}

#[test]
fn a_long_line_would_be_found() {
    let (long, row) = ("ö".repeat(MOST_COLUMNS + 1), format!("|{}|", "x".repeat(MOST_COLUMNS)));
    let url = format!("https://example.org/{long}");
    assert!(is_long(&long) && !is_long(&"ö".repeat(MOST_COLUMNS)) && !is_long(&url));
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("page.md");
    fs::write(&path, format!("{long}\n{row}\n```text\n{long}\n```\n```sh\n{long}\n```\n")).unwrap();
    assert_eq!(long_in_page(&Page::read(path)).collect::<Vec<_>>(), [&long, &long]);
}
