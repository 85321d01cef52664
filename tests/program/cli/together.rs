//! Programs that write into one folder at once, and programs that are killed: no mixture of two sets is ever left.
//!
//! `STRESS_ROUNDS=1000 cargo test --release --test program together` does so for longer.

use std::fs;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::common::{CASES, json, names, program};

fn rounds(otherwise: usize) -> usize {
    std::env::var("STRESS_ROUNDS").map_or(otherwise, |rounds| rounds.parse().unwrap())
}

/// Starts a run of so many nodes into the folder `out`.
fn start(folder: &Path, n_gamma: usize, more: &[&str]) -> Child {
    program(folder)
        .args(["run", &format!("{CASES}/quartic.toml"), "--out", "out", "--quiet", "--set"])
        .arg(format!("grid.n_gamma={n_gamma}"))
        .args(more)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// The number of nodes of the set in `out`, all of whose files must agree about it, or None where it has no summary.
fn nodes(out: &Path) -> Option<u64> {
    let rows = |name: &str| Some(fs::read_to_string(out.join(name)).ok()?.lines().count() as u64 - 1);
    let tables = [rows("trajectory.csv"), rows("residuals.csv"), rows("branches.csv")];
    let case = fs::read_to_string(out.join("case.toml"))
        .ok()
        .map(|text| text.lines().find_map(|line| line.strip_prefix("n_gamma = ")).unwrap().parse::<u64>().unwrap());
    let summary = out.join("summary.json").exists().then(|| json(&out.join("summary.json")));
    let said = summary.as_ref().map(|summary| summary["n_gamma"].as_u64().unwrap());
    let known: Vec<u64> = tables.into_iter().chain([case, said]).flatten().collect();
    assert!(known.windows(2).all(|pair| pair[0] == pair[1]), "a mixture: {known:?} in {:?}", names(out));
    if let Some(summary) = summary {
        let doubled = summary["system"] == "doubled";
        assert_eq!(known.len(), if doubled { 5 } else { 4 }, "not whole: {:?}", names(out));
    }
    said
}

#[test]
fn two_programs_in_one_folder_leave_one_set() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("out");
    let mut seen = [0, 0];
    for round in 0..rounds(25) {
        let doubled: &[&str] = if round % 2 == 0 { &["--set", "solver.system=doubled"] } else { &[] };
        let programs = [start(folder.path(), 60, &[]), start(folder.path(), 50, doubled)];
        for mut program in programs {
            assert_eq!(program.wait().unwrap().code(), Some(0));
        }
        let nodes = nodes(&out).expect("a whole set");
        seen[usize::from(nodes == 60)] += 1;
        let files = if nodes == 50 && round % 2 == 0 { 5 } else { 4 };
        assert_eq!(names(&out).len(), files, "{:?}", names(&out));
    }
    println!("the last was the one and the other: {seen:?}");
}

#[test]
fn a_killed_program_leaves_no_mixture() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("out");
    let mut random = 20_231_107_u64;
    // Old set, new set, none: what a killed program left.
    let mut left = [0, 0, 0];
    let mut span = Duration::ZERO;
    for round in 0..rounds(60) {
        if nodes(&out).is_none() {
            let begin = Instant::now();
            assert_eq!(start(folder.path(), 40, &[]).wait().unwrap().code(), Some(0));
            span = begin.elapsed();
        }
        let before = nodes(&out).expect("a whole set");
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let share = (random >> 33) as f64 / f64::from(1_u32 << 31);
        let mut program = start(folder.path(), 50 + round % 7, &[]);
        std::thread::sleep(span.mul_f64(1.1 * share));
        program.kill().unwrap();
        if program.wait().unwrap().code().is_none() {
            left[nodes(&out).map_or(2, |now| usize::from(now != before))] += 1;
        }
    }
    assert!(left[0] > 0, "{left:?}");
    println!("killed programs left the old set, the new one and none so many times: {left:?}");
    assert_eq!(start(folder.path(), 40, &[]).wait().unwrap().code(), Some(0));
    assert_eq!(nodes(&out), Some(40));
    // A killed program may leave a nameless lock or a file that never got its name; no other file is left of it.
    let left: Vec<String> = names(&out).into_iter().filter(|name| !name.starts_with('.')).collect();
    assert_eq!(left, ["case.toml", "residuals.csv", "summary.json", "trajectory.csv"]);
}
