//! What the commands write: files, columns, exit codes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

const CASES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/cases");

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_geodesic-ivp"))
}

fn run_in(directory: &Path, arguments: &str) -> Output {
    program().current_dir(directory).args(arguments.replace("CASES", CASES).split_whitespace()).output().unwrap()
}

fn succeeded(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn names(directory: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(directory).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    // But for the program's own record of them.
    names.retain(|name| name != ".geodesic-ivp-manifest.json");
    names.sort();
    names
}

fn first_line(path: &Path) -> String {
    fs::read_to_string(path).unwrap().lines().next().unwrap().to_owned()
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn run_writes_its_files_into_the_default_directory() {
    let folder = TempDir::new().unwrap();
    let text = succeeded(&run_in(folder.path(), "run CASES/quartic.toml"));
    // What the README shows is what the program prints, but for the time it took.
    let readme = include_str!("../README.md");
    for line in text.lines().filter(|line| !line.starts_with("  scheme")) {
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
    assert!(again.contains("t = 1.4688,"));
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
    for ((row, (gamma, t)), x) in reader.records().zip(solution.gamma().zip(solution.t())).zip(&solution.x) {
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
    assert_eq!(json(&out.join("summary.json"))["initial_guess"], "windowed-action");
    assert!(json(&out.join("summary.json"))["history"].as_array().unwrap().len() >= 2);
    let pictures = names(&out).into_iter().filter(|name| name.ends_with(".svg")).collect::<Vec<_>>();
    assert_eq!(pictures, ["delta_g.svg", "delta_q_t.svg", "t_dot.svg", "trajectory.svg", "world_line.svg"]);
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
        let text = succeeded(&run_in(folder.path(), &arguments));
        assert!(text.contains("SBP42 weak") && text.contains("|grad E_weak|"), "{text}");
        assert!(!text.contains("multiplier") && !text.contains("but the last"), "{text}");
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
    let output = program().current_dir(folder.path()).args(["run", "-"]).stdin(case).output().unwrap();
    assert!(succeeded(&output).contains("results/stdin"));
    assert_eq!(json(&folder.path().join("results/stdin/summary.json"))["x_final"], 1.1);
}

#[test]
fn converge_writes_errors_slopes_and_pictures() {
    let folder = TempDir::new().unwrap();
    let text = succeeded(&run_in(
        folder.path(),
        "converge CASES/quartic.toml --n-gamma 64,32,16 --sbp SBP21 --out out --plot",
    ));
    assert!(text.contains("2.007") && text.contains("2.078"), "{text}");
    let out = folder.path().join("out");
    assert_eq!(names(&out), ["convergence.csv", "errors_final.svg", "errors_l2.svg", "slopes.csv", "summary.json"]);
    let columns = "sbp,form,n_gamma,delta_gamma,eps_t_final,eps_x_final,eps_t_l2,eps_x_l2,delta_q_t_last,delta_k_max,iterations,seconds,status";
    assert_eq!(first_line(&out.join("convergence.csv")), columns);
    let columns = "sbp,form,quantity,slope,standard_error,slope_vs_inverse_n,n_min,n_max,points";
    assert_eq!(first_line(&out.join("slopes.csv")), columns);
    let slopes = fs::read_to_string(out.join("slopes.csv")).unwrap();
    assert!(slopes.lines().nth(1).unwrap().starts_with("SBP21,strong,eps_t_final,1.98"), "{slopes}");
    assert_eq!(json(&out.join("summary.json"))["status"], "complete");
    let ranged = succeeded(&run_in(folder.path(), "converge CASES/quartic.toml --fit-range 64:256 --out out"));
    assert!(ranged.contains("64 … 256") && !ranged.contains("16 …"), "{ranged}");
}

#[test]
fn converge_refuses_what_it_cannot_sweep() {
    let folder = TempDir::new().unwrap();
    for (arguments, code, message) in [
        ("converge CASES/quartic.toml --n-gamma 7", 2, "SBP42 needs at least 8 points"),
        ("converge CASES/quartic.toml --n-gamma 9223372036854775807", 2, "above the limit"),
        (
            "converge CASES/quartic.toml --set potential={formula={expression=\"abs(x)^2.5\"}} --set initial.x=0.0",
            3,
            "no Taylor series",
        ),
        (
            "converge CASES/quartic.toml --set initial.x_dot=10.0 --set grid={t_f=10.0,n_gamma=32}",
            3,
            "t_f is not reached",
        ),
        ("converge CASES/quartic.toml --n-gamma 16,x", 2, "invalid value 'x'"),
        ("converge CASES/quartic.toml --sbp SBP99", 2, "unknown operator \"SBP99\""),
        ("converge CASES/quartic.toml --sbp SBP84 --n-gamma 15", 2, "SBP84 needs at least 16 points"),
        ("converge CASES/quartic.toml --sbp GLL3 --n-gamma 1", 2, "2 or more"),
        (
            "converge CASES/quartic.toml --form weak --set scheme.regularised=false --set solver.system=doubled",
            2,
            "regularised",
        ),
        ("converge CASES/quartic.toml --fit-range 64", 2, "expected MIN:MAX"),
        ("converge CASES/horizon.toml", 4, "the reference trajectory ends at"),
    ] {
        let output = run_in(folder.path(), arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments}: {stderr}");
        assert!(stderr.contains(message), "{arguments}: {stderr}");
    }
    assert!(!folder.path().join("results/horizon/convergence.csv").exists());
    let unresolved =
        run_in(folder.path(), "converge CASES/quartic.toml --set grid.gamma_f=100.0 --sbp SBP42 --n-gamma 16,32");
    assert_eq!(unresolved.status.code(), Some(3), "{}", String::from_utf8_lossy(&unresolved.stderr));
}

#[test]
fn a_result_that_should_not_be_believed_says_so() {
    let folder = TempDir::new().unwrap();
    let output =
        run_in(folder.path(), "run CASES/quartic.toml --set grid.gamma_f=32.0 --set grid.n_gamma=65 --out out");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("K drifts by") && stderr.contains("exceeds its bound"), "{stderr}");
    let warnings = json(&folder.path().join("out/summary.json"))["warnings"].as_array().unwrap().len();
    assert_eq!(warnings, 5, "the sawtooth, K, the step, the bound, and another critical point");
    // The effective case of a changed case makes no promise that was made for another.
    assert!(!fs::read_to_string(folder.path().join("out/case.toml")).unwrap().contains("[expect]"));
}

#[cfg(unix)]
#[test]
fn an_interrupted_sweep_keeps_what_was_finished() {
    use std::io::Read;

    let folder = TempDir::new().unwrap();
    // Many grids, so that some are certainly left when the signal arrives; the finest take a while, so that some are
    // done.
    let grids: Vec<String> = (0..4000).map(|k| (20_000 + k).to_string()).collect();
    let mut child = program()
        .current_dir(folder.path())
        .args(["converge", &format!("{CASES}/quartic.toml"), "--out", "out", "--n-gamma", &grids.join(",")])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(700));
    assert!(Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status().unwrap().success());
    let mut stderr = String::new();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{stderr}");
    assert!(stderr.contains("interrupted:") && stderr.contains("grids were finished"), "{stderr}");
    let rows = fs::read_to_string(folder.path().join("out/convergence.csv")).unwrap().lines().count();
    assert!((2..8000).contains(&rows), "{rows} rows");
    assert_eq!(json(&folder.path().join("out/summary.json"))["status"], "interrupted");
}

#[test]
fn check_prints_the_effective_case_and_compares() {
    let folder = TempDir::new().unwrap();
    let text = succeeded(&run_in(folder.path(), "check CASES/quartic.toml"));
    assert!(text.contains("gamma_i = 0.0") && text.contains("max_iterations = 50"), "{text}");
    for case in fs::read_dir(CASES).unwrap() {
        let output = program().args(["check", "--run", "--quiet"]).arg(case.unwrap().path()).output().unwrap();
        succeeded(&output);
    }
    let missed = run_in(folder.path(), "check --run --quiet CASES/quartic.toml --set expect.x_final=0.16018");
    assert_eq!(missed.status.code(), Some(5));
    assert!(String::from_utf8_lossy(&missed.stderr).contains("x_final"));
}

#[test]
fn completions_and_manual_page() {
    let folder = TempDir::new().unwrap();
    assert!(succeeded(&run_in(folder.path(), "completions bash")).contains("geodesic-ivp"));
    assert!(succeeded(&run_in(folder.path(), "man")).contains(".TH geodesic-ivp"));
    assert!(succeeded(&run_in(folder.path(), "--help")).contains("Exit codes"));
}

#[test]
fn samples_are_written_where_they_are_asked_for() {
    let folder = TempDir::new().unwrap();
    let text = succeeded(&run_in(folder.path(), "run CASES/pendulum.toml --sample-t 0:10:0.1 --out out"));
    assert!(text.contains("samples.csv"));
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
    for (arguments, message) in [
        ("--sample-t 0:11:0.1", "goes beyond the run, which covers 0.0 to 9.99999999999999"),
        ("--sample-gamma 0:1", "expected START:STOP:STEP"),
        ("--sample-gamma 0:1:-0.1", "a STEP that leads from START to STOP"),
        ("--sample-gamma 0:1:nan", "expected START:STOP:STEP"),
        ("--sample-gamma 0:1:1e-12", "more than 1e8 samples"),
        ("--sample-gamma 0:1:0.1 --sample-t 0:1:0.1", "cannot be used with"),
        ("--sample-gamma 0:1:0.1 --stdout", "cannot be used with"),
    ] {
        let output = run_in(folder.path(), &format!("run CASES/pendulum.toml --out none {arguments}"));
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {stderr}");
        assert!(stderr.contains(message), "{arguments}: {stderr}");
        assert!(!folder.path().join("none/trajectory.csv").exists());
    }
}

#[test]
fn nothing_but_samples_is_kept_where_nothing_else_is_wanted() {
    let folder = TempDir::new().unwrap();
    let arguments = "run CASES/quartic-windows.toml --sample-t 0:50:5";
    succeeded(&run_in(folder.path(), &format!("{arguments} --out all")));
    let text = succeeded(&run_in(folder.path(), &format!("{arguments} --samples-only --out few")));
    assert!(text.ends_with("few: samples.csv, summary.json, case.toml\n"), "{text}");
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
fn an_accuracy_stands_in_for_scheme_and_grid() {
    let folder = TempDir::new().unwrap();
    let text = succeeded(&run_in(folder.path(), "run CASES/quartic.toml --set solver.accuracy=1e-9 --out out"));
    assert!(text.contains("GLL") && text.contains("weak") && text.contains("off by"), "{text}");
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
    assert!(String::from_utf8_lossy(&output.stderr).contains("the accuracy is not reached"));
    assert_eq!(names(&folder.path().join("none")), ["case.toml", "summary.json"]);
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
fn work_precision_writes_its_table_its_summary_and_pictures() {
    let folder = TempDir::new().unwrap();
    let small = "--methods gll8,sbp21,rk4,gauss --longest 1e-3";
    // The step of GLL and Gauss methods at its coarsest is too long for the steep wall: a row with its status.
    let command = format!("work-precision CASES/tanh-wall.toml {small} --gamma-f 4,20 --plot --out out");
    let text = succeeded(&run_in(folder.path(), &command));
    assert!(text.contains("ratio") && text.contains("1e-12"), "{text}");
    let out = folder.path().join("out");
    let pictures = ["drift_error.svg", "drift_k.svg", "error_evaluations.svg", "error_evaluations_2.svg"];
    let pictures = [&pictures[..], &["error_time.svg", "error_time_2.svg"]].concat();
    assert_eq!(names(&out), [&["drift.csv"][..], &pictures, &["summary.json", "work_precision.csv"]].concat());
    let columns =
        "method,setting,error_t,error_x,delta_k_max,seconds_min,seconds_median,evaluations,points,status,gamma_f";
    assert_eq!(first_line(&out.join("work_precision.csv")), columns);
    assert_eq!(first_line(&out.join("drift.csv")), "method,setting,gamma,error_t,error_x,delta_k");
    let table = fs::read_to_string(out.join("work_precision.csv")).unwrap();
    assert!(table.contains("converged") && table.contains("not-converged"), "{table}");
    let summary = json(&out.join("summary.json"));
    assert_eq!((summary["status"].as_str(), summary["ratios"].as_array().unwrap().len()), (Some("complete"), 20));
    assert!(!summary["fronts"].as_array().unwrap().is_empty());
    // The table of one run can stand beside another's, and pictures of an earlier run do not.
    let command =
        "work-precision CASES/tanh-wall.toml --methods rk4 --longest 1e-3 --rows out/work_precision.csv --out again";
    succeeded(&run_in(folder.path(), &command.replace("again", "out").replace("--rows out/work_precision.csv", "")));
    assert_eq!(names(&out), ["drift.csv", "summary.json", "work_precision.csv"]);
    succeeded(&run_in(folder.path(), command));
    let lines = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap().lines().count();
    assert!(lines("again/work_precision.csv") > lines("out/work_precision.csv") + 1);
}

#[test]
fn work_precision_refuses_what_it_cannot_chart() {
    let folder = TempDir::new().unwrap();
    for (arguments, code, message) in [
        ("work-precision CASES/horizon.toml", 4, "the reference trajectory ends at"),
        ("work-precision CASES/quartic.toml --methods euler", 2, "no method is called 'euler'"),
        ("work-precision CASES/quartic.toml --gamma-f 0", 2, "expected a positive number"),
        ("work-precision CASES/quartic.toml --gamma-f 1,2,3,4,5", 2, "4 lengths at most"),
        ("work-precision CASES/quartic.toml --rows none.csv", 1, "none.csv"),
    ] {
        let output = run_in(folder.path(), arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments}: {stderr}");
        assert!(stderr.contains(message), "{arguments}: {stderr}");
    }
    assert!(!folder.path().join("results/horizon/work_precision.csv").exists());
}

#[cfg(unix)]
#[test]
fn an_interrupted_chart_keeps_what_was_finished() {
    use std::io::Read;

    let folder = TempDir::new().unwrap();
    let mut child = program()
        .current_dir(folder.path())
        .args(["work-precision", &format!("{CASES}/quartic.toml"), "--out", "out", "--longest", "1"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(700));
    assert!(Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status().unwrap().success());
    let mut stderr = String::new();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{stderr}");
    assert!(stderr.contains("interrupted:") && stderr.contains("settings were finished"), "{stderr}");
    assert_eq!(json(&folder.path().join("out/summary.json"))["status"], "interrupted");
}
