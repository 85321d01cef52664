//! Other methods for the same world-line: what a user would take instead of this program's schemes, to compare with.
//!
//! ```text
//! t′ = Q_t/g00(x),     x′ = w,     w′ = −½ g00′(x) (Q_t/g00(x))²,     ′ = d/dγ
//! ```
//!
//! is the canonical system of H = w²/2 − Q_t²/(2 g00(x)) with the quadrature of t beside it. H is separable, and
//! K = −2H. Every method here has Q_t as a *parameter*: they deserve no credit for its being constant, and comparing
//! its drift alone would show nothing. Position, time and K decide.
//!
//! A scene of n coordinates is a [`Problem`] in a geometry. Its equations are those of Hamilton, for the active
//! coordinates and their momenta; ignorable coordinates are quadratures, and charges are parameters as Q_t is. If the
//! geometry is separable, they are q̈ = a(q), of the same form as above, and the methods take advantage of it.
//! Compositions need that.
//!
//! [`PEERS`] lists the methods. Each is a [`Peer`], which says what it is and where it comes from.
//! What is around the steps is the same for all. All but Taylor are compiled for the vector instructions of the
//! machine, as this program's own iteration is: the point is to be fair to them. In one coordinate each evaluates g00
//! and g00′ and nothing else, once a stage; in a scene it runs the program of Hamilton's equations.
//!
//! ```
//! use geodesic_ivp::Case;
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::methods::{Output, Peer, Problem, Setting};
//!
//! let case = Case::parse("quartic", builtin::text("quartic").expect("it is built in"), &[])?;
//! let problem = Problem { space: case.geometry().into(), start: case.start(), length: 1.0, g00: case.g00() };
//! let trajectory = Peer::Taylor.run(&problem, &Output::even(4), Setting::tolerance(1e-14))?;
//! assert!((trajectory.states.at(3).q[1] - 0.159_778_018_885_407).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod composition;
mod dop853;
mod driver;
mod equations;
mod peer;
mod potential;
mod radau5;
mod rk4;
mod scene;
mod taylor;
mod windows;

pub use peer::{About, PEERS, Peer, Prepared, Setting, Step};

use std::iter::Peekable;
use std::sync::Arc;

use crate::geometry::{Geometry, Start};

/// A method gives up after this many steps.
pub const MOST_STEPS: usize = 20_000_000;

/// A world-line to compute.
#[derive(Debug, Clone)]
pub struct Problem {
    /// The space-time; a geometry is around the start.
    pub space: Arc<Geometry>,
    /// The start. In one coordinate t counts from there.
    pub start: Start,
    /// γ_f − γ_i.
    pub length: f64,
    /// The coefficients of g00(x), lowest power first, in one coordinate with a polynomial potential: what a user of
    /// these methods would write by hand.
    pub g00: Option<Vec<f64>>,
}

/// Where the world-line is wanted: at γ − γ_i = length · mark/intervals for every mark.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Output {
    /// Parts of equal length.
    pub intervals: usize,
    /// Ends of parts, ascending, from 1 to at most `intervals`.
    pub marks: Vec<usize>,
}

impl Output {
    /// At the end of each of `intervals` parts.
    pub fn even(intervals: usize) -> Self {
        Self { intervals, marks: (1..=intervals).collect() }
    }

    /// The index of the step that has each mark, among so many steps of equal length, and where it is in that step, in
    /// (0, 1].
    fn places(&self, steps: usize) -> Peekable<impl Iterator<Item = (usize, f64)> + '_> {
        assert!(steps > 0 && self.intervals > 0, "no steps");
        let place = move |&mark: &usize| {
            let step = (mark * steps).div_ceil(self.intervals) - 1;
            (step, (mark * steps - step * self.intervals) as f64 / self.intervals as f64)
        };
        self.marks.iter().map(place).peekable()
    }

    /// γ − γ_i of the marks.
    pub fn gamma(&self, length: f64) -> impl Iterator<Item = f64> + '_ {
        self.marks.iter().map(move |&mark| length * (mark as f64 / self.intervals as f64))
    }
}

/// A point of the world-line of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<'s> {
    /// q^a of all coordinates.
    pub q: &'s [f64],
    /// p_a of all coordinates.
    pub p: &'s [f64],
}

/// Points of a world-line.
#[derive(Debug, Clone, PartialEq)]
pub struct States {
    dimension: usize,
    /// q and then p of each.
    values: Vec<f64>,
}

impl States {
    /// None so far, of so many coordinates, with room for `capacity`.
    pub(crate) fn new(dimension: usize, capacity: usize) -> Self {
        Self { dimension, values: Vec::with_capacity(2 * dimension * capacity) }
    }

    pub(crate) fn push(&mut self, q: &[f64], p: &[f64]) {
        self.values.extend_from_slice(q);
        self.values.extend_from_slice(p);
    }

    fn clear(&mut self) {
        self.values.clear();
    }

    /// Their number.
    pub fn len(&self) -> usize {
        self.iter().len()
    }

    /// Returns true if there are none.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// One after the other.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = State<'_>> {
        self.values.chunks_exact(2 * self.dimension).map(|state| {
            let (q, p) = state.split_at(self.dimension);
            State { q, p }
        })
    }

    /// The one at this place.
    ///
    /// # Panics
    /// If there are fewer.
    pub fn at(&self, place: usize) -> State<'_> {
        self.iter().nth(place).expect("there are more points")
    }

    /// The last one.
    pub fn last(&self) -> Option<State<'_>> {
        self.iter().last()
    }
}

/// A world-line that was computed.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// At the marks of the [`Output`].
    pub states: States,
    /// Evaluations of the potential; for a series its coefficients.
    pub evaluations: usize,
    /// Steps, rejected ones not counted.
    pub steps: usize,
}

/// Why no world-line was computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.as_str())]
pub enum Failure {
    /// It meets g00 ≤ 0, or a determinant of the metric changes its sign.
    OutsideDomain,
    /// A number is not finite.
    Diverged,
    /// More than [`MOST_STEPS`], or steps that shrink without end.
    TooManySteps,
    /// The iteration of an implicit method does not converge.
    NotConverged,
    /// Windows add up to more than the accuracy.
    AccuracyNotReached,
    /// The method needs equations of the second order.
    NotSeparable,
}

impl Failure {
    /// A word for files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::OutsideDomain => "outside-domain",
            Self::Diverged => "diverged",
            Self::TooManySteps => "too-many-steps",
            Self::NotConverged => "not-converged",
            Self::AccuracyNotReached => "accuracy-not-reached",
            Self::NotSeparable => "not-separable",
        }
    }
}
