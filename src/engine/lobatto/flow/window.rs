//! One window of a scene: sweeps over its nodes.
//!
//! Only active coordinates are unknowns; ignorable ones are quadratures.

use super::rule::Rule;
use super::state::FlowState;
use super::unknowns::{Places, Schedules, Unknowns};
use super::work::{Look, Tail};
use crate::formula::Register;
use crate::geometry::Geometry;
use crate::number::vector::{Level, Nodes};

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

/// By how much an error of the fields counts: q^a relative to its size, p_a by what it does to the q^b.
#[derive(Debug, Clone, Default)]
pub(super) struct Weights {
    pub(super) q: Vec<f64>,
    pub(super) p: Vec<f64>,
}

/// The rates of a window that was solved.
pub(super) struct Known<const P: usize> {
    pub(super) length: f64,
    pub(super) rates: Vec<Nodes<P>>,
}

/// A window with its arrays.
pub(super) struct FlowWindow<'g, const P: usize> {
    pub(super) geometry: &'g Geometry,
    schedules: Schedules,
    pub(super) rule: Rule<P>,
    pub(super) m: usize,
    pub(super) ignorable: Vec<usize>,
    /// With the program of the rates.
    pub(super) unknowns: Unknowns<'g, P>,
    pub(super) determinants: Vec<Register>,
    pub(super) scratch: Vec<Nodes<P>>,
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
        let equations = geometry.hamiltonian();
        let (n, m) = (geometry.dimension(), geometry.active().len());
        let places = Places {
            q: geometry.active().to_vec(),
            p: geometry.active().iter().map(|a| 2 * n + a).collect(),
            velocities: equations.active_velocities(),
            forces: equations.forces.clone(),
            ignorable: equations.ignorable_velocities(),
        };
        Self {
            geometry,
            schedules: Schedules::new(geometry),
            rule,
            m,
            ignorable: geometry.ignorable().collect(),
            unknowns: Unknowns::new(rule, geometry.separable(), &equations.program, places),
            determinants: equations.determinants.clone(),
            scratch: vec![Nodes::ZERO; 2 * m],
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
            self.unknowns.registers[2 * n + a].0 = [p; P];
        }
        self.unknowns.evaluate(&self.schedules.fixed);
    }

    /// Solves the window of length `h` from `start`, and leaves its end, its fields and its rates. After the first
    /// sweeps
    /// `is_hopeless` may look at the tails of the rates; it is told by how much the last sweep changed the fields.
    pub(super) fn solve(&mut self, task: Task<'_>, is_hopeless: &dyn Fn(&Self, f64) -> bool) -> Outcome {
        let sweeps = self.sweeps;
        let outcome = self.solve_as_it_is(task, is_hopeless);
        let is_finite = |rows: &[Nodes<P>]| rows.iter().flat_map(|row| row.0).all(f64::is_finite);
        let is_broken = match outcome {
            Outcome::Failed => !is_finite(self.unknowns.rates()),
            Outcome::Solved(_) | Outcome::TooLong => !self.norm.is_finite(),
        };
        if self.unknowns.mends || !is_broken {
            return outcome;
        }
        // Something may overflow on the way to finite rates: then it is mended from now on.
        let known = std::mem::replace(&mut self.sweeps, sweeps);
        (self.unknowns.mends, self.unknowns.is_mended) = (true, false);
        let mended = self.solve_as_it_is(task, is_hopeless);
        self.unknowns.mends = self.unknowns.is_mended;
        if self.unknowns.mends {
            return mended;
        }
        self.sweeps = known;
        outcome
    }

    fn solve_as_it_is(&mut self, task: Task<'_>, is_hopeless: &dyn Fn(&Self, f64) -> bool) -> Outcome {
        let Task { start, h, .. } = task;
        self.length = h;
        let first = self.sweeps;
        let m = self.m;
        let start_of = |row: usize| if row < m { start.q[self.geometry.active()[row]] } else { start.p[row - m] };
        self.unknowns.prepare(start_of, h);
        let is_guessed = self.guess(h);
        let mut outcome = self.iterate(task, is_hopeless);
        let is_solved = matches!(outcome, Outcome::Solved(_));
        if is_guessed && !is_solved && (outcome == Outcome::Failed || self.rejected.is_some()) {
            // A guess can be far off, even outside the domain: try once more from the tangent. If it was the part of a
            // window that was too long, it is of no use any more.
            self.rejected = None;
            self.unknowns.tangent();
            outcome = self.iterate(task, is_hopeless);
        }
        let Outcome::Solved(_) = outcome else { return outcome };
        self.unknowns.integrate_forces();
        // K and the velocities of ignorable coordinates at the fields as they are: so charges are exact to rounding on
        // the nodes, whatever the tolerance, unless the metric couples their coordinate to an active one.
        self.unknowns.evaluate_ignorable(&self.schedules.all, self.schedules.outputs, h);
        self.norm = self.unknowns.registers[self.geometry.hamiltonian().norm].0[self.points() - 1];
        let is_inside = self.determinants.iter().zip(self.geometry.signs()).all(|(&register, &sign)| {
            let nodes = &self.unknowns.registers[register].0[..self.points()];
            nodes.iter().all(|&value| value.is_finite() && (value * sign > 0.0 || sign == 0.0))
        });
        for (row, field) in self.fields.iter_mut().enumerate() {
            field.0 = self.unknowns.row(row).0;
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
        self.rejected = Some(Known { length: h, rates: self.unknowns.rates()[..2 * self.m].to_vec() });
    }

    /// What was solved last is accepted.
    pub(super) fn accept(&mut self, h: f64) {
        let rates = &self.unknowns.rates()[..2 * self.m];
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
        let changes = self.row_weights.iter().zip(&self.unknowns.change).map(|(weight, change)| weight * change);
        changes.fold(0.0, |most, change| if change <= most { most } else { change })
    }

    /// Weighted changes of the fields that are rounding: below them no sweep is needed. Coordinates count relative to
    /// their sizes.
    fn noise(&self, Task { start, weights, .. }: Task<'_>) -> f64 {
        let p = weights.p.iter().zip(&start.p).map(|(weight, p)| weight * p.hi.abs());
        4.0 * f64::EPSILON * p.fold(1.0, f64::max)
    }

    /// Changes at which sweeps may get stuck, because the rates that they sum are rounded.
    fn stuck(&self, task: Task<'_>) -> f64 {
        let largest = |row: &Nodes<P>| row.0.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let Weights { q, p } = task.weights;
        let active = self.geometry.active().iter();
        let q = active.zip(self.unknowns.velocities()).map(|(&a, rates)| q[a] * largest(rates));
        let p = p.iter().zip(self.unknowns.forces()).map(|(weight, rates)| weight * largest(rates));
        16.0 * f64::EPSILON * q.chain(p).fold(0.0, f64::max) + 4.0 * self.noise(task)
    }

    /// Sweeps from the guess in the registers until the error of the fields is below the tolerance, or at rounding.
    fn iterate(&mut self, task: Task<'_>, is_hopeless: &dyn Fn(&Self, f64) -> bool) -> Outcome {
        let Task { h, weights, tolerance, .. } = task;
        self.row_weights.clear();
        self.row_weights.extend(self.geometry.active().iter().map(|&a| weights.q[a]));
        // Charges are as exact as the momenta of the last sweep, also where these do little to positions.
        let largest = task.start.p.iter().fold(0.0_f64, |largest, p| largest.max(p.hi.abs()));
        let relative = if largest > 0.0 { 1.0 / largest } else { 0.0 };
        self.row_weights.extend(weights.p.iter().map(|weight| weight.max(relative)));
        let noise = self.noise(task);
        let (mut last, mut slower) = (f64::INFINITY, f64::INFINITY);
        for sweeps in 1..=MOST_SWEEPS {
            self.unknowns.sweep(self.schedules.of_sweep(), h);
            self.sweeps += 1;
            let change = self.weighted_change();
            if !change.is_finite() {
                return Outcome::Failed;
            }
            // The error is change · rate, with the slower of the last two rates: the first is often that of a part of
            // the guess. At the level of rounding the rate cannot be seen, so one more sweep is made.
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
        Level::Best.dispatch(Look { modes, rows: self.unknowns.rates(), out: &mut self.tails });
    }

    /// The ends of all fields.
    fn finish(&mut self, start: &FlowState, h: f64) {
        let m = self.m;
        let tables = &self.rule.unit.tables;
        self.end.clone_from(start);
        for (place, &a) in self.geometry.active().iter().enumerate() {
            let row = &self.unknowns.velocities()[place];
            let dp = self.unknowns.forces()[place].dot(&tables.weights);
            self.end.p[place] = start.p[place].plus_update((dp, 0.0));
            self.end.q[a] = match self.geometry.separable() {
                None => start.q[a].plus_update((row.dot(&tables.weights), 0.0)),
                Some(inverse) => {
                    let row_of_g = &inverse[place * m..][..m];
                    let free: f64 = row_of_g.iter().zip(&start.p).map(|(g, p)| g * h * p.hi).sum();
                    let rest: f64 = row_of_g.iter().zip(&start.p).map(|(g, p)| g * h * p.lo).sum();
                    start.q[a].plus_update((free, rest)).plus_update((row.dot(&tables.position_weights), 0.0))
                }
            };
        }
        for (&a, row) in self.ignorable.iter().zip(self.unknowns.ignorable()) {
            self.end.q[a] = start.q[a].plus_update((row.dot(&tables.weights), 0.0));
        }
        self.look();
    }
}
