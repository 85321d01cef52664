//! The modules of the library import each other in one direction only.

use std::fs;
use std::path::{Path, PathBuf};

/// From low to high.
const LAYERS: [&str; 29] = [
    "scalar",
    "compiled",
    "norm",
    "similar",
    "root",
    "runge_kutta",
    "expr",
    "geometry",
    "potential",
    "banded",
    "sbp",
    "metric",
    "geodesic",
    "vector",
    "sparse",
    "enclosure",
    "lobatto",
    "reference",
    "methods",
    "action",
    "solve",
    "diagnostics",
    "sampling",
    "tables",
    "errors",
    "numeric",
    "case",
    "study",
    "output",
];

/// The sources of the packages, from low to high.
pub(crate) const SOURCES: [&str; 3] = ["crates/engine/src", "crates/critical-point/src", "src"];

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

/// The modules of this crate that the program text names, comments and tests left out.
fn imports(text: &str) -> Vec<String> {
    let text = text.split("#[cfg(test)]").next().unwrap_or_default();
    let code: String = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    let word = |rest: &str| rest.chars().take_while(|c| c.is_ascii_lowercase() || *c == '_').collect::<String>();
    // Macros are used as `crate::name!`.
    let is_module = |rest: &&str| !rest.starts_with(&format!("{}!", word(rest)));
    code.split("crate::").skip(1).filter(is_module).map(word).filter(|name| !name.is_empty()).collect()
}

#[test]
fn modules_import_only_what_is_below_them() {
    let rank = |name: &str| LAYERS.iter().position(|layer| *layer == name);
    let (mut seen, mut count, mut lowest) = (0, 0, 0);
    for source in SOURCES {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join(source);
        let mut files = Vec::new();
        sources(&source, &mut files);
        count += files.len();
        let mut highest = lowest;
        for file in files {
            let inside = file.strip_prefix(&source).unwrap();
            let module = inside.iter().next().unwrap().to_str().unwrap().trim_end_matches(".rs");
            // The command layer stands above all of them.
            if ["cli", "main", "lib"].contains(&module) {
                continue;
            }
            let own = rank(module).unwrap_or_else(|| panic!("the module {module} has no layer"));
            assert!(own >= lowest, "{module} is in a package above its layer");
            highest = highest.max(own + 1);
            for import in imports(&fs::read_to_string(&file).unwrap()) {
                let Some(other) = rank(&import) else { panic!("{}: crate::{import} has no layer", inside.display()) };
                assert!(other <= own, "{}: {module} is below {import}", inside.display());
                seen += 1;
            }
        }
        lowest = highest;
    }
    assert!(count > 100 && seen > 200, "{count} files, {seen} imports were found");
}
