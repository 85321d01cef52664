//! `check --run`.

use geodesic_ivp::case::builtin::NAMES;
use tempfile::TempDir;

use crate::common::{case_file, program, succeeded};

#[test]
fn every_case_meets_its_expectations() {
    let folder = TempDir::new().unwrap();
    for name in NAMES {
        let output = program(folder.path()).args(["check", "--run", "--quiet", &case_file(name)]).output().unwrap();
        succeeded(&output);
    }
}
