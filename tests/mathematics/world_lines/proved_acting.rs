//! Proofs through events that act, against closed forms in 70 digits.

use geodesic_ivp::Case;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::study::proof::{ProofOfRun, Status, prove_run};
use geodesic_ivp::study::run::{Wanted, run};

use crate::common::parsed;
use crate::random_scenes::random::Random;

/// So many draws of each family.
const DRAWS: u64 = 40;

pub(super) fn decimal(text: &str) -> Extended {
    Extended::from_decimal(text).unwrap()
}

pub(super) fn number(random: &mut Random, least: f64, most: f64) -> String {
    format!("{:.4}", random.between(least, most))
}

/// The proof of a run; `None` where the run is refused.
pub(super) fn proved(case: &Case) -> Option<ProofOfRun> {
    let setup = case.setup();
    let run = run::<f64>(case, &setup, Wanted::default()).0.ok()?;
    let mut judged = run.judged(&setup, false, false);
    prove_run(case, &run, &mut judged, f64::INFINITY, &mut |_| true);
    judged.proof
}

/// How far a coordinate is from the true one, in radii; `None` without a proof.
pub(super) fn off(proof: &ProofOfRun, name: &str, wanted: Extended) -> Option<f64> {
    let end = proof.ends.iter().find(|end| end.name == name)?;
    assert!(end.radius < 1e-12, "{end:?}");
    Some((decimal(&end.end) - wanted).abs().to_f64() / end.radius)
}

/// The largest of some draws, of which most have to be proved.
pub(super) fn largest(off: impl Fn(&mut Random) -> Option<f64>) -> f64 {
    let found: Vec<f64> = (0..DRAWS).filter_map(|draw| off(&mut Random(7000 + 64 * draw))).collect();
    assert!(found.len() as f64 > 0.8 * DRAWS as f64, "{} proved", found.len());
    found.into_iter().fold(0.0, f64::max)
}

/// A ball that loses a part of both velocities whenever it meets the floor: pieces of parabolas.
#[test]
fn a_ball_that_bounces_is_where_parabolas_are() {
    let most = largest(|random| {
        let mut of = |least, most| number(random, least, most);
        let [z, vz, vx, e, f] = [of(0.6, 2.0), of(-1.0, 1.0), of(0.5, 1.5), of(0.82, 0.99), of(0.6, 1.1)];
        let case = parsed(
            &format!(
                "potential = {{ coordinates = [\"x\", \"z\"], formula = \"9.81*z\" }}\nparticle.law = \"newtonian\"\n\
                 initial = {{ x = 0.0, z = {z}, x_dot = {vx}, z_dot = {vz} }}\ngrid.t_f = 2.5\n\
                 solver.accuracy = 1e-9\n[events]\n\
                 floor = {{ when = \"z\", direction = \"down\", \
                 set = {{ x_dot = \"{f}*x_dot\", z_dot = \"-{e}*z_dot\" }} }}"
            ),
            &[],
        );
        let [mut z, mut vz, mut vx, e, f] = [z, vz, vx, e, f].map(|text| decimal(&text));
        let (mut x, mut left, g) = (Extended::ZERO, decimal("2.5"), decimal("9.81"));
        loop {
            let next = (vz + (vz * vz + Extended::from(2.0) * g * z).sqrt()) / g;
            let time = if next < left { next } else { left };
            x += vx * time;
            z += vz * time - g * time * time * Extended::from(0.5);
            left -= time;
            if left <= Extended::ZERO {
                break;
            }
            (vx, vz, z) = (f * vx, e * (g * time - vz), Extended::ZERO);
        }
        let proof = proved(&case)?;
        Some(off(&proof, "x", x)?.max(off(&proof, "z", z)?))
    });
    assert!(most <= 1.0 && most > 1e-6, "{most}");
}

/// An oscillator with a wall, between whose blows it goes on by an angle.
#[test]
fn an_oscillator_at_a_wall_is_where_its_angle_says() {
    let most = largest(|random| {
        let mut of = |least, most| number(random, least, most);
        let [start, wall, e] = [of(-2.0, -1.0), of(-0.3, 0.9), of(0.8, 1.0)];
        let case = parsed(
            &format!(
                "potential.formula = \"x^2/2\"\nparticle.law = \"newtonian\"\n\
                 initial = {{ x = {start}, x_dot = 0.0 }}\n\
                 grid.t_f = 20.0\nsolver.accuracy = 1e-9\n[events]\n\
                 wall = {{ when = \"x - ({wall})\", direction = \"up\", set = {{ x_dot = \"-{e}*x_dot\" }} }}"
            ),
            &[],
        );
        let [mut x, wall, e] = [start, wall, e].map(|text| decimal(&text));
        let (mut v, mut left) = (Extended::ZERO, decimal("20"));
        loop {
            // x = R cos(angle + t) is at the wall, on its way up, at the angle 2π − acos(wall/R).
            let radius = (x * x + v * v).sqrt();
            let [angle, of_wall] = [x, wall].map(|x| arc_cosine(x / radius));
            let angle = if v > Extended::ZERO { -angle } else { angle };
            let full = Extended::from(2.0) * Extended::PI;
            let next = if radius > wall.abs() { full - of_wall - angle } else { left };
            let time = if next < left { next } else { left };
            x = radius * (angle + time).cos();
            left -= time;
            if left <= Extended::ZERO {
                break;
            }
            (x, v) = (wall, -e * (radius * radius - wall * wall).sqrt());
        }
        off(&proved(&case)?, "x", x)
    });
    assert!(most <= 1.0 && most > 1e-6, "{most}");
}

/// By Newton's method from the double.
pub(super) fn arc_cosine(x: Extended) -> Extended {
    let clamped = x.to_f64().clamp(-1.0, 1.0);
    if x.abs() >= Extended::ONE {
        return Extended::from(clamped.acos().round() / std::f64::consts::PI.round()) * Extended::PI;
    }
    let mut angle = Extended::from(clamped.acos());
    for _ in 0..6 {
        angle += (angle.cos() - x) / angle.sin();
    }
    angle
}

/// A floor that moves: the formula of the event and what it sets depend on time and velocity.
#[test]
fn a_ball_on_a_floor_that_moves_is_where_parabolas_are() {
    let most = largest(|random| {
        let mut of = |least, most| number(random, least, most);
        let [z, a, w, e] = [of(0.8, 1.5), of(0.02, 0.1), of(2.0, 6.0), of(0.6, 0.9)];
        let case = parsed(
            &format!(
                "potential = {{ coordinates = [\"z\"], formula = \"9.81*z\" }}\nparticle.law = \"newtonian\"\n\
                 parameters = {{ a = {a}, w = {w}, e = {e} }}\ninitial = {{ z = {z}, z_dot = 0.0 }}\n\
                 grid.t_f = 2.0\nsolver.accuracy = 1e-9\n[events]\nfloor = {{ when = \"z - a*sin(w*t)\", \
                 direction = \"down\", set = {{ z_dot = \"-e*z_dot + (1 + e)*a*w*cos(w*t)\" }} }}"
            ),
            &[],
        );
        let [mut z, a, w, e] = [z, a, w, e].map(|text| decimal(&text));
        let (mut v, mut now, end, g) = (Extended::ZERO, Extended::ZERO, decimal("2"), decimal("9.81"));
        let half = Extended::from(0.5);
        loop {
            let at = |time: Extended| z + v * time - g * time * time * half;
            let gap = |time: Extended| at(time) - a * (w * (now + time)).sin();
            let rate = |time: Extended| v - g * time - a * w * (w * (now + time)).cos();
            let step = Extended::from(1e-3);
            let mut time = step;
            while now + time < end && gap(time) > Extended::ZERO {
                time += step;
            }
            for _ in 0..8 {
                time -= gap(time) / rate(time);
            }
            let is_met = gap(time).abs() < Extended::from(1e-50) && time > step * half;
            if !is_met || now + time >= end {
                z = at(end - now);
                break;
            }
            let before = v - g * time;
            z = at(time);
            now += time;
            v = (Extended::ONE + e) * a * w * (w * now).cos() - e * before;
        }
        off(&proved(&case)?, "z", z)
    });
    assert!(most <= 1.0 && most > 1e-6, "{most}");
}

/// The circle to which a kick turns an ellipse, through two events that change both momenta.
#[test]
fn a_kick_leads_to_the_circle() {
    let case = geodesic_ivp::case::builtin::text("kick").expect("it is built in");
    let proof = proved(&parsed(case, &[])).expect("it is solved");
    assert_eq!(proof.status, Status::Proved, "{proof:?}");
    let of = |name: &str, wanted: f64| off(&proof, name, Extended::from(wanted)).unwrap();
    assert!(of("x", 0.0) <= 1.0 && of("y", -4.0) <= 1.0, "{proof:?}");
}

/// What has no proof says why.
#[test]
fn two_walls_at_one_place_have_no_proof() {
    let reason = |events: &str| {
        let text = format!(
            "potential = {{ coordinates = [\"x\", \"z\"], formula = \"g*z\" }}\nparticle.law = \"newtonian\"\n\
             initial = {{ x = 0.0, z = 1.0, x_dot = 1.0, z_dot = 0.0 }}\ngrid.t_f = 0.8\nsolver.accuracy = 1e-9\n\
             parameters.g = 9.81\n[events]\n{events}"
        );
        let proof = proved(&parsed(&text, &[])).expect("it is solved");
        assert_eq!(proof.status, Status::Unproved);
        proof.reason.unwrap()
    };
    let floor = "floor = { when = \"z\", direction = \"down\", set = { z_dot = \"-z_dot\" } }";
    let other = "other = { when = \"2*z\", direction = \"down\", set = { x_dot = \"-x_dot\" } }";
    assert!(reason(&format!("{floor}\n{other}")).contains("too close together"));
    // What an event leaves at 0, up to rounding, may be met again.
    let heavier = "heavier = { when = \"z + z_dot\", set = { g = \"1\" } }";
    assert!(reason(heavier).contains("another formula is 0"));
}

/// The derivative of a formula does not show where it jumps: it is met there, and its rate is 0 on both sides.
#[test]
fn formulas_that_jump_are_met_by_no_proof() {
    let reason = |event: &str| {
        let text = format!(
            "potential = {{ coordinates = [\"x\", \"z\"], formula = \"10*z\" }}\nparticle.law = \"newtonian\"\n\
             initial = {{ x = 0.0, z = 1.0, x_dot = 1.0, z_dot = 0.0 }}\ngrid.t_f = 2.0\nsolver.accuracy = 1e-9\n\
             [events]\nfloor = {event}"
        );
        proved(&parsed(&text, &[])).expect("it is solved").reason
    };
    let set = "direction = \"down\", set = { z_dot = \"-0.9*z_dot\" } }";
    let jumps = Some("an event whose formula may jump".to_owned());
    assert_eq!(reason(&format!("{{ when = \"z + 0.5*step(x - 0.2)\", {set}")), jumps);
    assert_eq!(reason("{ when = \"z + 1e-12*step(x - 0.2)\", until = true }"), jumps);
    assert_eq!(reason("{ when = \"step(x - 0.7)*step(0.7 + 1e-15 - x) - 0.5\", until = true }"), jumps);
    assert_eq!(reason("{ when = \"z + 0.01*atan(1/(x - 0.3))\", until = true }"), jumps);
    assert_eq!(reason("{ when = \"atan(tan(4*x)) + 0.05\", until = true }"), jumps);
    assert_eq!(reason("{ when = \"max(x - 0.5, 2*x - 1)*(x - 0.5)^-1 - 1.5\", until = true }"), jumps);
    // What is continuous has a proof, where it is smooth, and what is only looked for leaves that of the end.
    assert_eq!(reason(&format!("{{ when = \"z + 0*max(x, -1)\", {set}")), None);
    assert_eq!(reason("{ when = \"z*step(z) + 2\", until = true }"), Some("a jump of step".to_owned()));
    assert_eq!(reason("{ when = \"sign(z)\" }"), None);
}
