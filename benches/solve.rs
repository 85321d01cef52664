//! The costs of the parts. `cargo bench --bench solve [-- NAME]` prints them side by side; read ratios of one run, not
//! absolute times.
//!
//! First one window with more and more nodes: the physical limit with its certificate, the doubled system, digits,
//! diagnostics and the Taylor reference. Then windows that are given, to rounding: V = x⁴/2 in 2000 windows of 20
//! nodes, by `solve` and by the engine, with and without certificates, and in steps of Gauss' method; scenes with more
//! and more coordinates, and orbits around black holes, in 100 windows by the engine. Its items are sweeps: evaluations
//! of the equations on all nodes of a window with the integrals that follow.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use geodesic_ivp::case::builtin;
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::engine::Engine;
use geodesic_ivp::geometry::{Geometry, OutsideGeometry, Start};
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::sbp::{SbpOperator, coefficients};
use geodesic_ivp::{Case, Solution, solve};

fn main() {
    divan::main();
}

/// A built-in case with settings.
fn case(name: &str, settings: &str) -> Case {
    let settings: Vec<String> = settings.split_whitespace().map(str::to_owned).collect();
    Case::parse(name, builtin::text(name).expect("it is built in"), &settings).expect("the case is valid")
}

fn solves<S: Real>(bencher: Bencher, settings: &str) {
    let case = case("quartic", settings);
    bencher.bench_local(|| solve::<S>(black_box(&case)));
}

/// D u on a million nodes.
#[divan::bench]
fn apply_operator(bencher: Bencher) {
    let sbp = SbpOperator::new(&coefficients::SBP42, 1_000_000, 1e-6).expect("enough points");
    let u: Vec<f64> = (0..1_000_000).map(|k| (f64::from(k) * 1e-6).sin()).collect();
    let mut out = vec![0.0; u.len()];
    bencher.bench_local(|| sbp.apply(black_box(&u), &mut out));
}

/// The physical limit with its certificate.
#[divan::bench(args = [32, 1_000, 10_000, 100_000, 1_000_000], consts = [21, 42, 63, 84], sample_count = 10)]
fn physical_limit<const SBP: usize>(bencher: Bencher, n: usize) {
    solves::<f64>(bencher, &format!("scheme.sbp=SBP{SBP} grid.n_gamma={n}"));
}

/// All 4N + 8 unknowns.
#[divan::bench(args = [200, 2_000, 20_000], sample_count = 10)]
fn doubled(bencher: Bencher, n: usize) {
    solves::<f64>(bencher, &format!("scheme.sbp=SBP42 solver.system=doubled grid.n_gamma={n}"));
}

/// A thousand nodes in extended precision.
#[divan::bench(args = ["SBP21", "SBP42"])]
fn in_40_digits(bencher: Bencher, sbp: &str) {
    solves::<Extended>(bencher, &format!("scheme.sbp={sbp} grid.n_gamma=1000 solver.digits=40"));
}

/// The potential as a formula.
#[divan::bench]
fn formula(bencher: Bencher) {
    solves::<f64>(bencher, "grid.n_gamma=100000 potential={formula=\"x^4/2\"}");
}

/// Everything that is measured on a solution of 100 000 nodes.
#[divan::bench]
fn diagnostics(bencher: Bencher) {
    let solution: Solution =
        solve(&case("quartic", "scheme.sbp=SBP42 grid.n_gamma=100000")).expect("the base case converges");
    bencher.bench_local(|| Diagnostics::new(black_box(&solution)));
}

/// The Taylor reference over this length of the world-line, with its error estimate.
#[divan::bench(args = [1.0, 10.0, 100.0])]
fn reference(bencher: Bencher, length: f64) {
    let case = case("quartic", "");
    let (metric, initial) = (case.geometry(), case.start());
    bencher.bench_local(|| ReferenceTrajectory::new(black_box(&metric), &initial, length, f64::MOST_DIGITS));
}

const NODES: usize = 20;

/// This makes the certificate and stores all that a run keeps.
#[divan::bench]
fn windows_with_everything(bencher: Bencher) {
    solves::<f64>(bencher, "scheme.sbp=GLL20 scheme.form=weak grid.n_gamma=20 grid.gamma_f=100 grid.windows=2000");
}

#[divan::bench(args = [false, true])]
fn windows_certified(bencher: Bencher, is_certified: bool) {
    engine(bencher, &case("quartic", ""), is_certified, |geometry, start| {
        Engine::equal(geometry, start, 100.0, 2000, NODES)
    });
}

#[divan::bench(args = [2, 4, 8, 12])]
fn gauss_stages(bencher: Bencher, stages: usize) {
    engine(bencher, &case("quartic", ""), false, |geometry, start| {
        Engine::gauss(geometry, start, 100.0, 2000, stages, 0.0)
    });
}

/// Each coordinate feels its two neighbours.
#[divan::bench(args = [1, 2, 4, 8, 16])]
fn chain(bencher: Bencher, count: usize) {
    springs(bencher, count, |j, k| j + 1 == k);
}

#[divan::bench(args = [2, 4, 8, 16])]
fn all_to_all(bencher: Bencher, count: usize) {
    springs(bencher, count, |_, _| true);
}

#[divan::bench(args = ["schwarzschild-orbit", "kerr-inclined"])]
fn orbit(bencher: Bencher, name: &str) {
    engine(bencher, &case(name, ""), false, |geometry, start| Engine::equal(geometry, start, 300.0, 100, NODES));
}

/// Each of so many coordinates x feels x², and a coupled pair feels (x − y)⁴. Names are short, as a formula has at most
/// 1024 bytes.
fn springs(bencher: Bencher, count: usize, are_coupled: impl Fn(usize, usize) -> bool) {
    let names: Vec<String> = ('a'..='p').take(count).map(String::from).collect();
    let mut terms: Vec<String> = names.iter().map(|name| format!("{name}^2")).collect();
    for (j, one) in names.iter().enumerate() {
        terms.extend((0..j).filter(|&k| are_coupled(k, j)).map(|k| format!("({one}-{})^4", names[k])));
    }
    let start = names.iter().enumerate().map(|(k, name)| format!("{name}={:.3}\n{name}_dot=0.0\n", (k as f64).cos()));
    let (terms, start) = (terms.join("+"), start.collect::<String>());
    let text = format!(
        "potential = {{ coordinates = {names:?}, formula = \"{terms}\" }}\nparticle.law = \"newtonian\"\n\
         grid.gamma_f = 5.0\nsolver.accuracy = 1e-10\n[initial]\n{start}"
    );
    let case = Case::parse("springs", &text, &[]).expect("it is valid");
    engine(bencher, &case, false, |geometry, start| Engine::equal(geometry, start, 5.0, 100, NODES));
}

/// An engine solves all of its windows. It is made anew each time.
fn engine(
    bencher: Bencher,
    case: &Case,
    is_certified: bool,
    make: impl for<'g> Fn(&'g Geometry, &Start) -> Result<Engine<'g>, OutsideGeometry>,
) {
    let (geometry, start) = (case.geometry(), case.start());
    let run = || {
        let mut engine = make(&geometry, black_box(&start)).expect("it is inside");
        while let Some(mut window) = engine.next().expect("windows are short") {
            if is_certified {
                black_box(window.gradient_norm());
            }
        }
        engine.sweeps()
    };
    bencher.counter(ItemsCount::new(run())).bench_local(run);
}
