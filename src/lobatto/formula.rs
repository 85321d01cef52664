//! The force of a formula: an interpreter of its program on vectors, compiled into the march itself.

use pulp::Simd;

use super::elementary;
use super::force::{Force, NEAR, corrections};
use super::simd::{abs, copy, is_fused, multiply_add, neg, product_error, two_sum, vectors, vectors_mut};
use super::tables::Nodes;
use crate::metric::Metric;
use crate::potential::{Function, Instruction, Program};

/// g00 and its derivatives by the program of V, an instruction all nodes. Constants are registers that were filled
/// once.
#[derive(Debug, Clone)]
pub(super) struct FormulaForce<const P: usize> {
    q_t: f64,
    c_squared: f64,
    two_over_mass: f64,
    steps: Vec<Instruction<f64>>,
    /// For a sine or cosine the step with the other one of the same argument: the first of them does both.
    twins: Vec<Option<usize>>,
    /// The first of the steps are those that V and V′ need; V″ needs the others too.
    steps_to_slope: usize,
    /// Register 0 is x, then the constants, then one register a step.
    first_step: usize,
    value: usize,
    slope: usize,
    curvature: usize,
    /// The registers, and in `refine` what they lack.
    registers: Vec<Nodes<P>>,
    lacks: Vec<Nodes<P>>,
    points: usize,
    /// Whether it calls functions.
    is_dear: bool,
}

/// The operands of an instruction.
fn operands(instruction: Instruction<f64>) -> [Option<usize>; 2] {
    match instruction {
        Instruction::X | Instruction::Constant(_) => [None, None],
        Instruction::Negate(a) | Instruction::Call(_, a) => [Some(a), None],
        Instruction::Add(a, b)
        | Instruction::Subtract(a, b)
        | Instruction::Multiply(a, b)
        | Instruction::Divide(a, b)
        | Instruction::Power(a, b) => [Some(a), Some(b)],
    }
}

/// Whether the instruction is a constant ±2^k whose reciprocal is a number as exact.
fn is_power_of_two(instruction: Instruction<f64>) -> bool {
    matches!(instruction, Instruction::Constant(c) if (1.0 / c).is_normal() && c.to_bits() << 12 == 0 && c.is_normal())
}

/// Whether two instructions compute the same number.
fn is_same(a: Instruction<f64>, b: Instruction<f64>) -> bool {
    use Instruction::{Add, Call, Divide, Multiply, Negate, Power, Subtract};
    match (a, b) {
        (Add(i, j), Add(k, l)) | (Multiply(i, j), Multiply(k, l)) => (i, j) == (k, l) || (i, j) == (l, k),
        (Subtract(i, j), Subtract(k, l)) | (Divide(i, j), Divide(k, l)) | (Power(i, j), Power(k, l)) => {
            (i, j) == (k, l)
        }
        (Negate(i), Negate(k)) => i == k,
        (Call(f, i), Call(g, k)) => f == g && i == k,
        _ => false,
    }
}

/// Whether one is the sine and one the cosine of the same.
fn are_twins(a: Instruction<f64>, b: Instruction<f64>) -> bool {
    use Function::{Cos, Sin};
    matches!((a, b), (Instruction::Call(Sin, i), Instruction::Call(Cos, k))
        | (Instruction::Call(Cos, i), Instruction::Call(Sin, k)) if i == k)
}

impl<const P: usize> FormulaForce<P> {
    /// For windows of `points` nodes. What only V″ needs is dropped where an evaluation is cheap.
    pub(super) fn new(metric: &Metric, q_t: f64, program: &Program<f64>, points: usize) -> Self {
        let all = program.instructions();
        let [value, slope, curvature] = program.outputs();
        let needed_for = |outputs: &[usize]| {
            let mut needed = vec![false; all.len()];
            outputs.iter().for_each(|&output| needed[output] = true);
            for k in (0..all.len()).rev() {
                if needed[k] {
                    operands(all[k]).into_iter().flatten().for_each(|operand| needed[operand] = true);
                }
            }
            needed
        };
        let forces = needed_for(&[value, slope]);
        let calls = |(instruction, &needed): (&Instruction<f64>, &bool)| needed && is_function(instruction);
        let is_dear = all.iter().zip(&forces).any(calls);
        let needed = if is_dear { needed_for(&[value, slope, curvature]) } else { forces.clone() };
        let mut register_of = vec![0; all.len()];
        let mut registers = vec![Nodes::ZERO];
        for (k, instruction) in all.iter().enumerate().filter(|&(k, _)| needed[k]) {
            if let Instruction::Constant(c) = *instruction {
                register_of[k] = registers.len();
                registers.push(Nodes([c; P]));
                if is_power_of_two(*instruction) {
                    registers.push(Nodes([1.0 / c; P]));
                }
            }
        }
        let first_step = registers.len();
        let mut steps = Vec::new();
        let mut steps_to_slope = 0;
        for is_for_forces in [true, false] {
            for (k, instruction) in all.iter().enumerate().filter(|&(k, _)| needed[k] && forces[k] == is_for_forces) {
                let at = |r: usize| register_of[r];
                let step = match *instruction {
                    Instruction::X | Instruction::Constant(_) => continue,
                    Instruction::Add(a, b) => Instruction::Add(at(a), at(b)),
                    Instruction::Subtract(a, b) => Instruction::Subtract(at(a), at(b)),
                    Instruction::Multiply(a, b) => Instruction::Multiply(at(a), at(b)),
                    // Dividing by a power of two is multiplying by another, to the bit, and ten times slower.
                    Instruction::Divide(a, b) if is_power_of_two(all[b]) => {
                        Instruction::Multiply(at(a), register_of[b] + 1)
                    }
                    Instruction::Divide(a, b) => Instruction::Divide(at(a), at(b)),
                    Instruction::Negate(a) => Instruction::Negate(at(a)),
                    Instruction::Power(a, b) => Instruction::Power(at(a), at(b)),
                    Instruction::Call(function, a) => Instruction::Call(function, at(a)),
                };
                // Integer powers of V and of V′ are multiplied out separately: what exists already is not computed
                // again.
                let known = steps.iter().position(|&earlier| is_same(earlier, step));
                register_of[k] = first_step + known.unwrap_or(steps.len());
                if known.is_none() {
                    steps.push(step);
                }
            }
            if is_for_forces {
                steps_to_slope = steps.len();
            }
        }
        let twins = steps.iter().map(|&step| steps.iter().position(|&other| are_twins(step, other))).collect();
        registers.resize(first_step + steps.len(), Nodes::ZERO);
        Self {
            q_t,
            c_squared: metric.c_squared(),
            two_over_mass: metric.two_over_mass(),
            first_step,
            value: register_of[value],
            slope: register_of[slope],
            curvature: register_of[curvature],
            registers,
            lacks: Vec::new(),
            points,
            is_dear,
            twins,
            steps,
            steps_to_slope,
        }
    }

    /// Runs the instructions in this range.
    #[inline(always)]
    fn run<S: Simd>(&mut self, s: S, from: usize, to: usize) {
        let mut k = from;
        while k < to {
            let step = self.steps[k];
            let (done, rest) = self.registers.split_at_mut(self.first_step + k);
            k += 1;
            let out = &mut rest[0];
            match step {
                Instruction::Add(i, j) => {
                    let (p, q, out) =
                        (vectors::<S>(&done[i].0), vectors::<S>(&done[j].0), vectors_mut::<S>(&mut out.0));
                    for n in 0..out.len() {
                        out[n] = s.add_f64s(p[n], q[n]);
                    }
                }
                Instruction::Subtract(i, j) => {
                    let (p, q, out) =
                        (vectors::<S>(&done[i].0), vectors::<S>(&done[j].0), vectors_mut::<S>(&mut out.0));
                    for n in 0..out.len() {
                        out[n] = s.sub_f64s(p[n], q[n]);
                    }
                }
                Instruction::Multiply(i, j) => {
                    let (p, q, out) =
                        (vectors::<S>(&done[i].0), vectors::<S>(&done[j].0), vectors_mut::<S>(&mut out.0));
                    for n in 0..out.len() {
                        out[n] = s.mul_f64s(p[n], q[n]);
                    }
                }
                Instruction::Divide(i, j) => {
                    let (p, q, out) =
                        (vectors::<S>(&done[i].0), vectors::<S>(&done[j].0), vectors_mut::<S>(&mut out.0));
                    for n in 0..out.len() {
                        out[n] = s.div_f64s(p[n], q[n]);
                    }
                }
                Instruction::Negate(i) => {
                    let (p, out) = (vectors::<S>(&done[i].0), vectors_mut::<S>(&mut out.0));
                    for n in 0..out.len() {
                        out[n] = neg(s, p[n]);
                    }
                }
                Instruction::Power(i, j) => elementary::power(s, &done[i].0, &done[j].0, &mut out.0),
                Instruction::Call(function, i) => match self.twins[k - 1] {
                    Some(twin) if twin < k => {}
                    Some(twin) => {
                        let (out, later) = rest.split_at_mut(1);
                        let (out, other) = (&mut out[0].0, &mut later[twin - k].0);
                        let (sin, cos) = if function == Function::Sin { (out, other) } else { (other, out) };
                        elementary::sin_cos(s, &done[i].0, [sin, cos]);
                    }
                    None => elementary::call(s, function, &done[i].0, &mut out.0),
                },
                Instruction::X | Instruction::Constant(_) => unreachable!("they are registers from the start"),
            }
        }
    }
}

/// Whether the instruction takes longer than all arithmetic.
fn is_function(instruction: &Instruction<f64>) -> bool {
    matches!(instruction, Instruction::Power(..) | Instruction::Call(..))
}

impl<const P: usize> Force for FormulaForce<P> {
    #[inline]
    fn set(&mut self, q_t: f64, points: usize) {
        (self.q_t, self.points) = (q_t, points);
    }

    #[inline(always)]
    fn refines(&self) -> bool {
        !self.is_dear
    }

    const MAY_BE_DEAR: bool = true;

    #[inline(always)]
    fn is_dear(&self) -> bool {
        self.is_dear && self.q_t != 0.0
    }

    #[inline(always)]
    fn slopes<S: Simd>(&mut self, s: S, [a, u]: [&[f64]; 2], [da, du]: [&mut [f64]; 2]) {
        self.run(s, self.steps_to_slope, self.steps.len());
        // With a = −½ g00′ u²: du/dx = 2 a/Q_t and da/dx = −½ g00″ u² + 4 a²/(Q_t u).
        let half = s.splat_f64s(-0.5 * self.two_over_mass);
        let reciprocal = s.splat_f64s(2.0 / self.q_t);
        let curvature = vectors::<S>(&self.registers[self.curvature].0);
        let (a, u) = (vectors::<S>(a), vectors::<S>(u));
        let (da, du) = (vectors_mut::<S>(da), vectors_mut::<S>(du));
        for i in 0..a.len() {
            du[i] = s.mul_f64s(a[i], reciprocal);
            let bend = s.mul_f64s(s.mul_f64s(curvature[i], half), s.mul_f64s(u[i], u[i]));
            let twice = s.add_f64s(du[i], du[i]);
            da[i] = multiply_add(s, s.div_f64s(twice, u[i]), a[i], bend);
        }
    }

    #[inline(always)]
    fn evaluate<S: Simd>(&mut self, s: S, x: &[f64], a: &mut [f64], u: &mut [f64], near: bool) {
        // The padding repeats the last node: it must not be a point of its own, which might lie outside the domain.
        copy::<S>(x, &mut self.registers[0].0);
        let last = x[self.points - 1];
        let mut k = self.points;
        while k < P {
            self.registers[0].0[k] = last;
            k += 1;
        }
        self.run(s, 0, self.steps_to_slope);
        let (q, m, c) = (s.splat_f64s(self.q_t), s.splat_f64s(self.two_over_mass), s.splat_f64s(self.c_squared));
        let half = s.splat_f64s(-0.5 * self.two_over_mass);
        let value = vectors::<S>(&self.registers[self.value].0);
        let slope = vectors::<S>(&self.registers[self.slope].0);
        let (a, u) = (&mut vectors_mut::<S>(a)[..value.len()], &mut vectors_mut::<S>(u)[..value.len()]);
        if near && is_fused::<S>() && self.q_t != 0.0 {
            // One Newton step, see `PolynomialForce`.
            let reciprocal = s.splat_f64s(1.0 / self.q_t);
            let mut far = s.splat_f64s(0.0);
            for i in 0..value.len() {
                let g = multiply_add(s, value[i], m, c);
                let r = s.mul_f64s(multiply_add(s, neg(s, g), u[i], q), reciprocal);
                far = s.max_f64s(far, abs(s, r));
                u[i] = multiply_add(s, r, u[i], u[i]);
                a[i] = s.mul_f64s(s.mul_f64s(s.mul_f64s(slope[i], half), u[i]), u[i]);
            }
            if s.reduce_max_f64s(far) < NEAR {
                return;
            }
        }
        for i in 0..value.len() {
            u[i] = s.div_f64s(q, multiply_add(s, value[i], m, c));
            a[i] = s.mul_f64s(s.mul_f64s(s.mul_f64s(slope[i], half), u[i]), u[i]);
        }
    }

    /// The same program on pairs. Only for programs of pure arithmetic.
    #[inline(always)]
    fn refine<S: Simd>(&mut self, s: S, [x, x_lo]: [&[f64]; 2], [a, u]: [&[f64]; 2], [da, du]: [&mut [f64]; 2]) {
        copy::<S>(x, &mut self.registers[0].0);
        if self.lacks.is_empty() {
            self.lacks.resize(self.registers.len(), Nodes::ZERO);
        }
        copy::<S>(x_lo, &mut self.lacks[0].0);
        let mut k = 0;
        while k < self.steps.len() {
            let step = self.steps[k];
            let (done, out) = self.registers.split_at_mut(self.first_step + k);
            let (done_lo, out_lo) = self.lacks.split_at_mut(self.first_step + k);
            k += 1;
            let (i, j) = match step {
                Instruction::Add(i, j)
                | Instruction::Subtract(i, j)
                | Instruction::Multiply(i, j)
                | Instruction::Divide(i, j) => (i, j),
                Instruction::Negate(i) => (i, i),
                _ => unreachable!("only arithmetic is refined"),
            };
            let (p, p_lo) = (vectors::<S>(&done[i].0), vectors::<S>(&done_lo[i].0));
            let (q, q_lo) = (vectors::<S>(&done[j].0), vectors::<S>(&done_lo[j].0));
            let (y, y_lo) = (vectors_mut::<S>(&mut out[0].0), vectors_mut::<S>(&mut out_lo[0].0));
            for n in 0..y.len() {
                (y[n], y_lo[n]) = match step {
                    Instruction::Add(..) => {
                        let (sum, error) = two_sum(s, p[n], q[n]);
                        (sum, s.add_f64s(error, s.add_f64s(p_lo[n], q_lo[n])))
                    }
                    Instruction::Subtract(..) => {
                        let (sum, error) = two_sum(s, p[n], neg(s, q[n]));
                        (sum, s.add_f64s(error, s.sub_f64s(p_lo[n], q_lo[n])))
                    }
                    Instruction::Multiply(..) => {
                        let y = s.mul_f64s(p[n], q[n]);
                        let error = product_error(s, p[n], q[n], y);
                        (y, multiply_add(s, p[n], q_lo[n], multiply_add(s, p_lo[n], q[n], error)))
                    }
                    Instruction::Divide(..) => {
                        // (p + p_lo − y (q + q_lo))/q with the remainder formed exactly
                        let y = s.div_f64s(p[n], q[n]);
                        let yq = s.mul_f64s(y, q[n]);
                        let r = s.sub_f64s(s.sub_f64s(p[n], yq), product_error(s, y, q[n], yq));
                        let r = s.add_f64s(r, s.sub_f64s(p_lo[n], s.mul_f64s(y, q_lo[n])));
                        (y, s.div_f64s(r, q[n]))
                    }
                    _ => (neg(s, p[n]), neg(s, p_lo[n])),
                };
            }
        }
        let value = vectors::<S>(&self.registers[self.value].0);
        let value_lo = vectors::<S>(&self.lacks[self.value].0);
        let slope = vectors::<S>(&self.registers[self.slope].0);
        let slope_lo = vectors::<S>(&self.lacks[self.slope].0);
        let (a, u) = (vectors::<S>(a), vectors::<S>(u));
        let (da, du) = (vectors_mut::<S>(da), vectors_mut::<S>(du));
        let (m, c) = (s.splat_f64s(self.two_over_mass), s.splat_f64s(self.c_squared));
        let half = s.splat_f64s(-0.5 * self.two_over_mass);
        for i in 0..a.len() {
            let p = s.mul_f64s(value[i], m);
            let (g, error) = two_sum(s, p, c);
            let p_lo = multiply_add(s, value_lo[i], m, product_error(s, value[i], m, p));
            let d = s.mul_f64s(slope[i], half);
            let d_lo = multiply_add(s, slope_lo[i], half, product_error(s, slope[i], half, d));
            (da[i], du[i]) = corrections(s, self.q_t, (g, s.add_f64s(error, p_lo)), (d, d_lo), a[i], u[i]);
        }
    }
}
