//! The end of a solved window, and the integrals on its nodes.

use pulp::{Simd, WithSimd};

use super::rule::{Order, Tables};
use super::system::System;
use super::window::{Known, Solver};
use crate::number::Compensated;
use crate::number::vector::{Lanes, Level, Nodes, Weights, multiply};

impl<const N: usize> Solver<'_, N> {
    /// Computes the end of the window with these tables, and what is wanted on its nodes.
    pub(super) fn finish(&mut self, tables: &Tables<N>, wanted: Known) {
        (self.length, self.known) = (tables.length, Known::Ends);
        Level::Best.dispatch(Finish { solver: self, tables: Some(tables), wanted });
        let active = self.geometry.active();
        for (row, &a) in self.rows.iter().zip(active) {
            self.end.q[a] = row.end;
        }
        for (place, end) in self.end.p.iter_mut().enumerate() {
            *end = match self.system.order {
                Order::First => self.rows[active.len() + place].end,
                Order::Second => {
                    let terms = self.metric[place * active.len()..].iter().zip(&self.rows[active.len()..]);
                    Compensated::from(terms.map(|(g, velocity)| g * velocity.end.high).sum())
                }
            };
        }
    }

    /// Computes what is wanted on the nodes and not known yet.
    pub(super) fn know(&mut self, wanted: Known) {
        if self.known < wanted {
            Level::Best.dispatch(Finish { solver: self, tables: None, wanted });
        }
    }
}

/// Computes the end of a window with its tables, if it is not known, and what is not needed to solve a window.
struct Finish<'a, 'g, 't, const N: usize> {
    solver: &'a mut Solver<'g, N>,
    tables: Option<&'t Tables<N>>,
    wanted: Known,
}

impl<const N: usize> WithSimd for Finish<'_, '_, '_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { solver, tables, wanted } = self;
        if let Some(tables) = tables {
            solver.end_rows(s, tables);
        }
        let Solver { system: System { registers, passes, ignorable, .. }, velocities, elapsed, momenta, .. } = solver;
        let (zero, m) = (Lanes::splat(s, 0.0), velocities.len());
        if wanted >= Known::Velocities && solver.known < Known::Velocities {
            for k in 0..m {
                let (start, slope) = (solver.rows[m + k].start, &registers[passes[0].slopes[k]]);
                let gains = multiply(s, &solver.rule.integral, slope, [zero; 2]);
                let velocity = gains.scale_add(solver.length, Lanes::splat(s, start.low)) + start.high;
                velocities[k] = velocity.nodes();
            }
        }
        if wanted == Known::All && solver.known < Known::All {
            for k in 0..elapsed.len() {
                let ways = multiply(s, &solver.rule.integral, &registers[ignorable[k]], [zero; 2]);
                elapsed[k] = ways.scale_add(solver.length, zero).nodes();
            }
            for (place, momentum) in momenta.iter_mut().enumerate() {
                let mut sum = zero;
                for (k, velocity) in velocities.iter().enumerate() {
                    sum = Lanes::new(s, velocity).scale_add(solver.metric[place * m + k], sum);
                }
                *momentum = sum.nodes();
            }
        }
        solver.known = wanted.max(solver.known);
    }
}

impl<const N: usize> Solver<'_, N> {
    /// Computes the rows at the end of the window, from which the next one is continued, and ignorable coordinates
    /// there.
    #[inline(always)]
    fn end_rows<S: Simd>(&mut self, s: S, tables: &Tables<N>) {
        let Self { system: System { registers, passes, order, ignorable, .. }, rows, .. } = self;
        let (is_exact, m) = (tables.collocation_low.is_some(), rows.len() / 2);
        for pass in &*passes {
            for k in 0..pass.slopes.len() {
                let (velocity, slope) = (rows[m + k].start, &registers[pass.slopes[k]]);
                let row = &mut rows[pass.first + k];
                row.slopes_before = Lanes::new(s, slope).nodes();
                if is_exact {
                    row.end = row.start.plus_small(tables.end_weights.dot(s, slope));
                    if *order == Order::Second {
                        row.end = row.end.plus_small(Compensated::from(tables.length) * velocity);
                    }
                } else {
                    // The increment contains the part that the start lacks.
                    row.end = Compensated::from(row.start.high).plus(row.increment);
                }
                if *order == Order::Second {
                    rows[m + k].end = velocity.plus_small(sum(s, &tables.weights, slope, is_exact));
                }
            }
        }
        for k in 0..ignorable.len() {
            let (a, gain) = (self.ignorable[k], sum(s, &tables.weights, &registers[ignorable[k]], is_exact));
            self.end.q[a] = self.start.q[a].plus_small(gain);
        }
    }
}

#[inline(always)]
fn sum<S: Simd, const N: usize>(s: S, weights: &Weights<N>, values: &Nodes<N>, is_exact: bool) -> Compensated {
    if is_exact {
        weights.dot(s, values)
    } else {
        Compensated::from(Lanes::new(s, &weights.high).dot(Lanes::new(s, values)))
    }
}
