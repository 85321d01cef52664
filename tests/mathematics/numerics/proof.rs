//! Ends of motions, proved: of random ones against Taylor series in 50 digits and against proofs in windows of half the
//! length, and of those that have one against a closed form. None is outside of its radius.
//!
//! Random scenes are those of the bench `promise`. `PROOF_DRAWS` is the number of draws of each family.

use geodesic_ivp::Case;
use geodesic_ivp::geometry::Start;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::proof::{Motion, Proof, Until, prove, prove_finer};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::solve::{Limit, Setup};

use crate::random_scenes::random;

#[path = "../../../benches/promise/scenes.rs"]
pub(super) mod scenes;
#[path = "../../../benches/promise/template.rs"]
pub(super) mod template;

const FAMILIES: &str = include_str!("../../../benches/promise/families.txt");
const DIGITS: u32 = 50;

/// What came of the draws.
#[derive(Default)]
struct Tally {
    draws: usize,
    proved: usize,
    compared: usize,
    largest: f64,
    with_finer: usize,
    /// The largest distance of two proofs beside the sum of their radii.
    largest_of_finer: f64,
    refused: Vec<String>,
    /// Draws that are no case, or have no reference.
    others: Vec<String>,
}

impl Tally {
    /// Compares ends with those of a reference.
    fn see(&mut self, what: &str, proof: &Proof, end: &Start<Extended>, own: f64) {
        let found = match &proof.end {
            Ok(found) => found,
            Err(reason) => return self.refused.push(format!("{what}: {reason} at {}", proof.reached)),
        };
        for coordinate in found {
            let exact = end.q[coordinate.coordinate];
            let off = (coordinate.value - exact).abs().to_f64();
            // The reference is off, too, and rounds its own end.
            let of_reference = 1e3 * own * exact.abs().to_f64().max(1.0);
            assert!(off <= coordinate.radius + of_reference, "{what}: {off:e} of {:e}", coordinate.radius);
            self.compared += 1;
            if coordinate.radius > of_reference {
                self.largest = self.largest.max(off / coordinate.radius);
            }
        }
    }

    /// Two proofs of one motion say nothing that both cannot be.
    fn see_finer(&mut self, what: &str, proof: &Proof, finer: &Proof) {
        let (Ok(found), Ok(finer)) = (&proof.end, &finer.end) else { return };
        for (one, other) in found.iter().zip(finer) {
            let off = (one.value - other.value).abs().to_f64();
            let together = one.radius + other.radius;
            assert!(off <= together, "{what}: {off:e} of {:e} + {:e}", one.radius, other.radius);
            self.with_finer += 1;
            self.largest_of_finer = self.largest_of_finer.max(off / together.max(f64::MIN_POSITIVE));
        }
    }

    /// Compares the proof of an end with that of a reference and with a finer proof.
    fn compare(&mut self, what: &str, motion: &Motion<'_>, end: &Start<Extended>, own: f64) -> bool {
        let proof = prove(motion, &mut |_| true);
        self.see(what, &proof, end, own);
        self.see_finer(what, &proof, &prove_finer(motion, &mut |_| true));
        proof.end.is_ok()
    }

    /// Draws a scene of a family, proves where it ends, and compares that.
    fn draw(&mut self, what: &str, template: &str, random: &mut random::Random) {
        let (text, mut settings, _) = scenes::drawn(template, random);
        let long = settings.iter().position(|setting| setting.contains(".N=")).unwrap();
        let key = settings[long].split('=').next().unwrap().to_owned();
        settings[long] = format!("{key}={}", random.scale(0.3, 6.0));
        settings.push("solver.tolerance=1e-9".to_owned());
        let Ok(case) = Case::parse(what, &text, &settings) else { return self.others.push(format!("{what}: no case")) };
        let setup: Setup<Extended> = case.setup();
        let Limit::Length(length) = setup.limit else { return self.others.push(format!("{what}: no length")) };
        let (geometry, start) = (&*setup.place.geometry, &*setup.place.start);
        let Ok(reference) = ReferenceTrajectory::new(geometry, start, length, DIGITS) else {
            return self.others.push(format!("{what}: no reference"));
        };
        let own = reference.error_estimate();
        let motion = Motion::new(geometry, start, Until::Length(length));
        let is_proved = self.compare(what, &motion, &reference.at(length), own);
        self.draws += 1;
        self.proved += usize::from(is_proved);
        // Where time is a coordinate, also at a time on the way.
        let time = reference.at(length * Extended::from(0.7)).q[0];
        let has_time = geometry.names()[0] == "t" && is_proved;
        if has_time && let Ok(until) = ReferenceTrajectory::length_of(geometry, start, 0, time, DIGITS) {
            let motion = Motion { until: Until::Value(0, time), ..motion };
            self.compare(&format!("{what} to t"), &motion, &reference.at(until), own);
        }
    }
}

#[test]
fn no_end_of_a_random_motion_is_outside_of_its_radius() {
    let draws = std::env::var("PROOF_DRAWS").ok().and_then(|text| text.parse().ok()).unwrap_or(1);
    let (mut random, mut tally) = (random::Random(75), Tally::default());
    for (name, template) in template::families(FAMILIES) {
        (0..draws).for_each(|draw| tally.draw(&format!("{name} {draw}"), template, &mut random));
    }
    let Tally { draws, proved, compared, largest, with_finer, largest_of_finer, refused, others } = tally;
    println!("{proved} of {draws} draws are proved, {compared} ends compared, {largest:.2} of a radius");
    println!("{with_finer} ends compared with finer proofs, {largest_of_finer:.2} of both radii");
    println!("refused:\n{}\nnot drawn:\n{}", refused.join("\n"), others.join("\n"));
    assert!(compared > 40 && largest > 1e-6, "{compared} {largest}");
    assert!(with_finer > 40 && largest_of_finer > 1e-6, "{with_finer} {largest_of_finer}");
    assert!(proved as f64 >= 0.9 * draws as f64, "{proved} of {draws}");
}

/// The proved end of a coordinate of a case that begins at 0 where nothing depends on it, and its radius.
pub(super) fn end_of(text: &str, name: &str) -> (Extended, f64) {
    let case = Case::parse("case", text, &[]).unwrap_or_else(|error| panic!("{error}"));
    let setup: Setup<Extended> = case.setup();
    let geometry = &*setup.place.geometry;
    let unused = case.is_lifted().then(|| setup.place.start.q.len() - 1);
    let until = match setup.limit {
        Limit::Length(length) => Until::Length(length),
        Limit::Value { coordinate, value } => Until::Value(coordinate, value),
    };
    let proof = prove(&Motion { unused, ..Motion::new(geometry, &setup.place.start, until) }, &mut |_| true);
    let a = geometry.names().iter().position(|own| own == name).unwrap();
    let end = proof.end.unwrap_or_else(|reason| panic!("{text}: {reason} at {}", proof.reached));
    let found = end.iter().find(|found| found.coordinate == a).unwrap();
    (found.value, found.radius)
}

/// Asserts that a closed form is within a radius below `most`.
#[track_caller]
pub(super) fn is_proved(text: &str, name: &str, exact: Extended, most: f64) {
    let (value, radius) = end_of(text, name);
    let off = (value - exact).abs().to_f64();
    println!("{name} = {}, {off:.1e} of {radius:.1e}", value.to_decimal(25));
    assert!(off <= radius && radius < most, "{text}: {name} = {}, {off:e} of {radius:e}", value.to_decimal(30));
}

pub(super) fn number(text: &str) -> Extended {
    Extended::from_decimal(text).unwrap()
}

fn cos(x: Extended) -> Extended {
    Real::cos(x)
}

pub(super) fn newtonian(length: impl std::fmt::Display, coordinates: &str, rest: &str) -> String {
    format!(
        "particle.law = \"newtonian\"\ngrid.gamma_f = {length}\nsolver.accuracy = 1e-8\n\
         potential.coordinates = [{coordinates}]\n{rest}"
    )
}

/// Nothing has a size at the start: coordinates, velocities and forces are 0.
#[test]
fn what_begins_from_rest_is_proved() {
    let (one, two) = (Extended::ONE, Extended::from(2.0));
    // ẍ = −x + 1 − cos 3t.
    let text = "potential.formula = \"x^2/2\"\npotential.force.x = \"1 - cos(3*t)\"\ninitial = { x = 0, x_dot = 0 }";
    let (t, c) = (Extended::from(30.0), cos(Extended::from(30.0)));
    let exact = one - c + (cos(Extended::from(90.0)) - c) / Extended::from(8.0);
    is_proved(&newtonian(30, "\"x\"", text), "x", exact, 1e-19);
    // 2ÿ = −y + 1 − cos 3x with x = t.
    let text = "particle.masses = { x = 1, y = 2 }\npotential.formula = \"y^2/2\"\npotential.force.y = \
                \"1 - cos(3*x)\"\ninitial = { x = 0, y = 0, x_dot = 1, y_dot = 0 }";
    let seventeenth = one / Extended::from(17.0);
    let slow = (one + seventeenth) * cos(t / two.sqrt());
    let exact = one + seventeenth * cos(Extended::from(90.0)) - slow;
    is_proved(&newtonian(30, "\"x\", \"y\"", text), "y", exact, 1e-18);
    // A pulse, which comes out of what is below the range of numbers: all of its tails are within 1e-1000.
    let text = "potential.formula = \"0\"\npotential.force.x = \"5*exp(-((t - 11.3)/0.1)^2)\"\n\
                initial = { x = 0, x_dot = 0 }";
    let exact = number("0.5") * <Extended as Real>::PI.sqrt() * number("18.7");
    is_proved(&newtonian(30, "\"x\"", text), "x", exact, 1e-24);
}

/// ẍ = −x + sin²(πt/100) cos 1.1t is driven by three tones.
#[test]
fn a_driven_motion_is_proved_until_a_time() {
    let text = "particle.law = \"newtonian\"\ninitial = { x = 0, x_dot = 0 }\ngrid.t_f = 100\n\
                solver.accuracy = 1e-8\nforce.x = \"-x + sin(pi*t/100)^2*cos(1.1*t)\"";
    let (t, tone) = (Extended::from(100.0), <Extended as Real>::PI / Extended::from(50.0));
    let answer = |w: Extended| (cos(w * t) - cos(t)) / (Extended::ONE - w * w);
    let beats = answer(number("1.1") + tone) + answer(number("1.1") - tone);
    is_proved(text, "x", answer(number("1.1")).half() - beats.half().half(), 1e-17);
}

/// A hill that is a high power is the same as one that is written with exp and ln.
#[test]
fn a_high_power_is_proved() {
    let rest = |formula: &str| format!("potential.formula = \"{formula}\"\ninitial = {{ x = 0, x_dot = 1 }}");
    let [(one, of_one), (other, of_other)] = ["1/(1 + (x - 15)^2)^40", "exp(-40*ln(1 + (x - 15)^2))"]
        .map(|formula| end_of(&newtonian(30, "\"x\"", &rest(formula)), "x"));
    assert!((one - other).abs().to_f64() <= of_one + of_other && of_one < 1e-15 && of_other < 1e-15);
    assert!((one.to_f64() + 0.040_746_2).abs() < 1e-7, "{}", one.to_decimal(20));
}

/// Powers of powers have exponents beyond the range of those that a power may have: (1 + x/n)^n is nearly exp x, and no
/// power of another exponent.
#[test]
fn powers_of_powers_are_what_they_say() {
    let rest = |formula: &str| format!("potential.formula = \"-({formula})/10\"\ninitial = {{ x = 0, x_dot = 1 }}");
    for (a, b) in [(65_536_u64, 65_536), (65_536, 65_537), (131_072, 65_536), (46_341, 46_341)] {
        let n = a * b;
        let [(one, of_one), (other, of_other)] = [format!("((1 + x/{n})^{a})^{b}"), format!("exp({n}*ln(1 + x/{n}))")]
            .map(|formula| end_of(&newtonian(1, "\"x\"", &rest(&formula)), "x"));
        let off = (one - other).abs().to_f64();
        assert!(off <= of_one + of_other && of_one < 1e-15 && of_other < 1e-15, "{a} {b}: {off:e} {of_one:e}");
    }
}

/// In a plane wave A_y = 5 cos(t − z) an electron that is met at rest keeps t − z = γ, so that ẏ = 5 (cos γ − 1) and
/// ż = ẏ²/2.
#[test]
fn where_errors_of_coordinates_cancel_all_are_proved() {
    let text = "initial = { t = 0, y = 0, z = 0, y_dot = 0, z_dot = 0, \
                norm = \"timelike\", solve = { t_dot = \"+\" } }\n\
                grid.gamma_f = 40\nsolver.accuracy = 1e-4\n[metric]\ncoordinates = [\"t\", \"y\", \"z\"]\n\
                components = { \"t t\" = \"1\", \"y y\" = \"-1\", \"z z\" = \"-1\" }\n\
                one_form = { y = \"5*cos(t - z)\" }";
    let (g, sin) = (Extended::from(40.0), |x: f64| <Extended as Real>::sin(Extended::from(x)));
    is_proved(text, "y", Extended::from(5.0) * (sin(40.0) - g), 1e-13);
    let z = number("12.5") * (number("1.5") * g - Extended::from(2.0) * sin(40.0) + number("0.25") * sin(80.0));
    is_proved(text, "z", z, 1e-12);
    is_proved(text, "t", z + g, 1e-12);
}

/// An orbit in a plane of space is that of the plane, and stays there.
#[test]
fn what_does_not_move_is_proved() {
    let text = |names: &str, start: &str, formula: &str| {
        newtonian(20, names, &format!("potential.formula = \"{formula}\"\ninitial = {{ {start} }}"))
    };
    let plane = "x = 1, y = 0, x_dot = 0, y_dot = 1.1";
    let [flat, space] = [
        text("\"x\", \"y\"", plane, "-1/sqrt(x^2 + y^2)"),
        text("\"x\", \"y\", \"z\"", &format!("{plane}, z = 0, z_dot = 0"), "-1/sqrt(x^2 + y^2 + z^2)"),
    ];
    for name in ["x", "y"] {
        let [(one, of_one), (other, of_other)] = [&flat, &space].map(|text| end_of(text, name));
        assert!((one - other).abs().to_f64() <= of_one + of_other && of_other < 1e-18, "{name}: {of_other:e}");
    }
    is_proved(&space, "z", Extended::ZERO, 1e-20);
}
