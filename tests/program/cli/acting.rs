//! Events that act, as a user meets them: tables, samples, continued runs, failures and refusals.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::common::{failed, json, names, run_in, succeeded};

/// The rows of a table, as numbers, of these columns.
fn rows(path: &Path, columns: &[&str]) -> Vec<Vec<f64>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let header = reader.headers().unwrap().clone();
    let places: Vec<usize> =
        columns.iter().map(|column| header.iter().position(|name| name == *column).unwrap()).collect();
    reader
        .records()
        .map(|row| places.iter().map(|&place| row.as_ref().unwrap()[place].parse().unwrap()).collect())
        .collect()
}

/// At each of the eight bounces the table has two rows of one gamma, and the velocity is turned between them.
#[test]
fn tables_have_the_rows_before_and_after_an_event() {
    let folder = TempDir::new().unwrap();
    let text = succeeded(&run_in(folder.path(), "run restitution --plot --out out"));
    assert!(text.contains("trusted") && text.contains("in pieces between 8 events"), "{text}");
    let out = folder.path().join("out");
    let table = rows(&out.join("trajectory.csv"), &["gamma", "z", "z_dot", "window"]);
    let turns: Vec<_> = table.windows(2).filter(|pair| pair[0][0] == pair[1][0] && pair[0][2] != pair[1][2]).collect();
    assert_eq!(turns.len(), 8);
    for pair in &turns {
        let [before, after] = [&pair[0], &pair[1]];
        assert!((before[1] - after[1]).abs() < 1e-12 && (after[2] + 0.9 * before[2]).abs() < 1e-12, "{pair:?}");
        assert_eq!(after[3], before[3] + 1.0);
    }
    assert_eq!(table.len(), rows(&out.join("residuals.csv"), &["gamma"]).len());
    let events = rows(&out.join("events.csv"), &["gamma"]);
    assert!(events.iter().zip(&turns).all(|(event, pair)| event[0] == pair[0][0]) && events.len() == 8);
    let summary = json(&out.join("summary.json"));
    assert_eq!(
        (summary["acting_events"].as_u64(), summary["windows"].as_f64()),
        (Some(8), Some(table[table.len() - 1][3]))
    );
    for picture in ["orbit.svg", "charges.svg", "mesh.svg", "section.svg"] {
        let svg = fs::read_to_string(out.join(picture)).unwrap();
        assert!(svg.starts_with("<svg") && !svg.contains("NaN"), "{picture}");
    }
    let piped = succeeded(&run_in(folder.path(), "run restitution --stdout --quiet"));
    assert_eq!(piped.lines().count(), table.len() + 1);
}

/// z = v s − g s²/2, s after the first bounce at 0.45 with v = 0.9 g 0.45.
#[test]
fn samples_are_those_of_the_piece_that_they_are_in() {
    let folder = TempDir::new().unwrap();
    for options in ["--sample-t 0.2:1.2:0.25", "--sample-gamma 0.2:1.2:0.25 --samples-only"] {
        succeeded(&run_in(folder.path(), &format!("run restitution --quiet --out out {options}")));
        let first = (2.0 / 9.81_f64).sqrt();
        for row in rows(&folder.path().join("out/samples.csv"), &["t", "z"]) {
            let s = row[0] - first;
            let z = if s < 0.0 { 1.0 - 4.905 * row[0] * row[0] } else { 0.9 * 9.81 * first * s - 4.905 * s * s };
            assert!((row[1] - z).abs() < 1e-11, "{row:?} {z}");
        }
    }
    let error = failed(&run_in(folder.path(), "run restitution --quiet --out no --sample-t 4:6:1"), 2);
    assert!(error.contains('0') && error.contains('5'), "{error}");
}

#[test]
fn a_run_is_continued_behind_events() {
    let folder = TempDir::new().unwrap();
    let run = |rest: &str| succeeded(&run_in(folder.path(), &format!("run restitution --quiet {rest}")));
    run("--out first --set grid.t_f=3.0");
    run("--out second --set grid.t_f=5.0 --from first");
    let summary = json(&folder.path().join("second/summary.json"));
    assert!((summary["final"]["z"].as_f64().unwrap() - 0.121_548_654_839_124).abs() < 1e-11);
    assert_eq!(summary["acting_events"].as_u64(), Some(4));
}

#[test]
fn bounces_without_an_end_keep_what_was_before() {
    let folder = TempDir::new().unwrap();
    let error = failed(&run_in(folder.path(), "run restitution --quiet --out out --set grid.t_f=20.0"), 3);
    assert!(error.contains("events do not end at gamma = 8.578949") && error.contains("end the run before"), "{error}");
    let out = folder.path().join("out");
    assert_eq!(names(&out), ["case.toml", "events.csv", "summary.json", "until_failure.csv"]);
    let last = rows(&out.join("until_failure.csv"), &["gamma"]).pop().unwrap()[0];
    assert!((last - 8.578_949).abs() < 1e-6 && rows(&out.join("events.csv"), &["gamma"]).len() > 100);
    assert_eq!(json(&out.join("summary.json"))["status"], "events-pile-up");
}

#[test]
fn many_runs_and_checks_know_events_that_act_and_studies_refuse_them() {
    let folder = TempDir::new().unwrap();
    let text =
        succeeded(&run_in(folder.path(), "run restitution --vary potential.parameters.e=0.5,0.9 --set grid.t_f=1.3"));
    assert!(text.contains("2 trusted"), "{text}");
    succeeded(&run_in(folder.path(), "check kick --run --quiet"));
    for command in ["converge", "stability", "work-precision"] {
        let error = failed(&run_in(folder.path(), &format!("{command} restitution")), 2);
        assert!(error.contains("knows no events that act"), "{command}: {error}");
    }
    let error = failed(&run_in(folder.path(), "run restitution --reference"), 2);
    assert!(error.contains("knows no events that act"), "{error}");
}

/// The end of a run does not say what events have made of parameters: to go on from there with those of the file would
/// be another motion.
#[test]
fn a_run_whose_events_set_parameters_is_not_continued() {
    let folder = TempDir::new().unwrap();
    let set = "--set events.floor.set.g=5";
    let text = succeeded(&run_in(folder.path(), &format!("run restitution {set} --set grid.t_f=1.0 --out first")));
    assert!(text.contains("trusted"), "{text}");
    let error = failed(&run_in(folder.path(), &format!("run restitution {set} --from first --out second")), 2);
    assert!(error.contains("goes on from another one") && error.contains("begin at the start"), "{error}");
    assert!(!folder.path().join("second").exists());
}
