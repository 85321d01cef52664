//! The world-line that a study works on, as the case sets it up and as other methods compute it.

use std::cell::RefCell;
use std::sync::Arc;
use std::time::Instant;

use crate::case::{Case, default_iterations};
use crate::diagnostics::origin;
use crate::geometry::Start;
use crate::methods::{Problem, State};
use crate::number::norm::larger;
use crate::number::{Extended, Real};
use crate::reference::{ReferenceEnds, ReferenceTrajectory};
use crate::solve::{Limit, Place, Settings, Setup, System, WorldLine};

/// The run is searched for the end that a formula gives in so many stages, each twice as long as all before it: what
/// comes after that end need not exist.
const STAGES: i32 = 6;

/// The line that a case sets up.
pub(super) struct Subject {
    /// As the case has it, in extended precision.
    pub(super) exact: Setup<Extended>,
    /// As the case has it.
    pub(super) own: Setup,
    /// Without what belongs to one scheme only: in one window, without an accuracy, with D̄ and the default of most
    /// iterations. Its end is still that of the case.
    pub(super) plain: Setup,
    /// True if it is a world-line of Newton's law.
    pub(super) is_lifted: bool,
    /// See [`Problem::g00`].
    g00: Option<Vec<f64>>,
}

impl Subject {
    pub(super) fn new(case: &Case) -> Self {
        let own: Setup = case.setup();
        let settings = Settings {
            system: System::PhysicalLimit,
            regularised: true,
            digits: f64::MOST_DIGITS,
            accuracy: None,
            sensitivity: false,
            is_judged: true,
            windows: 1,
            max_iterations: default_iterations(),
            ..own.settings
        };
        let plain = Setup { gamma_i: 0.0, carried: None, settings, ..own.clone() };
        Self { exact: case.setup(), own, plain, is_lifted: case.is_lifted(), g00: case.g00() }
    }

    /// The place with another tangent, in units of its own.
    pub(super) fn stretched(&self, tangent: f64) -> Place {
        let Place { geometry, start } = &self.plain.place;
        if tangent == 1.0 {
            return self.plain.place.clone();
        }
        let q_dot: Vec<f64> = start.q_dot.iter().map(|rate| rate * tangent).collect();
        let p = geometry.momenta(&start.q, &q_dot);
        Place { geometry: Arc::clone(geometry), start: Arc::new(Start { q: start.q.clone(), q_dot, p }) }
    }

    /// The world-line from that place as a problem for other methods.
    pub(super) fn problem(&self, place: &Place, length: f64) -> Problem {
        let (space, start) = (place.geometry.clone(), (*place.start).clone());
        Problem { space, start, length, g00: self.g00.clone() }
    }
}

/// Does something. Returns also the seconds that it takes.
pub(super) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let done = work();
    (done, start.elapsed().as_secs_f64())
}

/// K of a state, and the rate of the first coordinate.
pub(super) fn norm_and_first_rate(problem: &Problem, State { q, p }: State<'_>) -> [f64; 2] {
    let rates = |q_dot: Vec<f64>| [problem.space.norm(q, &q_dot), q_dot[0]];
    problem.space.velocities(q, p).map_or([f64::NAN; 2], rates)
}

/// The distance of a coordinate from where its size is counted from: 0, or the start if it is ignorable.
pub(super) fn distance<S: Real>(place: &Place<S>, a: usize, q: S) -> f64 {
    (q - origin(place, a)).to_f64().abs()
}

/// The sizes of the coordinates by which errors are judged: the largest distances at these points. Those of one kind
/// share the largest.
pub(super) fn sizes<S: Real>(place: &Place<S>, points: impl Iterator<Item = Vec<S>>) -> Vec<f64> {
    let mut sizes = vec![f64::MIN_POSITIVE; place.start.q.len()];
    for q in points {
        for (a, size) in sizes.iter_mut().enumerate() {
            *size = larger(*size, distance(place, a, q[a]));
        }
    }
    place.geometry.shared(&place.start.q, &sizes)
}

/// γ_f − γ_i of the run that is set up, wherever it ends.
///
/// # Errors
/// [`ReferenceEnds`] if the world-line does not get there.
pub(super) fn length_of<S: Real>(setup: &Setup<S>) -> Result<S, ReferenceEnds> {
    let (geometry, start, digits) = (&*setup.place.geometry, &*setup.place.start, setup.settings.digits);
    let whole = match setup.limit {
        Limit::Length(length) => length,
        Limit::Value { coordinate, value } => {
            let value = value - setup.origin_of(coordinate);
            ReferenceTrajectory::length_of(geometry, start, coordinate, value, digits)?
        }
    };
    if setup.until.is_empty() {
        return Ok(whole);
    }
    let norm = geometry.norm(&start.q, &start.q_dot);
    for stage in (0..=STAGES).rev() {
        let length = whole * S::from(0.5_f64.powi(stage));
        let reference = ReferenceTrajectory::new(geometry, start, length, digits)?;
        let firsts = setup.until.iter().filter_map(|until| {
            let formula = RefCell::new(until.formula.clone());
            let value = |point: &Start<S>| formula.borrow_mut().at(&point.q, &point.q_dot, &point.p, norm);
            let mut changes = reference.directed_sign_changes(value).into_iter();
            changes.find(|(_, to_positive)| until.direction.counts(*to_positive)).map(|(gamma, _)| gamma)
        });
        if let Some(first) = firsts.reduce(|a, b| if a < b { a } else { b }) {
            return Ok(first);
        }
    }
    Ok(whole)
}

/// The rows of a run, counted as the points of the reference are.
pub(super) fn rows<S: Real>(line: &WorldLine<S>) -> Vec<Vec<S>> {
    let counted = |a: usize| line.counted_from_origin(a, &line.q[a]).collect();
    let of = |a: usize| if line.origin.is_some() { counted(a) } else { line.q(a).collect() };
    (0..line.geometry().dimension()).map(of).collect()
}
