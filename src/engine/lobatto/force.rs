//! What drives the motion, a(x) = −½ g00′(x) u² with u = Q_t/g00(x), on all nodes of a window at once.

use pulp::{Simd, WithSimd};

#[cfg(doc)]
use crate::formula::Program;
use crate::geometry::metric::Metric;
use crate::number::vector::{abs, is_fused, multiply_add, neg, product_error, two_sum, vectors, vectors_mut};

/// The force of a potential. All slices have the padded length of a window, a multiple of 8.
pub(super) trait Force {
    /// Sets the charge from now on, and how many of the nodes count.
    fn set(&mut self, q_t: f64, points: usize);

    /// Whether [`Self::refine`] can do anything.
    fn refines(&self) -> bool;

    /// Fills `a` and `u` at `x`. If `near`, `u` holds the values at points close by, to start Newton's method from.
    fn evaluate<S: Simd>(&mut self, s: S, x: &[f64], a: &mut [f64], u: &mut [f64], near: bool);

    /// Whether an evaluation costs so much more than a matrix–vector product that computing slopes pays off.
    fn is_dear(&self) -> bool;

    /// Whether that is possible at all: otherwise nothing is compiled for it.
    const MAY_BE_DEAR: bool;

    /// From now on looks for what overflows on the way to finite values, see [`Program::mend_nodes`], or no longer.
    /// Whether that has changed anything since it was asked before; `None` where nothing overflows.
    fn mend(&mut self, _: bool) -> Option<bool> {
        None
    }

    /// da/dx and du/dx at the points of the last evaluation, which gave `a` and `u`.
    fn slopes<S: Simd>(&mut self, s: S, au: [&[f64]; 2], slopes: [&mut [f64]; 2]);

    /// What `a` and `u` lack because of rounding: a(x + x_lo) − a and u(x + x_lo) − u.
    fn refine<S: Simd>(&mut self, s: S, x: [&[f64]; 2], au: [&[f64]; 2], corrections: [&mut [f64]; 2]);
}

/// [`Force::evaluate`] as part of what it is called by; for single numbers out of line.
#[inline(always)]
pub(super) fn evaluate<S: Simd, F: Force>(s: S, force: &mut F, x: &[f64], a: &mut [f64], u: &mut [f64], near: bool) {
    if S::IS_SCALAR {
        evaluate_apart(s, force, x, [a, u], near);
    } else {
        force.evaluate(s, x, a, u, near);
    }
}

/// The same, compiled once for each level and force: for what is done once in a window, or costs much more.
#[inline(never)]
pub(super) fn evaluate_apart<S: Simd, F: Force>(s: S, force: &mut F, x: &[f64], au: [&mut [f64]; 2], near: bool) {
    s.vectorize(Evaluation { force, x, au, near });
}

struct Evaluation<'r, F> {
    force: &'r mut F,
    x: &'r [f64],
    au: [&'r mut [f64]; 2],
    near: bool,
}

impl<F: Force> WithSimd for Evaluation<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { force, x, au: [a, u], near } = self;
        force.evaluate(s, x, a, u, near);
    }
}

/// g00 = Σ c_k x^k, for every polynomial potential.
#[derive(Debug, Clone)]
pub(super) struct PolynomialForce {
    q_t: f64,
    /// The c_k, then the coefficients of d = −½ g00′, as many with a last one 0; a = d u².
    coefficients: Vec<f64>,
    /// Both again up to degree four.
    low: Option<[[f64; 5]; 2]>,
}

/// The largest relative change of u for which one Newton step is enough.
pub(super) const NEAR: f64 = 0.1;

impl PolynomialForce {
    pub(super) fn new(metric: &Metric, q_t: f64, coefficients: &[f64]) -> Self {
        let mut degree = coefficients.len().saturating_sub(1);
        while degree > 0 && coefficients[degree] == 0.0 {
            degree -= 1;
        }
        let mut all = vec![0.0; 2 * (degree + 1)];
        let (g, d) = all.split_at_mut(degree + 1);
        for (g, c) in g.iter_mut().zip(coefficients) {
            *g = metric.two_over_mass() * c;
        }
        g[0] += metric.c_squared();
        for k in 0..degree {
            d[k] = -0.5 * (k + 1) as f64 * g[k + 1];
        }
        let mut low = None;
        if degree < 5 {
            let mut both = [[0.0; 5]; 2];
            for k in 0..=degree {
                (both[0][k], both[1][k]) = (g[k], d[k]);
            }
            low = Some(both);
        }
        Self { q_t, coefficients: all, low }
    }

    /// g and d on G vectors from the `i`-th on; up to degree four in half the time of Horner's rule, by Estrin's
    /// scheme.
    #[inline(always)]
    fn values<S: Simd, const G: usize>(&self, s: S, x: &[S::f64s], i: usize) -> ([S::f64s; G], [S::f64s; G]) {
        let Some([g, d]) = &self.low else { return self.horner(s, x, i) };
        let mut out = ([s.splat_f64s(0.0); G], [s.splat_f64s(0.0); G]);
        let x = &x[i..i + G];
        for j in 0..G {
            let x = x[j];
            let square = s.mul_f64s(x, x);
            let high = multiply_add(s, s.splat_f64s(g[4]), square, pair(s, &g[2..], x));
            out.0[j] = multiply_add(s, high, square, pair(s, g, x));
            out.1[j] = multiply_add(s, pair(s, &d[2..], x), square, pair(s, d, x));
        }
        out
    }

    /// g and d on G vectors from the `i`-th on, by Horner's rule: G independent chains hide its latency.
    #[inline(always)]
    fn horner<S: Simd, const G: usize>(&self, s: S, x: &[S::f64s], i: usize) -> ([S::f64s; G], [S::f64s; G]) {
        let zero = s.splat_f64s(0.0);
        let (mut g, mut d) = ([zero; G], [zero; G]);
        let x = &x[i..i + G];
        let (all_g, all_d) = self.coefficients.split_at(self.coefficients.len() / 2);
        let mut k = all_g.len();
        while k > 0 {
            k -= 1;
            let (c, e) = (s.splat_f64s(all_g[k]), s.splat_f64s(all_d[k]));
            for j in 0..G {
                g[j] = multiply_add(s, g[j], x[j], c);
                d[j] = multiply_add(s, d[j], x[j], e);
            }
        }
        (g, d)
    }

    /// a and u on G vectors, by one Newton step or a division; the largest relative change of u.
    #[inline(always)]
    fn block<S: Simd, const G: usize>(
        &self,
        s: S,
        x: &[S::f64s],
        a: &mut [S::f64s],
        u: &mut [S::f64s],
        i: usize,
        far: &mut Option<S::f64s>,
    ) {
        let q = s.splat_f64s(self.q_t);
        let (g, d) = self.values::<S, G>(s, x, i);
        let (a, u) = (&mut a[i..i + G], &mut u[i..i + G]);
        for j in 0..G {
            match far {
                Some(far) => {
                    // As good as the iteration itself: x has moved by δ, the step leaves O(δ²). The residual has one
                    // rounding only, so that at convergence u is as accurate as by division.
                    let r = multiply_add(s, neg(s, g[j]), u[j], q);
                    let r = s.mul_f64s(r, s.splat_f64s(1.0 / self.q_t));
                    *far = s.max_f64s(*far, abs(s, r));
                    u[j] = multiply_add(s, r, u[j], u[j]);
                }
                None => u[j] = s.div_f64s(q, g[j]),
            }
            a[j] = s.mul_f64s(s.mul_f64s(d[j], u[j]), u[j]);
        }
    }
}

impl Force for PolynomialForce {
    #[inline]
    fn set(&mut self, q_t: f64, _points: usize) {
        self.q_t = q_t;
    }

    #[inline(always)]
    fn refines(&self) -> bool {
        true
    }

    const MAY_BE_DEAR: bool = false;

    #[inline(always)]
    fn is_dear(&self) -> bool {
        false
    }

    fn slopes<S: Simd>(&mut self, _: S, _: [&[f64]; 2], _: [&mut [f64]; 2]) {
        unreachable!("cheap forces are evaluated instead")
    }

    #[inline(always)]
    fn evaluate<S: Simd>(&mut self, s: S, x: &[f64], a: &mut [f64], u: &mut [f64], near: bool) {
        let (x, a, u) = (vectors::<S>(x), vectors_mut::<S>(a), vectors_mut::<S>(u));
        let mut newton = near && is_fused::<S>() && self.q_t != 0.0;
        loop {
            let mut far = if newton { Some(s.splat_f64s(0.0)) } else { None };
            let mut i = 0;
            if x.len().is_multiple_of(3) {
                while i < x.len() {
                    self.block::<S, 3>(s, x, a, u, i, &mut far);
                    i += 3;
                }
            }
            while i + 2 <= x.len() {
                self.block::<S, 2>(s, x, a, u, i, &mut far);
                i += 2;
            }
            if i < x.len() {
                self.block::<S, 1>(s, x, a, u, i, &mut far);
            }
            let far = match far {
                Some(far) => s.reduce_max_f64s(far),
                None => 0.0,
            };
            if far < NEAR {
                return;
            }
            newton = false;
        }
    }

    /// Compensated Horner scheme (Graillat, Langlois, Louvet 2009, "Algorithms for accurate, validated and fast
    /// polynomial evaluation").
    #[inline(always)]
    fn refine<S: Simd>(&mut self, s: S, [x, x_lo]: [&[f64]; 2], [a, u]: [&[f64]; 2], [da, du]: [&mut [f64]; 2]) {
        let (x, x_lo) = (vectors::<S>(x), vectors::<S>(x_lo));
        let (a, u) = (vectors::<S>(a), vectors::<S>(u));
        let (da, du) = (vectors_mut::<S>(da), vectors_mut::<S>(du));
        let (g, d) = self.coefficients.split_at(self.coefficients.len() / 2);
        for i in 0..x.len() {
            let g = compensated_horner(s, g, x[i], x_lo[i]);
            let d = compensated_horner(s, d, x[i], x_lo[i]);
            (da[i], du[i]) = corrections(s, self.q_t, g, d, a[i], u[i]);
        }
    }
}

/// c_0 + c_1 x.
#[inline(always)]
fn pair<S: Simd>(s: S, c: &[f64], x: S::f64s) -> S::f64s {
    multiply_add(s, s.splat_f64s(c[1]), x, s.splat_f64s(c[0]))
}

/// Σ c_k (x + x_lo)^k as (value, what it lacks).
#[inline(always)]
fn compensated_horner<S: Simd>(s: S, c: &[f64], x: S::f64s, x_lo: S::f64s) -> (S::f64s, S::f64s) {
    let mut k = c.len() - 1;
    let mut value = s.splat_f64s(c[k]);
    let mut lack = s.splat_f64s(0.0);
    while k > 0 {
        k -= 1;
        let p = s.mul_f64s(value, x);
        let error = product_error(s, value, x, p);
        lack = multiply_add(s, lack, x, multiply_add(s, value, x_lo, error));
        if c[k] == 0.0 {
            value = p;
        } else {
            let (sum, error) = two_sum(s, p, s.splat_f64s(c[k]));
            value = sum;
            lack = s.add_f64s(lack, error);
        }
    }
    (value, lack)
}

/// What a and u lack, given g00 and d = −½ g00′ as pairs. No division: 1/g00 = u/Q_t is good enough for a correction.
#[inline(always)]
pub(super) fn corrections<S: Simd>(
    s: S,
    q_t: f64,
    g: (S::f64s, S::f64s),
    d: (S::f64s, S::f64s),
    a: S::f64s,
    u: S::f64s,
) -> (S::f64s, S::f64s) {
    if q_t == 0.0 {
        return (s.splat_f64s(0.0), s.splat_f64s(0.0));
    }
    // du = (Q_t − u g)/g with the residual formed exactly.
    let p = s.mul_f64s(u, g.0);
    let r = s.sub_f64s(s.sub_f64s(s.splat_f64s(q_t), p), product_error(s, u, g.0, p));
    let r = s.sub_f64s(r, s.mul_f64s(u, g.1));
    let du = s.mul_f64s(r, s.mul_f64s(u, s.splat_f64s(1.0 / q_t)));
    // (d + d_lo)(u + du)², less the rounded a.
    let p = s.mul_f64s(u, u);
    let p_lo = multiply_add(s, s.add_f64s(u, u), du, product_error(s, u, u, p));
    let m = s.mul_f64s(d.0, p);
    let m_lo = multiply_add(s, d.0, p_lo, multiply_add(s, d.1, p, product_error(s, d.0, p, m)));
    (s.add_f64s(s.sub_f64s(m, a), m_lo), du)
}
