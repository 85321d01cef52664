//! The units of a motion, from the motion itself: a time scale, and a size for each unknown.
//!
//! Errors are relative to sizes. Lengths, times or masses that are scaled by powers of two scale these numbers exactly,
//! so that units change no digit of a run.

use crate::geometry::{Geometry, OutsideGeometry, Start};

/// The time scale and the sizes at the start of a run. What never moves has size 0.
#[derive(Debug, Clone, Default)]
pub(super) struct Sizes {
    /// T, the time in which a small error changes, or the length of the run if that is shorter.
    pub(super) time: f64,
    /// Sizes of active coordinates, and of their momenta and velocities.
    pub(super) positions: Vec<f64>,
    pub(super) momenta: Vec<f64>,
    pub(super) velocities: Vec<f64>,
    /// Sizes of the ways of ignorable coordinates.
    pub(super) ignorable: Vec<f64>,
}

impl Sizes {
    /// Measures the motion that begins at `start` and lasts for `length`.
    ///
    /// The rate is the fourth root of ½ Σ |S_ij S_ji|, S = J², J the Jacobian of the equations of motion: the frequency
    /// of an oscillator, 0 for free motion. With T = min(1/rate, length) a position q has the size max(|q|, |q̇| T), or
    /// |q̈| T² if that is 0. The largest one counts for all coordinates with equal g^aa. A momentum has the size of
    /// what changes its position by that position's size within T, and an ignorable coordinate that of its way in T.
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
        let second = shared(&|k| (0..2 * m).map(|j| entry(k, j) * slopes[j]).sum::<f64>().abs() * time * time);
        let positions: Vec<f64> = first.iter().zip(&second).map(|(&q, &way)| if q > 0.0 { q } else { way }).collect();
        let momenta = (0..m).map(|k| {
            let own = metric(k).abs();
            let by = if own > 0.0 { own } else { (0..m).map(|j| entry(k, m + j).abs()).fold(0.0, f64::max) };
            let (size, now) = (positions[k] / (time * by), start.p[active[k]].abs());
            if size.is_finite() { size.max(now) } else { now }
        });
        let momenta = momenta.collect();
        let speed = |k: usize| if time > 0.0 { slopes[k].abs().max(positions[k] / time) } else { slopes[k].abs() };
        let ignorable = geometry.ignorable().map(|a| point.q_dot(a).abs() * time).collect();
        Ok(Self { time, momenta, velocities: (0..m).map(speed).collect(), ignorable, positions })
    }
}

fn rate(jacobian: &[f64], n: usize) -> f64 {
    let square = |i: usize, j: usize| (0..n).map(|k| jacobian[i * n + k] * jacobian[k * n + j]).sum::<f64>();
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..n {
            sum += (square(i, j) * square(j, i)).abs();
        }
    }
    (0.5 * sum).sqrt().sqrt()
}
