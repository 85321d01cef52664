//! Formulas with kinks and jumps: sign, step, min and max.

use geodesic_ivp::solve::WorldLine;

use crate::common::{against_reference, distance, failure, line_of, shipped, text_solved};

fn block(t_f: f64, accuracy: f64) -> String {
    format!(
        "potential = {{ formula = \"x^2/2\", force = {{ x = \"-mu*sign(x_dot)\" }}, parameters = {{ mu = 0.1 }} }}\n\
         particle.law = \"newtonian\"\ninitial = {{ x = 1.0, x_dot = 0.0 }}\ngrid.t_f = {t_f:?}\n\
         solver.accuracy = {accuracy:e}\n"
    )
}

/// Around the middle ±μ of each half turn the block swings as without friction.
#[test]
fn dry_friction_takes_as_much_in_each_half_turn() {
    let exact = |t: f64| {
        let half = (t / std::f64::consts::PI).floor();
        let (middle, sign) = (if half % 2.0 == 0.0 { 0.1 } else { -0.1 }, if half % 2.0 == 0.0 { 1.0 } else { -1.0 });
        middle + (1.0 - 0.2 * half - 0.1) * sign * (t - half * std::f64::consts::PI).cos()
    };
    for accuracy in [1e-6, 1e-9, 1e-12] {
        for t_f in [2.0, 5.0, std::f64::consts::TAU, 11.0] {
            let line = text_solved(&block(t_f, accuracy));
            let off = (line.end().q[1] - exact(t_f)).abs();
            assert!(off <= accuracy, "{accuracy:e} {t_f}: {off:e}");
            assert_eq!(line.windows_unproved, Some(0));
        }
    }
}

/// A start on the surface of a jump is on the side that the motion goes to, whatever rounding makes of it: one window
/// leads away from there.
#[test]
fn a_motion_that_starts_on_the_surface_of_a_jump_leaves_it() {
    for (force, x_dot, wanted) in [
        ("2 - sign(x_dot)", 0.0, 0.5),
        ("-2 - sign(x_dot)", 0.0, -0.5),
        ("3*step(x) - 2", 1.0, 1.5),
        ("3*step(-x) - 1", 1.0, 0.5),
        ("(3 - sign(x_dot))/2", 0.0, 0.5),
    ] {
        for power in 4..13 {
            let accuracy = 10.0_f64.powi(-power);
            let line = text_solved(&format!(
                "potential.coordinates = [\"x\"]\npotential.formula = \"0\"\npotential.force.x = \"{force}\"\n\
                 particle.law = \"newtonian\"\ninitial = {{ x = 0.0, x_dot = {x_dot} }}\ngrid.t_f = 1.0\n\
                 solver.accuracy = {accuracy:e}\n"
            ));
            let off = (line.end().q[1] - wanted).abs();
            assert!(off <= accuracy && line.windows.len() <= 3, "{force} {accuracy:e}: {off:e}");
        }
    }
}

/// After five half turns the spring is weaker than the friction.
#[test]
fn a_block_that_sticks_ends_the_run() {
    let failure = failure(&block(40.0, 1e-8));
    assert!((failure.gamma - 5.0 * std::f64::consts::PI).abs() < 1e-6, "{failure}");
    assert!(failure.advice().contains("friction"), "{}", failure.advice());
}

/// A ball on a floor that is a stiff spring: k = 10⁶, g = 10, from h = 1. The number is that of parabolas and arcs of
/// sines, one after the other.
#[test]
fn a_ball_bounces_on_a_floor() {
    for floor in ["max(0, -z)", "-min(z, 0)", "-z*step(-z)"] {
        let line = text_solved(&format!(
            "potential = {{ coordinates = [\"z\"], formula = \"g*z + k/2*d^2\", definitions = {{ d = \"{floor}\" }},\n\
             parameters = {{ g = 10.0, k = \"g*1e5\" }} }}\nparticle.law = \"newtonian\"\n\
             initial = {{ z = 1.0, z_dot = 0.0 }}\ngrid.t_f = 10.0\nsolver.accuracy = 1e-9\n"
        ));
        assert!((line.end().q[1] - 0.919_742_915_664_843_6).abs() < 1e-8, "{floor}: {:?}", line.end());
    }
}

/// Over five periods and more a bond passes sixty knots, at each of which windows end.
#[test]
fn windows_end_at_the_knots_of_a_table() {
    for (spline, most) in [("cubic", 160), ("quintic", 160)] {
        let set = ["grid.t_f=20.0", "solver.accuracy=1e-12", &format!("tables.v.spline={spline}")];
        let line: WorldLine = line_of(&shipped("molecule-table", &set));
        let judged = against_reference(&line);
        assert!(judged.end.iter().all(|error| *error < 1e-12), "{spline}: {judged:?}");
        assert!(line.window_count < most, "{spline}: {}", line.window_count);
    }
}

/// The same motion in Cartesian coordinates with atan2 and in a rotated frame, and against the Taylor method, which
/// meets kinks by itself.
#[test]
fn an_angle_has_no_kink_where_its_formula_has_one() {
    let text = |potential: &str| {
        format!(
            "potential = {{ coordinates = [\"x\", \"y\"], formula = \"{potential}\" }}\nparticle.law = \"newtonian\"\n\
             initial = {{ x = 1.0, y = 0.0, x_dot = 0.0, y_dot = 1.1 }}\ngrid.t_f = 12.0\nsolver.accuracy = 1e-10\n"
        )
    };
    let angle = text_solved(&text("-1/hypot(x, y) + 0.01*cos(2*atan2(y, x))"));
    let plain = text_solved(&text("-1/sqrt(x^2 + y^2) + 0.01*(x^2 - y^2)/(x^2 + y^2)"));
    let off = distance(&angle.end().q[1..3], &plain.end().q[1..3]);
    assert!(off < 1e-9, "{off:e}");
    let judged = against_reference(&angle);
    assert!(judged.end.iter().all(|error| *error < 1e-8), "{judged:?}");
}

/// Friction acts on nothing that rests, whatever it is the difference of; and what is about to be pushed waits for it.
#[test]
fn what_rests_against_friction_rests() {
    for (friction, push, t_f) in [("x_dot", "0", 10.0), ("2*x_dot + y_dot", "0", 10.0), ("x_dot", "max(0, t - 3)", 2.9)]
    {
        let line = text_solved(&format!(
            "potential = {{ coordinates = [\"x\", \"y\"], formula = \"x^2/2\",\n\
             force = {{ x = \"-0.084*sign({friction}) + {push}\" }} }}\nparticle.law = \"newtonian\"\n\
             initial = {{ x = 0.0, y = 0.681, x_dot = 0.0, y_dot = 0.0 }}\ngrid.t_f = {t_f:?}\n\
             solver.accuracy = 1e-6\n"
        ));
        assert_eq!(line.end().q[1..3], [0.0, 0.681], "{friction}");
    }
}

/// A force (x − c)² behind x = c moves what rests there. No window with the kink in it resolves the first of that
/// motion, which has no size yet, so that they become as short as the rounding of the place.
#[test]
fn a_kink_that_moves_what_rests_is_met() {
    for (k, mass) in [1.0, 2.0, 10.0, 2.0, 7.0_f64].into_iter().enumerate() {
        let number = k as f64;
        let (c, u, force, t_f) = (1.428 + 1.1 * number, 0.611 + 0.2 * number, 0.058 + 0.3 * number, 17.4 - number);
        for accuracy in [1e-6, 1.43e-9, 1e-11] {
            let line = text_solved(&format!(
                "potential = {{ coordinates = [\"x\", \"y\"], formula = \"y^2/2\",\n\
                 force.y = \"{force:?}*max(0, x - {c:?})^2\" }}\nparticle.law = \"newtonian\"\n\
                 particle.masses = {{ x = 1, y = {mass:?} }}\ngrid.t_f = {t_f:?}\nsolver.accuracy = {accuracy:e}\n\
                 initial = {{ x = 0, y = 0, x_dot = {u:?}, y_dot = 0 }}"
            ));
            let since = t_f - c / u;
            let exact = force * u * u * (since * since - 2.0 * mass * (1.0 - (since / mass.sqrt()).cos()));
            let (off, size) = ((line.end().q[2] - exact).abs(), exact.abs());
            assert!(since > 0.0 && off <= accuracy * size, "{c} {accuracy:e}: {off:e} of {size:e}");
            assert_eq!(line.windows_unproved, Some(0), "{c} {accuracy:e}");
        }
    }
}
