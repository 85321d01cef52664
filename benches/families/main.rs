//! Is something wrong trusted? Draws scenes in which something is easily overlooked, runs and judges each as a user's
//! run is, and compares the verdict with two references that share nothing but formulas (`truth.rs`).
//!
//! The families are those of `families.txt`: forces that are flat at the start, pulses of steps and hats, high powers,
//! motion in a plane of space, chains at whose other end nothing moves yet, clocks that are far from 0, formulas that
//! lose digits, and invariants that are right or wrong. Of five runs three are to an accuracy, one to a tolerance, and
//! one on a given grid.
//!
//! ```text
//! cargo bench --bench families [-- DRAWS [SEED [FAMILY]]]
//! ```
//!
//! draws so many runs of every family, or of the one with that name. A result is wrong if a coordinate at the end is
//! off by more than the accuracy asked for, relative to the largest size of coordinates of its kind; without an
//! accuracy, by more than ten times the error that it claims. Results that are trusted and wrong are printed with their
//! cases, and the exit code is 1 if there is one. A run that takes longer than a limit counts as refused. The arguments
//! `one FAMILY NUMBER` print one draw, by the number that is printed with it.
//!
//! The table has, by families and schemes, the trusted results that are right and wrong, the doubtful ones that are
//! good (careful) and that are not (warned), refusals, draws that the references do not decide, and trusted results
//! that are too far off for the own size of a coordinate (coarse).

mod judged;
#[allow(dead_code, reason = "the other bench draws signs")]
#[path = "../verdict/random.rs"]
mod random;
mod scene;
mod tally;
#[path = "../promise/template.rs"]
mod template;
mod truth;

use std::collections::BTreeMap;
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use judged::{JUDGED, Judged, OUTCOMES, Outcome};
use random::Random;
use rayon::prelude::*;
use tally::Tally;
use template::families;

/// A draw may take so long.
const LIMIT: Duration = Duration::from_secs(20);
/// The time between two looks at a draw.
const LOOK: Duration = Duration::from_millis(2);

/// The families, with their templates.
type Families = BTreeMap<&'static str, Vec<&'static str>>;

/// A draw as the process that made it has printed it.
struct Drawn {
    family: &'static str,
    number: u64,
    outcome: Outcome,
    scheme: String,
    is_coarse: bool,
    reason: String,
    what: String,
}

fn main() -> ExitCode {
    let mut all: Families = BTreeMap::new();
    for (family, template) in families(include_str!("families.txt")) {
        all.entry(family).or_default().push(template);
    }
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    if let [one, family, number] = arguments.as_slice()
        && one == "one"
    {
        print_one(&all[family.as_str()], number.parse().expect("the number of a draw"));
        return ExitCode::SUCCESS;
    }
    let (draws, seed, only) = random::arguments(200);
    let names: Vec<&'static str> =
        all.keys().copied().filter(|name| only.as_deref().is_none_or(|only| only == *name)).collect();
    let numbers = (0..draws).map(|draw| seed.wrapping_mul(1_000_003).wrapping_add(draw));
    let jobs: Vec<(&'static str, u64)> =
        numbers.flat_map(|number| names.iter().map(move |name| (*name, number))).collect();
    let drawn: Vec<Drawn> = jobs.par_iter().map(|&(family, number)| draw(family, number)).collect();
    for drawn in drawn.iter().filter(|drawn| drawn.outcome == Outcome::Wrong) {
        println!("WRONG: {} {}\n{}\n", drawn.family, drawn.number, drawn.what);
    }
    let mut tallies: BTreeMap<(&str, &str), Tally> = BTreeMap::new();
    for drawn in &drawn {
        for key in [(drawn.family, drawn.scheme.as_str()), (drawn.family, "all"), ("all", "all")] {
            tallies.entry(key).or_default().see(drawn);
        }
    }
    tally::print(&tallies);
    ExitCode::from(u8::from(drawn.iter().any(|drawn| drawn.outcome == Outcome::Wrong)))
}

/// Prints a draw as [`draw`] reads it.
fn print_one(templates: &[&str], number: u64) {
    let mut random = Random(number << 20);
    let Judged { outcome, scheme, reason, is_coarse, what } = Judged::drawn(templates, &mut random);
    let (_, name) = OUTCOMES.iter().find(|(other, _)| *other == outcome).expect("it has a name");
    println!("{name}\n{scheme}\n{is_coarse}\n{}\n{what}", reason.lines().next().unwrap_or_default());
}

/// Draws in a process of its own, which can be ended.
fn draw(family: &'static str, number: u64) -> Drawn {
    let lost = |reason: &str| Drawn {
        family,
        number,
        outcome: Outcome::Refused,
        scheme: "lost".to_owned(),
        is_coarse: false,
        reason: reason.to_owned(),
        what: String::new(),
    };
    let program = std::env::current_exe().expect("the bench is a program");
    let mut command = Command::new(program);
    command.args(["one", family, &number.to_string()]).env("RAYON_NUM_THREADS", "1").stdout(Stdio::piped());
    let mut child = command.stderr(Stdio::null()).spawn().expect("it runs again");
    let start = Instant::now();
    while child.try_wait().expect("it is a child").is_none() {
        if start.elapsed() > LIMIT {
            child.kill().expect("it can be ended");
        }
        std::thread::sleep(LOOK);
    }
    let output = child.wait_with_output().expect("it has ended");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let judged = text.strip_prefix(JUDGED).map(|text| text.trim_start_matches('\n'));
    let parts: Vec<&str> = judged.unwrap_or(&text).splitn(5, '\n').collect();
    let outcome = OUTCOMES.iter().find(|(_, name)| parts.first() == Some(name));
    let (Some((outcome, _)), [_, scheme, is_coarse, reason, what]) = (outcome, parts.as_slice()) else {
        return match (start.elapsed() > LIMIT, judged) {
            (true, Some(_)) => Drawn { outcome: Outcome::Undecided, ..lost("the references take too long") },
            (true, None) => lost("it takes too long"),
            _ => lost("it panics"),
        };
    };
    Drawn {
        outcome: *outcome,
        scheme: (*scheme).to_owned(),
        is_coarse: *is_coarse == "true",
        reason: (*reason).to_owned(),
        what: (*what).to_owned(),
        ..lost("")
    }
}
