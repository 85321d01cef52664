//! Where samples of a run are wanted.

use crate::case::Case;
use crate::number::Real;
use crate::trajectory::{Coordinate, SampleStream};

/// The places of samples. Numbers are kept as text, so that a step of 0.1 is one tenth in every precision.
#[derive(Debug, Clone)]
pub struct Sampling {
    /// True if they are times, and false if they are values of γ.
    pub by_time: bool,
    /// The numbers, in ascending or descending order.
    pub numbers: Numbers,
}

/// Numbers as they are written.
#[derive(Debug, Clone)]
pub enum Numbers {
    /// So many in equal steps.
    Steps {
        /// The first one.
        start: String,
        /// The distance of two.
        step: String,
        /// Their number.
        count: usize,
    },
    /// These.
    List(Vec<String>),
}

impl Sampling {
    /// The number of samples.
    pub fn count(&self) -> usize {
        match &self.numbers {
            Numbers::Steps { count, .. } => *count,
            Numbers::List(list) => list.len(),
        }
    }

    /// The numbers in this precision.
    pub fn values<S: Real>(&self) -> Vec<S> {
        let read = |text: &str| S::from_decimal(text).unwrap_or_else(|| S::from(f64::NAN));
        match &self.numbers {
            Numbers::Steps { start, step, count } => {
                let (start, step): (S, S) = (read(start), read(step));
                (0..*count).map(|k| start + S::from(k as f64) * step).collect()
            }
            Numbers::List(list) => list.iter().map(|text| read(text)).collect(),
        }
    }

    /// The stream that takes the samples of a run of `case`; none if they are times, and it has no coordinate t.
    pub fn stream<S: Real>(&self, case: &Case) -> Option<SampleStream<S>> {
        let t = match self.by_time {
            true => Some(case.coordinates().iter().position(|name| name == "t")?),
            false => None,
        };
        Some(stream(case, t, self.values()))
    }
}

/// The stream that takes samples of a run of `case` at these values of a coordinate, or of γ.
pub(crate) fn stream<S: Real>(case: &Case, coordinate: Option<usize>, values: Vec<S>) -> SampleStream<S> {
    let Some(a) = coordinate else { return SampleStream::new(Coordinate::Gamma, values, case.is_backward()) };
    let backwards = (case.start::<f64>().q_dot[a] < 0.0) != case.is_backward();
    SampleStream::new(Coordinate::Value(a), values, backwards)
}
