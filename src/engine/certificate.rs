//! The gradient of the weak action at a window that was solved.
//!
//! With D̄ᵀH = −HD + E_N the gradient of E_weak with respect to one of two equal branches is −H (D̄p_a − f_a − F_a),
//! where p_a = g_ab D̄q^b + A_a, and D̄ contains the initial data. It is computed from the nodes alone, with the
//! formulas of the Lagrangian; `action` computes the same for any operator and any two branches.

use pulp::{Simd, WithSimd};

use super::kernel::{On, evaluate};
use super::window::Solver;
use crate::formula::{Register, Step};
use crate::number::vector::{Lanes, Level, Matrix, Nodes, multiply};

/// Room for certificates.
pub(super) struct Certificate<'g, const N: usize> {
    /// D̄.
    derivative: Box<Matrix<N>>,
    steps: &'g [Step],
    /// The first variables are q^a of n coordinates, then come their velocities.
    registers: Vec<Nodes<N>>,
    /// The registers of p_a of all coordinates, and of f_a + F_a of active ones.
    momenta: Vec<Register>,
    forces: Vec<Option<Register>>,
}

impl<'g, const N: usize> Certificate<'g, N> {
    pub(super) fn new(Solver { geometry, rule, .. }: &Solver<'g, N>) -> Self {
        let program = &geometry.lagrangian.momenta;
        let (n, active) = (geometry.dimension(), geometry.active());
        let mut forces = vec![None; n];
        active.iter().enumerate().for_each(|(place, &a)| forces[a] = Some(program.output(n + place)));
        Self {
            derivative: rule.derivative(),
            steps: program.steps_to(n + active.len()),
            registers: program.registers(|constant| Nodes([constant; N])),
            momenta: (0..n).map(|output| program.output(output)).collect(),
            forces,
        }
    }

    /// The largest entry of the gradient of the action of a window that is complete.
    pub(super) fn of(&mut self, window: &Solver<'_, N>) -> f64 {
        Level::Best.dispatch(On((self, window)))
    }
}

/// Computes max |b (D̄p_a − h (f_a + F_a))|, where p_a is computed from D̄q^b/h.
impl<const N: usize> WithSimd for On<(&mut Certificate<'_, N>, &Solver<'_, N>)> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) -> f64 {
        let On((Certificate { derivative, steps, registers, momenta, forces }, window)) = self;
        let h = window.length;
        let (n, zero) = (momenta.len(), Lanes::splat(s, 0.0));
        let weights = Lanes::new(s, &window.rule.weights);
        let (mut active, mut ignorable) = (0, 0);
        for a in 0..n {
            let way = if forces[a].is_some() {
                let (position, start) = (Lanes::new(s, window.system.position(active)), window.start.q[a]);
                registers[a] = position.nodes();
                active += 1;
                if window.scales.clocks[active - 1] {
                    // Where a jump is met its places may be one number, and its rate is known.
                    registers[n + a] = *window.slope_nodes(active - 1);
                    continue;
                }
                (position - start.high - start.low).nodes()
            } else {
                ignorable += 1;
                window.elapsed[ignorable - 1]
            };
            registers[n + a] = (multiply(s, derivative, &way, [zero; 2]) * (1.0 / h)).nodes();
        }
        let program = &window.geometry.lagrangian.momenta;
        evaluate(s, steps, registers, window.is_mended.then_some(program));
        // The maximum may lose a NaN, the sum does not.
        let (mut most, mut sum) = (zero, zero);
        active = 0;
        for a in 0..n {
            let (start, force) = match forces[a] {
                Some(register) => {
                    active += 1;
                    (window.start.p[active - 1].high, Lanes::new(s, &registers[register]) * -h)
                }
                None => (window.initial.p[a], zero),
            };
            let gain = (Lanes::new(s, &registers[momenta[a]]) - start).nodes();
            let entry = multiply(s, derivative, &gain, [force, zero]) * weights;
            most = most.max(entry.abs());
            sum = sum + entry;
        }
        if sum.dot(Lanes::splat(s, 1.0)).is_finite() { most.largest() } else { f64::INFINITY }
    }
}
