//! The verdict: the first line of `run`, the keys of its summary, and the column of a table of many runs.

use serde_json::Value;

use crate::common::Folder;

/// Returns what a run tells, its first line and the others without line breaks, and its summary.
fn verdict(folder: &Folder, arguments: &str) -> (String, String, Value) {
    let told = folder.succeeds(&format!("run {arguments} --out out --force"));
    assert!(told.lines().all(|line| line.chars().count() <= 100), "{told}");
    let (first, others) = told.split_once('\n').unwrap();
    (first.to_owned(), others.split_whitespace().collect::<Vec<_>>().join(" "), folder.summary("out"))
}

#[test]
fn the_first_line_and_the_summary_of_every_kind_of_run_say_the_same() {
    let folder = Folder::new();
    for (arguments, grade, most, digits) in [
        ("quartic", "trusted", 2e-3, 3),
        ("quartic --set solver.digits=30 --set scheme.sbp=SBP84 --set grid.n_gamma=64", "trusted", 1e-4, 5),
        ("quartic --set solver.accuracy=1e-8", "proved", 1e-8, 8),
        ("quartic --set solver.accuracy=1e-8 --no-prove", "trusted", 1e-8, 8),
        ("quartic --sample-gamma 0:1:0.5 --samples-only", "trusted", 2e-3, 3),
        ("kepler", "trusted", 1e-11, 11),
        ("outer-planets", "trusted", 1e-12, 11),
        ("kerr-inclined --set solver.accuracy=1e-7", "proved", 1e-7, 6),
    ] {
        let (line, others, summary) = verdict(&folder, arguments);
        assert!(summary["verdict_error"].as_f64().unwrap() < most, "{arguments}: {summary}");
        assert!(line.ends_with(&format!(": {grade}, good to {} digits", summary["good_digits"])), "{line}");
        assert!(!others.contains("doubt") && others.lines().count() <= 8, "{others}");
        assert_eq!(summary["verdict"], grade, "{arguments}");
        assert!(summary["good_digits"].as_u64().unwrap() >= digits, "{arguments}: {}", summary["good_digits"]);
        assert!(summary.get("verdict_reasons").is_none(), "{arguments}");
    }
}

#[test]
fn a_doubtful_result_has_its_reasons_and_exit_code_0() {
    let folder = Folder::new();
    let coarse = "quartic --set grid.gamma_f=32.0 --set grid.n_gamma=65";
    let kepler = "kepler --set scheme.sbp=SBP21 --set scheme.form=strong --set grid.windows=1 --set grid.n_gamma=30";
    for (arguments, reasons) in [(kepler, 2), (coarse, 6)] {
        let (line, others, summary) = verdict(&folder, arguments);
        let found = summary["verdict_reasons"].as_array().unwrap();
        assert!(line.contains(&format!(": doubtful for {} reasons, ", found.len())), "{line}");
        assert_eq!(others.matches("doubt ").count(), 1, "{others}");
        assert!(others.starts_with("doubt the error of "), "{others}");
        assert!(others.contains(": raise n_gamma or windows, or ask for solver.accuracy"), "{others}");
        assert_eq!(summary["verdict"], "doubtful");
        assert!(found.len() >= reasons, "{found:?}");
        let (_, all, _) = verdict(&folder, &format!("{arguments} --verbose"));
        assert_eq!(all.matches("doubt ").count(), found.len(), "{all}");
        let of_x = |reason: &Value| reason["reason"].as_str().unwrap().starts_with("the error of x is up to about ");
        assert!(found.iter().any(of_x), "{found:?}");
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
    let (_, told, summary) = verdict(&folder, &format!("{coarse} --verbose"));
    assert!(told.contains("K drifts by") && told.contains("exceeds its bound"), "{told}");
    let warnings = summary["warnings"].as_array().unwrap().len();
    assert_eq!(warnings, 5, "the sawtooth, K, the step, the bound, and another critical point");
    // The effective case of a changed case makes no promise that was made for another.
    assert!(!folder.read("out/case.toml").contains("[expect]"));
}

#[test]
fn a_run_without_a_result_is_refused() {
    let folder = Folder::new();
    let stalled = "quartic --set scheme.sbp=SBP42 --set grid.n_gamma=8 --set grid.gamma_f=20.0";
    for (arguments, code, status) in [("horizon", 4, "outside-domain"), (stalled, 3, "stalled")] {
        folder.fails(&format!("run {arguments} --out out --force"), code);
        let summary = folder.summary("out");
        assert_eq!((&summary["verdict"], &summary["status"]), (&"refused".into(), &status.into()));
        assert!(summary.get("verdict_error").is_none() && summary["message"].is_string(), "{summary}");
    }
}

#[test]
fn every_row_of_a_table_has_the_verdict_of_the_single_run() {
    let folder = Folder::new();
    let kepler = "kepler --set scheme.form=strong --set scheme.sbp=SBP42 --set grid.windows=1";
    for (case, values) in [("quartic", "1,100,0"), (kepler, "0.5,9")] {
        let run = format!("run {case} --set grid.n_gamma=200");
        let told = folder.succeeds(&format!("{run} --vary grid.gamma_f={values} --out table --force"));
        assert!(told.lines().next().unwrap().contains(": 1 trusted, 1 doubtful, "), "{told}");
        let table = folder.table("table/runs.csv");
        let rows = table.column("verdict").into_iter().zip(table.column("message"));
        for ((verdict, message), value) in rows.zip(values.split(',')) {
            if folder.run(&format!("{run} --set grid.gamma_f={value} --out one --force")).status.success() {
                let summary = folder.summary("one");
                assert_eq!(summary["verdict"], verdict, "{case} {value}");
                let reason = summary["verdict_reasons"][0]["reason"].as_str().unwrap_or("");
                assert!(message.starts_with(reason), "{case} {value}: {reason}");
            } else {
                assert_eq!(verdict, "refused");
            }
        }
    }
}
