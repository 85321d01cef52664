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
    /// of ignorable ones, the determinants. The very last output is K.
    rates: Program<S>,
    schedules: Schedules,
    velocities: usize,
    forces: usize,
    ignorable: usize,
    determinants: usize,
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
    /// All outputs.
    pub(crate) all: Box<[Step]>,
}

impl Schedules {
    /// So many outputs are velocities of active coordinates that are unknowns, and so many are what a sweep needs.
    fn new<S: Real>(rates: &Program<S>, level: impl Fn(usize) -> Level, [velocities, sweep]: [usize; 2]) -> Self {
        let varies = rates.depends_on(|variable| level(variable) > 0);
        let moves = rates.depends_on(|variable| level(variable) == 2);
        let outputs = |count: usize| (0..count).map(|output| rates.output(output));
        Self {
            fixed: rates.schedule(0..rates.size(), |register| varies[register]),
            sweep: rates.schedule(outputs(sweep), |register| !varies[register]),
            velocities: rates.schedule(outputs(velocities), |register| !moves[register]),
            all: rates.schedule(outputs(rates.outputs()), |register| !varies[register]),
        }
    }
}

impl<S: Real> RowPrograms<S> {
    pub(super) fn new(
        parts: &mut Parts<S>,
        active: &[usize],
        is_separable: bool,
        [q_dot, p_dot, determinants]: [&[NodeId]; 3],
    ) -> Self {
        let (n, m) = (parts.dimension(), active.len());
        let velocities: Vec<NodeId> = active.iter().map(|&a| q_dot[a]).collect();
        let ignorable: Vec<NodeId> = (0..n).filter(|a| !active.contains(a)).map(|a| q_dot[a]).collect();
        let rest = [p_dot, &ignorable, determinants].concat();
        let mut outputs = if is_separable { [rest, velocities].concat() } else { [velocities, rest].concat() };
        outputs.push(norm(parts, q_dot));
        let first = if is_separable { 0 } else { m };
        // The momenta of ignorable coordinates are the same in a whole run; of active ones velocities are wanted again.
        let level = level(n, active);
        // What a sweep needs comes first: it shares its work with nothing that is wanted once.
        let (sweep, others) = outputs.split_at_mut(first + m);
        for outputs in [sweep, others] {
            let reduced = parts.graph.reduced(outputs, &level);
            outputs.copy_from_slice(&reduced);
        }
        let rates = Program::new(&mut parts.graph, 3 * n, &outputs).fused();
        let schedules = Schedules::new(&rates, level, [first, first + m]);
        let momenta = momenta(parts, active);
        Self {
            rates,
            schedules,
            velocities: if is_separable { outputs.len() - 1 - m } else { 0 },
            forces: first,
            ignorable: first + m,
            determinants: first + n,
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
        self.rates.outputs()
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
