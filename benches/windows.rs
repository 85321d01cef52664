//! Windows that are given, to rounding.
//!
//! V = x⁴/2 is solved in 2000 windows of 20 nodes by `solve`, in one coordinate and as a scene, and by the engine,
//! with and without certificates; it is also solved in steps of Gauss' method. Scenes with more and more coordinates,
//! and orbits around black holes, are solved in 100 windows by the engine. Its items are sweeps: evaluations of the
//! equations on all nodes of a window with the integrals that follow.
//!
//! ```text
//! cargo bench --bench windows [-- NAME]
//! ```

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use geodesic_ivp::case::{Case, builtin};
use geodesic_ivp::engine::Engine;
use geodesic_ivp::geometry::{Geometry, OutsideGeometry, Start};
use geodesic_ivp::solve;

const NODES: usize = 20;
const RUN: &str = "
grid = { gamma_f = 100.0, windows = 2000 }
scheme = { sbp = 'GLL20', form = 'weak' }
";

fn main() {
    divan::main();
}

fn scene(text: &str) -> Case {
    Case::parse("bench", text, &[]).expect("a valid scene")
}

fn quartic() -> Case {
    let motion =
        "potential = { coordinates = ['x'], formula = 'x^4/2' }\ninitial = { x = 1.0, t_dot = 1.0, x_dot = 0.1 }";
    scene(&format!("{motion}{RUN}"))
}

/// This makes the certificate and stores all that a run keeps.
#[divan::bench]
fn solve_one_coordinate(bencher: Bencher) {
    let motion = "potential.quartic.kappa = 0.5\ninitial = { t = 0.0, x = 1.0, t_dot = 1.0, x_dot = 0.1 }";
    let case = Case::parse("bench", &format!("{motion}{RUN}"), &[]).expect("a valid case");
    bencher.bench_local(|| solve::<f64>(black_box(&case)).expect("it is solved"));
}

#[divan::bench]
fn solve_scene(bencher: Bencher) {
    let case = quartic();
    bencher.bench_local(|| solve(black_box(case.setup::<f64>())).expect("it is solved"));
}

#[divan::bench]
fn engine_bare(bencher: Bencher) {
    engine(bencher, &quartic(), false, |geometry, start| Engine::equal(geometry, start, 100.0, 2000, NODES));
}

#[divan::bench]
fn engine_certified(bencher: Bencher) {
    engine(bencher, &quartic(), true, |geometry, start| Engine::equal(geometry, start, 100.0, 2000, NODES));
}

#[divan::bench(args = [2, 4, 8, 12])]
fn gauss_stages(bencher: Bencher, stages: usize) {
    engine(bencher, &quartic(), false, |geometry, start| Engine::gauss(geometry, start, 100.0, 2000, stages, 0.0));
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
    let case = scene(builtin::text(name).expect("a shipped scene"));
    engine(bencher, &case, false, |geometry, start| Engine::equal(geometry, start, 300.0, 100, NODES));
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
    let case = scene(&format!(
        "potential = {{ coordinates = {names:?}, formula = \"{terms}\" }}\nparticle.law = \"newtonian\"\n\
         grid.gamma_f = 5.0\nsolver.accuracy = 1e-10\n[initial]\n{start}"
    ));
    engine(bencher, &case, false, |geometry, start| Engine::equal(geometry, start, 5.0, 100, NODES));
}

/// An engine solves all of its windows. It is made anew each time.
fn engine(
    bencher: Bencher,
    case: &Case,
    is_certified: bool,
    make: impl for<'g> Fn(&'g Geometry, &Start) -> Result<Engine<'g>, OutsideGeometry>,
) {
    let (geometry, start): (Geometry, Start) = (case.geometry(), case.start());
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
