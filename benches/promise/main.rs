//! Is an accuracy that is promised kept? Draws random scenes, runs each to a random accuracy, and measures the errors
//! of all coordinates at all nodes, relative to their sizes.
//!
//! The reference is a run with the tolerance 1e-15, interpolated by the polynomials of its windows. Another one with
//! 1e-14 tells how far it can be trusted: where they differ by more than a third of the accuracy, as in chaotic motion,
//! nothing is decided. For hills that a tolerance steps over, and near poles, both promise a tenth and a thirtieth of
//! the accuracy; straight lines past a pole have shown that these are right.
//!
//! ```text
//! cargo bench --bench promise [-- DRAWS [SEED [FAMILY]]]
//! ```
//!
//! draws so many runs of every family, or of one, half in random units. 120 draws take a minute. Refusals, broken
//! promises and estimates below the error are printed with what draws them again. The table has, by families and by
//! decades of the accuracy, the numbers of runs, of undecided ones, of broken promises, of estimates that are too low
//! and of attempts that were begun again, then accuracy/error (least and median), estimate/error (least, median and 90
//! %), and refusals. The exit code is 1 if a promise is broken.

#[path = "../verdict/random.rs"]
mod random;
mod runs;
mod scenes;
mod units;

use std::collections::BTreeMap;
use std::process::ExitCode;

use geodesic_ivp::engine::Accuracy;
use geodesic_ivp::geometry::{Geometry, Start};

use random::{Random, arguments};
use runs::{Run, time_and_sizes};
use scenes::FAMILIES;
use units::in_units;

/// The ends that the runs of a family or a decade came to.
#[derive(Default)]
struct Tally {
    refused: BTreeMap<String, usize>,
    undecided: usize,
    broken: usize,
    below: usize,
    restarts: usize,
    /// Accuracy and estimate, relative to the error.
    ratios: Vec<[f64; 2]>,
}

impl Tally {
    fn print(&mut self, name: &str) {
        let of = |k: usize| -> Vec<f64> {
            let mut of: Vec<f64> = self.ratios.iter().map(|ratio| ratio[k]).collect();
            of.sort_by(f64::total_cmp);
            of
        };
        let (accuracy, estimate) = (of(0), of(1));
        let at = |of: &[f64], part: f64| of.get((part * (of.len().max(1) - 1) as f64) as usize).copied().unwrap_or(0.0);
        let [least, median] = [0.0, 0.5].map(|part| at(&accuracy, part));
        let [low, middle, high] = [0.0, 0.5, 0.9].map(|part| at(&estimate, part));
        let Self { refused, undecided, broken, below, restarts, .. } = self;
        print!("{name:22} {:5} {undecided:4} {broken:4} {below:4} {restarts:4}  ", accuracy.len());
        println!("{least:8.1} {median:8.1}  {low:7.2} {middle:7.1} {high:7.1}  {refused:?}");
    }
}

/// The accuracy of a run, what became of it with its error and the doubt about that, and its description.
type Studied = (f64, Result<(Run, [f64; 2]), String>, String);

/// Draws a run; `None` where its scene has no start.
fn study(seed: u64, family: usize) -> Option<Studied> {
    let mut draw = Random(seed);
    let (name, scene) = FAMILIES[family];
    let drawn = scene(&mut draw);
    let (accuracy, turns) = (draw.scale(1e-11, 1e-4), draw.scale(0.3, 1000.0));
    // Nothing but flat ground is found farther away from disks.
    let reach = draw.between(3.0, 12.0);
    let is_in_units = draw.sign() < 0.0;
    let (text, q, v) = if is_in_units { in_units(drawn, &mut draw) } else { drawn };
    let geometry = Geometry::new(&text).ok()?.with_domain_of(&q).ok()?;
    let p = geometry.momenta(&q, &v);
    let start = Start { q_dot: geometry.velocities(&q, &p).ok()?, q: q.clone(), p };
    let (time, _) = time_and_sizes(&geometry, &start, 1e300);
    let length = match name {
        "disks" => reach,
        _ if time < 1e299 => turns * time,
        _ => turns,
    };
    let (_, sizes) = time_and_sizes(&geometry, &start, length);
    let of_units = if is_in_units { " in units" } else { "" };
    let what = format!("{name}{of_units} seed {seed} a {accuracy:.1e} L/T {turns:.1}");
    let run_of = |wanted| Run::new(&geometry, &start, length, wanted);
    let result = run_of(Accuracy::Promised(accuracy)).map(|promised| {
        // A tolerance alone may step over a hill that it comes to from far away, and loses digits at a pole.
        let wanted = match name {
            "disks" | "polar" => [10.0, 30.0].map(|share| Accuracy::Promised(accuracy / share)),
            _ => [1e-15, 1e-14].map(Accuracy::Local),
        };
        let [Ok(first), Ok(second)] = &wanted.map(run_of) else {
            return (promised, [0.0, f64::INFINITY]);
        };
        let mut origin = vec![0.0; q.len()];
        geometry.ignorable().for_each(|a| origin[a] = q[a]);
        let errors = promised.errors([first, second], &origin, sizes, geometry.active().len());
        (promised, errors)
    });
    Some((accuracy, result, what))
}

fn main() -> ExitCode {
    let (draws, seed, only) = arguments(10);
    let only: Option<usize> = only.map(|text| text.parse().expect("the number of a family"));
    let mut tallies: BTreeMap<(usize, i32), Tally> = BTreeMap::new();
    for family in (0..FAMILIES.len()).filter(|&family| only.is_none_or(|only| only == family)) {
        for k in 0..draws {
            let own = seed.wrapping_mul(1_000_003) + k * 64 + family as u64;
            let Some((accuracy, result, what)) = study(own << 20, family) else { continue };
            for key in [(0, family as i32), (1, accuracy.log10().floor() as i32), (2, 0)] {
                let tally = tallies.entry(key).or_default();
                match &result {
                    Err(reason) => *tally.refused.entry(reason.clone()).or_default() += 1,
                    Ok((_, [_, doubt])) if *doubt >= accuracy / 3.0 => tally.undecided += 1,
                    Ok((run, [error, doubt])) => {
                        tally.broken += usize::from(*error > accuracy);
                        tally.below += usize::from(run.estimate + doubt < *error);
                        tally.restarts += run.restarts;
                        let error = error.max(1e-17);
                        tally.ratios.push([accuracy / error, run.estimate / error]);
                    }
                }
            }
            match &result {
                Err(reason) => eprintln!("{reason}: {what}"),
                Ok((run, [error, doubt])) if *error > accuracy || run.estimate < *error => {
                    eprintln!("error {error:.1e} doubt {doubt:.1e} estimate {:.1e}: {what}", run.estimate);
                }
                Ok(_) => {}
            }
        }
    }
    let broken: usize = tallies.values().map(|tally| tally.broken).sum();
    println!("name                    runs und. brok. low again a/err min  median  est/err min median 90 %  refused");
    for ((kind, key), tally) in &mut tallies {
        let name = match kind {
            0 => FAMILIES[*key as usize].0.to_owned(),
            1 => format!("1e{key}"),
            _ => "all".to_owned(),
        };
        tally.print(&name);
    }
    ExitCode::from(u8::from(broken > 0))
}
