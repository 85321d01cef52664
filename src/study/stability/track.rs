//! A trajectory as the atlas judges it.

use std::ops::Range;

use super::Numbers;
use crate::action::Form;
use crate::diagnostics::{Diagnostics, energy_off, sawtooth};
use crate::geometry::Start;
use crate::methods::{Problem, Trajectory};
use crate::number::norm::{larger, max_abs};
use crate::solve::WorldLine;
use crate::study::subject::{norm_and_first_rate, rows};

/// A trajectory on its nodes, window by window.
pub(super) struct Track {
    /// γ − γ_i.
    pub(super) gamma: Vec<f64>,
    /// The coordinates, a row for each.
    pub(super) q: Vec<Vec<f64>>,
    delta_k: Vec<f64>,
    /// Equidistant stretches of nodes.
    stretches: Vec<Range<usize>>,
    pub(super) intervals: usize,
    pub(super) iterations: Option<usize>,
    /// What needs no reference.
    pub(super) numbers: Numbers,
}

impl Track {
    /// The track of a run of this program, which is the lift of Newton's law if `is_lifted`.
    pub(super) fn of_line(line: &WorldLine, is_lifted: bool) -> Self {
        let Diagnostics { charges, norm, energy, .. } = Diagnostics::of(line, &[], &mut [], is_lifted);
        let delta_energy_max = energy.map(|energy| {
            let inside = line.windows.iter().map(|grid| max_abs(&energy.delta[grid.exact()])).fold(0.0, larger);
            larger(inside, energy.max_ends)
        });
        let (mut delta_k, mut stretches, mut intervals) = (norm.delta, Vec::new(), 0);
        for (grid, &at_end) in line.windows.iter().zip(&norm.ends) {
            // In the strong form Dq is no velocity at the last node of a window.
            let nodes = grid.nodes();
            delta_k[nodes.end - 1] = at_end;
            intervals += nodes.len() - 1;
            if grid.is_equidistant() {
                stretches.push(grid.exact());
            }
        }
        let is_block = line.form == Form::Strong && line.windows.len() == 1;
        let last = |row: &[f64]| row.last().copied().unwrap_or(f64::NAN);
        let last_node = charges.iter().map(|charge| [last(&charge.delta), last(&charge.corrected)]);
        let numbers = Numbers {
            delta_k_max: norm.max_interior,
            delta_energy_max,
            charges: Some(charges.iter().map(|charge| charge.max_interior).collect()),
            last_node: is_block.then(|| last_node.collect()),
            ..Numbers::default()
        };
        let (gamma, iterations) = (line.gamma_from_start().collect(), Some(line.iterations.count));
        Self { gamma, q: rows(line), delta_k, stretches, intervals, iterations, numbers }
    }

    /// The track of another method, whose states are known at equal distances. Between the ends of its steps, which
    /// have equal lengths only if `is_equidistant` says so, there is nothing of a sawtooth.
    pub(super) fn of_states(problem: &Problem, found: &Trajectory, is_equidistant: bool, is_lifted: bool) -> Self {
        let Problem { space, start, length, .. } = problem;
        let mut q: Vec<Vec<f64>> = start.q.iter().map(|&q| vec![q]).collect();
        let k = space.norm(&start.q, &start.q_dot);
        let (mut delta_k, mut energy) = (vec![0.0], 0.0);
        for state in found.states.iter() {
            let [k_here, first_rate] = norm_and_first_rate(problem, state);
            let delta = k_here - k;
            if is_lifted {
                energy = larger(energy, energy_off(start, k + delta, first_rate).abs());
            }
            delta_k.push(delta);
            q.iter_mut().zip(state.q).for_each(|(row, q)| row.push(*q));
        }
        let count = delta_k.len();
        let numbers = Numbers {
            delta_k_max: delta_k.iter().fold(0.0, |most: f64, value| most.max(value.abs())),
            delta_energy_max: is_lifted.then_some(energy),
            ..Numbers::default()
        };
        Self {
            gamma: (0..count).map(|step| length * (step as f64 / (count - 1) as f64)).collect(),
            q,
            delta_k,
            stretches: is_equidistant.then_some(0..count).into_iter().collect(),
            intervals: found.steps,
            iterations: None,
            numbers,
        }
    }

    /// The largest error of each coordinate over the nodes.
    pub(super) fn errors(&self, reference: &[Start]) -> Vec<f64> {
        let largest = |(a, row): (usize, &Vec<f64>)| {
            row.iter().zip(reference).fold(0.0, |most, (here, exact)| larger(most, (here - exact.q[a]).abs()))
        };
        self.q.iter().enumerate().map(largest).collect()
    }

    /// The amplitude of the (−1)^k component of a row of values on the nodes.
    pub(super) fn sawtooth(&self, row: &[f64]) -> Option<f64> {
        self.stretches.iter().filter_map(|nodes| sawtooth(&row[nodes.clone()])).reduce(f64::max)
    }

    /// γ − γ_i where that of coordinate `a` first exceeds `threshold`.
    pub(super) fn sawtooth_from(&self, a: usize, threshold: f64) -> Option<f64> {
        let first = |nodes: &Range<usize>| {
            let rough = |w: &[f64]| sawtooth(w).is_some_and(|amplitude| amplitude > threshold);
            self.q[a][nodes.clone()].windows(5).position(rough).map(|k| self.gamma[nodes.start + k + 2])
        };
        self.stretches.iter().find_map(first)
    }

    /// The drift of K along the nodes.
    pub(super) fn k_drift(&self) -> f64 {
        drift_of(&self.delta_k)
    }
}

/// The mean over the last quarter of these values minus that over the first quarter.
fn drift_of(values: &[f64]) -> f64 {
    let quarter = (values.len() / 4).max(1).min(values.len());
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    mean(&values[values.len() - quarter..]) - mean(&values[..quarter])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drift_is_the_difference_of_the_quarters_at_the_ends() {
        assert_eq!(drift_of(&[1.0, 3.0, 9.0, 9.0, 9.0, 9.0, 5.0, 6.0]), 3.5);
        assert_eq!((drift_of(&[1.0, 4.0]), drift_of(&[7.0; 9])), (3.0, 0.0));
    }
}
