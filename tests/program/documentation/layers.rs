//! The modules of the library import each other in one direction only.

use std::fs;
use std::path::{Path, PathBuf};

/// The rooms of the library, from low to high. The command layer stands above all of them.
const LAYERS: [&str; 15] = [
    "number",
    "formula",
    "linalg",
    "sbp",
    "geometry",
    "engine",
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

/// The folder of the library and the program.
pub(crate) const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src");

/// Every file of Rust in a folder.
pub(crate) fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
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

/// The modules of this crate that the program text names, comments and tests left out.
fn imports(text: &str) -> Vec<String> {
    let mut parts = text.split("#[cfg(test)]");
    let first = parts.next().unwrap_or_default();
    let text: String = std::iter::once(first).chain(parts.map(behind_item)).collect();
    let code: String = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    let word = |rest: &str| rest.chars().take_while(|c| c.is_ascii_lowercase() || *c == '_').collect::<String>();
    code.split("crate::").skip(1).map(word).filter(|name| !name.is_empty()).collect()
}

#[test]
fn modules_import_only_what_is_below_them() {
    let rank = |name: &str| LAYERS.iter().position(|layer| *layer == name);
    let source = Path::new(SOURCE);
    let mut files = Vec::new();
    sources(source, &mut files);
    let (count, mut seen) = (files.len(), 0);
    for file in files {
        let inside = file.strip_prefix(source).unwrap();
        let module = inside.iter().next().unwrap().to_str().unwrap();
        if ["cli", "main.rs", "lib.rs"].contains(&module) {
            continue;
        }
        let own = rank(module).unwrap_or_else(|| panic!("the module {module} has no layer"));
        for import in imports(&fs::read_to_string(&file).unwrap()) {
            let Some(other) = rank(&import) else { panic!("{}: crate::{import} has no layer", inside.display()) };
            assert!(other <= own, "{}: {module} is below {import}", inside.display());
            seen += 1;
        }
    }
    assert!(count > 100 && seen > 200, "{count} files, {seen} imports were found");
}
