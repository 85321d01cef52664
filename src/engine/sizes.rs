//! The units of a motion, from the motion itself: a time scale, and a size for each unknown.
//!
//! Errors are relative to sizes. Lengths, times or masses that are scaled by powers of two scale these numbers exactly,
//! so that units change no digit of a run.

use super::kernel::Evaluate;
use super::rule::Order;
use super::system::Linear;
use crate::geometry::{Geometry, OutsideGeometry, Start};
use crate::number::norm::max_abs;
use crate::number::vector::{Level, Nodes};

/// A way of an ignorable coordinate that is less than this part of how it may change is none.
const AT_REST: f64 = 1e-3;

/// The time scale and the sizes at the start of a run. What never moves has size 0.
#[derive(Debug, Clone, Default)]
pub(super) struct Sizes {
    /// T, the time in which a small error changes, or the length of the run if that is shorter.
    pub(super) time: f64,
    /// Sizes of active coordinates, and of their momenta or, where these are unknowns, their velocities.
    pub(super) positions: Vec<f64>,
    pub(super) others: Vec<f64>,
    /// Sizes of the ways of ignorable coordinates.
    pub(super) ignorable: Vec<f64>,
}

impl Sizes {
    /// Measures the motion that begins at `start` and lasts for `length`.
    ///
    /// The rate is the fourth root of ½ Σ |S_ij S_ji|, S = J², J the Jacobian of the equations of motion: the frequency
    /// of an oscillator, 0 for free motion. With T = min(1/rate, length) a position q has the size max(|q|, |q̇| T), or
    /// the larger of |q̈| T² and |q⃛| T³ if that is 0. The largest one counts for all coordinates with equal g^aa. A
    /// momentum has the size of what changes its position by that position's size within T.
    ///
    /// An ignorable coordinate has the size of its way in T. If that is next to nothing, it may be at rest at the start
    /// only, and its rate a rounding error: then it has the size of the way by which that changes if active coordinates
    /// and momenta change by their sizes.
    ///
    /// # Errors
    /// If the start is outside the domain.
    pub(super) fn new(geometry: &Geometry, start: &Start, length: f64) -> Result<Self, OutsideGeometry> {
        let active = geometry.active();
        let m = active.len();
        let mut point = geometry.point();
        point.evaluate(&start.q, &start.p)?;
        let slopes: Vec<f64> =
            (active.iter().map(|&a| point.q_dot(a))).chain((0..m).map(|place| point.p_dot(place))).collect();
        let mut jacobian = vec![0.0; 4 * m * m];
        point.jacobian(&start.q, &start.p, |row, column, value| jacobian[row * 2 * m + column] = value);
        let rate = rate(&jacobian, 2 * m);
        let length = length.abs();
        let time = if rate * length > 1.0 { 1.0 / rate } else { length };
        let entry = |row: usize, column: usize| jacobian[row * 2 * m + column];

        let metric = |k: usize| entry(k, m + k);
        let is_same = |k: usize, j: usize| (metric(k) - metric(j)).abs() <= 1e-12 * metric(k).abs();
        let shared = |own: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..m).map(|k| (0..m).filter(|&j| is_same(k, j)).map(own).fold(0.0, f64::max)).collect()
        };
        let first = shared(&|k| start.q[active[k]].abs().max(slopes[k].abs() * time));
        // The derivatives of the slopes along the motion; a force may be 0 at the start and grow in time.
        let along = |slopes: &[f64]| -> Vec<f64> {
            (0..2 * m).map(|row| (0..2 * m).map(|j| entry(row, j) * slopes[j]).sum()).collect()
        };
        let accelerations = along(&slopes);
        let jerks = along(&accelerations);
        let [second, third] =
            [(accelerations, 2), (jerks, 3)].map(|(of, order)| shared(&|k| of[k].abs() * time.powi(order)));
        let of = |k: usize| if first[k] > 0.0 { first[k] } else { second[k].max(third[k]) };
        let positions: Vec<f64> = (0..m).map(of).collect();
        let momentum = |k: usize| {
            let own = metric(k).abs();
            let by = if own > 0.0 { own } else { (0..m).map(|j| entry(k, m + j).abs()).fold(0.0, f64::max) };
            let (size, now) = (positions[k] / (time * by), start.p[active[k]].abs());
            if size.is_finite() { size.max(now) } else { now }
        };
        let speed = |k: usize| if time > 0.0 { slopes[k].abs().max(positions[k] / time) } else { slopes[k].abs() };
        let is_second = geometry.is_separable();
        let others = (0..m).map(|k| if is_second { speed(k) } else { momentum(k) }).collect();
        let ignorable = geometry.ignorable().map(|a| point.q_dot(a).abs() * time).collect();
        let mut sizes = Self { time, positions, others, ignorable };
        let changes = sizes.changes_of_rates(geometry, start, &slopes);
        for (way, change) in sizes.ignorable.iter_mut().zip(changes) {
            *way = if *way > AT_REST * change { *way } else { change };
        }
        Ok(sizes)
    }

    /// By how much the ways of ignorable coordinates change if active coordinates and momenta change by their sizes.
    fn changes_of_rates(&self, geometry: &Geometry, start: &Start, velocities: &[f64]) -> Vec<f64> {
        let mut linear = Linear::<8>::new(geometry, &start.p);
        let (active, is_second) = (geometry.active(), linear.order == Order::Second);
        for (place, &a) in active.iter().enumerate() {
            let second = if is_second { velocities[place] } else { start.p[a] };
            linear.registers[linear.unknowns[place]] = Nodes([start.q[a]; 8]);
            linear.registers[linear.unknowns[active.len() + place]] = Nodes([second; 8]);
        }
        Level::Best.dispatch(Evaluate { registers: &mut linear.registers, steps: linear.steps });
        let sizes = [&self.positions[..], &self.others].concat();
        let mut changes = vec![0.0_f64; self.ignorable.len()];
        for term in &linear.rates {
            let value = term.factor * linear.registers[term.register].0[0];
            changes[term.row] = changes[term.row].max(value.abs() * sizes[term.column] * self.time);
        }
        changes
    }

    /// Raises the sizes of coordinates to these at least, by their index, and those of their momenta as much.
    pub(super) fn raise(&mut self, geometry: &Geometry, floors: &[(usize, f64)]) {
        for &(a, least) in floors {
            match geometry.active().binary_search(&a) {
                Ok(place) => {
                    let factor = least / self.positions[place];
                    self.positions[place] = self.positions[place].max(least);
                    if factor > 1.0 && factor.is_finite() {
                        self.others[place] *= factor;
                    }
                }
                Err(before) => self.ignorable[a - before] = self.ignorable[a - before].max(least),
            }
        }
    }
}

fn rate(jacobian: &[f64], n: usize) -> f64 {
    let square = |i: usize, j: usize| (0..n).map(|k| jacobian[i * n + k] * jacobian[k * n + j]).sum::<f64>();
    // The fourth power of a rate may be out of the range of numbers where the rate is not.
    let rates =
        (0..n * n).map(|at| (at / n, at % n)).map(|(i, j)| square(i, j).abs().sqrt() * square(j, i).abs().sqrt());
    let rates: Vec<f64> = rates.collect();
    let largest = max_abs(&rates);
    if largest == 0.0 {
        return 0.0;
    }
    let sum: f64 = rates.iter().map(|rate| (rate / largest).powi(2)).sum();
    (largest * (0.5 * sum).sqrt()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::Sizes;
    use crate::engine::tests::lifted;

    /// In V = x²/2, ṡ = p_t − x² is 0 at the start, and its slope −2x = −1 makes −0.5 of the size of x within T = 1.
    #[test]
    fn ignorable_coordinate_at_rest_has_a_size() {
        let (geometry, start) = lifted("x^2/2", &["x"], &[0.5], &[0.1]);
        let sizes = Sizes::new(&geometry, &start, 10.0).unwrap();
        let size = sizes.ignorable.last().unwrap();
        assert!(start.q_dot[2].abs() < 1e-15 && (size - 0.5).abs() < 1e-15, "{size}");
    }
}
