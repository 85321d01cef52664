//! Windows that follow each other: what they start from, where their solutions are kept, and their ends.

use pulp::{Simd, WithSimd};

use super::State;
use super::kernel::On;
use super::rule::{Order, Rule, Tables};
use super::sizes::{Scales, Size};
use super::system::{Linear, System};
use crate::geometry::{Geometry, OutsideGeometry, Start};
use crate::number::Compensated;
use crate::number::vector::{Lanes, Level, Nodes, Weights, multiply};
use crate::sbp::collocation::Collocation;

/// One of the unknown functions of γ. Sweeps iterate all of them, but velocities where the equations are of second
/// order.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<const N: usize> {
    /// Its value at the start of the window.
    pub(super) start: Compensated<f64>,
    /// Its size, and by what its rate may be off: see [`sizes`](super::sizes).
    pub(super) size: Size,
    /// Its value at the end of the window.
    pub(super) end: Compensated<f64>,
    /// A bound of what its slope may be off by between the nodes, by its modes.
    pub(super) foreseen: f64,
    /// The increment at the last node, as sweeps left it.
    pub(super) increment: f64,
    /// The part of the increments on the nodes that is known before the window is solved.
    pub(super) offset: Nodes<N>,
    /// The product of the slopes with the part of the matrix that rounding took from its entries.
    pub(super) low: Nodes<N>,
    /// The slopes in the window that was finished last.
    pub(super) slopes_before: Nodes<N>,
}

impl<const N: usize> Row<N> {
    fn new(start: f64, origin: f64, least: f64) -> Self {
        Self {
            start: Compensated::from(start),
            size: Size::new(start, origin, least),
            end: Compensated::from(start),
            foreseen: 0.0,
            increment: 0.0,
            offset: Nodes::ZERO,
            low: Nodes::ZERO,
            slopes_before: Nodes::ZERO,
        }
    }

    /// Goes on to the next window.
    fn advance(&mut self, is_shortest: bool) {
        self.start = self.end;
        self.size.advance(self.start.high, is_shortest);
    }
}

/// Solves windows that follow each other.
pub(super) struct Solver<'g, const N: usize> {
    pub(super) geometry: &'g Geometry,
    /// The start of the run, and its scales there.
    pub(super) initial: Start,
    pub(super) scales: Scales,
    pub(super) system: System<'g, N>,
    pub(super) rule: Rule<N>,
    /// Positions of active coordinates, and their momenta, or in second order their velocities.
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
    /// The sizes of the ways of ignorable coordinates since the start of the run.
    pub(super) ways: Vec<Size>,
    /// The weights of the highest Legendre modes, if the errors of windows are measured.
    pub(super) highest_modes: Option<[Nodes<N>; 4]>,
    /// True while slow sweeps are to go on, as a shorter window is no way out.
    pub(super) is_patient: bool,
    /// True where windows have their least length, so that a failure is one of the run.
    pub(super) is_shortest: bool,
    /// The linearised equations, from when rounding errors of rates are first asked for, and true while these matter.
    pub(super) linear: Option<Box<Linear<'g, 8>>>,
    pub(super) is_noisy: bool,
    /// True from the first window on in which something overflowed on the way to finite values.
    pub(super) is_mended: bool,
    /// The length of the finished window, and what of it was computed.
    pub(super) length: f64,
    pub(super) known: Known,
}

/// The parts of a finished window that were computed. Each includes those before, and none is computed unless it is
/// asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Known {
    /// The state at its end.
    Ends,
    /// The ways of ignorable coordinates on the nodes.
    Ways,
    /// Everything on the nodes.
    All,
}

impl<'g, const N: usize> Solver<'g, N> {
    /// Windows of a rule from a start, in a run of about this length.
    pub(super) fn new(
        geometry: &'g Geometry,
        start: &Start,
        length: f64,
        operators: &'static Collocation,
        measures: bool,
    ) -> Result<Self, OutsideGeometry> {
        let scales = Scales::new(geometry, start, length)?;
        let (m, ignorable, rule) = (geometry.active().len(), geometry.ignorable().count(), Rule::new(operators));
        let separable = if geometry.is_separable() { m } else { 0 };
        let mut solver = Self {
            initial: start.clone(),
            scales,
            rows: Vec::new(),
            start: State::default(),
            end: State::default(),
            metric: geometry.separable().map_or_else(Vec::new, |inverse| inverted(inverse, m)),
            velocities: vec![Nodes::ZERO; separable],
            elapsed: vec![Nodes::ZERO; ignorable],
            momenta: vec![Nodes::ZERO; separable],
            ways: Vec::new(),
            highest_modes: measures.then(|| rule.highest_modes()),
            is_patient: false,
            is_shortest: false,
            linear: None,
            is_noisy: false,
            is_mended: false,
            length: 0.0,
            known: Known::Ends,
            ignorable: geometry.ignorable().collect(),
            geometry,
            system: System::new(geometry),
            rule,
        };
        solver.begin();
        Ok(solver)
    }

    /// Goes to the start of the run.
    pub(super) fn begin(&mut self) {
        let Self { geometry, initial, scales, .. } = self;
        let Start { q, p, .. } = &*initial;
        self.system.begin(p);
        (self.is_mended, self.is_noisy) = (false, false);
        self.start = State {
            q: q.iter().map(|&q| Compensated::from(q)).collect(),
            p: geometry.active().iter().map(|&a| Compensated::from(p[a])).collect(),
        };
        self.end = self.start.clone();
        self.rows = rows(geometry, initial, scales);
        let way = |(&a, &least)| Size::new(q[a], q[a], least);
        self.ways = self.ignorable.iter().zip(&scales.least_ways).map(way).collect();
        self.settle_sizes();
    }

    /// Gives the unknowns of every group the size of the largest of them.
    pub(super) fn share_sizes(&mut self) {
        for group in &self.scales.shared {
            let of = group.iter().map(|&row| self.rows[row].size.inverse).filter(|&inverse| inverse > 0.0);
            let shared = of.fold(f64::INFINITY, f64::min);
            if shared < f64::INFINITY {
                group.iter().for_each(|&row| self.rows[row].size.inverse = shared);
            }
        }
    }

    /// Shares the sizes that the next window starts with.
    fn settle_sizes(&mut self) {
        if !self.scales.shared.is_empty() {
            self.share_sizes();
            self.rows.iter_mut().for_each(|row| row.size.before = row.size.inverse);
        }
    }

    /// Goes on to the window that begins where this one ends.
    pub(super) fn advance(&mut self) {
        self.rows.iter_mut().for_each(|row| row.advance(self.is_shortest));
        self.settle_sizes();
        for (way, &a) in self.ways.iter_mut().zip(&self.ignorable) {
            way.advance(self.end.q[a].high, self.is_shortest);
        }
        std::mem::swap(&mut self.start, &mut self.end);
    }
}

/// Unknowns at the start, with what is known of their sizes there.
fn rows<const N: usize>(geometry: &Geometry, start: &Start, scales: &Scales) -> Vec<Row<N>> {
    let (active, m) = (geometry.active(), geometry.active().len());
    let other = |place: usize| match geometry.separable() {
        Some(inverse) => inverse[place * m..].iter().zip(active).map(|(g, &b)| g * start.p[b]).sum(),
        None => start.p[active[place]],
    };
    let value = |row: usize| if row < m { start.q[active[row]] } else { other(row - m) };
    let origin = |row: usize| if row < m && scales.clocks[row] { start.q[active[row]] } else { 0.0 };
    (0..2 * m).map(|row| Row::new(value(row), origin(row), scales.least[row])).collect()
}

/// The inverse of a matrix of m rows.
fn inverted(matrix: &[f64], m: usize) -> Vec<f64> {
    let inverse = nalgebra::DMatrix::from_row_slice(m, m, matrix).try_inverse().expect("a metric has an inverse");
    (0..m * m).map(|place| inverse[(place / m, place % m)]).collect()
}

impl<const N: usize> Solver<'_, N> {
    /// Computes the end of the window with these tables, and what is wanted on its nodes.
    pub(super) fn finish(&mut self, tables: &Tables<N>, wanted: Known) {
        (self.length, self.known) = (tables.length, Known::Ends);
        Level::Best.dispatch(On((&mut *self, Some(tables), wanted)));
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
            Level::Best.dispatch(On((self, None, wanted)));
        }
    }
}

/// Computes the end of a window with its tables, if it is not known, and what is not needed to solve a window.
impl<const N: usize> WithSimd for On<(&mut Solver<'_, N>, Option<&Tables<N>>, Known)> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let On((solver, tables, wanted)) = self;
        if let Some(tables) = tables {
            solver.end_rows(s, tables);
        }
        let Solver { system: System { registers, passes, ignorable, .. }, velocities, elapsed, momenta, .. } = solver;
        let (zero, m) = (Lanes::splat(s, 0.0), velocities.len());
        if wanted >= Known::Ways && solver.known < Known::Ways {
            for k in 0..elapsed.len() {
                let ways = multiply(s, &solver.rule.integral, &registers[ignorable[k]], [zero; 2]);
                elapsed[k] = ways.scale_add(solver.length, zero).nodes();
            }
        }
        if wanted == Known::All && solver.known < Known::All {
            for k in 0..m {
                let (start, slope) = (solver.rows[m + k].start, &registers[passes[0].slopes[k]]);
                let gains = multiply(s, &solver.rule.integral, slope, [zero; 2]);
                let velocity = gains.scale_add(solver.length, Lanes::splat(s, start.low)) + start.high;
                velocities[k] = velocity.nodes();
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
