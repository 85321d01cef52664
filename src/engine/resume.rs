//! The end of a run as a start: the values that a window hands on, so that a run that continues it has the digits of
//! one, and how a run begins from them.

use serde::{Deserialize, Serialize};

use super::State;
use super::rule::Order;
use super::window::Solver;
use crate::number::Compensated;

/// The rounding errors of the numbers at the end of a run, and the state of the march there.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Handed {
    /// The rounding errors of q^a of all coordinates and of p_a of active ones; nothing where they are not known.
    pub q_low: Vec<f64>,
    /// The same of p_a.
    pub p_low: Vec<f64>,
    /// The march.
    pub march: Option<Marched>,
}

/// The state of a march: the unknowns that are not among q and p, the sizes that changes are compared with, and the
/// slopes that its next first guess continues.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Marched {
    /// The length of its last window.
    pub length: f64,
    /// Velocities where these are unknowns, each with what rounding took from it.
    pub velocities: Vec<[f64; 2]>,
    /// 1/size of every unknown, and of its slope.
    pub inverse_sizes: Vec<[f64; 2]>,
    /// Where ignorable coordinates began, and 1/size of their ways.
    pub ways: Vec<[f64; 2]>,
    /// Slopes on the nodes.
    pub slopes: Vec<Vec<f64>>,
}

impl<const N: usize> Solver<'_, N> {
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
        let is_second = self.system.order == Order::Second;
        if !is_second {
            self.rows[m..].iter_mut().zip(&self.end.p).for_each(|(row, &p)| row.end = p);
        }
        let fits = |march: &&Marched| march.slopes.len() == self.system.iterated();
        let Some(march) = handed.march.as_ref().filter(fits) else {
            self.advance();
            return false;
        };
        for (row, &[high, low]) in self.rows[m..].iter_mut().zip(&march.velocities) {
            row.end = Compensated { high, low };
        }
        let is_same = march.length == length && march.slopes.iter().all(|row| row.len() == self.rule.points());
        if is_same {
            for (k, (slopes, sizes)) in march.slopes.iter().zip(&march.inverse_sizes).enumerate() {
                self.rows[k].inverse_size = sizes[0];
                if is_second {
                    self.rows[m + k].inverse_size = sizes[1];
                }
                self.rows[k].slopes_before.0[..slopes.len()].copy_from_slice(slopes);
            }
            for (k, &[origin, inverse_size]) in march.ways.iter().enumerate().take(self.origin.len()) {
                (self.origin[k], self.inverse_ignorable[k]) = (origin, inverse_size);
            }
        }
        self.advance();
        is_same
    }
}
