//! These benches time windows of [`geodesic_ivp::engine::lobatto::flow`] in scenes with more and more coordinates.
//!
//! Chains of 1 to 16 coordinates, each of which feels its two neighbours, the same coordinates with every one feeling
//! all others, and orbits around black holes. Each is timed to the accuracy 1e-10 in windows of 24 nodes, bare and with
//! the certificate. A sweep is one evaluation of the equations on all nodes of a window with the integrals that follow;
//! those of companions and of rejected windows count. Entries are the second derivatives of the Hamiltonian that are
//! not zero: of ∂(q̇, ṗ)/∂(q, p) of the active coordinates and their momenta.
//!
//! ```text
//! cargo bench --bench scenes [-- NAME]
//! ```

use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::Instant;

use geodesic_ivp::case::SceneCase;
use geodesic_ivp::case::builtin;
use geodesic_ivp::engine::lobatto::Statistics;
use geodesic_ivp::engine::lobatto::flow::{Flow, FlowFailure, FlowView};
use geodesic_ivp::geometry::{Geometry, Start};

const ACCURACY: f64 = 1e-10;
/// Seconds that a scene is timed for at least, and the least number of runs.
const PATIENCE: f64 = 0.5;
const RUNS: usize = 5;

/// The length in γ of a run of a chain. The orbits are chaotic, and long ones with many coordinates have no ten digits.
const LENGTH: f64 = 5.0;

/// Coordinates of a chain.
const SIZES: [usize; 5] = [1, 2, 4, 8, 16];

/// Every coordinate x feels x², and a pair (x − y)⁴. A formula has at most 1024 bytes, so that names are short.
fn chain(count: usize, are_coupled: impl Fn(usize, usize) -> bool) -> SceneCase {
    let names: Vec<String> = ('a'..='p').take(count).map(String::from).collect();
    let mut terms: Vec<String> = names.iter().map(|name| format!("{name}^2")).collect();
    for (j, one) in names.iter().enumerate() {
        terms.extend((0..j).filter(|&k| are_coupled(k, j)).map(|k| format!("({one}-{})^4", names[k])));
    }
    let initial: Vec<String> = names
        .iter()
        .enumerate()
        .map(|(k, name)| format!("{name} = {:.3}\n{name}_dot = 0.0", (k as f64).cos()))
        .collect();
    let text = format!(
        "potential = {{ coordinates = {names:?}, formula = \"{}\" }}\nparticle.law = \"newtonian\"\n[initial]\n{}\n\
         [grid]\ngamma_f = {LENGTH:?}\n[solver]\naccuracy = {ACCURACY:e}\n",
        terms.join("+"),
        initial.join("\n")
    );
    SceneCase::parse("chain", &text, &[]).expect("a valid scene")
}

fn shipped(name: &str) -> SceneCase {
    SceneCase::parse(name, builtin::text(name).expect("a shipped scene"), &[]).expect("a valid scene")
}

fn run(flow: Flow<'_>, start: &Start, length: f64) -> Result<Statistics, FlowFailure> {
    let go_on = &mut |_: &FlowView<'_>| ControlFlow::Continue(());
    Ok(flow.run(black_box(start), length, &mut [], ACCURACY, go_on)?.statistics)
}

/// The least seconds of a run.
fn least(flow: Flow<'_>, start: &Start, length: f64) -> f64 {
    let (begin, mut least, mut runs) = (Instant::now(), f64::INFINITY, 0);
    while runs < RUNS || begin.elapsed().as_secs_f64() < PATIENCE {
        let now = Instant::now();
        let _ = black_box(run(flow, start, length));
        least = least.min(now.elapsed().as_secs_f64());
        runs += 1;
    }
    least
}

/// The entries of ∂(q̇, ṗ)/∂(q, p) that are not zero.
fn entries(geometry: &Geometry, start: &Start) -> usize {
    let mut count = 0;
    geometry.point().jacobian(&start.q, &start.p, |_, _, _| count += 1);
    count
}

fn report(name: &str, case: &SceneCase, length: f64) {
    let (geometry, start): (Geometry, Start) = (case.geometry(), case.start());
    let Statistics { windows, evaluations, .. } = match run(Flow::new(&geometry), &start, length) {
        Ok(statistics) => statistics,
        Err(failure) => return println!("{name:22} {failure}"),
    };
    let [bare, certified] =
        [Flow::new(&geometry), Flow::new(&geometry).certified()].map(|flow| 1e6 * least(flow, &start, length));
    let (active, sweeps) = (geometry.active().len(), evaluations as f64 / windows as f64);
    println!(
        "{name:22} {:6} {active:6} {:7} {windows:7} {sweeps:6.1} {:9.2} {:9.2} {:8.3} {:12.3}",
        geometry.dimension(),
        entries(&geometry, &start),
        bare / windows as f64,
        certified / windows as f64,
        bare / evaluations as f64,
        bare / evaluations as f64 / active as f64,
    );
}

fn main() {
    let wanted = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    let is_wanted = |name: &str| wanted.as_ref().is_none_or(|wanted| name.contains(wanted.as_str()));
    println!(
        "{:22} {:>6} {:>6} {:>7} {:>7} {:>6} {:>9} {:>9} {:>8} {:>12}",
        "scene", "coord.", "active", "entries", "windows", "sweeps", "μs", "certified", "μs/sweep", "/coordinate"
    );
    for count in SIZES {
        let name = format!("chain {count}");
        if is_wanted(&name) {
            report(&name, &chain(count, |j, k| j + 1 == k), LENGTH);
        }
    }
    for count in SIZES.into_iter().skip(1) {
        let name = format!("all to all {count}");
        if is_wanted(&name) {
            report(&name, &chain(count, |_, _| true), LENGTH);
        }
    }
    for (name, length) in [("schwarzschild-orbit", 2000.0), ("kerr-inclined", 400.0)] {
        if is_wanted(name) {
            report(name, &shipped(name), length);
        }
    }
}
