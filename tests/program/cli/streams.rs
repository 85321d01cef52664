//! Standard output: the text of summary.json with `--json` and nothing else, and it is noticed if it cannot be written.

use crate::common::{Folder, failed, shell, stderr, succeeded};

#[test]
fn every_command_with_a_summary_prints_its_text() {
    let folder = Folder::new();
    for (arguments, key) in [
        ("run quartic", "t_final"),
        ("run quartic --set solver.digits=30 --plot", "t_final"),
        ("converge quartic --n-gamma 16,32 --sbp SBP21", "slopes"),
        ("work-precision quartic --methods rk4 --longest 1e-3", "ratios"),
        ("stability quartic --methods rk4 --gamma-f 1 --delta-gamma 0.1", "omega"),
    ] {
        let text = folder.succeeds(&format!("{arguments} --out out --force --json"));
        assert_eq!(text, folder.read("out/summary.json"), "{arguments}");
        assert!(folder.summary("out").get(key).is_some(), "{arguments}: {text}");
    }
    // Without a case there is one object of both.
    let text = folder.succeeds("converge --n-gamma 16,32 --sbp SBP21 --out both --json");
    let both: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&text).unwrap();
    assert_eq!(both.keys().collect::<Vec<_>>(), ["linear", "quartic"]);
    assert!(both.iter().all(|(name, summary)| *summary == folder.summary(&format!("both/{name}"))));
}

#[test]
fn warnings_and_errors_stay_on_standard_error() {
    let folder = Folder::new();
    for (case, code, status, words) in
        [("horizon-near", 0, "converged", "warning:"), ("horizon", 4, "outside-domain", "leaves the domain")]
    {
        let output = folder.run(&format!("run {case} --json --out out"));
        assert!(failed(&output, code).contains(words), "{case}");
        assert_eq!(String::from_utf8(output.stdout).unwrap(), folder.read("out/summary.json"));
        assert_eq!(folder.summary("out")["status"], status);
    }
    let nothing = folder.run("converge horizon --json --out none");
    failed(&nothing, 4);
    assert!(nothing.stdout.is_empty(), "there is no summary");
}

#[cfg(target_os = "linux")]
#[test]
fn lost_output_is_an_error() {
    let folder = Folder::new();
    let lost = |line: &str| failed(&shell(&folder.path(""), &format!("geodesic-ivp {line}")), 1);
    for command in ["run quartic --stdout", "run quartic --json", "init quartic", "completions bash", "man"] {
        assert!(lost(&format!("{command} >&-")).contains("standard output is closed"), "{command}");
        assert!(lost(&format!("{command} >/dev/full")).contains("No space left"), "{command}");
    }
    for command in ["run quartic", "check quartic", "check --run quartic", "init --list"] {
        lost(&format!("{command} >/dev/full"));
    }
}

#[cfg(unix)]
#[test]
fn output_that_nobody_wants_is_no_error() {
    let folder = Folder::new();
    for line in [
        "run quartic --stdout >/dev/null",
        "check quartic >&-",
        "run quartic --json >/dev/null",
        "run free --quiet >&-",
    ] {
        succeeded(&shell(&folder.path(""), &format!("geodesic-ivp {line}")));
    }
    // A reader that goes away.
    let long = "run quartic --stdout --set grid.n_gamma=200000 --set particle.c=2000.0";
    let output = shell(&folder.path(""), &format!("{{ geodesic-ivp {long}; echo $? >&2; }} | head -1"));
    assert!(succeeded(&output).starts_with("gamma,t,x,"));
    assert_eq!(stderr(&output), "0\n");
}

/// Two marches part as the run goes on. A stream shows a window when both have passed it.
#[test]
fn the_error_of_every_node_grows_to_that_of_the_run() {
    let folder = Folder::new();
    for case in [
        "henon-heiles --set solver.accuracy=1e-6 --set grid.gamma_f=50.0",
        "kepler --set solver.tolerance=1e-8",
        "kerr-inclined --set solver.accuracy=1e-9",
    ] {
        folder.succeeds(&format!("run {case} --quiet --out out --force"));
        let (table, summary) = (folder.table("out/residuals.csv"), folder.summary("out"));
        let names: Vec<String> = table.columns.iter().filter(|name| name.starts_with("error_")).cloned().collect();
        assert!(names.len() >= 2 && !names.contains(&"error_s".to_owned()), "{names:?}");
        for name in &names {
            let column = table.numbers(name);
            // In the end sizes are known, which were expected before.
            let before = &column[..column.len() - 16];
            let grows = before.windows(2).all(|pair| pair[0] <= pair[1] * (1.0 + 1e-12));
            assert!(grows && column[0] > 0.0, "{case}: {name}");
            let (last, most) = (column[column.len() - 1], summary["error_max"][&name[6..]].as_f64().unwrap());
            assert!(last <= most * (1.0 + 1e-12) && last >= 0.5 * most, "{case}: {name} {last:e} {most:e}");
        }
        let piped = folder.succeeds(&format!("run {case} --quiet --stdout"));
        assert!(piped.lines().next().unwrap().contains(&names.join(",")));
    }
    folder.succeeds("run quartic --set solver.tolerance=1e-8 --no-error --quiet --out out --force");
    assert!(!folder.first_line("out/residuals.csv").contains("error_"));
}
