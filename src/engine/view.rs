//! A finished window as it is read: by unknowns, by coordinates, and by who pulls it.

use super::certificate::Certificate;
use super::dense::{Curve, Dense, integrated};
use super::rule::Order;
use super::sensitivity::Sensitivity;
use super::sizes::Size;
use super::solved::{Handed, Marched, Solved, State, WindowNodes};
use super::tangents::Tangents;
use super::window::{Known, Solver};
use crate::number::Compensated;
use crate::number::vector::Nodes;

impl<const N: usize> Solver<'_, N> {
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

    /// The place of a coordinate among the active ones, or else among the ignorable ones.
    pub(super) fn place(&self, a: usize) -> Result<usize, usize> {
        self.geometry.active().binary_search(&a).map_err(|before| a - before)
    }

    /// q̇^a at the end of the window.
    pub(super) fn end_rate(&self, a: usize) -> f64 {
        match (self.place(a), self.system.order) {
            (Err(j), _) => self.rate_nodes(j).0[N - 1],
            (Ok(place), Order::First) => self.slope_nodes(place).0[N - 1],
            (Ok(place), Order::Second) => self.rows[self.rows.len() / 2 + place].end.high,
        }
    }

    /// 1/size of q^a.
    pub(super) fn inverse_size(&self, a: usize) -> f64 {
        self.size(a).inverse
    }

    /// The size of q^a.
    pub(super) fn size(&self, a: usize) -> Size {
        self.place(a).map_or_else(|j| self.ways[j], |place| self.rows[place].size)
    }

    /// The sizes of all coordinates.
    pub(super) fn sizes(&self) -> Vec<f64> {
        let size = |a: usize| {
            let Size { origin, inverse, .. } = self.size(a);
            let way = (self.end.q[a].high - origin).abs();
            if inverse > 0.0 { way.max(1.0 / inverse) } else { way }
        };
        (0..self.geometry.dimension()).map(size).collect()
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
        let nodes = self.place(a).map_or_else(|j| &self.elapsed[j], |place| self.system.position(place));
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
            let increment = match (solver.place(a), solver.system.order) {
                (Err(j), _) => integral(solver.rate_nodes(j)),
                (Ok(place), Order::First) => integral(solver.slope_nodes(place)),
                (Ok(place), Order::Second) => {
                    let mut increment = integral(solver.slope_nodes(place));
                    gains.push(increment.clone());
                    // With the velocity at the start, what was integrated once is the velocity.
                    increment[0] += solver.rows[m + place].start.high;
                    integrated(&increment, h)
                }
            };
            curve([solver.start.q[a], solver.end.q[a]], increment)
        });
        let q = q.collect();
        let increments = match solver.system.order {
            Order::First => (m..2 * m).map(|row| integral(solver.slope_nodes(row))).collect(),
            // Momenta are combinations of velocities.
            Order::Second => {
                let mut momenta = vec![vec![0.0; points + 1]; m];
                for (k, momentum) in momenta.iter_mut().enumerate() {
                    for (g, gain) in solver.metric[k * m..].iter().zip(&gains) {
                        momentum.iter_mut().zip(gain).for_each(|(sum, c)| *sum += g * c);
                    }
                }
                momenta
            }
        };
        let ends = solver.start.p.iter().zip(&solver.end.p);
        let p = ends.zip(increments).map(|((&start, &end), increment)| curve([start, end], increment)).collect();
        Dense { p, q }
    }

    fn handed(&self) -> Handed {
        let solver = &self.solver;
        let pair = |sum: Compensated<f64>| [sum.high, sum.low];
        let (iterated, velocities) = solver.rows.split_at(solver.system.iterated());
        let speed = |k: usize| velocities.get(k).map_or(0.0, |velocity| velocity.size.inverse);
        let march = Marched {
            length: solver.length,
            velocities: velocities.iter().map(|row| pair(row.end)).collect(),
            inverse_sizes: iterated.iter().enumerate().map(|(k, row)| [row.size.inverse, speed(k)]).collect(),
            ways: solver.ways.iter().map(|way| [way.origin, way.inverse]).collect(),
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
