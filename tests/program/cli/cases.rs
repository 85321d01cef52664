//! Cases: the built-in ones, and advice that fits. `tests/cmd/` has the list of the built-in ones, short ways to write
//! one, and what may have been meant.

use std::fs;

use geodesic_ivp::case::builtin::{self, NAMES};

use crate::common::{CASES, Folder};

#[test]
fn every_case_meets_its_expectations() {
    let folder = Folder::new();
    // Where something is to be found, the run is only that from which a search begins.
    let names = NAMES.iter().filter(|name| !builtin::text(name).unwrap().contains("[find]"));
    names.for_each(|name| drop(folder.succeeds(&format!("check --run --quiet {name}"))));
}

/// A file of that path wins, and a folder does not.
#[test]
fn a_built_in_case_stands_in_for_a_file_that_is_not_there() {
    let folder = Folder::new();
    folder.succeeds("run quartic --out built-in");
    folder.succeeds("run CASES/quartic.toml --out file");
    assert_eq!(folder.read("built-in/trajectory.csv"), folder.read("file/trajectory.csv"));
    fs::copy(format!("{CASES}/free.toml"), folder.path("quartic")).unwrap();
    folder.succeeds("run quartic --out own");
    assert_eq!(folder.summary("own")["title"], "Free particle");
    fs::create_dir(folder.path("linear")).unwrap();
    assert!(folder.succeeds("check --run linear").contains("Linear potential"));
}

/// The fall ends at r = 1, at the proper time that the cycloid gives.
#[test]
fn gamma_at_the_end_of_a_scene_may_be_expected() {
    let folder = Folder::new();
    let check = "check schwarzschild-plunge --run --set expect.tolerance=1e-10 --set expect.gamma_final=";
    assert!(folder.fails(&format!("{check}34.76593"), 5).contains("gamma_final = 34.637"));
    let eta = (-0.8_f64).acos();
    let met = folder.succeeds(&format!("{check}{}", 125.0_f64.sqrt() * (eta + eta.sin())));
    assert!(met.contains("gamma_final = 34.637") && met.contains("r_final = "), "{met}");
}

#[test]
fn where_the_residual_is_rounding_more_iterations_are_not_recommended() {
    let message = Folder::new().fails("run pendulum --set parameters.g=9.81", 3);
    assert!(message.contains("max-iterations") && message.contains("more iterations would not help"), "{message}");
    assert!(message.contains("solver.accuracy") && !message.contains("raise solver.max_iterations"), "{message}");
}
