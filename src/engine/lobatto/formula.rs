//! The force of a formula: an interpreter of its program on vectors, compiled into the march itself.

use pulp::{Simd, WithSimd};

use super::force::{Force, NEAR, corrections};
use crate::formula::{Algebra, Function, Fused, Operation, Program, Step, run};
use crate::geometry::metric::Metric;
use crate::number::vector::{
    Nodes, abs, copy, elementary, is_fused, multiply_add, neg, product_error, two_sum, vectors, vectors_mut,
};

/// g00 and its derivatives by the program of V, a step for all nodes at once. Constants are registers that were filled
/// once.
#[derive(Debug, Clone)]
pub(super) struct FormulaForce<'m, const P: usize> {
    q_t: f64,
    c_squared: f64,
    two_over_mass: f64,
    program: &'m Program<f64>,
    registers: Vec<Nodes<P>>,
    /// The registers of `refine`, which not every run asks for.
    pairs: Vec<Pair<P>>,
    points: usize,
    /// The first flag is true if values that overflow on the way are mended, the second if one was.
    mends: bool,
    is_mended: bool,
    /// Whether it calls functions, which take longer than all arithmetic.
    is_dear: bool,
}

impl<'m, const P: usize> FormulaForce<'m, P> {
    /// For windows of `points` nodes.
    pub(super) fn new(metric: &Metric, q_t: f64, program: &'m Program<f64>, points: usize) -> Self {
        let is_function = |operation| matches!(operation, Operation::Power(..) | Operation::Call(..));
        Self {
            q_t,
            c_squared: metric.c_squared(),
            two_over_mass: metric.two_over_mass(),
            is_dear: program.steps_to(2).iter().any(|step| is_function(step.operation())),
            program,
            registers: program.registers(|constant| Nodes([constant; P])),
            pairs: Vec::new(),
            points,
            mends: false,
            is_mended: false,
        }
    }

    /// Mends the first outputs, if that is wanted.
    #[inline(always)]
    fn mend_first(&mut self, outputs: usize) {
        if self.mends {
            self.is_mended |= self.program.mend_nodes(outputs, P, &mut self.registers);
        }
    }

    fn output(&self, index: usize) -> &[f64; P] {
        &self.registers[self.program.output(index)].0
    }
}

/// The nodes of a window in every register.
struct Vectors<S, const P: usize>(S);

/// Carries out steps of a program on all nodes. The loops over nodes are long code: they are compiled once for each
/// level and length, not wherever a program is run.
#[inline(never)]
pub(super) fn carry_out<S: Simd, const P: usize>(s: S, steps: &[Step], registers: &mut [Nodes<P>]) {
    s.vectorize(CarryOut { steps, registers });
}

struct CarryOut<'r, const P: usize> {
    steps: &'r [Step],
    registers: &'r mut [Nodes<P>],
}

impl<const P: usize> WithSimd for CarryOut<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        run(&Vectors(s), self.steps, self.registers);
    }
}

/// `to` = `$operation` of a and b, vector by vector.
macro_rules! on_vectors {
    ($algebra:expr, $to:expr, $a:expr, $b:expr, $operation:ident) => {{
        let s = $algebra.0;
        let (p, q) = (vectors::<S>(&$a.0), vectors::<S>(&$b.0));
        let out = vectors_mut::<S>(&mut $to.0);
        for n in 0..out.len() {
            out[n] = s.$operation(p[n], q[n]);
        }
    }};
}

impl<S: Simd, const P: usize> Algebra for Vectors<S, P> {
    type Value = Nodes<P>;

    #[inline(always)]
    fn add(&self, to: &mut Nodes<P>, a: &Nodes<P>, b: &Nodes<P>) {
        on_vectors!(self, to, a, b, add_f64s);
    }

    #[inline(always)]
    fn subtract(&self, to: &mut Nodes<P>, a: &Nodes<P>, b: &Nodes<P>) {
        on_vectors!(self, to, a, b, sub_f64s);
    }

    #[inline(always)]
    fn multiply(&self, to: &mut Nodes<P>, a: &Nodes<P>, b: &Nodes<P>) {
        on_vectors!(self, to, a, b, mul_f64s);
    }

    #[inline(always)]
    fn divide(&self, to: &mut Nodes<P>, a: &Nodes<P>, b: &Nodes<P>) {
        on_vectors!(self, to, a, b, div_f64s);
    }

    #[inline(always)]
    fn negate(&self, to: &mut Nodes<P>, a: &Nodes<P>) {
        let (p, out) = (vectors::<S>(&a.0), vectors_mut::<S>(&mut to.0));
        for n in 0..out.len() {
            out[n] = neg(self.0, p[n]);
        }
    }

    #[inline(always)]
    fn power(&self, to: &mut Nodes<P>, a: &Nodes<P>, b: &Nodes<P>) {
        elementary::power(self.0, &a.0, &b.0, &mut to.0);
    }

    #[inline(always)]
    fn call(&self, to: &mut Nodes<P>, function: Function, a: &Nodes<P>) {
        elementary::call(self.0, function, &a.0, &mut to.0);
    }

    #[inline(always)]
    fn fused(&self, to: &mut Nodes<P>, fused: Fused, operands: [&Nodes<P>; 3]) {
        let s = self.0;
        let [p, q, r] = operands.map(|operand| vectors::<S>(&operand.0));
        let out = vectors_mut::<S>(&mut to.0);
        for n in 0..out.len() {
            out[n] = match fused {
                Fused::Add => multiply_add(s, p[n], q[n], r[n]),
                Fused::Subtract => multiply_add(s, p[n], q[n], neg(s, r[n])),
                Fused::SubtractFrom => multiply_add(s, neg(s, p[n]), q[n], r[n]),
            };
        }
    }

    #[inline(always)]
    fn sin_cos(&self, sin: &mut Nodes<P>, cos: &mut Nodes<P>, a: &Nodes<P>) {
        elementary::sin_cos(self.0, &a.0, [&mut sin.0, &mut cos.0]);
    }
}

/// The nodes of a value, and of what it lacks.
type Pair<const P: usize> = [Nodes<P>; 2];

/// Values and what they lack in every register: the pairs add up to about twice the digits. Only arithmetic.
struct Pairs<S, const P: usize>(S);

/// `$body` for the pairs p and q of a and b gives that of `to`.
macro_rules! on_pairs {
    ($algebra:expr, $to:expr, $a:expr, $b:expr, |$s:ident, $p:ident, $q:ident| $body:expr) => {{
        let $s = $algebra.0;
        let (p, p_lo) = (vectors::<S>(&$a[0].0), vectors::<S>(&$a[1].0));
        let (q, q_lo) = (vectors::<S>(&$b[0].0), vectors::<S>(&$b[1].0));
        let [y, y_lo] = $to;
        let (y, y_lo) = (vectors_mut::<S>(&mut y.0), vectors_mut::<S>(&mut y_lo.0));
        for n in 0..y.len() {
            let ($p, $q) = ((p[n], p_lo[n]), (q[n], q_lo[n]));
            (y[n], y_lo[n]) = $body;
        }
    }};
}

impl<S: Simd, const P: usize> Algebra for Pairs<S, P> {
    type Value = Pair<P>;

    #[inline(always)]
    fn add(&self, to: &mut Pair<P>, a: &Pair<P>, b: &Pair<P>) {
        on_pairs!(self, to, a, b, |s, p, q| {
            let (sum, error) = two_sum(s, p.0, q.0);
            (sum, s.add_f64s(error, s.add_f64s(p.1, q.1)))
        });
    }

    #[inline(always)]
    fn subtract(&self, to: &mut Pair<P>, a: &Pair<P>, b: &Pair<P>) {
        on_pairs!(self, to, a, b, |s, p, q| {
            let (sum, error) = two_sum(s, p.0, neg(s, q.0));
            (sum, s.add_f64s(error, s.sub_f64s(p.1, q.1)))
        });
    }

    #[inline(always)]
    fn multiply(&self, to: &mut Pair<P>, a: &Pair<P>, b: &Pair<P>) {
        on_pairs!(self, to, a, b, |s, p, q| {
            let y = s.mul_f64s(p.0, q.0);
            let error = product_error(s, p.0, q.0, y);
            (y, multiply_add(s, p.0, q.1, multiply_add(s, p.1, q.0, error)))
        });
    }

    #[inline(always)]
    fn divide(&self, to: &mut Pair<P>, a: &Pair<P>, b: &Pair<P>) {
        on_pairs!(self, to, a, b, |s, p, q| {
            // (p + p_lo − y (q + q_lo))/q with the remainder formed exactly
            let y = s.div_f64s(p.0, q.0);
            let yq = s.mul_f64s(y, q.0);
            let r = s.sub_f64s(s.sub_f64s(p.0, yq), product_error(s, y, q.0, yq));
            let r = s.add_f64s(r, s.sub_f64s(p.1, s.mul_f64s(y, q.1)));
            (y, s.div_f64s(r, q.0))
        });
    }

    #[inline(always)]
    fn negate(&self, to: &mut Pair<P>, a: &Pair<P>) {
        on_pairs!(self, to, a, a, |s, p, _q| (neg(s, p.0), neg(s, p.1)));
    }

    fn power(&self, _: &mut Pair<P>, _: &Pair<P>, _: &Pair<P>) {
        unreachable!("only arithmetic is refined");
    }

    fn call(&self, _: &mut Pair<P>, _: Function, _: &Pair<P>) {
        unreachable!("only arithmetic is refined");
    }
}

impl<const P: usize> Force for FormulaForce<'_, P> {
    #[inline]
    fn set(&mut self, q_t: f64, points: usize) {
        (self.q_t, self.points) = (q_t, points);
    }

    #[inline(always)]
    fn refines(&self) -> bool {
        !self.is_dear
    }

    fn mend(&mut self, mends: bool) -> Option<bool> {
        self.mends = mends;
        Some(std::mem::take(&mut self.is_mended))
    }

    const MAY_BE_DEAR: bool = true;

    #[inline(always)]
    fn is_dear(&self) -> bool {
        self.is_dear && self.q_t != 0.0
    }

    #[inline(always)]
    fn slopes<S: Simd>(&mut self, s: S, [a, u]: [&[f64]; 2], [da, du]: [&mut [f64]; 2]) {
        let known = self.program.steps_to(2).len();
        carry_out(s, &self.program.steps_to(3)[known..], &mut self.registers);
        self.mend_first(3);
        // With a = −½ g00′ u²: du/dx = 2 a/Q_t and da/dx = −½ g00″ u² + 4 a²/(Q_t u).
        let half = s.splat_f64s(-0.5 * self.two_over_mass);
        let reciprocal = s.splat_f64s(2.0 / self.q_t);
        let curvature = vectors::<S>(self.output(2));
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
        carry_out(s, self.program.steps_to(2), &mut self.registers);
        self.mend_first(2);
        let (q, m, c) = (s.splat_f64s(self.q_t), s.splat_f64s(self.two_over_mass), s.splat_f64s(self.c_squared));
        let half = s.splat_f64s(-0.5 * self.two_over_mass);
        let value = vectors::<S>(self.output(0));
        let slope = vectors::<S>(self.output(1));
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
    fn refine<S: Simd>(
        &mut self,
        s: S,
        [x, x_lo]: [&[f64]; 2],
        [a, u]: [&[f64]; 2],
        [da_row, du_row]: [&mut [f64]; 2],
    ) {
        let Self { program, pairs, .. } = self;
        if pairs.is_empty() {
            *pairs = program.registers(|constant| [Nodes([constant; P]), Nodes::ZERO]);
        }
        copy::<S>(x, &mut pairs[0][0].0);
        copy::<S>(x_lo, &mut pairs[0][1].0);
        run(&Pairs(s), program.steps_to(2), pairs);
        let [value, value_lo] = &pairs[program.output(0)];
        let [slope, slope_lo] = &pairs[program.output(1)];
        let (value, value_lo) = (vectors::<S>(&value.0), vectors::<S>(&value_lo.0));
        let (slope, slope_lo) = (vectors::<S>(&slope.0), vectors::<S>(&slope_lo.0));
        let (a, u) = (vectors::<S>(a), vectors::<S>(u));
        let (da, du) = (vectors_mut::<S>(da_row), vectors_mut::<S>(du_row));
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
        if self.mends {
            // What overflows has no more digits to offer.
            da_row.iter_mut().chain(du_row).filter(|lack| !lack.is_finite()).for_each(|lack| *lack = 0.0);
        }
    }
}
