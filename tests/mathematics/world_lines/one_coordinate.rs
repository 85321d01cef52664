//! A potential in one coordinate is a scene like any other, and both laws have the same forces.

use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::solve::WorldLine;

use crate::common::{end, line_of, one_and_scene, text_solved};

fn near(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() <= tolerance, "{what}, node {k}: {found:e} {expected:e}");
    }
}

#[test]
fn one_coordinate_is_measured_as_it_is_without_a_scene() {
    let rest = "[initial]\nt = 0.5\nx = 1.0\nt_dot = 1.1\nx_dot = 0.1\n[grid]\ngamma_f = 2.0\nwindows = 2\n";
    for (sbp, form, n_gamma) in [("SBP21", "strong", 17), ("SBP42", "strong", 24), ("SBP42", "weak", 24)] {
        let rest = format!("{rest}n_gamma = {n_gamma}\n[scheme]\nsbp = \"{sbp}\"\nform = \"{form}\"\n");
        let rest = format!("[particle]\nmass = 2.0\nc = 1.5\n{rest}");
        let [solution, line] = one_and_scene("x^4/2", &rest).map(|case| -> WorldLine { line_of(&case) });
        let [measured, same] = [&solution, &line].map(Diagnostics::new);
        let what = |name: &str| format!("{sbp} {form} {name}");
        for (a, name) in ["t", "x"].into_iter().enumerate() {
            let [q, known]: [Vec<f64>; 2] = [&line, &solution].map(|line| line.q(a).collect());
            near(&q, &known, 1e-12, &what(name));
            near(&same.tangent(&line)[a], &measured.tangent(&solution)[a], 1e-11, &what(name));
            near(&same.delta_g[a], &measured.delta_g[a], 1e-9, &what("delta_g"));
        }
        near(&same.charges[0].delta, &measured.charges[0].delta, 1e-11, &what("delta_q_t"));
        near(&same.charges[0].corrected, &measured.charges[0].corrected, 1e-11, &what("corrected"));
        near(&same.norm.delta, &measured.norm.delta, 1e-11, &what("delta_k"));
        near(&same.norm.ends, &measured.norm.ends, 1e-11, &what("delta_k at the ends"));
        // They differ from zero by more than that, so that sign and scale are tested.
        let last = measured.delta_g[1][n_gamma - 1].abs();
        assert_eq!(last > 1e-3, form == "strong", "{last:e}");
    }
    let rest =
        "initial = { t = 0.0, x = 1.0, t_dot = 1.0, x_dot = 0.1 }\ngrid.gamma_f = 20.0\nsolver.accuracy = 1e-11\n";
    let [solution, line] = one_and_scene("x^4/2", rest).map(|case| -> WorldLine { line_of(&case) });
    let [t, x] = ["t", "x"].map(|name| (end(&line, name) - end(&solution, name)).abs());
    assert!(x < 2e-11 && t < 2e-11 * end(&solution, "t"), "{t:e} {x:e}");
}

/// Slow motion in the paper's metric with a large c is Newton's, with drag, a magnetic field and a mass.
#[test]
fn forces_of_both_laws_are_the_same() {
    let end = |particle: &str| {
        let text = format!(
            r#"
            potential.coordinates = ["x", "y"]
            potential.formula = "x^2 + y^2"
            potential.force = {{ x = "-0.4*x_dot" }}
            potential.one_form = {{ x = "-0.3*y", y = "0.3*x" }}
            particle = {{ mass = 2.0, {particle} }}
            initial = {{ t_dot = 1.0, x = 1.0, y = 0.2, x_dot = 0.1, y_dot = -0.3 }}
            grid = {{ gamma_f = 4.0, n_gamma = 401 }}
            scheme = {{ sbp = "SBP84", form = "weak" }}
            "#
        );
        let line = text_solved(&text);
        [line.end().q[1], line.end().q[2]]
    };
    let [newton, other] = ["law = \"newtonian\"", "c = 1e4"].map(end);
    assert!(newton.iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-7), "{newton:?} {other:?}");
}
