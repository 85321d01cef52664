//! Values between the nodes, by the scheme's own interpolation.
//!
//! On an equidistant grid that is the quintic Hermite polynomial of each interval, for t, x and w* each with its own
//! first two derivatives at both ends, which the geodesic equations give. Its error O(Δγ⁶) is below that of the nodes
//! for every operator, and dx/dγ does not suffer from nodes of x that alternate about a smooth curve. In a spectral
//! element of the strong form it is the polynomial through all nodes, which is what the operator differentiates; in one
//! of the weak form, whose nodes are less accurate than its ends, the polynomials that continue what the window starts
//! with by the scheme's collocation system on twice as many nodes, as accurate as the ends. dt/dγ is Q_t/g00
//! everywhere.
//!
//! ```
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::sampling::Sampler;
//! use geodesic_ivp::{Case, Solution, solve};
//!
//! let case = Case::parse("free", builtin::text("free").expect("it is built in"), &[])?;
//! let solution: Solution = solve(&case)?;
//! let sample = Sampler::new(&solution).at_gamma(0.123).expect("inside the run");
//! assert!((sample.t - 0.123).abs() < 1e-13);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod hermite;
mod interpolant;
mod spectral;
mod stream;

pub use stream::{Coordinate, SampleStream};

use self::interpolant::Interpolant;
use self::spectral::Tables;
use crate::scalar::Real;
use crate::solve::Solution;

/// The world-line at one value of γ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<S = f64> {
    /// γ.
    pub gamma: S,
    /// t.
    pub t: S,
    /// x.
    pub x: S,
    /// dt/dγ.
    pub t_dot: S,
    /// dx/dγ.
    pub x_dot: S,
}

/// A value that lies outside the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutsideRun<S> {
    /// First and last value of the run.
    pub range: (S, S),
}

/// Interpolates one solution. What a window needs is prepared when a value in it is requested, and kept until a value
/// in another one is.
#[derive(Debug)]
pub struct Sampler<'a, S = f64> {
    solution: &'a Solution<S>,
    tables: Tables<S>,
    /// The last window that was asked for, and its interpolation.
    current: Option<(usize, Interpolant<S>)>,
}

impl<'a, S: Real> Sampler<'a, S> {
    /// For the windows of `solution`.
    pub fn new(solution: &'a Solution<S>) -> Self {
        Self::with_tables(solution, Tables::default())
    }

    fn with_tables(solution: &'a Solution<S>, tables: Tables<S>) -> Self {
        Self { solution, tables, current: None }
    }

    /// A run that ends at a physical time meets it to all but a few of its digits, and so does the requested value.
    fn slack(&self) -> S {
        const SPARE_DIGITS: u32 = 4;
        S::from_decimal(&format!("1e-{}", self.solution.digits - SPARE_DIGITS)).unwrap_or(S::EPSILON)
    }

    /// γ and t at the ends of the solution, counted from those of the run.
    fn ends(&self) -> Option<[[S; 2]; 2]> {
        let (first, last) = (self.solution.windows.first()?, self.solution.windows.last()?);
        Some([[first.gamma[0], last.gamma[1]], [first.start.t, self.solution.duration()]])
    }

    /// The world-line at `gamma`.
    ///
    /// # Errors
    /// [`OutsideRun`] beyond the ends by more than rounding.
    pub fn at_gamma(&mut self, gamma: S) -> Result<Sample<S>, OutsideRun<S>> {
        let Solution { gamma_i, windows, .. } = self.solution;
        let [ends, _] = self.ends().ok_or(OutsideRun { range: (*gamma_i, *gamma_i) })?;
        let from_start = within(gamma - *gamma_i, ends, self.slack())
            .ok_or(OutsideRun { range: (*gamma_i + ends[0], *gamma_i + ends[1]) })?;
        let window = partition(windows.len(), |window| windows[window].gamma[0] <= from_start);
        let place = from_start - windows[window].gamma[0];
        Ok(Sample { gamma, ..self.of_window(window).at(place) })
    }

    /// The world-line at the time `t`.
    ///
    /// # Errors
    /// [`OutsideRun`] before t_i or after t_N.
    pub fn at_time(&mut self, t: S) -> Result<Sample<S>, OutsideRun<S>> {
        let Solution { t_i, windows, .. } = self.solution;
        let [_, ends] = self.ends().ok_or(OutsideRun { range: (*t_i, *t_i) })?;
        // Time runs forwards or backwards, but not both.
        let backwards = ends[1] < ends[0];
        let [earliest, latest] = if backwards { [ends[1], ends[0]] } else { ends };
        let elapsed = within(t - *t_i, [earliest, latest], self.slack())
            .ok_or(OutsideRun { range: (*t_i + earliest, *t_i + latest) })?;
        let reached = |value: S| if backwards { value >= elapsed } else { value <= elapsed };
        let window = partition(windows.len(), |window| reached(windows[window].start.t));
        let elapsed = elapsed - windows[window].start.t;
        Ok(Sample { t, ..self.of_window(window).at_elapsed(elapsed, backwards) })
    }

    fn at(&mut self, coordinate: Coordinate, value: S) -> Result<Sample<S>, OutsideRun<S>> {
        match coordinate {
            Coordinate::Gamma => self.at_gamma(value),
            Coordinate::Time => self.at_time(value),
        }
    }

    fn of_window(&mut self, window: usize) -> &Interpolant<S> {
        if self.current.as_ref().is_some_and(|(current, _)| *current != window) {
            self.current = None;
        }
        let Self { solution, tables, current } = self;
        let (_, interpolant) = current.get_or_insert_with(|| {
            let view = solution.view(&solution.windows[window]);
            (window, Interpolant::new(solution, view, tables))
        });
        interpolant
    }
}

/// `value` between the two ends, moved there if it lies outside by no more than that share of them.
fn within<S: Real>(value: S, [low, high]: [S; 2], share: S) -> Option<S> {
    let slack = share * low.abs().max(high.abs());
    let inside = value >= low - slack && value <= high + slack;
    inside.then(|| {
        if value < low {
            low
        } else if value > high {
            high
        } else {
            value
        }
    })
}

/// The last interval 0 … `intervals` − 1 whose first node satisfies `reached`, which holds up to some node.
fn partition(intervals: usize, reached: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, intervals);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if reached(middle) { low = middle } else { high = middle }
    }
    low
}
