//! Every package that the program is built from may be used and passed on with it.

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

/// The packages of this program on this machine; nothing is fetched.
fn packages() -> Vec<Value> {
    let cargo = env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let platform = match OS {
        "linux" => format!("{ARCH}-unknown-linux-gnu"),
        "macos" => format!("{ARCH}-apple-darwin"),
        _ => format!("{ARCH}-pc-windows-msvc"),
    };
    let options = ["metadata", "--format-version=1", "--locked", "--offline", "--filter-platform", &platform];
    let output = Command::new(cargo).args(options).current_dir(ROOT).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

#[test]
fn every_dependency_has_a_permissive_licence() {
    assert!(
        !is_permissive("GPL-3.0-only") && !is_permissive("MIT AND GPL-3.0-only") && is_permissive("GPL-2.0 OR MIT")
    );
    let packages = packages();
    assert!(packages.len() > 50, "{} packages", packages.len());
    for package in &packages {
        let name = package["name"].as_str().unwrap();
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
