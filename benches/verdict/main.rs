//! Is the verdict on a run right? Solves random scenes in random schemes, from coarse to fine grids, and compares the
//! verdict with what two other integrators find.
//!
//! The scenes are potentials of one coordinate, smooth ones and ones with cusps, kinks, walls and narrow humps, and
//! scenes of several coordinates: potentials under either law, a planet, orbits around black holes, coordinates that
//! the metric couples. The schemes are SBP21 to SBP84 and GLL2 to GLL24, strong and weak, physical limit and doubled,
//! one window or many, and accuracies that are asked for.
//!
//! ```text
//! cargo bench --bench verdict [-- RUNS [SEED [accuracy]]]
//! ```
//!
//! The table counts verdicts by the error of their results. Every trusted result that is off by more than ten times its
//! estimate is printed with its case, and so is every one that is off by more than the accuracy that it was to have, at
//! a node or half way between two; the exit code is 1 if there is one. With `accuracy` all runs are to an accuracy,
//! between 1e-12 and 1e-4.

mod draw;
mod judged;
#[allow(dead_code, reason = "the other bench draws signs")]
mod random;
mod several;
mod tally;
mod truth;

use std::collections::BTreeMap;
use std::process::ExitCode;

use draw::Drawn;
use judged::Judged;
use rayon::prelude::*;
use tally::Tally;

fn main() -> ExitCode {
    let (runs, seed, scheme) = random::arguments(2000);
    let mut random = random::Random(seed);
    let one = |_| if scheme.is_some() { Drawn::accurate(&mut random, draw::any) } else { Drawn::new(&mut random) };
    let drawn: Vec<Drawn> = (0..runs).map(one).collect();
    let judged: Vec<Judged> = drawn.par_iter().map(|drawn| Judged::of(&drawn.case())).collect();

    let (mut all, mut wrong) = (Tally::default(), 0);
    let (mut schemes, mut kinds): (BTreeMap<&str, Tally>, BTreeMap<&str, Tally>) = Default::default();
    let mut reasons: BTreeMap<String, usize> = BTreeMap::new();
    for (drawn, judged) in drawn.iter().zip(&judged) {
        let careful = all.good[1];
        if all.count(judged) || judged.is_broken() {
            wrong += 1;
            println!("WRONG, error {:?}: {drawn}\n", judged.verdict.error);
        }
        if all.good[1] > careful {
            // Why a good result is called doubtful: the first words of the first reason.
            let words = judged.verdict.reasons[0].reason.split_whitespace().take(3).collect::<Vec<_>>().join(" ");
            *reasons.entry(words).or_default() += 1;
        }
        schemes.entry(&drawn.scheme).or_default().count(judged);
        kinds.entry(drawn.kind).or_default().count(judged);
    }
    print!("{}", all.table());
    let [good, careful] = all.good;
    println!("\nGood results, whose estimate is right and small: {good}.");
    println!("Of these are called doubtful: {careful}, that is {:.1} %.", 100.0 * all.too_careful());
    if careful > 0 {
        let reasons: Vec<String> = reasons.iter().map(|(words, count)| format!("\"{words} …\" {count}")).collect();
        println!("Their first reasons: {}.", reasons.join(", "));
    }
    println!("\n| scheme, scene | trusted | of these above the estimate | doubtful | refused | good, but doubtful |");
    println!("|---|---|---|---|---|---|");
    for (name, tally) in schemes.iter().chain(&kinds) {
        let [trusted, doubtful] = tally.counts.map(|counts| counts.iter().sum::<usize>());
        let low = tally.counts[0][1] + tally.counts[0][2];
        println!(
            "| {name} | {trusted} | {low} | {doubtful} | {} | {} of {} |",
            tally.refused, tally.good[1], tally.good[0]
        );
    }
    if wrong == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
