//! Hamilton's equations of a scene as one program: for points, for the nodes of a window, for Taylor series.
//!
//! The momenta of ignorable coordinates are constants of a run. The equations of the active coordinates do not contain
//! ignorable ones, which are quadratures.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use super::expressions::Expressions;
use super::inverse::Inverse;
use super::linearised::Equations;
use super::parts::Parts;
use super::{OutsideGeometry, is_outside};
use crate::formula::{Function, MOST_LOST, NodeId, Operation, Program, Register, run_at};
use crate::number::Real;

/// Hamilton's equations.
#[derive(Debug)]
pub(crate) struct Hamiltonian<S = f64> {
    /// Variables are q^a, then n that are not used, then p_a. The first outputs are what a sweep over a window needs:
    /// velocities of active coordinates, unless the motion is separable, and forces on them. Then come velocities of
    /// ignorable coordinates, determinants, other velocities, K, accelerations.
    pub(crate) program: Program<S>,
    /// The number of outputs before K, which are all that a point needs.
    pub(super) point: usize,
    pub(crate) active: Vec<usize>,
    /// The active part of g^ab, row by row, if it is constant and coupled to nothing else.
    pub(crate) inverse: Option<Vec<S>>,
    /// The registers of q̇^a of all coordinates.
    pub(crate) velocities: Vec<Register>,
    /// The registers of ṗ_a of active coordinates.
    pub(crate) forces: Vec<Register>,
    /// The registers of q̈^a of active coordinates, if the motion is separable.
    pub(crate) accelerations: Option<Vec<Register>>,
    /// The registers of the determinants of the blocks.
    pub(crate) determinants: Vec<Register>,
    parts: Parts<S>,
    /// The equations as they were formed, and with few operations.
    expressions: [Expressions; 2],
    linearised: OnceLock<Equations<S>>,
}

impl<S: Real> Hamiltonian<S> {
    pub(super) fn new(mut parts: Parts<S>, inverse: &Inverse, active: Vec<usize>) -> Self {
        let (n, constant) = (parts.dimension(), constant_inverse(&parts, inverse, &active));
        let plain = Expressions::new(&mut parts, inverse, &active);
        let reduced = plain.reduced(&mut parts, &active, constant.is_some());
        let Expressions { velocities, forces, determinants } = &reduced;
        let own: Vec<NodeId> = active.iter().map(|&a| velocities[a]).collect();
        let others: Vec<NodeId> = (0..n).filter(|a| !active.contains(a)).map(|a| velocities[a]).collect();
        let rest = [&forces[..], &others, determinants].concat();
        let mut outputs = if constant.is_some() { [rest, own].concat() } else { [own, rest].concat() };
        let point = outputs.len();
        let accelerations = constant.as_ref().map(|inverse| plain.accelerations(&mut parts, &active, inverse));
        outputs.extend(accelerations.iter().flatten());
        let program = Program::new(&mut parts.graph, 3 * n, &outputs).fused();
        let register = |node: &NodeId| {
            let output = outputs.iter().position(|output| output == node);
            program.output(output.expect("it is among the outputs"))
        };
        let registers = |nodes: &[NodeId]| nodes.iter().map(register).collect();
        Self {
            point,
            velocities: registers(velocities),
            forces: registers(forces),
            accelerations: accelerations.as_deref().map(registers),
            determinants: registers(determinants),
            program,
            active,
            inverse: constant,
            parts,
            expressions: [plain, reduced],
            linearised: OnceLock::new(),
        }
    }

    /// The coordinates that are unknown parameters.
    pub(crate) fn unknown(&self) -> Range<usize> {
        self.parts.unknown.clone()
    }

    /// Returns true if a coordinate moves at a velocity that no active coordinate or momentum changes.
    pub(crate) fn is_steady(&self, a: usize) -> bool {
        let n = self.velocities.len();
        let is_variable = |register: Register| self.active.iter().any(|&b| register == b || register == 2 * n + b);
        !self.program.depends_on(is_variable)[self.velocities[a]]
    }

    /// The registers of q̇^a of active coordinates.
    pub(crate) fn active_velocities(&self) -> Vec<Register> {
        self.active.iter().map(|&a| self.velocities[a]).collect()
    }

    /// The registers of q̇^a of ignorable coordinates.
    pub(crate) fn ignorable_velocities(&self) -> Vec<Register> {
        let all = self.velocities.iter().enumerate();
        all.filter(|(a, _)| !self.active.contains(a)).map(|(_, &register)| register).collect()
    }

    /// The function by which the equations of active coordinates jump, if there is one: sign or step of what depends on
    /// more than clocks, which are the same in neighbouring motions.
    pub(super) fn jump(&self, is_clock: impl Fn(usize) -> bool) -> Option<&'static str> {
        let (n, active) = (self.velocities.len(), &self.active);
        let moves = |place: usize| !is_clock(place);
        let varies = |variable: usize| {
            let of_variable = |a: &usize| *a == variable || 2 * n + a == variable;
            active.iter().position(of_variable).is_some_and(moves)
        };
        let depends = self.program.depends_on(varies);
        let outputs = if self.inverse.is_some() { n } else { n + active.len() };
        self.program.steps_to(outputs).iter().find_map(|step| match step.operation() {
            Operation::Call(Function::Sign, argument) if depends[argument] => Some("sign"),
            Operation::Call(Function::Step, argument) if depends[argument] => Some("step"),
            _ => None,
        })
    }

    /// Returns true if a force may grow like a power below 1: with abs, a root or a power that may be no whole one.
    pub(super) fn may_grow_like_a_root(&self) -> bool {
        self.program.steps_to(self.program.outputs.len()).iter().any(|step| {
            matches!(step.operation(), Operation::Call(Function::Abs | Function::Sqrt, _) | Operation::Power(..))
        })
    }

    /// The linearised equations, which are formed when they are first asked for.
    pub(crate) fn linearised(&self) -> &Equations<S> {
        self.linearised.get_or_init(|| Equations::new(self.parts.clone(), &self.active, &self.expressions))
    }
}

/// The active part of g^ab, if the equations of motion are q̈ = a(q).
fn constant_inverse<S: Real>(parts: &Parts<S>, inverse: &Inverse, active: &[usize]) -> Option<Vec<S>> {
    let n = parts.dimension();
    let is_coupled = |a: usize| (0..n).any(|b| !active.contains(&b) && inverse.get(a, b).is_some());
    let has_one_form = |a: usize| parts.one_form.contains_key(&a);
    if !parts.force.is_empty() || active.iter().any(|&a| is_coupled(a) || has_one_form(a)) {
        return None;
    }
    let entry = |a: usize, b: usize| inverse.get(a, b).map_or(Some(S::ZERO), |node| parts.graph.as_constant(node));
    active.iter().flat_map(|&a| active.iter().map(move |&b| (a, b))).map(|(a, b)| entry(a, b)).collect()
}

/// Hamilton's equations at N points, and room to compute them in.
#[derive(Debug, Clone)]
pub struct Points<S, const N: usize> {
    pub(super) hamiltonian: Arc<Hamiltonian<S>>,
    /// The signs that the determinants must have.
    pub(super) signs: Vec<S>,
    pub(super) registers: Vec<[S; N]>,
    /// The registers of the Jacobian, from when it is first asked for.
    jacobian: Vec<[S; N]>,
}

/// Hamilton's equations at one point.
pub type Point<S = f64> = Points<S, 1>;

impl<S: Real, const N: usize> Points<S, N> {
    pub(super) fn new(hamiltonian: &Arc<Hamiltonian<S>>, signs: &[S]) -> Self {
        Self {
            registers: hamiltonian.program.registers(|constant| [constant; N]),
            hamiltonian: hamiltonian.clone(),
            signs: signs.to_vec(),
            jacobian: Vec::new(),
        }
    }

    /// Evaluates the equations at so many points, where q^a and p_a are in their registers. The first of them is the
    /// node `first`. After `chances` points that cannot be mended no others are tried.
    ///
    /// # Errors
    /// The first node that is outside the domain.
    #[inline]
    pub(super) fn evaluate_there(
        &mut self,
        points: usize,
        first: usize,
        chances: &mut usize,
    ) -> Result<(), OutsideGeometry> {
        let Hamiltonian { program, point, .. } = &*self.hamiltonian;
        run_at(program.steps_to(*point), &mut self.registers);
        if self.is_inside(0..points)
            || program.mend(*point, points, &mut self.registers, chances) && self.is_inside(0..points)
        {
            return Ok(());
        }
        Err(self.outside(points, first))
    }

    /// Returns true if all determinants have the signs that they must have at these points, and rates are finite.
    #[inline]
    fn is_inside(&self, points: Range<usize>) -> bool {
        let Hamiltonian { velocities, forces, determinants, .. } = &*self.hamiltonian;
        if N == 1 {
            // Loops over one point would take as long as the equations.
            let is_finite = |&rate: &Register| self.registers[rate][0].is_finite();
            let mut determinants = determinants.iter().zip(&self.signs);
            return velocities.iter().all(is_finite)
                && forces.iter().all(is_finite)
                && determinants.all(|(&block, &sign)| !is_outside(self.registers[block][0], sign));
        }
        let row = |register: Register| self.registers[register][points.clone()].iter();
        let mut rates = velocities.iter().chain(forces);
        rates.all(|&rate| row(rate).fold(true, |all, value| all & value.is_finite()))
            && (determinants.iter().zip(&self.signs))
                .all(|(&block, &sign)| row(block).fold(true, |all, &value| all & !is_outside(value, sign)))
    }

    /// The first of the points that lies outside the domain, and why.
    #[cold]
    fn outside(&self, points: usize, first: usize) -> OutsideGeometry {
        let k = (0..points).find(|&k| !self.is_inside(k..k + 1)).unwrap_or(0);
        let value = |register: Register| self.registers[register][k];
        let mut blocks = self.hamiltonian.determinants.iter().zip(&self.signs);
        let block = blocks.position(|(&block, &sign)| is_outside(value(block), sign));
        OutsideGeometry {
            index: first + k,
            block,
            determinant: block.map_or(f64::NAN, |block| value(self.hamiltonian.determinants[block]).to_f64()),
            position: self.hamiltonian.active.first().map_or(f64::NAN, |&a| value(a).to_f64()),
        }
    }

    /// Evaluates the linearised equations at so many points, which `put` puts into registers.
    pub(super) fn linearise(&mut self, points: usize, put: impl FnOnce(&mut [[S; N]])) {
        let (equations, registers) = (self.hamiltonian.linearised(), &mut self.jacobian);
        if registers.is_empty() {
            *registers = equations.jacobian.registers(|constant| [constant; N]);
        }
        put(registers);
        equations.jacobian.run(equations.varying_entries(), points, registers, &mut MOST_LOST.clone());
    }

    /// Calls `see(row, column, value)` for the entries that are not zero, as evaluated last at point k.
    pub(super) fn each_entry(&self, k: usize, see: impl FnMut(usize, usize, S)) {
        let equations = self.hamiltonian.linearised();
        equations.each_entry(|output| self.jacobian[equations.jacobian.output(output)][k], see);
    }
}

impl<S: Real> Point<S> {
    /// Evaluates the equations at all q^a and p_a.
    ///
    /// # Errors
    /// [`OutsideGeometry`] with `index` 0.
    #[inline]
    pub fn evaluate(&mut self, q: &[S], p: &[S]) -> Result<(), OutsideGeometry> {
        set(&mut self.registers, q, p);
        self.evaluate_there(1, 0, &mut 1)
    }

    /// Writes the rates of a state, q^a of all coordinates and then p_a of all, into `out`.
    ///
    /// # Errors
    /// As [`Self::evaluate`].
    pub(crate) fn slopes(&mut self, state: &[S], out: &mut [S]) -> Result<(), OutsideGeometry> {
        let n = self.hamiltonian.velocities.len();
        self.evaluate(&state[..n], &state[n..])?;
        (0..n).for_each(|a| out[a] = self.q_dot(a));
        out[n..].fill(S::ZERO);
        for (place, &a) in self.hamiltonian.active.iter().enumerate() {
            out[n + a] = self.p_dot(place);
        }
        Ok(())
    }

    /// dq^a/dγ as evaluated last.
    #[inline]
    pub fn q_dot(&self, a: usize) -> S {
        self.registers[self.hamiltonian.velocities[a]][0]
    }

    /// dp/dγ of the active coordinate with that place among the active ones, as evaluated last.
    #[inline]
    pub fn p_dot(&self, place: usize) -> S {
        self.registers[self.hamiltonian.forces[place]][0]
    }

    /// d²q/dγ² as evaluated last, of the active coordinate with that place, if it does not depend on momenta: if the
    /// active part of g^ab is constant and coupled to nothing else.
    #[inline]
    pub fn acceleration(&self, place: usize) -> Option<S> {
        let (inverse, m) = (self.hamiltonian.inverse.as_deref()?, self.hamiltonian.active.len());
        let row = &inverse[place * m..][..m];
        Some(row.iter().enumerate().fold(S::ZERO, |sum, (other, &g)| sum + g * self.p_dot(other)))
    }

    /// Calls `see(row, column, value)` for the entries of ∂(q̇, ṗ)/∂(q, p) of the active coordinates that are not
    /// zero. Rows and columns 0 … m−1 are positions, m … 2m−1 momenta.
    pub fn jacobian(&mut self, q: &[S], p: &[S], see: impl FnMut(usize, usize, S)) {
        self.linearise(1, |registers| set(registers, q, p));
        self.each_entry(0, see);
    }
}

/// Puts all q^a and p_a into registers.
#[inline]
pub(super) fn set<S: Real>(registers: &mut [[S; 1]], q: &[S], p: &[S]) {
    let (n, registers) = (q.len(), registers.as_flattened_mut());
    // A few numbers are copied faster one by one.
    registers[..n].iter_mut().zip(q).for_each(|(register, &q)| *register = q);
    registers[2 * n..3 * n].iter_mut().zip(p).for_each(|(register, &p)| *register = p);
}
