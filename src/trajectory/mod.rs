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
//! In scenes of several coordinates the same is done with all positions and momenta, and [`crossings`] finds where
//! formulas of them change their sign.
//!
//! ```
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::trajectory::Sampler;
//! use geodesic_ivp::{Case, Solution, solve};
//!
//! let case = Case::parse("free", builtin::text("free").expect("it is built in"), &[])?;
//! let solution: Solution = solve(&case)?;
//! let sample = Sampler::new(&solution).at_gamma(0.123).expect("inside the run");
//! assert!((sample.t - 0.123).abs() < 1e-13);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cursor;
mod curved;
mod hermite;
mod interpolant;
mod legendre;
mod sampler;
mod scene;
mod spectral;
mod stream;

pub use curved::Curved;
pub use interpolant::Sample;
pub use sampler::Sampler;
pub use scene::{Crossing, SceneSample, Watch, crossings};
pub use stream::{Coordinate, SampleStream};

use crate::number::Real;

/// The error of a value that lies outside the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutsideRun<S> {
    /// The smallest and the largest value that the run covers.
    pub range: (S, S),
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
