//! By how much unknowns move in a window, and how far that is rounding.

use pulp::Simd;

use super::kernel::Evaluate;
use super::rule::Order;
use super::sizes::UNITS_OF_RATES;
use super::system::{Linear, System, Term};
use super::tuning::STALLED;
use super::window::Solver;
use crate::number::vector::{Lanes, Level, Nodes};

impl<const N: usize> Solver<'_, N> {
    /// Takes sizes from the values on the nodes. Returns true if some were taken to be more than twice as large.
    #[inline(always)]
    pub(super) fn take_sizes<S: Simd>(&mut self, s: S, h: f64) -> bool {
        let Self { system: System { registers, passes, order, .. }, rows, rule, scales, .. } = &mut *self;
        let m = rows.len() / 2;
        for pass in &*passes {
            for k in 0..pass.slopes.len() {
                let row = &mut rows[pass.first + k];
                let way = (Lanes::new(s, &registers[pass.unknowns[k]]) - row.start.high).abs();
                row.size.take(way.largest());
                if *order == Order::Second {
                    let slope = Lanes::new(s, &registers[pass.slopes[k]]).abs();
                    rows[m + k].size.take(h * slope.dot(Lanes::new(s, &rule.weights)));
                }
            }
        }
        if !scales.shared.is_empty() {
            self.share_sizes();
        }
        self.rows.iter().any(|row| row.size.has_shrunk())
    }

    /// The same for the ways of ignorable coordinates, whose rates are known.
    #[inline(always)]
    pub(super) fn take_ways<S: Simd>(&mut self, s: S, h: f64) {
        for (way, &rate) in self.ways.iter_mut().zip(&self.system.ignorable) {
            let rate = Lanes::new(s, &self.system.registers[rate]).abs();
            way.take(h * rate.dot(Lanes::new(s, &self.rule.weights)));
        }
    }

    /// By what rates are rounded at the start of the window. Returns true if that is more than sweeps can leave: where
    /// terms cancel, a rate may be nothing but rounding, and what it moves has no other size.
    #[cold]
    #[inline(never)]
    pub(super) fn measure_noise(&mut self, h: f64) -> bool {
        let (geometry, momenta) = (self.geometry, &self.initial.p);
        let linear = self.linear.get_or_insert_with(|| Box::new(Linear::new(geometry, momenta)));
        for (row, &unknown) in self.rows.iter().zip(&linear.unknowns) {
            linear.registers[unknown] = Nodes([row.start.high; 8]);
        }
        Level::Best.dispatch(Evaluate { registers: &mut linear.registers, steps: linear.steps });
        let level = |terms: &[Term], row: usize| {
            let of = terms.iter().filter(|term| term.row == row);
            let sum = of.map(|term| {
                (term.factor * linear.registers[term.register].0[0] * self.rows[term.column].start.high).abs()
            });
            UNITS_OF_RATES * f64::EPSILON * sum.sum::<f64>()
        };
        let noise: Vec<f64> = (0..self.rows.len()).map(|row| level(&linear.rows, row)).collect();
        let of_ways: Vec<f64> = (0..self.ways.len()).map(|j| level(&linear.rates, j)).collect();
        let (m, is_second) = (self.rows.len() / 2, self.system.order == Order::Second);
        let power = self.system.order.power_of(h);
        let mut matters = false;
        for (row, size) in self.rows.iter_mut().map(|row| &mut row.size).enumerate() {
            // In second order the rows of accelerations come first, and those of velocities have the same slopes.
            let own = if is_second { noise[row % m] } else { noise[row] };
            size.noise = own;
            let by = if is_second && row >= m { h } else { power };
            matters |= own * by * size.inverse > STALLED;
        }
        for (size, own) in self.ways.iter_mut().zip(of_ways) {
            size.noise = own;
            matters |= own * h * size.inverse > STALLED;
        }
        self.is_noisy = matters;
        if !matters {
            self.rows.iter_mut().map(|row| &mut row.size).chain(&mut self.ways).for_each(|size| size.noise = 0.0);
        }
        matters
    }
}

/// A coordinate one of whose rates is rounded by this part of itself is moved by rounding.
const BY_ROUNDING: f64 = 0.1;

impl<const N: usize> Solver<'_, N> {
    /// The coordinates that rounding moves in a window of length h like the last one.
    pub(super) fn moved_by_rounding(&mut self, h: f64) -> Vec<usize> {
        if !self.measure_noise(h) {
            return Vec::new();
        }
        let (active, m) = (self.geometry.active(), self.rows.len() / 2);
        let is_rounding = |row: usize| {
            let rate = self.slope_nodes(row).0.iter().fold(0.0, |most: f64, rate| most.max(rate.abs()));
            self.rows[row].size.noise > BY_ROUNDING * rate
        };
        let iterated = self.system.iterated();
        let moved = |&place: &usize| is_rounding(place) || (m + place < iterated && is_rounding(m + place));
        (0..m).filter(moved).map(|place| active[place]).collect()
    }
}
