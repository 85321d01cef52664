//! The shipped cases are in the program and at hand in any folder.

use std::fs;

use geodesic_ivp::case::builtin::NAMES;
use tempfile::TempDir;

use crate::common::{CASES, case_file, failed, json, names, run_in, stderr, succeeded};

#[test]
fn init_writes_and_lists_the_shipped_cases() {
    let folder = TempDir::new().unwrap();
    let list = succeeded(&run_in(folder.path(), "init --list"));
    let mut headings = Vec::new();
    for line in list.lines().filter(|line| !line.is_empty()) {
        let Some(row) = line.strip_prefix("  ") else {
            headings.push(line);
            continue;
        };
        let name = row.split_whitespace().next().unwrap();
        let path = case_file(name);
        assert_eq!(path.contains("/scenes/"), headings.len() > 2, "{name}");
        assert_eq!(succeeded(&run_in(folder.path(), &format!("init {name}"))), fs::read_to_string(path).unwrap());
    }
    assert_eq!(headings.len(), 4, "each group in one piece: {headings:?}");
    assert!(names(folder.path()).is_empty(), "init writes to standard output");
}

#[test]
fn the_list_has_a_sentence_of_its_own_for_every_case() {
    let list = succeeded(&run_in(TempDir::new().unwrap().path(), "init --list"));
    let rows = || list.lines().filter_map(|line| line.strip_prefix("  ")?.split_once("  "));
    let mut sentences: Vec<&str> = rows().map(|(_, sentence)| sentence.trim()).collect();
    sentences.sort_unstable();
    let count = sentences.len();
    sentences.dedup();
    assert!(count == NAMES.len() && sentences.len() == count, "{list}");
    assert!(list.lines().all(|line| line.chars().count() <= 100), "{list}");
}

#[test]
fn a_built_in_case_stands_in_for_a_file_that_is_not_there() {
    let folder = TempDir::new().unwrap();
    let output = run_in(folder.path(), "run quartic --out built-in");
    succeeded(&output);
    assert!(!stderr(&output).contains("note:"), "{}", stderr(&output));
    succeeded(&run_in(folder.path(), "run CASES/quartic.toml --out file"));
    let of = |out: &str| fs::read(folder.path().join(out).join("trajectory.csv")).unwrap();
    assert_eq!(of("built-in"), of("file"));
    assert!(succeeded(&run_in(folder.path(), "run quartic --set grid.n_gamma=8")).contains("results/quartic"));
    // A file of that path wins, and a folder does not.
    fs::copy(format!("{CASES}/free.toml"), folder.path().join("quartic")).unwrap();
    let output = run_in(folder.path(), "run quartic --out own");
    succeeded(&output);
    assert!(!stderr(&output).contains("note:"));
    assert_eq!(json(&folder.path().join("own/summary.json"))["title"], "Free particle");
    fs::create_dir(folder.path().join("linear")).unwrap();
    assert!(succeeded(&run_in(folder.path(), "check --run linear")).contains("Linear potential"));
}

#[test]
fn a_hard_case_is_found_by_its_bare_name() {
    let folder = TempDir::new().unwrap();
    succeeded(&run_in(folder.path(), "run horizon-near --quiet"));
    assert_eq!(json(&folder.path().join("results/horizon-near/summary.json"))["title"], "A horizon approached to 1e-6");
}

#[test]
fn a_scene_is_found_by_its_name() {
    let folder = TempDir::new().unwrap();
    let output = run_in(folder.path(), "run kepler");
    assert!(succeeded(&output).starts_with("Kepler's ellipse in Newton's law"));
    assert_eq!(json(&folder.path().join("results/kepler/summary.json"))["ignorable"], serde_json::json!(["t", "s"]));
}

#[test]
fn gamma_at_the_end_of_a_scene_may_be_expected() {
    let folder = TempDir::new().unwrap();
    // The fall ends at r = 1, at the proper time that the cycloid gives.
    let check = |gamma: &str| {
        let set = format!("--set expect.gamma_final={gamma} --set expect.tolerance=1e-10");
        run_in(folder.path(), &format!("check schwarzschild-plunge --run {set}"))
    };
    let output = check("34.76593");
    assert!(failed(&output, 5).contains("gamma_final = 34.637"), "{}", stderr(&output));
    let eta = (-0.8_f64).acos();
    let met = succeeded(&check(&(125.0_f64.sqrt() * (eta + eta.sin())).to_string()));
    assert!(met.contains("gamma_final = 34.637") && met.contains("r_final = "), "{met}");
}

#[test]
fn studies_need_no_case() {
    let folder = TempDir::new().unwrap();
    for (arguments, table) in [
        ("work-precision --methods rk4 --longest 1e-3 --out work", "work/work_precision.csv"),
        ("stability --methods rk4 --gamma-f 1 --delta-gamma 0.1 --out map", "map/stability.csv"),
    ] {
        let output = run_in(folder.path(), arguments);
        assert!(succeeded(&output).starts_with("Quartic oscillator"), "{arguments}");
        assert!(stderr(&output).contains("no CASE is given: the built-in case 'quartic' is used"), "{arguments}");
        assert!(folder.path().join(table).exists(), "{arguments}");
    }
}
