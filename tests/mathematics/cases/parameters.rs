//! One table of parameters for all formulas of a case, and the tables that it takes the place of.

use geodesic_ivp::case::Case;

use super::read;

const END: &str = "initial = { x = 1.0, x_dot = 0.0 }\ngrid.t_f = 2.0\nsolver.accuracy = 1e-6\n";

/// A spring whose parameter k stands in that table, which is written in TOML.
fn spring(parameters: &str) -> String {
    format!("particle.law = \"newtonian\"\n{parameters}\n{END}")
}

const NOW: &str = "parameters.k = 3\npotential.formula = \"k*x^2/2\"";
/// The same in the tables of before.
const BEFORE: [&str; 2] = [
    "potential = { formula = \"k*x^2/2\", parameters = { k = 3 } }",
    "potential.formula = { expression = \"k*x^2/2\", parameters = { k = 3 } }",
];

fn with(text: &str, overrides: &[&str]) -> Case {
    let overrides: Vec<String> = overrides.iter().map(|setting| (*setting).to_owned()).collect();
    Case::parse("case", text, &overrides).unwrap()
}

/// The value of k, and the notes.
fn k(case: &Case) -> (&str, usize) {
    let [(name, value)] = case.geometry_text.parameters.as_slice() else { panic!("one parameter") };
    assert_eq!(name, "k");
    (value, case.notes().len())
}

#[test]
fn all_formulas_of_a_case_see_one_table() {
    let text = "parameters = { k = 3, a = \"k/6\" }\npotential.formula = \"k*x^2/2\"\nparticle.law = \"newtonian\"\n\
                initial = { x = \"a\", x_dot = 0 }\ngrid.t_f = \"4*a\"\nsolver.accuracy = 1e-6\n\
                invariants.e = \"x_dot^2/2 + k*x^2/2\"\n";
    let case = read(text).unwrap();
    assert_eq!((case.start::<f64>().q[1], case.t_f::<f64>()), (0.5, Some(2.0)));
    assert!(case.warnings().is_empty() && case.notes().is_empty());
}

#[test]
fn former_tables_are_read_with_a_note_and_the_effective_case_has_the_new_one() {
    let now = read(&spring(NOW)).unwrap();
    assert_eq!(k(&now), ("3", 0));
    for before in BEFORE {
        let case = read(&spring(before)).unwrap();
        assert_eq!(k(&case), ("3", 1));
        assert!(case.notes()[0].contains("goes in the next version: [parameters]"), "{:?}", case.notes());
        let effective = case.to_toml();
        assert!(effective.contains("\n[parameters]\nk = 3\n") && effective.matches("parameters").count() == 1);
        assert_eq!(k(&read(&effective).unwrap()), ("3", 0), "{effective}");
    }
    let metric = "metric = { preset = \"schwarzschild\", parameters = { m = 2 } }\n\
                  initial = { r = 10.0, t_dot = 1.2, r_dot = -0.05, p_phi = -3.0 }\ngrid.gamma_f = 4.0\n\
                  solver.accuracy = 1e-6\n";
    let case = read(metric).unwrap();
    assert_eq!(case.geometry_text.parameters, [("m".to_owned(), "2".to_owned())]);
    assert!(case.to_toml().contains("\n[parameters]\nm = 2\n") && case.notes()[0].starts_with("metric.parameters"));
    // Those of a preset stand in the new table, too.
    let case = with(metric, &["metric.preset=kerr-equatorial"]);
    assert!(case.to_toml().contains("\n[parameters]\nm = 2\na = 0\n"), "{}", case.to_toml());
}

#[test]
fn an_override_of_either_name_changes_the_one_parameter() {
    for text in [NOW, BEFORE[0], BEFORE[1]].map(spring) {
        let notes = usize::from(!text.contains("parameters.k"));
        assert_eq!(k(&with(&text, &["parameters.k=5"])), ("5", notes));
        for key in ["potential.parameters.k", "potential.formula.parameters.k", "metric.parameters.k"] {
            let case = with(&text, &[&format!("{key}=5")]);
            assert_eq!(k(&case).0, "5");
            let place = key.strip_suffix(".k").unwrap();
            assert!(case.notes().iter().any(|note| note.starts_with(place)), "{:?}", case.notes());
        }
        // A potential with parameters of its own brings them.
        assert_eq!(k(&with(&text, &["potential={formula=\"k*x^4\",parameters={k=7}}"])).0, "7");
    }
}

#[test]
fn one_name_in_two_tables_is_a_mistake() {
    let text = spring(&format!("parameters.k = 2\n{}", BEFORE[0]));
    let error = read(&text).unwrap_err();
    assert!(error.message.contains("'k' is already that of a parameter"), "{error}");
}
