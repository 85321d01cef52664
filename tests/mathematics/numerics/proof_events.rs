//! Ends of motions at events, proved: of random scenes and formulas against Taylor series in 50 digits, and against
//! closed forms. `PROOF_DRAWS` is the number of draws of each family.

use geodesic_ivp::Case;
use geodesic_ivp::geometry::{Beside, Direction, Geometry, Observable, Place, Start};
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::proof::{Coordinate, Motion, Proof, Reason, Until, Watched, prove, prove_finer};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::solve::{Limit, Setup};
use geodesic_ivp::study::proof::{Status, prove_run};
use geodesic_ivp::study::run::{Judged, Run, Wanted, run};

use super::proof::{number, scenes, template};
use crate::common::parsed;
use crate::random_scenes::random::{self, Random};

const FAMILIES: &str = include_str!("../../../benches/promise/families.txt");
const DIGITS: u32 = 50;
/// An end is looked for at so many places.
const PLACES: usize = 600;

/// A formula that is looked for along a reference.
struct Looked {
    text: String,
    formula: Observable<Extended>,
    direction: Direction,
}

/// One of so many numbers from 0 on.
fn below(random: &mut Random, count: usize) -> usize {
    (random.next() >> 11) as usize % count
}

/// A formula of a random kind that is zero at a state, where `c` is its value without that.
fn drawn(random: &mut Random, names: &[String]) -> String {
    let [one, other] = [(); 2].map(|()| &names[below(random, names.len())]);
    match below(random, 6) {
        0 => one.clone(),
        1 => format!("{one}_dot"),
        2 => format!("p_{one}*{other}"),
        3 => format!("{one}^2 + {other}^2"),
        4 => format!("sin(3*{one} + {other})"),
        _ => format!("{one}_dot*{other} + cos({other})"),
    }
}

impl Looked {
    fn at(&mut self, start: &Start<Extended>, norm: Extended) -> Extended {
        self.formula.at(&start.q, &start.q_dot, &start.p, norm)
    }

    /// The places where a reference says that it is met.
    fn met(&mut self, reference: &ReferenceTrajectory<Extended>, length: Extended, norm: Extended) -> Vec<Extended> {
        let place = |k: usize| length * Extended::from(k as f64) / Extended::from(PLACES as f64);
        let (mut before, mut met) = (self.at(&reference.at(place(0)), norm), Vec::new());
        for k in 1..=PLACES {
            let here = self.at(&reference.at(place(k)), norm);
            let passes = (before < Extended::ZERO) != (here < Extended::ZERO);
            if passes && self.direction.counts(here > Extended::ZERO) {
                let (mut low, mut high) = (place(k - 1), place(k));
                for _ in 0..30 {
                    let middle = Extended::from(0.5) * (low + high);
                    let is_behind = (self.at(&reference.at(middle), norm) < Extended::ZERO) == (here < Extended::ZERO);
                    *(if is_behind { &mut high } else { &mut low }) = middle;
                }
                // By secants each step has half as many digits again, and more.
                let mut values = [low, high].map(|at| self.at(&reference.at(at), norm));
                for _ in 0..8 {
                    let next = high - values[1] * (high - low) / (values[1] - values[0]);
                    if !next.is_finite() || next == high {
                        break;
                    }
                    (low, high) = (high, next);
                    values = [values[1], self.at(&reference.at(high), norm)];
                }
                met.push(high);
            }
            before = here;
        }
        met
    }
}

/// What came of the draws.
#[derive(Default)]
struct Tally {
    draws: usize,
    met: usize,
    passed: usize,
    compared: usize,
    largest: f64,
    refused: Vec<String>,
}

impl Tally {
    fn draw(&mut self, what: &str, template: &str, random: &mut Random) {
        let (text, mut settings, _) = scenes::drawn(template, random);
        let long = settings.iter().position(|setting| setting.contains(".N=")).unwrap();
        let key = settings[long].split('=').next().unwrap().to_owned();
        settings[long] = format!("{key}={}", random.scale(0.3, 6.0));
        settings.push("solver.tolerance=1e-9".to_owned());
        let Ok(case) = Case::parse(what, &text, &settings) else { return };
        let setup: Setup<Extended> = case.setup();
        let Limit::Length(length) = setup.limit else { return };
        let (plain, start) = (&*setup.place.geometry, &*setup.place.start);
        let Ok(reference) = ReferenceTrajectory::new(plain, start, length, DIGITS) else { return };
        let norm = plain.norm(&start.q, &start.q_dot);
        let results = plain.dimension() - usize::from(case.is_lifted());
        let left = drawn(random, &plain.names()[..results]);
        let place = length * Extended::from(random.between(0.05, 0.95));
        let compiled = |text: &str| Observable::new(text, &case.geometry_text, Place::Potential).unwrap();
        let there = reference.at(place);
        let value = compiled(&left).at(&there.q, &there.q_dot, &there.p, norm);
        let direction = [Direction::Up, Direction::Down, Direction::Both][below(random, 3)];
        let text = format!("{left} - ({})", value.to_decimal(30));
        let mut looked = Looked { formula: compiled(&text), text, direction };
        let geometry = Geometry::watching(
            &case.geometry_text,
            Beside { formulas: &[&looked.text], ..Beside::default() },
            norm,
            case.is_backward(),
        )
        .unwrap();
        let [q, q_dot, p] = [&start.q, &start.q_dot, &start.p];
        let (value, off) = looked.formula.enclosed([q, q_dot, p], norm, 1e-60);
        // A formula that is constant is zero all the way.
        if value.abs().to_f64() < 1e-25 {
            return;
        }
        let with = |numbers: &[Extended], one: Extended| [numbers, &[one]].concat();
        let begin = Start { q: with(q, value), q_dot: with(q_dot, Extended::ZERO), p: with(p, Extended::ZERO) };
        let ends = below(random, 2) == 0;
        let watched = [Watched { direction, off, ends }];
        let until = Until::Length(length);
        let samples: Vec<Extended> = [0.0, 0.11, 0.52, 0.9].map(|part| length * Extended::from(part)).to_vec();
        let motion = Motion { watched: &watched, samples: &samples, ..Motion::new(&geometry, &begin, until) };
        let what = format!("{what}: {}, {direction:?}", looked.text);
        let mut met = looked.met(&reference, length, norm);
        let is_ended = ends && !met.is_empty();
        met.truncate(if ends { 1 } else { met.len() });
        let end = if is_ended { met[0] } else { length };
        self.draws += 1;
        for proof in [prove(&motion, &mut |_| true), prove_finer(&motion, &mut |_| true)] {
            self.see(&what, &proof, &reference, (&met, is_ended, end));
            for (found, &place) in proof.samples.iter().zip(&samples) {
                self.compare(&what, found, &reference.at(place), 1e4 * reference.error_estimate());
            }
            let before_end = samples.iter().filter(|place| **place < end).count();
            assert!(proof.end.is_err() || proof.samples.len() >= before_end, "{what}");
        }
    }

    fn see(
        &mut self,
        what: &str,
        proof: &Proof,
        reference: &ReferenceTrajectory<Extended>,
        (met, is_ended, end): (&[Extended], bool, Extended),
    ) {
        let found = match &proof.end {
            Ok(found) => found,
            Err(reason) => return self.refused.push(format!("{what}: {reason} at {}", proof.reached)),
        };
        assert_eq!((proof.ended_by.is_some(), proof.events.len()), (is_ended, met.len()), "{what}");
        *(if met.is_empty() { &mut self.passed } else { &mut self.met }) += 1;
        let own = 1e4 * reference.error_estimate();
        self.compare(what, found, &reference.at(end), own);
        for (event, &place) in proof.events.iter().zip(met) {
            let off = (event.gamma.0 - place).abs().to_f64();
            assert!(
                off <= event.gamma.1 + own * place.to_f64().max(1.0),
                "{what}: gamma {off:e} of {:e}",
                event.gamma.1
            );
            self.compare(what, &event.coordinates, &reference.at(place), own);
        }
    }

    fn compare(&mut self, what: &str, found: &[Coordinate], exact: &Start<Extended>, own: f64) {
        for coordinate in found {
            let exact = exact.q[coordinate.coordinate];
            let off = (coordinate.value - exact).abs().to_f64();
            let of_reference = own * exact.abs().to_f64().max(1.0);
            assert!(off <= coordinate.radius + of_reference, "{what}: {off:e} of {:e}", coordinate.radius);
            self.compared += 1;
            if coordinate.radius > of_reference {
                self.largest = self.largest.max(off / coordinate.radius);
            }
        }
    }
}

#[test]
fn no_end_at_an_event_of_a_random_motion_is_outside_of_its_radius() {
    let draws = std::env::var("PROOF_DRAWS").ok().and_then(|text| text.parse().ok()).unwrap_or(1);
    let (mut random, mut tally) = (random::Random(761), Tally::default());
    for (name, template) in template::families(FAMILIES) {
        (0..draws).for_each(|draw| tally.draw(&format!("{name} {draw}"), template, &mut random));
    }
    let Tally { draws, met, passed, compared, largest, refused } = tally;
    println!(
        "{draws} draws: {met} proofs with events, {passed} without, {compared} compared, {largest:.2} of a radius"
    );
    println!("refused:\n{}", refused.join("\n"));
    assert!(met > draws / 2 && compared > 40 && largest > 1e-6, "{met} {compared} {largest}");
    // Each draw is proved twice. A formula may be drawn at a place where it nearly turns.
    assert!(refused.len() as f64 <= 0.2 * 2.0 * draws as f64, "{}", refused.join("\n"));
}

/// A run with its proof.
fn judged(case: &Case) -> (Run, Judged) {
    let run = run::<f64>(case, &case.setup(), Wanted::default()).0.unwrap_or_else(|none| panic!("{none:?}"));
    let mut judged = run.judged(&case.setup(), false, false);
    prove_run(case, &run, &mut judged, f64::INFINITY, &mut |_| true);
    (run, judged)
}

fn oscillator(rest: &str) -> Case {
    parsed(
        &format!(
            "particle.law = \"newtonian\"\npotential.formula = \"x^2/2\"\ninitial = {{ x = 1.0, x_dot = 0.0 }}\n\
             grid.t_f = 20.0\nsolver.accuracy = 1e-9\n{rest}"
        ),
        &[],
    )
}

/// x = cos t.
#[test]
fn ends_at_events_are_those_of_closed_forms() {
    let pi = Extended::PI;
    let third = |k: f64| pi * Extended::from(k) / Extended::from(3.0);
    for (rest, ended_by, time) in [
        ("grid.until = \"x - 0.5\"", Some("grid.until"), third(1.0)),
        ("events.up = { when = \"x - 0.5\", direction = \"up\", until = true }", Some("up"), third(5.0)),
        ("events.down = { when = \"x + 0.5\", direction = \"down\", until = true }", Some("down"), third(2.0)),
        // It begins with the velocity 0, and leaves it.
        ("events.turn = { when = \"x_dot\", until = true }", Some("turn"), third(3.0)),
        ("events.top = { when = \"x_dot\", until = true, direction = \"down\" }", Some("top"), third(6.0)),
        // In time, in a function of it, in a momentum; and what never happens.
        ("events.late = { when = \"t - 3.25\", until = true }", Some("late"), number("3.25")),
        ("events.half = { when = \"sin(t/2) - 0.5\", until = true }", Some("half"), third(1.0)),
        ("events.fast = { when = \"x_dot + 0.5\", until = true }", Some("fast"), third(0.5)),
        ("events.never = { when = \"x - 1.5\", until = true }", None, number("20")),
        // The first of two.
        (
            "events.one = { when = \"x + 0.5\", until = true }\nevents.two = { when = \"x - 0.5\", until = true }",
            Some("two"),
            third(1.0),
        ),
    ] {
        let case = oscillator(rest);
        let (run, judged) = judged(&case);
        let proof = judged.proof.as_ref().unwrap_or_else(|| panic!("{rest}"));
        assert_eq!((proof.status, proof.ended_by.as_deref()), (Status::Proved, ended_by), "{rest}: {:?}", proof.reason);
        let end = |name: &str| proof.ends.iter().find(|end| end.name == name).unwrap();
        for (name, exact) in [("x", Real::cos(time)), ("t", time)] {
            let Some(end) = proof.ends.iter().find(|end| end.name == name) else { continue };
            let off = (number(&end.end) - exact).abs().to_f64();
            assert!(off <= end.radius && end.radius < 1e-18, "{rest}: {name} {off:e} of {:e}", end.radius);
        }
        assert!((end("t").run_off_by) < 1e-9 && run.line.ended_by.is_some() == ended_by.is_some(), "{rest}");
    }
}

/// x touches −1 and 1, and passes both places of two events at one time.
#[test]
fn what_is_grazed_or_met_together_is_not_proved() {
    for (rest, reason) in [
        ("grid.until = \"x + 1\"", Reason::Grazed),
        // It is 0 all the way.
        ("grid.until = \"x^2 + x_dot^2 - 1\"", Reason::Grazed),
        (
            "events.a = { when = \"x - 0.5\", until = true }\nevents.b = { when = \"2*x - 1\", until = true }",
            Reason::Together,
        ),
    ] {
        let (_, judged) = judged(&oscillator(rest));
        let proof = judged.proof.unwrap();
        assert_eq!((proof.status, proof.reason), (Status::Unproved, Some(reason.to_string())), "{rest}");
    }
}
