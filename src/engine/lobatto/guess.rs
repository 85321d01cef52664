//! Where the iteration of a window starts.

use pulp::Simd;

use super::tables::{Matrix, Tables};
use crate::number::vector::{Nodes, multiply_add, vectors, vectors_mut};

/// Where the iteration starts.
#[derive(Clone, Copy)]
pub(super) enum Guess<'a, const P: usize> {
    /// At the parabola through the start.
    Parabola,
    /// By the tables' own extrapolation from the window before.
    Same,
    /// At the forces of a window of any length, continued as a polynomial.
    Continued { from: &'a Continuation<'a, P>, values: &'a Nodes<P> },
}

/// A polynomial through the nodal values of one window on the nodes of another: at z = `first` + `step` c_i on [−1, 1].
pub(super) struct Continuation<'a, const P: usize> {
    /// Column j is what node j adds to the Legendre coefficients.
    pub(super) modes: &'a Matrix<P>,
    /// (2k + 1)/(k + 1) and k/(k + 1): P_{k+1} = the one z P_k − the other P_{k−1}.
    pub(super) recurrence: &'a [[f64; 2]],
    pub(super) degree: usize,
    pub(super) first: f64,
    pub(super) step: f64,
    /// What the values are multiplied by.
    pub(super) factor: f64,
}

impl<const P: usize> Continuation<'_, P> {
    /// From the Legendre coefficients in `values` to nodal values.
    #[inline(always)]
    pub(super) fn apply<S: Simd>(&self, s: S, t: &Tables<P>, values: &mut Nodes<P>) {
        let coefficients = *values;
        let (first, step) = (s.splat_f64s(self.first), s.splat_f64s(self.step / t.length.hi));
        let factor = s.splat_f64s(self.factor);
        let (line, out) = (vectors::<S>(&t.line), vectors_mut::<S>(&mut values.0));
        for i in 0..out.len() {
            // Clenshaw's recurrence
            let z = multiply_add(s, line[i], step, first);
            let (mut b, mut before) = (s.splat_f64s(0.0), s.splat_f64s(0.0));
            for k in (0..=self.degree).rev() {
                let c = s.splat_f64s(coefficients.0[k]);
                let c = multiply_add(s, s.splat_f64s(-self.recurrence[k + 1][1]), before, c);
                before = b;
                b = multiply_add(s, s.mul_f64s(s.splat_f64s(self.recurrence[k][0]), z), b, c);
            }
            out[i] = s.mul_f64s(b, factor);
        }
    }
}
