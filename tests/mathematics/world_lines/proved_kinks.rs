//! Proofs through kinks and jumps of forces, against closed forms in 70 digits.

use geodesic_ivp::Case;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::study::proof::Status;

use super::proved_acting::{arc_cosine, decimal, largest, number, off, proved};
use crate::common::parsed;

const HALF: f64 = 0.5;

/// Where motions end.
const LENGTH: &str = "20";
/// On the way there, and on the way back to the same time before the start: what t_f and velocities are multiplied by.
const WAYS: [f64; 2] = [1.0, -1.0];

/// A particle in |x|: pieces of parabolas that meet at x = 0 with the same speed, on both ways.
#[test]
fn in_the_potential_of_abs_parabolas_follow_each_other() {
    let of_way = |way: f64| {
        largest(|random| {
            let [x, v] = [number(random, 0.5, 2.0), number(random, -1.0, 1.0)];
            let case = parsed(
                &format!(
                    "potential.formula = \"abs(x)\"\nparticle.law = \"newtonian\"\n\
                 initial = {{ x = {x}, x_dot = \"{way}*{v}\" }}\ngrid.t_f = \"{way}*{LENGTH}\"\n\
                 solver.accuracy = 1e-9"
                ),
                &[],
            );
            let [x, v] = [x, v].map(|text| decimal(&text));
            // To x = 0 with the speed w, and from there on ways of 2 w from 0 to 0.
            let w = (v * v + Extended::from(2.0) * x).sqrt();
            let mut left = decimal("20") - (v + w);
            let mut sign = -Extended::ONE;
            while left > Extended::from(2.0) * w {
                left -= Extended::from(2.0) * w;
                sign = -sign;
            }
            off(&proved(&case)?, "x", sign * (w * left - left * left * Extended::from(HALF)))
        })
    };
    for most in WAYS.map(of_way) {
        assert!(most <= 1.0 && most > 1e-6, "{most}");
    }
}

/// A spring with dry friction f, from this start to t = 20, or to −20 with the opposite velocity.
fn with_friction(x: &str, v: &str, f: &str, way: f64) -> Case {
    let text = format!(
        "potential = {{ formula = \"x^2/2\", force = {{ x = \"-{f}*sign(x_dot)\" }} }}\n\
         particle.law = \"newtonian\"\ninitial = {{ x = {x}, x_dot = \"{way}*{v}\" }}\n\
         grid.t_f = \"{way}*{LENGTH}\"\nsolver.accuracy = 1e-9"
    );
    parsed(&text, &[])
}

/// The place of it so long after it has turned at `turn` > f.
fn from_turn(mut turn: Extended, f: Extended, mut left: Extended) -> Extended {
    let mut sign = Extended::ONE;
    while left > Extended::PI {
        left -= Extended::PI;
        turn -= Extended::from(2.0) * f;
        sign = -sign;
    }
    sign * (f + (turn - f) * left.cos())
}

/// A spring with dry friction: half turns about +f and −f, where the velocity changes its sign and x is beyond ±f. On
/// the way back every half turn has what friction takes from it.
#[test]
fn dry_friction_takes_the_same_from_every_half_turn() {
    let of_way = |way: f64| {
        largest(|random| {
            let [x, v, f] = [number(random, 1.0, 2.0), number(random, 0.1, 1.0), number(random, 0.01, 0.05)];
            let case = with_friction(&x, &v, &f, way);
            let [x, v, f] = [x, v, f].map(|text| decimal(&text));
            let f = Extended::from(way) * f;
            // Up to the first turn about −f.
            let radius = ((x + f) * (x + f) + v * v).sqrt();
            let left = decimal("20") - arc_cosine((x + f) / radius);
            off(&proved(&case)?, "x", from_turn(radius - f, f, left))
        })
    };
    for most in WAYS.map(of_way) {
        assert!(most <= 1.0 && most > 1e-6, "{most}");
    }
}

/// From rest the velocity is 0, where friction jumps: the motion leaves to the side to which it is driven on both
/// sides. Where it is held there is no proof.
#[test]
fn a_body_is_released_where_friction_does_not_hold_it() {
    let most = largest(|random| {
        let [x, f] = [number(random, 1.0, 2.0), number(random, 0.01, 0.05)];
        let case = with_friction(&x, "0.0", &f, 1.0);
        let [x, f] = [x, f].map(|text| decimal(&text));
        off(&proved(&case)?, "x", from_turn(x, f, decimal("20")))
    });
    assert!(most <= 1.0 && most > 1e-6, "{most}");
    let held = proved(&with_friction("0.01", "0.0", "0.02", 1.0));
    assert!(held.is_none_or(|proof| proof.ends.is_empty()));
}

/// A pulse of steps in time, and one in space.
#[test]
fn pulses_of_steps_give_their_momentum() {
    let most = largest(|random| {
        let mut of = |least, most| number(random, least, most);
        let [force, begin, long, v] = [of(0.5, 2.0), of(0.3, 1.0), of(0.1, 2.0), of(0.5, 1.0)];
        let case = parsed(
            &format!(
                "particle.law = \"newtonian\"\ninitial = {{ x = 0.0, x_dot = {v} }}\ngrid.t_f = 5.0\n\
                 solver.accuracy = 1e-9\n\
                 force.x = \"{force}*(step(t - {begin}) - step(t - {begin} - {long}))\""
            ),
            &[],
        );
        let [force, begin, long, v] = [force, begin, long, v].map(|text| decimal(&text));
        let behind = decimal("5") - begin - long;
        let pushed = force * long;
        let wanted = v * decimal("5") + pushed * long * Extended::from(HALF) + pushed * behind;
        off(&proved(&case)?, "x", wanted)
    });
    // Parabolas are integrated without an error, and only bounds are left.
    assert!(most <= 1.0, "{most}");
}

/// The second derivatives at the points of a natural cubic spline with one distance, by elimination.
fn bends(y: &[Extended], h: Extended) -> Vec<Extended> {
    let (n, four, six) = (y.len(), Extended::from(4.0), Extended::from(6.0));
    let (mut pivots, mut right) = (vec![four; n], vec![Extended::ZERO; n]);
    for i in 1..n - 1 {
        right[i] = six * (y[i - 1] - y[i] - y[i] + y[i + 1]) / (h * h);
        if i > 1 {
            right[i] = right[i] - right[i - 1] / pivots[i - 1];
            pivots[i] = four - Extended::ONE / pivots[i - 1];
        }
    }
    let mut bends = vec![Extended::ZERO; n];
    for i in (1..n - 1).rev() {
        bends[i] = (right[i] - bends[i + 1]) / pivots[i];
    }
    bends
}

/// A force that was measured at points of time: a spline, whose pieces are polynomials.
#[test]
fn a_force_from_a_table_is_integrated_piece_by_piece() {
    let most = largest(|random| {
        let y: Vec<String> = (0..8).map(|_| number(random, -1.0, 1.0)).collect();
        let v = number(random, 0.5, 1.0);
        let case = parsed(
            &format!(
                "particle.law = \"newtonian\"\ninitial = {{ t = 0.1, x = 0.0, x_dot = {v} }}\ngrid.t_f = 3.3\n\
                 solver.accuracy = 1e-9\nforce.x = \"push(t)\"\n\
                 tables.push = {{ x = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5], y = [{}] }}",
                y.join(", ")
            ),
            &[],
        );
        let y: Vec<Extended> = y.iter().map(|text| decimal(text)).collect();
        let (h, number) = (Extended::from(HALF), |value: f64| Extended::from(value));
        let bends = bends(&y, h);
        let (mut x, mut v, mut u) = (Extended::ZERO, decimal(&v), decimal("0.1"));
        let end = decimal("3.3");
        for i in 0..7 {
            let begin = number(i as f64) * h;
            let b = (y[i + 1] - y[i]) / h - h * (number(2.0) * bends[i] + bends[i + 1]) / number(6.0);
            let (c, d) = (bends[i] / number(2.0), (bends[i + 1] - bends[i]) / (number(6.0) * h));
            // The velocity and the way from the knot, without what was there.
            let speed = |u: Extended| u * (y[i] + u * (b / number(2.0) + u * (c / number(3.0) + u * d / number(4.0))));
            let way = |u: Extended| {
                let inner = b / number(6.0) + u * (c / number(12.0) + u * d / number(20.0));
                u * u * (y[i] / number(2.0) + u * inner)
            };
            let to = if end < begin + h { end - begin } else { h };
            x += (v - speed(u)) * (to - u) + way(to) - way(u);
            v += speed(to) - speed(u);
            u = Extended::ZERO;
        }
        off(&proved(&case)?, "x", x)
    });
    assert!(most <= 1.0, "{most}");
}

/// A floor that gives way: parabolas above it and turns about the place of rest in it.
#[test]
fn a_ball_on_a_stiff_floor_is_where_parabolas_and_turns_are() {
    let most = largest(|random| {
        let [z, k] = [number(random, 0.5, 1.5), number(random, 50.0, 500.0)];
        let case = parsed(
            &format!(
                "potential = {{ coordinates = [\"z\"], formula = \"10*z + {k}/2*max(0, -z)^2\" }}\n\
                 particle.law = \"newtonian\"\ninitial = {{ z = {z}, z_dot = 0.1 }}\ngrid.t_f = 6.0\n\
                 solver.accuracy = 1e-9"
            ),
            &[],
        );
        let [z, k, up, g] = [&z, &k, "0.1", "10"].map(decimal);
        // Down to the floor with the speed w, in it for an angle, and up with the same speed.
        let w = (up * up + Extended::from(2.0) * g * z).sqrt();
        let (omega, rest) = (k.sqrt(), g / k);
        let radius = (rest * rest + w * w / k).sqrt();
        let [flight, inside] =
            [Extended::from(2.0) * w / g, Extended::from(2.0) * (Extended::PI - arc_cosine(rest / radius)) / omega];
        let mut left = decimal("6") - (up + w) / g;
        while left > inside + flight {
            left -= inside + flight;
        }
        let wanted = if left < inside {
            // z = −rest + radius cos(angle), from the angle at which it comes in.
            radius * (arc_cosine(rest / radius) + omega * left).cos() - rest
        } else {
            let time = left - inside;
            w * time - g * time * time * Extended::from(HALF)
        };
        off(&proved(&case)?, "z", wanted)
    });
    assert!(most <= 1.0 && most > 1e-6, "{most}");
}

/// A body that friction stops stays at a surface, and a kink in a kink may jump with it.
#[test]
fn what_stays_at_a_surface_has_no_proof() {
    let reason = |scene: &str| {
        let text = format!("particle.law = \"newtonian\"\nsolver.accuracy = 1e-9\n{scene}");
        let proof = proved(&parsed(&text, &[])).expect("it is solved");
        assert_eq!(proof.status, Status::Unproved, "{scene}");
        proof.reason.unwrap()
    };
    let rest = "initial = { x = 1.0, x_dot = 0.0 }\ngrid.t_f = 1.0\npotential.formula = \"abs(x - 1)\"";
    assert!(reason(rest).contains("a start at which abs, sign, step or a table changes"));
    let inner = "initial = { x = 0.5, x_dot = 1.0 }\ngrid.t_f = 1.0\npotential.formula = \"abs(1 - abs(x))\"";
    assert!(reason(inner).contains("a kink of abs"));
    // No force shows a wall that is so small that no line meets it.
    let wall = "initial = { x = 0.6, y = 0.4, x_dot = 0.0, y_dot = 0.0 }\ngrid.t_f = 3.0\n\
                potential = { coordinates = [\"x\", \"y\"], \
                formula = \"(x^2 + y^2)/2 + 5*step(1e-4 - (x-0.3)^2 - (y-0.2)^2)\" }";
    assert!(reason(wall).contains("a jump of step"));
    // Nor a jump of which factors cancel.
    for jump in ["abs(x)/x", "abs(2*x)/x", "max(x, 2*x)/x", "x/max(x, -x)", "exp(abs(x)/x)", "abs(x)*x^-1"] {
        let text = format!(
            "particle.law = \"newtonian\"\nsolver.accuracy = 1e-9\ninitial = {{ x = -1.0, x_dot = 3.0 }}\n\
             grid.t_f = 0.9\npotential.formula = \"0.1*({jump}) + x^2/2\""
        );
        // Some of them are seen when the case is read.
        let case = Case::parse("case", &text, &[]);
        assert!(
            case.ok().and_then(|case| proved(&case)).is_none_or(|proof| proof.status == Status::Unproved),
            "{jump}"
        );
    }
}
