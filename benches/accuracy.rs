//! What `solver.accuracy` costs against the best windows picked by hand, and whether its promise is kept.
//!
//! Prints one line per accuracy, for every built-in case with a world-line that stays inside the domain and for long
//! runs. It has the largest true error at all nodes against the Taylor reference, the estimate, the time of the
//! adaptive march, and the time of the fastest march in equal windows whose true error at all nodes is below the same
//! accuracy. For the latter n, the number of windows and the tolerance of the iteration are tried out. Both times
//! include everything after the tables of the windows.
//!
//! ```text
//! cargo bench --bench accuracy [-- NAME]
//! ```

use std::ops::ControlFlow;
use std::time::Instant;

use geodesic_ivp::Case;
use geodesic_ivp::case::{End, builtin};
use geodesic_ivp::engine::lobatto::{Adaptive, Goal, March, Twofold, WeakRule, WindowView};
use geodesic_ivp::geometry::geodesic::InitialData;
use geodesic_ivp::geometry::metric::Metric;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::reference::ReferenceTrajectory;

/// Cases, and what is changed in them.
const SCENES: [(&str, &str); 18] = [
    ("free", ""),
    ("linear", ""),
    ("harmonic", ""),
    ("quartic", ""),
    ("quartic-t-dot-4", ""),
    ("quartic-t-dot-8", ""),
    ("pendulum", ""),
    ("morse", ""),
    ("double-well", ""),
    ("units", ""),
    ("tanh-wall", ""),
    ("pendulum-separatrix", ""),
    ("double-well-barrier", ""),
    ("power-20", ""),
    ("nearly-spacelike", ""),
    ("quartic", "grid.gamma_f=100.0"),
    ("pendulum", "grid.t_f=100.0"),
    ("quartic", "grid.gamma_f=1000.0"),
];
/// Nodes tried by hand.
const NODES: [usize; 8] = [8, 10, 12, 14, 16, 20, 24, 32];
/// Errors are compared at this many nodes at most.
const COMPARED: usize = 1500;

struct Scene {
    metric: Metric,
    initial: InitialData,
    q_t: f64,
    length: f64,
    reference: ReferenceTrajectory<Extended>,
}

impl Scene {
    fn new(name: &str, change: &str) -> Self {
        let text = builtin::text(name).expect("a shipped case");
        let overrides: Vec<String> = change.split_whitespace().map(str::to_owned).collect();
        let case = Case::parse(name, text, &overrides).expect("a valid case");
        let (metric, initial): (Metric, InitialData) = (case.metric(), case.initial_data());
        let length = match case.end::<f64>() {
            End::Length(length) => length,
            End::Duration(duration) => {
                ReferenceTrajectory::length_of(&metric, &initial, 0, duration, 16).expect("the time is reached")
            }
        };
        let exact = ReferenceTrajectory::new(&case.metric(), &case.initial_data(), Extended::from(length), 22);
        let q_t = initial.invariants(&metric).q_t;
        Self { metric, initial, q_t, length, reference: exact.expect("the world-line exists") }
    }

    /// The largest error at nodes (γ − γ_i, t, x), relative to max(1, largest |t − t_i|) and max(1, largest |x|).
    fn error(&self, nodes: &[(Twofold, f64, f64)]) -> f64 {
        let (mut errors, mut sizes) = ([0.0_f64; 2], [1.0_f64; 2]);
        for &(gamma, t, x) in nodes.iter().rev().step_by(nodes.len().div_ceil(COMPARED)) {
            let gamma = Extended::from(gamma.hi) + Extended::from(gamma.lo);
            let exact = self.reference.at(gamma.min(Extended::from(self.length)));
            let t = Extended::from(t) - Extended::from(self.initial.t);
            for (k, (found, exact)) in [(t, exact.elapsed), (Extended::from(x), exact.x)].into_iter().enumerate() {
                errors[k] = errors[k].max((found - exact).abs().to_f64());
                sizes[k] = sizes[k].max(exact.abs().to_f64());
            }
        }
        (errors[0] / sizes[0]).max(errors[1] / sizes[1])
    }

    fn march<'a>(&'a self, n: usize, windows: usize, tolerance: f64) -> March<'a> {
        let length = Twofold::from(self.length) / Twofold::from(windows as f64);
        March::new(&self.metric, self.q_t, WeakRule::shared(n), length).with_tolerance(tolerance)
    }

    /// Seconds of a march in equal windows.
    fn by_hand(&self, (n, windows, tolerance): (usize, usize, f64)) -> f64 {
        let start = Instant::now();
        let result = self.march(n, windows, tolerance).run(self.initial.into(), windows, &mut go_on);
        let seconds = start.elapsed().as_secs_f64();
        if result.is_ok() { seconds } else { f64::INFINITY }
    }

    fn keeps(&self, accuracy: f64, (n, windows, tolerance): (usize, usize, f64)) -> bool {
        let mut nodes = Vec::new();
        let result =
            self.march(n, windows, tolerance).run(self.initial.into(), windows, &mut |view| see(view, &mut nodes));
        result.is_ok() && self.error(&nodes) <= accuracy
    }

    /// For every n the fewest windows, and the loosest tolerance of the iteration, that keep the accuracy.
    fn hand_picked(&self, accuracy: f64) -> Vec<(usize, usize, f64)> {
        let of_rule = |n: usize| {
            let tight = 1e-3 * accuracy;
            let most = (64.0 * self.length).max(64.0);
            let windows = |k: i32| 1.06_f64.powi(k).round() as usize;
            let (mut low, mut high) = (0, most.log(1.06) as i32);
            while low < high {
                let middle = (low + high) / 2;
                if self.keeps(accuracy, (n, windows(middle), tight)) { high = middle } else { low = middle + 1 }
            }
            let tolerances = [3.0, 1.0, 0.3, 0.1, 0.03, 0.01, 1e-3].map(|factor| factor * accuracy);
            let tolerance = tolerances.into_iter().find(|&t| self.keeps(accuracy, (n, windows(low), t)))?;
            Some((n, windows(low), tolerance))
        };
        NODES.into_iter().filter_map(of_rule).collect()
    }
}

fn go_on(_: &WindowView<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn see(view: &WindowView<'_>, nodes: &mut Vec<(Twofold, f64, f64)>) -> ControlFlow<()> {
    if view.index == 0 {
        nodes.clear();
    }
    let inside = view.rule.nodes().iter().zip(view.t()).zip(view.x());
    nodes.extend(inside.map(|((&node, t), &x)| (view.gamma + node * view.length, t, x)));
    nodes.push((view.gamma + view.length, view.end.t.hi, view.end.x.hi));
    ControlFlow::Continue(())
}

fn main() {
    let wanted = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    println!("{:34}accuracy   error     estimate  attempts  windows   time (us)   by hand (us)         ratio", "case");
    let mut largest = 0.0_f64;
    for (name, change) in SCENES {
        if wanted.as_ref().is_some_and(|wanted| wanted != name) {
            continue;
        }
        let scene = Scene::new(name, change);
        for digits in 4..=13 {
            let accuracy = 10.0_f64.powi(-digits);
            let adaptive = |observe: &mut dyn FnMut(&WindowView<'_>) -> ControlFlow<()>| {
                let march = Adaptive::new(&scene.metric, scene.q_t);
                march.run(scene.initial.into(), Goal::Gamma(scene.length), accuracy, observe)
            };
            let mut nodes = Vec::new();
            let adapted = match adaptive(&mut |view| see(view, &mut nodes)) {
                Ok(adapted) => adapted,
                Err(failure) => {
                    println!("{name:16} {change:18} {accuracy:5.0e}  {failure}");
                    continue;
                }
            };
            let error = scene.error(&nodes);
            let picked = scene.hand_picked(accuracy);
            let rounds = (0.2 / (1e-6 * scene.length.max(1.0))) as usize / 50;
            let (mut seconds, mut best) = (f64::INFINITY, (f64::INFINITY, (0, 0, 0.0)));
            for _ in 0..rounds.clamp(8, 300) {
                let start = Instant::now();
                adaptive(&mut go_on).expect("it did before");
                seconds = seconds.min(start.elapsed().as_secs_f64());
                for &setting in &picked {
                    let by_hand = scene.by_hand(setting);
                    if by_hand < best.0 {
                        best = (by_hand, setting);
                    }
                }
            }
            let ratio = seconds / best.0;
            largest = largest.max(ratio);
            let kept = error <= accuracy && error <= adapted.error_estimate && adapted.error_estimate <= accuracy;
            println!(
                "{name:16} {change:18} {accuracy:5.0e}  {error:8.1e}  {:8.1e}  {:8}  {:7}  {:10.2}  \
                 {:10.2} ({:2} x {:5})  {ratio:5.2}{}",
                adapted.error_estimate,
                adapted.attempts,
                adapted.statistics.windows,
                1e6 * seconds,
                1e6 * best.0,
                best.1.0,
                best.1.1,
                if kept { "" } else { "  NOT KEPT" },
            );
        }
    }
    println!("largest ratio {largest:.2}");
}
