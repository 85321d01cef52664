//! Short ways to write a case, and advice that fits. What may have been meant is told in `tests/cmd/hints.md`.

use std::fs;

use tempfile::TempDir;

use crate::common::{failed, json, run_in, succeeded};

#[test]
fn a_formula_can_be_a_word_and_t_begins_at_zero() {
    let folder = TempDir::new().unwrap();
    let text = "potential.formula = \"0.5*x^4\"\ninitial = { x = 1.0, t_dot = 1.0, x_dot = 0.1 }\n\
                grid.n_gamma = 32\nscheme.sbp = \"SBP21\"\n";
    fs::write(folder.path().join("short.toml"), text).unwrap();
    succeeded(&run_in(folder.path(), "run short.toml --out short"));
    succeeded(&run_in(folder.path(), "run quartic --out long"));
    let [short, long] = ["short", "long"].map(|out| json(&folder.path().join(out).join("summary.json")));
    for key in ["t_final", "x_final"] {
        let [short, long] = [&short, &long].map(|summary| summary[key].as_f64().unwrap());
        assert!((short - long).abs() < 1e-13);
    }
    // The effective case is the same case, and a mistake is found inside the word.
    succeeded(&run_in(folder.path(), "run short/case.toml --out again"));
    assert_eq!(json(&folder.path().join("again/summary.json"))["x_final"], short["x_final"]);
    fs::write(folder.path().join("short.toml"), text.replace("x^4", "y^4")).unwrap();
    let message = failed(&run_in(folder.path(), "check short.toml"), 2);
    assert!(message.contains("short.toml:1:26") && message.contains("unknown name 'y'"), "{message}");
    // An accuracy needs no [grid].
    let text = "potential.formula = \"x^2\"\ninitial = { x = 1.0, t_dot = 1.0, x_dot = 0.1 }\nsolver.accuracy = 1e-8\n";
    fs::write(folder.path().join("accurate.toml"), text).unwrap();
    succeeded(&run_in(folder.path(), "run accurate.toml"));
}

#[test]
fn a_formula_needs_no_quotes_on_the_command_line_and_a_case_no_title() {
    let folder = TempDir::new().unwrap();
    let text = "potential.formula = \"0\"\ninitial = { x = 1.0, t_dot = 1.0, x_dot = 0.1 }\n\
                particle.c = 3.0\nsolver.accuracy = 1e-8\n";
    fs::write(folder.path().join("mine.toml"), text).unwrap();
    let output = succeeded(&run_in(folder.path(), "run mine.toml --set potential.formula=1-cos(x)"));
    assert!(output.starts_with("mine: trusted, "), "{output}");
    let effective = fs::read_to_string(folder.path().join("results/mine/case.toml")).unwrap();
    assert!(effective.contains("1-cos(x)") && !effective.contains("title"), "{effective}");
    let message = failed(&run_in(folder.path(), "run mine.toml --set initial.x=1-2"), 2);
    assert!(message.contains("'1-2' is not a TOML value"), "{message}");
}

#[test]
fn where_the_residual_is_rounding_more_iterations_are_not_recommended() {
    let folder = TempDir::new().unwrap();
    let message = failed(&run_in(folder.path(), "run pendulum --set potential.formula.parameters.g=9.81"), 3);
    assert!(message.contains("max-iterations") && message.contains("more iterations would not help"), "{message}");
    assert!(message.contains("solver.accuracy") && !message.contains("raise solver.max_iterations"), "{message}");
}
