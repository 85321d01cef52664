//! A folder's files: the program replaces what it wrote, and nothing else.

use std::fs;

use crate::common::{CASES, Folder, MANIFEST, stderr, succeeded};

const SET: [&str; 4] = ["case.toml", "residuals.csv", "summary.json", "trajectory.csv"];

#[test]
fn files_of_a_user_are_neither_replaced_nor_removed() {
    let folder = Folder::new();
    let is_own = |name: &str| folder.read(&format!("out/{name}")) == "a user's own";
    // What a run does not write is left alone, also where another run would write or remove it.
    let own = ["branches.csv", "notes.txt", "samples.csv", "world_line.svg"];
    own.iter().for_each(|name| folder.write(&format!("out/{name}"), "a user's own"));
    folder.succeeds("run quartic --out out");
    folder.succeeds("run horizon-near --out out");
    folder.fails("run horizon --out out", 4);
    assert!(own.into_iter().all(is_own));
    assert_eq!(folder.names("out"), ["branches.csv", "case.toml", own[1], own[2], "summary.json", own[3]]);
    // What it does write is refused before anything is computed.
    let samples = "run quartic --sample-t 0:1:0.5 --out out";
    folder.refuses(&[(format!("{samples} --plot"), 1, "samples.csv, world_line.svg … --force")]);
    // By force it is replaced, and from then on the program's.
    folder.succeeds(&format!("{samples} --force"));
    assert!(!is_own("samples.csv") && is_own("world_line.svg"));
    folder.succeeds("run quartic --out out");
    assert!(!folder.has("out/samples.csv") && is_own("branches.csv") && is_own("notes.txt"));
}

#[test]
fn results_without_a_record_are_taken_for_a_users() {
    let folder = Folder::new();
    folder.succeeds("run quartic");
    let manifest = format!("results/quartic/{MANIFEST}");
    let record = folder.json(&manifest);
    assert_eq!((record["command"].as_str(), record["state"].as_str()), (Some("run"), Some("complete")));
    assert_eq!(record["files"].as_array().unwrap().len(), 4);
    fs::remove_file(folder.path(&manifest)).unwrap();
    let files = "trajectory.csv, residuals.csv, summary.json, case.toml … --out … --force";
    folder.refuses(&[("run quartic", 1, files)]);
    folder.succeeds("run quartic --force");
    // A record that is none, or that leads out of the folder, is not followed.
    folder.write("results/mine.txt", "mine");
    let outside = record.to_string().replace("\"case.toml\"", "\"../mine.txt\"");
    for (record, named) in [("{}", MANIFEST), (&*outside, "../mine.txt")] {
        folder.write(&manifest, record);
        folder.refuses(&[("run quartic", 1, named)]);
    }
}

#[test]
fn cases_and_commands_have_default_folders_of_their_own() {
    let folder = Folder::new();
    for (place, source) in [("a", "quartic"), ("b", "free")] {
        folder.write(&format!("{place}/case.toml"), fs::read(format!("{CASES}/{source}.toml")).unwrap());
    }
    // Each again and in any order: a case keeps its folder.
    for (case, at, title) in [
        ("a/case.toml", "case", "Quartic oscillator"),
        ("b/case.toml", "case-2", "Free particle"),
        ("a/case.toml", "case", "Quartic oscillator"),
        ("b/../b/case.toml", "case-2", "Free particle"),
    ] {
        let output = folder.run(&format!("run {case}"));
        assert!(succeeded(&output).contains(&format!("results/{at} (")), "{case}");
        assert_eq!(stderr(&output).contains("results/case holds results of a/case.toml"), at == "case-2", "{case}");
        assert_eq!(folder.summary(&format!("results/{at}"))["title"], title);
    }
    // A study's results go beside the run's.
    let text = folder.succeeds("converge b/case.toml --n-gamma 8,16");
    assert!(text.contains("results/case-2/converge: "), "{text}");
    let text = folder.succeeds("stability a/case.toml --methods rk4 --gamma-f 1 --delta-gamma 0.1");
    assert!(text.contains("results/case/stability: "), "{text}");
    assert_eq!(folder.names("results/case-2"), [&["case.toml", "converge"], &SET[1..]].concat());
    assert!(folder.has("results/case-2/converge/slopes.csv"));
    // A folder that is named holds one set: the last command's.
    folder.succeeds("run a/case.toml --out out");
    folder.succeeds("converge a/case.toml --n-gamma 16,32 --out out");
    assert_eq!(folder.names("out"), ["convergence.csv", "slopes.csv", "summary.json"]);
}

/// A program that is killed while it puts its files in place leaves this.
#[test]
fn an_incomplete_set_is_cleared_away() {
    let folder = Folder::new();
    let manifest = format!("out/{MANIFEST}");
    folder.succeeds("run quartic --out out");
    let record = folder.read(&manifest).replace("\"complete\"", "\"incomplete\"");
    folder.write(&manifest, &record);
    // With its summary a set is whole: what ends without results leaves it there, and without a summary it does not.
    folder.fails("converge quartic --n-gamma 7 --out out", 2);
    assert_eq!(folder.names("out"), SET);
    fs::remove_file(folder.path("out/summary.json")).unwrap();
    folder.fails("converge quartic --n-gamma 7 --out out", 2);
    assert_eq!(folder.names("out"), [""; 0]);
    folder.write("out/branches.csv", "of nobody's");
    folder.write(&manifest, record.replace("\"case.toml\"", "\"case.toml\", \"branches.csv\""));
    folder.fails("run horizon --out out", 4);
    assert_eq!(folder.names("out"), ["case.toml", "summary.json"]);
    assert_eq!(folder.json(&manifest)["state"], "complete");
}

#[cfg(unix)]
#[test]
fn a_link_is_written_through() {
    let folder = Folder::new();
    folder.write("elsewhere.csv", "");
    fs::create_dir(folder.path("out")).unwrap();
    std::os::unix::fs::symlink(folder.path("elsewhere.csv"), folder.path("out/trajectory.csv")).unwrap();
    for force in ["--force", ""] {
        folder.succeeds(&format!("run quartic --out out {force}"));
        assert!(folder.path("out/trajectory.csv").is_symlink());
        assert_eq!(folder.read("elsewhere.csv").lines().count(), 33);
    }
}

#[test]
fn names_of_dots_alone_have_a_folder_of_their_own() {
    let folder = Folder::new();
    for name in ["...toml", "..toml"] {
        folder.write(name, fs::read(format!("{CASES}/free.toml")).unwrap());
        assert!(folder.succeeds(&format!("run {name}")).contains(&format!("results/{name} (")));
        assert_eq!(folder.names(&format!("results/{name}")), SET);
    }
    assert_eq!(folder.names(""), ["...toml", "..toml", "results"]);
}

#[cfg(unix)]
#[test]
fn control_characters_of_names_are_shown_and_not_sent() {
    let folder = Folder::new();
    let untitled = fs::read_to_string(format!("{CASES}/free.toml")).unwrap().replace("title = ", "# title = ");
    folder.write("a\u{1b}[31m\u{9b}b.toml", untitled);
    folder.write("bad\u{7}.toml", "x = 1\n");
    for (line, code) in [
        ("run a\u{1b}[31m\u{9b}b.toml", 0),
        ("run a\u{1b}[31m\u{9b}b.toml --plot", 0),
        ("run a\u{1b}[31m\u{9b}b.toml --vary initial.x=0,1", 0),
        ("check bad\u{7}.toml", 2),
        ("check missing\u{7}.toml", 1),
        ("run free --sample-t @missing\u{7}.csv:t", 2),
        ("run free --out bad\u{7}.toml", 1),
    ] {
        let output = folder.run(line);
        assert_eq!(output.status.code(), Some(code), "{}", stderr(&output));
        let told = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
        assert!(!told.contains(|c: char| c.is_control() && c != '\n'), "{told:?}");
        assert!(code != 0 || told.contains("a\\u{1b}[31m\\u{9b}b"), "{told}");
    }
    assert!(folder.read("results/a\u{1b}[31m\u{9b}b/orbit.svg").contains("a\\u{1b}[31m\\u{9b}b"));
}

/// A file of a living program, which holds a lock on it, is left alone, as are those whose names are only similar.
#[test]
fn what_killed_programs_left_under_temporary_names_is_removed_by_the_next() {
    let folder = Folder::new();
    folder.succeeds("run quartic --out out --plot");
    let left = [".trajectory.csv.Ab3dE9", ".orbit.svg.000000", "..geodesic-ivp-manifest.json.zzzzzz"];
    let others = [".trajectory.csv.swp", ".notes.csv.Ab3dE9", "trajectory.csv.Ab3dE9", ".trajectory.csv.Ab3-E9"];
    left.iter().chain(&others).for_each(|name| folder.write(&format!("out/{name}"), "1"));
    folder.write("out/.residuals.csv.living", "1");
    let living = fs::File::open(folder.path("out/.residuals.csv.living")).unwrap();
    living.lock().unwrap();
    folder.succeeds("run quartic --out out");
    assert!(left.iter().all(|name| !folder.has(&format!("out/{name}"))), "{:?}", folder.names("out"));
    let stay = others.iter().chain(&[".residuals.csv.living"]);
    assert!(stay.clone().all(|name| folder.has(&format!("out/{name}"))), "{:?}", folder.names("out"));
    drop(living);
    folder.succeeds("run quartic --out out");
    assert!(!folder.has("out/.residuals.csv.living"));
}
