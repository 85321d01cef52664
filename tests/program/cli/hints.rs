//! Errors that say what may have been meant, at the place where it stands.

use std::fs;

use tempfile::TempDir;

use crate::common::{CASES, failed, json, program, run_in, stderr, succeeded};

#[test]
fn misspelt_words_are_recognised() {
    let folder = TempDir::new().unwrap();
    for (arguments, fragments) in [
        ("rnu quartic", &["'run'"][..]),
        ("run quartic --plto", &["'--plot'"]),
        ("run quartic --set grid.n_gama=64", &["unknown field `n_gama`", "did you mean `n_gamma`?", ":21:1"]),
        ("run quartic --set n_gamma=64", &["unknown field `n_gamma`", "did you mean `grid.n_gamma`?"]),
        ("run quartic --set initial.mass=2.0", &["did you mean `particle.mass`?"]),
        ("run quartic --set potential={quartics={kappa=1.0}}", &["did you mean `quartic`?"]),
        ("run quartic --set solver.system=doubld", &["did you mean `doubled`?"]),
        ("run quartic --set scheme.sbp=sbp42", &["did you mean \"SBP42\"?"]),
        ("run quartic --set scheme.sbp=gll16", &["did you mean \"GLL16\"?"]),
        (
            "run pendulum --set potential.parameters.g=2",
            &["'potential.parameters' is not a potential", "potential.formula.parameters"],
        ),
    ] {
        let message = failed(&run_in(folder.path(), arguments), 2);
        assert!(fragments.iter().all(|fragment| message.contains(fragment)), "{arguments}: {message}");
    }
}

#[test]
fn formulas_of_other_languages_are_translated() {
    let folder = TempDir::new().unwrap();
    for (expression, character, hint) in [
        ("x**2", 3, "a power is written ^"),
        ("0.5*pow(x, 2)", 5, "pow(a, b) is written a^b"),
        ("log(1 + x^2)", 1, "the natural logarithm is ln, the one to base 10 is log10"),
        ("1 - Cos(x)", 5, "did you mean 'cos'?"),
        ("arctan(x)", 1, "the inverse tangent is atan"),
        ("X^2", 1, "did you mean 'x'?"),
        ("x²", 2, "a square is written ^2"),
        ("omga*x", 1, "did you mean 'omega'?"),
        ("1 + 2x^2", 5, "a product is written with *: 2*x"),
        ("0.5(x^2)", 4, "a product is written with *"),
    ] {
        let setting = format!("potential={{formula={{expression=\"{expression}\",parameters={{omega=1.0}}}}}}");
        let output = program(folder.path()).args(["run", "quartic", "--set", &setting]).output().unwrap();
        let message = failed(&output, 2);
        assert!(message.contains(&format!("(character {character} of the expression)")), "{expression}: {message}");
        assert!(message.contains(hint), "{expression}: {message}");
    }
}

#[test]
fn all_missing_keys_are_named_at_once() {
    let folder = TempDir::new().unwrap();
    for (text, fragments) in [
        ("", &["`potential`", "`initial`", "`scheme`", "`grid`", "solver.accuracy in place of both", ":1:1"][..]),
        (
            "potential.quartic = {}\n[initial]\nt = 0.0\n[grid]\n[scheme]\nsbp = \"SBP21\"\n",
            &[
                "missing fields",
                "`initial.x`, `initial.t_dot`, `initial.x_dot`, `grid.n_gamma`, `potential.quartic.kappa`",
                ":2:1",
            ],
        ),
        (
            "potential.free = {}\n[initial]\nx = 1.0\nvelocity = 0.1\n[solver]\naccuracy = 1e-9\n",
            &["missing field `t_dot`", "initial.t_dot is dt/dgamma at the start"],
        ),
    ] {
        fs::write(folder.path().join("case.toml"), text).unwrap();
        let message = failed(&run_in(folder.path(), "check case.toml"), 2);
        assert!(fragments.iter().all(|fragment| message.contains(fragment)), "{message}");
    }
}

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
    assert!(output.starts_with("mine\n"), "{output}");
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

#[test]
fn a_parameter_without_use_is_a_warning() {
    let folder = TempDir::new().unwrap();
    let formula = "potential={formula={expression=\"a*x^2\",parameters={a=1.0,b=2.0}}}";
    let output = run_in(folder.path(), &format!("check quartic --set {formula}"));
    succeeded(&output);
    let warnings = stderr(&output);
    assert!(warnings.contains("the formula does not use the parameter 'b'") && !warnings.contains("'a'"), "{warnings}");
}

#[test]
fn what_is_no_case_file_is_told_what_is_expected() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("case.yaml"), "potential:\n  quartic: 0.5\n").unwrap();
    let message = failed(&run_in(folder.path(), "run case.yaml"), 2);
    assert!(message.contains("a case is a TOML file, not .yaml") && message.contains("case.yaml:1:"), "{message}");
    let message = failed(&run_in(folder.path(), "run ."), 1);
    assert!(message.contains("it is a folder") && message.contains("`init --list`"), "{message}");
    for missing in ["cases/quartic.toml", "quatric", "Quartic.toml"] {
        let message = failed(&run_in(folder.path(), &format!("run {missing}")), 1);
        assert!(message.contains("there is a built-in case `quartic`"), "{missing}: {message}");
    }
}

#[test]
fn samples_beyond_the_end_are_told_where_it_is() {
    let folder = TempDir::new().unwrap();
    let message = failed(&run_in(folder.path(), &format!("run {CASES}/pendulum.toml --sample-t 0:11:0.1")), 2);
    assert!(message.contains("the run ends at ") && message.contains("--set grid.t_f="), "{message}");
    let message = failed(&run_in(folder.path(), "run quartic --sample-gamma -0.5:0.5:0.1"), 2);
    assert!(message.contains("take samples from 0.0 to 1.0"), "{message}");
    let message = failed(&run_in(folder.path(), "run quartic --sample-gamma 0:2:0.1"), 2);
    assert!(message.contains("the run ends at 1.0") && message.contains("--set grid.gamma_f="), "{message}");
}
