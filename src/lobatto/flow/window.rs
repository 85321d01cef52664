//! One window of a scene: sweeps over its nodes.
//!
//! ```text
//! general      P = p + h A ṗ(Q, P),  then  Q = q + h A q̇(Q, P)
//! separable    Q = q + h c q̇ + h² A² g^ab ṗ_b(Q)          where q̇^a = g^ab p_b with constant g^ab
//! ```
//!
//! Only active coordinates are unknowns; ignorable ones are quadratures.

use super::state::FlowState;
use super::tables::FlowTables;
use super::work::{Look, Tail};
use crate::expr::Register;
use crate::geometry::{Geometry, RowPrograms};
use crate::lobatto::rule::WeakRule;
use crate::lobatto::simd::Level;
use crate::lobatto::tables::Nodes;
use crate::lobatto::unit::Unit;

/// The most sweeps over a window: with more, two shorter ones are cheaper.
pub(super) const MOST_SWEEPS: usize = 24;

/// A sweep that leaves this much of the change before does not converge.
const STALLED: f64 = 0.9;

/// Faster sweeps are always enough.
const SLOW: f64 = 0.2;

/// After this many sweeps their rate shows.
const EARLY: usize = 5;

/// How a window ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Solved, in so many sweeps.
    Solved(usize),
    /// The rates show early that it is far too long.
    TooLong,
    /// The sweeps do not converge, or leave the domain.
    Failed,
}

/// A window to solve.
#[derive(Clone, Copy)]
pub(super) struct Task<'t> {
    pub(super) start: &'t FlowState,
    /// Its length.
    pub(super) h: f64,
    pub(super) weights: &'t Weights,
    /// The weighted error that the sweeps may leave.
    pub(super) tolerance: f64,
    /// Whether it is longer than the window before, so that it may turn out to be far too long.
    pub(super) is_new: bool,
}

/// What a rule brings to all windows.
#[derive(Clone, Copy)]
pub(super) struct Rule<const P: usize> {
    pub(super) rule: &'static WeakRule,
    pub(super) unit: &'static Unit<P>,
    /// From nodal values to the two highest modes but the last.
    pub(super) tail: &'static [Nodes<P>; 2],
    pub(super) tables: &'static FlowTables<P>,
}

/// By how much an error of the fields counts: q^a relative to its size, p_a by what it does to the q^b.
#[derive(Debug, Clone, Default)]
pub(super) struct Weights {
    pub(super) q: Vec<f64>,
    pub(super) p: Vec<f64>,
}

/// Rates on the nodes, times the length of the window: of active coordinates, of their momenta, of ignorable
/// coordinates. In the separable case there is in place of the first h² q̈.
pub(super) struct Rows<const P: usize> {
    pub(super) rates: Vec<Nodes<P>>,
    m: usize,
}

impl<const P: usize> Rows<P> {
    fn new(m: usize, n: usize) -> Self {
        Self { rates: vec![Nodes::ZERO; m + n], m }
    }

    pub(super) fn velocities(&self) -> &[Nodes<P>] {
        &self.rates[..self.m]
    }

    pub(super) fn forces(&self) -> &[Nodes<P>] {
        &self.rates[self.m..2 * self.m]
    }

    pub(super) fn ignorable(&self) -> &[Nodes<P>] {
        &self.rates[2 * self.m..]
    }
}

/// The rates of a window that was solved.
pub(super) struct Known<const P: usize> {
    pub(super) length: f64,
    pub(super) rates: Vec<Nodes<P>>,
}

/// A window with its arrays.
pub(super) struct FlowWindow<'g, const P: usize> {
    pub(super) geometry: &'g Geometry,
    pub(super) programs: &'g RowPrograms<f64>,
    pub(super) rule: Rule<P>,
    pub(super) m: usize,
    pub(super) ignorable: Vec<usize>,
    /// Of the program of the rates. The nodes of Q and P stand in those of its variables.
    pub(super) registers: Vec<Nodes<P>>,
    pub(super) q_at: Vec<Register>,
    pub(super) p_at: Vec<Register>,
    pub(super) velocities_from: Vec<Register>,
    pub(super) forces_from: Vec<Register>,
    pub(super) ignorable_from: Vec<Register>,
    pub(super) determinants: Vec<Register>,
    pub(super) rows: Rows<P>,
    pub(super) scratch: Vec<Nodes<P>>,
    /// What is added to the starts, a row for each active coordinate, then one for each of their momenta.
    pub(super) low: Vec<Nodes<P>>,
    pub(super) starts: Vec<f64>,
    pub(super) change: Vec<f64>,
    pub(super) kicks: Vec<f64>,
    /// The weighted error that the sweeps have left in the fields of the window that was solved last.
    pub(super) left: f64,
    /// The weights of the unknowns.
    row_weights: Vec<f64>,
    /// Q and P of the window on its nodes.
    pub(super) fields: Vec<Nodes<P>>,
    pub(super) end: FlowState,
    /// Of every row of the rates.
    pub(super) tails: Vec<Tail>,
    /// Of the window that was solved last.
    pub(super) length: f64,
    /// K at its end.
    pub(super) norm: f64,
    /// Sweeps so far, over all windows.
    pub(super) sweeps: usize,
    pub(super) previous: Option<Known<P>>,
    pub(super) rejected: Option<Known<P>>,
}

impl<'g, const P: usize> FlowWindow<'g, P> {
    pub(super) fn new(geometry: &'g Geometry, rule: Rule<P>) -> Self {
        let programs = geometry.field().rows();
        let (n, m) = (geometry.dimension(), geometry.active().len());
        let rates = programs.rates().program();
        let mut registers = vec![Nodes::ZERO; rates.registers()];
        rates.each_constant(|register, constant| registers[register].0 = [constant; P]);
        Self {
            geometry,
            programs,
            rule,
            m,
            ignorable: geometry.ignorable().collect(),
            registers,
            q_at: geometry.active().to_vec(),
            p_at: geometry.active().iter().map(|a| 2 * n + a).collect(),
            velocities_from: programs.velocity_registers(),
            forces_from: programs.force_registers(),
            ignorable_from: programs.ignorable_registers(),
            determinants: programs.determinant_registers(),
            rows: Rows::new(m, n),
            scratch: vec![Nodes::ZERO; 2 * m],
            low: vec![Nodes::ZERO; 2 * m],
            starts: vec![0.0; 2 * m],
            change: vec![0.0; 2 * m],
            kicks: vec![0.0; m],
            left: 0.0,
            row_weights: Vec::with_capacity(2 * m),
            fields: vec![Nodes::ZERO; 2 * m],
            end: FlowState::default(),
            tails: vec![Tail::default(); m + n],
            length: 0.0,
            norm: 0.0,
            sweeps: 0,
            previous: None,
            rejected: None,
        }
    }

    pub(super) fn points(&self) -> usize {
        self.rule.rule.points()
    }

    /// Forgets the windows before: a new march begins, with these momenta of ignorable coordinates.
    pub(super) fn begin(&mut self, momenta: &[f64]) {
        (self.previous, self.rejected) = (None, None);
        let n = momenta.len();
        for (a, &p) in momenta.iter().enumerate() {
            self.registers[2 * n + a].0 = [p; P];
        }
        self.evaluate_fixed();
    }

    /// Solves the window of length `h` from `start`, and leaves its end, its fields and its rates. After the first sweeps
    /// `is_hopeless` may look at the tails of the rates; it is told by how much the last sweep changed the fields.
    pub(super) fn solve(&mut self, task: Task<'_>, is_hopeless: &dyn Fn(&Self, f64) -> bool) -> Outcome {
        let Task { start, h, .. } = task;
        self.length = h;
        let first = self.sweeps;
        self.prepare(start, h);
        let is_guessed = self.guess(h);
        let mut outcome = self.iterate(task, is_hopeless);
        let is_solved = matches!(outcome, Outcome::Solved(_));
        if is_guessed && !is_solved && (outcome == Outcome::Failed || self.rejected.is_some()) {
            // A guess can be far off, even outside the domain: try once more from the tangent. If it was the part of a
            // window that was too long, it is of no use any more.
            self.rejected = None;
            self.tangent();
            outcome = self.iterate(task, is_hopeless);
        }
        let Outcome::Solved(_) = outcome else { return outcome };
        if self.geometry.is_separable() {
            self.integrate_forces();
        }
        self.evaluate_last(h);
        let is_inside = self.determinants.iter().zip(self.geometry.field().signs()).all(|(&register, &sign)| {
            let nodes = &self.registers[register].0[..self.points()];
            nodes.iter().all(|&value| value.is_finite() && (value * sign > 0.0 || sign == 0.0))
        });
        for (field, &register) in self.fields.iter_mut().zip(self.q_at.iter().chain(&self.p_at)) {
            field.0 = self.registers[register].0;
        }
        self.finish(start, h);
        match is_inside && self.end.is_finite() {
            true => Outcome::Solved(self.sweeps - first),
            false => Outcome::Failed,
        }
    }

    /// What was solved last is too long; its rates are a good guess for a part of it, if they are `sane`.
    pub(super) fn reject(&mut self, h: f64, sane: bool) {
        if !sane {
            self.rejected = None;
            return;
        }
        self.rejected = Some(Known { length: h, rates: self.rows.rates[..2 * self.m].to_vec() });
    }

    /// What was solved last is accepted.
    pub(super) fn accept(&mut self, h: f64) {
        let rates = &self.rows.rates[..2 * self.m];
        match &mut self.previous {
            Some(known) => {
                known.length = h;
                known.rates.clone_from_slice(rates);
            }
            None => self.previous = Some(Known { length: h, rates: rates.to_vec() }),
        }
        self.rejected = None;
    }

    /// The largest change that the last sweep made, weighted.
    fn weighted_change(&self) -> f64 {
        // NaN must not be lost.
        let changes = self.row_weights.iter().zip(&self.change).map(|(weight, change)| weight * change);
        changes.fold(0.0, |most, change| if change <= most { most } else { change })
    }

    /// Weighted changes of the fields that are rounding: below them no sweep is needed. Coordinates count relative to their
    /// sizes.
    fn noise(&self, Task { start, weights, .. }: Task<'_>) -> f64 {
        let p = weights.p.iter().zip(&start.p).map(|(weight, p)| weight * p.hi.abs());
        4.0 * f64::EPSILON * p.fold(1.0, f64::max)
    }

    /// Changes at which sweeps may get stuck, because the rates that they sum are rounded.
    fn stuck(&self, task: Task<'_>) -> f64 {
        let largest = |row: &Nodes<P>| row.0.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let Weights { q, p } = task.weights;
        let q = self.q_at.iter().zip(self.rows.velocities()).map(|(&a, rates)| q[a] * largest(rates));
        let p = p.iter().zip(self.rows.forces()).map(|(weight, rates)| weight * largest(rates));
        16.0 * f64::EPSILON * q.chain(p).fold(0.0, f64::max) + 4.0 * self.noise(task)
    }

    /// Sweeps from the guess in the registers until the error of the fields is below the tolerance, or at rounding.
    fn iterate(&mut self, task: Task<'_>, is_hopeless: &dyn Fn(&Self, f64) -> bool) -> Outcome {
        let Task { h, weights, tolerance, .. } = task;
        self.row_weights.clear();
        self.row_weights.extend(self.q_at.iter().map(|&a| weights.q[a]));
        // Charges are as exact as the momenta of the last sweep, also where these do little to positions.
        let largest = task.start.p.iter().fold(0.0_f64, |largest, p| largest.max(p.hi.abs()));
        let relative = if largest > 0.0 { 1.0 / largest } else { 0.0 };
        self.row_weights.extend(weights.p.iter().map(|weight| weight.max(relative)));
        // What forces add to momenta is compared with what they added in the sweep before.
        self.kicks.fill(0.0);
        let noise = self.noise(task);
        let (mut last, mut slower) = (f64::INFINITY, f64::INFINITY);
        for sweeps in 1..=MOST_SWEEPS {
            self.sweep(h);
            let change = self.weighted_change();
            if !change.is_finite() {
                return Outcome::Failed;
            }
            // The error is change · rate, with the slower of the last two rates: the first is often that of a part of the
            // guess. At the level of rounding the rate cannot be seen, so one more sweep is made.
            let rate = change / last;
            let slowest = if slower.is_finite() { rate.max(slower) } else { rate };
            let left = change * slowest.min(1.0);
            if sweeps > 1 && (change <= tolerance || slower.is_finite() && left <= tolerance) || last <= noise {
                // Rounding is counted by itself.
                self.left = if left <= noise || last <= noise { 0.0 } else { left };
                return Outcome::Solved(sweeps);
            }
            if sweeps >= EARLY && change > noise {
                let is_too_slow = || change * rate.powi((MOST_SWEEPS - sweeps) as i32) > tolerance.max(noise);
                if rate > STALLED || rate > SLOW && is_too_slow() {
                    if rate <= STALLED || change > self.stuck(task) {
                        return Outcome::Failed;
                    }
                    self.left = 0.0;
                    return Outcome::Solved(sweeps);
                }
            }
            if sweeps > 1 && sweeps < EARLY && task.is_new {
                self.look();
                if is_hopeless(self, change) {
                    return Outcome::TooLong;
                }
            }
            slower = if sweeps > 1 { rate } else { f64::INFINITY };
            last = change;
        }
        Outcome::Failed
    }

    /// Looks at the tails of the rates.
    fn look(&mut self) {
        let modes = self.rule.tail;
        Level::Best.dispatch(Look { modes, rows: &self.rows.rates, out: &mut self.tails });
    }

    /// The ends of all fields.
    fn finish(&mut self, start: &FlowState, h: f64) {
        let m = self.m;
        let tables = &self.rule.unit.tables;
        let sum = |weights: &[f64; P], row: &Nodes<P>| -> f64 { weights.iter().zip(&row.0).map(|(b, v)| b * v).sum() };
        self.end.clone_from(start);
        for (place, &a) in self.q_at.iter().enumerate() {
            let row = &self.rows.velocities()[place];
            let dp = sum(&tables.weights, &self.rows.forces()[place]);
            self.end.p[place] = start.p[place].plus_update((dp, 0.0));
            self.end.q[a] = match self.geometry.separable() {
                None => start.q[a].plus_update((sum(&tables.weights, row), 0.0)),
                Some(inverse) => {
                    let row_of_g = &inverse[place * m..][..m];
                    let free: f64 = row_of_g.iter().zip(&start.p).map(|(g, p)| g * h * p.hi).sum();
                    let rest: f64 = row_of_g.iter().zip(&start.p).map(|(g, p)| g * h * p.lo).sum();
                    start.q[a].plus_update((free, rest)).plus_update((sum(&tables.position_weights, row), 0.0))
                }
            };
        }
        for (&a, row) in self.ignorable.iter().zip(self.rows.ignorable()) {
            self.end.q[a] = start.q[a].plus_update((sum(&tables.weights, row), 0.0));
        }
        self.look();
    }
}
