//! What a certified and stored run costs against the bare march of the same windows.
//!
//! For three potentials and two lengths the march of [`March`], the run of [`solve`] in the same windows, and, for
//! three accuracies, the march of [`Adaptive`] and the run with `solver.accuracy`. They are timed in turns in one
//! process, together with writing as many numbers as the run keeps to new memory, which the march does without; the
//! shortest times are printed with the ratio of the first two.
//!
//! ```text
//! cargo bench --bench certified [-- NAME]
//! ```

use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::Instant;

use geodesic_ivp::engine::lobatto::{Adaptive, Goal, March, Twofold, WeakRule, WindowView};
use geodesic_ivp::geometry::metric::Metric;
use geodesic_ivp::solve::Setup;
use geodesic_ivp::{Case, Solution, case::builtin, solve};

/// Seconds that a row is timed for at least.
const PATIENCE: f64 = 0.3;

/// The shortest seconds of a march, of the run, and of writing what a run like `kept` keeps; all in turns.
fn in_turns(kept: &Solution, mut march: impl FnMut(), mut run: impl FnMut()) -> [f64; 3] {
    let mut least = [f64::INFINITY; 3];
    let mut write = || {
        black_box((kept.elapsed().to_vec(), kept.x().to_vec(), kept.windows.clone()));
    };
    let begin = Instant::now();
    let mut rounds = 0;
    while rounds < 5 || begin.elapsed().as_secs_f64() < PATIENCE {
        let works: [&mut dyn FnMut(); 3] = [&mut march, &mut run, &mut write];
        for (least, work) in least.iter_mut().zip(works) {
            let start = Instant::now();
            work();
            *least = least.min(start.elapsed().as_secs_f64());
        }
        rounds += 1;
    }
    least
}

fn go_on(_: &WindowView<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn case(name: &str, overrides: &[String]) -> Case {
    Case::parse(name, builtin::text(name).expect("a shipped case"), overrides).expect("a valid case")
}

fn report(name: &str, what: &str, windows: usize, times: [f64; 3]) {
    let [march, run, write] = times.map(|seconds| 1e6 * seconds);
    println!("{name:10} {what:34} {windows:6} windows {march:10.3} {run:10.3} {write:10.3} μs {:6.2}", run / march);
}

/// Windows of `length` with 20 nodes, to rounding.
fn to_rounding(name: &str, gamma_f: f64, length: f64) {
    let windows = (gamma_f / length).round() as usize;
    let case = case(
        name,
        &[
            "scheme.sbp=GLL20".to_owned(),
            "scheme.form=weak".to_owned(),
            "grid.n_gamma=20".to_owned(),
            format!("grid={{gamma_f={gamma_f:?},n_gamma=20,windows={windows}}}"),
        ],
    );
    let (metric, initial) = (case.metric(), case.initial_data());
    let march = March::new(
        &metric,
        initial.invariants(&metric).q_t,
        WeakRule::shared(20),
        Twofold::from(gamma_f) / Twofold::from(windows as f64),
    );
    let setup = Setup::<f64, Metric>::from(&case);
    let run = || -> Solution { solve(black_box(setup.clone())).expect("the run converges") };
    let times = in_turns(
        &run(),
        || {
            black_box(march.run(initial.into(), windows, &mut go_on).expect("the march converges"));
        },
        || {
            black_box(run());
        },
    );
    report(name, &format!("gamma_f {gamma_f}, windows of {length}"), windows, times);
}

/// Windows chosen for an accuracy.
fn to_accuracy(name: &str, gamma_f: f64, accuracy: f64) {
    let case = case(name, &[format!("solver={{accuracy={accuracy:e}}}"), format!("grid={{gamma_f={gamma_f:?}}}")]);
    let (metric, initial) = (case.metric(), case.initial_data());
    let q_t = initial.invariants(&metric).q_t;
    let goal = Goal::Gamma(gamma_f);
    let setup = Setup::<f64, Metric>::from(&case);
    let what = format!("gamma_f {gamma_f}, accuracy {accuracy:e}");
    let run = || solve(black_box(setup.clone()));
    let kept = match run() {
        Ok(kept) => kept,
        Err(refused) => return println!("{name:10} {what:34} refused: {refused}"),
    };
    let times = in_turns(
        &kept,
        || {
            let march = Adaptive::new(&metric, q_t).run(initial.into(), goal, accuracy, &mut go_on);
            black_box(march.expect("the run has reached it"));
        },
        || {
            black_box(run().expect("it has done so before"));
        },
    );
    report(name, &what, kept.window_count, times);
}

fn main() {
    let only: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    println!("{:61} {:>10} {:>10} {:>10} {:>9}", "", "march", "run", "write", "ratio");
    for name in ["quartic", "morse", "pendulum"] {
        if !only.is_empty() && !only.iter().any(|only| name.contains(only.as_str())) {
            continue;
        }
        for gamma_f in [1.0, 1000.0] {
            to_rounding(name, gamma_f, 0.25);
            to_rounding(name, gamma_f, 0.5);
            to_rounding(name, gamma_f, 1.0);
            for accuracy in [1e-4, 1e-8, 1e-12] {
                to_accuracy(name, gamma_f, accuracy);
            }
        }
    }
}
