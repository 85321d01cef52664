//! A potential in one coordinate is a scene like any other: a case without coordinates says the same about it.

use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::solve::WorldLine;
use geodesic_ivp::{Case, Solution, solve};

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
        let particle = "[particle]\nmass = 2.0\nc = 1.5\n";
        let one = format!("[potential]\nformula = {{ expression = \"x^4/2\" }}\n{particle}{rest}");
        let solution: Solution = solve(&Case::parse("one", &one, &[]).unwrap()).unwrap();
        let measured = Diagnostics::new(&solution);
        let scene = format!("[potential]\ncoordinates = [\"x\"]\nformula = \"x^4/2\"\n{particle}{rest}");
        let scene = Case::parse("scene", &scene, &[]).unwrap_or_else(|error| panic!("{error}"));
        let line: WorldLine = solve(scene.setup()).unwrap();
        let same = Diagnostics::of(&line, &[], &mut [], false);
        let what = |name: &str| format!("{sbp} {form} {name}");
        near(&line.q(0).collect::<Vec<_>>(), &solution.t().collect::<Vec<_>>(), 1e-12, &what("t"));
        near(&line.q(1).collect::<Vec<_>>(), solution.x(), 1e-12, &what("x"));
        near(&same.charges[0].delta, &measured.charges[0].delta, 1e-11, &what("delta_q_t"));
        near(&same.charges[0].corrected, &measured.charges[0].corrected, 1e-11, &what("corrected"));
        near(&same.norm.delta, &measured.norm.delta, 1e-11, &what("delta_k"));
        near(&same.norm.ends, &measured.norm.ends, 1e-11, &what("delta_k at the ends"));
        near(&same.delta_g[0], &measured.delta_g[0], 1e-9, &what("delta_g_t"));
        near(&same.delta_g[1], &measured.delta_g[1], 1e-9, &what("delta_g_x"));
        // They differ from zero by more than that, so that sign and scale are tested.
        let last = measured.delta_g[1][n_gamma - 1].abs();
        assert_eq!(last > 1e-3, form == "strong", "{last:e}");
        let tangent = measured.tangent(&solution);
        near(&same.tangent(&line)[0], &tangent[0], 1e-11, &what("t_dot"));
        near(&same.tangent(&line)[1], &tangent[1], 1e-11, &what("x_dot"));
    }
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
        let case = Case::parse("test", &text, &[]).unwrap_or_else(|error| panic!("{error}"));
        let line: WorldLine = solve(case.setup()).unwrap_or_else(|failure| panic!("{failure}"));
        [line.end().q[1], line.end().q[2]]
    };
    let [newton, other] = ["law = \"newtonian\"", "c = 1e4"].map(end);
    assert!(newton.iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-7), "{newton:?} {other:?}");
}
