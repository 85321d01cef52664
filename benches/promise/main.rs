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
//! draws so many runs of every family, or of one by its number, half in random units; `1 SEED FAMILY` draws again what
//! was printed with this seed, and prints its case. Refusals, broken promises and estimates below
//! the error are printed with what draws them again. The table has, by families and by decades of the accuracy, the
//! numbers of runs, of undecided ones, of broken promises and of estimates that are too low, then accuracy/error (least
//! and median), estimate/error (least, median and 90 %), and refusals. The exit code is 1 if a promise is broken.

#[path = "../verdict/random.rs"]
mod random;
mod scenes;
mod template;

use std::collections::BTreeMap;
use std::process::ExitCode;

use geodesic_ivp::case::Case;
use geodesic_ivp::solve;
use geodesic_ivp::solve::WorldLine;
use geodesic_ivp::trajectory::Sampler;
use random::{Random, arguments};
use rayon::prelude::*;
use scenes::drawn;
use template::families;

/// The ends that the runs of a family or a decade came to.
#[derive(Default)]
struct Tally {
    refused: BTreeMap<String, usize>,
    undecided: usize,
    broken: usize,
    below: usize,
    /// Accuracy and estimate, relative to the error.
    ratios: Vec<[f64; 2]>,
}

impl Tally {
    fn see(&mut self, accuracy: f64, result: &Result<Found, String>) {
        match result {
            Err(reason) => *self.refused.entry(reason.clone()).or_default() += 1,
            Ok(found) if found.doubt >= accuracy / 3.0 => self.undecided += 1,
            Ok(Found { error, doubt, estimate }) => {
                self.broken += usize::from(*error > accuracy);
                self.below += usize::from(estimate + doubt < *error);
                let error = error.max(1e-17);
                self.ratios.push([accuracy / error, estimate / error]);
            }
        }
    }

    fn print(&self, name: &str) {
        let of = |k: usize| -> Vec<f64> {
            let mut of: Vec<f64> = self.ratios.iter().map(|ratio| ratio[k]).collect();
            of.sort_by(f64::total_cmp);
            of
        };
        let (accuracy, estimate) = (of(0), of(1));
        let at = |of: &[f64], part: f64| of.get((part * (of.len().max(1) - 1) as f64) as usize).copied().unwrap_or(0.0);
        let [least, median] = [0.0, 0.5].map(|part| at(&accuracy, part));
        let [low, middle, high] = [0.0, 0.5, 0.9].map(|part| at(&estimate, part));
        let Self { refused, undecided, broken, below, .. } = self;
        print!("{name:22} {:5} {undecided:4} {broken:4} {below:4}  ", accuracy.len());
        println!("{least:8.1} {median:8.1}  {low:7.2} {middle:7.1} {high:7.1}  {refused:?}");
    }
}

/// The largest error of a run relative to sizes of coordinates, the doubt about that, and the error that it expects.
struct Found {
    error: f64,
    doubt: f64,
    estimate: f64,
}

/// The accuracy of a run, what became of it, and its description.
type Studied = (f64, Result<Found, String>, String);

/// Draws a run; `None` where its scene has no start.
fn study(seed: u64, (name, template): (&str, &str)) -> Option<Studied> {
    let mut random = Random(seed);
    let (text, settings, is_in_units) = drawn(template, &mut random);
    let accuracy = random.scale(1e-11, 1e-4);
    let run_to = |wanted: String| -> Option<Result<WorldLine, String>> {
        let case = Case::parse(name, &text, &[settings.as_slice(), &[wanted]].concat()).ok()?;
        Some(solve(&case).map_err(|failure| failure.status.to_string()))
    };
    let promised = run_to(format!("solver.accuracy={accuracy:e}"))?;
    let of_units = if is_in_units { " in units" } else { "" };
    let what = format!("{name}{of_units} seed {seed} a {accuracy:e}");
    let found = promised.and_then(|promised| {
        // Such a run is doubtful, and promises nothing.
        if promised.windows_unproved.is_some_and(|count| count > 0) {
            return Err("unproved".to_owned());
        }
        // A tolerance alone may step over a hill that it comes to from far away, and loses digits at a pole.
        let wanted = match name {
            "disks" | "polar" => [10.0, 30.0].map(|share| format!("solver.accuracy={:e}", accuracy / share)),
            // A march without a judge has a hundredth of the tolerance.
            _ => ["1e-13", "1e-12"].map(|tolerance| format!("solver={{ tolerance = {tolerance}, error = false }}")),
        };
        let estimate = promised.error_estimate.unwrap_or(0.0);
        match wanted.map(run_to) {
            [Some(Ok(first)), Some(Ok(second))] => Ok(compared(&promised, [&first, &second], estimate)),
            _ => Ok(Found { error: 0.0, doubt: f64::INFINITY, estimate }),
        }
    });
    Some((accuracy, found, what))
}

/// The largest differences from the first reference, and of the two references there.
fn compared(run: &WorldLine, references: [&WorldLine; 2], estimate: f64) -> Found {
    let mut found = Found { error: 0.0, doubt: 0.0, estimate };
    let mut samplers = references.map(Sampler::new);
    // s of Newton's law is none of the results.
    let mut rows: Vec<_> = (0..run.geometry().results()).map(|a| run.q(a)).collect();
    for gamma in run.gamma() {
        let [one, two] = samplers.each_mut().map(|sampler| sampler.at_gamma(gamma).expect("it is inside").q);
        for (a, row) in rows.iter_mut().enumerate() {
            let (q, size) = (row.next().expect("a node has all coordinates"), run.sizes[a]);
            if size > 0.0 {
                found.error = found.error.max((q - one[a]).abs() / size);
                found.doubt = found.doubt.max((two[a] - one[a]).abs() / size);
            }
        }
    }
    found
}

fn main() -> ExitCode {
    let (draws, seed, only) = arguments(10);
    let only: Option<usize> = only.map(|text| text.parse().expect("the number of a family"));
    let families = families(include_str!("families.txt"));
    let all = (0..families.len()).filter(|&family| only.is_none_or(|only| only == family));
    let jobs: Vec<(usize, u64)> = all.flat_map(|family| (0..draws).map(move |k| (family, k))).collect();
    let again = only.filter(|_| draws == 1);
    if let Some(family) = again {
        let (text, settings, _) = drawn(families[family].1, &mut Random(seed));
        println!("{text}\n{settings:?}");
    }
    let one = |&(family, k): &(usize, u64)| {
        let own = (seed.wrapping_mul(1_000_003) + k * 64 + family as u64) << 20;
        Some((family, study(if again.is_some() { seed } else { own }, families[family])?))
    };
    let studied: Vec<(usize, Studied)> = jobs.par_iter().filter_map(one).collect();
    let mut tallies: BTreeMap<(usize, i32), Tally> = BTreeMap::new();
    for (family, (accuracy, result, what)) in &studied {
        for key in [(0, *family as i32), (1, accuracy.log10().floor() as i32), (2, 0)] {
            tallies.entry(key).or_default().see(*accuracy, result);
        }
        match result {
            Err(reason) => eprintln!("{reason}: {what}"),
            Ok(Found { error, doubt, estimate }) if error > accuracy || estimate < error => {
                eprintln!("error {error:.1e} doubt {doubt:.1e} estimate {estimate:.1e}: {what}");
            }
            Ok(_) => {}
        }
    }
    println!("name                    runs und. brok. low a/err min  median  est/err min median 90 %  refused");
    for ((kind, key), tally) in &tallies {
        let name = match kind {
            0 => families[*key as usize].0.to_owned(),
            1 => format!("1e{key}"),
            _ => "all".to_owned(),
        };
        tally.print(&name);
    }
    ExitCode::from(u8::from(tallies.values().any(|tally| tally.broken > 0)))
}
