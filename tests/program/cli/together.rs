//! Programs that write into one folder at once, and programs that are killed: no mixture of two sets is ever left.
//!
//! `STRESS_ROUNDS=1000 cargo test --profile tests --test program together` does so for longer.

use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use crate::common::Folder;

fn rounds(otherwise: usize) -> usize {
    std::env::var("STRESS_ROUNDS").map_or(otherwise, |rounds| rounds.parse().unwrap())
}

/// Starts a run of so many nodes into the folder `out`.
fn start(folder: &Folder, n_gamma: usize, more: &str) -> Child {
    let mut run = folder.program(&format!("run quartic --out out --quiet --set grid.n_gamma={n_gamma} {more}"));
    run.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// The number of nodes of the set in `out`, all of whose files must agree about it, or None where it has no summary.
fn nodes(folder: &Folder) -> Option<u64> {
    let read = |name: &str| folder.has(&format!("out/{name}")).then(|| folder.read(&format!("out/{name}")));
    let tables = ["trajectory.csv", "residuals.csv", "branches.csv"].map(read);
    let rows = tables.iter().flatten().map(|text| text.lines().count() as u64 - 1);
    let of_case = |text: String| text.lines().find_map(|line| line.strip_prefix("n_gamma = ")?.parse().ok()).unwrap();
    let summary = read("summary.json").map(|_| folder.summary("out"));
    let said = summary.as_ref().map(|summary| summary["n_gamma"].as_u64().unwrap());
    let known: Vec<u64> = rows.chain(read("case.toml").map(of_case)).chain(said).collect();
    assert!(known.windows(2).all(|pair| pair[0] == pair[1]), "a mixture: {known:?} in {:?}", folder.names("out"));
    if let Some(summary) = summary {
        let whole = if summary["system"] == "doubled" { 5 } else { 4 };
        assert_eq!(known.len(), whole, "not whole: {:?}", folder.names("out"));
    }
    said
}

#[test]
fn two_programs_in_one_folder_leave_one_set() {
    let folder = Folder::new();
    let mut seen = [0, 0];
    for round in 0..rounds(25) {
        let doubled = if round % 2 == 0 { "--set solver.system=doubled" } else { "" };
        for mut program in [start(&folder, 60, ""), start(&folder, 50, doubled)] {
            assert_eq!(program.wait().unwrap().code(), Some(0));
        }
        let nodes = nodes(&folder).expect("a whole set");
        seen[usize::from(nodes == 60)] += 1;
        let files = if nodes == 50 && round % 2 == 0 { 5 } else { 4 };
        assert_eq!(folder.names("out").len(), files, "{:?}", folder.names("out"));
    }
    println!("the last was the one and the other: {seen:?}");
}

#[test]
fn a_killed_program_leaves_no_mixture() {
    let folder = Folder::new();
    let mut random = 20_231_107_u64;
    // Old set, new set, none: what a killed program left.
    let mut left = [0, 0, 0];
    let mut span = Duration::ZERO;
    for round in 0..rounds(60) {
        if nodes(&folder).is_none() {
            let begin = Instant::now();
            assert_eq!(start(&folder, 40, "").wait().unwrap().code(), Some(0));
            span = begin.elapsed();
        }
        let before = nodes(&folder).expect("a whole set");
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let share = (random >> 33) as f64 / f64::from(1_u32 << 31);
        let mut program = start(&folder, 50 + round % 7, "");
        std::thread::sleep(span.mul_f64(1.1 * share));
        program.kill().unwrap();
        if program.wait().unwrap().code().is_none() {
            left[nodes(&folder).map_or(2, |now| usize::from(now != before))] += 1;
        }
    }
    assert!(left[0] > 0, "{left:?}");
    println!("killed programs left the old set, the new one and none so many times: {left:?}");
    assert_eq!(start(&folder, 40, "").wait().unwrap().code(), Some(0));
    assert_eq!(nodes(&folder), Some(40));
    // A killed program may leave a nameless lock or a file that never got its name; no other file is left of it.
    let left: Vec<String> = folder.names("out").into_iter().filter(|name| !name.starts_with('.')).collect();
    assert_eq!(left, ["case.toml", "residuals.csv", "summary.json", "trajectory.csv"]);
}
