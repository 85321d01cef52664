//! Scenes get from `run` what a case of one coordinate gets.

use std::fs;

use tempfile::TempDir;

use super::common::{json, run_in, stderr, succeeded};

/// The quartic case with a second coordinate that nothing depends on.
const QUARTIC: &str = r#"
    potential = { coordinates = ["x", "y"], formula = "x^4/2" }
    initial = { x = 1.0, y = 0.0, t_dot = 1.0, x_dot = 0.1, y_dot = 0.0 }
    grid = { gamma_f = 100.0, n_gamma = 2001 }
    scheme.sbp = "SBP21"
    expect = { x_final = 1.0, tolerance = 3.0 }
"#;

#[test]
fn a_scene_is_warned_of_its_sawtooth_as_one_coordinate_is() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("scene.toml"), QUARTIC).unwrap();
    let output = run_in(folder.path(), "run scene.toml --out scene");
    let warnings = stderr(&output);
    assert!(warnings.contains("even and odd nodes are apart: the sawtooth in x is"), "{warnings}");
    assert!(succeeded(&output).contains("from an explicit recursion"));
    let one = "run quartic --out one --quiet --set grid.gamma_f=100 --set grid.n_gamma=2001";
    succeeded(&run_in(folder.path(), one));
    let [scene, one] = ["scene", "one"].map(|name| json(&folder.path().join(name).join("summary.json")));
    let of = |value: &serde_json::Value| value.as_f64().unwrap_or_else(|| panic!("{value} is no number"));
    let (x, alone) = (&scene["sawtooth"]["x"], &one["sawtooth"]);
    assert!((of(x) / of(alone) - 1.0).abs() < 1e-3, "{x} {alone}");
    // y is not active.
    assert!(scene["sawtooth"].as_object().unwrap().len() == 1 && of(&scene["write_seconds"]) > 0.0);
    let listed = scene["warnings"].as_array().unwrap();
    assert!(listed.iter().any(|warning| warning.as_str().unwrap().contains("the sawtooth in x")), "{listed:?}");
    // In a spectral element there is no such oscillation to be measured, and a resolved motion is not warned of.
    let weak = "--set scheme.sbp=GLL16 --set scheme.form=weak --set grid.n_gamma=16 --set grid.windows=100";
    let output = run_in(folder.path(), &format!("run scene.toml --out weak {weak}"));
    assert_eq!(stderr(&output), "");
    assert!(json(&folder.path().join("weak/summary.json"))["sawtooth"]["x"].is_null());
}

#[test]
fn the_effective_case_has_expectations_only_as_it_stands_in_its_file() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("scene.toml"), QUARTIC).unwrap();
    for (more, has) in [("", true), ("--set grid.gamma_f=1.0 --set grid.n_gamma=21", false)] {
        succeeded(&run_in(folder.path(), &format!("run scene.toml --quiet --out out {more}")));
        let text = fs::read_to_string(folder.path().join("out/case.toml")).unwrap();
        assert_eq!(text.contains("[expect]"), has, "{text}");
    }
}

#[test]
fn one_iteration_is_no_plural() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("scene.toml"), QUARTIC.replace("x^4/2", "y/10")).unwrap();
    let set = "--set scheme.sbp=SBP42 --set grid.gamma_f=1e-3 --set grid.n_gamma=8";
    let told = succeeded(&run_in(folder.path(), &format!("run scene.toml --out out {set}")));
    assert!(told.contains("from 1 Newton iteration\n"), "{told}");
}
