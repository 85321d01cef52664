//! `run --enclose`: the look between the nodes of a run on a given grid.

use serde_json::Value;

use crate::common::{Folder, stderr, succeeded};

const BARRIER: &str = "potential.formula.expression = \"5*exp(-((x - 2)/0.01)^2)\"
particle.c = 3.0
initial = { t = 0.0, x = -0.6, t_dot = 1.0, x_dot = 0.6 }
grid = { gamma_f = 64.0, n_gamma = 65 }
scheme.sbp = \"SBP42\"
";

const RIDGE: &str = "potential = { coordinates = [\"x\", \"y\"], formula = \"5*exp(-((x + y/2 - 2)/1e-4)^2)\" }
particle.c = 3.0
initial = { x = -0.6, y = 0.0, t_dot = 1.0, x_dot = 0.6, y_dot = 0.1 }
grid = { gamma_f = 64.0, n_gamma = 16, windows = 4 }
scheme = { sbp = \"GLL16\", form = \"weak\" }
";

/// A folder with the cases of a barrier and of a ridge.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("barrier.toml", BARRIER);
    folder.write("ridge.toml", RIDGE);
    folder
}

/// Returns what a run tells, and its summary.
fn run(folder: &Folder, arguments: &str) -> (String, Value) {
    (folder.succeeds(&format!("run {arguments} --out out --force")), folder.summary("out"))
}

fn keys(value: &Value) -> Vec<&String> {
    value.as_object().unwrap().keys().collect()
}

#[test]
fn what_hides_makes_the_verdict_doubtful_and_says_where() {
    let folder = folder();
    for (case, gaps, names, place) in
        [("barrier.toml", 64, &["gamma", "t", "x"][..], 2.0), ("ridge.toml", 60, &["gamma", "t", "x", "y"], 1.8)]
    {
        let (told, summary) = run(&folder, &format!("{case} --enclose --verbose"));
        assert_eq!((&summary["gaps"], &summary["gaps_unproved"]), (&gaps.into(), &1.into()), "{case}");
        assert_eq!(summary["verdict"], "doubtful");
        let gap = &summary["gap_unproved"];
        assert_eq!(keys(gap), names);
        let ends = |name: &str| [&gap[name][0], &gap[name][1]].map(|end| end.as_f64().unwrap());
        let ([from, to], [start, end]) = (ends("x"), ends("gamma"));
        assert!(from < place && place < to && start < end, "{gap:?}");
        let words = format!("in 1 of {gaps} gaps between nodes the formulas may do what the nodes do not see");
        let begins = |text: &Value| text.as_str().unwrap().starts_with(&words);
        let reasons = summary["verdict_reasons"].as_array().unwrap();
        let reason = reasons.iter().find(|reason| begins(&reason["reason"])).unwrap();
        assert_eq!(reason["remedy"], "take more nodes (grid.n_gamma) or solver.accuracy");
        assert!(summary["warnings"].as_array().unwrap().iter().any(begins), "{summary}");
        assert!(told.contains(&format!("1 of {gaps} gaps between nodes are not explained")), "{told}");
        assert!(told.lines().next().unwrap().contains(": doubtful"), "{told}");
        // The line is broken.
        assert!(told.split_whitespace().collect::<Vec<_>>().join(" ").contains(&words), "{told}");
    }
}

#[test]
fn what_the_nodes_follow_is_trusted() {
    let folder = folder();
    let smooth = "barrier.toml --set grid.n_gamma=4001 --set potential.formula.expression=5*exp(-((x-2)/0.5)^2)";
    for arguments in ["quartic", "pendulum", "morse-60-digits", "tanh-wall", "kepler", "kerr-inclined", smooth] {
        let (told, summary) = run(&folder, &format!("{arguments} --enclose"));
        assert_eq!((&summary["verdict"], &summary["gaps_unproved"]), (&"trusted".into(), &0.into()), "{arguments}");
        assert!(summary["gaps"].as_u64().unwrap() > 30 && summary.get("gap_unproved").is_none(), "{summary}");
        let error = summary["verdict_error"].as_f64().unwrap();
        // A verdict counts what formulas lose besides.
        let accuracy = summary["gaps_accuracy"].as_f64().unwrap();
        assert!((accuracy / error.clamp(1e-12, 1e-3) - 1.0).abs() < 1e-6, "{arguments}: {accuracy:e} {error:e}");
        assert!(told.contains("nothing hides in the "), "{told}");
    }
}

/// Without the option nothing is looked at but where windows are chosen, which is done in any case.
#[test]
fn a_run_to_an_accuracy_looks_between_its_nodes_in_any_case_and_no_other() {
    let folder = folder();
    for case in ["pendulum", "kerr-inclined", "morse --sample-gamma 0:1:0.5 --samples-only"] {
        let (_, with) = run(&folder, &format!("{case} --set solver.accuracy=1e-8 --enclose"));
        let (_, without) = run(&folder, &format!("{case} --set solver.accuracy=1e-8"));
        assert_eq!(with["windows_unproved"], 0);
        assert_eq!(keys(&with), keys(&without), "{case}");
    }
    for case in ["barrier.toml", "ridge.toml"] {
        assert!(!keys(&run(&folder, case).1).iter().any(|key| key.starts_with("gap")), "{case}");
    }
}

#[test]
fn one_table_has_its_warning_too_and_without_nodes_it_is_refused() {
    let folder = folder();
    let output = folder.run("run barrier.toml --enclose --stdout");
    assert!(succeeded(&output).lines().count() > 60);
    assert!(stderr(&output).contains("1 of 64 gaps"), "{}", stderr(&output));
    let samples = "run barrier.toml --enclose --sample-gamma 0:1:0.5 --samples-only --out out";
    folder.refuses(&[
        (samples, 2, "--samples-only keeps no nodes that --enclose could look between"),
        ("run barrier.toml --enclose --vary initial.x=0,1 --out out", 2, "'--enclose' cannot be used with '--vary"),
    ]);
}
