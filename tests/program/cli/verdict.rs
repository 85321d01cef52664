//! The verdict: the first line of `run`, the keys of its summary, and the column of a table of many runs.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::common::{case_file, failed, json, run_in, succeeded};

/// Returns what a run tells, its first line and the others without line breaks, and its summary.
fn verdict(folder: &TempDir, arguments: &str) -> (String, String, Value) {
    let told = succeeded(&run_in(folder.path(), &format!("run {arguments} --out out --force")));
    assert!(told.lines().all(|line| line.chars().count() <= 100), "{told}");
    let (first, others) = told.split_once('\n').unwrap();
    let others = others.split_whitespace().collect::<Vec<_>>().join(" ");
    (first.to_owned(), others, json(&folder.path().join("out/summary.json")))
}

#[test]
fn the_first_line_and_the_summary_of_every_kind_of_run_say_the_same() {
    let folder = TempDir::new().unwrap();
    for (arguments, most, digits) in [
        ("quartic", 2e-3, 3),
        ("quartic --set solver.digits=30 --set scheme.sbp=SBP84 --set grid.n_gamma=64", 1e-4, 5),
        ("quartic --set solver.accuracy=1e-8", 1e-8, 8),
        ("quartic --sample-gamma 0:1:0.5 --samples-only", 2e-3, 3),
        ("kepler", 1e-11, 11),
        ("outer-planets", 1e-12, 11),
        ("kerr-inclined --set solver.accuracy=1e-7", 1e-7, 6),
    ] {
        let (line, others, summary) = verdict(&folder, arguments);
        assert!(summary["verdict_error"].as_f64().unwrap() < most, "{arguments}: {summary}");
        assert!(line.ends_with(&format!(": trusted, good to {} digits", summary["good_digits"])), "{line}");
        assert!(!others.contains("doubt") && others.lines().count() <= 8, "{others}");
        assert_eq!(summary["verdict"], "trusted", "{arguments}");
        assert!(summary["good_digits"].as_u64().unwrap() >= digits, "{arguments}: {}", summary["good_digits"]);
        assert!(summary.get("verdict_reasons").is_none(), "{arguments}");
    }
}

#[test]
fn a_doubtful_result_has_its_reasons_and_exit_code_0() {
    let folder = TempDir::new().unwrap();
    let coarse = "--set grid.gamma_f=32.0 --set grid.n_gamma=65";
    let kepler = "kepler --set scheme.sbp=SBP21 --set scheme.form=strong --set grid.windows=1 --set grid.n_gamma=30";
    for (arguments, reasons, coordinate) in [(format!("quartic {coarse}"), 6, "x"), (kepler.to_owned(), 2, "x")] {
        let (line, others, summary) = verdict(&folder, &arguments);
        let found = summary["verdict_reasons"].as_array().unwrap();
        assert!(line.contains(&format!(": doubtful for {} reasons, ", found.len())), "{line}");
        assert_eq!(others.matches("doubt ").count(), 1, "{others}");
        assert!(others.starts_with("doubt the error of "), "{others}");
        assert!(others.contains(": raise n_gamma or windows, or ask for solver.accuracy"), "{others}");
        assert_eq!(summary["verdict"], "doubtful");
        assert!(found.len() >= reasons, "{found:?}");
        let (_, all, _) = verdict(&folder, &format!("{arguments} --verbose"));
        assert_eq!(all.matches("doubt ").count(), found.len(), "{all}");
        let starts = format!("the error of {coordinate} is up to about ");
        assert!(found.iter().any(|reason| reason["reason"].as_str().unwrap().starts_with(&starts)), "{found:?}");
        // Every warning is a reason, and in the same words.
        for warning in summary["warnings"].as_array().unwrap() {
            let warning = warning.as_str().unwrap();
            let is_reason = |reason: &Value| {
                let [reason, remedy] = ["reason", "remedy"].map(|key| reason[key].as_str().unwrap());
                warning.starts_with(reason) && warning.ends_with(remedy)
            };
            assert!(found.iter().any(is_reason) || warning.contains("Newton's mechanics"), "{warning}: {found:?}");
        }
    }
}

#[test]
fn a_run_without_a_result_is_refused() {
    let folder = TempDir::new().unwrap();
    let stalled = "run quartic --set scheme.sbp=SBP42 --set grid.n_gamma=8 --set grid.gamma_f=20.0";
    for (arguments, code) in [(format!("run {}", case_file("horizon")), 4), (stalled.to_owned(), 3)] {
        failed(&run_in(folder.path(), &format!("{arguments} --out out --force")), code);
        let summary = json(&folder.path().join("out/summary.json"));
        assert_eq!(summary["verdict"], "refused", "{arguments}");
        assert!(summary.get("verdict_error").is_none() && summary["message"].is_string(), "{summary}");
    }
}

#[test]
fn every_row_of_a_table_has_the_verdict_of_the_single_run() {
    let folder = TempDir::new().unwrap();
    let kepler = "kepler --set scheme.form=strong --set scheme.sbp=SBP42 --set grid.windows=1";
    for (case, values) in [("quartic", "1,100,0"), (kepler, "0.5,9")] {
        let nodes = "--set grid.n_gamma=200";
        let vary = format!("run {case} {nodes} --vary grid.gamma_f={values} --out table --force");
        let told = succeeded(&run_in(folder.path(), &vary));
        assert!(told.lines().next().unwrap().contains(": 1 trusted, 1 doubtful, "), "{told}");
        let text = fs::read_to_string(folder.path().join("table/runs.csv")).unwrap();
        let mut rows = csv::Reader::from_reader(text.as_bytes());
        let place = rows.headers().unwrap().iter().position(|name| name == "verdict").unwrap();
        for (row, value) in rows.records().zip(values.split(',')) {
            let row = row.unwrap();
            let one =
                run_in(folder.path(), &format!("run {case} {nodes} --set grid.gamma_f={value} --out one --force"));
            if one.status.success() {
                let summary = json(&folder.path().join("one/summary.json"));
                assert_eq!(summary["verdict"], row[place], "{case} {value}");
                let reason = summary["verdict_reasons"][0]["reason"].as_str().unwrap_or("");
                assert!(row[place + 1].starts_with(reason), "{case} {value}: {reason}");
            } else {
                assert_eq!(&row[place], "refused");
            }
        }
    }
}
