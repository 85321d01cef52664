//! A world-line that other methods compute, too.

use crate::case::{Case, MAX_ITERATIONS};
use crate::methods::{Problem, State};
use crate::number::{Extended, Real};
use crate::solve::{Place, Settings, Setup, System, WorldLine};

/// A state as studies judge it.
pub(super) struct Judged {
    /// The coordinates, counted as those of a [`Point`](super::Point) are.
    pub(super) q: Vec<f64>,
    /// K.
    pub(super) k: f64,
    /// The rate of the first coordinate.
    pub(super) q0_dot: f64,
}

/// A state of a problem.
pub(super) fn judged(problem: &Problem, State { q, p }: State<'_>) -> Judged {
    let q_dot = problem.space.velocities(q, p).ok();
    let of = |number: &dyn Fn(&[f64]) -> f64| q_dot.as_deref().map_or(f64::NAN, number);
    let (k, q0_dot) = (of(&|q_dot| problem.space.norm(q, q_dot)), of(&|q_dot| q_dot[0]));
    Judged { q: q.to_vec(), k, q0_dot }
}

/// p_a at a node of a run in one window.
pub(super) fn momenta_at(line: &WorldLine, node: usize) -> Vec<f64> {
    let mut p = line.place.start.p.clone();
    for (row, &a) in line.p.iter().zip(line.geometry().active()) {
        p[a] = row[node];
    }
    p
}

/// The line that a case sets up, for studies.
pub(super) struct Line {
    /// As the case has it, in extended precision.
    pub(super) exact: Setup<Extended>,
    /// As the case has it.
    pub(super) own: Setup,
    /// Without what belongs to one scheme only: in one window, without an accuracy, with D̄ and the default of most
    /// iterations. Its end is still that of the case.
    pub(super) plain: Setup,
    /// True if it is a world-line of Newton's law.
    pub(super) is_lifted: bool,
    /// True if it is that of a scene.
    pub(super) is_scene: bool,
    /// See [`Problem::g00`].
    pub(super) g00: Option<Vec<f64>>,
}

impl Line {
    /// Makes the line that `case` sets up.
    pub(super) fn new(case: &Case) -> Self {
        let own: Setup = case.setup();
        let settings = Settings {
            system: System::PhysicalLimit,
            digits: f64::MOST_DIGITS,
            accuracy: None,
            sensitivity: false,
            windows: 1,
            max_iterations: MAX_ITERATIONS,
            ..own.settings
        };
        let plain = Setup { gamma_i: 0.0, carried: None, regularised: true, settings, ..own.clone() };
        let (is_lifted, is_scene, g00) = (case.is_lifted(), !case.is_of_x(), case.g00());
        Self { exact: case.setup(), own, plain, is_lifted, is_scene, g00 }
    }

    /// The world-line from that place as a problem for other methods.
    pub(super) fn problem(&self, place: &Place, length: f64) -> Problem {
        let (space, start) = (place.geometry.clone(), (*place.start).clone());
        Problem { space, start, length, g00: self.g00.clone() }
    }
}
