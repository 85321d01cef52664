//! The gradient of the weak action at a window that was solved, in the window's own arrays.
//!
//! With v = g00 D̄t, w = D̄x and D̄ᵀH = −HD + E_N the gradient of E_weak with respect to one of two equal branches is
//!
//! ```text
//! ∂E/∂t = −H D̄(v − Q_t),     ∂E/∂x = H ( ½ g00′ (D̄t)² + D̄w ),
//! ```
//!
//! where D̄v stands for Dv + H⁻¹e_1 (v_1 − Q_t) and likewise for w: what the initial data of a field add. With the
//! forces at X, g00 = Q_t/u and ½ g00′ = −a/u². `action` computes the same for any operator and any two
//! branches.

use pulp::{Simd, WithSimd};

use super::State;
use super::force::{Force, evaluate_apart};
use super::product::product_apart;
use super::unit::Unit;
use super::view::Certified;
use super::window::Window;
use crate::number::vector::{Nodes, abs, copy, vectors, vectors_mut};

/// What an observer of certified windows gets besides the window.
#[derive(Debug, Clone)]
pub(super) struct Certificate<const P: usize> {
    /// t on the nodes, counted from the start of the window.
    elapsed: Nodes<P>,
    /// The largest entry of the gradient.
    gradient_norm: f64,
}

impl<const P: usize> Certificate<P> {
    pub(super) fn new() -> Self {
        Self { elapsed: Nodes::ZERO, gradient_norm: 0.0 }
    }

    /// For an observer, on the n nodes.
    pub(super) fn view(&self, n: usize) -> Certified<'_> {
        Certified { elapsed: &self.elapsed.0[..n], gradient_norm: self.gradient_norm }
    }
}

/// From D̄t and D̄x to v − Q_t and w − w_i.
#[inline(always)]
fn momenta<S: Simd, const P: usize>(
    s: S,
    [charge, stretch, w0]: [f64; 3],
    u: &Nodes<P>,
    slopes: &[Nodes<P>; 2],
    out: &mut [Nodes<P>; 2],
) {
    let [v, w] = out;
    let (v, w, u) = (vectors_mut::<S>(&mut v.0), vectors_mut::<S>(&mut w.0), vectors::<S>(&u.0));
    let (t_dot, x_dot) = (vectors::<S>(&slopes[0].0), vectors::<S>(&slopes[1].0));
    let (q, w0) = (s.splat_f64s(charge), s.splat_f64s(stretch * w0));
    for i in 0..u.len() {
        // Without a charge t does not move.
        let g00 = if charge == 0.0 { s.splat_f64s(0.0) } else { s.div_f64s(q, u[i]) };
        v[i] = s.sub_f64s(s.mul_f64s(g00, t_dot[i]), s.splat_f64s(stretch * charge));
        w[i] = s.sub_f64s(x_dot[i], w0);
    }
}

/// The work that is compiled for every level of instructions.
pub(super) struct Certify<'r, const P: usize, F> {
    pub(super) unit: &'r Unit<P>,
    /// For the charge `charge`.
    pub(super) force: &'r mut F,
    pub(super) charge: f64,
    pub(super) window: &'r Window<P>,
    /// In the parameter of the march, as everything in the window is.
    pub(super) start: &'r State,
    /// The length of the window in that parameter.
    pub(super) stretch: f64,
    /// Its length in γ.
    pub(super) length: f64,
    pub(super) out: &'r mut Certificate<P>,
}

impl<const P: usize, F: Force> WithSimd for Certify<'_, P, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { unit, force, charge, window, start, stretch, length, out } = self;
        let (mut a, mut u) = (Nodes::<P>::ZERO, Nodes::<P>::ZERO);
        // Afresh: the last sweep may have left the forces of the X before, and u by a step of Newton's method.
        evaluate_apart(s, force, &window.x.0, [&mut a.0, &mut u.0], false);
        // Fields of t and of x in turn: themselves, then their derivatives, then those of v and w.
        let mut fields = [const { Nodes::<P>::ZERO }; 2];
        let mut slopes = [const { Nodes::<P>::ZERO }; 2];
        let mut bends = [const { Nodes::<P>::ZERO }; 2];
        unit.integral(s, &window.u, stretch, &mut fields[0]);
        copy::<S>(&fields[0].0, &mut out.elapsed.0);
        {
            let (x, from) = (vectors_mut::<S>(&mut fields[1].0), vectors::<S>(&window.x.0));
            let x0 = s.splat_f64s(start.x.hi);
            for i in 0..x.len() {
                x[i] = s.sub_f64s(from[i], x0);
            }
        }
        // D̄ four times, in one place of the code.
        let mut k = 0;
        while k < 4 {
            if k == 2 {
                momenta(s, [charge, stretch, start.w.hi], &u, &slopes, &mut fields);
            }
            let to = if k < 2 { &mut slopes[k] } else { &mut bends[k - 2] };
            product_apart(s, &[0.0; P], &unit.derivative[..unit.tables.columns], &fields[k % 2].0, &mut to.0);
            k += 1;
        }
        let (mut most, mut sum) = (s.splat_f64s(0.0), s.splat_f64s(0.0));
        let (b, a, u) = (vectors::<S>(&unit.tables.weights), vectors::<S>(&a.0), vectors::<S>(&u.0));
        let (t_dot, v_dot, w_dot) = (vectors::<S>(&slopes[0].0), vectors::<S>(&bends[0].0), vectors::<S>(&bends[1].0));
        for i in 0..b.len() {
            // Without a charge there is no force.
            let ratio = if charge == 0.0 { s.splat_f64s(0.0) } else { s.div_f64s(t_dot[i], u[i]) };
            let force = s.mul_f64s(a[i], s.mul_f64s(ratio, ratio));
            let [t, x] = [s.mul_f64s(b[i], v_dot[i]), s.mul_f64s(b[i], s.sub_f64s(w_dot[i], force))];
            let larger = s.max_f64s(abs(s, t), abs(s, x));
            most = s.max_f64s(most, larger);
            // The maximum may lose a NaN.
            sum = s.add_f64s(sum, s.add_f64s(t, x));
        }
        let sum = s.reduce_sum_f64s(sum);
        out.gradient_norm = if sum.is_finite() { s.reduce_max_f64s(most) / length } else { f64::INFINITY };
    }
}
