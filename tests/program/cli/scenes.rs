//! Scenes get from `run` what a case of one coordinate gets.

use std::fs;

use tempfile::TempDir;

use crate::common::{json, run_in, stderr, succeeded};

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
    let told = succeeded(&run_in(folder.path(), "run scene.toml --out scene --verbose"));
    assert!(told.contains("even and odd nodes are apart: the sawtooth in x is"), "{told}");
    assert!(told.contains("an explicit recursion"), "{told}");
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
        assert_eq!(text.contains("expect"), has, "{text}");
    }
}

#[test]
fn samples_events_and_pictures_of_a_scene_are_written() {
    let folder = TempDir::new().unwrap();
    let told = succeeded(&run_in(folder.path(), "run kepler --plot --sample-gamma 6:0:-0.5 --out all"));
    assert!(told.contains("  events   ") && told.contains("periapsis 1"), "{told}");
    assert!(told.contains("  exact    energy = -0.5, to "), "{told}");
    let all = folder.path().join("all");
    let pictures = ["orbit.svg", "charges.svg", "mesh.svg", "section.svg"];
    assert!(pictures.iter().all(|name| fs::read_to_string(all.join(name)).unwrap().ends_with("</svg>\n")));
    let table = |name: &str| {
        let mut reader = csv::Reader::from_path(all.join(name)).unwrap();
        let rows = reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect::<Vec<_>>());
        rows.collect::<Vec<_>>()
    };
    let (samples, events) = (table("samples.csv"), table("events.csv"));
    assert_eq!((samples.len(), samples[0][0].as_str(), samples[12][0].as_str()), (13, "6.0", "0.0"));
    assert_eq!((&events[0][0], &events[1][0], events.len()), (&"apoapsis".to_owned(), &"periapsis".to_owned(), 2));
    let number = |text: &str| text.parse::<f64>().unwrap();
    assert!(
        (number(&events[0][1]) - std::f64::consts::PI).abs() < 1e-12 && (number(&events[0][3]) + 1.6).abs() < 1e-12
    );
    let summary = json(&all.join("summary.json"));
    assert_eq!(summary["events"], serde_json::json!({ "apoapsis": 1, "periapsis": 1 }));
    let number = |key: &str| summary[key].as_f64().unwrap();
    assert!((number("energy") + 0.5).abs() < 1e-15 && number("max_abs_delta_energy_ends") < 1e-13);
    assert!(number("max_abs_delta_energy") > number("max_abs_delta_energy_ends"));
    // The events stand in the effective case too, and what was not asked for is taken away.
    assert!(fs::read_to_string(all.join("case.toml")).unwrap().contains("[events]"));
    succeeded(&run_in(folder.path(), "run damped-oscillator --sample-t 0:10:2.5 --out all --force"));
    assert!(!all.join("events.csv").exists() && !all.join("orbit.svg").exists());
    let times: Vec<f64> = table("samples.csv").iter().map(|row| row[1].parse().unwrap()).collect();
    assert_eq!(times, [0.0, 2.5, 5.0, 7.5, 10.0]);
}

#[test]
fn a_particle_with_a_conformal_factor_has_tau_in_every_file_and_table() {
    let folder = TempDir::new().unwrap();
    let text = succeeded(&run_in(folder.path(), "init kerr-mino"));
    fs::write(folder.path().join("mino.toml"), text).unwrap();
    succeeded(&run_in(folder.path(), "check mino.toml --run"));
    let told = succeeded(&run_in(folder.path(), "run mino.toml --plot --sample-gamma 0:1:0.5 --out one"));
    assert!(told.contains("p_tau = -1"), "{told}");
    let header = |file: &str| fs::read_to_string(folder.path().join(file)).unwrap().lines().next().unwrap().to_owned();
    for file in ["one/trajectory.csv", "one/samples.csv", "one/events.csv"] {
        assert!(header(file).contains(",tau,") && header(file).contains(",tau_dot"), "{file}: {}", header(file));
    }
    assert!(header("one/residuals.csv").contains(",delta_q_tau,"));
    let summary = json(&folder.path().join("one/summary.json"));
    let of = |key: &str| summary[key]["tau"].as_f64().unwrap_or_else(|| panic!("{summary}"));
    assert!((of("final") - 400.0).abs() < 1e-10 && (of("charges") + 1.0).abs() < 1e-15, "{summary}");
    let charges = fs::read_to_string(folder.path().join("one/charges.svg")).unwrap();
    assert!(charges.contains("\u{3c4}</tspan>"), "p_tau has a curve");
    succeeded(&run_in(folder.path(), "run mino.toml --vary initial.r=4.0,4.5 --quiet --out two"));
    assert!(header("two/runs.csv").contains(",phi,tau,t_dot,"), "{}", header("two/runs.csv"));
}

#[test]
fn one_iteration_is_no_plural() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("scene.toml"), QUARTIC.replace("x^4/2", "y/10")).unwrap();
    let set = "--set scheme.sbp=SBP42 --set grid.gamma_f=1e-3 --set grid.n_gamma=8";
    let told = succeeded(&run_in(folder.path(), &format!("run scene.toml --verbose --out out {set}")));
    assert!(told.contains("1 Newton iteration\n"), "{told}");
}
