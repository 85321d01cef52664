//! `--json`: the text of summary.json on standard output, and nothing else.

use std::fs;

use tempfile::TempDir;

use crate::common::{case_file, failed, json, run_in, stderr, succeeded};

#[test]
fn every_command_with_a_summary_prints_its_text() {
    let folder = TempDir::new().unwrap();
    for (arguments, key) in [
        ("run quartic", "t_final"),
        ("run quartic --set solver.digits=30 --plot", "t_final"),
        ("converge quartic --n-gamma 16,32 --sbp SBP21", "slopes"),
        ("work-precision quartic --methods rk4 --longest 1e-3", "ratios"),
        ("stability quartic --methods rk4 --gamma-f 1 --delta-gamma 0.1", "omega"),
    ] {
        let text = succeeded(&run_in(folder.path(), &format!("{arguments} --out out --force --json")));
        assert_eq!(text, fs::read_to_string(folder.path().join("out/summary.json")).unwrap(), "{arguments}");
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert!(value.get(key).is_some(), "{arguments}: {text}");
    }
}

#[test]
fn converge_without_a_case_prints_one_object_of_both() {
    let folder = TempDir::new().unwrap();
    let text = succeeded(&run_in(folder.path(), "converge --n-gamma 16,32 --sbp SBP21 --out out --json"));
    let both: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&text).unwrap();
    assert_eq!(both.keys().collect::<Vec<_>>(), ["linear", "quartic"]);
    for (name, summary) in both {
        assert_eq!(summary, json(&folder.path().join("out").join(name).join("summary.json")));
    }
}

#[test]
fn warnings_and_errors_stay_on_standard_error() {
    let folder = TempDir::new().unwrap();
    let suspect = run_in(folder.path(), "run horizon-near --json --out out");
    assert!(stderr(&suspect).contains("warning:"), "{}", stderr(&suspect));
    let summary: serde_json::Value = serde_json::from_str(&succeeded(&suspect)).unwrap();
    assert_eq!(summary["status"], "converged");

    let failure = run_in(folder.path(), &format!("run {} --json --out out", case_file("horizon")));
    assert!(failed(&failure, 4).contains("leaves the domain"));
    let summary: serde_json::Value = serde_json::from_slice(&failure.stdout).unwrap();
    assert_eq!(summary["status"], "outside-domain");
    assert_eq!(failure.stdout, fs::read(folder.path().join("out/summary.json")).unwrap());

    let nothing = run_in(folder.path(), "converge horizon --json --out none");
    failed(&nothing, 4);
    assert!(nothing.stdout.is_empty(), "there is no summary");
}
