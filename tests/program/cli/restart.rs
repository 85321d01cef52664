//! `run --from` and `initial.from`.

use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::common::{failed, json, run_in, succeeded};

fn ended(folder: &Path, name: &str) -> Value {
    json(&folder.join(name).join("summary.json"))["end_state"].clone()
}

/// Two runs of 500 windows and one of 1000 have the same digits: those of the engine's windows, in f64, and those that
/// Newton's method solves, in f64 and in more digits.
#[test]
fn two_runs_are_one_to_the_last_bit() {
    let folder = TempDir::new().unwrap();
    for (name, case, windows, scheme) in [
        ("weak", "henon-heiles", 500, "--set scheme.sbp=GLL16 --set grid.n_gamma=16"),
        ("metric", "kerr-inclined", 500, "--set scheme.sbp=GLL8 --set grid.n_gamma=8"),
        ("paper", "quartic", 500, "--set scheme.form=weak --set scheme.sbp=GLL12 --set grid.n_gamma=12"),
        ("strong", "quartic", 500, "--set scheme.sbp=SBP42 --set grid.n_gamma=12"),
        ("newton", "two-bodies", 50, "--set scheme.sbp=SBP42 --set grid.n_gamma=12"),
        ("digits", "quartic", 5, "--set scheme.sbp=SBP42 --set grid.n_gamma=12 --set solver.digits=40"),
    ] {
        let run = |out: &str, from: &str, last: usize, windows: usize| {
            let grid = format!("--set grid.gamma_f={last} --set grid.windows={windows}");
            let out = format!("{name}-{out}");
            let from = if from.is_empty() { String::new() } else { format!("--from {name}-{from}") };
            succeeded(&run_in(folder.path(), &format!("run {case} --quiet {scheme} {grid} --out {out} {from}")));
            ended(folder.path(), &out)
        };
        let length = windows / 50 + 1;
        run("first", "", length, windows);
        let second = run("second", "first", 2 * length, windows);
        assert_eq!(second, run("whole", "", 2 * length, 2 * windows), "{name}");
        assert!(second["gamma"][0].as_str().unwrap().starts_with(&(2 * length).to_string()), "{second}");
    }
}

#[test]
fn a_run_to_an_accuracy_goes_on_from_a_run_to_an_accuracy() {
    let folder = TempDir::new().unwrap();
    let run = |rest: &str| succeeded(&run_in(folder.path(), &format!("run kepler --quiet {rest}")));
    let accurate = "--set solver.accuracy=1e-12";
    run(&format!("{accurate} --set grid.t_f=20.0 --out whole"));
    run(&format!("{accurate} --set grid.t_f=9.0 --out first"));
    run(&format!("{accurate} --set grid.t_f=20.0 --from first/summary.json --out second"));
    run(&format!("{accurate} --set grid.t_f=0.0 --from second --out back"));
    let at =
        |name: &str, key: &str| -> f64 { ended(folder.path(), name)["q"][key][0].as_str().unwrap().parse().unwrap() };
    for key in ["t", "x", "y"] {
        assert!((at("whole", key) - at("second", key)).abs() < 1e-10, "{key}");
    }
    assert!((at("back", "x") - 0.4).abs() < 1e-10 && at("back", "y").abs() < 1e-10 && at("back", "t") == 0.0);
}

#[test]
fn what_is_no_end_of_a_run_is_refused() {
    let folder = TempDir::new().unwrap();
    succeeded(&run_in(folder.path(), "run quartic --quiet --out first"));
    for (arguments, said) in [
        ("run quartic --from nowhere", "cannot read nowhere: "),
        ("run quartic --from first/case.toml", "first/case.toml has no end_state: "),
        ("run kepler --from first", "first/summary.json ends without a coordinate 'y'"),
        ("run quartic --from first --set initial.x=2", "unknown field `x`"),
    ] {
        let error = failed(&run_in(folder.path(), arguments), 2);
        assert!(error.contains(said), "{arguments}: {error}");
    }
}
