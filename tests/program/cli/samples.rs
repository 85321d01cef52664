//! `run --sample-t`, `--sample-gamma`, `--samples-only`.

use crate::common::Folder;

#[test]
fn samples_are_written_where_they_are_asked_for() {
    let folder = Folder::new();
    folder.succeeds("run pendulum --sample-t 0:10:0.1 --out out");
    let t = folder.table("out/samples.csv").numbers("t");
    assert_eq!(t.len(), 101);
    assert!(t.iter().zip(0..).all(|(t, k)| (t - 0.1 * f64::from(k)).abs() < 1e-14));
    // A run without samples takes the old ones away.
    folder.succeeds("run pendulum --out out");
    assert!(!folder.has("out/samples.csv"));
    folder.succeeds("run quartic --set solver.digits=40 --sample-gamma 0.9:0.1:-0.2 --out digits");
    assert_eq!(folder.table("digits/samples.csv").column("gamma"), ["0.9", "0.7", "0.5", "0.3", "0.1"]);
}

#[test]
fn nothing_but_samples_is_kept_where_nothing_else_is_wanted() {
    let folder = Folder::new();
    let arguments = "run quartic-windows --sample-t 0:50:5";
    folder.succeeds(&format!("{arguments} --out all"));
    let text = folder.succeeds(&format!("{arguments} --samples-only --out few"));
    assert!(text.contains("  written  few ("), "{text}");
    assert_eq!(folder.names("few"), ["case.toml", "samples.csv", "summary.json"]);
    let samples = folder.read("few/samples.csv");
    assert_eq!(samples, folder.read("all/samples.csv"));
    assert_eq!(folder.succeeds(&format!("{arguments} --samples-only --stdout")), samples);
    let [all, few] = ["all", "few"].map(|out| folder.summary(out));
    for key in ["windows", "max_abs_delta_k", "max_abs_delta_k_ends", "gradient_norm", "t_final"] {
        assert_eq!(all[key], few[key], "{key}");
    }
}

#[test]
fn samples_may_be_a_list_or_a_column() {
    let folder = Folder::new();
    folder.write("times.csv", "n,t\n1,0\n2,1\n3, 2.5\n");
    for case in ["pendulum", "kepler", "quartic-40-digits --set grid.gamma_f=3.0"] {
        let samples =
            |times: &str| folder.succeeds(&format!("run {case} --quiet --stdout --samples-only --sample-t {times}"));
        let listed = samples("0,1,2.5");
        assert_eq!(listed.lines().count(), 4);
        assert_eq!(listed, samples("@times.csv:t"));
        assert_eq!(listed.lines().nth(3), samples("0:2.5:2.5").lines().nth(2));
    }
    folder.refuses(
        &[
            ("0,2,1", "must be in order"),
            ("0,one", "'one' is not a finite number"),
            ("@times.csv:z", "has no column 'z'; its columns are n, t"),
            ("@none.csv:t", "cannot read none.csv"),
            ("0,1,200", "goes beyond the run, which covers 0.0 to 9.99"),
        ]
        .map(|(times, words)| (format!("run pendulum --quiet --sample-t {times}"), 2, words)),
    );
}

/// A run that ends where x is largest: an error of the phase does nothing to x there, but to the samples before.
#[test]
fn errors_are_those_of_all_samples() {
    let folder = Folder::new();
    let case = "quartic-windows --set grid.gamma_f=99.94 --set grid.windows=400 --set scheme.sbp=GLL4 \
                --set grid.n_gamma=4 --sample-gamma 0:99:0.5";
    folder.succeeds(&format!("run {case} --out all"));
    folder.succeeds(&format!("run {case} --samples-only --out few"));
    let [nodes, samples, end] = [("all", "error_max"), ("few", "error_max"), ("few", "error_final")]
        .map(|(out, key)| folder.summary(out)[key]["x"].as_f64().unwrap());
    assert!(samples > 0.9 * nodes && samples < 1.1 * nodes && end < 0.1 * nodes, "{nodes:e}, {samples:e}, {end:e}");
}
