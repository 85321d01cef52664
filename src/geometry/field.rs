//! Hamilton's equations of a scene as one program, with their Jacobian.
//!
//! ```text
//! q̇^a = g^ab (p_b − A_b),    ṗ_a = ½ ∂_a g_bc q̇^b q̇^c + ∂_a A_b q̇^b + F_a(q, q̇)
//! ```
//!
//! Where the Hamiltonian H(q, p) is known, they are q̇^a = ∂H/∂p_a and, without a force, ṗ_a = −∂H/∂q^a.
//!
//! The momenta of ignorable coordinates are constants of a run. The equations of the active coordinates do not contain
//! ignorable ones, which are quadratures.

use std::sync::Arc;

use super::inverse::Inverse;
use super::is_outside;
use super::linearised::{Equations, Linearised};
use super::outside::OutsideGeometry;
use super::parts::Parts;
use super::rows::{RateNodes, RowPrograms};
use super::structure::Source;
use crate::formula::{NodeId, Program};
use crate::number::Real;

/// Hamilton's equations.
#[derive(Debug, Clone)]
pub struct Field<S = f64> {
    dimension: usize,
    active: Vec<usize>,
    /// Outputs: q̇^a for all a, ṗ_a for active a, the determinants of the blocks.
    rates: Program<S>,
    blocks: usize,
    signs: Vec<S>,
    rows: RowPrograms<S>,
    linearised: Arc<Linearised<S>>,
}

/// The registers in which a program runs, with what it computed last.
#[derive(Debug, Clone)]
pub struct Rates<S> {
    registers: Vec<S>,
}

impl<S: Real> Field<S> {
    pub(super) fn new(parts: &mut Parts<S>, inverse: &Inverse, active: &[usize], separable: Option<&[S]>) -> Self {
        let (n, is_separable) = (parts.dimension(), separable.is_some());
        let q_dot = velocities(parts, inverse);
        let p_dot: Vec<NodeId> = active.iter().map(|&a| rate(parts, a, &q_dot)).collect();
        let determinants: Vec<NodeId> = inverse.blocks.iter().map(|block| block.determinant).collect();
        let plain = [q_dot.clone(), p_dot.clone()];
        let (rates, norm) = RateNodes { q_dot, p_dot, determinants }.reduced(parts, active, is_separable);
        let rows = RowPrograms::new(parts, active, separable, (&rates, norm));
        let RateNodes { q_dot, p_dot, determinants } = rates;
        let rates = Program::new(&mut parts.graph, 3 * n, &[&q_dot[..], &p_dot, &determinants].concat());
        let linearised = Linearised::new(parts, active, is_separable, [plain, [q_dot, p_dot]]);
        Self {
            dimension: n,
            active: active.to_vec(),
            rates,
            blocks: inverse.blocks.len(),
            signs: vec![S::ZERO; inverse.blocks.len()],
            rows,
            linearised: Arc::new(linearised),
        }
    }

    pub(super) fn set_signs(&mut self, signs: &[S]) {
        self.signs.copy_from_slice(signs);
    }

    /// The active coordinates.
    pub fn active(&self) -> &[usize] {
        &self.active
    }

    /// The program: variables q^a, then n that are not used, then p_a; outputs q̇^a for all a, then ṗ_a for active a.
    pub(crate) fn program(&self) -> &Program<S> {
        &self.rates
    }

    /// The equations for all nodes of a window at once.
    pub(crate) fn rows(&self) -> &RowPrograms<S> {
        &self.rows
    }

    /// The signs that the determinants of the blocks have, ±1, or 0 for either.
    pub(crate) fn signs(&self) -> &[S] {
        &self.signs
    }

    /// Room to evaluate the equations in.
    pub fn room(&self) -> Rates<S> {
        Rates { registers: self.rates.registers(|constant| constant) }
    }

    /// Room to evaluate the Jacobian in.
    pub fn jacobian_room(&self) -> Rates<S> {
        Rates { registers: self.linearised.get().jacobian.registers(|constant| constant) }
    }

    /// Evaluates the equations at all q^a and p_a.
    ///
    /// # Errors
    /// [`OutsideGeometry`] with `index` 0.
    #[inline]
    pub fn evaluate(&self, q: &[S], p: &[S], rates: &mut Rates<S>) -> Result<(), OutsideGeometry> {
        rates.set(q, p);
        let all = self.dimension + self.active.len() + self.blocks;
        self.rates.run_once(all, &mut rates.registers);
        match self.check(rates) {
            Err(_) if self.rates.mend(all, &mut rates.registers, |number| number) => self.check(rates),
            found => found,
        }
    }

    /// Whether the point that was evaluated lies inside the domain.
    #[inline]
    fn check(&self, rates: &Rates<S>) -> Result<(), OutsideGeometry> {
        let outputs = self.dimension + self.active.len();
        for (block, &sign) in self.signs.iter().enumerate() {
            let determinant = rates.registers[self.rates.output(outputs + block)];
            if is_outside(determinant, sign) {
                return Err(OutsideGeometry { index: 0, block: Some(block), determinant: determinant.to_f64() });
            }
        }
        let is_finite = |output: usize| rates.registers[self.rates.output(output)].is_finite();
        if (0..outputs).all(is_finite) {
            return Ok(());
        }
        Err(OutsideGeometry { index: 0, block: None, determinant: f64::NAN })
    }

    /// Writes the rates of a state, q^a of all coordinates and then p_a of all, into `out`.
    ///
    /// # Errors
    /// As [`Self::evaluate`].
    pub(crate) fn slopes(&self, state: &[S], rates: &mut Rates<S>, out: &mut [S]) -> Result<(), OutsideGeometry> {
        let n = self.dimension;
        self.evaluate(&state[..n], &state[n..], rates)?;
        (0..n).for_each(|a| out[a] = self.q_dot(rates, a));
        out[n..].fill(S::ZERO);
        for (place, &a) in self.active.iter().enumerate() {
            out[n + a] = self.p_dot(rates, place);
        }
        Ok(())
    }

    /// dq^a/dγ as evaluated last.
    #[inline]
    pub fn q_dot(&self, rates: &Rates<S>, a: usize) -> S {
        rates.registers[self.rates.output(a)]
    }

    /// dp/dγ of the active coordinate with that place among the active ones, as evaluated last.
    #[inline]
    pub fn p_dot(&self, rates: &Rates<S>, place: usize) -> S {
        rates.registers[self.rates.output(self.dimension + place)]
    }

    /// Calls `see(row, column, value)` for the entries of ∂(q̇, ṗ)/∂(q, p) of the active coordinates that are not
    /// zero. Rows and columns 0 … m−1 are positions, m … 2m−1 momenta.
    pub fn jacobian(&self, q: &[S], p: &[S], rates: &mut Rates<S>, see: impl FnMut(usize, usize, S)) {
        rates.set(q, p);
        let Equations { entries, jacobian, .. } = self.linearised.get();
        let of_active = entries.iter().take_while(|entry| entry.row < 2 * self.active.len());
        let outputs = of_active.filter(|entry| matches!(entry.value, Source::Row(_))).count();
        jacobian.run(outputs, &mut rates.registers);
        self.each_entry(|output| rates.registers[jacobian.output(output)], see);
    }

    /// The same with `value_of` an output of the program of the entries.
    pub(crate) fn each_entry(&self, value_of: impl Fn(usize) -> S, mut see: impl FnMut(usize, usize, S)) {
        for entry in self.linearised.get().entries.iter().take_while(|entry| entry.row < 2 * self.active.len()) {
            let value = match entry.value {
                Source::Constant(value) => value,
                Source::Row(output) => value_of(output),
            };
            see(entry.row, entry.column, value);
        }
    }

    /// The linearised equations.
    pub(crate) fn linearised(&self) -> &Equations<S> {
        self.linearised.get()
    }
}

impl<S: Real> Rates<S> {
    #[inline]
    fn set(&mut self, q: &[S], p: &[S]) {
        let n = q.len();
        self.registers[..n].copy_from_slice(q);
        self.registers[2 * n..3 * n].copy_from_slice(p);
    }
}

/// q̇^a = g^ab (p_b − A_b) for every a.
fn velocities<S: Real>(parts: &mut Parts<S>, inverse: &Inverse) -> Vec<NodeId> {
    let n = parts.dimension();
    if let Some(hamiltonian) = parts.hamiltonian {
        return (2 * n..3 * n).map(|p| parts.graph.derivative(hamiltonian, p)).collect();
    }
    let kinetic: Vec<NodeId> = (0..n)
        .map(|b| {
            let p = parts.graph.variable(2 * n + b);
            match parts.one_form.get(&b) {
                Some(&one_form) => parts.graph.subtract(p, one_form),
                None => p,
            }
        })
        .collect();
    let velocity = |a: usize| {
        let mut sum = parts.graph.constant(S::ZERO);
        for (b, &kinetic) in kinetic.iter().enumerate() {
            if let Some(entry) = inverse.get(a, b) {
                let product = parts.graph.multiply(entry, kinetic);
                sum = parts.graph.add(sum, product);
            }
        }
        sum
    };
    (0..n).map(velocity).collect()
}

/// ṗ_a.
fn rate<S: Real>(parts: &mut Parts<S>, a: usize, q_dot: &[NodeId]) -> NodeId {
    match parts.hamiltonian {
        Some(hamiltonian) if parts.force.is_empty() => {
            let slope = parts.graph.derivative(hamiltonian, a);
            parts.graph.negate(slope)
        }
        _ => force(parts, a, q_dot),
    }
}

/// f_a + F_a.
pub(super) fn force<S: Real>(parts: &mut Parts<S>, a: usize, q_dot: &[NodeId]) -> NodeId {
    let half = parts.graph.constant(S::ONE.half());
    let mut sum = parts.graph.constant(S::ZERO);
    let metric: Vec<([usize; 2], NodeId)> = parts.metric.iter().map(|(&bc, &node)| (bc, node)).collect();
    for ([b, c], node) in metric {
        let slope = parts.graph.derivative(node, a);
        let mut term = parts.graph.multiply(slope, q_dot[b]);
        term = parts.graph.multiply(term, q_dot[c]);
        if b == c {
            term = parts.graph.multiply(half, term);
        }
        sum = parts.graph.add(sum, term);
    }
    let one_form: Vec<(usize, NodeId)> = parts.one_form.iter().map(|(&b, &node)| (b, node)).collect();
    for (b, node) in one_form {
        let slope = parts.graph.derivative(node, a);
        let term = parts.graph.multiply(slope, q_dot[b]);
        sum = parts.graph.add(sum, term);
    }
    if let Some(&force) = parts.force.get(&a) {
        let n = parts.dimension();
        let variables: Vec<NodeId> = (0..n).map(|b| parts.graph.variable(b)).collect();
        let replacement: Vec<NodeId> = variables.iter().chain(q_dot).copied().collect();
        let force = parts.graph.substitute(&[force], &replacement)[0];
        sum = parts.graph.add(sum, force);
    }
    sum
}
