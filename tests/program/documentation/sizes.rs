//! Files and functions are short, and the files of the engine import each other in one direction only.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::layers::{SOURCE, sources};

const MOST_LINES_OF_FILE: usize = 400;
const MOST_LINES_OF_FUNCTION: usize = 60;

fn texts(folder: impl AsRef<Path>) -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    sources(folder.as_ref(), &mut files);
    files.into_iter().map(|file| (file.clone(), fs::read_to_string(file).unwrap())).collect()
}

/// The functions of a formatted text: their first lines, and how many lines they have.
fn functions(text: &str) -> Vec<(&str, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let begins = |line: &str| {
        let words = line.trim_start();
        let words = words
            .strip_prefix("pub ")
            .or_else(|| words.split_once(") ").filter(|(v, _)| v.starts_with("pub(")).map(|(_, rest)| rest))
            .unwrap_or(words);
        words.starts_with("fn ") || words.starts_with("const fn ")
    };
    let mut found = Vec::new();
    for (first, line) in lines.iter().enumerate().filter(|(_, line)| begins(line)) {
        let indent = &line[..line.len() - line.trim_start().len()];
        let is_end =
            |line: &&str| line.strip_prefix(indent).is_some_and(|rest| rest == "}" || rest == ");" || rest == ";");
        let is_short = line.ends_with(';') || line.ends_with('}');
        let count = if is_short { 1 } else { 1 + lines[first..].iter().position(is_end).unwrap_or(0) };
        found.push((*line, count));
    }
    found
}

#[test]
fn files_and_functions_are_short() {
    let mut seen = 0;
    for (file, text) in texts(SOURCE) {
        let count = text.lines().count();
        assert!(count <= MOST_LINES_OF_FILE, "{} has {count} lines", file.display());
        for (first, count) in functions(&text) {
            seen += 1;
            assert!(count <= MOST_LINES_OF_FUNCTION, "{}: {first} has {count} lines", file.display());
        }
    }
    assert!(seen > 2000, "{seen} functions");
    let long = format!("    fn long() {{\n{}    }}\n", "        f();\n".repeat(70));
    assert_eq!(functions(&long), [("    fn long() {", 72)]);
}

/// Returns what a file of the engine imports from others of it: the first words of `use super::…`, but for names that
/// modules hand on.
fn imports(text: &str, file: &str) -> BTreeSet<String> {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let mut found = BTreeSet::new();
    for import in code.split("use super::").skip(1) {
        let mut import = import.split(';').next().unwrap_or_default();
        let mut folder = Path::new(file).parent();
        while let Some(outer) = import.strip_prefix("super::") {
            (import, folder) = (outer, folder.and_then(Path::parent));
        }
        let list = import.strip_prefix('{').map_or(import, |list| list.trim_end_matches('}'));
        // In a list only single words name modules; in a path the first one does.
        let names: Vec<&str> = if import.starts_with('{') { list.split(',').collect() } else { vec![list] };
        for name in names {
            let name = name.split("::").next().unwrap_or_default().trim();
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
        let before = graph.len();
        graph.retain(|_, imports| imports.iter().any(|import| rest.contains(import)));
        if graph.len() == before {
            return graph.into_keys().collect();
        }
    }
}

#[test]
fn files_of_the_engine_import_each_other_in_one_direction() {
    let folder = Path::new(SOURCE).join("engine");
    let mut graph = BTreeMap::new();
    for (file, text) in texts(&folder) {
        let name = file.strip_prefix(&folder).unwrap().with_extension("").to_str().unwrap().replace('\\', "/");
        // Modules only name their parts, and define what all of them share.
        if !name.ends_with("mod") && !name.ends_with("tests") {
            let imports = imports(&text, &name);
            graph.insert(name, imports);
        }
    }
    assert!(graph.len() > 25 && graph.values().map(BTreeSet::len).sum::<usize>() > 60, "{graph:?}");
    assert!(graph["estimate"].contains("plane") && graph["plane"].contains("linear"));
    let mut ring = graph.clone();
    ring.get_mut("linear").unwrap().insert("estimate".to_owned());
    assert!(circle(ring).len() > circle(graph.clone()).len());
    let found = circle(graph);
    assert!(found.is_empty(), "in a circle, or above one: {found:?}");
}
