//! Random scenes, marched to a random accuracy and compared with other integrators.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::ControlFlow;

use geodesic_ivp::geodesic::InitialData;
use geodesic_ivp::lobatto::{Adaptive, Goal, Inside, WindowView};
use geodesic_ivp::methods::{Dop853, Output, Peer, Problem, Setting};
use geodesic_ivp::metric::Metric;
use geodesic_ivp::potential::{Formula, Potential};
use geodesic_ivp::reference::{ReferencePoint, ReferenceTrajectory};

use super::outcome::Outcome;
use super::random::Random;

/// Pieces on which the other integrators begin anew.
const PIECES: usize = 64;
/// How far they may be apart, as a share of the accuracy, to be believed; and what rounding may do in any case.
const AGREED: f64 = 0.1;
const ROUNDING: f64 = 1e-13;
/// The exact world-line is computed a little beyond the end.
const BEYOND: f64 = 1.001;

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
        let c: f64 = [1.0, 3.0, 10.0][random.next() as usize % 3];
        let strength = random.scale(0.05, 0.4) * c * c;
        let (kind, formula) = match random.next() % 6 {
            0 => ("cusp", format!("{strength}*sqrt(x^2 + {}^2)", random.scale(1e-4, 0.1))),
            1 => ("kink", format!("{strength}*abs(x - {})", random.between(-0.3, 0.3))),
            2 => ("wall", format!("{strength}*tanh({}*(x - 1))", random.scale(1.0, 200.0))),
            3 => ("power", format!("{strength}*x^{}", 2 * (2 + random.next() % 10))),
            4 => ("hump", format!("{strength}*exp(-((x - 1)/{})^2)", random.scale(0.15, 1.0))),
            _ => {
                let s = random.scale(1e-3, 0.1);
                ("cusps", format!("{strength}*(sqrt((x - 0.3)^2 + {s}^2) + abs(x + 0.2))"))
            }
        };
        let t_dot = random.scale(1.0, 4.0);
        let x = random.between(-0.9, 0.9);
        let initial = InitialData { t: 0.0, x, t_dot, x_dot: random.between(-0.6, 0.6) * c * t_dot };
        let length = random.scale(0.5, 12.0) / t_dot;
        Self::new(kind, formula, c, initial, Goal::Gamma(length), random.scale(1e-12, 1e-4))
    }

    fn new(kind: &'static str, formula: String, c: f64, initial: InitialData, goal: Goal, accuracy: f64) -> Self {
        let parsed = Formula::new(&formula, &BTreeMap::new()).expect("a valid formula");
        let metric = Metric::new(Potential::Formula(parsed), 1.0, c);
        Self { kind, formula, metric, initial, c, goal, accuracy }
    }

    /// Marches and compares.
    pub(crate) fn run(&self) -> Outcome {
        let Some(exact) = Exact::new(self) else { return Outcome::NoReference };
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
            let [exact_t, exact_x] = exact.at(gamma);
            errors = [errors[0].max((t - exact_t).abs()), errors[1].max((x - exact_x).abs())];
            sizes = [sizes[0].max(exact_t.abs()), sizes[1].max(exact_x.abs())];
        }
        if let Goal::Time(duration) = *goal {
            if adapted.end.t.hi.to_bits() != duration.to_bits() {
                return Outcome::Refused(format!("t ends at {}", adapted.end.t.hi));
            }
            // x where the exact t is the one asked for.
            let [t, x] = exact.at(adapted.gamma.hi);
            let velocity = adapted.end.w.hi * metric.at(adapted.end.x.hi).g00 / q_t;
            errors[1] = errors[1].max((adapted.end.x.hi - (x + velocity * (duration - t))).abs());
        }
        let error = (errors[0] / sizes[0]).max(errors[1] / sizes[1]) - exact.error - ROUNDING;
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

/// The exact world-line, as pieces.
struct Exact {
    pieces: Vec<(InitialData, ReferenceTrajectory)>,
    piece: f64,
    error: f64,
}

impl Exact {
    /// None where it leaves the domain, or cannot be told well enough.
    fn new(Scene { metric, initial, goal, accuracy, .. }: &Scene) -> Option<Self> {
        let length = match *goal {
            Goal::Gamma(length) => length,
            Goal::Time(duration) => ReferenceTrajectory::length_of(metric, *initial, duration, 16).ok()?,
        };
        let piece = BEYOND * length / PIECES as f64;
        let q_t = initial.invariants(metric).q_t;
        let (mut here, mut other) = (*initial, *initial);
        let (mut pieces, mut error) = (Vec::new(), 0.0_f64);
        for _ in 0..PIECES {
            let trajectory = ReferenceTrajectory::new(metric, here, piece, 16).ok()?;
            let ReferencePoint { elapsed, x, t_dot, x_dot } = trajectory.at(piece);
            pieces.push((here, trajectory));
            here = InitialData { t: here.t + elapsed, x, t_dot, x_dot };
            let problem = Problem { metric: metric.clone(), initial: other, length: piece };
            let state = *Dop853.run(&problem, &Output::even(1), Setting::tolerance(1e-15)).ok()?.states.last()?;
            let t_dot = q_t / metric.at(state.x).g00;
            other = InitialData { t: other.t + state.elapsed, x: state.x, t_dot, x_dot: state.w };
            let apart = [(here.t, other.t), (here.x, other.x)].map(|(a, b)| (a - b).abs() / a.abs().max(1.0));
            error = error.max(apart[0]).max(apart[1]);
        }
        (error <= AGREED * accuracy + ROUNDING).then_some(Self { pieces, piece, error })
    }

    fn at(&self, gamma: f64) -> [f64; 2] {
        let index = ((gamma / self.piece) as usize).min(PIECES - 1);
        let (start, trajectory) = &self.pieces[index];
        let point = trajectory.at(gamma - index as f64 * self.piece);
        [start.t + point.elapsed, point.x]
    }
}
