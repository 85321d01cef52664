//! `check`, `completions` and `man`.

use geodesic_ivp::case::builtin::NAMES;
use tempfile::TempDir;

use crate::common::{case_file, program, run_in, succeeded};

#[test]
fn check_prints_the_effective_case_and_compares() {
    let folder = TempDir::new().unwrap();
    let text = succeeded(&run_in(folder.path(), "check CASES/quartic.toml"));
    assert!(text.contains("gamma_i = 0.0") && text.contains("max_iterations = 50"), "{text}");
    for name in NAMES {
        let output = program(folder.path()).args(["check", "--run", "--quiet", &case_file(name)]).output().unwrap();
        succeeded(&output);
    }
    let missed = run_in(folder.path(), "check --run --quiet CASES/quartic.toml --set expect.x_final=0.16018");
    assert_eq!(missed.status.code(), Some(5));
    assert!(String::from_utf8_lossy(&missed.stderr).contains("x_final"));
}

#[test]
fn completions_and_manual_page() {
    let folder = TempDir::new().unwrap();
    assert!(succeeded(&run_in(folder.path(), "completions bash")).contains("geodesic-ivp"));
    let page = succeeded(&run_in(folder.path(), "man"));
    assert!(page.contains(".TH geodesic-ivp") && page.contains("geodesic\\-ivp run [OPTIONS] <CASE>"), "{page}");
    assert!(succeeded(&run_in(folder.path(), "--help")).contains("Exit codes"));
}
