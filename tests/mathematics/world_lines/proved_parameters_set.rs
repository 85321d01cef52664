//! Proofs through events that set parameters, against closed forms in 70 digits.

use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::study::proof::{ProofOfRun, Status};

use super::proved_acting::{decimal, largest, number, off, proved};
use crate::common::{line_of, parsed};

/// An oscillator from rest at 1 to `end`, whose frequency is another one behind each passage of 0.
fn oscillator(first: Extended, mut next: impl FnMut(Extended) -> Extended, end: Extended) -> Extended {
    let (half, mut frequency, mut sign) = (Extended::PI * decimal("0.5"), first, -Extended::ONE);
    // From rest at 1 it comes to 0 with the speed of its frequency.
    let (speed, mut time) = (first, half / first);
    frequency = next(frequency);
    while time + Extended::PI / frequency < end {
        time += Extended::PI / frequency;
        frequency = next(frequency);
        sign = -sign;
    }
    sign * speed / frequency * (frequency * (end - time)).sin()
}

/// A spring that becomes weaker, and a mass that is lost, whenever x is 0: velocities stay.
#[test]
fn an_oscillator_that_changes_at_each_passage_is_where_pieces_of_sines_are() {
    let most = largest(|random| {
        let [k, part, end] = [(1.0, 4.0), (0.8, 1.2), (6.0, 9.0)].map(|(least, most)| number(random, least, most));
        let of = |formulas: &str| {
            let text = format!(
                "potential.coordinates = [\"x\"]\nparticle.law = \"newtonian\"\ninitial = {{ x = 1.0, x_dot = 0.0 }}\n\
                 solver.accuracy = 1e-9\ngrid.t_f = {end}\n{formulas}"
            );
            proved(&parsed(&text, &[]))
        };
        let spring = format!(
            "potential.formula = \"k*x^2/2\"\nparameters = {{ k = {k}, part = {part} }}\n\
             events.weaker = {{ when = \"x\", set = {{ k = \"part*k\" }} }}"
        );
        let mass = format!(
            "potential.formula = \"x^2/2\"\nparticle.masses.x = \"1/k\"\nparameters = {{ k = {k}, part = {part} }}\n\
             events.lost = {{ when = \"x\", set = {{ k = \"k + (part - 1)*k + x_dot*x\" }} }}"
        );
        let [k, part, end] = [&k, &part, &end].map(|text| decimal(text));
        let wanted = oscillator(k.sqrt(), |frequency| frequency * part.sqrt(), end);
        let found = [of(&spring), of(&mass)].map(|proof| off(&proof?, "x", wanted));
        Some(found[0]?.max(found[1]?))
    });
    assert!(most <= 1.0 && most > 1e-6, "{most}");
}

/// A ball of which each bounce changes gravity and the restitution itself: pieces of parabolas.
#[test]
fn a_ball_whose_bounces_change_gravity_is_where_parabolas_are() {
    let most = largest(|random| {
        let [z, e, g, more] = [(0.6, 2.0), (0.85, 0.99), (5.0, 12.0), (0.2, 1.0)].map(|(a, b)| number(random, a, b));
        let text = format!(
            "potential = {{ coordinates = [\"z\"], formula = \"g*z\" }}\nparticle.law = \"newtonian\"\n\
             initial = {{ z = {z}, z_dot = 0.0 }}\ngrid.t_f = 2.0\nsolver.accuracy = 1e-9\n\
             parameters = {{ g = {g}, e = {e} }}\nevents.floor = {{ when = \"z\", direction = \"down\", \
             set = {{ z_dot = \"-e*z_dot\", g = \"g + {more}\", e = \"e^2\" }} }}"
        );
        let [mut z, mut e, mut g, more] = [z, e, g, more].map(|text| decimal(&text));
        let (mut speed, mut left, two) = (Extended::ZERO, decimal("2"), Extended::from(2.0));
        loop {
            let next = (speed + (speed * speed + two * g * z).sqrt()) / g;
            let time = if next < left { next } else { left };
            z += speed * time - g * time * time / two;
            left -= time;
            if left <= Extended::ZERO {
                break;
            }
            (speed, z) = (e * (g * time - speed), Extended::ZERO);
            (g, e) = (g + more, e * e);
        }
        off(&proved(&parsed(&text, &[]))?, "z", z)
    });
    assert!(most <= 1.0 && most > 1e-6, "{most}");
}

/// Where the metric changes, velocities stay and momenta do not: a straight line has one velocity all the way. A force
/// that is turned off leaves the velocity that there was.
#[test]
fn velocities_go_on_where_parameters_of_metrics_and_forces_change() {
    let end = |proof: Option<ProofOfRun>, name: &str, wanted: f64| {
        let proof = proof.expect("it is solved");
        assert_eq!(proof.status, Status::Proved, "{proof:?}");
        let off = off(&proof, name, Extended::from(wanted)).unwrap();
        assert!(off <= 1.0, "{off} in {name}: {proof:?}");
    };
    let metric = "metric.coordinates = [\"x\", \"y\"]\n\
                  metric.components = { \"x x\" = \"k\", \"x y\" = \"k/3\", \"y y\" = \"1 + k^2\" }\n\
                  initial = { x = 0.0, y = 0.0, x_dot = 1.0, y_dot = 0.5 }\n\
                  grid.gamma_f = 3.0\nsolver.accuracy = 1e-9\n\
                  parameters.k = 2.0\nevents.other = { when = \"x - 1\", set = { k = \"5*k + y\" } }";
    end(proved(&parsed(metric, &[])), "x", 3.0);
    end(proved(&parsed(metric, &[])), "y", 1.5);
    let force = "potential = { coordinates = [\"x\"], formula = \"0\", force = { x = \"a\" } }\n\
                 particle.law = \"newtonian\"\ninitial = { x = 0.0, x_dot = 0.0 }\ngrid.t_f = 4.0\n\
                 solver.accuracy = 1e-9\nparameters.a = 2.0\nevents.off = { when = \"t - 1\", set = { a = \"0\" } }";
    end(proved(&parsed(force, &[])), "x", 7.0);
    // Two of them, of which one sets what the other one is met at.
    let two = force.replace(
        "events.off",
        "parameters.at = 3.0\nevents.back = { when = \"x - at\", set = { a = \"-a - 2\" } }\nevents.off",
    );
    // x = 1 + 2 (t − 1) is 3 at t = 2, and from there 3 + 2 s − s².
    end(proved(&parsed(&two, &["grid.t_f=3.5"])), "x", 3.75);
}

/// By the relativistic law the energy changes with the potential. Behind the event the motion is that of a run which
/// begins there, with the same velocities.
#[test]
fn a_relativistic_motion_goes_on_in_the_changed_potential() {
    let text = |start: &str, a: &str, further: &str| {
        format!(
            "potential.coordinates = [\"x\"]\npotential.formula = \"a*x + x^2/9\"\nparticle.c = 3.0\n\
             parameters.a = {a}\ninitial = {{ {start} }}\n{further}"
        )
    };
    let start = "t = 0.0, x = 0.3, t_dot = 1.0, x_dot = 0.2";
    let accurate = "solver.accuracy = 1e-9\ngrid.gamma_f = 2.5\n";
    let event = "events.other = { when = \"t - 1\", set = { a = \"-a/2\" } }";
    let whole = proved(&parsed(&text(start, "0.7", &format!("{accurate}{event}")), &[])).expect("it is solved");
    let grid = "solver.digits = 45\nscheme = { sbp = \"GLL24\", form = \"weak\" }\ngrid = { t_f = 1.0, windows = 12 }";
    let first = line_of::<Extended>(&parsed(&text(start, "0.7", grid), &[]));
    let (state, left) = (first.end(), decimal("2.5") - first.gamma_f());
    let [x, t_dot, x_dot] = [state.q[1], state.q_dot[0], state.q_dot[1]].map(|number| number.to_decimal(45));
    let start = format!("t = 1.0, x = {x}, t_dot = {t_dot}, x_dot = {x_dot}");
    let accurate = format!("solver.accuracy = 1e-9\ngrid.gamma_f = {}\n", left.to_decimal(45));
    let second = proved(&parsed(&text(&start, "-0.35", &accurate), &[])).expect("it is solved");
    for name in ["t", "x"] {
        let [one, other] = [&whole, &second].map(|of| of.ends.iter().find(|end| end.name == name).expect("a proof"));
        let apart = (decimal(&one.end) - decimal(&other.end)).abs().to_f64();
        assert!(apart <= one.radius + other.radius && one.radius < 1e-12, "{name}: {one:?} {other:?}");
    }
}
