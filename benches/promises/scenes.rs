//! Random scenes, marched to a random accuracy and compared with other integrators.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::ControlFlow;

use geodesic_ivp::engine::lobatto::{Adaptive, Goal, Inside, WindowView};
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

/// What to march, and how well.
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

    /// Marches and compares.
    pub(crate) fn run(&self) -> Outcome {
        let Some(exact) = self.truth() else { return Outcome::NoReference };
        let Self { metric, initial, goal, accuracy, .. } = self;
        let mut nodes = Vec::new();
        let mut see = |view: &WindowView<'_>| {
            if view.index == 0 {
                nodes.clear();
            }
            for (node, (&x, t)) in view.rule.nodes().iter().zip(view.x().iter().zip(view.t())) {
                nodes.push(((view.gamma + *node * view.length).hi, t, x));
            }
            nodes.push(((view.gamma + view.length).hi, view.end.t.hi, view.end.x.hi));
            // The dense output half way between nodes.
            let places = view.rule.nodes().windows(2).map(|pair| 0.5 * (pair[0].hi + pair[1].hi));
            let mut gammas = places.clone().map(|place| (view.gamma + view.length * place).hi);
            view.inside(places, |Inside { t, x, .. }| {
                nodes.extend(gammas.next().map(|gamma| (gamma, t, x)));
            });
            ControlFlow::Continue(())
        };
        let q_t = initial.invariants(metric).q_t;
        let adapted = match Adaptive::new(metric, q_t).run((*initial).into(), *goal, *accuracy, &mut see) {
            Ok(adapted) => adapted,
            Err(failure) => return Outcome::Refused(failure.to_string()),
        };
        let (mut errors, mut sizes) = ([0.0_f64; 2], [1.0_f64; 2]);
        for (gamma, t, x) in nodes {
            for (a, (found, exact)) in [t, x].into_iter().zip(exact.at(gamma)).enumerate() {
                errors[a] = errors[a].max((found - exact).abs());
                sizes[a] = sizes[a].max(exact.abs());
            }
        }
        if let Goal::Time(duration) = *goal {
            if adapted.end.t.hi.to_bits() != duration.to_bits() {
                return Outcome::Refused(format!("t ends at {}", adapted.end.t.hi));
            }
            // x where the exact t is the one asked for.
            let there = exact.at(adapted.gamma.hi);
            let velocity = adapted.end.w.hi * metric.at(adapted.end.x.hi).g00 / q_t;
            errors[1] = errors[1].max((adapted.end.x.hi - (there[1] + velocity * (duration - there[0]))).abs());
        }
        let error = (errors[0] / sizes[0]).max(errors[1] / sizes[1]) - exact.apart - ROUNDING;
        let estimate = adapted.error_estimate;
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
