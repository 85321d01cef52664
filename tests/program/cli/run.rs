//! `run`: files, columns, what is said.

use geodesic_ivp::case::{Case, builtin};
use geodesic_ivp::{Solution, solve};

use crate::common::{Folder, stderr, succeeded};

/// Files and columns are those of `tests/cmd/first-run.md`.
#[test]
fn the_first_run_is_that_of_the_guide_and_its_case_gives_the_same_again() {
    let folder = Folder::new();
    let text = folder.succeeds("run CASES/quartic.toml");
    let guide = include_str!("../../../docs/guide.md");
    for line in text.lines().filter(|line| !line.starts_with("  written")) {
        assert!(guide.contains(line), "the guide does not show: {line}");
    }
    let summary = folder.summary("results/quartic");
    for key in
        "status version sbp form system digits n_gamma windows iterations gradient_norm multipliers t_final x_final \
                q_t k max_abs_delta_q_t_interior delta_q_t_last max_abs_delta_q_t_corrected max_abs_delta_g_interior \
                max_abs_delta_k max_abs_delta_k_ends sawtooth h_bvp h_bvp_bound solve_seconds initial_guess"
            .split_whitespace()
    {
        assert!(!summary[key].is_null(), "summary.json has no {key}");
    }
    folder.succeeds("run results/quartic/case.toml --out again");
    assert_eq!(folder.summary("again")["x_final"], summary["x_final"]);
}

#[test]
fn the_tables_are_the_solution_to_the_last_bit() {
    let folder = Folder::new();
    folder.succeeds("run units --out out --quiet");
    let solution: Solution = solve(&Case::parse("units", builtin::text("units").unwrap(), &[]).unwrap()).unwrap();
    let table = folder.table("out/trajectory.csv");
    assert_eq!(table.numbers("gamma"), solution.gamma().collect::<Vec<_>>());
    assert_eq!(table.numbers("t"), solution.t().collect::<Vec<_>>());
    assert_eq!(table.numbers("x"), solution.x());
}

#[test]
fn a_doubled_run_writes_branches_and_another_run_removes_them() {
    let folder = Folder::new();
    folder.succeeds("run quartic --set solver.system=doubled --out out --plot --quiet");
    assert!(folder.has("out/branches.csv"));
    let summary = folder.summary("out");
    assert_eq!(summary["initial_guess"], "engine");
    assert!(summary["history"].as_array().unwrap().len() >= 2);
    let of_every_run = ["charges", "delta_g", "delta_q_t", "mesh", "orbit", "t_dot", "trajectory", "world_line"];
    assert_eq!(folder.pictures("out"), of_every_run.map(|name| format!("{name}.svg")));
    folder.succeeds("run quartic --out out --quiet");
    assert_eq!(folder.names("out"), ["case.toml", "residuals.csv", "summary.json", "trajectory.csv"]);
}

#[test]
fn the_weak_form_has_no_multipliers_and_no_last_node_to_speak_of() {
    let folder = Folder::new();
    for system in ["physical-limit", "doubled"] {
        let text =
            folder.succeeds(&format!("run quartic-weak --set solver.system={system} --out out --plot --verbose"));
        assert!(text.contains("SBP42 weak") && text.contains("|grad E_weak|"), "{text}");
        assert!(!text.contains("multiplier") && !text.contains("at the last"), "{text}");
        let summary = folder.summary("out");
        assert!(summary["form"] == "weak" && summary.get("multipliers").is_none());
        for key in ["max_abs_delta_q_t_interior", "delta_q_t_last"] {
            assert!(summary[key].as_f64().unwrap().abs() < 1e-13, "{key}");
        }
        assert!(!folder.read("out/delta_q_t.svg").contains("last node"), "no correction is drawn");
        assert_eq!(folder.has("out/branches.csv"), system == "doubled");
        // One long block of SBP21 is too much for Newton's method: that is said, and nothing is handed on.
        let long = "run quartic --set scheme.form=weak --set grid.gamma_f=100.0 --set grid.n_gamma=2001 --out failed";
        let error = folder.fails(&format!("{long} --set solver.system={system}"), 3);
        assert!(error.contains("no critical point found"), "{system}: {error}");
        assert_eq!(folder.names("failed"), ["case.toml", "summary.json"]);
    }
    let text = folder.succeeds("converge quartic-weak --n-gamma 65,129,257 --out out");
    assert!(text.contains("SBP42 weak"), "{text}");
    let slopes = folder.read("out/slopes.csv");
    assert!(slopes.contains("SBP42,weak,eps_t_final,4.0"), "{slopes}");
}

#[test]
fn an_accuracy_stands_in_for_scheme_and_grid() {
    let folder = Folder::new();
    let text = folder.succeeds("run quartic --set solver.accuracy=1e-9 --out out");
    assert!(text.contains("GLL") && text.contains("weak") && text.contains("relative to the size"), "{text}");
    let summary = folder.summary("out");
    let estimate = summary["error_estimate"].as_f64().unwrap();
    assert!(estimate > 0.0 && estimate <= 1e-9 && summary["accuracy"] == 1e-9);
    assert!((summary["x_final"].as_f64().unwrap() - 0.159_778_018_885_407_25).abs() < 1e-9);
    // The effective case can be run again, says so, and lets a grid take the place of the accuracy.
    let effective = folder.read("out/case.toml");
    assert!(effective.contains("accuracy = 1e-9") && !effective.contains("n_gamma") && !effective.contains("sbp"));
    folder.succeeds("run out/case.toml --out again");
    let grid = "--set grid.n_gamma=32 --set scheme.sbp=SBP21 --set scheme.form=strong";
    folder.succeeds(&format!("run out/case.toml {grid} --out grid"));
    assert_eq!(folder.summary("grid")["n_gamma"], 32);
    // What stands in [scheme] beside an accuracy is not used, and that is said.
    let text = "potential.free = {}\ninitial = { t = 0.0, x = 0.0, t_dot = 1.0, x_dot = 0.5 }\nscheme.sbp = \"SBP21\"\n\
                solver.accuracy = 1e-6\n[grid]\ngamma_f = 1\n";
    folder.write("both.toml", text);
    assert!(stderr(&folder.run("run both.toml")).contains("what [scheme] says is not used"));
    // Beyond what the arithmetic can do.
    let error = folder.fails("run quartic --set solver.accuracy=1e-17 --out none", 3);
    assert!(error.contains("the accuracy 1e-17 is not reached"), "{error}");
    assert_eq!(folder.names("none"), ["case.toml", "summary.json", "until_failure.csv"]);
    assert_eq!(folder.summary("none")["status"], "accuracy-not-reached");
}

#[test]
fn every_so_many_nodes_of_a_window_are_written_and_its_last_one() {
    let folder = Folder::new();
    let windows = "run quartic --set grid.windows=2 --set grid.n_gamma=12 --quiet";
    let rows = |arguments: &str| -> Vec<String> {
        folder.succeeds(&format!("{windows} {arguments}")).lines().map(str::to_owned).collect()
    };
    let (all, few) = (rows("--stdout"), rows("--stdout --every 5"));
    let kept = [0, 1, 6, 11, 12, 13, 18, 23, 24].map(|row| all[row].clone());
    assert_eq!(few, kept);
    rows("--every 5 --out few");
    for name in ["trajectory.csv", "residuals.csv"] {
        assert_eq!(folder.read(&format!("few/{name}")).lines().count(), 9, "{name}");
    }
    folder.refuses(&[("run quartic --every 0", 2, "")]);
}

/// Windows of a grid, a run to an accuracy, whose number of windows is not known before, and one that has one only.
#[test]
fn a_pipe_gets_the_rows_of_the_files_and_the_same_warnings() {
    let folder = Folder::new();
    for case in [
        "quartic",
        "quartic --set grid.windows=3",
        "quartic-accuracy",
        "quartic --set solver.accuracy=1e-3 --set grid.gamma_f=0.1",
        "kepler",
        "henon-heiles --set solver.accuracy=1e-6 --set grid.gamma_f=20.0",
    ] {
        let output = folder.run(&format!("run {case} --stdout --quiet"));
        let piped = succeeded(&output);
        assert_eq!(stderr(&folder.run(&format!("run {case} --quiet --out out --force"))), stderr(&output));
        let [trajectory, residuals] = ["trajectory", "residuals"].map(|name| folder.read(&format!("out/{name}.csv")));
        // The number of the window stands at the end of both.
        let has_window = piped.lines().next().unwrap().ends_with(",window");
        let joined: Vec<String> = trajectory
            .lines()
            .zip(residuals.lines())
            .map(|(one, two)| {
                let one = if has_window { one.rsplit_once(',').unwrap().0 } else { one };
                format!("{one},{}", two.split_once(',').unwrap().1)
            })
            .collect();
        assert!(piped.lines().eq(joined.iter().map(String::as_str)), "{case}");
    }
}

#[test]
fn rows_and_events_before_a_failure_are_kept() {
    let folder = Folder::new();
    // A fall into r = 0 is no critical point; the turn before it is an event.
    let text = "potential = { coordinates = [\"r\"], formula = \"-1/r\" }\nparticle.law = \"newtonian\"\n\
                initial = { r = 1.0, r_dot = 0.5 }\nevents.turn.when = \"r_dot\"\n\
                grid = { gamma_f = 9.0, windows = 80 }\nscheme = { sbp = \"GLL8\", form = \"weak\" }\n";
    folder.write("fall.toml", text);
    let output = folder.run("run fall.toml --out out --quiet");
    assert!([Some(3), Some(4)].contains(&output.status.code()), "{}", stderr(&output));
    assert_eq!(folder.names("out"), ["case.toml", "events.csv", "summary.json", "until_failure.csv"]);
    let (rows, events) = (folder.read("out/until_failure.csv"), folder.read("out/events.csv"));
    assert!(rows.starts_with("gamma,t,r,s,t_dot,r_dot,s_dot,delta_q_t") && rows.lines().count() > 100, "{rows}");
    assert!(events.lines().count() == 2 && events.contains("turn,0.59790"), "{events}");
    // Where the length of the run is searched for, those of the attempt that failed.
    folder.write("search.toml", text.replace("gamma_f", "t_f"));
    folder.run("run search.toml --out search --quiet");
    assert!(
        folder.table("search/until_failure.csv").rows.len() > 100 && folder.read("search/events.csv").contains("turn")
    );
    // Where nothing else was wanted, samples before it are kept: the fall from rest at 1.14 takes 1.35 units.
    folder.fails("run fall.toml --out few --quiet --samples-only --sample-t 0:9:0.25 --set solver.accuracy=1e-9", 3);
    let samples = folder.table("few/until_failure.csv").numbers("t");
    assert!(samples.len() > 4 && samples[4] == 1.0 && *samples.last().unwrap() < 2.5, "{samples:?}");
    // The next run that ends leaves nothing of it.
    folder.succeeds("run fall.toml --out out --quiet --set grid.gamma_f=1.0 --set grid.windows=10");
    assert!(!folder.has("out/until_failure.csv"));
}
