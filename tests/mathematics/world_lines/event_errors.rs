//! The error at the end of a run that a formula ends is that of the place: closed forms of an oscillator, by formulas
//! that cross slowly, or cancel.

use geodesic_ivp::diagnostics::verdict::Grade;
use geodesic_ivp::solve::Setup;
use geodesic_ivp::study::run::{Wanted, run};

use crate::common::parsed;
use crate::random_scenes::random::Random;

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

/// A ball that falls and bounces on a floor where the force on it jumps, behind which it never is: x at t = 4 by
/// parabolas, and how many bounces there are.
fn bounced([mut x, mut v]: [f64; 2], weight: f64, floor: f64, restitution: f64) -> (f64, usize) {
    let (mut t, mut bounces) = (0.0, 0);
    loop {
        let rest = 4.0 - t;
        let fall = (v + (v * v + 2.0 * weight * (x - floor)).sqrt()) / weight;
        if fall > rest {
            return (x + v * rest - weight * rest * rest / 2.0, bounces);
        }
        (t, x, v, bounces) = (t + fall, floor, restitution * (weight * fall - v), bounces + 1);
    }
}

#[test]
fn an_event_on_the_surface_of_a_jump_has_the_errors_of_its_place() {
    let (mut random, mut bounces) = (Random(72), 0);
    for k in 0..40 {
        let [height, speed, floor, jump, restitution] =
            [[0.5, 1.5], [-1.0, 1.0], [0.5, 2.0], [-5.0, 5.0], [0.7, 1.2]].map(|[low, high]| random.between(low, high));
        let start = floor + height;
        let accuracy = [1e-6, 1e-8, 1e-10, 1e-11, 1e-12][k % 5];
        let text = format!(
            "potential.formula = \"0\"\npotential.coordinates = [\"x\"]\n\
             potential.force = {{ x = \"-9 + {jump}*sign(x - {floor})\" }}\nparticle.law = \"newtonian\"\n\
             initial = {{ x = {start}, x_dot = {speed} }}\ngrid.t_f = 4.0\nsolver.accuracy = {accuracy}\n\
             events.floor = {{ when = \"x - {floor}\", set = {{ x_dot = \"-{restitution}*x_dot\" }} }}"
        );
        let case = parsed(&text, &[]);
        let setup: Setup = case.setup();
        // Where the force below the floor leads up again, a march may miss that it was there.
        let Ok(run) = run(&case, &setup, Wanted::default()).0 else { continue };
        let judged = run.judged(&setup, false, false);
        if judged.verdict.grade == Grade::Doubtful {
            continue;
        }
        let (truth, count) = bounced([start, speed], 9.0 - jump, floor, restitution);
        assert_eq!(run.acting_events, count, "{text}");
        let (claim, off) = (judged.error.unwrap().at_most_at_end()[1], (run.line.end().q[1] - truth).abs());
        assert!(off <= claim + 4e-14, "off by {off:e}, and claims {claim:e}: {text}");
        bounces += count;
    }
    assert!(bounces > 60, "{bounces}");
}
