//! What stands between two nodes is met, wherever it is and however narrow: pulses of steps, hats of kinks and hills
//! that are high powers. A particle of mass 1 flies at them with the speed 1, and where it is after 30 units of time is
//! known in closed form or from short steps.

use std::sync::Arc;

use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::methods::{Output, Peer, Problem, Setting};
use geodesic_ivp::solve::WorldLine;

use crate::common::{line_of, parsed};

const LENGTH: f64 = 30.0;
const ACCURACY: f64 = 1e-8;

fn flight(formula: &str, force: &str) -> WorldLine {
    flight_to(formula, force, ACCURACY)
}

fn flight_to(formula: &str, force: &str, accuracy: f64) -> WorldLine {
    let force = if force.is_empty() { String::new() } else { format!(", force = {{ x = \"{force}\" }}") };
    line_of(&parsed(
        &format!(
            "potential = {{ coordinates = [\"x\"], formula = \"{formula}\"{force} }}\nparticle.law = \"newtonian\"\n\
             initial = {{ x = 0.0, x_dot = 1.0 }}\ngrid.gamma_f = {LENGTH:?}\nsolver.accuracy = {accuracy:e}\n"
        ),
        &[],
    ))
}

/// The run ends at x, as accurate as asked for, and knows that it has looked everywhere.
fn assert_ends_at(line: &WorldLine, x: f64, what: &str) {
    let off = (line.end().q[1] - x).abs() / x.abs().max(1.0);
    assert!(off <= ACCURACY, "{what}: {off:e}");
    assert_eq!(line.windows_unproved, Some(0), "{what}");
}

/// Numbers that look random.
struct Random(u64);

impl Random {
    fn between(&mut self, least: f64, most: f64) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        least + (most - least) * (self.0 >> 11) as f64 / 2.0_f64.powi(53)
    }

    /// All sizes are equally frequent.
    fn scale(&mut self, least: f64, most: f64) -> f64 {
        self.between(least.ln(), most.ln()).exp()
    }
}

#[test]
fn pulses_of_steps_push() {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    for _ in 0..60 {
        let (from, width) = (random.between(1.0, 25.0), random.scale(1e-6, 2.0));
        let (to, push) = (from + width, random.between(-0.5, 0.5));
        let force = push / (to - from);
        let line = flight("0", &format!("{force:?}*step(t - {from:?})*step({to:?} - t)"));
        let x = LENGTH + push * (LENGTH - 0.5 * (from + to));
        assert_ends_at(&line, x, &format!("{force:e} from {from} for {width:e}"));
    }
}

/// A kink inside of another one: neither shows the other on the nodes.
#[test]
fn pulses_around_a_kink_push() {
    let mut random = Random(0x1234_5678_9abc_def1);
    for number in 0..60 {
        let (at, width) = (random.between(3.0, 25.0), random.scale(1e-6, 1.0));
        let push = random.between(-0.5, 0.5);
        let force = match number % 3 {
            0 => format!("{:?}*step({width:?} - abs(t - {at:?}))", 0.5 * push / width),
            1 => format!("{:?}*max(0, 1 - abs(t - {at:?})/{width:?})", push / width),
            _ => format!(
                "{:?}*step(sign(t - {at:?} + {width:?}) - sign(t - {at:?} - {width:?}) - 1)",
                0.5 * push / width
            ),
        };
        let line = flight("0", &force);
        assert_ends_at(&line, LENGTH + push * (LENGTH - at), &force);
    }
}

/// A throw is one window, and its height is passed on the way up and down between two nodes of that.
#[test]
fn an_end_that_is_passed_there_and_back_is_met() {
    let up = (2.4 - (2.4_f64 * 2.4 - 17.0 * 0.285).sqrt()) / 8.5;
    for (length, end) in [1.0, 5.0, 50.0, 200.0].into_iter().flat_map(|length| {
        ["grid.until = \"z - 0.285\"", "events.e = { when = \"z - 0.285\", direction = \"up\", until = true }"]
            .map(|end| (length, end))
    }) {
        let line: WorldLine = line_of(&parsed(
            &format!(
                "potential = {{ coordinates = [\"z\"], formula = \"8.5*z\" }}\nparticle.law = \"newtonian\"\n\
                 initial = {{ z = 0.0, z_dot = 2.4 }}\ngrid.t_f = {length:?}\nsolver.accuracy = 1e-9\n{end}\n"
            ),
            &[],
        ));
        assert!((line.end().q[0] - up).abs() < 1e-9, "{length} {end}: {}", line.end().q[0]);
    }
}

#[test]
fn hats_of_kinks_are_hills() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for number in 0..60 {
        let (top, width) = (random.between(4.0, 12.0), random.scale(1e-6, 2.0));
        let is_high = number % 2 == 0;
        let height = if is_high { random.between(0.6, 3.0) } else { random.between(0.1, 0.4) };
        let [from, to] = [top - width, top + width];
        let slope = height / width;
        let formula = format!("{slope:?}*(abs(x - {from:?}) - 2*abs(x - {top:?}) + abs(x - {to:?}))/2");
        // A place is rounded by 1e-15, where the height changes by 1e-15/width.
        let line = flight_to(&formula, "", if width < 1e-4 { 1e-6 } else { ACCURACY });
        let x = if is_high {
            2.0 * from - (LENGTH - 2.0 / slope)
        } else {
            // On both slopes the mean speed is that of the foot and the top.
            to + LENGTH - from - 4.0 * width / (1.0 + (1.0 - 2.0 * height).sqrt())
        };
        assert_ends_at(&line, x, &format!("height {height} at {top}, width {width:e}"));
    }
}

/// The end by DOP853, which begins anew on pieces that are shorter than any hill is wide.
fn in_short_steps(geometry: &Geometry, start: &Start) -> f64 {
    let (space, mut here, pieces) = (Arc::new(geometry.clone()), start.clone(), 3000);
    for _ in 0..pieces {
        let problem = Problem { space: Arc::clone(&space), start: here, length: LENGTH / f64::from(pieces), g00: None };
        let found = Peer::Dop853.run(&problem, &Output::even(1), Setting::tolerance(1e-15)).unwrap();
        let state = found.states.last().unwrap();
        let (q, p) = (state.q.to_vec(), state.p.to_vec());
        here = Start { q_dot: geometry.velocities(&q, &p).unwrap(), q, p };
    }
    here.q[1]
}

#[test]
fn hills_that_are_powers_are_met() {
    let mut random = Random(0xd1b5_4a32_d192_ed03);
    for number in 0..32 {
        let (power, top) = (random.scale(2.0, 1300.0).round(), random.between(5.0, 12.0));
        let height = if number % 2 == 0 { random.between(0.6, 2.0) } else { random.between(0.1, 0.4) };
        // The hill is as wide as this, whatever the power.
        let scale = random.scale(0.05, 1.0) * f64::sqrt(power);
        let base = match number / 2 % 4 {
            0 => format!("1/(1 + ((x - {top:?})/{scale:?})^2)"),
            1 => format!("exp(-((x - {top:?})/{scale:?})^2)"),
            2 => format!("(1 - tanh((x - {top:?})/{scale:?})^2)"),
            _ => format!("(1/cosh((x - {top:?})/{scale:?}))"),
        };
        let formula = format!("{height:?}*({base})^{power}");
        let line = flight(&formula, "");
        let x = in_short_steps(line.geometry(), &line.place.start);
        assert_ends_at(&line, x, &formula);
    }
}

/// In a hat that is 1e-6 wide all windows are short beside the run, and the velocity of s, which is quadratic in t,
/// bends in each of them: K and the energy are those of the momenta on the nodes.
#[test]
fn a_thin_hat_leaves_all_witnesses_quiet() {
    for (height, place, width) in [(-0.9055, 8.0923, 1.192e-6), (0.4, 5.31, 3.7e-7), (-0.2, 9.7, 8.1e-6)] {
        let text = format!(
            "potential.coordinates = ['x']\npotential.formula = '{height}*max(0, 1 - abs(x - {place})/{width:e})'\n\
             particle.law = 'newtonian'\ninitial = {{ x = 0.0, x_dot = 1.4929 }}\ngrid.gamma_f = 22.88\n\
             solver.accuracy = 4.6e-7"
        );
        let case = crate::common::parsed(&text, &[]);
        let setup = case.setup::<f64>();
        let found = geodesic_ivp::study::run::run(&case, &setup, geodesic_ivp::study::run::Wanted::default()).0;
        let judged = found.unwrap_or_else(|none| panic!("{none:?}")).judged(&setup, false, false);
        assert!(judged.verdict.reasons.is_empty(), "{width}: {:?}", judged.verdict.reasons);
    }
}
