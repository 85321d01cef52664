//! The table of what became of draws.

use std::collections::BTreeMap;

use super::Drawn;
use super::judged::{OUTCOMES, Outcome};

/// So many first words tell reasons apart.
const WORDS: usize = 4;

/// Numbers of draws.
#[derive(Default)]
pub(crate) struct Tally {
    /// By outcomes, in the order of [`OUTCOMES`].
    counts: [usize; OUTCOMES.len()],
    coarse: usize,
    /// The first words of reasons for doubts about good results, and of refusals, with numbers of draws that have them
    /// and one of these.
    reasons: BTreeMap<(Outcome, String), (usize, u64)>,
}

impl Tally {
    pub(crate) fn see(&mut self, drawn: &Drawn) {
        self.counts[drawn.outcome as usize] += 1;
        self.coarse += usize::from(drawn.is_coarse);
        if matches!(drawn.outcome, Outcome::Careful | Outcome::Refused) {
            let is_word = |word: &&str| !word.contains(|c: char| c.is_ascii_digit());
            let words: Vec<&str> = drawn.reason.split_whitespace().filter(is_word).take(WORDS).collect();
            self.reasons.entry((drawn.outcome, words.join(" "))).or_insert((0, drawn.number)).0 += 1;
        }
    }

    fn of(&self, outcome: Outcome) -> usize {
        self.counts[outcome as usize]
    }
}

/// Prints the table as Markdown, and reasons below it.
pub(crate) fn print(tallies: &BTreeMap<(&str, &str), Tally>) {
    let names: Vec<&str> = OUTCOMES.iter().map(|(_, name)| *name).collect();
    println!("| family | scheme | {} | coarse | careful of good | refused of all |", names.join(" | "));
    println!("|---|---|{}---|---|---|", "---|".repeat(names.len()));
    for ((family, scheme), tally) in tallies {
        let counts: Vec<String> = tally.counts.iter().map(usize::to_string).collect();
        let [right, careful, refused] = [Outcome::Right, Outcome::Careful, Outcome::Refused].map(|it| tally.of(it));
        let percent = |part: usize, of: usize| 100.0 * part as f64 / of.max(1) as f64;
        println!(
            "| {family} | {scheme} | {} | {} | {:.1} % | {:.1} % |",
            counts.join(" | "),
            tally.coarse,
            percent(careful, right + careful),
            percent(refused, tally.counts.iter().sum())
        );
    }
    for ((family, scheme), tally) in tallies.iter().filter(|((_, scheme), _)| *scheme == "all") {
        for ((outcome, words), (count, number)) in &tally.reasons {
            println!("{family} {scheme}: {outcome:?} {count} times, as in {number}: {words} …");
        }
    }
}
