//! `run --from` and `initial.from`.

use serde_json::Value;

use crate::common::Folder;

fn ended(folder: &Folder, out: &str) -> Value {
    folder.summary(out)["end_state"].clone()
}

/// Two runs of 500 windows and one of 1000 have the same digits: those of the engine's windows, in f64, and those that
/// Newton's method solves, in f64 and in more digits.
#[test]
fn two_runs_are_one_to_the_last_bit() {
    let folder = Folder::new();
    for (case, windows, scheme) in [
        ("henon-heiles", 500, "--set scheme.sbp=GLL16 --set grid.n_gamma=16"),
        ("kerr-inclined", 500, "--set scheme.sbp=GLL8 --set grid.n_gamma=8"),
        ("quartic", 500, "--set scheme.form=weak --set scheme.sbp=GLL12 --set grid.n_gamma=12"),
        ("quartic", 500, "--set scheme.sbp=SBP42 --set grid.n_gamma=12"),
        ("two-bodies", 50, "--set scheme.sbp=SBP42 --set grid.n_gamma=12"),
        ("quartic", 5, "--set scheme.sbp=SBP42 --set grid.n_gamma=12 --set solver.digits=40"),
    ] {
        let run = |out: &str, last: usize, windows: usize| {
            let grid = format!("--set grid.gamma_f={last} --set grid.windows={windows}");
            folder.succeeds(&format!("run {case} --quiet {scheme} {grid} --out {out}"));
            ended(&folder, out.split(' ').next().unwrap())
        };
        let length = windows / 50 + 1;
        run("first", length, windows);
        let second = run("second --from first", 2 * length, windows);
        assert_eq!(second, run("whole", 2 * length, 2 * windows), "{case} {scheme}");
        assert!(second["gamma"][0].as_str().unwrap().starts_with(&(2 * length).to_string()), "{second}");
    }
}

#[test]
fn a_run_to_an_accuracy_goes_on_from_a_run_to_an_accuracy() {
    let folder = Folder::new();
    for rest in [
        "20.0 --out whole",
        "9.0 --out first",
        "20.0 --from first/summary.json --out second",
        "0.0 --from second --out back",
    ] {
        folder.succeeds(&format!("run kepler --quiet --set solver.accuracy=1e-12 --set grid.t_f={rest}"));
    }
    let at = |out: &str, key: &str| -> f64 { ended(&folder, out)["q"][key][0].as_str().unwrap().parse().unwrap() };
    for key in ["t", "x", "y"] {
        assert!((at("whole", key) - at("second", key)).abs() < 1e-10, "{key}");
    }
    assert!((at("back", "x") - 0.4).abs() < 1e-10 && at("back", "y").abs() < 1e-10 && at("back", "t") == 0.0);
}

#[test]
fn what_is_no_end_of_a_run_is_refused() {
    let folder = Folder::new();
    folder.succeeds("run quartic --quiet --out first");
    folder.refuses(&[
        ("run quartic --from nowhere", 2, "cannot read nowhere: "),
        ("run quartic --from first/case.toml", 2, "first/case.toml has no end_state: "),
        ("run kepler --from first", 2, "first/summary.json ends without a coordinate 'y'"),
        ("run quartic --from first --set initial.x=2", 2, "unknown field `x`"),
    ]);
}
