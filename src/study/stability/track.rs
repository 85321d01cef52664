//! A trajectory as the atlas judges it.

use std::ops::Range;

use super::status::Sizes;
use crate::diagnostics::sawtooth;
use crate::number::norm::larger;
use crate::solve::WindowGrid;
use crate::study::space::Point;

/// A trajectory on its nodes, window by window.
pub(super) struct Track {
    /// γ − γ_i.
    pub(super) gamma: Vec<f64>,
    /// The coordinates, a row for each.
    pub(super) q: Vec<Vec<f64>>,
    pub(super) delta_k: Vec<f64>,
    /// Equidistant stretches of nodes.
    pub(super) stretches: Vec<Range<usize>>,
    pub(super) intervals: usize,
    pub(super) delta_k_max: f64,
    pub(super) delta_energy_max: Option<f64>,
    /// max |Δp_a| of every charge.
    pub(super) charges: Option<Vec<f64>>,
    /// Δp_a at the last node, and with the multiplier correction, of every charge.
    pub(super) last_node: Option<Vec<[f64; 2]>>,
    pub(super) iterations: Option<usize>,
}

impl Track {
    /// The track of a run in windows with these grids, where ΔK is `ends` for what the windows are continued with, and
    /// `delta_k_max` at most on the way.
    pub(super) fn of_windows<'g>(
        grids: impl Iterator<Item = WindowGrid<'g, f64>>,
        gamma: Vec<f64>,
        (q, mut delta_k): (Vec<Vec<f64>>, Vec<f64>),
        (ends, delta_k_max): (&[f64], f64),
    ) -> Self {
        let (mut stretches, mut intervals) = (Vec::new(), 0);
        for (grid, &at_end) in grids.zip(ends) {
            // In the strong form Dq is no velocity at the last node of a window.
            let nodes = grid.nodes();
            delta_k[nodes.end - 1] = at_end;
            intervals += nodes.len() - 1;
            if grid.is_equidistant() {
                stretches.push(grid.exact());
            }
        }
        Self {
            gamma,
            q,
            delta_k,
            stretches,
            intervals,
            delta_k_max,
            delta_energy_max: None,
            charges: None,
            last_node: None,
            iterations: None,
        }
    }

    /// The track of a method which took so many steps, and whose states are known at equal distances. Between the ends
    /// of its steps, which have equal lengths only if `is_equidistant` says so, there is nothing of a sawtooth.
    pub(super) fn of_steps(
        length: f64,
        (q, delta_k): (Vec<Vec<f64>>, Vec<f64>),
        intervals: usize,
        is_equidistant: bool,
    ) -> Self {
        let count = delta_k.len();
        Self {
            gamma: (0..count).map(|step| length * (step as f64 / (count - 1) as f64)).collect(),
            q,
            delta_k_max: delta_k.iter().fold(0.0, |most: f64, value| most.max(value.abs())),
            delta_k,
            stretches: is_equidistant.then_some(0..count).into_iter().collect(),
            intervals,
            delta_energy_max: None,
            charges: None,
            last_node: None,
            iterations: None,
        }
    }

    /// The largest error of each coordinate over the nodes.
    pub(super) fn errors(&self, reference: &[Point]) -> Vec<f64> {
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

    /// The coordinate with the largest sawtooth in units of its size, among these.
    pub(super) fn roughest(&self, active: &[usize], sizes: Option<&Sizes>) -> Option<usize> {
        let share = |a: usize| Some((a, self.sawtooth(&self.q[a])? / sizes.map_or(1.0, |sizes| sizes.q[a])));
        let most = active.iter().filter_map(|&a| share(a)).max_by(|one, other| one.1.total_cmp(&other.1));
        most.map(|(a, _)| a)
    }

    /// The mean of ΔK over the last quarter of the nodes minus that over the first quarter.
    pub(super) fn k_drift(&self) -> f64 {
        let count = self.delta_k.len();
        let quarter = (count / 4).max(1).min(count);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        mean(&self.delta_k[count - quarter..]) - mean(&self.delta_k[..quarter])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coordinates 0 and 1 on five nodes, both with a sawtooth.
    fn track(delta_k: Vec<f64>) -> Track {
        let sawtooth = |size: f64| (0..5).map(|k| if k % 2 == 0 { size } else { -size }).collect::<Vec<f64>>();
        Track::of_steps(1.0, (vec![sawtooth(3.0), sawtooth(2.0)], delta_k), 4, true)
    }

    #[test]
    fn the_roughest_coordinate_is_so_in_units_of_its_size() {
        let (track, sizes) = (track(vec![0.0; 5]), Sizes { q: vec![100.0, 10.0], k: 1.0 });
        assert_eq!((track.roughest(&[0, 1], None), track.roughest(&[0, 1], Some(&sizes))), (Some(0), Some(1)));
        assert_eq!((track.roughest(&[0], Some(&sizes)), track.roughest(&[], None)), (Some(0), None));
    }

    #[test]
    fn a_drift_is_the_difference_of_the_quarters_at_the_ends() {
        let drift = |delta_k: &[f64]| track(delta_k.to_vec()).k_drift();
        assert_eq!(drift(&[1.0, 3.0, 9.0, 9.0, 9.0, 9.0, 5.0, 6.0]), 3.5);
        assert_eq!((drift(&[1.0, 4.0]), drift(&[7.0; 9])), (3.0, 0.0));
    }
}
