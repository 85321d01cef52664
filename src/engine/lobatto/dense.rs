//! Points inside a window, from the integrals of the polynomials that u and a are on its nodes.
//!
//! On [0, 1], with z = 2s − 1 and P_{−1} = −1, ∫_0^s P_k = (P_{k+1}(z) − P_{k−1}(z))/(2(2k + 1)).

use pulp::{Simd, WithSimd};

use super::product::product_apart;
use super::unit::{Unit, with_unit};
use super::view::{Inside, WindowView};
use crate::number::vector::{Level, Nodes, multiply_add, neg, vectors, vectors_mut};
use crate::sbp::collocation::share;

/// Points that are computed together.
const TOGETHER: usize = 16;

impl WindowView<'_> {
    /// Hands out t, x and w at `fractions` (0 to 1) of the window: the dense output.
    ///
    /// They are the integrals of the polynomials that u and a are on the nodes: of order n + 1, without an evaluation
    /// of the potential; at 1 it is the end of the window, of order 2n − 2. `sampling` keeps that order inside
    /// too, at a hundred times the cost.
    pub fn inside(&self, fractions: impl IntoIterator<Item = f64>, mut see: impl FnMut(Inside)) {
        let mut fractions = fractions.into_iter().fuse();
        let mut fill = |at: &mut [f64; TOGETHER]| {
            let mut count = 0;
            for (at, fraction) in at.iter_mut().zip(&mut fractions) {
                *at = fraction;
                count += 1;
            }
            count
        };
        blocks(self, &mut fill, &mut |points| points.iter().copied().for_each(&mut see));
    }
}

/// Points in blocks of at most [`TOGETHER`]: `fill` says how many fractions it has put into one, 0 at the end; `see`
/// gets the points there. What is compiled for every number of nodes knows neither type, so that nothing of it is
/// compiled again where they differ.
fn blocks(view: &WindowView<'_>, fill: &mut dyn FnMut(&mut [f64; TOGETHER]) -> usize, see: &mut dyn FnMut(&[Inside])) {
    let (t0, x0, w0, end) = (view.start.t, view.start.x, view.start.w, view.end);
    let [t_scale, w_scale] = view.scales();
    let h = view.length.hi;
    let x_scale = h * w_scale;
    with_unit!(view.rule, unit => {
        let mut integrals = None;
        loop {
            let mut at = Nodes::<TOGETHER>::ZERO;
            let count = fill(&mut at.0);
            if count == 0 {
                break;
            }
            let mut series = [const { Nodes::ZERO }; 3];
            if at.0[..count].iter().any(|&fraction| fraction != 1.0) {
                let series = Series { unit, view, integrals: &mut integrals, at: &at, count, out: &mut series };
                Level::Best.dispatch(series);
            }
            let [t, x, w] = &series;
            let mut points = [Inside::default(); TOGETHER];
            for (i, point) in points[..count].iter_mut().enumerate() {
                let fraction = at.0[i];
                *point = if fraction == 1.0 {
                    Inside { t: end.t.hi, x: end.x.hi, w: end.w.hi }
                } else {
                    Inside {
                        t: t0.hi + (t0.lo + t_scale * t.0[i]),
                        x: x0.hi + (x0.lo + (fraction * h * w0.hi + x_scale * x.0[i])),
                        w: w0.hi + (w0.lo + w_scale * w.0[i]),
                    }
                };
            }
            see(&points[..count]);
        }
    });
}

/// Factors of P_{k+1} − P_{k−1}, k = 0 … n, in ∫u, ∫a and ∬a; only the last goes to n.
struct Integrals<const P: usize> {
    t: Nodes<P>,
    w: Nodes<P>,
    x: Nodes<P>,
    x_last: f64,
}

/// ∫u, ∬a and ∫a over [0, s] for the first `count` of `at`: the work that is compiled for every level.
struct Series<'r, const P: usize> {
    unit: &'r Unit<P>,
    view: &'r WindowView<'r>,
    /// Made with the first points.
    integrals: &'r mut Option<Integrals<P>>,
    at: &'r Nodes<TOGETHER>,
    count: usize,
    out: &'r mut [Nodes<TOGETHER>; 3],
}

impl<const P: usize> WithSimd for Series<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { unit, view, integrals, at, count, out } = self;
        let integrals = integrals.get_or_insert_with(
            #[inline(always)]
            || unit.integrate(s, [view.nodes.u, view.nodes.a]),
        );
        unit.series(s, integrals, at, count, out);
    }
}

impl<const P: usize> Unit<P> {
    #[inline(always)]
    fn integrate<S: Simd>(&self, s: S, nodal: [&[f64]; 2]) -> Integrals<P> {
        let n = self.tables.points;
        let [mut t, mut w] = [Nodes::<P>::ZERO, Nodes::<P>::ZERO];
        for k in 0..2 {
            let (values, out) = if k == 0 { (nodal[0], &mut t) } else { (nodal[1], &mut w) };
            let mut padded = Nodes::<P>::ZERO;
            padded.0[..n].copy_from_slice(values);
            product_apart(s, &[0.0; P], &self.modes[..self.tables.columns], &padded.0, &mut out.0);
            let (shares, out) = (vectors::<S>(&self.shares.0), vectors_mut::<S>(&mut out.0));
            for i in 0..out.len() {
                out[i] = s.mul_f64s(out[i], shares[i]);
            }
        }
        // What stands at P_k in Σ w_k (P_{k+1} − P_{k−1}).
        let mut x = Nodes::<P>::ZERO;
        x.0[0] = w.0[0] - w.0[1];
        for k in 1..P - 1 {
            x.0[k] = w.0[k - 1] - w.0[k + 1];
        }
        x.0[P - 1] = w.0[P - 2];
        for k in 0..P {
            x.0[k] *= self.shares.0[k];
        }
        Integrals { x_last: w.0[n - 1] * share(n), t, w, x }
    }

    #[inline(always)]
    fn series<S: Simd>(
        &self,
        s: S,
        c: &Integrals<P>,
        at: &Nodes<TOGETHER>,
        count: usize,
        out: &mut [Nodes<TOGETHER>; 3],
    ) {
        let vectors = count.div_ceil(S::F64_LANES);
        let mut i = 0;
        while i + 2 <= vectors {
            self.block::<S, 2>(s, c, at, i, out);
            i += 2;
        }
        if i < vectors {
            self.block::<S, 1>(s, c, at, i, out);
        }
    }

    /// The same on G vectors from the `i`-th on.
    #[inline(always)]
    fn block<S: Simd, const G: usize>(
        &self,
        s: S,
        c: &Integrals<P>,
        at: &Nodes<TOGETHER>,
        i: usize,
        out: &mut [Nodes<TOGETHER>; 3],
    ) {
        let (one, zero) = (s.splat_f64s(1.0), s.splat_f64s(0.0));
        let at = &vectors::<S>(&at.0)[i..i + G];
        let mut z = [zero; G];
        for g in 0..G {
            z[g] = s.sub_f64s(s.add_f64s(at[g], at[g]), one);
        }
        let (mut p, mut before) = ([one; G], [neg(s, one); G]);
        let (mut t, mut x, mut w) = ([zero; G], [zero; G], [zero; G]);
        let n = self.tables.points;
        for k in 0..=n {
            let [next, last] = self.recurrence[k];
            let (next, last) = (s.splat_f64s(next), s.splat_f64s(-last));
            let is_last = k == n;
            let x_factor = s.splat_f64s(if is_last { c.x_last } else { c.x.0[k] });
            for g in 0..G {
                let after = multiply_add(s, s.mul_f64s(next, z[g]), p[g], s.mul_f64s(last, before[g]));
                let difference = s.sub_f64s(after, before[g]);
                x[g] = multiply_add(s, x_factor, difference, x[g]);
                if !is_last {
                    t[g] = multiply_add(s, s.splat_f64s(c.t.0[k]), difference, t[g]);
                    w[g] = multiply_add(s, s.splat_f64s(c.w.0[k]), difference, w[g]);
                }
                (before[g], p[g]) = (p[g], after);
            }
        }
        let values = [t, x, w];
        for k in 0..3 {
            let out = &mut vectors_mut::<S>(&mut out[k].0)[i..i + G];
            let mut g = 0;
            while g < G {
                out[g] = values[k][g];
                g += 1;
            }
        }
    }
}
