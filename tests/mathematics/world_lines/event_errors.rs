//! The error at the end of a run that a formula ends is that of the place: closed forms of an oscillator, by formulas
//! that cross slowly, or cancel.

use geodesic_ivp::solve::Setup;
use geodesic_ivp::study::run::{Wanted, run};

use crate::common::parsed;

/// The error that a run of x = cos t claims at its end in t, and by how much it is off there.
fn claimed(until: &str, grid: &str, truth: f64) -> [f64; 2] {
    let text = format!(
        r#"
        potential = {{ coordinates = ["x"], formula = "x^2/2" }}
        particle.law = "newtonian"
        initial = {{ x = 1.0, x_dot = 0.0 }}
        grid.t_f = 4.0
        grid.until = "{until}"
        {grid}
        "#
    );
    let case = parsed(&text, &[]);
    let setup: Setup = case.setup();
    let run = run(&case, &setup, Wanted::default()).0.unwrap_or_else(|none| panic!("{until}: {none:?}"));
    assert_eq!(run.line.ended_by, Some(0), "{until}");
    let error = run.judged(&setup, false, false).error.unwrap();
    [error.at_most_at_end()[0], (run.line.end().q[0] - truth).abs()]
}

#[test]
fn the_error_at_an_end_is_that_of_its_place() {
    let third = std::f64::consts::PI / 3.0;
    let accurate = "solver.accuracy = 1e-6";
    let rough = "grid.n_gamma = 12\ngrid.windows = 4\nscheme = { sbp = \"GLL12\", form = \"weak\" }";
    let fine = "grid.n_gamma = 80\ngrid.windows = 5\nscheme = { sbp = \"SBP84\", form = \"weak\" }";
    for grid in [accurate, rough, fine] {
        for (until, truth) in [
            ("x - 0.5", third),
            ("x_dot + 0.1*x - 0.05 + sqrt(3)/2", third),
            // Where it turns at t = pi it is crossed slowly.
            ("x + 0.999999", std::f64::consts::PI - (2.0 * 1e-6_f64).sqrt() * (1.0 + 1e-6 / 12.0)),
            ("cos(1e-3*(x + 0.5)) - cos(1e-3)", third),
            ("(x + 1e9) - 1000000000.5", third),
        ] {
            let [claim, off] = claimed(until, grid, truth);
            assert!(off <= 2.0 * claim + 4e-15, "{until} with {grid}: off by {off:e}, and claims {claim:e}");
        }
    }
}
