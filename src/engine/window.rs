//! One window: its collocation equations, solved, and what follows from the solution.

use pulp::{Simd, WithSimd};

use super::certificate::Certificate;
use super::kernel::{Ends, LocalErrors, Row, Sweeps, Swept, grow, integrated, inverse, plus};
use super::rule::{Order, Rule, Tables};
use super::sizes::Sizes;
use super::system::System;
use super::tangents::Tangents;
use super::{Failure, State};
use crate::geometry::{Geometry, Start};
use crate::number::Compensated;
use crate::number::vector::{Lanes, Level, Matrix, Nodes, Twofold};

/// More sweeps than a window of a good length needs, and more than one of a given length does.
const MOST_SWEEPS: [usize; 2] = [30, 60];

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
    ignorable: Vec<usize>,
    /// Ignorable coordinates at the start of the run, and 1/size of their ways since then.
    pub(super) origin: Vec<f64>,
    pub(super) inverse_ignorable: Vec<f64>,
    /// The errors that the window makes in them.
    pub(super) ignorable_errors: Vec<f64>,
    /// By how much they grow over the window.
    gains: Vec<Twofold>,
    /// The weights of the highest Legendre modes, if the errors of windows are measured.
    highest_modes: Option<[Nodes<N>; 4]>,
    /// From the first certificate on.
    pub(super) certificate: Option<Box<Certificate<'g, N>>>,
    /// From the first window on over which changes are carried.
    pub(super) tangents: Option<Box<Tangents<'g, N>>>,
    most_sweeps: usize,
    /// True while slow sweeps are to go on, as a shorter window is no way out.
    pub(super) is_patient: bool,
    /// True from the first window on in which something overflowed on the way to finite values.
    pub(super) is_mended: bool,
    /// The length of the finished window, and what of it was computed.
    pub(super) length: f64,
    known: Known,
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
            gains: vec![Twofold::ZERO; ignorable],
            highest_modes: measures.then(|| rule.highest_modes()),
            certificate: None,
            tangents: None,
            most_sweeps: MOST_SWEEPS[usize::from(!measures)],
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

    /// Solves the window with these tables until sweeps leave no more than `threshold`, relative to sizes. The first
    /// guess continues the window before, if there is a matrix for that.
    ///
    /// # Errors
    /// If the sweeps do not converge, or if a node is outside the domain.
    pub(super) fn solve(
        &mut self,
        tables: &Tables<N>,
        continuation: Option<&Matrix<N>>,
        threshold: f64,
    ) -> Result<Swept, Failure> {
        let mut swept = self.sweep(tables, continuation, threshold);
        if !swept.is_solved && !self.is_mended && self.system.is_broken() {
            self.is_mended = true;
            swept = self.sweep(tables, None, threshold);
        }
        if !swept.is_solved {
            return Err(Failure::NotConverged);
        }
        match self.system.check_domain(self.rule.points()) {
            Ok(()) => Ok(swept),
            Err(outside) => Err(Failure::OutsideDomain(outside)),
        }
    }

    fn sweep(&mut self, tables: &Tables<N>, continuation: Option<&Matrix<N>>, threshold: f64) -> Swept {
        let System { registers, order, passes, others, ignorable, .. } = &mut self.system;
        Level::Best.dispatch(Sweeps {
            registers,
            rows: &mut self.rows,
            passes,
            order: *order,
            nodes: &self.rule.nodes,
            length: tables.length,
            collocation: &tables.collocation,
            collocation_low: tables.collocation_low.as_deref(),
            continuation,
            threshold,
            most_sweeps: self.most_sweeps,
            is_patient: self.is_patient || !self.rule.has_end(),
            mended: self.is_mended.then(|| &self.geometry.hamiltonian().program),
            others,
            ignorable,
            inverse_ignorable: &self.inverse_ignorable,
            ignorable_errors: &mut self.ignorable_errors,
            points: self.rule.points(),
            highest_modes: self.highest_modes.as_ref(),
        })
    }

    /// Computes the end of the window with these tables, and what is wanted on its nodes.
    pub(super) fn finish(&mut self, tables: &Tables<N>, wanted: Known) {
        (self.length, self.known) = (tables.length, Known::Ends);
        Level::Best.dispatch(Finish { solver: self, tables: Some(tables), wanted });
        for (&a, &gain) in self.ignorable.iter().zip(&self.gains) {
            self.end.q[a] = plus(self.start.q[a], gain);
        }
        for (row, &a) in self.rows.iter().zip(self.geometry.active()) {
            self.end.q[a] = row.end;
        }
        let m = self.geometry.active().len();
        for (place, end) in self.end.p.iter_mut().enumerate() {
            *end = match self.system.order {
                Order::First => self.rows[m + place].end,
                Order::Second => {
                    let by = &self.metric[place * m..][..m];
                    Compensated::from(by.iter().zip(&self.rows).map(|(g, row)| g * row.velocity_end.high).sum())
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

    /// Puts the end at the last node, if that is its place.
    pub(super) fn end_nodes(&mut self) {
        if !self.rule.has_end() {
            return;
        }
        let last = self.rule.points() - 1;
        for (place, &a) in self.geometry.active().iter().enumerate() {
            self.system.registers[self.system.positions[place]].0[last] = self.end.q[a].high;
            let momentum = match self.system.order {
                Order::First => &mut self.system.registers[self.system.momenta[place]],
                Order::Second => &mut self.momenta[place],
            };
            momentum.0[last] = self.end.p[place].high;
        }
    }

    /// Goes on to the window that begins where this one ends.
    pub(super) fn advance(&mut self) {
        self.rows.iter_mut().for_each(Row::advance);
        for (place, &a) in self.ignorable.iter().enumerate() {
            grow(&mut self.inverse_ignorable[place], self.end.q[a].high - self.origin[place]);
        }
        std::mem::swap(&mut self.start, &mut self.end);
    }

    /// The local error at the end of the window with these errors, if modes that its nodes do not see are smaller by
    /// `decay` than the highest ones that they see: they make errors at the end, too.
    pub(super) fn with_unseen(&mut self, local: LocalErrors, decay: f64) -> f64 {
        let unseen = local.tail * decay;
        let factor = unseen / local.end;
        if factor > 1.0 && factor.is_finite() {
            let own = self.rows.iter_mut().map(|row| &mut row.end_error);
            own.chain(&mut self.ignorable_errors).for_each(|error| *error *= factor);
            return unseen;
        }
        local.end
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
        let Solver { system, rule, rows, gains, velocities, elapsed, momenta, metric, length, known, .. } = solver;
        let System { registers, order, passes, ignorable, .. } = system;
        if let Some(tables) = tables {
            Ends { registers, rows, passes, order: *order, tables, ignorable, gains }.with_simd(s);
        }
        let matrix = &rule.integral;
        if wanted >= Known::Velocities && *known < Known::Velocities {
            for k in 0..velocities.len() {
                let slope = &registers[passes[0].slopes[k]];
                velocities[k] = integrated(s, matrix, *length, slope, rows[k].velocity);
            }
        }
        if wanted == Known::All && *known < Known::All {
            for k in 0..elapsed.len() {
                elapsed[k] = integrated(s, matrix, *length, &registers[ignorable[k]], Compensated::default());
            }
            for place in 0..momenta.len() {
                let mut sum = Lanes::splat(s, 0.0);
                for k in 0..velocities.len() {
                    sum = Lanes::new(s, &velocities[k]).scale_add(metric[place * velocities.len() + k], sum);
                }
                momenta[place] = sum.nodes();
            }
        }
        *known = wanted.max(*known);
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
