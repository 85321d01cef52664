//! The packages that the program is built from: they may be used and passed on with it, and the tests share their
//! build.

use std::collections::BTreeSet;
use std::env::consts::{ARCH, OS};
use std::path::Path;
use std::process::Command;
use std::{env, fs};

use serde_json::Value;

use crate::common::ROOT;

/// These ask for no more than to be named.
const PERMISSIVE: [&str; 10] = [
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "ISC",
    "MIT",
    "Unicode-3.0",
    "Zlib",
];

/// Returns true if an SPDX expression leaves a choice of permissive licences: every part that is joined by AND has one.
/// An old way to write OR is a slash.
fn is_permissive(expression: &str) -> bool {
    let expression = expression.replace(['(', ')'], "").replace('/', " OR ");
    expression.split(" AND ").all(|part| part.split(" OR ").any(|licence| PERMISSIVE.contains(&licence.trim())))
}

/// Asks cargo about this project; nothing is fetched.
fn cargo(options: &[&str]) -> String {
    let cargo = env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let output = Command::new(cargo).args(options).args(["--locked", "--offline"]).current_dir(ROOT).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn every_dependency_has_a_permissive_licence() {
    assert!(
        !is_permissive("GPL-3.0-only") && !is_permissive("MIT AND GPL-3.0-only") && is_permissive("GPL-2.0 OR MIT")
    );
    let platform = match OS {
        "linux" => format!("{ARCH}-unknown-linux-gnu"),
        "macos" => format!("{ARCH}-apple-darwin"),
        _ => format!("{ARCH}-pc-windows-msvc"),
    };
    let metadata: Value =
        serde_json::from_str(&cargo(&["metadata", "--format-version=1", "--filter-platform", &platform])).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    assert!(packages.len() > 50, "{} packages", packages.len());
    for package in packages {
        let name = &package["name"];
        let is_allowed = match package["license"].as_str() {
            Some(expression) => is_permissive(expression),
            None => {
                let manifest = Path::new(package["manifest_path"].as_str().unwrap());
                let file = package["license_file"].as_str().unwrap_or_else(|| panic!("{name} has no licence"));
                fs::read_to_string(manifest.with_file_name(file)).unwrap().starts_with("BSD 3-Clause License")
            }
        };
        assert!(is_allowed, "{name}: {}", package["license"]);
    }
}

/// Every package with its features, as it is built for what these edges of the tree of dependencies reach.
fn built(edges: &str) -> BTreeSet<String> {
    let tree = cargo(&["tree", "--prefix", "none", "--no-dedupe", "--format", "{p} {f}", "--edges", edges]);
    tree.lines().map(str::to_owned).collect()
}

#[test]
fn tests_build_nothing_a_second_time() {
    let (program, all) = (built("no-dev"), built("normal,build,dev"));
    assert!(program.len() > 50 && all.len() > program.len(), "{} and {} packages", program.len(), all.len());
    let again: Vec<&String> = program.difference(&all).collect();
    assert!(again.is_empty(), "these and all that uses them are built again: {again:?}");
}
