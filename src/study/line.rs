//! A world-line that other methods compute, too.

use super::space::{Point, Studied};
use crate::case::Solver;
use crate::geometry::Geometry;
use crate::geometry::metric::Metric;
use crate::methods::{Driven, Problem, SceneState, State};
use crate::number::{Extended, Real};
use crate::solve::{Place, Settings, Setup, Space, System, WorldLine};

/// A state as studies judge it.
pub(super) struct Judged {
    /// The coordinates, counted as those of a [`Point`] are.
    pub(super) q: Vec<f64>,
    /// K.
    pub(super) k: f64,
    /// The rate of the first coordinate.
    pub(super) q0_dot: f64,
}

/// A space-time in which world-lines are solved for, and computed by other methods.
pub(super) trait Raced: Studied<f64> + Space<f64, Rough = Self> + Driven<State: Send + Sync> {
    /// The same kind in extended precision.
    type Exact: Studied<Extended>;

    /// A state of a problem.
    fn judged(problem: &Problem<Self>, state: Self::State) -> Judged;

    /// K at a point of the reference of a problem.
    fn k(problem: &Problem<Self>, point: &Point) -> f64;

    /// The state with these coordinates and momenta.
    fn state_of(q: Vec<f64>, p: Vec<f64>) -> Self::State;

    /// p_a at a node of a run in one window.
    fn momenta_at(line: &WorldLine<f64, Self>, node: usize) -> Vec<f64>;
}

impl Raced for Metric {
    type Exact = Metric<Extended>;

    fn judged(problem: &Problem, State { elapsed, x, w }: State) -> Judged {
        let (q_t, g00) = (problem.q_t(), problem.space.g00(x));
        Judged { q: vec![elapsed, x], k: q_t * (q_t / g00) - w * w, q0_dot: q_t / g00 }
    }

    fn k(problem: &Problem, _: &Point) -> f64 {
        problem.start.invariants(&problem.space).k
    }

    /// The momentum of x is minus its velocity.
    fn state_of(q: Vec<f64>, p: Vec<f64>) -> State {
        State { elapsed: q[0], x: q[1], w: -p[1] }
    }

    fn momenta_at(line: &WorldLine<f64, Self>, node: usize) -> Vec<f64> {
        vec![line.invariants().q_t, -line.sbp().derivative_at(line.x(), node)]
    }
}

impl Raced for Geometry {
    type Exact = Geometry<Extended>;

    fn judged(problem: &Problem<Self>, SceneState { q, p }: SceneState) -> Judged {
        let q_dot = problem.space.velocities(&q, &p).ok();
        let of = |number: &dyn Fn(&[f64]) -> f64| q_dot.as_deref().map_or(f64::NAN, number);
        let (k, q0_dot) = (of(&|q_dot| problem.space.norm(&q, q_dot)), of(&|q_dot| q_dot[0]));
        Judged { q, k, q0_dot }
    }

    fn k(problem: &Problem<Self>, Point { q, q_dot, .. }: &Point) -> f64 {
        problem.space.norm(q, q_dot)
    }

    fn state_of(q: Vec<f64>, p: Vec<f64>) -> SceneState {
        SceneState { q, p }
    }

    fn momenta_at(line: &WorldLine, node: usize) -> Vec<f64> {
        let mut p = line.place.start.p.clone();
        for (row, &a) in line.p.iter().zip(line.geometry().active()) {
            p[a] = row[node];
        }
        p
    }
}

/// What a case sets up, for studies.
pub(super) struct Line<G: Raced> {
    /// As the case has it, in extended precision.
    pub(super) exact: Setup<Extended, G::Exact>,
    /// As the case has it.
    pub(super) own: Setup<f64, G>,
    /// Without what belongs to one scheme only: in one window, without an accuracy, with D̄ and the default of most
    /// iterations. Its end is still that of the case.
    pub(super) plain: Setup<f64, G>,
    /// Whether it is a world-line of Newton's law.
    pub(super) is_lifted: bool,
}

impl<G: Raced> Line<G> {
    /// What `case` sets up.
    pub(super) fn new<C>(case: &C, is_lifted: bool) -> Self
    where
        for<'c> Setup<f64, G>: From<&'c C>,
        for<'c> Setup<Extended, G::Exact>: From<&'c C>,
    {
        let own: Setup<f64, G> = case.into();
        let settings = Settings {
            system: System::PhysicalLimit,
            digits: f64::MOST_DIGITS,
            accuracy: None,
            windows: 1,
            max_iterations: Solver::default().max_iterations,
            ..own.settings
        };
        let plain = Setup { gamma_i: 0.0, regularised: true, settings, ..own.clone() };
        Self { exact: case.into(), own, plain, is_lifted }
    }

    /// The world-line from that place as a problem for other methods.
    pub(super) fn problem(place: &Place<f64, G>, length: f64) -> Problem<G> {
        Problem { space: place.geometry.clone(), start: G::start(place), length }
    }
}
