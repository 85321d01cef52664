//! Samples of a run that is computed window by window.

use super::legendre::Tables;
use super::{OutsideRun, Sample, Sampler};
use crate::number::Real;
use crate::solve::{Solution, WindowNodes};

/// The quantity by which samples are requested.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinate {
    /// γ.
    Gamma,
    /// The coordinate with this index, which must grow or fall all the way.
    Value(usize),
}

/// Takes samples at given values from the solutions of a run: its consecutive parts, or the whole run at once.
#[derive(Debug)]
pub struct SampleStream<S = f64> {
    coordinate: Coordinate,
    /// The values in the order of the run.
    values: Vec<S>,
    /// True if that is the reverse of the requested order.
    reversed: bool,
    samples: Vec<Sample<S>>,
    /// The value at the start of the run.
    first: S,
    /// True if the coordinate turned round in what was seen.
    has_turned: bool,
    tables: Tables<S>,
}

/// Why there are no samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoSamples<S> {
    /// One lies beyond the ends of the run by more than rounding.
    Outside(OutsideRun<S>),
    /// The coordinate does not grow, or fall, all the way: a value of it is not one place of the world-line.
    Turns,
}

impl<S: Real> SampleStream<S> {
    /// Takes the samples that lie in `solution`. It must continue the previous one or, if it contains the first window,
    /// begins the run again.
    pub fn see(&mut self, solution: &Solution<S>) {
        if solution.window_count == solution.windows.len() {
            self.samples.clear();
            self.has_turned = false;
        }
        if solution.windows.is_empty() {
            return;
        }
        let (origin, end) = self.coordinate.ends(solution);
        if solution.window_count == solution.windows.len() {
            self.first = origin;
        }
        if let Coordinate::Value(a) = self.coordinate {
            let turns = |view: WindowNodes<'_, S>| {
                let change = view.end.q[a] - view.start.q[a];
                // Written so that no change at all is a turn.
                !(if end < S::ZERO { change < S::ZERO } else { change > S::ZERO })
            };
            self.has_turned |= solution.views().any(turns);
        }
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
    /// [`NoSamples`] if one does not lie in the run, or cannot be told from another one.
    pub fn finish(mut self, last: &Solution<S>) -> Result<Vec<Sample<S>>, NoSamples<S>> {
        if self.has_turned {
            return Err(NoSamples::Turns);
        }
        let mut sampler = Sampler::with_tables(last, self.tables);
        for &value in &self.values[self.samples.len()..] {
            let sample = sampler.at(self.coordinate, value).map_err(|_| {
                let (first, change) = self.coordinate.ends(last);
                let end = first + change;
                let range = if end < self.first { (end, self.first) } else { (self.first, end) };
                NoSamples::Outside(OutsideRun { range })
            })?;
            self.samples.push(sample);
        }
        if self.reversed {
            self.samples.reverse();
        }
        Ok(self.samples)
    }

    /// A stream of samples at `values`, which must be in ascending or descending order. `backwards` says whether γ, or
    /// the coordinate, falls along the run.
    pub fn new(coordinate: Coordinate, mut values: Vec<S>, backwards: bool) -> Self {
        let descending = values.first() > values.last();
        let reversed = descending != backwards;
        if reversed {
            values.reverse();
        }
        Self {
            coordinate,
            values,
            reversed,
            samples: Vec::new(),
            first: S::ZERO,
            has_turned: false,
            tables: Tables::default(),
        }
    }
}

impl<S: Real> Sampler<'_, S> {
    fn at(&mut self, coordinate: Coordinate, value: S) -> Result<Sample<S>, OutsideRun<S>> {
        match coordinate {
            Coordinate::Gamma => self.at_gamma(value),
            Coordinate::Value(a) => self.at_value(a, value),
        }
    }
}

impl Coordinate {
    /// Where it starts, and how much it has changed at the end of what is kept.
    fn ends<S: Real>(self, line: &Solution<S>) -> (S, S) {
        match self {
            Self::Gamma => (line.gamma_i, line.signed(line.windows.last().map_or(line.length, |last| last.gamma[1]))),
            Self::Value(a) => {
                let first = line.place.start.q[a];
                (line.origin_of(a) + first, line.last_joint().q[a] - first)
            }
        }
    }
}
