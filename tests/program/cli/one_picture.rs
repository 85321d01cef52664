//! `run --plot --together`: the curves of several runs in one picture.

use crate::common::{Folder, stderr, succeeded};

/// The labels of a picture's legend and of all else that is written in it.
fn texts(svg: &str) -> Vec<&str> {
    let text = |part: &str| part.split_once('>').unwrap().1.len();
    svg.split("<text").skip(1).filter(|part| text(part) > 0).map(|part| part.split_once('>').unwrap().1).collect()
}

/// The number of elements of a picture that have this colour, as that of a line or of symbols.
fn coloured(svg: &str, colour: &str) -> usize {
    svg.matches(&format!("stroke=\"#{colour}\"")).count() + svg.matches(&format!("-{colour}-")).count()
}

/// The colours of the first three runs.
const COLOURS: [&str; 3] = ["0072b2", "d55e00", "009e73"];

#[test]
fn the_curves_of_several_cases_are_in_one_picture_beside_their_own() {
    let folder = Folder::new();
    let quartic = folder.succeeds("init quartic");
    for n in ["16", "32", "64"] {
        assert!(quartic.contains("n_gamma = 32"));
        folder.write(&format!("n{n}.toml"), quartic.replace("n_gamma = 32", &format!("n_gamma = {n}")));
    }
    let told = folder.succeeds("run n16.toml n32.toml n64.toml --plot --together");
    let end = "Together: n16, n32, n64\n  written  results/together: orbit.svg, charges.svg, mesh.svg, world_line.svg, \
               t_dot.svg,\n           trajectory.svg, delta_q_t.svg, delta_g.svg\n";
    assert!(told.ends_with(end), "{told}");
    let all = folder.pictures("results/together");
    assert_eq!(all, folder.pictures("results/n16"));
    for name in &all {
        let svg = folder.read(&format!("results/together/{name}"));
        let found = COLOURS.map(|colour| coloured(&svg, colour));
        assert!(found.iter().all(|&count| count > 0), "{name}: {found:?}");
        assert!(["n16", "n32", "n64"].iter().all(|run| texts(&svg).iter().any(|text| text.contains(run))), "{name}");
    }
    // The charge of every node of every run is there: as many as in the pictures of each.
    let vertices = |svg: &str| -> usize {
        let lines = svg.split("points=\"").skip(1).map(|line| line.split_once('"').unwrap().0);
        lines.map(|line| line.split(' ').count()).sum()
    };
    let of_charge = |folder_of: &str| vertices(&folder.read(&format!("results/{folder_of}/delta_q_t.svg")));
    let apart: usize = ["n16", "n32", "n64"].map(of_charge).iter().sum();
    let legend = |runs: usize| 2 * runs;
    assert!(of_charge("together") >= apart - legend(3), "{} of {apart}", of_charge("together"));
    // A reference that all have is drawn once, and has no name of a run.
    let reference = texts(&folder.read("results/together/trajectory.svg")).join("\n");
    assert_eq!(reference.matches("geodesic (reference)").count(), 1, "{reference}");
}

#[test]
fn rows_of_a_sweep_are_drawn_together() {
    let folder = Folder::new();
    folder.succeeds("run quartic --vary grid.n_gamma=16,32,64 --plot --together --out out");
    let names = folder.pictures("out");
    for name in ["orbit.svg", "delta_q_t.svg", "line.svg"] {
        assert!(names.iter().any(|other| other == name), "{names:?}");
    }
    let svg = folder.read("out/delta_q_t.svg");
    for value in ["grid.n_gamma = 16", "grid.n_gamma = 32", "grid.n_gamma = 64"] {
        assert!(svg.contains(value), "{value}");
    }
    // A row is the run with its values: its curve is that of the same case, given as a file.
    for n in ["16", "32"] {
        folder.succeeds(&format!("run quartic --set grid.n_gamma={n} --plot --out n{n}"));
        folder.write(&format!("n{n}.toml"), folder.read(&format!("n{n}/case.toml")));
    }
    folder.succeeds("run n16.toml n32.toml --plot --together --out files");
    folder.succeeds("run quartic --vary grid.n_gamma=16,32 --plot --together --out rows");
    let curves = |folder_of: &str| -> Vec<Vec<[i32; 2]>> {
        let svg = folder.read(&format!("{folder_of}/delta_q_t.svg"));
        // In tenths of a pixel from the first point: a longer legend moves the plot.
        let tenths = |text: &str| (10.0 * text.parse::<f64>().unwrap()).round() as i32;
        let place = |pair: &str| pair.split_once(',').map(|(x, y)| [tenths(x), tenths(y)]).unwrap();
        let lines = svg.split("points=\"").skip(1).map(|line| line.split_once('"').unwrap().0);
        let curve = |line: &str| {
            let places: Vec<[i32; 2]> = line.split(' ').map(place).collect();
            places.iter().map(|[x, y]| [x - places[0][0], y - places[0][1]]).collect()
        };
        lines.map(curve).collect()
    };
    assert_eq!(curves("files"), curves("rows"));
    // The events of all rows have a picture of their own.
    folder.succeeds("run kepler --vary initial.x=0.4,0.5 --plot --together --out kepler");
    assert_eq!(folder.pictures("kepler"), ["charges.svg", "line.svg", "mesh.svg", "orbit.svg", "section.svg"]);
    assert!(folder.read("kepler/section.svg").contains("Where the events of all rows are"));
}

#[test]
fn a_failed_case_is_left_out_of_the_picture() {
    let folder = Folder::new();
    let output = folder.run("run quartic horizon linear --plot --together --out out --quiet");
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    let svg = folder.read("out/orbit.svg");
    assert!(svg.contains(">quartic<") && svg.contains(">linear<") && !svg.contains("horizon"), "{svg}");
    let rows = folder.run("run linear --set grid.gamma_f=4 --vary initial.x=-0.9,3 --plot --together --out rows");
    assert!(stderr(&rows).contains("--together has 1 of the runs to draw"), "{}", stderr(&rows));
    succeeded(&rows);
    assert!(folder.read("rows/orbit.svg").contains(">initial.x = 3<"));
}

#[test]
fn runs_that_have_nothing_in_common_are_not_drawn_together() {
    let folder = Folder::new();
    folder.write("axes.toml", folder.succeeds("init quartic") + "\n[plot]\nx = \"x\"\ny = \"x_dot\"\n");
    folder.refuses(&[
        ("run quartic --plot --together", 2, "draws several runs in one picture, and this is one … name further"),
        ("run quartic morse --together", 2, "--plot"),
        ("run quartic kepler --plot --together", 2, "have other coordinates, t, x and t, x, y, s … same coordinates"),
        ("run quartic axes.toml --plot --together", 2, "are drawn in other axes, t and x and x and x_dot"),
        ("run quartic --vary initial.x=1 --plot --together", 2, "and this is one"),
        ("run quartic --vary initial.x=1:2:7 --plot --together", 2, "draws 6 runs at most, and these are 7"),
        ("run quartic --vary initial.x=1:2:4 --together", 2, "--plot"),
        ("run quartic --vary initial.x=1:2:4 --part 1/2 --plot --together --out a", 2, "--part"),
    ]);
}
