//! One window of a scene: sweeps over its nodes, and the companion from which its error is seen.
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
    /// By how much an error of a position counts more after the window.
    pub(super) lasting: f64,
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
    pub(super) sweep_from: Vec<Register>,
    pub(super) determinants: Vec<Register>,
    pub(super) rows: Rows<P>,
    pub(super) companion_rows: Rows<P>,
    pub(super) scratch: Vec<Nodes<P>>,
    /// What is added to the starts, a row for each active coordinate, then one for each of their momenta.
    pub(super) low: Vec<Nodes<P>>,
    pub(super) starts: Vec<f64>,
    pub(super) change: Vec<f64>,
    /// Q and P of the window on its nodes; the registers hold those of the companion afterwards.
    pub(super) fields: Vec<Nodes<P>>,
    pub(super) end: FlowState,
    /// The companion's fields at the end, before a sweep.
    pub(super) ends: Vec<f64>,
    /// Of every row of the rates.
    pub(super) tails: Vec<Tail>,
    /// Of the window that was solved last.
    pub(super) length: f64,
    /// K at its end.
    pub(super) norm: f64,
    /// Changes that are rounding.
    pub(super) noise: f64,
    /// Random signs.
    pub(super) signs: u64,
    /// Sweeps so far, over all windows and companions.
    pub(super) sweeps: usize,
    pub(super) previous: Option<Known<P>>,
    pub(super) rejected: Option<Known<P>>,
}

impl<'g, const P: usize> FlowWindow<'g, P> {
    pub(super) fn new(geometry: &'g Geometry, rule: Rule<P>) -> Self {
        let programs = geometry.field().rows();
        let (n, m) = (geometry.dimension(), geometry.active().len());
        let mut registers = vec![Nodes::ZERO; programs.rates().registers()];
        programs.rates().each_constant(|register, constant| registers[register].0 = [constant; P]);
        let sweep_from = [programs.force_registers(), programs.ignorable_registers()].concat();
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
            sweep_from,
            determinants: programs.determinant_registers(),
            rows: Rows::new(m, n),
            companion_rows: Rows::new(m, n),
            scratch: vec![Nodes::ZERO; 2 * m],
            low: vec![Nodes::ZERO; 2 * m],
            starts: vec![0.0; 2 * m],
            change: vec![0.0; 2 * m],
            fields: vec![Nodes::ZERO; 2 * m],
            end: FlowState::default(),
            ends: vec![0.0; 2 * m],
            tails: vec![Tail::default(); m + n],
            length: 0.0,
            norm: 0.0,
            noise: 0.0,
            signs: 1,
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
    }

    /// Solves the window of length `h` from `start`, and leaves its end, its fields and its rates. After the first sweeps
    /// `is_hopeless` may look at the tails of the rates; it is told by how much the last sweep changed the fields.
    pub(super) fn solve(&mut self, task: Task<'_>, is_hopeless: &dyn Fn(&Self, f64) -> bool) -> Outcome {
        let Task { start, h, .. } = task;
        self.length = h;
        let first = self.sweeps;
        let is_guessed = self.guess(start, h);
        let mut outcome = self.iterate(task, is_hopeless);
        if outcome == Outcome::Failed && is_guessed {
            // A guess can be far off, even outside the domain: try once more from the tangent.
            self.tangent(start, h);
            outcome = self.iterate(task, is_hopeless);
        }
        let Outcome::Solved(_) = outcome else { return outcome };
        let is_inside = self.determinants.iter().zip(self.geometry.field().signs()).all(|(&register, &sign)| {
            let nodes = &self.registers[register].0[..self.points()];
            nodes.iter().all(|&value| value.is_finite() && (value * sign > 0.0 || sign == 0.0))
        });
        if self.geometry.is_separable() {
            self.integrate_rows(&self.rule.tables.own.a[..], 1, false);
        }
        self.evaluate_last(h);
        for (field, &register) in self.fields.iter_mut().zip(self.q_at.iter().chain(&self.p_at)) {
            field.0 = self.registers[register].0;
        }
        self.finish(start, h);
        match is_inside && self.end.is_finite() {
            true => Outcome::Solved(self.sweeps - first),
            false => Outcome::Failed,
        }
    }

    /// What was solved last is too long; its rates are a good guess for a part of it.
    pub(super) fn reject(&mut self, h: f64) {
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
    fn weighted_change(&self, weights: &Weights) -> f64 {
        let q = self.q_at.iter().zip(&self.change).map(|(&a, change)| weights.q[a] * change);
        let momenta = if self.geometry.is_separable() { 0 } else { self.m };
        let p = weights.p[..momenta].iter().zip(&self.change[self.m..]).map(|(weight, change)| weight * change);
        // NaN must not be lost.
        q.chain(p).fold(0.0, |most, change| if change <= most { most } else { change })
    }

    /// Sweeps from the guess in the registers until the error of the fields is below the tolerance, or at rounding.
    fn iterate(&mut self, task: Task<'_>, is_hopeless: &dyn Fn(&Self, f64) -> bool) -> Outcome {
        let Task { start, h, weights, .. } = task;
        // Errors of momenta have their weight; where only positions are iterated, theirs become errors of momenta.
        let tolerance = match self.geometry.is_separable() {
            true => task.tolerance / task.lasting,
            false => task.tolerance,
        };
        self.prepare(start, h, None);
        let q = self.q_at.iter().map(|&a| weights.q[a] * start.q[a].hi.abs());
        let p = weights.p.iter().zip(&start.p).map(|(weight, p)| weight * p.hi.abs());
        let noise = 4.0 * f64::EPSILON * q.chain(p).fold(0.0, f64::max);
        self.noise = noise;
        let matrices = &self.rule.tables.own;
        let (mut last, mut slower) = (f64::INFINITY, f64::INFINITY);
        for sweeps in 1..=MOST_SWEEPS {
            self.sweep(h, matrices, false);
            let change = self.weighted_change(weights);
            if !change.is_finite() {
                return Outcome::Failed;
            }
            // The error is change · rate, with the slower of the last two rates: the first is often that of a part of the
            // guess. At the level of rounding the rate cannot be seen, so one more sweep is made.
            let rate = change / last;
            let is_small = change <= tolerance || change * rate.max(slower) <= tolerance;
            if sweeps > 1 && is_small || last <= noise {
                return Outcome::Solved(sweeps);
            }
            if sweeps >= EARLY && change > noise {
                let needed = (tolerance.max(noise) / change).ln() / rate.ln();
                if rate > STALLED || sweeps as f64 + needed > MOST_SWEEPS as f64 {
                    return Outcome::Failed;
                }
            }
            if sweeps > 1 && sweeps < EARLY {
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
