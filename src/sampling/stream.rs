//! Samples of a run that comes window by window.

use super::spectral::Tables;
use super::{OutsideRun, Sample, Sampler};
use crate::scalar::Real;
use crate::solve::Solution;

/// The quantity by which samples are requested.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinate {
    /// γ.
    Gamma,
    /// t.
    Time,
}

/// Takes samples at given values from solutions that are the parts of a run, or the whole of it.
#[derive(Debug)]
pub struct SampleStream<S = f64> {
    coordinate: Coordinate,
    /// In the order of the run.
    values: Vec<S>,
    /// Whether that is the reverse of the order asked for.
    reversed: bool,
    samples: Vec<Sample<S>>,
    tables: Tables<S>,
}

impl<S: Real> SampleStream<S> {
    /// Samples at `values`, which ascend or descend, of a run whose time runs `backwards` or not.
    pub fn new(coordinate: Coordinate, mut values: Vec<S>, backwards: bool) -> Self {
        let descending = values.first() > values.last();
        let reversed = descending != (backwards && coordinate == Coordinate::Time);
        if reversed {
            values.reverse();
        }
        Self { coordinate, values, reversed, samples: Vec::new(), tables: Tables::default() }
    }

    /// Takes the samples that lie in `solution`, which continues what was seen before, or (with its first window)
    /// begins the run again.
    pub fn see(&mut self, solution: &Solution<S>) {
        if solution.window_count == solution.windows.len() {
            self.samples.clear();
        }
        let Some(last) = solution.windows.last() else { return };
        let (origin, end) = match self.coordinate {
            Coordinate::Gamma => (solution.gamma_i, last.gamma[1]),
            Coordinate::Time => (solution.t_i, last.end.t),
        };
        // The end of a window is the start of the next one.
        let beyond = |value: S| if end < S::ZERO { value - origin <= end } else { value - origin >= end };
        let mut sampler = Sampler::with_tables(solution, std::mem::take(&mut self.tables));
        for &value in &self.values[self.samples.len()..] {
            if beyond(value) {
                break;
            }
            // Values before the run are found again, and refused, in the end.
            let Ok(sample) = sampler.at(self.coordinate, value) else { break };
            self.samples.push(sample);
        }
        self.tables = sampler.tables;
    }

    /// All samples in the order asked for, `last` being the last that was seen.
    ///
    /// # Errors
    /// [`OutsideRun`] if one lies beyond the ends of the run by more than rounding.
    pub fn finish(mut self, last: &Solution<S>) -> Result<Vec<Sample<S>>, OutsideRun<S>> {
        let mut sampler = Sampler::with_tables(last, self.tables);
        for &value in &self.values[self.samples.len()..] {
            let sample = sampler.at(self.coordinate, value).map_err(|_| {
                let end = last.t_i + last.duration();
                OutsideRun {
                    range: match self.coordinate {
                        Coordinate::Gamma => (last.gamma_i, last.gamma_f()),
                        Coordinate::Time if end < last.t_i => (end, last.t_i),
                        Coordinate::Time => (last.t_i, end),
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
