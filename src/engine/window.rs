//! Windows that follow each other: what they start from, and where their solutions are kept.

use super::State;
use super::certificate::Certificate;
use super::row::{Row, grow, inverse};
use super::rule::{Order, Rule};
use super::sizes::Sizes;
use super::system::System;
use super::tangents::Tangents;
use crate::geometry::{Geometry, Start};
use crate::number::Compensated;
use crate::number::vector::Nodes;

/// Solves windows that follow each other.
pub(super) struct Solver<'g, const N: usize> {
    pub(super) geometry: &'g Geometry,
    pub(super) system: System<'g, N>,
    pub(super) rule: Rule<N>,
    /// Positions of active coordinates, and in first order their momenta.
    pub(super) rows: Vec<Row<N>>,
    /// The states at the start and at the end of the window.
    pub(super) start: State,
    pub(super) end: State,
    /// g_ab of active coordinates by rows, where it is constant and velocities are unknowns in place of momenta.
    pub(super) metric: Vec<f64>,
    /// Velocities of active coordinates on the nodes, where they are unknowns.
    pub(super) velocities: Vec<Nodes<N>>,
    /// Ignorable coordinates on the nodes, from the start of the window.
    pub(super) elapsed: Vec<Nodes<N>>,
    /// Momenta of active coordinates on the nodes, where velocities are unknowns.
    pub(super) momenta: Vec<Nodes<N>>,
    /// The ignorable coordinates.
    pub(super) ignorable: Vec<usize>,
    /// Ignorable coordinates at the start of the run, and 1/size of their ways since then.
    pub(super) origin: Vec<f64>,
    pub(super) inverse_ignorable: Vec<f64>,
    /// The errors that the window makes in them.
    pub(super) ignorable_errors: Vec<f64>,
    /// The weights of the highest Legendre modes, if the errors of windows are measured.
    pub(super) highest_modes: Option<[Nodes<N>; 4]>,
    /// From the first certificate on.
    pub(super) certificate: Option<Box<Certificate<'g, N>>>,
    /// From the first window on over which changes are carried.
    pub(super) tangents: Option<Box<Tangents<'g, N>>>,
    /// True while slow sweeps are to go on, as a shorter window is no way out.
    pub(super) is_patient: bool,
    /// True from the first window on in which something overflowed on the way to finite values.
    pub(super) is_mended: bool,
    /// The length of the finished window, and what of it was computed.
    pub(super) length: f64,
    pub(super) known: Known,
}

/// Parts of a finished window. Each includes those before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Known {
    /// Its end.
    Ends,
    /// The velocities of active coordinates on the nodes.
    Velocities,
    /// Everything on the nodes.
    All,
}

impl<'g, const N: usize> Solver<'g, N> {
    /// Windows of this rule.
    pub(super) fn new(geometry: &'g Geometry, rule: Rule<N>, measures: bool) -> Self {
        let (active, system) = (geometry.active(), System::new(geometry));
        let (m, ignorable) = (active.len(), geometry.ignorable().count());
        let separable = if geometry.is_separable() { m } else { 0 };
        Self {
            rows: Vec::with_capacity(2 * m),
            start: State::default(),
            end: State::default(),
            metric: geometry.separable().map_or_else(Vec::new, |inverse| inverted(inverse, m)),
            velocities: vec![Nodes::ZERO; separable],
            elapsed: vec![Nodes::ZERO; ignorable],
            momenta: vec![Nodes::ZERO; separable],
            origin: Vec::with_capacity(ignorable),
            inverse_ignorable: Vec::with_capacity(ignorable),
            ignorable_errors: vec![0.0; ignorable],
            highest_modes: measures.then(|| rule.highest_modes()),
            certificate: None,
            tangents: None,
            is_patient: false,
            is_mended: false,
            length: 0.0,
            known: Known::Ends,
            ignorable: geometry.ignorable().collect(),
            geometry,
            system,
            rule,
        }
    }

    /// Goes to the start of a run.
    pub(super) fn begin(&mut self, start: &Start, sizes: &Sizes) {
        let active = self.geometry.active();
        self.system.begin(start);
        self.is_mended = false;
        self.start = State {
            q: start.q.iter().map(|&q| Compensated::from(q)).collect(),
            p: active.iter().map(|&a| Compensated::from(start.p[a])).collect(),
        };
        self.end = self.start.clone();
        self.rows = rows(self.geometry, self.system.order, start, sizes);
        self.origin = self.ignorable.iter().map(|&a| start.q[a]).collect();
        self.inverse_ignorable = sizes.ignorable.iter().map(|&size| inverse(size)).collect();
    }

    /// Goes on to the window that begins where this one ends.
    pub(super) fn advance(&mut self) {
        self.rows.iter_mut().for_each(Row::advance);
        for (place, &a) in self.ignorable.iter().enumerate() {
            grow(&mut self.inverse_ignorable[place], self.end.q[a].high - self.origin[place]);
        }
        std::mem::swap(&mut self.start, &mut self.end);
    }
}

fn rows<const N: usize>(geometry: &Geometry, order: Order, start: &Start, sizes: &Sizes) -> Vec<Row<N>> {
    let active = geometry.active();
    let velocity = |place: usize| {
        let row = geometry.separable().map(|inverse| &inverse[place * active.len()..][..active.len()]);
        row.map_or(0.0, |row| row.iter().zip(active).map(|(g, &b)| g * start.p[b]).sum())
    };
    let position = |(place, &a): (usize, &usize)| {
        Row::new(start.q[a], velocity(place), [sizes.positions[place], sizes.velocities[place]])
    };
    let momentum = |(place, &a): (usize, &usize)| Row::new(start.p[a], 0.0, [sizes.momenta[place], 0.0]);
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
