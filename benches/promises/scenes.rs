//! Random scenes, solved to a random accuracy and compared with other integrators.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::ControlFlow;

use geodesic_ivp::engine::{Accuracy, Engine, POINTS};
use geodesic_ivp::geometry::geodesic::InitialData;
use geodesic_ivp::geometry::metric::Metric;
use geodesic_ivp::geometry::potential::{Formula, Potential};
use geodesic_ivp::reference::ReferenceTrajectory;

use super::outcome::Outcome;
use super::random::Random;
use super::rough::Rough;
use super::truth::Truth;

/// How far they may be apart, as a share of the accuracy, to be believed; and what rounding may do in any case.
const AGREED: f64 = 0.1;
const ROUNDING: f64 = 1e-13;

/// Where a run ends.
#[derive(Debug, Clone, Copy)]
enum Goal {
    Gamma(f64),
    Time(f64),
}

/// What to solve, and how well.
pub(crate) struct Scene {
    pub(crate) kind: &'static str,
    formula: String,
    metric: Metric,
    initial: InitialData,
    c: f64,
    goal: Goal,
    accuracy: f64,
}

/// Smooth potentials, each with x at the start.
const SMOOTH: [(&str, f64); 4] =
    [("x^4/2", 1.0), ("0.1*(1 - cos(x))", 1.0), ("0.3*(1 - exp(-x))^2", 0.8), ("0.1*(x^2 - 1)^2", 0.4)];

impl Scene {
    /// Smooth, to a time.
    pub(crate) fn smooth(random: &mut Random) -> Self {
        let (formula, x) = SMOOTH[random.next() as usize % SMOOTH.len()];
        let initial = InitialData { t: 0.0, x, t_dot: 1.0, x_dot: random.between(-0.2, 0.2) };
        let (goal, accuracy) = (Goal::Time(random.between(0.05, 3.0)), random.scale(1e-12, 1e-6));
        Self::new("smooth, t_f", formula.to_owned(), 1.0, initial, goal, accuracy)
    }

    /// With something in it that is no polynomial on a window.
    pub(crate) fn rough(random: &mut Random) -> Self {
        let Rough { kind, formula, c, start: [x, t_dot, x_dot], length } =
            Rough::new(random, 1e-4, |random| [1.0, random.scale(0.15, 1.0)]);
        let initial = InitialData { t: 0.0, x, t_dot, x_dot };
        Self::new(kind, formula, c, initial, Goal::Gamma(length), random.scale(1e-12, 1e-4))
    }

    fn new(kind: &'static str, formula: String, c: f64, initial: InitialData, goal: Goal, accuracy: f64) -> Self {
        let parsed = Formula::new(&formula, &BTreeMap::new()).expect("a valid formula");
        let metric = Metric::new(Potential::Formula(parsed), 1.0, c);
        Self { kind, formula, metric, initial, c, goal, accuracy }
    }

    /// None where it leaves the domain, or cannot be told well enough.
    fn truth(&self) -> Option<Truth> {
        let Self { metric, initial, goal, accuracy, .. } = self;
        let length = match *goal {
            Goal::Gamma(length) => length,
            Goal::Time(duration) => ReferenceTrajectory::length_of(metric, initial, 0, duration, 16).ok()?,
        };
        Truth::one(metric, *initial, length).filter(|truth| truth.apart <= AGREED * accuracy + ROUNDING)
    }

    /// Solves and compares.
    pub(crate) fn run(&self) -> Outcome {
        let Some(exact) = self.truth() else { return Outcome::NoReference };
        let Self { metric, initial, goal, accuracy, .. } = self;
        let (mut nodes, start, wanted) = (Vec::new(), initial.start(metric), Accuracy::Promised(*accuracy));
        let engine = match *goal {
            Goal::Gamma(length) => Engine::accurate(metric.scene(), &start, length, wanted, POINTS),
            Goal::Time(t) => Engine::accurate_to_value(metric.scene(), &start, (0, t), wanted, POINTS),
        };
        let mut engine = engine.expect("a start inside the domain");
        let run = engine.run(|mut window| {
            if window.index == 0 {
                nodes.clear();
            }
            let (gamma, h, dense, begin) = (window.gamma, window.length, window.dense(), window.start().positions());
            let active = metric.scene().active();
            let rows = window.nodes();
            let origin = |a: usize| if active.contains(&a) { 0.0 } else { begin[a] };
            for (k, fraction) in rows.fractions().iter().enumerate() {
                nodes.push((gamma + fraction * h, [0, 1].map(|a| origin(a) + rows.q(a)[k])));
            }
            // Half way between nodes, and at the end.
            let between = rows.fractions().windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
            for fraction in between.chain([1.0]) {
                let (mut q, mut p) = ([0.0; 2], vec![0.0; active.len()]);
                dense.at(fraction, &mut q, &mut p);
                nodes.push((gamma + fraction * h, q));
            }
            ControlFlow::Continue(())
        });
        if let Err(failure) = run {
            return Outcome::Refused(failure.as_str().to_owned());
        }
        let (mut errors, mut sizes) = ([0.0_f64; 2], [1.0_f64; 2]);
        for (gamma, q) in nodes {
            for (a, (found, exact)) in q.into_iter().zip(exact.at(gamma)).enumerate() {
                errors[a] = errors[a].max((found - exact).abs());
                sizes[a] = sizes[a].max(exact.abs());
            }
        }
        if let Goal::Time(duration) = *goal {
            let (gamma, end) = engine.place();
            if end[0].to_bits() != duration.to_bits() {
                return Outcome::Refused(format!("t ends at {}", end[0]));
            }
            // x where the exact t is the one asked for.
            let (there, x_dot) = (exact.at(gamma), -engine.window().end().momenta()[0]);
            let velocity = x_dot * metric.at(end[1]).g00 / start.p[0];
            errors[1] = errors[1].max((end[1] - (there[1] + velocity * (duration - there[0]))).abs());
        }
        let error = (errors[0] / sizes[0]).max(errors[1] / sizes[1]) - exact.apart - ROUNDING;
        let estimate = engine.error_estimate().expect("it has one");
        match error {
            error if error > *accuracy => Outcome::Broken { error, estimate },
            error if error > estimate => Outcome::TooLow { error, estimate },
            _ => Outcome::Kept { error, estimate },
        }
    }
}

impl fmt::Display for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { formula, initial: InitialData { x, t_dot, x_dot, .. }, c, goal, accuracy, .. } = self;
        write!(
            f,
            "V = {formula}, c = {c}, x = {x}, t_dot = {t_dot}, x_dot = {x_dot}, {goal:?}, accuracy = {accuracy:e}"
        )
    }
}
