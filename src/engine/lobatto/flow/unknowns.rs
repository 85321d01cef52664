//! Positions and momenta of active coordinates on the nodes of a window, and sweeps over them.
//!
//! ```text
//! general      P = p + h A ṗ(Q, P),  then  Q = q + h A q̇(Q, P)
//! separable    Q = q + h c q̇ + h² A² g^ab ṗ_b(Q)          where q̇^a = g^ab p_b with constant g^ab
//! ```
//!
//! The equations are those of the motion, or the linearised ones of a small error.

use super::rule::Rule;
use super::tables::FlowTables;
use super::work::{Evaluate, Integrate, Mend, Pass, Sweep};
use crate::engine::lobatto::Twofold;
use crate::formula::{Program, Register, Step};
use crate::geometry::Geometry;
use crate::number::vector::{Level, Nodes};

/// Where a program has its variables and its outputs.
pub(super) struct Places {
    /// q^a and p_a of the active coordinates.
    pub(super) q: Vec<Register>,
    pub(super) p: Vec<Register>,
    /// q̇^a and ṗ_a of the active coordinates, q̇^a of the ignorable ones.
    pub(super) velocities: Vec<Register>,
    pub(super) forces: Vec<Register>,
    pub(super) ignorable: Vec<Register>,
}

/// The steps that compute what a sweep needs.
#[derive(Clone, Copy)]
pub(super) struct SweepSteps<'s> {
    /// Forces, and velocities where the kinetic part varies.
    pub(super) all: &'s [Step],
    /// Velocities alone, after momenta have changed.
    pub(super) velocities: &'s [Step],
    /// So many outputs give both.
    pub(super) outputs: usize,
}

/// The steps of a scene's equations, which work on one register file.
pub(super) struct Schedules {
    /// The steps that depend on nothing but momenta of ignorable coordinates. The others need them.
    pub(super) fixed: Box<[Step]>,
    /// The steps of a sweep, and those to velocities after nothing but momenta has changed.
    sweep: Box<[Step]>,
    velocities: Box<[Step]>,
    /// The steps to all outputs but accelerations.
    pub(super) all: Box<[Step]>,
    /// The number of outputs of a sweep, and of all outputs but accelerations.
    sweep_outputs: usize,
    pub(super) outputs: usize,
}

impl Schedules {
    pub(super) fn new(geometry: &Geometry) -> Self {
        let (n, active, program) = (geometry.dimension(), geometry.active(), &geometry.hamiltonian().program);
        let is_momentum = |variable: usize| variable >= 2 * n && active.contains(&(variable - 2 * n));
        let varies = program.depends_on(|variable| variable < 2 * n || is_momentum(variable));
        let moves = program.depends_on(is_momentum);
        let outputs = |count: usize| (0..count).map(|output| program.output(output));
        // Of a separable motion velocities are no unknowns, and accelerations stand last.
        let m = active.len();
        let [unknown, last] = if geometry.is_separable() { [0, m] } else { [m, 0] };
        let (sweep, all) = (unknown + m, program.outputs() - last);
        Self {
            fixed: program.schedule(0..program.size(), |register| varies[register]),
            sweep: program.schedule(outputs(sweep), |register| !varies[register]),
            velocities: program.schedule(outputs(unknown), |register| !moves[register]),
            all: program.schedule(outputs(all), |register| !varies[register]),
            sweep_outputs: sweep,
            outputs: all,
        }
    }

    pub(super) fn of_sweep(&self) -> SweepSteps<'_> {
        SweepSteps { all: &self.sweep, velocities: &self.velocities, outputs: self.sweep_outputs }
    }
}

/// The unknowns of a window with what is known of them.
pub(super) struct Unknowns<'g, const P: usize> {
    rule: Rule<P>,
    /// g^ab of active coordinates by rows, where the kinetic part is constant.
    inverse: Option<&'g [f64]>,
    m: usize,
    program: &'g Program<f64>,
    /// The first flag is true if rates that overflow on the way to finite values are mended, the second if the last
    /// sweeps mended one.
    pub(super) mends: bool,
    pub(super) is_mended: bool,
    /// Of the program of the rates. The nodes of Q and P stand in those of its variables.
    pub(super) registers: Vec<Nodes<P>>,
    pub(super) places: Places,
    /// Rates times the length of the window: of active coordinates, of their momenta, of ignorable coordinates. In the
    /// separable case there is h² q̈ in place of the first.
    rates: Vec<Nodes<P>>,
    /// q^a and p_a at the start, and what is added to them on the nodes.
    pub(super) starts: Vec<f64>,
    low: Vec<Nodes<P>>,
    /// By how much the last sweep changed each unknown.
    pub(super) change: Vec<f64>,
    kicks: Vec<f64>,
}

impl<'g, const P: usize> Unknowns<'g, P> {
    pub(super) fn new(rule: Rule<P>, inverse: Option<&'g [f64]>, program: &'g Program<f64>, places: Places) -> Self {
        let (m, ignorable) = (places.q.len(), places.ignorable.len());
        Self {
            rule,
            inverse,
            m,
            program,
            mends: false,
            is_mended: false,
            registers: program.registers(|constant| Nodes([constant; P])),
            places,
            rates: vec![Nodes::ZERO; 2 * m + ignorable],
            starts: vec![0.0; 2 * m],
            low: vec![Nodes::ZERO; 2 * m],
            change: vec![0.0; 2 * m],
            kicks: vec![0.0; m],
        }
    }

    pub(super) fn rates(&self) -> &[Nodes<P>] {
        &self.rates
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

    /// The nodes of row `row`: positions, then momenta.
    pub(super) fn row(&self, row: usize) -> &Nodes<P> {
        &self.registers[if row < self.m { self.places.q[row] } else { self.places.p[row - self.m] }]
    }

    /// Sets what does not change in the sweeps over a window of length `h`: the start, row by row, and the line of the
    /// free motion.
    pub(super) fn prepare(&mut self, start: impl Fn(usize) -> Twofold, h: f64) {
        let m = self.m;
        for (row, (to, low)) in self.starts.iter_mut().zip(&mut self.low).enumerate() {
            let start = start(row);
            *to = start.hi;
            low.0 = [start.lo; P];
        }
        // What sweeps add to momenta is compared with what they added before.
        self.kicks.fill(0.0);
        let Some(inverse) = self.inverse else { return };
        for row in 0..m {
            let inverse = &inverse[row * m..][..m];
            let velocity: f64 = inverse.iter().zip(&self.starts[m..]).map(|(g, p)| g * p).sum();
            let c = &self.rule.tables.nodes.0;
            self.low[row].0.iter_mut().zip(c).for_each(|(low, c)| *low += h * velocity * c);
        }
    }

    /// Puts the start into the registers, and with constant kinetic part the line of the free motion.
    pub(super) fn tangent(&mut self) {
        for (row, &register) in self.places.q.iter().chain(&self.places.p).enumerate() {
            let start = self.starts[row];
            let to = &mut self.registers[register].0;
            to.iter_mut().zip(&self.low[row].0).for_each(|(to, low)| *to = start + low);
        }
    }

    /// One sweep over a window of length `h`.
    pub(super) fn sweep(&mut self, steps: SweepSteps<'_>, h: f64) {
        let FlowTables { a, a_squared, .. } = self.rule.tables;
        let columns = self.rule.unit.tables.columns;
        let (a, a_squared) = (&a[..columns], &a_squared[..columns]);
        let Places { q, p, velocities, forces, .. } = &self.places;
        let momenta = Pass { steps: steps.all, from: forces, is_position: false, inverse: None, matrix: a, to: p };
        let passes = if self.inverse.is_some() {
            &[Pass { is_position: true, inverse: self.inverse, matrix: a_squared, to: q, ..momenta }][..]
        } else {
            &[momenta, Pass { steps: steps.velocities, from: velocities, is_position: true, to: q, ..momenta }]
        };
        Level::Best.dispatch(Sweep {
            registers: &mut self.registers,
            h,
            rates: &mut self.rates[..2 * self.m],
            start: &self.starts,
            low: &self.low,
            change: &mut self.change,
            kicks: &mut self.kicks,
            weights: &self.rule.unit.tables.weights,
            passes,
            mend: self.mends.then_some(Mend { program: self.program, outputs: steps.outputs, points: P }),
            is_mended: &mut self.is_mended,
        });
    }

    /// Momenta of a separable geometry, once the forces are known.
    pub(super) fn integrate_forces(&mut self) {
        if self.inverse.is_some() {
            let rates = std::mem::take(&mut self.rates);
            self.integrate(&rates[self.m..2 * self.m], false);
            self.rates = rates;
        }
    }

    /// Puts the integrals of other rates into the registers: h² q̈ in the separable case, otherwise h q̇ and h ṗ.
    pub(super) fn start_from(&mut self, rates: &[Nodes<P>]) {
        if self.inverse.is_none() {
            self.integrate(&rates[self.m..], false);
        }
        self.integrate(&rates[..self.m], true);
    }

    /// Integrates rates of positions or of momenta.
    fn integrate(&mut self, rates: &[Nodes<P>], is_position: bool) {
        let (range, to) = if is_position { (0..self.m, &self.places.q) } else { (self.m..2 * self.m, &self.places.p) };
        let FlowTables { a, a_squared, .. } = self.rule.tables;
        let matrix = if is_position && self.inverse.is_some() { a_squared } else { a };
        Level::Best.dispatch(Integrate {
            matrix: &matrix[..self.rule.unit.tables.columns],
            rates,
            start: &self.starts[range.clone()],
            low: &self.low[range.clone()],
            registers: &mut self.registers,
            to,
            change: &mut self.change[range],
        });
    }

    /// Carries out these steps to the first `outputs` outputs, after which the velocities of ignorable coordinates are
    /// known.
    pub(super) fn evaluate_ignorable(&mut self, steps: &[Step], outputs: usize, h: f64) {
        Level::Best.dispatch(Evaluate {
            steps,
            mend: self.mends.then_some(Mend { program: self.program, outputs, points: P }),
            registers: &mut self.registers,
            factor: h,
            from: &self.places.ignorable,
            to: &mut self.rates[2 * self.m..],
        });
    }

    /// Carries out steps.
    pub(super) fn evaluate(&mut self, steps: &[Step]) {
        let registers = &mut self.registers;
        Level::Best.dispatch(Evaluate { steps, mend: None, registers, factor: 1.0, from: &[], to: &mut [] });
    }
}
