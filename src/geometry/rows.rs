//! Hamilton's equations and the Lagrangian's momenta as programs for all nodes of a window at once.

use super::field::force;
use super::parts::Parts;
use crate::formula::{Level, NodeId, Program, Register, Step};
use crate::number::Real;

/// Programs whose registers hold the nodes of a window. The first outputs are what a sweep over the window needs.
#[derive(Debug, Clone)]
pub(crate) struct RowPrograms<S> {
    /// Variables q^a, then n that are not used, then p_a. Outputs in this order, or with the velocities of active
    /// coordinates last where they are not unknowns: these velocities, the forces on active coordinates, the velocities
    /// of ignorable ones, the determinants. Then comes K, and then accelerations of active coordinates, if these
    /// depend on positions only.
    rates: Program<S>,
    schedules: Schedules,
    velocities: usize,
    forces: usize,
    ignorable: usize,
    determinants: usize,
    accelerations: Option<usize>,
    /// Variables q^a and q̇^a. Outputs p_a of all coordinates, then f_a + F_a of active ones.
    momenta: Program<S>,
    dimension: usize,
    active: Vec<usize>,
    blocks: usize,
}

/// Parts of the program of the rates, which work on one register file.
#[derive(Debug, Clone)]
pub(crate) struct Schedules {
    /// What depends on nothing but the momenta of ignorable coordinates. The others need it.
    pub(crate) fixed: Box<[Step]>,
    /// What a sweep needs.
    pub(crate) sweep: Box<[Step]>,
    /// Velocities of active coordinates after nothing but momenta has changed, where these velocities are unknowns.
    pub(crate) velocities: Box<[Step]>,
    /// All outputs but accelerations.
    pub(crate) all: Box<[Step]>,
}

impl Schedules {
    /// So many outputs are velocities of active coordinates that are unknowns, so many are what a sweep needs, and so
    /// many are all but accelerations.
    fn new<S: Real>(rates: &Program<S>, level: impl Fn(usize) -> Level, [velocities, sweep, all]: [usize; 3]) -> Self {
        let varies = rates.depends_on(|variable| level(variable) > 0);
        let moves = rates.depends_on(|variable| level(variable) == 2);
        let outputs = |count: usize| (0..count).map(|output| rates.output(output));
        Self {
            fixed: rates.schedule(0..rates.size(), |register| varies[register]),
            sweep: rates.schedule(outputs(sweep), |register| !varies[register]),
            velocities: rates.schedule(outputs(velocities), |register| !moves[register]),
            all: rates.schedule(outputs(all), |register| !varies[register]),
        }
    }
}

/// The rates of a scene as expressions.
pub(super) struct RateNodes {
    /// q̇^a of all coordinates.
    pub(super) q_dot: Vec<NodeId>,
    /// ṗ_a of active coordinates.
    pub(super) p_dot: Vec<NodeId>,
    /// The determinants of the blocks.
    pub(super) determinants: Vec<NodeId>,
}

impl RateNodes {
    /// The same rates and K, all with fewer operations. What a sweep needs is written apart: it shares its work with
    /// nothing that is wanted once.
    pub(super) fn reduced<S: Real>(
        mut self,
        parts: &mut Parts<S>,
        active: &[usize],
        is_separable: bool,
    ) -> (Self, NodeId) {
        let mut norm = norm(parts, &self.q_dot);
        let level = level(parts.dimension(), active);
        let (mut sweep, mut others): (Vec<&mut NodeId>, Vec<&mut NodeId>) = (Vec::new(), Vec::new());
        for (a, velocity) in self.q_dot.iter_mut().enumerate() {
            let is_unknown = active.contains(&a) && !is_separable;
            if is_unknown { sweep.push(velocity) } else { others.push(velocity) }
        }
        sweep.extend(&mut self.p_dot);
        others.extend(self.determinants.iter_mut().chain([&mut norm]));
        for nodes in [sweep, others] {
            let roots: Vec<NodeId> = nodes.iter().map(|node| **node).collect();
            let reduced = parts.graph.reduced(&roots, &level);
            nodes.into_iter().zip(reduced).for_each(|(node, reduced)| *node = reduced);
        }
        (self, norm)
    }
}

impl<S: Real> RowPrograms<S> {
    /// From expressions with few operations. `inverse` are the entries of g^ab of active coordinates by rows, if the
    /// equations of motion are q̈ = a(q).
    pub(super) fn new(
        parts: &mut Parts<S>,
        active: &[usize],
        inverse: Option<&[S]>,
        (rates, norm): (&RateNodes, NodeId),
    ) -> Self {
        let (n, m, is_separable) = (parts.dimension(), active.len(), inverse.is_some());
        let RateNodes { q_dot, p_dot, determinants } = rates;
        let velocities: Vec<NodeId> = active.iter().map(|&a| q_dot[a]).collect();
        let ignorable: Vec<NodeId> = (0..n).filter(|a| !active.contains(a)).map(|a| q_dot[a]).collect();
        let rest = [&p_dot[..], &ignorable, determinants].concat();
        let mut outputs = if is_separable { [rest, velocities].concat() } else { [velocities, rest].concat() };
        outputs.push(norm);
        let (first, count) = (if is_separable { 0 } else { m }, outputs.len());
        let level = level(n, active);
        if let Some(inverse) = inverse {
            let rows = inverse.chunks_exact(m.max(1)).map(|row| combination(parts, row, p_dot)).collect::<Vec<_>>();
            outputs.extend(parts.graph.reduced(&rows, &level));
        }
        let rates = Program::new(&mut parts.graph, 3 * n, &outputs).fused();
        // The momenta of ignorable coordinates are the same in a whole run; of active ones velocities are wanted again.
        let schedules = Schedules::new(&rates, level, [first, first + m, count]);
        let momenta = momenta(parts, active);
        Self {
            rates,
            schedules,
            velocities: if is_separable { count - 1 - m } else { 0 },
            forces: first,
            ignorable: first + m,
            determinants: first + n,
            accelerations: inverse.map(|_| count),
            momenta,
            dimension: n,
            active: active.to_vec(),
            blocks: determinants.len(),
        }
    }

    /// The program of the rates: variables q^a, n that are not used, p_a.
    pub(crate) fn rates(&self) -> &Program<S> {
        &self.rates
    }

    /// Its parts.
    pub(crate) fn schedules(&self) -> &Schedules {
        &self.schedules
    }

    /// How many of its outputs give everything that a sweep needs: velocities of active coordinates, where they are
    /// unknowns, and forces.
    pub(crate) fn sweep(&self) -> usize {
        self.forces + self.active.len()
    }

    /// How many of them are velocities and forces, but for velocities of active coordinates that are not unknowns.
    pub(crate) fn motion(&self) -> usize {
        self.determinants
    }

    /// How many there are.
    pub(crate) fn all(&self) -> usize {
        self.accelerations.unwrap_or(self.rates.outputs())
    }

    /// The register of K.
    pub(crate) fn norm_register(&self) -> Register {
        self.rates.output(self.all() - 1)
    }

    /// The registers of q̇^a of the active coordinates.
    pub(crate) fn velocity_registers(&self) -> Vec<Register> {
        self.registers(self.velocities, self.active.len())
    }

    /// The registers of ṗ_a of the active coordinates.
    pub(crate) fn force_registers(&self) -> Vec<Register> {
        self.registers(self.forces, self.active.len())
    }

    /// The registers of q̇^a of the ignorable coordinates.
    pub(crate) fn ignorable_registers(&self) -> Vec<Register> {
        self.registers(self.ignorable, self.dimension - self.active.len())
    }

    /// The registers of q̈^a of the active coordinates, if these depend on positions only.
    pub(crate) fn acceleration_registers(&self) -> Option<Vec<Register>> {
        self.accelerations.map(|first| self.registers(first, self.active.len()))
    }

    /// The registers of the determinants.
    pub(crate) fn determinant_registers(&self) -> Vec<Register> {
        self.registers(self.determinants, self.blocks)
    }

    /// The program of the momenta p_a of all coordinates and the forces f_a + F_a on active ones, in the variables q^a
    /// and q̇^a.
    pub(crate) fn momenta(&self) -> &Program<S> {
        &self.momenta
    }

    fn registers(&self, first: usize, count: usize) -> Vec<Register> {
        (first..first + count).map(|output| self.rates.output(output)).collect()
    }
}

/// When variables of Hamilton's equations become known: momenta of ignorable coordinates at the start of a run, then
/// positions, then momenta.
pub(super) fn level(n: usize, active: &[usize]) -> impl Fn(usize) -> Level {
    move |variable| match variable.checked_sub(2 * n) {
        None => 1,
        Some(a) if active.contains(&a) => 2,
        Some(_) => 0,
    }
}

/// K = g_ab q̇^a q̇^b.
fn norm<S: Real>(parts: &mut Parts<S>, q_dot: &[NodeId]) -> NodeId {
    let mut sum = parts.graph.constant(S::ZERO);
    let two = parts.graph.constant(S::ONE + S::ONE);
    let metric: Vec<([usize; 2], NodeId)> = parts.metric.iter().map(|(&ab, &node)| (ab, node)).collect();
    for ([a, b], node) in metric {
        let product = parts.graph.multiply(q_dot[a], q_dot[b]);
        let mut term = parts.graph.multiply(node, product);
        if a != b {
            term = parts.graph.multiply(two, term);
        }
        sum = parts.graph.add(sum, term);
    }
    sum
}

/// Σ_b row_b values_b.
fn combination<S: Real>(parts: &mut Parts<S>, row: &[S], values: &[NodeId]) -> NodeId {
    let mut sum = parts.graph.constant(S::ZERO);
    for (&factor, &value) in row.iter().zip(values) {
        let factor = parts.graph.constant(factor);
        let product = parts.graph.multiply(factor, value);
        sum = parts.graph.add(sum, product);
    }
    sum
}

fn momenta<S: Real>(parts: &mut Parts<S>, active: &[usize]) -> Program<S> {
    let n = parts.dimension();
    let q_dot: Vec<NodeId> = (n..2 * n).map(|variable| parts.graph.variable(variable)).collect();
    let mut outputs: Vec<NodeId> = Vec::with_capacity(n + active.len());
    for a in 0..n {
        let mut sum = parts.one_form.get(&a).copied().unwrap_or_else(|| parts.graph.constant(S::ZERO));
        for (b, &velocity) in q_dot.iter().enumerate() {
            if let Some(entry) = parts.component(a, b) {
                let product = parts.graph.multiply(entry, velocity);
                sum = parts.graph.add(sum, product);
            }
        }
        outputs.push(sum);
    }
    for &a in active {
        outputs.push(force(parts, a, &q_dot));
    }
    let outputs = parts.graph.reduced(&outputs, |_| 1);
    Program::new(&mut parts.graph, 2 * n, &outputs).fused()
}
