//! Samples of a run that is computed window by window.

use super::legendre::Tables;
use super::{OutsideRun, Sample, Sampler};
use crate::number::Real;
use crate::solve::Solution;

/// The quantity by which samples are requested.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinate {
    /// γ.
    Gamma,
    /// t.
    Time,
}

/// Takes samples at given values from the solutions of a run: its consecutive parts, or the whole run at once.
#[derive(Debug)]
pub struct SampleStream<S = f64> {
    coordinate: Coordinate,
    /// The values in the order of the run.
    values: Vec<S>,
    /// Whether that is the reverse of the requested order.
    reversed: bool,
    samples: Vec<Sample<S>>,
    tables: Tables<S>,
}

impl<S: Real> SampleStream<S> {
    /// Takes the samples that lie in `solution`. It must continue the previous one or, if it contains the first window,
    /// begins the run again.
    pub fn see(&mut self, solution: &Solution<S>) {
        if solution.window_count == solution.windows.len() {
            self.samples.clear();
        }
        let Some(last) = solution.windows.last() else { return };
        let (origin, end) = match self.coordinate {
            Coordinate::Gamma => (solution.gamma_i, last.gamma[1]),
            Coordinate::Time => (solution.t_i(), solution.duration()),
        };
        // A sample at the end of this solution is left to the next one, which starts there.
        let beyond = |value: S| if end < S::ZERO { value - origin <= end } else { value - origin >= end };
        let mut sampler = Sampler::with_tables(solution, std::mem::take(&mut self.tables));
        let from = self.samples.len();
        let reached = self.values[from..].iter().take_while(|&&value| !beyond(value)).count();
        // A value before the start of the run stays in the list, and `finish` refuses it.
        let values = self.values[from..from + reached].iter();
        self.samples.extend(values.map_while(|&value| sampler.at(self.coordinate, value).ok()));
        self.tables = sampler.tables;
    }

    /// All samples, in the requested order. `last` is the last solution that was seen.
    ///
    /// # Errors
    /// [`OutsideRun`] if one lies beyond the ends of the run by more than rounding.
    pub fn finish(mut self, last: &Solution<S>) -> Result<Vec<Sample<S>>, OutsideRun<S>> {
        let mut sampler = Sampler::with_tables(last, self.tables);
        for &value in &self.values[self.samples.len()..] {
            let sample = sampler.at(self.coordinate, value).map_err(|_| {
                let end = last.t_i() + last.duration();
                OutsideRun {
                    range: match self.coordinate {
                        Coordinate::Gamma => (last.gamma_i, last.gamma_f()),
                        Coordinate::Time if end < last.t_i() => (end, last.t_i()),
                        Coordinate::Time => (last.t_i(), end),
                    },
                }
            })?;
            self.samples.push(sample);
        }
        if self.reversed {
            self.samples.reverse();
        }
        Ok(self.samples)
    }
}

impl<S: Real> SampleStream<S> {
    /// A stream of samples at `values`, which must be in ascending or descending order. `backwards` says whether t
    /// decreases along the run.
    pub fn new(coordinate: Coordinate, mut values: Vec<S>, backwards: bool) -> Self {
        let descending = values.first() > values.last();
        let reversed = descending != (backwards && coordinate == Coordinate::Time);
        if reversed {
            values.reverse();
        }
        Self { coordinate, values, reversed, samples: Vec::new(), tables: Tables::default() }
    }
}

impl<S: Real> Sampler<'_, S> {
    fn at(&mut self, coordinate: Coordinate, value: S) -> Result<Sample<S>, OutsideRun<S>> {
        match coordinate {
            Coordinate::Gamma => self.at_gamma(value),
            Coordinate::Time => self.at_value(0, value),
        }
    }
}
