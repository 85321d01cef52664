//! `run --vary` and `merge`: a table of many runs, whole or in parts, and what is left of one that is interrupted.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::common::{failed, json, names, run_in, stderr, succeeded};

const JOURNAL: &str = "runs.partial.csv";

/// The records of a table, its header first.
fn table(path: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_path(path).unwrap();
    reader.records().map(|record| record.unwrap().iter().map(str::to_owned).collect()).collect()
}

/// The column of that name.
fn column(table: &[Vec<String>], name: &str) -> Vec<String> {
    let place = table[0].iter().position(|other| other == name).unwrap_or_else(|| panic!("{name}: {:?}", table[0]));
    table[1..].iter().map(|row| row[place].clone()).collect()
}

/// A number of a summary, as it is written there.
fn number(summary: &str, key: &str) -> String {
    let value = |line: &str| line.trim().strip_prefix(&format!("\"{key}\": ")).map(str::to_owned);
    let value = summary.lines().find_map(value).unwrap_or_else(|| panic!("{key} is not in\n{summary}"));
    value.trim_end_matches(',').to_owned()
}

#[test]
fn a_row_is_the_single_run_with_these_overrides() {
    let folder = TempDir::new().unwrap();
    let told = succeeded(&run_in(
        folder.path(),
        "run quartic --set grid.n_gamma=40 --vary initial.x=0.8:1:2 --vary scheme.sbp=SBP21,SBP42 --out out",
    ));
    assert!(told.contains("varied   initial.x from 0.8 to 1.0 (2 values), scheme.sbp from SBP21 to SBP42"), "{told}");
    assert!(told.contains("rows     4: 4 converged") && told.contains("out: runs.csv, summary.json, case.toml"));
    let out = folder.path().join("out");
    assert_eq!(names(&out), ["case.toml", "runs.csv", "summary.json"]);
    let rows = table(&out.join("runs.csv"));
    let maxima = "max_abs_delta_q_t_interior,max_abs_delta_q_t_last,max_abs_delta_q_t_corrected,\
                  max_abs_delta_g_interior,max_abs_delta_k,max_abs_delta_k_ends,gradient_norm";
    let before = "row,initial.x,scheme.sbp,status,exit_code,ended_by,gamma,t,x,t_dot,x_dot";
    assert_eq!(rows[0].join(","), format!("{before},{maxima},verdict,message"));
    let keys: Vec<String> = rows[1..].iter().map(|row| row[..6].join(" ")).collect();
    let expected = ["1 0.8 SBP21", "2 0.8 SBP42", "3 1.0 SBP21", "4 1.0 SBP42"];
    assert_eq!(keys, expected.map(|row| format!("{row} converged 0 gamma_f")));
    let column = |name: &str| column(&rows, name);
    for (row, (x, sbp)) in [("0.8", "SBP21"), ("0.8", "SBP42"), ("1.0", "SBP21"), ("1.0", "SBP42")].iter().enumerate() {
        let one = format!("run quartic --set grid.n_gamma=40 --set initial.x={x} --set scheme.sbp={sbp} --out one");
        succeeded(&run_in(folder.path(), &one));
        let summary = fs::read_to_string(folder.path().join("one/summary.json")).unwrap();
        for (key, name) in [
            ("gamma_final", "gamma"),
            ("t_final", "t"),
            ("x_final", "x"),
            ("x_dot_final", "x_dot"),
            ("max_abs_delta_q_t_interior", "max_abs_delta_q_t_interior"),
            ("max_abs_delta_q_t_corrected", "max_abs_delta_q_t_corrected"),
            ("max_abs_delta_g_interior", "max_abs_delta_g_interior"),
            ("max_abs_delta_k", "max_abs_delta_k"),
            ("max_abs_delta_k_ends", "max_abs_delta_k_ends"),
            ("gradient_norm", "gradient_norm"),
        ] {
            assert_eq!(number(&summary, key), column(name)[row], "{key} of row {row}");
        }
        // In the strong form the last row of the tangent has the values handed on.
        let trajectory = table(&folder.path().join("one/trajectory.csv"));
        assert_eq!(trajectory.last().unwrap()[3], column("t_dot")[row]);
    }
    let summary = json(&out.join("summary.json"));
    assert_eq!(
        (summary["rows"].as_u64(), summary["runs"].as_u64(), summary["solved"].as_u64()),
        (Some(4), Some(4), Some(4))
    );
    assert_eq!(summary["vary"], serde_json::json!(["initial.x=0.8:1:2", "scheme.sbp=SBP21,SBP42"]));
    // The case is the one that is varied, with what --set says.
    let case = fs::read_to_string(out.join("case.toml")).unwrap();
    assert!(case.contains("n_gamma = 40") && !case.contains("[expect]"), "{case}");
}

#[test]
fn without_out_a_table_has_a_folder_beside_the_results_of_the_case() {
    let folder = TempDir::new().unwrap();
    succeeded(&run_in(folder.path(), "run quartic"));
    let told = succeeded(&run_in(folder.path(), "run quartic --vary initial.x_dot=-0.1:0.1:3 --json"));
    assert_eq!(serde_json::from_str::<serde_json::Value>(&told).unwrap()["statuses"]["converged"], 3);
    let results = folder.path().join("results/quartic");
    assert_eq!(names(&results), ["case.toml", "residuals.csv", "summary.json", "trajectory.csv", "vary"]);
    assert_eq!(column(&table(&results.join("vary/runs.csv")), "initial.x_dot"), ["-0.1", "0.0", "0.1"]);
    // Again: the table is replaced, and nothing is resumed.
    let again = run_in(folder.path(), "run quartic --vary initial.x_dot=-0.1:0.1:3");
    assert!(!stderr(&again).contains("there already") && succeeded(&again).contains("3 converged"));
}

#[test]
fn events_of_all_rows_are_in_one_table_and_the_end_is_named() {
    let folder = TempDir::new().unwrap();
    let set = "--set events.apoapsis.until=true --set grid.windows=10";
    let vary = format!("run kepler {set} --vary initial.x=0.4,0.35 --vary grid.t_f=1,6 --out out");
    succeeded(&run_in(folder.path(), &vary));
    let rows = table(&folder.path().join("out/runs.csv"));
    assert_eq!(column(&rows, "ended_by"), ["t_f", "apoapsis", "t_f", "apoapsis"]);
    assert!(rows[0].contains(&"max_abs_delta_energy_ends".to_owned()), "{:?}", rows[0]);
    assert!(rows[0].contains(&"max_abs_delta_angular_momentum".to_owned()), "{:?}", rows[0]);
    let events = table(&folder.path().join("out/runs-events.csv"));
    assert_eq!(events[0].join(","), "row,event,gamma,t,x,y,s,t_dot,x_dot,y_dot,s_dot");
    let of = |row: &str| -> Vec<Vec<String>> {
        events[1..].iter().filter(|event| event[0] == row).map(|event| event[1..].to_vec()).collect()
    };
    assert!(of("1").is_empty() && of("2").len() == 1 && of("3").is_empty() && of("4").len() == 1, "{events:?}");
    let one = format!("run kepler {set} --set initial.x=0.35 --set grid.t_f=6 --out one");
    succeeded(&run_in(folder.path(), &one));
    assert_eq!(table(&folder.path().join("one/events.csv"))[1..], of("4"));
    // The end is the event.
    assert_eq!(rows[4][rows[0].iter().position(|name| name == "gamma").unwrap()], of("4")[0][1]);
    let until = "run schwarzschild-orbit --vary grid.until=r-9.0 --out until";
    succeeded(&run_in(folder.path(), &format!("{until} --set solver.accuracy=1e-8")));
    let rows = table(&folder.path().join("until/runs.csv"));
    let estimate: f64 = column(&rows, "error_estimate")[0].parse().unwrap();
    assert!(estimate < 1e-8 && ["until", "gamma_f"].contains(&column(&rows, "ended_by")[0].as_str()), "{rows:?}");
}

#[test]
fn a_row_without_a_result_is_a_row_with_a_reason() {
    let folder = TempDir::new().unwrap();
    // At x = −3 the start is behind the horizon; from −0.5 the motion gets there.
    let output = run_in(
        folder.path(),
        "run linear --set grid.gamma_f=4 --vary initial.x=-3,-0.5,3 --vary grid.n_gamma=32,2 --out out",
    );
    let told = succeeded(&output);
    let rows = table(&folder.path().join("out/runs.csv"));
    assert_eq!(
        column(&rows, "status"),
        ["invalid-case", "invalid-case", "outside-domain", "invalid-case", "converged", "invalid-case"],
        "{rows:?}"
    );
    assert_eq!(column(&rows, "exit_code"), ["2", "2", "4", "2", "0", "2"]);
    let messages = column(&rows, "message");
    assert!(
        messages[0].contains("g00") && messages[2].contains("leaves the domain") && messages[5].contains("n_gamma")
    );
    assert!(messages[4].is_empty() && column(&rows, "t")[2].is_empty() && !column(&rows, "t")[4].is_empty());
    assert!(told.contains("rows     6: 1 converged, 4 invalid-case, 1 outside-domain"), "{told}");
    // A table without any solution.
    let none = run_in(folder.path(), "run linear --set grid.gamma_f=4 --vary initial.x=-0.9,-0.8 --out none");
    assert!(failed(&none, 3).contains("no row has a solution"));
    assert_eq!(table(&folder.path().join("none/runs.csv")).len(), 3);
    // A solved row that should not be believed says so.
    let doubtful =
        run_in(folder.path(), "run quartic --vary grid.gamma_f=1,100 --out doubtful --set grid.n_gamma=1001");
    assert!(stderr(&doubtful).contains("1 of the solved rows are doubtful"), "{}", stderr(&doubtful));
    let messages = column(&table(&folder.path().join("doubtful/runs.csv")), "message");
    assert!(messages[0].is_empty() && messages[1].contains("sawtooth"), "{messages:?}");
    // A table has one set of columns, those of the first valid row.
    let text = "potential = { coordinates = [\"x\", \"y\"], formula = \"x^2 + y^2\" }\ngrid.n_gamma = 32\n\
                initial = { x = 1.0, y = 0.0, t_dot = 1.0, x_dot = 0.0, y_dot = 0.1 }\nscheme.sbp = \"SBP42\"\n";
    fs::write(folder.path().join("laws.toml"), text).unwrap();
    succeeded(&run_in(folder.path(), "run laws.toml --vary particle.law=relativistic,newtonian --out laws"));
    let rows = table(&folder.path().join("laws/runs.csv"));
    assert_eq!(column(&rows, "status"), ["converged", "invalid-case"]);
    assert_eq!(column(&rows, "message")[1], "its coordinates are t, x, y, s, and those of the table are t, x, y");
}

/// A table with events, rows of several windows, and one that is invalid.
const TABLE: &str =
    "run kepler --quiet --set grid.windows=8 --vary initial.x=0.3:0.9:3 --vary initial.y_dot=1.0,1.9,abc";

#[test]
fn parts_are_joined_to_the_table_of_one_run_byte_for_byte() {
    let folder = TempDir::new().unwrap();
    succeeded(&run_in(folder.path(), &format!("{TABLE} --out whole")));
    let of = |out: &str| {
        let read = |name: &str| fs::read_to_string(folder.path().join(out).join(name)).unwrap();
        ["runs.csv", "runs-events.csv", "summary.json", "case.toml", ".geodesic-ivp-manifest.json"].map(read)
    };
    assert!(of("whole")[0].lines().count() == 10 && of("whole")[1].lines().count() > 6);
    for (k, n) in [(1, 4), (2, 4), (3, 4), (4, 4), (1, 2), (2, 2), (12, 12)] {
        succeeded(&run_in(folder.path(), &format!("{TABLE} --part {k}/{n} --out p{k}of{n}")));
    }
    let rows = column(&table(&folder.path().join("p2of4/runs.csv")), "row");
    assert_eq!(rows, ["2", "6"]);
    // More parts than rows: some have none.
    assert_eq!(table(&folder.path().join("p12of12/runs.csv")).len(), 1);
    let told = succeeded(&run_in(folder.path(), "merge p3of4 p1of4 p4of4 p2of4 --out merged"));
    assert!(told.contains("rows     9: 5 converged, 3 invalid-case, 1 stalled"), "{told}");
    assert_eq!(of("merged"), of("whole"));
    succeeded(&run_in(folder.path(), "merge p1of2 p4of4 p2of4 --out mixed --quiet"));
    assert_eq!(of("mixed"), of("whole"));

    let refused = |arguments: &str| failed(&run_in(folder.path(), &format!("merge {arguments} --out bad")), 2);
    assert!(refused("p1of4 p2of4 p4of4").contains("part 3/4 is missing: 7 of 9 rows are there"));
    assert!(refused("p1of2 p2of4").contains("rows 4, 8 are missing"));
    let twice = refused("p1of2 p2of2 p3of4");
    assert!(twice.contains("row 3 is both in p1of2 and in p3of4"), "{twice}");
    fs::create_dir(folder.path().join("empty")).unwrap();
    assert!(refused("p1of2 empty").contains("empty has no table of runs"));
    succeeded(&run_in(folder.path(), "run kepler --quiet --out single"));
    assert!(refused("p1of2 single").contains("that of another command"));
    for (change, what) in [("--set grid.windows=9", "cases"), ("--vary grid.t_f=6.0", "what varies")] {
        let part = format!("{TABLE} {change} --part 2/2 --out other")
            .replace("--set grid.windows=8 ", if what == "cases" { "" } else { "--set grid.windows=8 " });
        succeeded(&run_in(folder.path(), &part));
        let message = refused("p1of2 other");
        assert!(message.contains("parts of different tables") && message.contains(what), "{message}");
    }
    assert!(!folder.path().join("bad").exists(), "nothing is left of what was refused");
    assert!(failed(&run_in(folder.path(), "merge p1of2 p2of2"), 2).contains("--out"));
}

#[test]
fn an_unfinished_table_is_not_continued_as_another() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    fs::write(out.join(JOURNAL), "mine").unwrap();
    let message = failed(&run_in(folder.path(), &format!("{TABLE} --out out")), 1);
    assert!(message.contains("nothing says that this program wrote it") && message.contains("--force"), "{message}");
    assert_eq!(fs::read_to_string(out.join(JOURNAL)).unwrap(), "mine");
    succeeded(&run_in(folder.path(), &format!("{TABLE} --out out --force")));
    assert_eq!(names(&out), ["case.toml", "runs-events.csv", "runs.csv", "summary.json"]);
}

/// Programs that are killed and go on, on systems with signals.
#[cfg(unix)]
mod killed {
    use std::process::{Child, Command, Stdio};
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    use super::*;
    use crate::common::program;

    /// Some hundred rows, which take seconds.
    const LONG: &str = "run henon-heiles --set grid.gamma_f=20 --set grid.windows=20 --vary initial.y=-0.2:0.2:200";

    fn start(folder: &Path, arguments: &str) -> Child {
        let mut command = program(folder);
        command.args(arguments.split_whitespace());
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// The whole lines of the journal after the first two: the rows that it has.
    fn rows_in(journal: &Path) -> usize {
        let bytes = fs::read(journal).unwrap_or_default();
        bytes.iter().filter(|&&byte| byte == b'\n').count().saturating_sub(2)
    }

    #[test]
    fn a_killed_table_goes_on_and_ends_as_if_nothing_had_happened() {
        let folder = TempDir::new().unwrap();
        succeeded(&run_in(folder.path(), &format!("{LONG} --quiet --out whole")));
        let journal = folder.path().join("out").join(JOURNAL);
        let mut before = 0;
        // Moments of all kinds: before there is anything, and so long after so many more rows.
        for (rows, microseconds) in [(0, 0), (0, 20_000), (5, 300), (1, 2000), (40, 900), (17, 7000), (2, 100)] {
            let mut child = start(folder.path(), &format!("{LONG} --out out"));
            while rows_in(&journal) < before + rows && child.try_wait().unwrap().is_none() {
                sleep(Duration::from_micros(200));
            }
            sleep(Duration::from_micros(microseconds));
            child.kill().unwrap();
            let output = child.wait_with_output().unwrap();
            assert_eq!(output.status.code(), None, "{}", stderr(&output));
            let now = rows_in(&journal);
            assert!(now >= before + rows, "{before} rows were there, and {now} are left");
            assert!(!folder.path().join("out/runs.csv").exists());
            before = now;
        }
        let rest = run_in(folder.path(), &format!("{LONG} --out out"));
        assert!(stderr(&rest).contains(&format!("note: {before} of 200 rows are there already")), "{}", stderr(&rest));
        succeeded(&rest);
        for name in ["runs.csv", "runs-events.csv", "summary.json", "case.toml"] {
            let read = |out: &str| fs::read_to_string(folder.path().join(out).join(name)).unwrap();
            assert_eq!(read("out"), read("whole"), "{name}");
        }
        assert!(!journal.exists());
    }

    #[test]
    fn an_interrupted_table_keeps_its_rows_for_the_same_command_only() {
        let folder = TempDir::new().unwrap();
        let journal = folder.path().join("out").join(JOURNAL);
        let mut child = start(folder.path(), &format!("{LONG} --out out"));
        let begin = Instant::now();
        while rows_in(&journal) < 3 && begin.elapsed() < Duration::from_secs(60) {
            sleep(Duration::from_millis(5));
        }
        // While it is being computed nobody else computes it.
        assert!(child.try_wait().unwrap().is_none());
        let busy = failed(&run_in(folder.path(), &format!("{LONG} --out out")), 1);
        assert!(busy.contains("another program is computing"), "{busy}");
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        let message = failed(&output, 130);
        let kept = rows_in(&journal);
        assert!(message.contains(&format!("interrupted: {kept} of 200 rows are kept")), "{message}");
        assert_eq!(names(&folder.path().join("out")), ["runs-events.partial.csv", JOURNAL]);
        let unfinished = failed(&run_in(folder.path(), "merge out --out merged"), 2);
        assert!(unfinished.contains("the table of out is not finished"), "{unfinished}");
        for (other, words) in [
            (LONG.replace("20 --set", "21 --set"), "another text of the case"),
            (LONG.replace(":200", ":201"), "--vary initial.y=-0.2:0.2:201"),
            (format!("{LONG} --part 1/2"), "--part 1/2"),
        ] {
            let message = failed(&run_in(folder.path(), &format!("{other} --out out")), 2);
            assert!(message.contains("rows of another table") && message.contains(words), "{message}");
            assert_eq!(rows_in(&journal), kept);
        }
        // Another version of the program does not continue it either.
        let text = fs::read_to_string(&journal).unwrap();
        fs::write(&journal, text.replacen(env!("CARGO_PKG_VERSION"), "0.0.1", 1)).unwrap();
        let message = failed(&run_in(folder.path(), &format!("{LONG} --out out")), 2);
        assert!(message.contains("geodesic-ivp 0.0.1, and this is"), "{message}");
    }
}

#[test]
fn several_cases_are_run_one_after_the_other() {
    let folder = TempDir::new().unwrap();
    let told = succeeded(&run_in(folder.path(), "run quartic CASES/free.toml kepler"));
    for name in ["quartic", "free", "kepler"] {
        assert!(told.contains(&format!("results/{name} (")), "{told}");
        succeeded(&run_in(folder.path(), &format!("run {name} --out alone")));
        let read = |at: &str| fs::read_to_string(folder.path().join(at).join("trajectory.csv")).unwrap();
        assert_eq!(read(&format!("results/{name}")), read("alone"));
    }
    // One that fails does not stop the others, and decides the exit code.
    let output = run_in(folder.path(), "run CASES/hard/horizon.toml free --out out");
    assert!(failed(&output, 4).contains("leaves the domain"));
    assert_eq!(names(&folder.path().join("out")), ["free", "horizon"]);
    assert!(folder.path().join("out/free/trajectory.csv").exists());
    // A mistake in the last one is found before the first is run.
    fs::write(folder.path().join("bad.toml"), "potential.free = {}\n").unwrap();
    failed(&run_in(folder.path(), "run quartic bad.toml --out early"), 2);
    assert!(!folder.path().join("early").exists());
    fs::create_dir(folder.path().join("a")).unwrap();
    fs::copy(crate::common::case_file("free"), folder.path().join("a/free.toml")).unwrap();
    for (arguments, words) in [
        ("quartic quartic", "named twice"),
        ("a/free.toml free --out out", "the same folder"),
        ("quartic free --stdout", "cannot be used"),
        ("quartic free --json", "cannot be used"),
    ] {
        let message = failed(&run_in(folder.path(), &format!("run {arguments}")), 2);
        assert!(message.contains(words), "{arguments}: {message}");
    }
}

#[test]
fn two_keys_make_a_map() {
    let folder = TempDir::new().unwrap();
    let keys = "--vary initial.x=0.5:1:3 --vary grid.n_gamma=2,16,32";
    succeeded(&run_in(folder.path(), &format!("run quartic {keys} --plot --column verdict --out out")));
    assert_eq!(names(&folder.path().join("out")), ["case.toml", "map.svg", "runs.csv", "summary.json"]);
    let svg = fs::read_to_string(folder.path().join("out/map.svg")).unwrap();
    for words in ["verdict over initial.x and grid.n_gamma", "refused", "trusted"] {
        assert!(svg.contains(words), "{words} is not in\n{svg}");
    }
    for (arguments, message) in [
        ("--vary initial.x=0.5:1:3 --plot", "--plot draws a map of a whole table over two keys that vary"),
        (&*format!("{keys} --plot --column momentum"), "the table has no column 'momentum'"),
        (&*format!("{keys} --part auto"), "no variables of a job array are set"),
    ] {
        let told = failed(&run_in(folder.path(), &format!("run quartic {arguments} --out none")), 2);
        assert!(told.contains(message), "{told}");
    }
}
