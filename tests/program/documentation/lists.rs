//! Lists that must have what the program has: keys of a case, columns of tables, keys of a summary.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use geodesic_ivp::case::{Cases, KEYS, Key};
use geodesic_ivp::geometry::PRESETS;
use geodesic_ivp::methods::PEERS;

use super::manual::{page, section};
use super::pages::Page;
use crate::common::{Folder, MANIFEST, ROOT};

/// Returns what the program says that it knows where it is told something else.
fn known(setting: &str) -> Vec<String> {
    let error = Folder::new().fails(&format!("check quartic --quiet --set {setting}"), 2);
    let line = error.lines().find(|line| line.starts_with("error: ")).unwrap_or_else(|| panic!("{setting}: {error}"));
    match (line.split_once("available keys: "), line.split_once("expected ").or(line.split_once("the only key is "))) {
        (Some((_, list)), _) => list.split(", ").map(str::to_owned).collect(),
        (None, Some((_, list))) => list.split('`').skip(1).step_by(2).map(str::to_owned).collect(),
        _ => panic!("{setting}: {error}"),
    }
}

/// `TRANSCRIPTS=overwrite` writes the list anew.
#[test]
fn the_page_of_cases_lists_the_keys_of_the_table() {
    let code = |text: &str| format!("`{text}`");
    let row = |key: &Key| {
        let default = match key.default {
            "" | "none" => key.default.to_owned(),
            needed if key.is_required() => needed.to_owned(),
            default => code(default),
        };
        let cases = match key.cases {
            Cases::All => "all",
            Cases::OfX => "of x",
            Cases::Scenes | Cases::MakesScene => "scenes",
        };
        let cells = [code(key.name), key.takes(), default, key.meaning.to_owned(), cases.to_owned()];
        format!("| {} |\n", cells.join(" | ")).replace("|  |", "| |")
    };
    let list: String = KEYS.iter().map(row).collect();
    let path = Path::new(ROOT).join("docs/cases.md");
    let page = fs::read_to_string(&path).unwrap();
    let (before, rest) = page.split_once("|---|---|---|---|---|\n").unwrap();
    let (listed, behind) = rest.split_once("\n\n").unwrap();
    if std::env::var("TRANSCRIPTS").is_ok_and(|what| what == "overwrite") {
        fs::write(&path, format!("{before}|---|---|---|---|---|\n{list}\n{behind}")).unwrap();
    }
    assert_eq!(format!("{listed}\n"), list);
}

#[test]
fn the_list_of_statuses_is_complete() {
    let page = Page::named("docs/results.md");
    let is_status = |row: &Vec<String>| row.len() == 3 && ["0", "3", "4"].contains(&row[2].as_str());
    let listed = page.rows().filter(is_status).map(|row| row[0].clone());
    assert_eq!(listed.collect::<BTreeSet<_>>(), known("expect.status=unknown").into_iter().collect());
}

/// The names in the first column of these rows.
fn firsts(rows: &[Vec<String>]) -> BTreeSet<&str> {
    rows.iter().flat_map(|row| row[0].split(", ")).collect()
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

/// There are a case of x and a scene in all commands, and runs of scenes in one window, so that there is no column
/// window: a charge and an invariant; a coordinate that conformal adds; a force; a sum and the other system.
#[test]
fn columns_keys_and_files_are_those_that_the_pages_list() {
    let run = "--plot --sample-gamma 0:1:0.5 --set grid.windows=1 --set grid.gamma_f=1";
    let adaptive = "--plot --sample-gamma 0:1:0.5 --set solver.accuracy=1e-6 --set grid.gamma_f=1";
    let (rows, manual) = (Page::named("docs/results.md").rows().collect::<Vec<_>>(), page());
    let (listed, files) = (firsts(&rows), section(&manual, "FILES"));
    let (folder, mut tables) = (Folder::new(), BTreeSet::new());
    for (command, names, ignorable, invariants) in [
        (&*format!("run quartic {run} --set solver.system=doubled"), &["t", "x"][..], &["t"][..], &[][..]),
        ("converge quartic --n-gamma 16,32", &["t", "x"], &["t"], &[]),
        ("work-precision quartic --methods RK4 --longest 0.001", &["t", "x"], &["t"], &[]),
        ("stability quartic --methods RK4 --gamma-f 1 --delta-gamma 0.1", &["t", "x"], &["t"], &[]),
        (
            "converge henon-heiles --n-gamma 32,64 --set grid.gamma_f=1 --set grid.windows=1",
            &["t", "x", "y", "s"],
            &["t", "s"],
            &[],
        ),
        ("work-precision fish-eye --methods RK4 --longest 0.001", &["x", "y"], &[], &[]),
        ("stability henon-heiles --methods RK4 --gamma-f 1 --delta-gamma 0.1", &["t", "x", "y", "s"], &["t", "s"], &[]),
        (&*format!("run kerr-inclined {run}"), &["t", "r", "theta", "phi"], &["t", "phi"], &["carter"]),
        (&*format!("run kerr-mino {run}"), &["t", "r", "theta", "phi", "tau"], &["t", "phi", "tau"], &["carter"]),
        (&*format!("run kerr-inclined {adaptive}"), &["t", "r", "theta", "phi"], &["t", "phi"], &["carter"]),
        (&*format!("run damped-oscillator {run}"), &["t", "x", "s"], &["s"], &[]),
        (&*format!("run two-bodies {run} --set solver.system=doubled"), &["t", "x1", "x2"], &["t"], &[]),
        ("find lambert", &["t", "x", "y", "s"], &["t", "s"], &[]),
        ("find spring-fit", &["t", "x", "s"], &["s"], &[]),
    ] {
        let first = command.split(' ').next().unwrap();
        folder.succeeds(&format!("{command} --quiet --out out --force"));
        for name in folder.names("out").into_iter().filter(|name| !name.starts_with('.')) {
            let is_of = |row: &Vec<String>| row[0].starts_with(first) || row[0] == "all of these";
            let is_named = |row: &Vec<String>| is_of(row) && row.iter().any(|cell| cell.contains(&name));
            assert!(rows.iter().any(is_named), "{command} writes {name}, which its rows do not name");
            assert!(files.contains(&name), "{name} is not in\n{files}");
            // Tables of the run that was found are those of `run`; find.csv of a fit has no residuals.
            let is_other = first == "find" && !["find.csv", "fit.csv"].contains(&&*name);
            let is_of_fit = name == "find.csv" && command != "find lambert";
            if name.ends_with(".csv") && !is_other && !is_of_fit {
                // A lift has s as its last coordinate, and the energy in the place of K.
                let (header, is_lifted) = (folder.first_line(&format!("out/{name}")), names.contains(&"s"));
                let has_energy = is_lifted && ["residuals.csv", "stability.csv"].contains(&name.as_str());
                assert_eq!(header.contains(",delta_energy"), has_energy, "{header}");
                let header = header.replace(",delta_energy_max", ",in Newton's law delta_energy_max");
                let header = if name == "residuals.csv" { header.replace(",delta_energy", ",delta_k") } else { header };
                let unknowns: &[&str] = &["initial.x_dot", "initial.y_dot"];
                let of_search = [("<unknown>", unknowns), ("<k>", &["1", "2"])];
                let places = [("<q>", names), ("<c>", ignorable), ("<name>", invariants)];
                let places = [&places[..], &of_search].concat();
                let is_header = |row: &Vec<String>| expanded(&row[1], &places).join(",") == header;
                const PROVED: &str = " of a run that is proved";
                let kinds = ["", " of a scene", " of the strong form", " to an accuracy or with a tolerance", PROVED]
                    .map(|kind| format!("{name}{kind}"));
                let mut of_table = rows.iter().filter(|row| row.len() == 2 && kinds.contains(&row[0]));
                assert!(of_table.any(is_header), "{command}: {name} has {header}");
                tables.insert(name);
            }
        }
        let summary = folder.summary("out");
        let mut keys = summary.as_object().unwrap().keys();
        let missing = keys.find(|key| ["run", "find"].contains(&first) && !listed.contains(key.as_str()));
        assert_eq!(missing, None, "{command} has a key that docs/results.md does not have");
    }
    assert!(tables.len() == 12 && files.contains(MANIFEST), "{tables:?}");
}

#[test]
fn the_guide_has_every_column_of_many_runs() {
    let guide: Vec<Vec<String>> = Page::named("docs/guide.md").rows().filter(|row| row.len() == 2).collect();
    let files: Vec<Vec<String>> = Page::named("docs/results.md").rows().collect();
    let (listed, folder) = (firsts(&guide), Folder::new());
    for (case, coordinates, invariants) in [
        ("quartic", &["t", "x"][..], &[][..]),
        ("kepler --set solver.accuracy=1e-6", &["t", "x", "y", "s"], &["angular_momentum"]),
        ("schwarzschild-orbit --set grid.gamma_f=1.0", &["t", "r", "phi"], &[]),
    ] {
        folder.succeeds(&format!("run {case} --quiet --out out --force --vary grid.gamma_i=0.0 --sample-gamma 0"));
        for column in folder.table("out/runs.csv").columns.iter().filter(|column| *column != "grid.gamma_i") {
            // The guide has q in place of a coordinate, and NAME of one that has a charge and of an invariant.
            let mut name = column.clone();
            for q in coordinates.iter().filter(|q| column == *q || *column == format!("{q}_dot")) {
                name = column.replacen(q, "q", 1);
            }
            for q in coordinates {
                name = name.replace(&format!("delta_q_{q}_"), "delta_q_NAME_");
            }
            if invariants.iter().any(|invariant| *column == format!("max_abs_delta_{invariant}")) {
                name = "max_abs_delta_NAME".to_owned();
            }
            assert!(listed.contains(name.as_str()), "{case}: {column}");
        }
        for file in folder.names("out").into_iter().filter(|file| !file.starts_with('.')) {
            let is_of = |row: &Vec<String>| row[0].starts_with("run --vary") || row[0] == "all of these";
            let is_named = |row: &Vec<String>| is_of(row) && row[1].contains(&file);
            assert!(files.iter().any(is_named), "{file}");
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
