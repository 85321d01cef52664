//! Is an accuracy that is asked for kept in one coordinate? Draws random potentials, solves each to a random accuracy,
//! and compares the nodes and places between them with two other integrators, a Taylor method and DOP853. Both are
//! restarted on short pieces, so that neither jumps over anything.
//!
//! Every fourth V is smooth (the quartic, a pendulum, Morse's, a double well), and the run ends at a random t_f. The
//! others have cusps, kinks, walls, steep powers or Gaussians. Scenes of several coordinates are those of the benches
//! `promise` and `verdict`.
//!
//! ```text
//! cargo bench --bench promises [-- RUNS [SEED]]
//! ```
//!
//! Every broken promise is printed with its scene. The exit code is 1 if there is one. The table has the median and the
//! largest of the errors in units of their estimates.

mod outcome;
mod random;
mod rough;
mod scenes;
#[allow(dead_code, reason = "scenes of several coordinates are not drawn here")]
mod truth;

use std::collections::BTreeMap;
use std::process::ExitCode;

use outcome::Outcome;
use scenes::Scene;

/// The error of a run in units of its estimate.
fn share(outcome: &Outcome) -> Option<f64> {
    match *outcome {
        Outcome::NoReference | Outcome::Refused(_) => None,
        Outcome::Broken { error, estimate }
        | Outcome::TooLow { error, estimate }
        | Outcome::Kept { error, estimate } => Some(error.max(0.0) / estimate),
    }
}

fn main() -> ExitCode {
    let (runs, mut random) = random::arguments(1000);
    // Runs, without reference, refused, broken promises, estimates that are too low.
    let mut table: BTreeMap<&str, ([usize; 5], Vec<f64>)> = BTreeMap::new();
    for _ in 0..runs {
        let is_smooth = random.next().is_multiple_of(4);
        let scene = if is_smooth { Scene::smooth(&mut random) } else { Scene::rough(&mut random) };
        let (kind, outcome) = (scene.kind, scene.run());
        let (row, shares) = table.entry(kind).or_default();
        shares.extend(share(&outcome));
        row[0] += 1;
        let column = match &outcome {
            Outcome::NoReference => 1,
            Outcome::Refused(_) => 2,
            Outcome::Broken { .. } => 3,
            Outcome::TooLow { .. } => 4,
            Outcome::Kept { .. } => continue,
        };
        row[column] += 1;
        if column > 1 {
            println!("{outcome}: {scene}");
        }
    }
    println!(
        "{:>13} {:>8} {:>14} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "kind", "runs", "no reference", "refused", "broken", "too low", "median", "largest"
    );
    for (kind, ([runs, unknown, refused, broken, low], shares)) in &mut table {
        shares.sort_by(f64::total_cmp);
        let (median, largest) = (shares.get(shares.len() / 2), shares.last());
        let [median, largest] =
            [median, largest].map(|share| share.map_or(String::new(), |share| format!("{share:.2}")));
        println!("{kind:>13} {runs:>8} {unknown:>14} {refused:>8} {broken:>8} {low:>8} {median:>8} {largest:>8}");
    }
    if table.values().any(|(row, _)| row[3] > 0 || row[4] > 0) { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
