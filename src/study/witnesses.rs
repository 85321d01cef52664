//! A run that is right is explained by its error, and one that was made wrong on purpose is doubted by the witness that
//! can see it.

use std::sync::Arc;

use super::errors::run_error;
use crate::case::Case;
use crate::diagnostics::Diagnostics;
use crate::solve::{WorldLine, solve};

/// Two masses on a spring, for which the sum of momenta, the energy and a formula are kept.
const SPRING: &str = r#"
    potential = { coordinates = ["x", "y"], formula = "3*(x-y)^2 + (x-y)^4" }
    particle = { law = "newtonian", masses = { x = 2.0, y = 0.5 } }
    initial = { x = 0.6, y = -0.2, x_dot = 0.9, y_dot = 1.5 }
    invariants = { momentum = "p_x + p_y" }
"#;
/// A relativistic motion in a plane, and one that a force slows down.
const PLANE: &str = r#"
    potential = { coordinates = ["x", "y"], formula = "x^2/2 + y^2" }
    particle.c = 3.0
    initial = { x = 0.6, y = -0.2, x_dot = 0.3, y_dot = 0.5, t_dot = 1.0 }
"#;
const FRICTION: &str = r#"
    metric.coordinates = ["t", "x"]
    metric.components = { "t t" = "1", "x x" = "-1" }
    metric.force = { x = "x_dot/5" }
    initial = { t_dot = 2.0, x = 0.0, x_dot = 0.5 }
"#;
const SCHEMES: [&str; 6] = [
    "solver.accuracy = 1e-9\ngrid.gamma_f = 3.0",
    "grid = { gamma_f = 3.0, n_gamma = 400 }\nscheme.sbp = \"SBP21\"",
    "grid = { gamma_f = 3.0, n_gamma = 100 }\nscheme = { sbp = \"SBP42\", form = \"weak\" }",
    "grid = { gamma_f = 3.0, n_gamma = 60, windows = 2 }\nscheme.sbp = \"SBP84\"",
    "grid = { gamma_f = 3.0, n_gamma = 10, windows = 4 }\nscheme = { sbp = \"GLL10\", form = \"weak\" }",
    "grid = { gamma_f = 3.0, n_gamma = 12, windows = 8 }\nscheme.sbp = \"GLL12\"",
];

fn case(text: &str, scheme: &str) -> Case {
    Case::parse("test", &format!("{scheme}\n{text}"), &[]).unwrap_or_else(|error| panic!("{error}\n{scheme}\n{text}"))
}

/// A run with its errors.
fn run(case: &Case) -> (WorldLine, Vec<f64>) {
    let setup = case.setup();
    let line = solve(&setup).unwrap_or_else(|failure| panic!("{failure}"));
    let errors = run_error(&setup, &line, &[]).expect("a second solve reaches the end").at_most();
    (line, errors)
}

/// The reasons to doubt a run that its witnesses give.
fn reasons(case: &Case, line: &WorldLine, errors: &[f64]) -> Vec<String> {
    let start = case.start::<f64>();
    let sums = case.geometry::<f64>().conserved_sums(&start, || case.geometry());
    let sums: Vec<_> = sums.into_iter().map(|sum| sum.terms).collect();
    let found = Diagnostics::of(line, &sums, &mut case.observables(), case.is_lifted());
    found.unexplained(line, Some(errors)).into_iter().map(|reason| reason.reason).collect()
}

#[test]
fn the_error_of_a_right_run_explains_what_its_witnesses_say() {
    for scheme in SCHEMES {
        for text in [SPRING, PLANE, FRICTION] {
            let case = case(text, scheme);
            let (line, errors) = run(&case);
            let found = reasons(&case, &line, &errors);
            assert!(found.is_empty(), "{found:?} with {errors:?} in\n{scheme}\n{text}");
        }
    }
}

/// What is done to a run.
type Wrong = fn(&mut WorldLine);

#[test]
fn every_witness_sees_a_run_that_was_made_wrong() {
    let moved: Wrong = |line| {
        let middle = line.nodes() / 2;
        line.q[1][middle] += 0.05;
    };
    let shifted: Wrong = |line| line.q[0].iter_mut().for_each(|t| *t *= 1.02);
    let uncertified: Wrong = |line| line.gradient_norm = 10.0;
    let lost: Wrong = |line| line.q[1][1] = f64::NAN;
    let pushed: Wrong = |line| *line.joints.last_mut().expect("it has ends") += 0.05;
    for scheme in SCHEMES {
        for (text, wrong, witness) in [
            (SPRING, moved, "the energy of positions and velocities"),
            (SPRING, moved, "p_x + p_y"),
            (SPRING, moved, "the invariant momentum"),
            (PLANE, moved, "K"),
            (PLANE, moved, "the gradient of the action"),
            (PLANE, shifted, "p_t"),
            (PLANE, uncertified, "the gradient of the action, as it was found in solving,"),
            (PLANE, lost, "K"),
            (PLANE, lost, "p_t"),
            (FRICTION, pushed, "p_x without the work of the force"),
        ] {
            let case = case(text, scheme);
            let (mut line, errors) = run(&case);
            let is_strong = scheme != SCHEMES[0] && !scheme.contains("weak");
            // All rows of a strong element contain multipliers, and a sum of its equations is not the work.
            // The weak form has no multipliers: all of the gradient is that of the nodes.
            let has_none = match witness {
                "the gradient of the action" => is_strong && scheme.contains("GLL"),
                "the gradient of the action, as it was found in solving," => !is_strong,
                _ => is_strong && text == FRICTION,
            };
            wrong(&mut line);
            let found = reasons(&case, &line, &errors);
            let is_told = found.iter().any(|reason| reason.starts_with(&format!("{witness} changes by")));
            assert!(is_told != has_none, "{witness}: {found:?} with {errors:?} in\n{scheme}\n{text}");
        }
    }
}

/// The nodes solve the equations of another potential: only the action that is formed anew knows.
#[test]
fn a_force_that_was_changed_behind_the_solver_is_seen_by_the_gradient() {
    for scheme in ["solver.accuracy = 1e-12\ngrid.gamma_f = 3.0", SCHEMES[2]] {
        let right = case(PLANE, scheme);
        let (mut line, errors) = run(&right);
        let other = case(&PLANE.replace("y^2\"", "y^2 + 2*sin(3*x)\""), scheme);
        line.place.geometry = Arc::new(other.geometry());
        let found = reasons(&right, &line, &errors);
        assert!(found.iter().any(|reason| reason.starts_with("the gradient of the action changes")), "{found:?}");
    }
}

#[test]
fn a_formula_that_is_not_kept_is_doubted_by_its_name_and_nothing_else_is() {
    let text = PLANE.to_owned() + "[invariants]\nwrong = \"x*y_dot + y*x_dot\"\nnorm_again = \"norm\"\n";
    for scheme in SCHEMES {
        let case = case(&text, scheme);
        let (line, errors) = run(&case);
        let found = reasons(&case, &line, &errors);
        assert!(found.len() == 1 && found[0].starts_with("the invariant wrong changes by"), "{found:?}");
    }
}

#[test]
fn a_hill_between_the_nodes_makes_a_defect() {
    let hill = |place: &str, nodes: u32| {
        let text = format!(
            "potential.formula = \"0.05*exp(-((x - {place})/1e-2)^2)\"\nparticle.c = 3.0\n\
             initial = {{ x = -1.0, t_dot = 1.0, x_dot = 1.0 }}\n"
        );
        let scheme = format!(
            "grid = {{ gamma_f = 2.0, n_gamma = {nodes} }}\nscheme = {{ sbp = \"GLL{nodes}\", form = \"weak\" }}"
        );
        let case = case(&text, &scheme);
        let line: WorldLine = solve(case.setup()).unwrap_or_else(|failure| panic!("{failure}"));
        let defect = Diagnostics::new(&line).defect.map(|defect| defect.most).expect("it is an element");
        (reasons(&case, &line, &[1e-9, 1e-9]), defect)
    };
    // The middle of a window with an even number of nodes is a zero of P_15, and a widest gap.
    let (found, defect) = hill("0.0", 16);
    assert!(found.len() == 1 && found[0].starts_with("between the nodes"), "{found:?}");
    assert!(found[0].contains("near gamma = 1.000000, with t = ") && found[0].contains("x = 0.000000"), "{found:?}");
    // g00 = 9 + 2V is 9.1 there, and ṫ = Q_t/g00 where the nodes have ṫ = 1: t is off by 2 (1 − 9/9.1) of 2.
    assert!((defect - 0.1 / 9.1).abs() < 1e-3, "{defect}");
    // A hill that is far away makes none.
    let (found, defect) = hill("7.0", 16);
    assert!(found.is_empty() && defect < 1e-12, "{found:?}, {defect}");
}

/// A run to an accuracy shows how small the defect is that it was chosen for.
#[test]
fn a_defect_falls_with_the_accuracy() {
    let defect = |accuracy: &str| {
        let scheme = format!("solver.accuracy = {accuracy}\ngrid.gamma_f = 20.0");
        let (line, _) = run(&case(SPRING, &scheme));
        Diagnostics::new(&line).defect.expect("its windows are elements").most
    };
    let [coarse, fine] = ["1e-4", "1e-12"].map(defect);
    assert!(coarse > 1e-9 && fine < 1e-2 * coarse && fine > 0.0, "{coarse:e} and {fine:e}");
}
