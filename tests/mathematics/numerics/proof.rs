//! Ends of random motions, proved, against Taylor series in 50 digits: none is outside of its radius.
//!
//! The scenes are those of the bench `promise`. `PROOF_DRAWS` is the number of draws of each family.

use geodesic_ivp::Case;
use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::proof::{Motion, Proof, Until, prove};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::solve::{Limit, Setup};

use crate::random_scenes::random;

#[path = "../../../benches/promise/scenes.rs"]
mod scenes;
#[path = "../../../benches/promise/template.rs"]
mod template;

const FAMILIES: &str = include_str!("../../../benches/promise/families.txt");
const DIGITS: u32 = 50;

/// What came of the draws.
#[derive(Default)]
struct Tally {
    compared: usize,
    largest: f64,
    refused: Vec<String>,
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
}

fn proved(geometry: &Geometry<Extended>, start: &Start<Extended>, until: Until) -> Proof {
    prove(&Motion { geometry, start, unused: None, until }, &mut |_| true)
}

#[test]
fn no_end_of_a_random_motion_is_outside_of_its_radius() {
    let draws = std::env::var("PROOF_DRAWS").ok().and_then(|text| text.parse().ok()).unwrap_or(1);
    let (mut random, mut tally) = (random::Random(75), Tally::default());
    for (name, template) in template::families(FAMILIES) {
        for draw in 0..draws {
            let (text, mut settings, _) = scenes::drawn(template, &mut random);
            let long = settings.iter().position(|setting| setting.contains(".N=")).unwrap();
            let key = settings[long].split('=').next().unwrap().to_owned();
            settings[long] = format!("{key}={}", random.scale(0.3, 6.0));
            settings.push("solver.tolerance=1e-9".to_owned());
            let Ok(case) = Case::parse(name, &text, &settings) else { continue };
            let setup: Setup<Extended> = case.setup();
            let Limit::Length(length) = setup.limit else { continue };
            let (geometry, start) = (&*setup.place.geometry, &*setup.place.start);
            let Ok(reference) = ReferenceTrajectory::new(geometry, start, length, DIGITS) else { continue };
            let (what, own) = (format!("{name} {draw}"), reference.error_estimate());
            let proof = proved(geometry, start, Until::Length(length));
            tally.see(&what, &proof, &reference.at(length), own);
            // Where time is a coordinate, also at a time on the way.
            let time = reference.at(length * Extended::from(0.7)).q[0];
            let has_time = geometry.names()[0] == "t" && proof.end.is_ok();
            if has_time && let Ok(until) = ReferenceTrajectory::length_of(geometry, start, 0, time, DIGITS) {
                let proof = proved(geometry, start, Until::Value(0, time));
                tally.see(&format!("{what} to t"), &proof, &reference.at(until), own);
            }
        }
    }
    let Tally { compared, largest, refused } = tally;
    println!("{compared} ends, {largest:.2} of a radius; {} refused:\n{}", refused.len(), refused.join("\n"));
    assert!(compared > 40 && largest > 1e-6, "{compared} {largest}");
}
