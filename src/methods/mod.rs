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
//! [`Composition`] needs that.
//!
//! [`PEERS`] lists the methods. Each is a [`Peer`]: it says what it is, where it comes from and how it takes a step.
//! What is around the steps is the same for all. All but Taylor are compiled for the vector instructions of the
//! machine, as this program's own iteration is: the point is to be fair to them. In one coordinate each evaluates g00
//! and g00′ and nothing else, once a stage; in a scene it runs the program of Hamilton's equations.
//!
//! ```
//! use geodesic_ivp::Case;
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::methods::{Output, Peer, Problem, Setting, Taylor};
//!
//! let case = Case::parse("quartic", builtin::text("quartic").expect("it is built in"), &[])?;
//! let problem = Problem { space: case.geometry().into(), start: case.start(), length: 1.0, g00: case.g00() };
//! let trajectory = Taylor.run(&problem, &Output::even(4), Setting::tolerance(1e-14))?;
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
mod states;
mod taylor;
mod windows;

pub use composition::Composition;
pub use dop853::Dop853;
pub use peer::{About, PEERS, Peer, Prepared, Setting, Step};
pub use radau5::Radau5;
pub use rk4::Rk4;
pub use states::{State, States};
pub use taylor::Taylor;
pub use windows::Windows::{self, Gauss};

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
    /// Ends of parts, ascending, each at most `intervals`.
    pub marks: Vec<usize>,
}

impl Output {
    /// At the end of each of `intervals` parts.
    pub fn even(intervals: usize) -> Self {
        Self { intervals, marks: (1..=intervals).collect() }
    }

    /// The index of the step that has each mark, among so many steps of equal length, and where it is in that step, in
    /// (0, 1]; a mark at the start is at 0 of the first.
    fn places(&self, steps: usize) -> Peekable<impl Iterator<Item = (usize, f64)> + '_> {
        assert!(steps > 0 && self.intervals > 0, "no steps");
        let place = move |&mark: &usize| {
            let step = (mark * steps).div_ceil(self.intervals).saturating_sub(1);
            (step, (mark * steps - step * self.intervals) as f64 / self.intervals as f64)
        };
        self.marks.iter().map(place).peekable()
    }

    /// The number of marks at the start.
    fn at_start(&self) -> usize {
        self.marks.iter().take_while(|&&mark| mark == 0).count()
    }

    /// γ − γ_i of the marks.
    pub fn gamma(&self, length: f64) -> impl Iterator<Item = f64> + '_ {
        self.marks.iter().map(move |&mark| length * (mark as f64 / self.intervals as f64))
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
pub enum Failure {
    /// It meets g00 ≤ 0, or a determinant of the metric changes its sign.
    #[error("the world-line leaves the domain")]
    OutsideDomain,
    /// A number is not finite.
    #[error("the numbers are not finite")]
    Diverged,
    /// More than [`MOST_STEPS`], or steps that shrink without end.
    #[error("too many steps")]
    TooManySteps,
    /// The iteration of an implicit method does not converge.
    #[error("an implicit step does not converge")]
    NotConverged,
    /// Windows add up to more than the accuracy.
    #[error("the accuracy is not reached")]
    AccuracyNotReached,
    /// The method needs equations of the second order.
    #[error("the scene is not separable")]
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
