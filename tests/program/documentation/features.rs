//! The tests share the build of the program: they need no package with other features.

use std::collections::BTreeSet;
use std::env;
use std::process::Command;

use crate::common::ROOT;

/// Every package with its features, as it is built for what these edges of the tree of dependencies reach.
fn built(edges: &str) -> BTreeSet<String> {
    let cargo = env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let options = ["tree", "--locked", "--offline", "--prefix", "none", "--no-dedupe", "--format", "{p} {f}"];
    let output = Command::new(cargo).args(options).args(["--edges", edges]).current_dir(ROOT).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

#[test]
fn tests_build_nothing_a_second_time() {
    let (program, all) = (built("no-dev"), built("normal,build,dev"));
    assert!(program.len() > 50 && all.len() > program.len(), "{} and {} packages", program.len(), all.len());
    let again: Vec<&String> = program.difference(&all).collect();
    assert!(again.is_empty(), "these and all that uses them are built again: {again:?}");
}
