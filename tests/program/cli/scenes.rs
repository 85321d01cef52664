//! Scenes get from `run` what a case of one coordinate gets, and with `solver.sensitivity` how changes grow.

use crate::common::{Folder, stderr};

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
    let folder = Folder::new();
    folder.write("scene.toml", QUARTIC);
    let told = folder.succeeds("run scene.toml --out scene --verbose");
    assert!(told.contains("even and odd nodes are apart: the sawtooth in x is"), "{told}");
    assert!(told.contains("an explicit recursion"), "{told}");
    folder.succeeds("run quartic --out one --quiet --set grid.gamma_f=100 --set grid.n_gamma=2001");
    let [scene, one] = ["scene", "one"].map(|name| folder.summary(name));
    let of = |value: &serde_json::Value| value.as_f64().unwrap_or_else(|| panic!("{value} is no number"));
    let (x, alone) = (&scene["sawtooth"]["x"], &one["sawtooth"]["x"]);
    assert!((of(x) / of(alone) - 1.0).abs() < 1e-3, "{x} {alone}");
    // y is not active.
    assert!(scene["sawtooth"].as_object().unwrap().len() == 1 && of(&scene["write_seconds"]) > 0.0);
    let listed = scene["warnings"].as_array().unwrap();
    assert!(listed.iter().any(|warning| warning.as_str().unwrap().contains("the sawtooth in x")), "{listed:?}");
    // In a spectral element there is no such oscillation to be measured, and a resolved motion is not warned of.
    let weak = "--set scheme.sbp=GLL16 --set scheme.form=weak --set grid.n_gamma=16 --set grid.windows=100";
    assert_eq!(stderr(&folder.run(&format!("run scene.toml --out weak {weak}"))), "");
    assert!(folder.summary("weak")["sawtooth"]["x"].is_null());
}

#[test]
fn the_effective_case_has_expectations_only_as_it_stands_in_its_file() {
    let folder = Folder::new();
    folder.write("scene.toml", QUARTIC);
    for (more, has) in [("", true), ("--set grid.gamma_f=1.0 --set grid.n_gamma=21", false)] {
        folder.succeeds(&format!("run scene.toml --quiet --out out {more}"));
        assert_eq!(folder.read("out/case.toml").contains("expect"), has);
    }
}

#[test]
fn samples_events_and_pictures_of_a_scene_are_written() {
    let folder = Folder::new();
    let told = folder.succeeds("run kepler --plot --sample-gamma 6:0:-0.5 --out all");
    assert!(told.contains("  events   ") && told.contains("periapsis 1"), "{told}");
    assert!(told.contains("  exact    energy = -0.5, to "), "{told}");
    assert_eq!(folder.pictures("all"), ["charges.svg", "mesh.svg", "orbit.svg", "section.svg"]);
    let gamma = folder.table("all/samples.csv").numbers("gamma");
    assert_eq!((gamma.len(), gamma[0], gamma[12]), (13, 6.0, 0.0));
    let events = folder.table("all/events.csv");
    assert_eq!(events.column("event"), ["apoapsis", "periapsis"]);
    let [gamma, x] = ["gamma", "x"].map(|name| events.numbers(name)[0]);
    assert!((gamma - std::f64::consts::PI).abs() < 1e-12 && (x + 1.6).abs() < 1e-12);
    let summary = folder.summary("all");
    assert_eq!(summary["events"], serde_json::json!({ "apoapsis": 1, "periapsis": 1 }));
    assert_eq!(summary["ignorable"], serde_json::json!(["t", "s"]));
    let number = |key: &str| summary[key].as_f64().unwrap();
    assert!((number("energy") + 0.5).abs() < 1e-15 && number("max_abs_delta_energy_ends") < 1e-13);
    assert!(number("max_abs_delta_energy") > number("max_abs_delta_energy_ends"));
    // The events stand in the effective case too, and what was not asked for is taken away.
    assert!(folder.read("all/case.toml").contains("[events]"));
    folder.succeeds("run damped-oscillator --sample-t 0:10:2.5 --out all --force");
    assert!(!folder.has("all/events.csv") && !folder.has("all/orbit.svg"));
    assert_eq!(folder.table("all/samples.csv").numbers("t"), [0.0, 2.5, 5.0, 7.5, 10.0]);
}

#[test]
fn a_particle_with_a_conformal_factor_has_tau() {
    let folder = Folder::new();
    let told = folder.succeeds("run kerr-mino --plot --sample-gamma 0:1:0.5 --out one");
    assert!(told.contains("p_tau = -1"), "{told}");
    folder.succeeds("run kerr-mino --vary initial.r=4.0,4.5 --quiet --out two");
    assert!(folder.first_line("two/runs.csv").contains(",phi,tau,t_dot,"));
    let summary = folder.summary("one");
    let of = |key: &str| summary[key]["tau"].as_f64().unwrap_or_else(|| panic!("{summary}"));
    assert!((of("final") - 400.0).abs() < 1e-10 && (of("charges") + 1.0).abs() < 1e-15, "{summary}");
    assert!(folder.read("one/charges.svg").contains("\u{3c4}</tspan>"), "p_tau has a curve");
}

#[test]
fn one_iteration_is_no_plural() {
    let folder = Folder::new();
    folder.write("scene.toml", QUARTIC.replace("x^4/2", "y/10"));
    let set = "--set scheme.sbp=SBP42 --set grid.gamma_f=1e-3 --set grid.n_gamma=8";
    let told = folder.succeeds(&format!("run scene.toml --verbose --out out {set}"));
    assert!(told.contains("1 Newton iteration\n"), "{told}");
}

#[test]
fn a_sensitivity_has_a_table_and_says_how_changes_grow() {
    let folder = Folder::new();
    let told = folder.succeeds("run henon-heiles-megno --set grid.gamma_f=20 --out out");
    let summary = &folder.summary("out")["sensitivity"];
    let [lyapunov, megno] = ["lyapunov", "megno"].map(|key| format!("{:.6}", summary[key].as_f64().unwrap()));
    let growth = format!("  growth   largest Lyapunov exponent {lyapunov}, MEGNO {megno} (2: regular)\n");
    assert!(told.contains(&growth), "{told}{growth}");
    let table = folder.read("out/sensitivity.csv");
    let header = "gamma,d_x_d_x,d_x_d_y,d_x_d_p_x,d_x_d_p_y,d_y_d_x,d_y_d_y,d_y_d_p_x,d_y_d_p_y,d_p_x_d_x,d_p_x_d_y,\
                  d_p_x_d_p_x,d_p_x_d_p_y,d_p_y_d_x,d_p_y_d_y,d_p_y_d_p_x,d_p_y_d_p_y";
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some(header));
    assert_eq!(lines.next(), Some("0.0,1.0,0.0,0.0,0.0,0.0,1.0,0.0,0.0,0.0,0.0,1.0,0.0,0.0,0.0,0.0,1.0"));
    assert!(lines.last().unwrap().starts_with("20.0,"), "{table}");
    let growth = folder.table("out/growth.csv");
    assert_eq!(growth.numbers("gamma").len(), table.lines().count() - 1);
    for key in ["lyapunov", "megno"] {
        assert_eq!(growth.numbers(key).last().copied(), summary[key].as_f64(), "{key}");
    }
}

#[test]
fn many_runs_have_the_growth_of_each_in_columns() {
    let folder = Folder::new();
    let run = "run henon-heiles-megno --set grid.gamma_f=20 --set parameters.v_i=0.1";
    folder.succeeds(&format!("{run} --vary parameters.y_i=0.1,0.2 --out many"));
    folder.succeeds(&format!("{run} --set parameters.y_i=0.2 --out one"));
    let (table, summary) = (folder.table("many/runs.csv"), &folder.summary("one")["sensitivity"]);
    for key in ["lyapunov", "megno"] {
        assert_eq!(table.numbers(key)[1], summary[key].as_f64().unwrap(), "{key}");
    }
    let words = "solver.sensitivity needs solver.accuracy or solver.tolerance … \
                 give solver.tolerance in place of scheme and grid";
    folder.refuses(&[("run henon-heiles --set solver.sensitivity=true", 2, words)]);
}

/// Events, invariants, pictures and an end are no other motion, so that they take nothing from what is said of it.
#[test]
fn what_looks_at_a_run_takes_no_key_away() {
    let folder = Folder::new();
    let keys = |summary: &serde_json::Value| summary.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    let accurate = "quartic-accuracy";
    for (case, more, of) in [
        ("quartic", "--set events.zero.when=x", &["events"][..]),
        (accurate, "--set events.zero.when=x-0.5 --set events.zero.set.x_dot=-x_dot", &["acting_events", "events"]),
        (
            "quartic",
            "--set invariants.square=norm",
            &["invariants", "max_abs_delta_invariant", "max_abs_delta_invariant_ends"],
        ),
        ("quartic", "--set grid.until=x-0.5", &[]),
    ] {
        folder.succeeds(&format!("run {case} --quiet --force --out plain"));
        folder.succeeds(&format!("run {case} --quiet --force --out more {more}"));
        let [plain, summary] = ["plain", "more"].map(|name| folder.summary(name));
        let mut further: Vec<String> = keys(&summary);
        further.retain(|key| plain.get(key).is_none());
        further.sort();
        assert_eq!(further, of, "{more}");
        let missing: Vec<String> = keys(&plain).into_iter().filter(|key| summary.get(key).is_none()).collect();
        assert!(missing.is_empty(), "{more}: {missing:?}");
    }
}

/// The paper's numbers at the last node, 2.06 and 0.0593, are in the tables: there the operator takes up its defect.
#[test]
fn the_last_row_of_the_operator_is_in_a_table() {
    let folder = Folder::new();
    folder.succeeds("run quartic --quiet --out strong");
    let residuals = folder.table("strong/residuals.csv");
    let last = |name: &str| *residuals.numbers(name).last().unwrap();
    assert!((last("d_t") - 2.058).abs() < 5e-4 && (last("delta_q_t") - 0.0593).abs() < 5e-5);
    let (summary, x) = (folder.summary("strong"), *folder.table("strong/trajectory.csv").numbers("x").last().unwrap());
    // V = x⁴/2 and g00 = 1 + 2V with c = m = 1.
    let charge = (1.0 + x.powi(4)) * last("d_t") - summary["q_t"].as_f64().unwrap();
    assert!((charge - last("delta_q_t")).abs() < 1e-14, "{charge}");
    folder.succeeds("run quartic-weak --quiet --out weak");
    assert!(!folder.first_line("weak/residuals.csv").contains("d_t"));
}
