//! A folder's files: the program replaces what it wrote, and nothing else.

use std::fs;

use tempfile::TempDir;

use crate::common::{CASES, MANIFEST, failed, json, names, run_in, stderr, succeeded};

const SET: [&str; 4] = ["case.toml", "residuals.csv", "summary.json", "trajectory.csv"];

#[test]
fn files_of_a_user_are_neither_replaced_nor_removed() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    let own = |name: &str| fs::write(out.join(name), "a user's own").unwrap();
    let is_own = |name: &str| fs::read_to_string(out.join(name)).unwrap() == "a user's own";
    // What a run does not write is left alone, also where another run would write or remove it.
    ["samples.csv", "branches.csv", "world_line.svg", "notes.txt"].iter().for_each(|name| own(name));
    succeeded(&run_in(folder.path(), "run CASES/quartic.toml --out out"));
    succeeded(&run_in(folder.path(), "run CASES/hard/horizon-near.toml --out out"));
    failed(&run_in(folder.path(), "run CASES/hard/horizon.toml --out out"), 4);
    assert!(["samples.csv", "branches.csv", "world_line.svg", "notes.txt"].into_iter().all(is_own));
    // What it does write is refused before anything is computed.
    let before = fs::read(out.join("summary.json")).unwrap();
    let message = failed(&run_in(folder.path(), "run CASES/quartic.toml --sample-t 0:1:0.5 --plot --out out"), 1);
    assert!(message.contains("samples.csv, world_line.svg") && message.contains("--force"), "{message}");
    assert!(is_own("samples.csv") && fs::read(out.join("summary.json")).unwrap() == before);
    // By force it is replaced, and from then on the program's.
    succeeded(&run_in(folder.path(), "run CASES/quartic.toml --sample-t 0:1:0.5 --out out --force"));
    assert!(!is_own("samples.csv") && is_own("world_line.svg"));
    succeeded(&run_in(folder.path(), "run CASES/quartic.toml --out out"));
    assert!(!out.join("samples.csv").exists() && is_own("branches.csv") && is_own("notes.txt"));
}

#[test]
fn results_without_a_record_are_taken_for_a_users() {
    let folder = TempDir::new().unwrap();
    succeeded(&run_in(folder.path(), "run CASES/quartic.toml"));
    let out = folder.path().join("results/quartic");
    let record = json(&out.join(MANIFEST));
    assert_eq!((record["command"].as_str(), record["state"].as_str()), (Some("run"), Some("complete")));
    assert_eq!(record["files"].as_array().unwrap().len(), 4);
    fs::remove_file(out.join(MANIFEST)).unwrap();
    let message = failed(&run_in(folder.path(), "run CASES/quartic.toml"), 1);
    assert!(message.contains("trajectory.csv, residuals.csv, summary.json, case.toml"), "{message}");
    assert!(message.contains("--out") && message.contains("--force"), "{message}");
    succeeded(&run_in(folder.path(), "run CASES/quartic.toml --force"));
    // A record that is none, or that leads out of the folder, is not followed.
    fs::write(out.join(MANIFEST), "{}").unwrap();
    assert!(failed(&run_in(folder.path(), "run CASES/quartic.toml"), 1).contains(MANIFEST));
    fs::write(folder.path().join("results/mine.txt"), "mine").unwrap();
    let outside = record.to_string().replace("\"case.toml\"", "\"../mine.txt\"");
    fs::write(out.join(MANIFEST), outside).unwrap();
    assert!(failed(&run_in(folder.path(), "run CASES/quartic.toml"), 1).contains("../mine.txt"));
    assert!(folder.path().join("results/mine.txt").exists());
}

#[test]
fn cases_and_commands_have_default_folders_of_their_own() {
    let folder = TempDir::new().unwrap();
    let results = folder.path().join("results");
    for (place, source) in [("a", "quartic"), ("b", "free")] {
        fs::create_dir(folder.path().join(place)).unwrap();
        fs::copy(format!("{CASES}/{source}.toml"), folder.path().join(place).join("case.toml")).unwrap();
    }
    let title = |at: &str| json(&results.join(at).join("summary.json"))["title"].as_str().map(str::to_owned);
    // Each again and in any order: a case keeps its folder.
    for (case, at, expected) in [
        ("a/case.toml", "case", "Quartic oscillator"),
        ("b/case.toml", "case-2", "Free particle"),
        ("a/case.toml", "case", "Quartic oscillator"),
        ("b/../b/case.toml", "case-2", "Free particle"),
    ] {
        let output = run_in(folder.path(), &format!("run {case}"));
        assert!(succeeded(&output).contains(&format!("results/{at} (")), "{case}");
        assert_eq!(stderr(&output).contains("results/case holds results of a/case.toml"), at == "case-2", "{case}");
        assert_eq!(title(at).as_deref(), Some(expected));
    }
    // A study's results go beside the run's.
    let text = succeeded(&run_in(folder.path(), "converge b/case.toml --n-gamma 8,16"));
    assert!(text.contains("results/case-2/converge: "), "{text}");
    let map = "stability a/case.toml --methods rk4 --gamma-f 1 --delta-gamma 0.1";
    assert!(succeeded(&run_in(folder.path(), map)).contains("results/case/stability: "));
    assert_eq!(names(&results.join("case-2")), [&["case.toml", "converge"], &SET[1..]].concat());
    assert!(results.join("case-2/converge/slopes.csv").exists() && title("case-2").is_some());
    // A folder that is named holds one set: the last command's.
    succeeded(&run_in(folder.path(), "run a/case.toml --out out"));
    succeeded(&run_in(folder.path(), "converge a/case.toml --n-gamma 16,32 --out out"));
    assert_eq!(names(&folder.path().join("out")), ["convergence.csv", "slopes.csv", "summary.json"]);
}

/// A program that is killed while it puts its files in place leaves this.
#[test]
fn an_incomplete_set_is_cleared_away() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("out");
    succeeded(&run_in(folder.path(), "run CASES/quartic.toml --out out"));
    let record = fs::read_to_string(out.join(MANIFEST)).unwrap().replace("\"complete\"", "\"incomplete\"");
    fs::write(out.join(MANIFEST), &record).unwrap();
    // With its summary a set is whole: what ends without results leaves it there, and without a summary it does not.
    failed(&run_in(folder.path(), "converge CASES/quartic.toml --n-gamma 7 --out out"), 2);
    assert_eq!(names(&out), SET);
    fs::remove_file(out.join("summary.json")).unwrap();
    failed(&run_in(folder.path(), "converge CASES/quartic.toml --n-gamma 7 --out out"), 2);
    assert_eq!(names(&out), [""; 0]);
    fs::write(out.join(MANIFEST), &record).unwrap();
    fs::write(out.join("branches.csv"), "of nobody's").unwrap();
    fs::write(out.join(MANIFEST), record.replace("\"case.toml\"", "\"case.toml\", \"branches.csv\"")).unwrap();
    failed(&run_in(folder.path(), "run CASES/hard/horizon.toml --out out"), 4);
    assert_eq!(names(&out), ["case.toml", "summary.json"]);
    assert_eq!(json(&out.join(MANIFEST))["state"], "complete");
}

#[cfg(unix)]
#[test]
fn a_link_is_written_through() {
    let folder = TempDir::new().unwrap();
    let [out, elsewhere] = ["out", "elsewhere.csv"].map(|name| folder.path().join(name));
    fs::create_dir(&out).unwrap();
    fs::write(&elsewhere, "").unwrap();
    std::os::unix::fs::symlink(&elsewhere, out.join("trajectory.csv")).unwrap();
    for force in ["--force", ""] {
        succeeded(&run_in(folder.path(), &format!("run CASES/quartic.toml --out out {force}")));
        assert!(out.join("trajectory.csv").is_symlink());
        assert_eq!(fs::read_to_string(&elsewhere).unwrap().lines().count(), 33);
    }
}
