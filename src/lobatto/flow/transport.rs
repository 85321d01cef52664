//! What errors of a world-line grow to: its linearised equations, along which small errors travel.
//!
//! A window knows from its highest modes what it adds to the error, but not with which sign. These sizes are added to a
//! *probe*, errors of the fields that travel along with the world-line: each window changes every component of the probe
//! by what it may be off by, with the signs that change K most.
//!
//! The linearised equations are solved like the equations themselves, by sweeps of the weak scheme over 16 nodes. They
//! have to be solved well: equations of motion have directions in which errors grow only in proportion to time, and those
//! become exponential with the square root of what is wrong in the equations.

use super::rule;
use super::state::FlowState;
use super::window::{FlowWindow, MOST_SWEEPS, Rule, Weights};
use super::work::{Evaluate, Integrate, Pass, Sample, Sweep};
use crate::expr::{Program, Register, Staged};
use crate::geometry::Geometry;
use crate::lobatto::simd::Level;
use crate::lobatto::tables::Nodes;

/// Nodes of a window on which small errors are followed.
pub(super) const LANES: usize = 16;

/// What the sweeps over a probe may leave of it in a run of N windows, times N²; and the limits of that.
const INTEREST: f64 = 1.0;
const LEAST: f64 = 1e-11;
const MOST: f64 = 1e-3;

/// The error that a window may add to a field.
#[derive(Debug, Clone, Copy)]
pub(super) struct Local {
    /// Of truncation and of the sweeps, whatever its sign.
    pub(super) size: f64,
    /// ½ ∂K of the field: q̇^a for p_a, −ṗ_a for q^a.
    pub(super) half_norm: f64,
    /// Of rounding, with random signs.
    pub(super) rounding: f64,
}

/// The probe of a run. Rows are q^a of active coordinates, their p_a, then q^a of ignorable coordinates.
pub(super) struct Transport<'g> {
    geometry: &'g Geometry,
    m: usize,
    rule: Rule<LANES>,
    /// The entries of the linearised equations, in the variables q^a and p_a.
    jacobian: &'g Staged<f64>,
    jacobian_registers: Vec<Nodes<LANES>>,
    /// The registers of q^a and p_a of active coordinates.
    variables: Vec<Register>,
    entries_from: Vec<Register>,
    /// The slopes of small errors. Its first registers are the errors, then come the entries.
    linear: &'g Program<f64>,
    registers: Vec<Nodes<LANES>>,
    /// The registers of the errors.
    errors: Vec<Register>,
    velocities_from: Vec<Register>,
    forces_from: Vec<Register>,
    ignorable_from: Vec<Register>,
    rates: Vec<Nodes<LANES>>,
    low: Vec<Nodes<LANES>>,
    starts: Vec<f64>,
    change: Vec<f64>,
    kicks: Vec<f64>,
    /// By how much errors of the fields count.
    weights: Vec<f64>,
    probe: Vec<f64>,
    /// Random signs.
    signs: u64,
}

impl<'g> Transport<'g> {
    pub(super) fn new(geometry: &'g Geometry) -> Self {
        let (jacobian, linear) = geometry.field().linearised();
        let entries = jacobian.program();
        let (n, m) = (geometry.dimension(), geometry.active().len());
        let room = |program: &Program<f64>| {
            let mut registers = vec![Nodes::ZERO; program.registers()];
            program.each_constant(|register, constant| registers[register].0 = [constant; LANES]);
            registers
        };
        let outputs = |from: usize, count: usize| (from..from + count).map(|output| linear.output(output)).collect();
        let velocities = if geometry.is_separable() { n } else { 0 };
        let forces = if geometry.is_separable() { 0 } else { m };
        Self {
            geometry,
            m,
            rule: rule::coarse(),
            jacobian,
            jacobian_registers: room(entries),
            variables: geometry.active().iter().copied().chain(geometry.active().iter().map(|a| 2 * n + a)).collect(),
            entries_from: (0..entries.outputs()).map(|output| entries.output(output)).collect(),
            linear,
            registers: room(linear),
            errors: (0..2 * m).collect(),
            velocities_from: outputs(velocities, m),
            forces_from: outputs(forces, m),
            ignorable_from: outputs(forces + m, n - m),
            rates: vec![Nodes::ZERO; n + m],
            low: vec![Nodes::ZERO; 2 * m],
            starts: vec![0.0; 2 * m],
            change: vec![0.0; 2 * m],
            kicks: vec![0.0; m],
            weights: Vec::with_capacity(2 * m),
            probe: vec![0.0; n + m],
            signs: 1,
        }
    }

    /// Forgets all errors: a new march begins from `start`, with these momenta of ignorable coordinates.
    pub(super) fn begin(&mut self, momenta: &[f64], start: &FlowState) {
        self.probe.fill(0.0);
        let n = momenta.len();
        for (a, &p) in momenta.iter().enumerate() {
            self.jacobian_registers[2 * n + a].0 = [p; LANES];
        }
        for (row, &register) in self.variables.iter().enumerate() {
            let value = if row < self.m { start.q[register].hi } else { start.p[row - self.m].hi };
            self.jacobian_registers[register].0 = [value; LANES];
        }
        let registers = &mut self.jacobian_registers;
        Level::Best.dispatch(Evaluate { steps: self.jacobian.fixed(), registers, factor: 1.0, from: &[], to: &mut [] });
        self.evaluate();
    }

    /// The entries at the points in the registers.
    fn evaluate(&mut self) {
        let (first, outputs) = (2 * self.m, self.entries_from.len());
        Level::Best.dispatch(Evaluate {
            steps: self.jacobian.varying(outputs),
            registers: &mut self.jacobian_registers,
            factor: 1.0,
            from: &self.entries_from,
            to: &mut self.registers[first..first + outputs],
        });
    }

    /// The entries at the end of what was evaluated last, of active coordinates: row, column, value.
    pub(super) fn at_end(&self, see: impl FnMut(usize, usize, f64)) {
        let last = self.rule.rule.points() - 1;
        let value = |output: usize| self.registers[2 * self.m + output].0[last];
        self.geometry.field().each_entry(value, see);
    }

    /// Carries the probe over a window that was solved, one of about `windows`. Errors are compared with `weights`.
    pub(super) fn follow<const P: usize>(&mut self, window: &FlowWindow<'_, P>, weights: &Weights, windows: f64) {
        Level::Best.dispatch(Sample {
            matrix: &window.rule.tables.sampled,
            points: window.points(),
            rows: &window.fields,
            registers: &mut self.jacobian_registers,
            to: &self.variables,
        });
        self.evaluate();
        self.weights.clear();
        self.weights.extend(self.geometry.active().iter().map(|&a| weights.q[a]).chain(weights.p.iter().copied()));
        let interest = (INTEREST / (windows * windows)).clamp(LEAST, MOST);
        let mut probe = std::mem::take(&mut self.probe);
        self.carry(&mut probe, window.length, interest);
        self.probe = probe;
    }

    /// Carries a probe over a window of length `h`, until sweeps change it by that share at most.
    fn carry(&mut self, probe: &mut [f64], h: f64, interest: f64) {
        let m = self.m;
        self.starts.copy_from_slice(&probe[..2 * m]);
        let separable = self.geometry.separable();
        for row in 0..2 * m {
            if let (Some(inverse), true) = (separable, row < m) {
                let velocity: f64 = inverse[row * m..][..m].iter().zip(&probe[m..2 * m]).map(|(g, p)| g * p).sum();
                let c = &self.rule.tables.nodes.0;
                self.low[row].0.iter_mut().zip(c).for_each(|(low, c)| *low = h * velocity * c);
            }
            let (start, low) = (self.starts[row], &self.low[row]);
            self.registers[row].0.iter_mut().zip(&low.0).for_each(|(to, low)| *to = start + low);
        }
        let (q, p) = self.errors.split_at(m);
        let (a, a_squared) = (&self.rule.tables.a[..], &self.rule.tables.a_squared[..]);
        let (velocities, forces) = (&self.velocities_from[..], &self.forces_from[..]);
        let steps = self.linear.steps_to(if separable.is_some() { m } else { 2 * m });
        let force = Pass { steps, from: forces, is_position: false, inverse: None, matrix: a, to: p };
        let separable_pass = [Pass { is_position: true, inverse: separable, matrix: a_squared, to: q, ..force }];
        let general =
            [force, Pass { steps: self.linear.steps_to(m), from: velocities, is_position: true, to: q, ..force }];
        let passes = if separable.is_some() { &separable_pass[..] } else { &general[..] };
        for sweep in 0..MOST_SWEEPS {
            Level::Best.dispatch(Sweep {
                registers: &mut self.registers,
                h,
                rates: &mut self.rates[..2 * m],
                start: &self.starts,
                low: &self.low,
                change: &mut self.change,
                kicks: &mut self.kicks,
                weights: &self.rule.unit.tables.weights,
                passes,
            });
            let last = self.rule.rule.points() - 1;
            let (mut change, mut size) = (0.0_f64, 0.0_f64);
            for row in 0..2 * m {
                change = change.max(self.weights[row] * self.change[row]);
                size = size.max(self.weights[row] * self.starts[row].abs().max(self.registers[row].0[last].abs()));
            }
            if sweep > 0 && change <= interest * size {
                break;
            }
        }
        if separable.is_some() {
            Level::Best.dispatch(Integrate {
                matrix: a,
                rates: &self.rates[m..2 * m],
                start: &self.starts[m..],
                low: &self.low[m..],
                registers: &mut self.registers,
                to: p,
                change: &mut self.change[m..],
            });
        }
        let outputs = if separable.is_some() { probe.len() - m } else { probe.len() };
        Level::Best.dispatch(Evaluate {
            steps: self.linear.steps_to(outputs),
            registers: &mut self.registers,
            factor: h,
            from: &self.ignorable_from,
            to: &mut self.rates[2 * m..],
        });
        let last = self.rule.rule.points() - 1;
        for (row, error) in probe.iter_mut().enumerate() {
            if row < 2 * m {
                *error = self.registers[row].0[last];
            } else {
                let weights = &self.rule.unit.tables.weights;
                *error += weights.iter().zip(&self.rates[row].0).map(|(b, rate)| b * rate).sum::<f64>();
            }
        }
    }

    /// Enlarges the probe by what a window may add: in the direction in which K changes most, away from its present
    /// change. Errors of K grow into errors of the phase; added with other signs they could cancel by accident.
    pub(super) fn enlarge(&mut self, local: impl Fn(usize) -> Local) {
        let half_norm: f64 = self.probe.iter().enumerate().map(|(row, error)| local(row).half_norm * error).sum();
        for (row, error) in self.probe.iter_mut().enumerate() {
            let Local { size, rounding, half_norm: slope } = local(row);
            let towards = if slope == 0.0 { *error } else { slope * 1.0_f64.copysign(half_norm) };
            // A linear congruential generator (Knuth, MMIX).
            self.signs = self.signs.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let sign = if self.signs >> 63 == 0 { 1.0 } else { -1.0 };
            *error += size.copysign(towards) + sign * rounding;
        }
    }

    /// The error of a row.
    pub(super) fn of(&self, row: usize) -> f64 {
        self.probe[row]
    }
}
