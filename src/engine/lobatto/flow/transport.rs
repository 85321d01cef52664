//! What errors of a world-line grow to: its linearised equations, along which small errors travel.
//!
//! A window knows from its highest modes what it adds to the error, but not with which sign. These sizes are added to a
//! *probe*, errors of the fields that travel along with the world-line: each window changes every component of the
//! probe by what it may be off by, with the signs that change K most.
//!
//! The linearised equations are solved like the equations themselves, by sweeps of the weak scheme over 16 nodes. They
//! have to be solved well: equations of motion have directions in which errors grow only in proportion to time, and
//! those become exponential with the square root of what is wrong in the equations.

use super::rule;
use super::state::FlowState;
use super::tables::LANES;
use super::unknowns::{Places, SweepSteps, Unknowns};
use super::window::{FlowWindow, MOST_SWEEPS, Weights};
use super::work::{Evaluate, Mend, Sample};
use crate::engine::lobatto::Twofold;
use crate::formula::Register;
use crate::geometry::{Geometry, LinearisedEquations};
use crate::number::vector::{Level, Nodes};

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
    last: usize,
    /// The linearised equations: their entries in the variables q^a and p_a, and the slopes of small errors. The first
    /// registers of these are the errors, then come the entries.
    linearised: &'g LinearisedEquations<f64>,
    jacobian_registers: Vec<Nodes<LANES>>,
    /// The registers of q^a and p_a of active coordinates.
    variables: Vec<Register>,
    entries_from: Vec<Register>,
    errors: Unknowns<'g, LANES>,
    /// By how much errors of the fields count.
    weights: Vec<f64>,
    probe: Vec<f64>,
    /// Windows so far.
    windows: f64,
}

impl<'g> Transport<'g> {
    pub(super) fn new(geometry: &'g Geometry) -> Self {
        let linearised = geometry.hamiltonian().linearised();
        let LinearisedEquations { jacobian: entries, slopes, .. } = linearised;
        let (n, m) = (geometry.dimension(), geometry.active().len());
        let outputs = |from: usize, count: usize| (from..from + count).map(|output| slopes.output(output)).collect();
        let velocities = if geometry.is_separable() { n } else { 0 };
        let forces = if geometry.is_separable() { 0 } else { m };
        let places = Places {
            q: (0..m).collect(),
            p: (m..2 * m).collect(),
            velocities: outputs(velocities, m),
            forces: outputs(forces, m),
            ignorable: outputs(forces + m, n - m),
        };
        let rule = rule::coarse();
        Self {
            geometry,
            m,
            last: rule.rule.points() - 1,
            linearised,
            jacobian_registers: entries.registers(|constant| Nodes([constant; LANES])),
            variables: geometry.active().iter().copied().chain(geometry.active().iter().map(|a| 2 * n + a)).collect(),
            entries_from: (0..entries.outputs()).map(|output| entries.output(output)).collect(),
            errors: Unknowns::new(rule, geometry.separable(), slopes, places),
            weights: Vec::with_capacity(2 * m),
            probe: vec![0.0; n + m],
            windows: 0.0,
        }
    }

    /// Forgets all errors: a new march begins from `start`, with these momenta of ignorable coordinates.
    pub(super) fn begin(&mut self, momenta: &[f64], start: &FlowState) {
        self.probe.fill(0.0);
        self.windows = 0.0;
        let n = momenta.len();
        for (a, &p) in momenta.iter().enumerate() {
            self.jacobian_registers[2 * n + a].0 = [p; LANES];
        }
        for (row, &register) in self.variables.iter().enumerate() {
            let value = if row < self.m { start.q[register].hi } else { start.p[row - self.m].hi };
            self.jacobian_registers[register].0 = [value; LANES];
        }
        let (steps, registers) = (&self.linearised.fixed, &mut self.jacobian_registers);
        Level::Best.dispatch(Evaluate { steps, mend: None, registers, factor: 1.0, from: &[], to: &mut [] });
        self.evaluate();
    }

    /// The entries at the points in the registers.
    fn evaluate(&mut self) {
        let (first, outputs) = (2 * self.m, self.entries_from.len());
        Level::Best.dispatch(Evaluate {
            steps: &self.linearised.varying,
            mend: Some(Mend { program: &self.linearised.jacobian, outputs, points: LANES }),
            registers: &mut self.jacobian_registers,
            factor: 1.0,
            from: &self.entries_from,
            to: &mut self.errors.registers[first..first + outputs],
        });
    }

    /// The entries at one of the nodes of what was evaluated last, of active coordinates: row, column, value.
    fn at(&self, node: usize, see: impl FnMut(usize, usize, f64)) {
        let value = |output: usize| self.errors.registers[2 * self.m + output].0[node];
        self.linearised.each_entry(value, see);
    }

    /// The entries at the end of what was evaluated last.
    pub(super) fn at_end(&self, see: impl FnMut(usize, usize, f64)) {
        self.at(self.last, see);
    }

    /// The entries at a node near the middle, and what part of the window comes before it.
    pub(super) fn at_middle(&self, see: impl FnMut(usize, usize, f64)) -> f64 {
        let node = self.last / 2;
        self.at(node, see);
        rule::coarse().rule.nodes()[node].hi
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
        self.carry(window.length, interest);
    }

    /// Carries the probe over a window of length `h`, until sweeps change it by that share at most.
    fn carry(&mut self, h: f64, interest: f64) {
        let Self { m, last, linearised: LinearisedEquations { slopes, .. }, ref weights, .. } = *self;
        let (errors, probe) = (&mut self.errors, &mut self.probe);
        errors.prepare(|row| Twofold::from(probe[row]), h);
        errors.tangent();
        let is_separable = self.geometry.is_separable();
        let all = slopes.steps_to(if is_separable { m } else { 2 * m });
        for sweep in 0..MOST_SWEEPS {
            errors.sweep(SweepSteps { all, velocities: slopes.steps_to(m), outputs: 0 }, h);
            let (mut change, mut size) = (0.0_f64, 0.0_f64);
            for (row, weight) in weights.iter().enumerate() {
                change = change.max(weight * errors.change[row]);
                size = size.max(weight * errors.starts[row].abs().max(errors.row(row).0[last].abs()));
            }
            if sweep > 0 && change <= interest * size {
                break;
            }
        }
        errors.integrate_forces();
        let outputs = if is_separable { probe.len() - m } else { probe.len() };
        errors.evaluate_ignorable(slopes.steps_to(outputs), outputs, h);
        let (fields, ignorable) = probe.split_at_mut(2 * m);
        fields.iter_mut().enumerate().for_each(|(row, error)| *error = errors.row(row).0[last]);
        let weights = &rule::coarse().unit.tables.weights;
        ignorable.iter_mut().zip(errors.ignorable()).for_each(|(error, rates)| *error += rates.dot(weights));
    }

    /// Enlarges the probe by what a window may add: in the direction in which K changes most, away from its present
    /// change. Errors of K grow into errors of the phase; added with other signs they could cancel by accident.
    pub(super) fn enlarge(&mut self, local: impl Fn(usize) -> Local) {
        let half_norm: f64 = self.probe.iter().enumerate().map(|(row, error)| local(row).half_norm * error).sum();
        // Rounding errors have random signs: after j windows they have added up to √j of them.
        let share = (self.windows + 1.0).sqrt() - self.windows.sqrt();
        self.windows += 1.0;
        for (row, error) in self.probe.iter_mut().enumerate() {
            let Local { size, rounding, half_norm: slope } = local(row);
            let towards = if slope == 0.0 { *error } else { slope * 1.0_f64.copysign(half_norm) };
            *error += (size + share * rounding).copysign(towards);
        }
    }

    /// The error of a row.
    pub(super) fn of(&self, row: usize) -> f64 {
        self.probe[row]
    }
}

#[cfg(test)]
mod tests;
