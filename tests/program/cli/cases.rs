//! Cases: the built-in ones, short ways to write one, and advice that fits. `tests/cmd/` has the list of the built-in
//! ones, and what may have been meant.

use std::fs;

use geodesic_ivp::case::builtin::NAMES;

use crate::common::{CASES, Folder};

#[test]
fn every_case_meets_its_expectations() {
    let folder = Folder::new();
    NAMES.iter().for_each(|name| drop(folder.succeeds(&format!("check --run --quiet {name}"))));
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
fn a_formula_can_be_a_word_and_t_begins_at_zero() {
    let folder = Folder::new();
    let text = "potential.formula = \"0.5*x^4\"\ninitial = { x = 1.0, t_dot = 1.0, x_dot = 0.1 }\n\
                grid.n_gamma = 32\nscheme.sbp = \"SBP21\"\n";
    folder.write("short.toml", text);
    folder.succeeds("run short.toml --out short");
    folder.succeeds("run quartic --out long");
    for key in ["t_final", "x_final"] {
        let [short, long] = ["short", "long"].map(|out| folder.summary(out)[key].as_f64().unwrap());
        assert!((short - long).abs() < 1e-13);
    }
    // The effective case is the same case, and a mistake is found inside the word.
    folder.succeeds("run short/case.toml --out again");
    assert_eq!(folder.summary("again")["x_final"], folder.summary("short")["x_final"]);
    folder.write("wrong.toml", text.replace("x^4", "y^4"));
    folder.refuses(&[("check wrong.toml", 2, "wrong.toml:1:26 … unknown name 'y'")]);
}

#[test]
fn an_accuracy_needs_no_grid_a_formula_no_quotes_and_a_case_no_title() {
    let folder = Folder::new();
    let text = "potential.formula = \"0\"\ninitial = { x = 1.0, t_dot = 1.0, x_dot = 0.1 }\n\
                particle.c = 3.0\nsolver.accuracy = 1e-8\n";
    folder.write("mine.toml", text);
    let output = folder.succeeds("run mine.toml --set potential.formula=1-cos(x)");
    assert!(output.starts_with("mine: trusted, "), "{output}");
    let effective = folder.read("results/mine/case.toml");
    assert!(effective.contains("1-cos(x)") && !effective.contains("title"), "{effective}");
}

#[test]
fn where_the_residual_is_rounding_more_iterations_are_not_recommended() {
    let message = Folder::new().fails("run pendulum --set potential.formula.parameters.g=9.81", 3);
    assert!(message.contains("max-iterations") && message.contains("more iterations would not help"), "{message}");
    assert!(message.contains("solver.accuracy") && !message.contains("raise solver.max_iterations"), "{message}");
}
