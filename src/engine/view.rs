//! A finished window as it is read: by unknowns, by coordinates, and by who pulls it.

use super::certificate::Certificate;
use super::dense::{Curve, Dense, integrated};
use super::resume::{Handed, Marched};
use super::row::Row;
use super::rule::Order;
use super::sensitivity::Sensitivity;
use super::solved::{Solved, State, WindowNodes};
use super::system::Finished;
use super::tangents::Tangents;
use super::window::{Known, Solver};
use crate::number::Compensated;
use crate::number::vector::Nodes;

/// An unknown at the ends of a window.
pub(super) struct Unknown {
    pub(super) inverse_size: f64,
    /// The larger one of its absolute values there.
    pub(super) magnitude: f64,
    /// A bound of the error that the window makes.
    pub(super) end_error: f64,
}

impl<'g, const N: usize> Solver<'g, N> {
    /// One of 2m unknowns at a finished window of length `h`: positions, then momenta or velocities.
    pub(super) fn unknown(&self, k: usize, h: f64) -> Unknown {
        let m = self.geometry.active().len();
        let unknown = |inverse_size: f64, [start, end]: [Compensated<f64>; 2], end_error: f64| Unknown {
            inverse_size,
            magnitude: start.high.abs().max(end.high.abs()),
            end_error,
        };
        let row = |row: &Row<N>, end_error: f64| unknown(row.inverse_size, [row.start, row.end], end_error);
        match self.system.order {
            Order::First => row(&self.rows[k], self.rows[k].end_error),
            Order::Second if k < m => row(&self.rows[k], h * self.rows[k].end_error),
            Order::Second => {
                let row = &self.rows[k - m];
                unknown(row.inverse_speed, [row.velocity, row.velocity_end], row.end_error)
            }
        }
    }

    /// The nodes of an unknown.
    #[inline(always)]
    pub(super) fn unknown_nodes(&self, k: usize) -> &Nodes<N> {
        match (k.checked_sub(self.system.positions.len()), self.system.order) {
            (None, _) => self.system.position(k),
            (Some(place), Order::First) => &self.system.registers[self.system.momenta[place]],
            (Some(place), Order::Second) => &self.velocities[place],
        }
    }

    /// The slopes of a row that sweeps iterate.
    #[inline(always)]
    pub(super) fn slope_nodes(&self, row: usize) -> &Nodes<N> {
        let passes = &self.system.passes;
        let pass = if row < self.system.positions.len() { &passes[passes.len() - 1] } else { &passes[0] };
        &self.system.registers[pass.slopes[row - pass.first]]
    }

    /// The velocities of an ignorable coordinate.
    #[inline(always)]
    pub(super) fn rate_nodes(&self, j: usize) -> &Nodes<N> {
        &self.system.registers[self.system.ignorable[j]]
    }

    /// The number of a coordinate if active ones come first, and then ignorable ones.
    pub(super) fn number_of(&self, coordinate: usize) -> usize {
        match self.geometry.active().binary_search(&coordinate) {
            Ok(place) => place,
            Err(before) => self.system.positions.len() + coordinate - before,
        }
    }

    /// The place of a coordinate with that number among the ignorable ones; `None` if it is active.
    pub(super) fn ignorable_place(&self, number: usize) -> Option<usize> {
        number.checked_sub(self.system.positions.len())
    }

    /// q̇^a at the end of the window, by that number.
    pub(super) fn end_rate(&self, number: usize) -> f64 {
        match (self.ignorable_place(number), self.system.order) {
            (Some(j), _) => self.rate_nodes(j).0[N - 1],
            (None, Order::First) => self.slope_nodes(number).0[N - 1],
            (None, Order::Second) => self.rows[number].velocity_end.high,
        }
    }

    /// 1/size of a coordinate, by that number.
    pub(super) fn inverse_size(&self, number: usize) -> f64 {
        self.ignorable_place(number).map_or_else(|| self.rows[number].inverse_size, |j| self.inverse_ignorable[j])
    }

    fn finished(&self) -> Finished<'_, 'g, N> {
        let Self { system, rule, start, rows, metric, elapsed, length: h, is_mended, .. } = self;
        Finished { system, rule, start, rows, metric, elapsed, h: *h, is_mended: *is_mended }
    }

    /// The sizes of all coordinates.
    pub(super) fn sizes(&self) -> Vec<f64> {
        let size = |a: usize| {
            let (number, end) = (self.number_of(a), self.end.q[a].high);
            let way = self.ignorable_place(number).map_or(end, |j| end - self.origin[j]);
            let inverse = self.inverse_size(number);
            if inverse > 0.0 { way.abs().max(1.0 / inverse) } else { way.abs() }
        };
        (0..self.geometry.dimension()).map(size).collect()
    }

    /// The coefficients of momenta, which are combinations of velocities with these coefficients.
    fn momenta_of(&self, velocities: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let momentum = |place: usize| {
            let mut momentum = vec![0.0; velocities[0].len()];
            for (g, velocity) in self.metric[place * velocities.len()..].iter().zip(velocities) {
                momentum.iter_mut().zip(velocity).for_each(|(sum, c)| *sum += g * c);
            }
            momentum
        };
        (0..velocities.len()).map(momentum).collect()
    }
}

impl<const N: usize> WindowNodes for Solver<'_, N> {
    fn points(&self) -> usize {
        self.rule.points()
    }

    fn fractions(&self) -> &[f64] {
        &self.rule.nodes[0].0[..self.rule.points()]
    }

    fn q(&self, a: usize) -> &[f64] {
        let number = self.number_of(a);
        let place = self.ignorable_place(number);
        let nodes = place.map_or_else(|| self.system.position(number), |j| &self.elapsed[j]);
        &nodes.0[..self.rule.points()]
    }

    fn p(&self, place: usize) -> &[f64] {
        let nodes = match self.system.order {
            Order::First => &self.system.registers[self.system.momenta[place]],
            Order::Second => &self.momenta[place],
        };
        &nodes.0[..self.rule.points()]
    }
}

impl<const N: usize> Solved for Solver<'_, N> {
    fn start(&self) -> &State {
        &self.start
    }

    fn end(&self) -> &State {
        &self.end
    }

    fn nodes(&mut self) -> &dyn WindowNodes {
        self.know(Known::All);
        if !self.rule.has_end() {
            return self;
        }
        // The end is at the last node.
        let last = self.rule.points() - 1;
        for (place, &a) in self.geometry.active().iter().enumerate() {
            self.system.registers[self.system.positions[place]].0[last] = self.end.q[a].high;
            let momentum = match self.system.order {
                Order::First => &mut self.system.registers[self.system.momenta[place]],
                Order::Second => &mut self.momenta[place],
            };
            momentum.0[last] = self.end.p[place].high;
        }
        self
    }

    fn dense(&self) -> Dense {
        let (geometry, h, points) = (self.geometry, self.length, self.rule.points());
        let m = geometry.active().len();
        let curve = |[start, end]: [Compensated<f64>; 2], increment| Curve { start, end: end.high, increment };
        let integral = |slopes: &Nodes<N>| integrated(&self.rule.modes(slopes)[..points], h);
        let mut gains: Vec<Vec<f64>> = Vec::with_capacity(m);
        let q = (0..geometry.dimension()).map(|a| {
            let number = self.number_of(a);
            let increment = match (self.ignorable_place(number), self.system.order) {
                (Some(j), _) => integral(self.rate_nodes(j)),
                (None, Order::First) => integral(self.slope_nodes(number)),
                (None, Order::Second) => {
                    let mut increment = integral(self.slope_nodes(number));
                    gains.push(increment.clone());
                    // With the velocity at the start, what was integrated once is the velocity.
                    increment[0] += self.rows[number].velocity.high;
                    integrated(&increment, h)
                }
            };
            curve([self.start.q[a], self.end.q[a]], increment)
        });
        let q = q.collect();
        let increments = match self.system.order {
            Order::First => (m..2 * m).map(|row| integral(self.slope_nodes(row))).collect(),
            Order::Second => self.momenta_of(&gains),
        };
        let ends = self.start.p.iter().zip(&self.end.p);
        let p = ends.zip(increments).map(|((&start, &end), increment)| curve([start, end], increment)).collect();
        Dense { p, q }
    }

    fn handed(&self) -> Handed {
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

    fn gradient_norm(&mut self) -> Option<f64> {
        if !self.rule.has_end() {
            return None;
        }
        self.know(Known::All);
        let new = || Box::new(Certificate::new(self.geometry, &self.rule));
        let mut certificate = self.certificate.take().unwrap_or_else(new);
        let norm = certificate.of(&self.finished());
        self.certificate = Some(certificate);
        Some(norm)
    }

    fn carry(&mut self, sensitivity: &mut Sensitivity) {
        let charges = || (0..self.geometry.dimension()).map(|a| self.system.charge(a)).collect::<Vec<_>>();
        let new = || Box::new(Tangents::new(self.geometry, &self.rule, &charges()));
        let mut tangents = self.tangents.take().unwrap_or_else(new);
        tangents.follow(&self.finished(), sensitivity);
        self.tangents = Some(tangents);
    }
}
