//! Windows of the weak scheme, quartic base case: γ_f = 1 at errors of 1e-13, γ_f = 1000 with |ΔK| < 7e-12. Divide by
//! the number of windows, or by that of evaluations, which are printed first.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use geodesic_ivp::case::SceneCase;
use geodesic_ivp::engine::lobatto::{Adaptive, Goal, Level, March, Marched, State, Twofold, WeakRule, WindowView};
use geodesic_ivp::geometry::metric::Metric;
use geodesic_ivp::geometry::potential::{Formula, Potential};
use geodesic_ivp::{Case, solve};

const POTENTIALS: [&str; 6] = ["named", "x^4/2", "x*x*x*x*0.5", "1 - cos(x)", MORSE, "(1 + x^2)^1.5"];

const MORSE: &str = "(1 - exp(-x))^2/2";

/// t and x of the quartic base case at γ = 1, from its continuum solution with 24 digits.
const EXACT: [f64; 2] = [1.468_634_756_955_731, 0.159_778_018_885_407_25];

fn main() {
    for potential in POTENTIALS {
        for (n, windows, gamma, tolerance) in [(24, 1, 1.0, 3e-13), (24, 900, 1000.0, 1e-13), (20, 4000, 1000.0, 0.0)] {
            let (metric, rule) = (metric(potential), WeakRule::new(n));
            let Marched { end, statistics } = run(&march(&metric, &rule, windows, gamma, tolerance), windows);
            let evaluations = statistics.evaluations;
            print!("{potential}: gamma_f {gamma}, n {n}, {windows} windows, {evaluations} evaluations");
            if potential.contains(['(']) {
                println!(", x {:.16}, t {:.16}", end.x.hi, end.t.hi);
            } else if gamma == 1.0 {
                println!(", errors of t and x {:.1e} and {:.1e}", end.t.hi - EXACT[0], end.x.hi - EXACT[1]);
            } else {
                println!(", dK {:.1e}", delta_k(&end));
            }
        }
    }
    divan::main();
}

fn metric(name: &str) -> Metric {
    let potential = match name {
        "named" => Potential::quartic(0.5),
        text => Potential::Formula(Formula::new(text, &BTreeMap::new()).expect("a valid formula")),
    };
    Metric::new(potential, 1.0, 1.0)
}

fn march<'a>(metric: &'a Metric, rule: &'a WeakRule, windows: usize, gamma: f64, tolerance: f64) -> March<'a> {
    let length = Twofold::from(gamma) / Twofold::from(windows as f64);
    March::new(metric, 2.0, rule, length).with_tolerance(tolerance)
}

fn run(march: &March<'_>, windows: usize) -> Marched {
    let start = State { t: 0.0.into(), x: 1.0.into(), w: 0.1.into() };
    let go_on = &mut |_: &WindowView<'_>| ControlFlow::Continue(());
    march.run(black_box(start), windows, go_on).expect("the run converges")
}

fn delta_k(state: &State) -> f64 {
    let square = state.x * state.x;
    let k = Twofold::from(4.0) / (square * square + Twofold::ONE) - state.w * state.w;
    (k - (Twofold::from(2.0) - Twofold::from(0.1) * Twofold::from(0.1))).hi
}

/// t and x at γ = 1, both with errors below 1e-13 (see what is printed), in one window.
#[divan::bench(args = POTENTIALS)]
fn one_unit(bencher: Bencher, potential: &str) {
    let (metric, rule) = (metric(potential), WeakRule::new(24));
    let march = march(&metric, &rule, 1, 1.0, 3e-13);
    bencher.bench_local(|| run(&march, 1));
}

/// A thousand units with |ΔK| < 7e-12.
#[divan::bench(args = POTENTIALS)]
fn a_thousand_units(bencher: Bencher, potential: &str) {
    let (metric, rule) = (metric(potential), WeakRule::new(24));
    let march = march(&metric, &rule, 900, 1000.0, 1e-13);
    bencher.counter(ItemsCount::new(900usize)).bench_local(|| run(&march, 900));
}

/// 4000 windows to rounding, with the twofold evaluation: what a million units are made of.
#[divan::bench(args = POTENTIALS)]
fn a_thousand_units_to_rounding(bencher: Bencher, potential: &str) {
    let (metric, rule) = (metric(potential), WeakRule::new(20));
    let march = march(&metric, &rule, 4000, 1000.0, 0.0);
    bencher.counter(ItemsCount::new(4000usize)).bench_local(|| run(&march, 4000));
}

/// A thousand units to an accuracy, with everything from the tables of the lengths to the error estimate.
#[divan::bench(args = [1e-4, 1e-6, 1e-8, 1e-10, 3e-13])]
fn a_thousand_units_adaptively(bencher: Bencher, accuracy: f64) {
    let metric = metric("named");
    let start = State { t: 0.0.into(), x: 1.0.into(), w: 0.1.into() };
    bencher.bench_local(|| {
        let go_on = &mut |_: &WindowView<'_>| ControlFlow::Continue(());
        Adaptive::new(&metric, 2.0).run(black_box(start), Goal::Gamma(1000.0), accuracy, go_on).expect("it is reached")
    });
}

/// The same for γ = 1.
#[divan::bench(args = [1e-4, 1e-7, 1e-10, 1e-13])]
fn one_unit_adaptively(bencher: Bencher, accuracy: f64) {
    let metric = metric("named");
    let start = State { t: 0.0.into(), x: 1.0.into(), w: 0.1.into() };
    bencher.bench_local(|| {
        let go_on = &mut |_: &WindowView<'_>| ControlFlow::Continue(());
        Adaptive::new(&metric, 2.0).run(black_box(start), Goal::Gamma(1.0), accuracy, go_on).expect("it is reached")
    });
}

const RUN: &str = "
grid = { gamma_f = 100.0, windows = 2000 }
scheme = { sbp = 'GLL20', form = 'weak' }
";

/// 2000 windows of GLL20 by `solve`, with the certificate and all that it stores, in one coordinate.
#[divan::bench]
fn given_windows_of_one_coordinate(bencher: Bencher) {
    let text = "potential.quartic.kappa = 0.5\ninitial = { t = 0.0, x = 1.0, t_dot = 1.0, x_dot = 0.1 }";
    let case = Case::parse("bench", &format!("{text}{RUN}"), &[]).expect("a valid case");
    bencher.bench_local(|| solve::<f64, _>(black_box(&case)).expect("it is solved"));
}

/// The same motion as a scene, in t and x.
#[divan::bench]
fn given_windows_of_a_scene(bencher: Bencher) {
    let text =
        "potential = { coordinates = ['x'], formula = 'x^4/2' }\ninitial = { x = 1.0, t_dot = 1.0, x_dot = 0.1 }";
    let case = SceneCase::parse("bench", &format!("{text}{RUN}"), &[]).expect("a valid scene");
    bencher.bench_local(|| solve(black_box(case.setup::<f64>())).expect("it is solved"));
}

/// The best instruction set against the others.
#[divan::bench(args = ["best", "avx2", "scalar"])]
fn levels(bencher: Bencher, level: &str) {
    let (metric, rule) = (metric("named"), WeakRule::new(16));
    let level = match level {
        "best" => Level::Best,
        "avx2" => Level::Avx2,
        _ => Level::Scalar,
    };
    let march = march(&metric, &rule, 2000, 1000.0, 1e-17).with_level(level);
    bencher.counter(ItemsCount::new(2000usize)).bench_local(|| run(&march, 2000));
}

/// The tables of one rule, and those of one length.
#[divan::bench(args = [16, 20, 24, 64])]
fn tables(bencher: Bencher, n: usize) {
    bencher.bench_local(|| WeakRule::new(black_box(n)));
}
