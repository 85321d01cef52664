//! Values between the nodes, by the scheme's own interpolation.
//!
//! In the following w* is the scheme's value of dx/dγ on the nodes: Dx or, in the weak form, D̄x, except at the last
//! node of a window in the strong form.
//!
//! * On an equidistant grid, t, x and w* are each interpolated by the quintic Hermite polynomial of every interval. The
//!   first two derivatives at both ends come from the geodesic equations. The error O(Δγ⁶) is below that of the nodes
//!   for every operator. As w* is interpolated by itself, a sawtooth in x does not spoil dx/dγ.
//! * In a spectral element of the strong form, the polynomial through all nodes is used, which is the one that the
//!   operator differentiates.
//! * In a spectral element of the weak form, the nodes are less accurate than the ends. There the collocation system of
//!   the scheme is solved once more from the start of the window, on twice as many nodes. The resulting polynomials are
//!   as accurate as the ends. Where the window's own nodes resolve the forces to rounding, or an accuracy was asked
//!   for, which holds at the nodes too, the integrals of the forces through the window's own nodes are enough: their
//!   errors of t and x are below those of the nodes, that of dx/dγ is up to 2n/h times as large.
//!
//! dt/dγ is Q_t/g00 everywhere.
//!
//! In scenes of several coordinates [`SceneSampler`] does the same with all positions and momenta, and [`crossings`]
//! finds where formulas of them change their sign.
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

mod cursor;
mod dense;
mod hermite;
mod interpolant;
mod legendre;
mod scene;
mod spectral;
mod stream;

pub use scene::{Crossing, SceneSample, SceneSampler, Watch, crossings};
pub use stream::{Coordinate, SampleStream};

use self::cursor::{Cursor, Reached};
use self::interpolant::Interpolant;
use self::legendre::Tables;
use crate::metric::Metric;
use crate::scalar::Real;
use crate::solve::{Solution, WorldLine};

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

/// The error of a value that lies outside the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutsideRun<S> {
    /// The smallest and the largest value that the run covers.
    pub range: (S, S),
}

/// Interpolates one solution. A window is prepared when a value in it is requested, and kept until a value in another
/// window is.
#[derive(Debug)]
pub struct Sampler<'a, S = f64> {
    cursor: Cursor<'a, S, Metric<S>, Interpolant<S>>,
    tables: Tables<S>,
}

impl<'a, S: Sampled> Sampler<'a, S> {
    /// The world-line at `gamma`.
    ///
    /// # Errors
    /// [`OutsideRun`] beyond the ends by more than rounding.
    pub fn at_gamma(&mut self, gamma: S) -> Result<Sample<S>, OutsideRun<S>> {
        S::sample_at_gamma(self, gamma)
    }

    /// The world-line at the time `t`.
    ///
    /// # Errors
    /// [`OutsideRun`] before t_i or after t_N.
    pub fn at_time(&mut self, t: S) -> Result<Sample<S>, OutsideRun<S>> {
        S::sample_at_time(self, t)
    }
}

impl<'a, S: Real> Sampler<'a, S> {
    /// A sampler of `solution`.
    pub fn new(solution: &'a Solution<S>) -> Self {
        Self::with_tables(solution, Tables::default())
    }

    fn with_tables(solution: &'a Solution<S>, tables: Tables<S>) -> Self {
        Self { cursor: Cursor::new(solution), tables }
    }

    fn at_gamma_here(&mut self, gamma: S) -> Result<Sample<S>, OutsideRun<S>> {
        let (window, place) = self.cursor.at_gamma(gamma)?;
        Ok(Sample { gamma, ..self.of_window(window).at(place) })
    }

    /// The sign of dt/dγ is that of Q_t everywhere, so that t is monotonic.
    fn at_time_here(&mut self, t: S) -> Result<Sample<S>, OutsideRun<S>> {
        let Reached { window, value, falls } = self.cursor.at_value(0, t)?;
        let elapsed = value - self.cursor.line.joint(window).q[0];
        Ok(Sample { t, ..self.of_window(window).at_elapsed(elapsed, falls) })
    }

    /// The world-line at the first of the `values` of γ, which ascend, and at the others in the same window.
    fn at_leading(&mut self, values: &[S], samples: &mut Vec<Sample<S>>) -> Result<(), OutsideRun<S>> {
        let Some(&first) = values.first() else { return Ok(()) };
        let Solution { gamma_i, windows, .. } = self.cursor.line;
        let window = self.cursor.window_at(first - *gamma_i);
        let [begin, end] = windows[window].gamma;
        let is_inside = |gamma: S| gamma - *gamma_i >= begin && gamma - *gamma_i < end;
        let count = values.iter().take_while(|&&value| is_inside(value)).count();
        if count < 2 {
            samples.push(self.at_gamma_here(first)?);
            return Ok(());
        }
        let places = values[..count].iter().map(|&value| value - *gamma_i - begin);
        let from = samples.len();
        self.of_window(window).at_many(places, samples);
        samples[from..].iter_mut().zip(values).for_each(|(sample, &gamma)| sample.gamma = gamma);
        Ok(())
    }

    fn at(&mut self, coordinate: Coordinate, value: S) -> Result<Sample<S>, OutsideRun<S>> {
        match coordinate {
            Coordinate::Gamma => self.at_gamma_here(value),
            Coordinate::Time => self.at_time_here(value),
        }
    }

    fn of_window(&mut self, window: usize) -> &Interpolant<S> {
        let Self { cursor, tables } = self;
        cursor.of_window(window, |solution| Interpolant::new(solution, solution.view(window), tables))
    }
}

/// The relative distance from the ends of a run of so many digits at which a value still counts as inside. The end of a
/// run at a physical time is only known up to a few of the last digits.
fn slack<S: Real>(digits: u32) -> S {
    const SPARE_DIGITS: u32 = 4;
    S::from(0.1_f64.powi((digits - SPARE_DIGITS) as i32))
}

/// `value`, moved to the nearer end if it lies outside the two ends by at most `share` of them; `None` if it lies
/// further outside.
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

/// The last of the intervals 0 … `intervals` − 1 whose first node satisfies `reached`, or the first interval.
/// `reached` must be true up to some node and false from there on.
fn partition(intervals: usize, reached: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, intervals);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if reached(middle) { low = middle } else { high = middle }
    }
    low
}

crate::compiled! {
    /// Numbers in which runs are sampled.
    pub trait Sampled {
        fn sample_at_gamma(
            this: &mut Sampler<'_, Self>,
            gamma: Self,
        ) -> Result<Sample<Self>, OutsideRun<Self>> = Sampler::at_gamma_here;
        fn sample_at_time(
            this: &mut Sampler<'_, Self>,
            t: Self,
        ) -> Result<Sample<Self>, OutsideRun<Self>> = Sampler::at_time_here;
        fn crossings(
            line: &WorldLine<Self>,
            watches: &mut [Watch<Self>],
        ) -> Vec<Crossing<Self>> = scene::crossings::crossings_here;
        fn stream_see(this: &mut SampleStream<Self>, solution: &Solution<Self>) -> () = SampleStream::see_here;
        fn stream_finish(
            this: SampleStream<Self>,
            last: &Solution<Self>,
        ) -> Result<Vec<Sample<Self>>, OutsideRun<Self>> = SampleStream::finish_here;
        fn scene_sample_at_gamma(
            this: &mut SceneSampler<'_, Self>,
            gamma: Self,
        ) -> Result<SceneSample<Self>, OutsideRun<Self>> = SceneSampler::at_gamma_here;
        fn scene_sample_at_value(
            this: &mut SceneSampler<'_, Self>,
            a: usize,
            value: Self,
        ) -> Result<SceneSample<Self>, OutsideRun<Self>> = SceneSampler::at_value_here;
    }
}
