//! Values between the nodes, by the scheme's own interpolation.
//!
//! * On an equidistant grid every coordinate and momentum is the Hermite polynomial through its values and derivatives
//!   on four nodes. Its error is below that of the nodes for every operator, and as momenta are interpolated by
//!   themselves, a sawtooth in x does not spoil dx/dγ.
//! * In a spectral element of the strong form it is the polynomial through all nodes, which the operator
//!   differentiates.
//! * In a spectral element of the weak form, where nodes are less accurate than ends, the scheme is solved once more
//!   from the start of the window, on twice as many nodes. Where an accuracy was asked for, which holds at the nodes
//!   too, the integrals of the rates through the window's own nodes are enough.
//!
//! Velocities follow from positions and momenta. [`crossings`] finds where formulas of the state change their sign.
//!
//! ```
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::trajectory::Sampler;
//! use geodesic_ivp::{Case, Solution, solve};
//!
//! let case = Case::parse("free", builtin::text("free").expect("it is built in"), &[])?;
//! let solution: Solution = solve(&case)?;
//! let sample = Sampler::new(&solution).at_gamma(0.123).expect("inside the run");
//! assert!((sample.q[0] - 0.123).abs() < 1e-13);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod crossings;
mod curve;
mod inside;
mod late;
mod nodes;
mod sampler;

pub use crossings::{Crossing, EventSearch, Watch, crossings};
pub(crate) use late::late_at_end;
pub use sampler::{Coordinate, NoSamples, Sample, SampleStream, Sampler};

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
    inside.then(|| if value > high { high } else { value.max(low) })
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

#[cfg(test)]
mod tests {
    use super::within;

    #[test]
    fn what_lies_little_outside_is_moved_to_the_end() {
        let moved = |value: f64| within(value, [-2.0, 1.0], 0.25);
        assert_eq!([-2.75, -2.5, 0.5, 1.5, 1.75].map(moved), [None, Some(-2.0), Some(0.5), Some(1.0), None]);
    }
}
