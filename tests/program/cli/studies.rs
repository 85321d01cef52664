//! `converge` and `work-precision`: files, columns, what they refuse, interrupts.

use std::fs;
use std::process::{Command, Stdio};

use tempfile::TempDir;

use crate::common::{CASES, failed, first_line, json, names, program, run_in, stderr, succeeded};

/// Every row below this heading has a cell that begins where the heading does.
fn assert_column(text: &str, heading: &str) {
    let (above, below) = text.split_once(heading).unwrap_or_else(|| panic!("no {heading} in {text}"));
    let column = above.lines().last().map_or(0, |line| line.chars().count());
    let ends =
        |line: &str| ["written", "error", "ratio", "length"].iter().any(|end| line.trim_start().starts_with(end));
    let mut rows = 0;
    for line in below.lines().skip(1).take_while(|line| !ends(line)) {
        let cell: Vec<char> = line.chars().skip(column - 1).take(2).collect();
        assert!(cell[0] == ' ' && cell[1] != ' ', "{heading}: {line}");
        rows += 1;
    }
    assert!(rows >= 4, "{rows} rows below {heading} in {text}");
}

#[test]
fn converge_writes_errors_slopes_and_pictures() {
    let folder = TempDir::new().unwrap();
    let text = succeeded(&run_in(
        folder.path(),
        "converge CASES/quartic.toml --n-gamma 64,32,16 --sbp SBP21 --out out --plot --verbose",
    ));
    assert!(text.contains("2.007") && text.contains("2.078"), "{text}");
    ["slope", "grids", "against 1/N", "points"].iter().for_each(|heading| assert_column(&text, heading));
    let out = folder.path().join("out");
    assert_eq!(names(&out), ["convergence.csv", "errors_final.svg", "errors_l2.svg", "slopes.csv", "summary.json"]);
    let columns = "sbp,form,n_gamma,delta_gamma,eps_t_final,eps_x_final,eps_t_l2,eps_x_l2,delta_q_t_last,delta_k_max,\
         iterations,seconds,status";
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
fn a_slope_of_a_base_case_stands_beside_that_of_the_paper() {
    let folder = TempDir::new().unwrap();
    let text = succeeded(&run_in(folder.path(), "converge quartic --sbp SBP21 --n-gamma 16,32,64"));
    assert!(text.contains("SBP21       eps_x_final  2.007 ± 0.002   2.08  16 … 64\n"), "{text}");
    assert!(!text.contains("1/N"), "{text}");
    let changed = succeeded(&run_in(folder.path(), "converge quartic --sbp SBP21 --set particle.mass=2.0"));
    assert!(!changed.contains("paper"), "{changed}");
}

#[test]
fn a_warning_of_a_slope_has_its_remedy() {
    let folder = TempDir::new().unwrap();
    let warned = |arguments: &str| stderr(&run_in(folder.path(), &format!("converge quartic --sbp SBP42 {arguments}")));
    let all = warned("");
    assert!(
        all.contains("eps_x_final: not asymptotic") && all.contains("fit finer grids: --fit-range 64:1024"),
        "{all}"
    );
    assert!(!warned("--fit-range 64:1024").contains("warning"));
    assert!(warned("--n-gamma 16,32,64").contains("sweep finer grids: --n-gamma 64,128,256"));
    // Where all errors are rounding, one warning is for all of them.
    let rounding = warned("--sbp GLL24 --n-gamma 96,192,384");
    assert_eq!(rounding.matches("warning").count(), 1, "{rounding}");
    assert!(rounding.contains("sweep coarser grids with --n-gamma"), "{rounding}");
}

#[test]
fn tables_of_studies_fit_a_hundred_columns_and_say_the_answer_first() {
    let folder = TempDir::new().unwrap();
    for (command, answer) in [
        ("converge --n-gamma 16,32,64,128", "The paper's base cases: the slopes against 1/N agree with"),
        ("converge --n-gamma 16,32,64,128 --verbose", "The paper's base cases: the slopes against 1/N agree with"),
        ("converge quartic --n-gamma 16,32,64 --verbose", "Quartic oscillator: the order is 2.0 for SBP21, 1.8 to 3.1"),
        ("work-precision kerr-inclined --methods gauss,gll12 --longest 1e-3", "An inclined orbit around a rotating"),
        ("stability quartic --gamma-f 1,4 --delta-gamma 0.1,0.5", "Quartic oscillator: "),
        ("check quartic --run", "# The case meets its [expect] table:"),
        ("check kerr-inclined --run", "# The case meets its [expect] table:"),
    ] {
        let text = succeeded(&run_in(folder.path(), command));
        assert!(text.starts_with(answer), "{command}: {text}");
        // A comment of a case is as long as its author made it.
        let long = text.lines().find(|line| line.chars().count() > 100 && !line.starts_with("# "));
        assert!(long.is_none(), "{command}: {long:?}");
    }
}

#[test]
fn what_is_refused_leaves_no_folder() {
    let folder = TempDir::new().unwrap();
    for (arguments, code) in [
        ("converge quartic --n-gamma 7", 2),
        ("stability quartic --delta-gamma 1e-9 --gamma-f 100", 2),
        ("run quartic --sample-gamma 0:5:1", 2),
        ("converge horizon", 4),
    ] {
        failed(&run_in(folder.path(), &format!("{arguments} --out deep/er")), code);
        assert!(names(folder.path()).is_empty(), "{arguments}: {:?}", names(folder.path()));
    }
}

#[test]
fn converge_takes_scenes() {
    let folder = TempDir::new().unwrap();
    let command = "converge kerr-inclined --set grid.gamma_f=60.0 --n-gamma 128,256,512 --sbp SBP21 --out out --plot";
    let text = succeeded(&run_in(folder.path(), &(command.to_owned() + " --set grid.windows=1")));
    assert!(text.contains("SBP21 weak  eps_theta_l2     2.0"), "{text}");
    assert!(text.contains("the order is 2.0 for SBP21 weak"), "{text}");
    let out = folder.path().join("out");
    assert_eq!(names(&out), ["convergence.csv", "errors_final.svg", "errors_l2.svg", "slopes.csv", "summary.json"]);
    let columns = "sbp,form,n_gamma,delta_gamma,eps_t_final,eps_r_final,eps_theta_final,eps_phi_final,eps_t_l2,\
                   eps_r_l2,eps_theta_l2,eps_phi_l2,delta_q_t_last,delta_q_phi_last,delta_k_max,iterations,seconds,\
                   status";
    assert_eq!(first_line(&out.join("convergence.csv")), columns);
    let slopes = fs::read_to_string(out.join("slopes.csv")).unwrap();
    assert_eq!(slopes.lines().count(), 9);
    let reference = &json(&out.join("summary.json"))["reference"];
    assert!(reference["theta_final"].is_number() && reference["phi_size"].is_number(), "{reference}");
    let picture = fs::read_to_string(out.join("errors_final.svg")).unwrap();
    assert!(picture.contains("slope 2.0"), "the largest error is drawn with its slope");
    let plunge = "metric.preset = \"schwarzschild\"\ninitial = { r = 3.0, t_dot = 3.0, r_dot = -1.0, phi_dot = 0.0 }\n\
                  grid.gamma_f = 20.0\nscheme.sbp = \"GLL8\"\n";
    fs::write(folder.path().join("plunge.toml"), plunge).unwrap();
    for command in ["converge plunge.toml --sbp SBP21 --n-gamma 16", "work-precision plunge.toml --methods rk4"] {
        let outside = run_in(folder.path(), command);
        assert_eq!(outside.status.code(), Some(4), "{command}: {}", stderr(&outside));
        assert!(stderr(&outside).contains("the reference trajectory ends at"), "{command}");
    }
}

#[test]
fn a_mixture_of_even_and_odd_grids_is_a_warning_in_the_strong_form() {
    let folder = TempDir::new().unwrap();
    for (arguments, is_mixed) in [
        ("--n-gamma 63,64,65,128 --sbp SBP21", true),
        ("--n-gamma 64,96,128 --sbp SBP21", false),
        ("--n-gamma 65,97,129 --sbp SBP21", false),
        ("--n-gamma 63,64,65,128 --sbp SBP21 --form weak", false),
    ] {
        let output = run_in(folder.path(), &format!("converge quartic {arguments}"));
        succeeded(&output);
        assert_eq!(stderr(&output).contains("even and odd numbers of nodes"), is_mixed, "{arguments}");
    }
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
        ("converge CASES/hard/horizon.toml", 4, "the reference trajectory ends at"),
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
fn work_precision_takes_scenes() {
    let folder = TempDir::new().unwrap();
    let small = "--methods gll8,sbp21,rk4,dop853 --longest 1e-3";
    let command = format!("work-precision schwarzschild-orbit {small} --gamma-f 200 --plot --out out");
    let text = succeeded(&run_in(folder.path(), &command));
    assert!(text.contains("ratio") && text.contains("1e-12"), "{text}");
    let out = folder.path().join("out");
    let columns = "method,setting,error_t,error_r,error_phi,delta_k_max,seconds_min,seconds_median,evaluations,points,\
                   status,gamma_f";
    assert_eq!(first_line(&out.join("work_precision.csv")), columns);
    assert_eq!(first_line(&out.join("drift.csv")), "method,setting,gamma,error_t,error_r,error_phi,delta_k");
    let table = fs::read_to_string(out.join("work_precision.csv")).unwrap();
    assert!(["GLL8 weak", "SBP21 strong", "RK4", "DOP853"].iter().all(|name| table.contains(name)), "{table}");
    let picture = fs::read_to_string(out.join("error_time.svg")).unwrap();
    assert!(picture.contains("largest error of t, r and phi"));
    // Its own table can be read back, and that of another number of coordinates is refused.
    let command = "work-precision schwarzschild-orbit --methods rk4 --longest 1e-3 --gamma-f 200 --out again --rows \
                   out/work_precision.csv";
    succeeded(&run_in(folder.path(), command));
    let command = "work-precision henon-heiles --methods rk4 --longest 1e-3 --rows out/work_precision.csv --out again";
    let refused = run_in(folder.path(), command);
    assert_eq!(refused.status.code(), Some(1), "{}", stderr(&refused));
    let unknown = run_in(folder.path(), "work-precision schwarzschild-orbit --methods verlet");
    assert_eq!(unknown.status.code(), Some(2), "{}", stderr(&unknown));
    assert!(stderr(&unknown).contains("error: Verlet needs a scene that is separable"), "{}", stderr(&unknown));
}

#[test]
fn work_precision_writes_its_table_its_summary_and_pictures() {
    let folder = TempDir::new().unwrap();
    let small = "--methods gll8,sbp21,rk4,gauss --longest 1e-3";
    // The step of GLL and Gauss methods at its coarsest is too long for the steep wall: a row with its status.
    let command = format!("work-precision CASES/hard/tanh-wall.toml {small} --gamma-f 4,20 --plot --out out");
    let text = succeeded(&run_in(folder.path(), &command));
    assert!(text.contains("ratio") && text.contains("1e-12"), "{text}");
    ["own s", "this program  ", "others  "].iter().for_each(|heading| assert_column(&text, heading));
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
    let command = "work-precision CASES/hard/tanh-wall.toml --methods rk4 --longest 1e-3 --rows \
         out/work_precision.csv --out again";
    succeeded(&run_in(folder.path(), &command.replace("again", "out").replace("--rows out/work_precision.csv", "")));
    assert_eq!(names(&out), ["drift.csv", "summary.json", "work_precision.csv"]);
    succeeded(&run_in(folder.path(), command));
    let lines = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap().lines().count();
    // On a busy machine the first row may be the only one below the longest time.
    assert!(lines("again/work_precision.csv") > lines("out/work_precision.csv"));
}

#[test]
fn work_precision_refuses_what_it_cannot_chart() {
    let folder = TempDir::new().unwrap();
    for (arguments, code, message) in [
        ("work-precision CASES/hard/horizon.toml", 4, "the reference trajectory ends at"),
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

/// Interrupts a command while it works. Returns its folder and what it says.
#[cfg(unix)]
fn interrupted(command: &str) -> (TempDir, String) {
    use std::io::Read;

    let folder = TempDir::new().unwrap();
    let mut child = program(folder.path())
        .args(command.replace("CASES", CASES).split_whitespace())
        .args(["--out", "out"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(700));
    assert!(Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status().unwrap().success());
    let mut stderr = String::new();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{stderr}");
    assert_eq!(json(&folder.path().join("out/summary.json"))["status"], "interrupted");
    (folder, stderr)
}

/// The commands have so much to do that some is certainly left when the signal arrives, and each piece takes a while,
/// so that some is done.
#[cfg(unix)]
#[test]
fn interrupted_studies_keep_what_was_finished() {
    let grids: Vec<String> = (0..4000).map(|k| (20_000 + k).to_string()).collect();
    let steps: Vec<String> = (0..3000).map(|k| format!("{:e}", 1e-4 + 1e-9 * f64::from(k))).collect();
    let converge = format!("converge CASES/quartic.toml --n-gamma {}", grids.join(","));
    let stability =
        format!("stability CASES/quartic.toml --methods sbp42,rk4 --gamma-f 1,2 --delta-gamma {}", steps.join(","));
    let chart = "work-precision CASES/quartic.toml --longest 1".to_owned();
    for (command, done, table, most) in [
        (converge, "grids were finished", Some("convergence.csv"), 8000),
        (stability, "cells were finished", Some("stability.csv"), 15_000),
        (chart, "settings were finished", None, 0),
    ] {
        let (folder, stderr) = interrupted(&command);
        assert!(stderr.contains("interrupted:") && stderr.contains(done), "{stderr}");
        if let Some(table) = table {
            let rows = fs::read_to_string(folder.path().join("out").join(table)).unwrap().lines().count();
            assert!((2..most).contains(&rows), "{rows} rows");
        }
    }
}
