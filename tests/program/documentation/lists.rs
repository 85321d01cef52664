//! Lists that must have what the program has: keys of a case, columns of tables, keys of a summary.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use geodesic_ivp::case::builtin::{self, Group};
use geodesic_ivp::case::{KEYS, SCENE_KEYS};
use geodesic_ivp::geometry::PRESETS;
use geodesic_ivp::methods::PEERS;
use tempfile::TempDir;

use super::pages::Page;
use crate::common::{ROOT, program};

/// Returns what the program says that it knows where it is told something else.
fn known(directory: &Path, setting: &str) -> Vec<String> {
    let output = program(directory).args(["check", "quartic", "--quiet", "--set", setting]).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    let line = error.lines().find(|line| line.starts_with("error: ")).unwrap_or_else(|| panic!("{setting}: {error}"));
    match (line.split_once("available keys: "), line.split_once("expected ").or(line.split_once("the only key is "))) {
        (Some((_, list)), _) => list.split(", ").map(str::to_owned).collect(),
        (None, Some((_, list))) => list.split('`').skip(1).step_by(2).map(str::to_owned).collect(),
        _ => panic!("{setting}: {error}"),
    }
}

/// Every key of a case of the paper, dotted: what the program knows and the list of keys of scenes does not have.
/// Tables other than that of a potential's kind are no keys of their own.
pub(crate) fn keys() -> BTreeSet<String> {
    let folder = TempDir::new().unwrap();
    let known = |setting: &str| known(folder.path(), setting);
    let mut keys = BTreeSet::new();
    for top in known("unknown=1") {
        match top.as_str() {
            "title" => drop(keys.insert(top)),
            "metric" | "body" | "pair" | "force" | "invariants" | "events" | "plot" | "tables" => {}
            "potential" => {
                for kind in known("potential={unknown={}}").into_iter().filter(|kind| !is_of_scenes("potential", kind))
                {
                    if kind != "free" {
                        let inner = known(&format!("potential={{{kind}={{unknown=1}}}}"));
                        keys.extend(inner.into_iter().map(|key| format!("potential.{kind}.{key}")));
                    }
                    keys.insert(format!("potential.{kind}"));
                }
            }
            table => {
                let known = known(&format!("{table}.unknown=1")).into_iter().filter(|key| !is_of_scenes(table, key));
                keys.extend(known.map(|key| format!("{table}.{key}")));
            }
        }
    }
    keys
}

/// Returns true if a key is one that scenes have besides.
fn is_of_scenes(table: &str, key: &str) -> bool {
    let dotted = format!("{table}.{key}");
    let general = key.strip_prefix("p_").map_or(dotted.clone(), |_| format!("{table}.p_q"));
    let is = |names: &str| names.split(", ").any(|name| name == dotted || name == general);
    KEYS.iter().all(|key| key.name != dotted) && SCENE_KEYS.iter().any(|(names, _)| is(names))
}

/// The rows of the page's table of keys that are for scenes only, or those that are not: the last column says so.
fn rows_of_keys(of_scenes: bool) -> Vec<Vec<String>> {
    let is_key = |cell: &str| cell == "title" || (cell.contains('.') && !cell.contains(' ') || cell.contains(", "));
    let is_row = |row: &Vec<String>| row.len() == 5 && is_key(&row[0]) && (row[4] == "scenes") == of_scenes;
    Page::named("docs/cases.md").rows().filter(is_row).collect()
}

#[test]
fn the_page_of_cases_has_every_key_and_no_other() {
    let listed: Vec<Vec<String>> = rows_of_keys(false).into_iter().map(|row| row[..4].to_vec()).collect();
    assert_eq!(listed.iter().map(|row| row[0].clone()).collect::<BTreeSet<_>>(), keys());
    // The manual page has them in the same words.
    let known = KEYS.iter().map(|key| [key.name, key.kind, key.default, key.meaning].map(str::to_owned).to_vec());
    assert_eq!(listed, known.collect::<Vec<_>>());
}

#[test]
fn the_page_of_cases_has_the_keys_of_scenes_in_the_words_of_the_manual_page() {
    let listed: Vec<_> = rows_of_keys(true).into_iter().map(|row| vec![row[0].clone(), row[3].clone()]).collect();
    let known = SCENE_KEYS.iter().map(|&(name, meaning)| vec![name.to_owned(), meaning.to_owned()]);
    assert_eq!(listed, known.collect::<Vec<_>>());
}

#[test]
fn the_index_of_cases_has_every_one_once_and_below_its_group() {
    let headings = [
        (Group::Paper, "## The paper's"),
        (Group::Basic, "## Basic ones"),
        (Group::Hard, "## Hard ones"),
        (Group::Newtonian, "## Scenes"),
    ];
    let (mut listed, mut group) = (Vec::new(), None);
    for line in Page::named("cases/README.md").lines() {
        group = headings.iter().find(|(_, heading)| *heading == line).map(|(group, _)| *group).or(group);
        for name in line.split("[`").skip(1).filter_map(|rest| rest.split_once("`](")).map(|(name, _)| name) {
            let is_scene = |group: Option<Group>| group.is_some_and(Group::is_scene);
            let own = builtin::group(name);
            assert!(own == group || is_scene(own) && is_scene(group), "{name} is in {own:?}");
            listed.push(name.to_owned());
        }
    }
    listed.sort();
    let mut names = builtin::NAMES.to_vec();
    names.sort();
    assert_eq!(listed, names);
}

#[test]
fn the_list_of_statuses_is_complete() {
    let folder = TempDir::new().unwrap();
    let page = Page::named("docs/results.md");
    let (exits, all) = (["0", "3", "4"], known(folder.path(), "expect.status=unknown"));
    let listed = page.rows().filter(|row| row.len() == 3 && exits.contains(&row[2].as_str())).map(|row| row[0].clone());
    assert_eq!(listed.collect::<BTreeSet<_>>(), all.into_iter().collect());
}

/// A folder with what commands write that cost little.
pub(crate) fn results() -> TempDir {
    let folder = TempDir::new().unwrap();
    for command in [
        "run quartic --set solver.system=doubled --sample-gamma 0:1:0.5 --plot",
        "converge quartic --n-gamma 16,32",
        "work-precision quartic --methods RK4 --longest 0.001",
        "stability quartic --methods RK4 --gamma-f 1 --delta-gamma 0.1",
    ] {
        let output =
            program(folder.path()).args(command.split(' ')).args(["--quiet", "--out", "all"]).output().unwrap();
        assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
        let from = folder.path().join("all");
        fs::rename(&from, folder.path().join(command.split(' ').next().unwrap())).unwrap();
    }
    folder
}

/// Returns the columns that a row of the page's table stands for in a case: one with … is there once for each of the
/// names that its place in angle brackets stands for, and two columns with "and" between them alternate.
fn expanded(columns: &str, names: &[(&str, &[&str])]) -> Vec<String> {
    let mut all = Vec::new();
    for column in columns.split(", ") {
        let Some(repeated) = column.strip_suffix(" …") else {
            all.push(column.to_owned());
            continue;
        };
        let (place, of_place) = names.iter().find(|(place, _)| repeated.contains(place)).unwrap();
        for name in *of_place {
            all.extend(repeated.split(" and ").map(|column| column.replace(place, name)));
        }
    }
    all
}

#[test]
fn columns_are_expanded() {
    let names = [("<q>", &["t", "x"][..]), ("<c>", &["t"]), ("<name>", &[])];
    let columns = expanded("gamma, <q> …, p_<c> and p_<c>_corrected …, delta_<q> …, delta_<name> …, end", &names);
    assert_eq!(columns.join(","), "gamma,t,x,p_t,p_t_corrected,delta_t,delta_x,end");
}

#[test]
fn columns_keys_and_files_are_those_that_the_page_lists() {
    let page = Page::named("docs/results.md");
    let rows: Vec<Vec<String>> = page.rows().collect();
    let folder = results();
    let mut tables = BTreeSet::new();
    for command in fs::read_dir(folder.path()).unwrap() {
        let command = command.unwrap();
        for file in fs::read_dir(command.path()).unwrap() {
            let file = file.unwrap();
            let name = file.file_name().into_string().unwrap();
            if name.starts_with('.') {
                continue;
            }
            let (command, text) =
                (command.file_name().into_string().unwrap(), fs::read_to_string(file.path()).unwrap());
            let mentioned =
                |row: &&Vec<String>| row[0].starts_with(&command) && row.iter().any(|cell| cell.contains(&name));
            assert!(rows.iter().any(|row| mentioned(&row)), "{command} writes {name}, which its rows do not name");
            if name.ends_with(".csv") {
                let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
                let of_x = [("<q>", &["t", "x"][..]), ("<c>", &["t"]), ("<name>", &[])];
                let mut rows = rows.iter().filter(|row| row.len() == 2 && row[0] == name);
                assert!(rows.any(|row| expanded(&row[1], &of_x) == header), "{name} has {header:?}");
                tables.insert(name);
            }
        }
    }
    assert_eq!(tables.len(), 9, "{tables:?}");
    let summary: serde_json::Map<String, serde_json::Value> =
        serde_json::from_str(&fs::read_to_string(folder.path().join("run/summary.json")).unwrap()).unwrap();
    let listed: BTreeSet<&str> = rows.iter().flat_map(|row| row[0].split(", ")).collect();
    let missing: Vec<&String> = summary.keys().filter(|key| !listed.contains(key.as_str())).collect();
    assert!(missing.is_empty(), "keys of summary.json that docs/results.md does not have: {missing:?}");
}

#[test]
fn columns_and_keys_of_scenes_are_those_that_the_page_lists() {
    let page = Page::named("docs/results.md");
    let rows: Vec<Vec<String>> = page.rows().collect();
    let listed: BTreeSet<&str> = rows.iter().flat_map(|row| row[0].split(", ")).collect();
    let folder = TempDir::new().unwrap();
    let manual = program(folder.path()).arg("man").output().unwrap().stdout;
    let manual = String::from_utf8(manual).unwrap().replace('\\', "");
    // In one window, so that there is no column window: a charge and an invariant; a coordinate that conformal adds; a
    // force; a sum and the other system.
    for (scene, names, ignorable, invariants) in [
        ("kerr-inclined", &["t", "r", "theta", "phi"][..], &["t", "phi"][..], &["carter"][..]),
        ("kerr-mino", &["t", "r", "theta", "phi", "tau"], &["t", "phi", "tau"], &["carter"]),
        ("damped-oscillator", &["t", "x", "s"], &["s"], &[]),
        ("two-bodies", &["t", "x1", "x2"], &["t"], &[]),
    ] {
        let mut command = program(folder.path());
        command.args(["run", scene, "--quiet", "--out", scene, "--set", "grid.windows=1", "--set", "grid.gamma_f=1"]);
        command.args(["--plot", "--sample-gamma", "0:1:0.5"]);
        if scene == "two-bodies" {
            command.args(["--set", "solver.system=doubled"]);
        }
        assert!(command.status().unwrap().success(), "{scene}");
        let text = |file: &str| fs::read_to_string(folder.path().join(scene).join(file)).unwrap();
        let summary: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&text("summary.json")).unwrap();
        let missing: Vec<&String> = summary.keys().filter(|key| !listed.contains(key.as_str())).collect();
        assert!(missing.is_empty(), "{scene}: keys that docs/results.md does not have: {missing:?}");
        let header = |file: &str| text(file).lines().next().unwrap().to_owned();
        let of_case = [("<q>", names), ("<c>", ignorable), ("<name>", invariants)];
        let listed_columns = |file: &str| {
            let row = rows.iter().find(|row| row.len() == 2 && row[0] == file).unwrap_or_else(|| panic!("{file}"));
            expanded(&row[1], &of_case).join(",")
        };
        let all = |suffix: &str| names.iter().map(|name| format!("{name}{suffix}")).collect::<Vec<_>>();
        let gamma = || vec!["gamma".to_owned()];
        assert_eq!(header("trajectory.csv"), [gamma(), all(""), all("_dot")].concat().join(","));
        let charges = ignorable.iter().flat_map(|q| [format!("delta_q_{q}"), format!("delta_q_{q}_corrected")]);
        // A lift has s as its last coordinate.
        let k = if names.last() == Some(&"s") { "delta_energy" } else { "delta_k" };
        let residuals = names.iter().map(|q| format!("delta_g_{q}")).chain([k.to_owned()]);
        let residuals = residuals.chain(invariants.iter().map(|name| format!("delta_{name}")));
        assert_eq!(
            header("residuals.csv"),
            gamma().into_iter().chain(charges).chain(residuals).collect::<Vec<_>>().join(",")
        );
        for file in ["trajectory.csv", "residuals.csv", "samples.csv"] {
            assert_eq!(header(file).replace(",delta_energy", ",delta_k"), listed_columns(file), "{scene}");
        }
        let state = [gamma(), all(""), all("_dot")].concat().join(",");
        assert_eq!(header("samples.csv"), state);
        if scene == "kerr-inclined" {
            assert_eq!(header("events.csv"), format!("event,{state}"));
            assert_eq!(header("events.csv"), listed_columns("events.csv"));
        }
        let files = fs::read_dir(folder.path().join(scene)).unwrap();
        for name in files.map(|file| file.unwrap().file_name().into_string().unwrap()) {
            let mentioned =
                |row: &Vec<String>| row[0].starts_with("run") && row.iter().any(|cell| cell.contains(&name));
            assert!(name.starts_with('.') || rows.iter().any(mentioned), "{scene}: {name}");
            assert!(name.ends_with(".lock") || manual.contains(&name), "the manual page does not name {name}");
        }
        if scene == "two-bodies" {
            assert_eq!(header("branches.csv"), [gamma(), all("_1"), all("_2")].concat().join(","));
        }
    }
}

#[test]
fn the_guide_has_every_column_of_many_runs() {
    let page = Page::named("docs/guide.md");
    let rows: Vec<Vec<String>> = page.rows().filter(|row| row.len() == 2).collect();
    let listed: BTreeSet<&str> = rows.iter().flat_map(|row| row[0].split(", ")).collect();
    let files: Vec<Vec<String>> = Page::named("docs/results.md").rows().collect();
    let folder = TempDir::new().unwrap();
    for (case, more, coordinates, invariants) in [
        ("quartic", "", &["t", "x"][..], &[][..]),
        ("kepler", "solver.accuracy=1e-6", &["t", "x", "y", "s"], &["angular_momentum"]),
        ("schwarzschild-orbit", "grid.gamma_f=1.0", &["t", "r", "phi"], &[]),
    ] {
        let mut command = program(folder.path());
        command.args(["run", case, "--quiet", "--out", case, "--vary", "grid.gamma_i=0.0"]);
        if !more.is_empty() {
            command.args(["--set", more]);
        }
        assert!(command.status().unwrap().success());
        let header = fs::read_to_string(folder.path().join(case).join("runs.csv")).unwrap();
        for column in header.lines().next().unwrap().split(',').filter(|column| *column != "grid.gamma_i") {
            let q = coordinates.iter().find(|q| [q.to_string(), format!("{q}_dot")].contains(&column.to_owned()));
            let of_charge = |q: &&str| column.replace(&format!("delta_q_{q}_"), "delta_q_NAME_");
            let general = coordinates.iter().map(of_charge).find(|name| name != column);
            let invariant = invariants.iter().any(|name| column == format!("max_abs_delta_{name}"));
            let name = match (q, general) {
                (Some(q), _) => column.replacen(q, "q", 1),
                (None, Some(general)) => general,
                (None, None) if invariant => "max_abs_delta_NAME".to_owned(),
                (None, None) => column.to_owned(),
            };
            assert!(listed.contains(name.as_str()), "{case}: {column}");
        }
        for file in fs::read_dir(folder.path().join(case)).unwrap() {
            let file = file.unwrap().file_name().into_string().unwrap();
            let is_named = files.iter().any(|row| row[0].starts_with("run CASE --vary") && row[2].contains(&file));
            assert!(file.starts_with('.') || is_named, "{file}");
        }
    }
}

#[test]
fn the_page_of_cases_has_every_preset() {
    let rows: Vec<Vec<String>> = Page::named("docs/cases.md").rows().collect();
    let first = rows.iter().position(|row| row[0] == "preset").unwrap() + 2;
    let listed = rows[first..].iter().take(PRESETS.len()).map(|row| (row[0].clone(), row[1].clone()));
    let known = PRESETS.iter().map(|preset| (preset.name.to_owned(), preset.text().coordinates.join(", ")));
    assert_eq!(listed.collect::<Vec<_>>(), known.collect::<Vec<_>>());
    assert!(rows.get(first + PRESETS.len()).is_none_or(|row| row.len() != rows[first].len()), "a preset too many");
    for preset in PRESETS {
        let row = &rows[first..][PRESETS.iter().position(|other| other.name == preset.name).unwrap()];
        for parameter in preset.parameters() {
            let is_named = row[2].split(|c: char| !c.is_alphanumeric()).any(|word| word == parameter);
            assert!(is_named, "{}: {parameter}", preset.name);
        }
    }
}

#[test]
fn the_page_of_the_method_lists_every_other_method_with_its_source() {
    let rows: Vec<Vec<String>> = Page::named("docs/method.md").rows().collect();
    let first = rows.iter().position(|row| row[0] == "method").unwrap() + 2;
    let known = PEERS.iter().map(|peer| {
        let about = peer.about();
        let order = about.order.map_or_else(|| "any".to_owned(), |order| order.to_string());
        vec![about.name, order, format!("{:?}", about.step).to_lowercase(), about.source.to_owned()]
    });
    assert_eq!(rows[first..first + PEERS.len()], known.collect::<Vec<_>>());
}

#[test]
fn the_version_is_the_same_everywhere() {
    let text = |name: &str| fs::read_to_string(Path::new(ROOT).join(name)).unwrap();
    let (changelog, citation) = (text("CHANGELOG.md"), text("CITATION.cff"));
    // The newest released section: "## [VERSION] - DATE".
    let newest = changelog.lines().find(|line| line.starts_with("## [") && *line != "## [Unreleased]").unwrap();
    let (version, date) = newest.strip_prefix("## [").unwrap().split_once("] - ").unwrap();
    assert_eq!(version, env!("CARGO_PKG_VERSION"));
    let has = |line: &str| citation.lines().any(|one| one == line);
    assert!(has(&format!("version: {version}")) && has(&format!("date-released: {date}")), "{citation}");
}
