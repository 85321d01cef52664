//! One window: its collocation equations, solved, and what follows from the solution.

use super::kernel::{Product, Row, Sums, Sweeps, Swept};
use super::rule::{Order, Rule, Tables};
use super::sizes::Sizes;
use super::system::System;
use super::{Failure, State};
use crate::formula::Register;
use crate::geometry::{Geometry, Start};
use crate::number::Compensated;
use crate::number::vector::twofold::two_product;
use crate::number::vector::{Level, Nodes, Twofold, Weights};

/// Solves windows that follow each other.
pub(super) struct Solver<'g, const N: usize> {
    pub(super) geometry: &'g Geometry,
    pub(super) system: System<'g, N>,
    pub(super) rule: Rule<N>,
    /// Positions of active coordinates, and in first order their momenta.
    rows: Vec<Row<N>>,
    /// The states at the start and at the end of the window.
    pub(super) start: State,
    pub(super) end: State,
    /// g_ab of active coordinates by rows, where it is constant and velocities are unknowns in place of momenta.
    metric: Vec<f64>,
    /// Velocities of active coordinates on the nodes, where they are unknowns.
    velocities: Vec<Nodes<N>>,
    /// Ignorable coordinates on the nodes, from the start of the window.
    pub(super) elapsed: Vec<Nodes<N>>,
    /// Momenta of active coordinates on the nodes.
    pub(super) momenta: Vec<Nodes<N>>,
    sums: Vec<Twofold>,
    /// True if a window was solved before this one.
    follows: bool,
}

impl<'g, const N: usize> Solver<'g, N> {
    /// Windows of a rule of `points` ≤ N nodes, of which the first one begins at `start`.
    pub(super) fn new(geometry: &'g Geometry, start: &Start, sizes: &Sizes, points: usize) -> Self {
        let (active, mut system) = (geometry.active(), System::new(geometry));
        system.begin(start);
        let state = State {
            q: start.q.iter().map(|&q| Compensated::from(q)).collect(),
            p: active.iter().map(|&a| Compensated::from(start.p[a])).collect(),
        };
        let ignorable = geometry.ignorable().count();
        Self {
            rows: rows(geometry, system.order, start, sizes),
            rule: Rule::new(points),
            start: state.clone(),
            end: state,
            metric: geometry.separable().map_or_else(Vec::new, |inverse| inverted(inverse, active.len())),
            velocities: vec![Nodes::ZERO; if geometry.is_separable() { active.len() } else { 0 }],
            elapsed: vec![Nodes::ZERO; ignorable],
            momenta: vec![Nodes::ZERO; active.len()],
            sums: Vec::new(),
            follows: false,
            geometry,
            system,
        }
    }

    /// Solves the window with these tables until sweeps leave no more than `threshold`, relative to sizes.
    ///
    /// # Errors
    /// If the sweeps do not converge, also from the motion without forces, or if a node is outside the domain.
    pub(super) fn solve(&mut self, tables: &Tables<N>, threshold: f64) -> Result<Swept, Failure> {
        let mut swept = self.sweep(tables, threshold, self.follows);
        if !swept.is_solved && self.follows {
            // A guess may lie outside the domain.
            let again = self.sweep(tables, threshold, false);
            swept = Swept { sweeps: swept.sweeps + again.sweeps, ..again };
        }
        if !swept.is_solved {
            return Err(Failure::NotConverged);
        }
        match self.system.complete(self.rule.points()) {
            Ok(()) => Ok(swept),
            Err(outside) => Err(Failure::OutsideDomain(outside)),
        }
    }

    fn sweep(&mut self, tables: &Tables<N>, threshold: f64, continues: bool) -> Swept {
        Level::Best.dispatch(Sweeps {
            order: self.system.order,
            registers: &mut self.system.registers,
            rows: &mut self.rows,
            passes: &self.system.passes,
            nodes: &self.rule.nodes,
            length: tables.length,
            collocation: &tables.collocation,
            collocation_low: &tables.collocation_low,
            continuation: continues.then_some(&tables.continuation),
            threshold,
        })
    }

    /// Computes the end of the window with these tables, and the nodes of ignorable coordinates and of momenta.
    pub(super) fn finish(&mut self, tables: &Tables<N>) {
        let h = tables.length;
        for (to, &register) in self.elapsed.iter_mut().zip(&self.system.ignorable) {
            *to = self.system.registers[register];
        }
        Level::Best.dispatch(Product { matrix: &self.rule.integral, factor: h, rows: &mut self.elapsed });
        let System { registers, ignorable, .. } = &self.system;
        add_up(&tables.weights, registers, ignorable, &mut self.sums);
        for (a, &sum) in self.geometry.ignorable().zip(&self.sums) {
            self.end.q[a] = plus(self.start.q[a], sum);
        }
        self.finish_rows(tables);
        for (row, &a) in self.rows.iter().zip(self.geometry.active()) {
            self.end.q[a] = row.end;
        }
        match self.system.order {
            Order::First => {
                let rows = &self.rows[self.momenta.len()..];
                for (place, (row, &register)) in rows.iter().zip(&self.system.momenta).enumerate() {
                    (self.momenta[place], self.end.p[place]) = (self.system.registers[register], row.end);
                }
            }
            Order::Second => self.finish_velocities(tables),
        }
    }

    /// The rows at the end, of which positions also move without forces in second order.
    fn finish_rows(&mut self, tables: &Tables<N>) {
        for pass in &self.system.passes {
            add_up(&tables.end_weights, &self.system.registers, &pass.slopes, &mut self.sums);
            for (row, &sum) in self.rows[pass.first..].iter_mut().zip(&self.sums) {
                row.end = plus(row.start, sum);
                if self.system.order == Order::Second {
                    let (way, low) = two_product(tables.length, row.velocity.high);
                    row.end = plus(row.end, Twofold::new(way, low + tables.length * row.velocity.low));
                }
            }
        }
    }

    /// Velocities are integrals of the slopes, and momenta follow from them.
    fn finish_velocities(&mut self, tables: &Tables<N>) {
        for (to, &register) in self.velocities.iter_mut().zip(&self.system.passes[0].slopes) {
            *to = self.system.registers[register];
        }
        Level::Best.dispatch(Product {
            matrix: &self.rule.integral,
            factor: tables.length,
            rows: &mut self.velocities,
        });
        let System { registers, passes, .. } = &self.system;
        add_up(&tables.weights, registers, &passes[0].slopes, &mut self.sums);
        for ((row, gains), &sum) in self.rows.iter_mut().zip(&mut self.velocities).zip(&self.sums) {
            let Compensated { high, low } = row.velocity;
            row.velocity = plus(row.velocity, sum);
            gains.0.iter_mut().for_each(|gain| *gain = high + (low + *gain));
        }
        let m = self.rows.len();
        for (place, (p, end)) in self.momenta.iter_mut().zip(&mut self.end.p).enumerate() {
            let by = &self.metric[place * m..][..m];
            *p = Nodes::ZERO;
            for (&g, velocity) in by.iter().zip(&self.velocities).filter(|(g, _)| **g != 0.0) {
                p.0.iter_mut().zip(&velocity.0).for_each(|(p, v)| *p += g * v);
            }
            *end = Compensated::from(by.iter().zip(&self.rows).map(|(g, row)| g * row.velocity.high).sum());
        }
    }

    /// Goes on to the window that begins where this one ends.
    pub(super) fn advance(&mut self) {
        for pass in &self.system.passes {
            for (row, &slope) in self.rows[pass.first..].iter_mut().zip(&pass.slopes) {
                row.advance(&self.system.registers[slope]);
            }
        }
        std::mem::swap(&mut self.start, &mut self.end);
        self.follows = true;
    }

    /// p_a at the start of the window, of any coordinate.
    pub(super) fn start_momentum(&self, a: usize) -> f64 {
        match self.geometry.active().iter().position(|&active| active == a) {
            Some(place) => self.start.p[place].high,
            None => self.system.charge(a),
        }
    }

    /// The nodes of the position of an active coordinate, by its place among them.
    pub(super) fn position(&self, place: usize) -> &Nodes<N> {
        &self.system.registers[self.system.positions[place]]
    }
}

/// Adds up what these registers have on the nodes.
fn add_up<const N: usize>(weights: &Weights<N>, registers: &[Nodes<N>], from: &[Register], sums: &mut Vec<Twofold>) {
    Level::Best.dispatch(Sums { weights, registers, from, sums });
}

/// A sum with one more term, of which nothing is lost.
fn plus(sum: Compensated<f64>, term: Twofold) -> Compensated<f64> {
    let Twofold { hi: high, lo: low } = Twofold { hi: sum.high, lo: sum.low }.plus_update((term.hi, term.lo));
    Compensated { high, low }
}

fn rows<const N: usize>(geometry: &Geometry, order: Order, start: &Start, sizes: &Sizes) -> Vec<Row<N>> {
    let active = geometry.active();
    let velocity = |place: usize| {
        let row = geometry.separable().map(|inverse| &inverse[place * active.len()..][..active.len()]);
        row.map_or(0.0, |row| row.iter().zip(active).map(|(g, &b)| g * start.p[b]).sum())
    };
    let position = |(place, &a): (usize, &usize)| Row::new(start.q[a], velocity(place), sizes.positions[place]);
    let momentum = |(place, &a): (usize, &usize)| Row::new(start.p[a], 0.0, sizes.momenta[place]);
    let positions = active.iter().enumerate().map(position);
    match order {
        Order::First => positions.chain(active.iter().enumerate().map(momentum)).collect(),
        Order::Second => positions.collect(),
    }
}

/// The inverse of a matrix of m rows.
fn inverted(matrix: &[f64], m: usize) -> Vec<f64> {
    let inverse = nalgebra::DMatrix::from_row_slice(m, m, matrix).try_inverse().expect("a metric has an inverse");
    (0..m * m).map(|place| inverse[(place / m, place % m)]).collect()
}
