//! `run`: files, columns, what is said.

use std::fs;

use tempfile::TempDir;

use crate::common::{CASES, failed, first_line, json, names, program, run_in, stderr, succeeded};

#[test]
fn run_writes_its_files_into_the_default_directory() {
    let folder = TempDir::new().unwrap();
    let text = succeeded(&run_in(folder.path(), "run CASES/quartic.toml"));
    // What the README shows is what the program prints, but for the time it took.
    let readme = include_str!("../../../README.md");
    for line in text.lines().filter(|line| !line.starts_with("  written")) {
        assert!(readme.contains(line), "the README does not show: {line}");
    }
    let out = folder.path().join("results/quartic");
    assert_eq!(names(&out), ["case.toml", "residuals.csv", "summary.json", "trajectory.csv"]);
    assert_eq!(first_line(&out.join("trajectory.csv")), "gamma,t,x,t_dot,x_dot");
    let residuals = "gamma,delta_q_t,delta_q_t_corrected,delta_g_t,delta_g_x,delta_k";
    assert_eq!(first_line(&out.join("residuals.csv")), residuals);
    assert_eq!(fs::read_to_string(out.join("trajectory.csv")).unwrap().lines().count(), 33);
    let summary = json(&out.join("summary.json"));
    for key in
        "status version sbp form system digits n_gamma windows iterations gradient_norm multipliers t_final x_final \
                q_t k max_abs_delta_q_t_interior delta_q_t_last max_abs_delta_q_t_corrected max_abs_delta_g_interior \
                max_abs_delta_k max_abs_delta_k_ends sawtooth h_bvp h_bvp_bound solve_seconds initial_guess"
            .split_whitespace()
    {
        assert!(!summary[key].is_null(), "summary.json has no {key}");
    }
    // The effective case is a case, and gives the same result.
    let again = succeeded(&run_in(folder.path(), "run results/quartic/case.toml --out again"));
    assert!(again.contains("t = 1.4688 ± 0.0002,"), "{again}");
    assert_eq!(json(&folder.path().join("again/summary.json"))["x_final"], summary["x_final"]);
}

#[test]
fn the_tables_are_the_solution_to_the_last_bit() {
    let folder = TempDir::new().unwrap();
    succeeded(&run_in(folder.path(), "run CASES/units.toml --out out --quiet"));
    let text = fs::read_to_string(format!("{CASES}/units.toml")).unwrap();
    let solution: geodesic_ivp::Solution =
        geodesic_ivp::solve(&geodesic_ivp::Case::parse("units", &text, &[]).unwrap()).unwrap();
    let mut reader = csv::Reader::from_path(folder.path().join("out/trajectory.csv")).unwrap();
    for ((row, (gamma, t)), x) in reader.records().zip(solution.gamma().zip(solution.t())).zip(solution.x()) {
        let row = row.unwrap();
        let cell = |i: usize| row[i].parse::<f64>().unwrap();
        assert_eq!([cell(0), cell(1), cell(2)], [gamma, t, *x]);
    }
}

#[test]
fn a_doubled_run_writes_branches_and_another_run_removes_them() {
    let folder = TempDir::new().unwrap();
    succeeded(&run_in(folder.path(), "run CASES/quartic.toml --set solver.system=doubled --out out --plot --quiet"));
    let out = folder.path().join("out");
    assert_eq!(first_line(&out.join("branches.csv")), "gamma,t_1,x_1,t_2,x_2");
    assert_eq!(json(&out.join("summary.json"))["initial_guess"], "engine");
    assert!(json(&out.join("summary.json"))["history"].as_array().unwrap().len() >= 2);
    let pictures = names(&out).into_iter().filter(|name| name.ends_with(".svg")).collect::<Vec<_>>();
    let of_every_run = ["charges.svg", "mesh.svg", "orbit.svg"];
    let of_x = ["delta_g.svg", "delta_q_t.svg", "t_dot.svg", "trajectory.svg", "world_line.svg"];
    assert!(of_every_run.iter().chain(&of_x).all(|name| pictures.iter().any(|other| other == name)));
    assert_eq!(pictures.len(), 8);
    for picture in pictures {
        let svg = fs::read_to_string(out.join(picture)).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>") && !svg.contains("NaN"));
    }
    succeeded(&run_in(folder.path(), "run CASES/quartic.toml --out out --quiet"));
    assert_eq!(names(&out), ["case.toml", "residuals.csv", "summary.json", "trajectory.csv"]);
}

#[test]
fn the_weak_form_has_no_multipliers_and_no_last_node_to_speak_of() {
    let folder = TempDir::new().unwrap();
    for system in ["physical-limit", "doubled"] {
        let arguments = format!("run CASES/quartic-weak.toml --set solver.system={system} --out out --plot");
        let text = succeeded(&run_in(folder.path(), &format!("{arguments} --verbose")));
        assert!(text.contains("SBP42 weak") && text.contains("|grad E_weak|"), "{text}");
        assert!(!text.contains("multiplier") && !text.contains("at the last"), "{text}");
        let summary = json(&folder.path().join("out/summary.json"));
        assert_eq!(summary["form"], "weak");
        assert!(summary.get("multipliers").is_none());
        assert!(summary["max_abs_delta_q_t_interior"].as_f64().unwrap() < 1e-13);
        assert!(summary["delta_q_t_last"].as_f64().unwrap().abs() < 1e-13);
        let picture = fs::read_to_string(folder.path().join("out/delta_q_t.svg")).unwrap();
        assert!(!picture.contains("last node"), "no correction is drawn");
        assert_eq!(folder.path().join("out/branches.csv").exists(), system == "doubled");
    }
    let text = succeeded(&run_in(folder.path(), "converge CASES/quartic-weak.toml --n-gamma 65,129,257 --out out"));
    assert!(text.contains("SBP42 weak"), "{text}");
    let slopes = fs::read_to_string(folder.path().join("out/slopes.csv")).unwrap();
    assert!(slopes.contains("SBP42,weak,eps_t_final,4.0"), "{slopes}");
    // One long block of SBP21 is too much for Newton's method: that is said, and nothing is handed on.
    for system in ["physical-limit", "doubled"] {
        let arguments = format!(
            "run CASES/quartic.toml --set scheme.form=weak --set grid.gamma_f=100.0 --set grid.n_gamma=2001 \
             --set solver.system={system} --out failed"
        );
        let output = run_in(folder.path(), &arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{system}: {stderr}");
        assert!(stderr.contains("no critical point found"), "{system}: {stderr}");
        assert_eq!(names(&folder.path().join("failed")), ["case.toml", "summary.json"]);
    }
}

#[test]
fn standard_output_carries_data_only() {
    let folder = TempDir::new().unwrap();
    let text = succeeded(&run_in(folder.path(), "run CASES/quartic.toml --stdout"));
    let mut lines = text.lines();
    let header = "gamma,t,x,t_dot,x_dot,delta_q_t,delta_q_t_corrected,delta_g_t,delta_g_x,delta_k";
    assert_eq!(lines.next(), Some(header));
    assert_eq!(lines.count(), 32);
    assert!(names(folder.path()).is_empty(), "no files");
    assert_eq!(succeeded(&run_in(folder.path(), "run CASES/quartic.toml --quiet")), "");
}

#[test]
fn a_case_can_come_from_standard_input() {
    let folder = TempDir::new().unwrap();
    let case = fs::File::open(format!("{CASES}/free.toml")).unwrap();
    let output = program(folder.path()).args(["run", "-"]).stdin(case).output().unwrap();
    assert!(succeeded(&output).contains("results/stdin"));
    let x_final = json(&folder.path().join("results/stdin/summary.json"))["x_final"].as_f64().unwrap();
    assert!((x_final - 1.1).abs() < 1e-14, "{x_final}");
}

#[test]
fn a_result_that_should_not_be_believed_says_so() {
    let folder = TempDir::new().unwrap();
    let output = run_in(
        folder.path(),
        "run CASES/quartic.toml --set grid.gamma_f=32.0 --set grid.n_gamma=65 --verbose --out out",
    );
    let told = succeeded(&output);
    assert!(told.contains("K drifts by") && told.contains("exceeds its bound"), "{told}");
    let warnings = json(&folder.path().join("out/summary.json"))["warnings"].as_array().unwrap().len();
    assert_eq!(warnings, 5, "the sawtooth, K, the step, the bound, and another critical point");
    // The effective case of a changed case makes no promise that was made for another.
    assert!(!fs::read_to_string(folder.path().join("out/case.toml")).unwrap().contains("[expect]"));
}

#[test]
fn an_accuracy_stands_in_for_scheme_and_grid() {
    let folder = TempDir::new().unwrap();
    let text = succeeded(&run_in(folder.path(), "run CASES/quartic.toml --set solver.accuracy=1e-9 --out out"));
    assert!(text.contains("GLL") && text.contains("weak") && text.contains("relative to the size"), "{text}");
    let summary = json(&folder.path().join("out/summary.json"));
    let estimate = summary["error_estimate"].as_f64().unwrap();
    assert!(estimate > 0.0 && estimate <= 1e-9 && summary["accuracy"] == 1e-9);
    assert!((summary["x_final"].as_f64().unwrap() - 0.159_778_018_885_407_25).abs() < 1e-9);
    // The effective case can be run again, says so, and lets a grid take the place of the accuracy.
    let effective = fs::read_to_string(folder.path().join("out/case.toml")).unwrap();
    assert!(effective.contains("accuracy = 1e-9") && !effective.contains("n_gamma") && !effective.contains("sbp"));
    succeeded(&run_in(folder.path(), "run out/case.toml --out again"));
    let grid = "run out/case.toml --set grid.n_gamma=32 --set scheme.sbp=SBP21 --set scheme.form=strong --out grid";
    succeeded(&run_in(folder.path(), grid));
    assert_eq!(json(&folder.path().join("grid/summary.json"))["n_gamma"], 32);
    // What stands in [scheme] beside an accuracy is not used, and that is said.
    let text = "potential.free = {}\ninitial = { t = 0.0, x = 0.0, t_dot = 1.0, x_dot = 0.5 }\nscheme.sbp = \"SBP21\"\n\
                solver.accuracy = 1e-6\n[grid]\n";
    fs::write(folder.path().join("both.toml"), text).unwrap();
    let output = run_in(folder.path(), "run both.toml");
    succeeded(&output);
    assert!(String::from_utf8_lossy(&output.stderr).contains("what [scheme] says is not used"));
    // Beyond what the arithmetic can do.
    let output = run_in(folder.path(), "run CASES/quartic.toml --set solver.accuracy=1e-17 --out none");
    assert_eq!(output.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&output.stderr).contains("the accuracy 1e-17 is not reached"));
    assert_eq!(names(&folder.path().join("none")), ["case.toml", "summary.json", "until_failure.csv"]);
    assert_eq!(json(&folder.path().join("none/summary.json"))["status"], "accuracy-not-reached");
}

#[test]
fn an_override_takes_the_place_of_what_it_excludes() {
    let folder = TempDir::new().unwrap();
    succeeded(&run_in(folder.path(), "run CASES/quartic.toml --set grid.t_f=1.0 --set initial.velocity=0.2 --out out"));
    let summary = json(&folder.path().join("out/summary.json"));
    assert!((summary["t_final"].as_f64().unwrap() - 1.0).abs() < 1e-14);
    let effective = fs::read_to_string(folder.path().join("out/case.toml")).unwrap();
    assert!(!effective.contains("gamma_f") && !effective.contains("x_dot"), "{effective}");
}

#[test]
fn every_so_many_nodes_of_a_window_are_written_and_its_last_one() {
    let folder = TempDir::new().unwrap();
    let windows = "run quartic --set grid.windows=2 --set grid.n_gamma=12 --quiet";
    let rows = |arguments: &str| -> Vec<String> {
        let text = succeeded(&run_in(folder.path(), arguments));
        text.lines().map(str::to_owned).collect()
    };
    let (all, few) = (rows(&format!("{windows} --stdout")), rows(&format!("{windows} --stdout --every 5")));
    let kept = [0, 5, 10, 11].map(|node| [1 + node, 13 + node]);
    let mut expected = vec![all[0].clone()];
    expected.extend([0, 1].iter().flat_map(|&window| kept.map(|rows| all[rows[window]].clone())));
    assert_eq!(few, expected);
    succeeded(&run_in(folder.path(), &format!("{windows} --every 5 --out few")));
    for name in ["trajectory.csv", "residuals.csv"] {
        assert_eq!(fs::read_to_string(folder.path().join("few").join(name)).unwrap().lines().count(), 9, "{name}");
    }
    failed(&run_in(folder.path(), "run quartic --every 0"), 2);
}

/// Windows of a grid, a run to an accuracy, whose number of windows is not known before, and one that has one only.
#[test]
fn a_pipe_gets_the_rows_of_the_files() {
    let folder = TempDir::new().unwrap();
    for case in [
        "quartic --set grid.windows=3",
        "quartic-accuracy",
        "quartic --set solver.accuracy=1e-3 --set grid.gamma_f=0.1",
        "kepler",
        "henon-heiles --set solver.accuracy=1e-6 --set grid.gamma_f=20.0",
    ] {
        let piped = succeeded(&run_in(folder.path(), &format!("run {case} --stdout --quiet")));
        succeeded(&run_in(folder.path(), &format!("run {case} --quiet --out out --force")));
        let table = |name: &str| fs::read_to_string(folder.path().join("out").join(name)).unwrap();
        let (trajectory, residuals) = (table("trajectory.csv"), table("residuals.csv"));
        let window = |line: &str| {
            if trajectory.starts_with("gamma") && piped.lines().next().unwrap().ends_with(",window") {
                line.rsplit_once(',').map_or_else(String::new, |(rest, _)| rest.to_owned())
            } else {
                line.to_owned()
            }
        };
        let joined: Vec<String> = trajectory
            .lines()
            .zip(residuals.lines())
            .map(|(one, two)| format!("{},{}", window(one), two.split_once(',').unwrap().1))
            .collect();
        assert!(piped.lines().eq(joined.iter().map(String::as_str)), "{case}");
    }
}

#[test]
fn rows_and_events_before_a_failure_are_kept() {
    let folder = TempDir::new().unwrap();
    // A fall into r = 0 is no critical point; the turn before it is an event.
    let text = "potential = { coordinates = [\"r\"], formula = \"-1/r\" }\nparticle.law = \"newtonian\"\n\
                initial = { r = 1.0, r_dot = 0.5 }\nevents.turn.when = \"r_dot\"\n\
                grid = { gamma_f = 9.0, windows = 90 }\nscheme = { sbp = \"GLL8\", form = \"weak\" }\n";
    fs::write(folder.path().join("fall.toml"), text).unwrap();
    let output = run_in(folder.path(), "run fall.toml --out out --quiet");
    assert!([Some(3), Some(4)].contains(&output.status.code()), "{}", stderr(&output));
    let read = |name: &str| fs::read_to_string(folder.path().join("out").join(name)).unwrap();
    assert_eq!(names(&folder.path().join("out")), ["case.toml", "events.csv", "summary.json", "until_failure.csv"]);
    let (rows, events) = (read("until_failure.csv"), read("events.csv"));
    assert!(rows.starts_with("gamma,t,r,s,t_dot,r_dot,s_dot,delta_q_t") && rows.lines().count() > 100, "{rows}");
    assert!(events.lines().count() == 2 && events.contains("turn,0.59790"), "{events}");
    // The next run that ends leaves nothing of it.
    succeeded(&run_in(folder.path(), "run fall.toml --out out --quiet --set grid.gamma_f=1.0 --set grid.windows=10"));
    assert!(!folder.path().join("out/until_failure.csv").exists());
}

#[test]
fn a_run_into_a_pipe_warns_of_the_same() {
    let folder = TempDir::new().unwrap();
    let warnings = |arguments: &str| stderr(&run_in(folder.path(), &format!("run quartic --quiet {arguments}")));
    let piped = warnings("--stdout");
    assert!(piped.contains("not the motion of Newton's mechanics"), "{piped}");
    assert_eq!(piped, warnings("--out out"));
}
