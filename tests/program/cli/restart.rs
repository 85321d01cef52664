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
            let mut end = ended(&folder, out.split(' ').next().unwrap());
            // One run knows less of its error than two.
            end.as_object_mut().unwrap().remove("error");
            end
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

/// The last of so many pieces of a run of `case`, each of which continues the one before, and what it says. The first
/// one has a start of its own.
fn pieces(folder: &Folder, case: &str, start: &str, (count, length): (usize, f64)) -> (Value, String) {
    let mut told = String::new();
    for piece in 1..=count {
        let from = if piece == 1 { start.to_owned() } else { format!("--from piece{}", piece - 1) };
        let end = length * piece as f64;
        told = folder.succeeds(&format!("run {case} {from} --set grid.gamma_f={end} --out piece{piece}"));
    }
    (folder.summary(&format!("piece{count}")), told.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// The distance of the ends of two runs in a coordinate.
fn apart(one: &Value, other: &Value, key: &str) -> f64 {
    let at = |summary: &Value| summary["final"][key].as_f64().unwrap();
    (at(one) - at(other)).abs()
}

#[test]
fn the_error_of_a_regular_run_in_pieces_is_carried_and_grows_no_faster_than_it_does() {
    let folder = Folder::new();
    let kepler = "kepler --set solver.tolerance=1e-9";
    let (last, told) = pieces(&folder, kepler, "", (10, 7.0));
    folder.succeeds("run kepler --quiet --set solver.accuracy=1e-11 --set grid.gamma_f=70.0 --out whole");
    let (whole, error) = (folder.summary("whole"), last["verdict_error"].as_f64().unwrap());
    assert_eq!(last["verdict"], "trusted", "{last}");
    assert!(told.contains("; of it ") && told.contains(" inherited)"), "{told}");
    for key in ["x", "y"] {
        let (off, claimed) = (apart(&last, &whole, key), last["end_state"]["error"][key].as_f64().unwrap().abs());
        assert!(off <= last["error_final"][key].as_f64().unwrap(), "{key}: {off:e} {error:e}");
        assert!(claimed <= last["error_final"][key].as_f64().unwrap() * 1.000001, "{key}: {claimed:e}");
    }
    let first = folder.summary("piece1")["verdict_error"].as_f64().unwrap();
    assert!(error > first && error < 1e4 * first, "{first:e} {error:e}");
}

#[test]
fn a_chaotic_run_in_pieces_is_no_better_than_the_whole() {
    let folder = Folder::new();
    let start = "--set initial.x=0 --set initial.y=-0.25 --set initial.y_dot=0 --set initial.x_dot=0.5103";
    let (last, _) = pieces(&folder, "henon-heiles --set solver.tolerance=1e-8", start, (10, 60.0));
    assert_eq!(last["verdict"], "doubtful", "{last}");
    let reason = last["verdict_reasons"][0]["reason"].as_str().unwrap();
    assert!(reason.contains("the run that it continues"), "{reason}");
}

#[test]
fn an_end_without_its_error_leaves_a_doubt() {
    let folder = Folder::new();
    folder.succeeds("run kepler --quiet --out first");
    let mut summary = folder.summary("first");
    summary["end_state"].as_object_mut().unwrap().remove("error");
    folder.write("old/summary.json", summary.to_string());
    folder.succeeds("run kepler --quiet --from old --set grid.gamma_f=7.0 --out second");
    let second = folder.summary("second");
    let reason = second["verdict_reasons"][0]["reason"].as_str().unwrap();
    assert!(reason.contains("the error of the run that it continues is not known"), "{reason}");
    // Nor does a third one know it.
    folder.succeeds("run kepler --quiet --from second --set grid.gamma_f=8.0 --out third");
    assert_eq!(folder.summary("third")["verdict"], "doubtful");
}

#[test]
fn a_run_does_not_replace_the_one_that_it_continues() {
    let folder = Folder::new();
    folder.succeeds("run kepler --quiet");
    let before = folder.read("results/kepler/summary.json");
    let holds = "results/kepler holds the run that this one continues";
    folder.refuses(&[
        ("run kepler --from results/kepler --set grid.gamma_f=7.0", 2, holds),
        (
            "run kepler --from results/../results/kepler/summary.json --set grid.gamma_f=7.0 --out results/kepler/.",
            2,
            "holds the run that",
        ),
        ("run kepler --from results/kepler --vary grid.gamma_f=7,8 --out results/kepler", 2, holds),
    ]);
    assert_eq!(folder.read("results/kepler/summary.json"), before);
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

/// A spring that is another one from 5 on: the run goes on with its energy, and what it inherits explains what its
/// witnesses see.
#[test]
fn a_run_goes_on_with_other_formulas() {
    let folder = Folder::new();
    folder.write(
        "spring.toml",
        "potential={coordinates=['x'], formula='k*x^2/2', parameters={k=1.0}}\nparticle.law='newtonian'\n\
         initial={x=1.0, x_dot=0.0}\ngrid.t_f=5.0\nsolver.accuracy=1e-8\n",
    );
    folder.succeeds("run spring.toml --out first");
    let told = folder.succeeds("run spring.toml --from first --set parameters.k=1.5 --set grid.t_f=20 --out second");
    assert!(told.contains("trusted"), "{told}");
    let summary = folder.summary("second");
    let energy = summary["energy"].as_f64().unwrap();
    assert!((energy - 0.520_116_058_865_443_4).abs() < 1e-9, "{energy}");
    assert!((summary["final"]["x"].as_f64().unwrap() + 0.108_611_911_792_383_78).abs() < 1e-8, "{summary}");
    assert!((summary["final"]["s"].as_f64().unwrap() + 0.0549).abs() < 1e-3, "{summary}");
}

/// What a run inherits limits where it is good to so many digits, and is in the doubts of its witnesses.
#[test]
fn a_run_is_good_to_no_more_digits_than_it_inherits() {
    let folder = Folder::new();
    folder.succeeds("run henon-heiles --set solver.tolerance=1e-2 --set grid.gamma_f=50 --out first");
    let told = folder
        .succeeds("run henon-heiles --from first --set solver.tolerance=1e-12 --set grid.gamma_f=60 --out second");
    let summary = folder.summary("second");
    let good = |digits: &str| summary["good_until"][digits].as_f64().unwrap();
    assert!(good("9") == 50.0 && good("3") == 60.0, "{summary}");
    assert!(!told.contains("explain"), "{told}");
}
