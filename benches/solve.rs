//! What the parts cost. `cargo bench` prints them side by side; read ratios of one run, not absolute times.

use divan::{Bencher, black_box};
use geodesic_ivp::case::builtin;
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::sbp::{SbpOperator, coefficients};
use geodesic_ivp::{Case, Solution, solve};

fn main() {
    divan::main();
}

fn case(overrides: &[&str]) -> Case {
    let text = builtin::text("quartic").expect("it is built in");
    let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
    Case::parse("quartic", text, &overrides).expect("the case is valid")
}

fn grid(sbp: &str, n: usize, more: &[&str]) -> Case {
    let (sbp, n) = (format!("scheme.sbp={sbp}"), format!("grid.n_gamma={n}"));
    case(&[&[sbp.as_str(), n.as_str()], more].concat())
}

/// D u on a million nodes.
#[divan::bench(args = ["SBP21", "SBP42"])]
fn apply_operator(bencher: Bencher, name: &str) {
    let table = if name == "SBP21" { &coefficients::SBP21 } else { &coefficients::SBP42 };
    let sbp = SbpOperator::new(table, 1_000_000, 1e-6).expect("enough points");
    let u: Vec<f64> = (0..1_000_000).map(|k| (f64::from(k) * 1e-6).sin()).collect();
    let mut out = vec![0.0; u.len()];
    bencher.bench_local(|| sbp.apply(black_box(&u), &mut out));
}

/// The physical limit with its certificate.
#[divan::bench(args = [1_000, 10_000, 100_000, 1_000_000], sample_count = 10)]
fn physical_limit_sbp21(bencher: Bencher, n: usize) {
    let case = grid("SBP21", n, &[]);
    bencher.bench_local(|| solve::<f64>(black_box(&case)));
}

/// The physical limit with its certificate.
#[divan::bench(args = [1_000, 10_000, 100_000, 1_000_000], sample_count = 10)]
fn physical_limit_sbp42(bencher: Bencher, n: usize) {
    let case = grid("SBP42", n, &[]);
    bencher.bench_local(|| solve::<f64>(black_box(&case)));
}

/// All 4N + 8 unknowns.
#[divan::bench(args = [200, 2_000, 20_000], sample_count = 10)]
fn doubled_sbp42(bencher: Bencher, n: usize) {
    let case = grid("SBP42", n, &["solver.system=doubled"]);
    bencher.bench_local(|| solve::<f64>(black_box(&case)));
}

/// 1000 nodes, the number of digits in the solver's two kinds of arithmetic.
#[divan::bench(args = ["SBP21", "SBP42"])]
fn a_thousand_nodes_in_16_digits(bencher: Bencher, sbp: &str) {
    let case = grid(sbp, 1000, &[]);
    bencher.bench_local(|| solve::<f64>(black_box(&case)));
}

/// The same in extended precision.
#[divan::bench(args = ["SBP21", "SBP42"])]
fn a_thousand_nodes_in_40_digits(bencher: Bencher, sbp: &str) {
    let case = grid(sbp, 1000, &["solver.digits=40"]);
    bencher.bench_local(|| solve::<Extended>(black_box(&case)));
}

/// The same potential as a built-in and as a formula.
#[divan::bench(args = ["{quartic={kappa=0.5}}", "{formula={expression=\"x^4/2\"}}"])]
fn potential(bencher: Bencher, potential: &str) {
    let case = grid("SBP21", 100_000, &[&format!("potential={potential}")]);
    bencher.bench_local(|| solve::<f64>(black_box(&case)));
}

/// Everything that is measured on a solution of 100 000 nodes.
#[divan::bench]
fn diagnostics(bencher: Bencher) {
    let solution: Solution = solve(&grid("SBP42", 100_000, &[])).expect("the base case converges");
    bencher.bench_local(|| Diagnostics::new(black_box(&solution)));
}

/// The Taylor reference over this length of the world-line, with its error estimate.
#[divan::bench(args = [1.0, 10.0, 100.0])]
fn reference(bencher: Bencher, length: f64) {
    let case = case(&[]);
    let (metric, initial) = (case.geometry(), case.start());
    bencher.bench_local(|| ReferenceTrajectory::new(black_box(&metric), &initial, length, f64::MOST_DIGITS));
}
