//! The end of a run as a start: what a window hands on, and how a run begins from it.

use super::State;
use super::handed::{Handed, Marched};
use super::rule::Order;
use super::window::Solver;
use crate::number::Compensated;

impl<const N: usize> Solver<'_, N> {
    /// The values that the finished window hands on.
    pub(super) fn handed(&self) -> Handed {
        let pair = |sum: Compensated<f64>| [sum.high, sum.low];
        let velocities = self.rows.iter().filter(|_| self.system.order == Order::Second);
        let march = Marched {
            length: self.length,
            velocities: velocities.map(|row| pair(row.velocity_end)).collect(),
            inverse_sizes: self.rows.iter().map(|row| [row.inverse_size, row.inverse_speed]).collect(),
            ways: self.origin.iter().zip(&self.inverse_ignorable).map(|(&origin, &size)| [origin, size]).collect(),
            slopes: self.rows.iter().map(|row| row.slopes_before.0[..self.rule.points()].to_vec()).collect(),
        };
        let low = |sums: &[Compensated<f64>]| sums.iter().map(|sum| sum.low).collect();
        Handed { q_low: low(&self.end.q), p_low: low(&self.end.p), march: Some(march) }
    }

    /// Goes to the start of a run that continues another one. Returns true if the slopes of a window like those of this
    /// run, of this length, are known.
    pub(super) fn resume(&mut self, handed: &Handed, length: f64) -> bool {
        let m = self.geometry.active().len();
        let State { q, p } = &mut self.end;
        for (sums, lows) in [(q, &handed.q_low), (p, &handed.p_low)] {
            sums.iter_mut().zip(lows).for_each(|(sum, &low)| sum.low = low);
        }
        for (row, &a) in self.rows.iter_mut().zip(self.geometry.active()) {
            row.end = self.end.q[a];
        }
        for (row, &p) in self.rows.iter_mut().skip(m).zip(&self.end.p) {
            row.end = p;
        }
        let fits = |march: &&Marched| march.slopes.len() == self.rows.len();
        let Some(march) = handed.march.as_ref().filter(fits) else {
            self.advance();
            return false;
        };
        for (row, &[high, low]) in self.rows.iter_mut().zip(&march.velocities) {
            row.velocity_end = Compensated { high, low };
        }
        let is_same = march.length == length && march.slopes.iter().all(|row| row.len() == self.rule.points());
        if is_same {
            for (k, row) in self.rows.iter_mut().enumerate() {
                [row.inverse_size, row.inverse_speed] = march.inverse_sizes[k];
                row.slopes_before.0[..march.slopes[k].len()].copy_from_slice(&march.slopes[k]);
            }
            for (k, &[origin, inverse_size]) in march.ways.iter().enumerate().take(self.origin.len()) {
                (self.origin[k], self.inverse_ignorable[k]) = (origin, inverse_size);
            }
        }
        self.advance();
        is_same
    }
}
