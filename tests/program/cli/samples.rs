//! `run --sample-t`, `--sample-gamma`, `--samples-only`.

use std::fs;

use tempfile::TempDir;

use crate::common::{failed, json, names, run_in, succeeded};

#[test]
fn samples_are_written_where_they_are_asked_for() {
    let folder = TempDir::new().unwrap();
    succeeded(&run_in(folder.path(), "run CASES/pendulum.toml --sample-t 0:10:0.1 --out out"));
    let mut reader = csv::Reader::from_path(folder.path().join("out/samples.csv")).unwrap();
    assert_eq!(reader.headers().unwrap(), vec!["gamma", "t", "x", "t_dot", "x_dot"]);
    let t: Vec<f64> = reader.records().map(|row| row.unwrap()[1].parse().unwrap()).collect();
    assert_eq!(t.len(), 101);
    assert!(t.iter().zip(0..).all(|(t, k)| (t - 0.1 * f64::from(k)).abs() < 1e-14));
    // A run without samples takes the old ones away.
    succeeded(&run_in(folder.path(), "run CASES/pendulum.toml --out out"));
    assert!(!folder.path().join("out/samples.csv").exists());
    let digits = "run CASES/quartic.toml --set solver.digits=40 --sample-gamma 0.9:0.1:-0.2 --out digits";
    succeeded(&run_in(folder.path(), digits));
    let samples = fs::read_to_string(folder.path().join("digits/samples.csv")).unwrap();
    assert_eq!(
        samples.lines().map(|line| line.split(',').next().unwrap()).skip(1).collect::<Vec<_>>(),
        ["0.9", "0.7", "0.5", "0.3", "0.1"]
    );
}

#[test]
fn nothing_but_samples_is_kept_where_nothing_else_is_wanted() {
    let folder = TempDir::new().unwrap();
    let arguments = "run CASES/quartic-windows.toml --sample-t 0:50:5";
    succeeded(&run_in(folder.path(), &format!("{arguments} --out all")));
    let text = succeeded(&run_in(folder.path(), &format!("{arguments} --samples-only --out few")));
    assert!(text.contains("  written  few ("), "{text}");
    let [all, few] = ["all", "few"].map(|out| folder.path().join(out));
    assert_eq!(names(&few), ["case.toml", "samples.csv", "summary.json"]);
    let samples = fs::read_to_string(few.join("samples.csv")).unwrap();
    assert_eq!(samples, fs::read_to_string(all.join("samples.csv")).unwrap());
    let piped = run_in(folder.path(), &format!("{arguments} --samples-only --stdout"));
    assert_eq!(succeeded(&piped), samples);
    let [all, few] = [all, few].map(|out| json(&out.join("summary.json")));
    for key in ["windows", "max_abs_delta_k", "max_abs_delta_k_ends", "gradient_norm", "t_final"] {
        assert_eq!(all[key], few[key], "{key}");
    }
}

#[test]
fn samples_may_be_a_list_or_a_column() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("times.csv"), "n,t\n1,0\n2,1\n3, 2.5\n").unwrap();
    for case in ["pendulum", "kepler", "quartic-40-digits --set grid.gamma_f=3.0"] {
        let samples = |times: &str| {
            let line = format!("run {case} --quiet --stdout --samples-only --sample-t {times}");
            succeeded(&run_in(folder.path(), &line))
        };
        let listed = samples("0,1,2.5");
        assert_eq!(listed.lines().count(), 4);
        assert_eq!(listed, samples("@times.csv:t"));
        assert_eq!(listed.lines().nth(3), samples("0:2.5:2.5").lines().nth(2));
    }
    for (times, said) in [
        ("0,2,1", "must be in order"),
        ("0,one", "'one' is not a finite number"),
        ("@times.csv:z", "has no column 'z'; its columns are n, t"),
        ("@none.csv:t", "cannot read none.csv"),
        ("0,1,200", "goes beyond the run, which covers 0.0 to 9.99"),
    ] {
        let error = failed(&run_in(folder.path(), &format!("run pendulum --quiet --sample-t {times}")), 2);
        assert!(error.contains(said), "{times}: {error}");
    }
}

/// A run that ends where x is largest: an error of the phase does nothing to x there, but to the samples before.
#[test]
fn errors_are_those_of_all_samples() {
    let folder = TempDir::new().unwrap();
    let case = "quartic-windows --set grid.gamma_f=99.94 --set grid.windows=400 --set scheme.sbp=GLL4 \
                --set grid.n_gamma=4 --sample-gamma 0:99:0.5";
    let [all, few] = ["--out all", "--samples-only --out few"].map(|rest| {
        succeeded(&run_in(folder.path(), &format!("run {case} {rest}")));
        json(&folder.path().join(rest.rsplit(' ').next().unwrap()).join("summary.json"))
    });
    let [nodes, samples, end] = [(&all, "error_x_max"), (&few, "error_x_max"), (&few, "error_x_final")]
        .map(|(summary, key)| summary[key].as_f64().unwrap());
    assert!(samples > 0.9 * nodes && samples < 1.1 * nodes && end < 0.1 * nodes, "{nodes:e}, {samples:e}, {end:e}");
}
