//! `run --vary` and `merge`: a table of many runs, whole or in parts, and what is left of one that is interrupted.
//! `tests/cmd/many-runs.md` has what is said, and what is refused at once.

use std::fs;

#[cfg(target_os = "linux")]
use crate::common::shell;
use crate::common::{CASES, Folder, MANIFEST, failed, stderr, succeeded};

const JOURNAL: &str = "runs.partial.csv";

/// A number of a summary, as it is written there.
fn number(summary: &str, key: &str) -> String {
    let value = |line: &str| line.trim().strip_prefix(&format!("\"{key}\": ")).map(str::to_owned);
    let value = summary.lines().find_map(value).unwrap_or_else(|| panic!("{key} is not in\n{summary}"));
    value.trim_end_matches(',').to_owned()
}

#[test]
fn a_row_is_the_single_run_with_these_overrides() {
    let folder = Folder::new();
    let run = "run quartic --set grid.n_gamma=40";
    folder.succeeds(&format!("{run} --vary initial.x=0.8:1:2 --vary scheme.sbp=SBP21,SBP42 --out out"));
    let table = folder.table("out/runs.csv");
    let maxima = "max_abs_delta_q_t_interior,max_abs_delta_q_t_last,max_abs_delta_q_t_corrected,\
                  max_abs_delta_g_interior,max_abs_delta_k,max_abs_delta_k_ends,gradient_norm";
    let before = "row,initial.x,scheme.sbp,status,exit_code,ended_by,gamma,t,x,t_dot,x_dot";
    assert_eq!(table.columns.join(","), format!("{before},{maxima},verdict,message"));
    for (row, (x, sbp)) in [("0.8", "SBP21"), ("0.8", "SBP42"), ("1.0", "SBP21"), ("1.0", "SBP42")].iter().enumerate() {
        assert_eq!(table.rows[row][..6].join(" "), format!("{} {x} {sbp} converged 0 gamma_f", row + 1));
        folder.succeeds(&format!("{run} --set initial.x={x} --set scheme.sbp={sbp} --out one"));
        let summary = folder.read("one/summary.json");
        let ends = ["gamma", "t", "x", "x_dot"].map(|name| (format!("{name}_final"), name));
        // The one at the last node has a sign in the summary.
        let maxima = maxima.split(',').filter(|name| !name.ends_with("q_t_last")).map(|name| (name.to_owned(), name));
        for (key, name) in ends.into_iter().chain(maxima) {
            assert_eq!(number(&summary, &key), table.column(name)[row], "{key} of row {row}");
        }
        // In the strong form the last row of the tangent has the values handed on.
        assert_eq!(folder.table("one/trajectory.csv").column("t_dot").last(), Some(&table.column("t_dot")[row]));
    }
    let summary = folder.summary("out");
    assert_eq!(["rows", "runs", "solved"].map(|key| summary[key].as_u64()), [Some(4); 3]);
    assert_eq!(summary["vary"], serde_json::json!(["initial.x=0.8:1:2", "scheme.sbp=SBP21,SBP42"]));
    // The case is the one that is varied, with what --set says.
    let case = folder.read("out/case.toml");
    assert!(case.contains("n_gamma = 40") && !case.contains("[expect]"), "{case}");
}

#[test]
fn without_out_a_table_has_a_folder_beside_the_results_of_the_case() {
    let folder = Folder::new();
    folder.succeeds("run quartic");
    let vary = "run quartic --vary initial.x_dot=-0.1:0.1:3";
    let told = folder.succeeds(&format!("{vary} --json"));
    assert_eq!(serde_json::from_str::<serde_json::Value>(&told).unwrap()["statuses"]["converged"], 3);
    let all = ["case.toml", "residuals.csv", "summary.json", "trajectory.csv", "vary"];
    assert_eq!(folder.names("results/quartic"), all);
    assert_eq!(folder.table("results/quartic/vary/runs.csv").column("initial.x_dot"), ["-0.1", "0.0", "0.1"]);
    // Again: the table is replaced, and nothing is resumed.
    let again = folder.run(vary);
    assert!(!stderr(&again).contains("there already") && succeeded(&again).contains("3 converged"));
}

#[test]
fn events_of_all_rows_are_in_one_table_and_the_end_is_named() {
    let folder = Folder::new();
    let run = "run kepler --set events.apoapsis.until=true --set grid.windows=10";
    folder.succeeds(&format!("{run} --vary initial.x=0.4,0.35 --vary grid.t_f=1,6 --out out"));
    let table = folder.table("out/runs.csv");
    assert_eq!(table.column("ended_by"), ["t_f", "apoapsis", "t_f", "apoapsis"]);
    for name in ["max_abs_delta_energy_ends", "max_abs_delta_angular_momentum"] {
        assert!(table.columns.iter().any(|column| column == name), "{:?}", table.columns);
    }
    let events = folder.table("out/runs-events.csv");
    assert_eq!(events.columns.join(","), "row,event,gamma,t,x,y,s,t_dot,x_dot,y_dot,s_dot");
    assert_eq!(events.column("row"), ["2", "4"]);
    folder.succeeds(&format!("{run} --set initial.x=0.35 --set grid.t_f=6 --out one"));
    assert_eq!(folder.table("one/events.csv").rows, [&events.rows[1][1..]]);
    // The end is the event.
    assert_eq!(table.column("gamma")[3], events.column("gamma")[1]);
    folder.succeeds("run schwarzschild-orbit --vary grid.until=r-9.0 --out until --set solver.accuracy=1e-8");
    let table = folder.table("until/runs.csv");
    let ended_by = table.column("ended_by")[0];
    assert!(table.numbers("error_estimate")[0] < 1e-8 && ["until", "gamma_f"].contains(&ended_by), "{table:?}");
}

#[test]
fn a_row_without_a_result_is_a_row_with_a_reason() {
    let folder = Folder::new();
    // At x = −3 the start is behind the horizon; from −0.5 the motion gets there.
    let vary = "--vary initial.x=-3,-0.5,3 --vary grid.n_gamma=32,2";
    folder.succeeds(&format!("run linear --set grid.gamma_f=4 {vary} --out out"));
    let table = folder.table("out/runs.csv");
    assert_eq!(table.column("exit_code"), ["2", "2", "4", "2", "0", "2"], "{table:?}");
    let [messages, t] = ["message", "t"].map(|name| table.column(name));
    let words = ["g00", "", "leaves the domain", "", "", "n_gamma"];
    assert!(messages.iter().zip(words).all(|(message, words)| message.contains(words)), "{messages:?}");
    assert!(messages[4].is_empty() && t[2].is_empty() && !t[4].is_empty());
    // A solved row that should not be believed says so.
    let doubtful = folder.run("run quartic --vary grid.gamma_f=1,100 --out doubtful --set grid.n_gamma=1001");
    assert!(stderr(&doubtful).contains("1 of the solved rows is doubtful"), "{}", stderr(&doubtful));
    let table = folder.table("doubtful/runs.csv");
    let messages = table.column("message");
    assert!(messages[0].is_empty() && messages[1].contains("sawtooth"), "{messages:?}");
    // A table has one set of columns, those of the first valid row.
    let text = "potential = { coordinates = [\"x\", \"y\"], formula = \"x^2 + y^2\" }\n\
                grid = { gamma_f = 1, n_gamma = 32 }\n\
                initial = { x = 1.0, y = 0.0, t_dot = 1.0, x_dot = 0.0, y_dot = 0.1 }\nscheme.sbp = \"SBP42\"\n";
    folder.write("laws.toml", text);
    folder.succeeds("run laws.toml --vary particle.law=relativistic,newtonian --out laws");
    let table = folder.table("laws/runs.csv");
    assert_eq!(table.column("status"), ["converged", "invalid-case"]);
    assert_eq!(table.column("message")[1], "its coordinates are t, x, y, s, and those of the table are t, x, y");
}

/// A table with events, rows of several windows, and one that is invalid.
const TABLE: &str =
    "run kepler --quiet --set grid.windows=8 --vary initial.x=0.3:0.9:3 --vary initial.y_dot=1.0,1.9,abc";

#[test]
fn parts_are_joined_to_the_table_of_one_run_byte_for_byte() {
    let folder = Folder::new();
    folder.succeeds(&format!("{TABLE} --out whole"));
    let of = |out: &str| {
        ["runs.csv", "runs-events.csv", "summary.json", "case.toml", MANIFEST]
            .map(|name| folder.read(&format!("{out}/{name}")))
    };
    assert!(of("whole")[0].lines().count() == 10 && of("whole")[1].lines().count() > 6);
    for (k, n) in [(1, 4), (2, 4), (3, 4), (4, 4), (1, 2), (2, 2), (12, 12)] {
        folder.succeeds(&format!("{TABLE} --part {k}/{n} --out p{k}of{n}"));
    }
    assert_eq!(folder.table("p2of4/runs.csv").column("row"), ["2", "6"]);
    // More parts than rows: some have none.
    assert!(folder.table("p12of12/runs.csv").rows.is_empty());
    let told = folder.succeeds("merge p3of4 p1of4 p4of4 p2of4 --out merged");
    assert!(told.contains("rows     9: 5 converged, 3 invalid-case, 1 stalled"), "{told}");
    folder.succeeds("merge p1of2 p4of4 p2of4 --out mixed --quiet");
    assert_eq!((of("merged"), of("mixed")), (of("whole"), of("whole")));
    // Parts of other tables.
    folder.succeeds(&format!("{} --part 2/2 --out case", TABLE.replace("windows=8", "windows=9")));
    folder.succeeds(&format!("{TABLE} --vary grid.t_f=6.0 --part 2/2 --out keys"));
    // A row that the table does not have.
    folder.succeeds(&format!("{TABLE} --part 2/2 --out longer"));
    let rows = folder.read("longer/runs.csv");
    let (_, cells) = rows.lines().last().and_then(|row| row.split_once(',')).unwrap();
    folder.write("longer/runs.csv", format!("{rows}11,{cells}\n"));
    folder.refuses(&[
        ("merge p1of2 longer --out bad", 2, "a row 11 in longer, but the whole table has 9 rows"),
        ("merge p1of4 p2of4 p4of4 --out bad", 2, "part 3/4 is missing: 7 of 9 rows are there"),
        ("merge p1of2 p2of4 --out bad", 2, "rows 4, 8 are missing"),
        ("merge p1of4 p2of4 --out bad", 2, "parts 3/4, 4/4 are missing"),
        ("merge p1of4 p12of12 --out bad", 2, "rows 2, 3, 4, 6, 7, … are missing"),
        ("merge p1of2 p2of2 p3of4 --out bad", 2, "row 3 is both in p1of2 and in p3of4"),
        ("merge p1of2 case --out bad", 2, "parts of different tables … cases"),
        ("merge p1of2 keys --out bad", 2, "parts of different tables … what varies"),
    ]);
}

#[test]
fn an_unfinished_table_is_not_continued_as_another() {
    let folder = Folder::new();
    folder.write(&format!("out/{JOURNAL}"), "mine");
    let words = "nothing says that this program wrote it … --force";
    folder.refuses(&[(format!("{TABLE} --out out"), 1, words)]);
    folder.succeeds(&format!("{TABLE} --out out --force"));
    assert_eq!(folder.names("out"), ["case.toml", "runs-events.csv", "runs.csv", "summary.json"]);
}

/// Programs that are killed and go on, on systems with signals.
#[cfg(unix)]
mod killed {
    use std::process::{Child, Command, Stdio};
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    use super::*;

    /// Some hundred rows, which take seconds.
    const LONG: &str = "run henon-heiles --set grid.gamma_f=20 --set grid.windows=20 --sample-t 0:20:1 \
                        --vary initial.y=-0.2:0.2:200 --out out";

    fn start(folder: &Folder) -> Child {
        folder.program(LONG).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// The whole lines of the journal after the first two: the rows that it has.
    fn rows_in_journal(folder: &Folder) -> usize {
        let bytes = fs::read(folder.path("out").join(JOURNAL)).unwrap_or_default();
        bytes.iter().filter(|&&byte| byte == b'\n').count().saturating_sub(2)
    }

    #[test]
    fn a_killed_table_goes_on_and_ends_as_if_nothing_had_happened() {
        let folder = Folder::new();
        folder.succeeds(&LONG.replace("--out out", "--quiet --out whole"));
        let mut before = 0;
        // Moments of all kinds: before there is anything, and so long after so many more rows.
        for (rows, microseconds) in [(0, 0), (0, 20_000), (5, 300), (1, 2000), (40, 900), (17, 7000), (2, 100)] {
            let mut child = start(&folder);
            while rows_in_journal(&folder) < before + rows && child.try_wait().unwrap().is_none() {
                sleep(Duration::from_micros(200));
            }
            sleep(Duration::from_micros(microseconds));
            child.kill().unwrap();
            let output = child.wait_with_output().unwrap();
            assert_eq!(output.status.code(), None, "{}", stderr(&output));
            let now = rows_in_journal(&folder);
            assert!(now >= before + rows, "{before} rows were there, and {now} are left");
            assert!(!folder.has("out/runs.csv"));
            before = now;
        }
        let rest = folder.run(LONG);
        assert!(stderr(&rest).contains(&format!("note: {before} of 200 rows are there already")), "{}", stderr(&rest));
        succeeded(&rest);
        for name in ["runs.csv", "runs-events.csv", "runs-samples.csv", "summary.json", "case.toml"] {
            assert_eq!(folder.read(&format!("out/{name}")), folder.read(&format!("whole/{name}")), "{name}");
        }
        assert!(!folder.has(&format!("out/{JOURNAL}")));
    }

    #[test]
    fn an_interrupted_table_keeps_its_rows_for_the_same_command_only() {
        let folder = Folder::new();
        let mut child = start(&folder);
        let begin = Instant::now();
        while rows_in_journal(&folder) < 3 && begin.elapsed() < Duration::from_secs(60) {
            sleep(Duration::from_millis(5));
        }
        // While it is being computed nobody else computes it.
        assert!(child.try_wait().unwrap().is_none());
        let busy = folder.fails(LONG, 1);
        assert!(busy.contains("another program is computing"), "{busy}");
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let message = failed(&child.wait_with_output().unwrap(), 130);
        let kept = rows_in_journal(&folder);
        assert!(message.contains(&format!("interrupted: {kept} of 200 rows are kept")), "{message}");
        assert_eq!(folder.names("out"), ["runs-events.partial.csv", "runs-samples.partial.csv", JOURNAL]);
        folder.refuses(&[
            ("merge out --out merged", 2, "the table of out is not finished"),
            (&*LONG.replace("20 --set", "21 --set"), 2, "rows of another table … another text of the case"),
            (&*LONG.replace(":200", ":201"), 2, "rows of another table … --vary initial.y=-0.2:0.2:201"),
            (&*format!("{LONG} --part 1/2"), 2, "rows of another table … --part 1/2"),
            (&*LONG.replace("0:20:1", "0:20:2"), 2, "begun with --sample-t 0:20:1, and now it is --sample-t 0:20:2"),
        ]);
        // Another version of the program does not continue it either.
        let journal = format!("out/{JOURNAL}");
        folder.write(&journal, folder.read(&journal).replacen(env!("CARGO_PKG_VERSION"), "0.0.1", 1));
        folder.refuses(&[(LONG, 2, "geodesic-ivp 0.0.1, and this is")]);
    }
}

/// A limit of the size of files leaves a journal of some rows. Its table goes on as long as what it is computed from is
/// the same, and not with another table of points, or another run that is continued.
#[cfg(target_os = "linux")]
#[test]
fn a_table_is_not_continued_from_files_with_another_content() {
    let folder = Folder::new();
    let points = |last: u32| folder.write("points.csv", format!("r,v\n0,0\n1,1\n2,4\n3,{last}\n"));
    let first = |x: &str| drop(folder.succeeds(&format!("run free --set initial.x={x} --out first")));
    folder.write(
        "table.toml",
        "tables.v = { file = \"points.csv\", x = \"r\", y = \"v\" }\npotential.formula = \"v(x)\"\n\
         initial = { t = 0, x = 1, t_dot = 1, x_dot = 0 }\ngrid.gamma_f = 0.1\nsolver.accuracy = 1e-6\n",
    );
    let table = "run table.toml --vary initial.x=1:2:100 --out a";
    let from = "run free --from first --set grid.gamma_f=2 --vary particle.mass=1:2:100 --out b";
    let change = |is_changed: bool| {
        points(if is_changed { 8 } else { 9 });
        first(if is_changed { "0.5" } else { "0.25" });
    };
    change(false);
    for (line, name) in [(table, "points.csv"), (from, "first/summary.json")] {
        failed(&shell(&folder.path(""), &format!("ulimit -f 16; exec geodesic-ivp {line}")), 1);
        change(true);
        folder.refuses(&[(line, 2, format!("rows of another table … another content of {name} … --out"))]);
        change(false);
        let rest = folder.run(line);
        assert!(stderr(&rest).contains("of 100 rows are there already"), "{}", stderr(&rest));
        succeeded(&rest);
    }
}

#[test]
fn several_cases_are_run_one_after_the_other() {
    let folder = Folder::new();
    let told = folder.succeeds("run quartic CASES/free.toml kepler");
    for name in ["quartic", "free", "kepler"] {
        assert!(told.contains(&format!("results/{name} (")), "{told}");
        folder.succeeds(&format!("run {name} --out alone"));
        assert_eq!(folder.read(&format!("results/{name}/trajectory.csv")), folder.read("alone/trajectory.csv"));
    }
    // One that fails does not stop the others, and decides the exit code.
    assert!(folder.fails("run horizon free --out out", 4).contains("leaves the domain"));
    assert_eq!(folder.names("out"), ["free", "horizon"]);
    assert!(folder.has("out/free/trajectory.csv"));
    folder.write("bad.toml", "potential.free = {}\n");
    folder.write("a/free.toml", fs::read(format!("{CASES}/free.toml")).unwrap());
    folder.refuses(&[
        // A mistake in the last one is found before the first is run.
        ("run quartic bad.toml --out early", 2, ""),
        ("run quartic quartic", 2, "named twice"),
        ("run a/free.toml free --out out", 2, "the same folder"),
        ("run quartic free --stdout", 2, "cannot be used"),
        ("run quartic free --json", 2, "cannot be used"),
    ]);
}

#[test]
fn two_keys_make_a_map() {
    let folder = Folder::new();
    let keys = "run quartic --vary initial.x=0.5:1:3 --vary grid.n_gamma=2,16,32";
    folder.succeeds(&format!("{keys} --plot --column verdict --out out"));
    assert_eq!(folder.names("out"), ["case.toml", "map.svg", "runs.csv", "summary.json"]);
    let svg = folder.read("out/map.svg");
    for words in ["verdict over x at the start and grid.n_gamma", "refused", "trusted"] {
        assert!(svg.contains(words), "{words} is not in\n{svg}");
    }
    folder.refuses(&[
        (format!("{keys} --plot --column momentum --out none"), 2, "the table has no column 'momentum'"),
        (format!("{keys} --part auto --out none"), 2, "no variables of a job array are set"),
    ]);
}

#[test]
fn one_key_makes_a_line_and_events_a_section_of_all_rows() {
    let folder = Folder::new();
    folder.succeeds("run kepler --vary initial.y_dot=0.9,1,1.1 --plot --column y_dot --out out");
    let tables = ["case.toml", "line.svg", "runs-events.csv", "runs.csv", "section.svg", "summary.json"];
    assert_eq!(folder.names("out"), tables);
    let [line, section] = ["line", "section"].map(|name| folder.read(&format!("out/{name}.svg")));
    assert!(line.contains("y_dot over y_dot at the start"), "{line}");
    for words in ["initial.y_dot = 0.9", "initial.y_dot = 1.1", "events of all rows"] {
        assert!(section.contains(words), "{words} is not in\n{section}");
    }
    // Words have a row of cells.
    folder.succeeds("run quartic --vary grid.n_gamma=2,16,32 --plot --column verdict --out words");
    let words = folder.read("words/line.svg");
    assert!(words.contains("verdict over grid.n_gamma<") && words.contains("refused"), "{words}");
    folder.refuses(&[(
        "run quartic --vary initial.x=1,2 --vary grid.n_gamma=16,32 --vary particle.c=1,2 --plot --out none",
        2,
        "one or two keys",
    )]);
}

#[test]
fn a_pipe_takes_the_rows_in_their_order() {
    let folder = Folder::new();
    let keys = "run quartic --vary initial.x=0.5:1:11 --vary grid.n_gamma=2,16";
    folder.succeeds(&format!("{keys} --out out --quiet"));
    let piped = folder.run(&format!("{keys} --stdout --quiet"));
    assert_eq!(String::from_utf8(piped.stdout).unwrap(), folder.read("out/runs.csv"));
    assert!(piped.status.success() && !folder.has("results"));
    let none = folder.run("run quartic --vary grid.n_gamma=2 --stdout");
    assert_eq!(none.status.code(), Some(2));
    let part = folder.run(&format!("{keys} --stdout --quiet --part 2/2"));
    assert_eq!(String::from_utf8(part.stdout).unwrap().lines().count(), 12);
    folder.refuses(&[
        (format!("{keys} --part 1/2"), 2, "give each part a folder"),
        (format!("{keys} --stdout --plot"), 2, "cannot be used"),
    ]);
}
