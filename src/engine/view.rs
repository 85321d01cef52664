//! A finished window as it is read: by unknowns and by coordinates.

use super::dense::{Curve, Dense, integrated};
use super::kernel::Row;
use super::rule::Order;
use super::window::Solver;
use crate::number::Compensated;
use crate::number::vector::Nodes;

/// The place of a coordinate among the active ones, or among the ignorable ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    Active(usize),
    Ignorable(usize),
}

/// An unknown at the ends of a window.
pub(super) struct Unknown {
    pub(super) inverse_size: f64,
    /// The larger one of its absolute values there.
    pub(super) magnitude: f64,
    /// A bound of the error that the window makes.
    pub(super) end_error: f64,
}

impl<const N: usize> Solver<'_, N> {
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
            (None, _) => &self.system.registers[self.system.positions[k]],
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

    /// The combination of velocities that a momentum is, where they are unknowns: of each the same coefficients.
    pub(super) fn momentum_of(&self, place: usize, velocities: &[Vec<f64>]) -> Vec<f64> {
        let mut momentum = vec![0.0; velocities[0].len()];
        for (g, velocity) in self.metric[place * velocities.len()..].iter().zip(velocities) {
            momentum.iter_mut().zip(velocity).for_each(|(sum, c)| *sum += g * c);
        }
        momentum
    }

    /// The place of a coordinate.
    pub(super) fn place_of(&self, coordinate: usize) -> Place {
        match self.geometry.active().binary_search(&coordinate) {
            Ok(place) => Place::Active(place),
            Err(before) => Place::Ignorable(coordinate - before),
        }
    }

    /// q̇^a at the end of the window.
    pub(super) fn end_rate(&self, place: Place) -> f64 {
        match (place, self.system.order) {
            (Place::Ignorable(j), _) => self.rate_nodes(j).0[N - 1],
            (Place::Active(place), Order::First) => self.slope_nodes(place).0[N - 1],
            (Place::Active(place), Order::Second) => self.rows[place].velocity_end.high,
        }
    }

    /// 1/size of a coordinate.
    pub(super) fn inverse_size(&self, place: Place) -> f64 {
        match place {
            Place::Active(place) => self.rows[place].inverse_size,
            Place::Ignorable(j) => self.inverse_ignorable[j],
        }
    }

    /// The sizes of all coordinates.
    pub(super) fn sizes(&self) -> Vec<f64> {
        let size = |a: usize| {
            let (inverse, end) = (self.inverse_size(self.place_of(a)), self.end.q[a].high);
            let way = if let Place::Ignorable(j) = self.place_of(a) { end - self.origin[j] } else { end };
            if inverse > 0.0 { way.abs().max(1.0 / inverse) } else { way.abs() }
        };
        (0..self.geometry.dimension()).map(size).collect()
    }

    /// The motion over the window that was solved.
    pub(super) fn motion(&self) -> Dense {
        let (geometry, h, points) = (self.geometry, self.length, self.rule.points());
        let (n, m) = (geometry.dimension(), geometry.active().len());
        let curve = |[start, end]: [Compensated<f64>; 2], increment| Curve { start, end: end.high, increment };
        let ends_of_q = |a: usize| [self.start.q[a], self.end.q[a]];
        let ends_of_p = |place: usize| [self.start.p[place], self.end.p[place]];
        let integral = |slopes: &Nodes<N>| integrated(&self.rule.modes(slopes)[..points], h);
        let mut q: Vec<Option<Curve>> = vec![None; n];
        for (j, a) in geometry.ignorable().enumerate() {
            q[a] = Some(curve(ends_of_q(a), integral(self.rate_nodes(j))));
        }
        let mut gains: Vec<Vec<f64>> = Vec::with_capacity(m);
        for (place, &a) in geometry.active().iter().enumerate() {
            let mut increment = integral(self.slope_nodes(place));
            if self.system.order == Order::Second {
                gains.push(increment.clone());
                // With the velocity at the start, what was integrated once is the velocity.
                increment[0] += self.rows[place].velocity.high;
                increment = integrated(&increment, h);
            }
            q[a] = Some(curve(ends_of_q(a), increment));
        }
        let p = (0..m).map(|place| {
            let increment = match self.system.order {
                Order::First => integral(self.slope_nodes(m + place)),
                Order::Second => self.momentum_of(place, &gains),
            };
            curve(ends_of_p(place), increment)
        });
        Dense { p: p.collect(), q: q.into_iter().flatten().collect(), degree: points + 1 }
    }

    /// The nodes of the position of an active coordinate, by its place among them.
    pub(super) fn position(&self, place: usize) -> &Nodes<N> {
        self.system.position(place)
    }

    /// The nodes of its momentum.
    pub(super) fn momentum(&self, place: usize) -> &Nodes<N> {
        match self.system.order {
            Order::First => &self.system.registers[self.system.momenta[place]],
            Order::Second => &self.momenta[place],
        }
    }
}
