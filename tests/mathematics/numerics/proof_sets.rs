//! Proofs of the motions from a set of starts: what one says holds for each of these motions, which have proofs of
//! their own, and for any two of them.

use geodesic_ivp::Case;
use geodesic_ivp::geometry::Start;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::proof::{Generator, Motion, Proof, Reason, Until, prove};
use geodesic_ivp::solve::{Limit, Setup};

use super::proof::{scenes, template};
use crate::random_scenes::random::Random;

const FAMILIES: &str = include_str!("../../../benches/promise/families.txt");
/// Starts are spread by this part of their numbers at most.
const SPREAD: f64 = 1e-8;

#[derive(Default)]
struct Tally {
    compared: usize,
    largest: f64,
    /// Differences of two ends, and the largest part of their slack that they need.
    differences: usize,
    most: f64,
    /// Ends whose radius is less than a thousandth of what the linear part reaches.
    linear: usize,
    constant: usize,
    refused: Vec<String>,
}

/// The proof of the motion from the point β of a set.
fn at(motion: &Motion<'_>, beta: &[f64]) -> Proof {
    let (mut q, mut p) = (motion.start.q.clone(), motion.start.p.clone());
    let Until::Length(mut length) = motion.until else { unreachable!("sets end after lengths") };
    for (generator, &beta) in motion.generators.iter().zip(beta) {
        let by = |part: f64| Extended::from(part) * Extended::from(beta);
        q.iter_mut().zip(&generator.q).for_each(|(q, &part)| *q += by(part));
        p.iter_mut().zip(&generator.p).for_each(|(p, &part)| *p += by(part));
        length += by(generator.length);
    }
    let q_dot = motion.geometry.velocities(&q, &p).unwrap();
    let start = Start { q, q_dot, p };
    prove(&Motion { start: &start, until: Until::Length(length), generators: &[], ..*motion }, &mut |_| true)
}

impl Tally {
    fn compare(&mut self, what: &str, set: &Proof, one: &Proof, beta: &[f64]) {
        let Ok(ends) = &one.end else { return };
        for end in ends {
            let spread = set.state[end.coordinate].as_ref().unwrap();
            let along: f64 = spread.columns.iter().zip(beta).map(|(column, beta)| column * beta).sum();
            let off = (end.value - spread.value - Extended::from(along)).abs().to_f64();
            let room = spread.radius + end.radius;
            assert!(off <= room, "{what} at {beta:?}: {off:e} of {:e} + {:e}", spread.radius, end.radius);
            self.compared += 1;
            self.largest = self.largest.max(off / room);
            let reach: f64 = spread.columns.iter().map(|column| column.abs()).sum();
            self.linear += usize::from(spread.radius < 1e-3 * reach);
        }
    }

    /// What is said of the difference of two motions.
    fn compare_two(&mut self, what: &str, set: &Proof, [one, other]: [&Proof; 2], beta: [&[f64]; 2]) {
        let (Ok(ends), Ok(others)) = (&one.end, &other.end) else { return };
        let apart: Vec<f64> = beta[0].iter().zip(beta[1]).map(|(one, other)| one - other).collect();
        let most = apart.iter().fold(0.0_f64, |most, apart| most.max(apart.abs()));
        for (end, other) in ends.iter().zip(others) {
            let spread = set.state[end.coordinate].as_ref().unwrap();
            let along: f64 = spread.columns.iter().zip(&apart).map(|(column, apart)| column * apart).sum();
            let off = (end.value - other.value - Extended::from(along)).abs().to_f64();
            let room = most * spread.slack + end.radius + other.radius;
            assert!(off <= room, "{what} at {beta:?}: {off:e} of {room:e}, slack {:e}", spread.slack);
            self.differences += 1;
            self.most = self.most.max(off / room);
        }
    }

    fn draw(&mut self, what: &str, template: &str, random: &mut Random) {
        let (text, mut settings, _) = scenes::drawn(template, random);
        let long = settings.iter().position(|setting| setting.contains(".N=")).unwrap();
        let key = settings[long].split('=').next().unwrap().to_owned();
        settings[long] = format!("{key}={}", random.scale(0.3, 3.0));
        settings.push("solver.tolerance=1e-9".to_owned());
        let Ok(case) = Case::parse(what, &text, &settings) else { return };
        let setup: Setup<Extended> = case.setup();
        let Limit::Length(length) = setup.limit else { return };
        let (geometry, start) = (&*setup.place.geometry, &*setup.place.start);
        let is_active = |a: usize| geometry.active().contains(&a);
        let size = |values: &[Extended]| {
            let active = (0..values.len()).filter(|&a| is_active(a)).map(|a| values[a].abs().to_f64());
            active.fold(0.0, f64::max)
        };
        let [of_q, of_p] = [size(&start.q), size(&start.p)];
        let mut direction = |all: bool| {
            let mut part = |size: f64| SPREAD * random.between(-1.0, 1.0) * size;
            let q: Vec<f64> = (0..start.q.len()).map(|_| part(of_q)).collect();
            let p = (0..q.len()).map(|a| if all || is_active(a) { part(of_p) } else { 0.0 }).collect();
            Generator { q, p, length: part(length.to_f64()) }
        };
        let generators = [direction(false), direction(false)];
        let motion = Motion { generators: &generators, ..Motion::new(geometry, start, Until::Length(length)) };
        let set = prove(&motion, &mut |_| true);
        match &set.end {
            Ok(_) => {
                let beta = [[0.0, 0.0], [1.0, 1.0], [-1.0, 1.0], [0.3, -0.9]];
                let proofs = beta.map(|beta| at(&motion, &beta));
                for (i, one) in proofs.iter().enumerate() {
                    self.compare(what, &set, one, &beta[i]);
                    for (j, other) in proofs.iter().enumerate().skip(i + 1) {
                        self.compare_two(what, &set, [one, other], [&beta[i], &beta[j]]);
                    }
                }
            }
            Err(reason) => self.refused.push(format!("{what}: {reason}")),
        }
        let other = [direction(true)];
        let other = prove(&Motion { generators: &other, ..motion }, &mut |_| true);
        self.constant += usize::from(other.end == Err(Reason::Constant));
    }
}

#[test]
fn each_motion_of_a_set_ends_where_the_proof_of_the_set_says() {
    let draws = std::env::var("PROOF_DRAWS").ok().and_then(|text| text.parse().ok()).unwrap_or(1);
    let (mut random, mut tally) = (Random(76), Tally::default());
    for (name, template) in template::families(FAMILIES) {
        (0..draws).for_each(|draw| tally.draw(&format!("{name} {draw}"), template, &mut random));
    }
    let Tally { compared, largest, differences, most, linear, constant, refused } = tally;
    println!("{compared} ends compared, {largest:.2} of a radius, {linear} of them nearly linear");
    println!("{differences} differences, {most:.2} of what they may be off by");
    println!("{constant} change a constant; refused:\n{}", refused.join("\n"));
    assert!(compared > 100 && largest > 1e-4, "{compared} {largest}");
    assert!(differences > 100 && most > 1e-4, "{differences} {most}");
    // What is quadratic is small.
    assert!(linear * 2 > compared, "{linear} of {compared}");
    assert!(constant > 0 && refused.len() * 10 <= compared / 8, "{}", refused.join("\n"));
}
