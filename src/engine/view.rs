//! A finished window as it is read: by unknowns, by coordinates, and by who pulls it.

use super::certificate::Certificate;
use super::dense::{Curve, Dense, integrated};
use super::resume::{Handed, Marched};
use super::rule::Order;
use super::sensitivity::Sensitivity;
use super::solved::{Solved, State, WindowNodes};
use super::tangents::Tangents;
use super::window::{Known, Solver};
use crate::number::Compensated;
use crate::number::vector::Nodes;

impl<const N: usize> Solver<'_, N> {
    /// A bound of the error that the finished window makes in unknown k, of positions and momenta or velocities.
    pub(super) fn end_error(&self, k: usize) -> f64 {
        let m = self.rows.len() / 2;
        match self.system.order {
            Order::Second if k < m => self.length * self.rows[m + k].end_error,
            _ => self.rows[k].end_error,
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
            (None, Order::Second) => self.rows[self.rows.len() / 2 + number].end.high,
        }
    }

    /// 1/size of a coordinate, by that number.
    pub(super) fn inverse_size(&self, number: usize) -> f64 {
        self.ignorable_place(number).map_or_else(|| self.rows[number].inverse_size, |j| self.inverse_ignorable[j])
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

/// A solver whose windows are lent, with room for what is asked of them.
pub(super) struct Lent<'g, const N: usize> {
    pub(super) solver: Solver<'g, N>,
    certificate: Option<Box<Certificate<'g, N>>>,
    tangents: Option<Box<Tangents<'g, N>>>,
}

impl<'g, const N: usize> From<Solver<'g, N>> for Lent<'g, N> {
    fn from(solver: Solver<'g, N>) -> Self {
        Self { solver, certificate: None, tangents: None }
    }
}

impl<const N: usize> Solved for Lent<'_, N> {
    fn start(&self) -> &State {
        &self.solver.start
    }

    fn end(&self) -> &State {
        &self.solver.end
    }

    fn nodes(&mut self) -> &dyn WindowNodes {
        let solver = &mut self.solver;
        solver.know(Known::All);
        if !solver.rule.has_end() {
            return solver;
        }
        // The end is at the last node.
        let last = solver.rule.points() - 1;
        for (place, &a) in solver.geometry.active().iter().enumerate() {
            solver.system.registers[solver.system.positions[place]].0[last] = solver.end.q[a].high;
            let momentum = match solver.system.order {
                Order::First => &mut solver.system.registers[solver.system.momenta[place]],
                Order::Second => &mut solver.momenta[place],
            };
            momentum.0[last] = solver.end.p[place].high;
        }
        solver
    }

    fn dense(&self) -> Dense {
        let solver = &self.solver;
        let (geometry, h, points) = (solver.geometry, solver.length, solver.rule.points());
        let m = geometry.active().len();
        let curve = |[start, end]: [Compensated<f64>; 2], increment| Curve { start, end: end.high, increment };
        let integral = |slopes: &Nodes<N>| integrated(&solver.rule.modes(slopes)[..points], h);
        let mut gains: Vec<Vec<f64>> = Vec::with_capacity(m);
        let q = (0..geometry.dimension()).map(|a| {
            let number = solver.number_of(a);
            let increment = match (solver.ignorable_place(number), solver.system.order) {
                (Some(j), _) => integral(solver.rate_nodes(j)),
                (None, Order::First) => integral(solver.slope_nodes(number)),
                (None, Order::Second) => {
                    let mut increment = integral(solver.slope_nodes(number));
                    gains.push(increment.clone());
                    // With the velocity at the start, what was integrated once is the velocity.
                    increment[0] += solver.rows[m + number].start.high;
                    integrated(&increment, h)
                }
            };
            curve([solver.start.q[a], solver.end.q[a]], increment)
        });
        let q = q.collect();
        let increments = match solver.system.order {
            Order::First => (m..2 * m).map(|row| integral(solver.slope_nodes(row))).collect(),
            Order::Second => solver.momenta_of(&gains),
        };
        let ends = solver.start.p.iter().zip(&solver.end.p);
        let p = ends.zip(increments).map(|((&start, &end), increment)| curve([start, end], increment)).collect();
        Dense { p, q }
    }

    fn handed(&self) -> Handed {
        let solver = &self.solver;
        let pair = |sum: Compensated<f64>| [sum.high, sum.low];
        let (iterated, velocities) = solver.rows.split_at(solver.system.iterated());
        let speed = |k: usize| velocities.get(k).map_or(0.0, |velocity| velocity.inverse_size);
        let march = Marched {
            length: solver.length,
            velocities: velocities.iter().map(|row| pair(row.end)).collect(),
            inverse_sizes: iterated.iter().enumerate().map(|(k, row)| [row.inverse_size, speed(k)]).collect(),
            ways: solver.origin.iter().zip(&solver.inverse_ignorable).map(|(&origin, &size)| [origin, size]).collect(),
            slopes: iterated.iter().map(|row| row.slopes_before.0[..solver.rule.points()].to_vec()).collect(),
        };
        let low = |sums: &[Compensated<f64>]| sums.iter().map(|sum| sum.low).collect();
        Handed { q_low: low(&solver.end.q), p_low: low(&solver.end.p), march: Some(march) }
    }

    fn gradient_norm(&mut self) -> Option<f64> {
        let Self { solver, certificate, .. } = self;
        solver.rule.has_end().then(|| {
            solver.know(Known::All);
            certificate.get_or_insert_with(|| Box::new(Certificate::new(solver))).of(solver)
        })
    }

    fn carry(&mut self, sensitivity: &mut Sensitivity) {
        let Self { solver, tangents, .. } = self;
        tangents.get_or_insert_with(|| Box::new(Tangents::new(solver))).follow(solver, sensitivity);
    }
}
