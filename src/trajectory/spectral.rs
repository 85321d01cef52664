//! Interpolation in windows of weak spectral elements.
//!
//! The scheme is the Lobatto IIIC method, which has order 2n − 2 at the end of a window but only order n at its nodes.
//! The values at the start of a window are those at the end of the previous one. Inside the window the world-line
//! becomes as accurate as at the ends if it is computed once more from the start with enough stages: by fixed-point
//! (Picard) sweeps on 2n nodes, which begin with the forces at the n nodes of the window. The integrals of these forces
//! are enough where an accuracy was asked for, which holds at the nodes too, or where more nodes would gain no digit.

use super::legendre::{Expansion, Tables, integral, legendre, series};
use crate::geometry::geodesic::acceleration;
use crate::geometry::metric::Metric;
use crate::number::Real;
use crate::sbp::gll::MOST_NODES;
use crate::solve::WindowNodes;

/// Largest number of sweeps. Each gains two digits or more.
const MOST_SWEEPS: usize = 100;
/// Legendre coefficients of forces that count as rounding, relative to the largest one.
const ROUNDING: f64 = 1e-16;

/// t (counted from the start of the window), x and w in one window, as integrals of the polynomials for u = dt/dγ and
/// a = d²x/dγ².
#[derive(Debug)]
pub(super) struct Polynomials<S> {
    length: S,
    /// x and w at the start.
    start: [S; 2],
    /// Legendre coefficients of ∫u, ∬a and ∫a over [0, 1].
    integrals: [Vec<S>; 3],
}

impl<S: Real> Polynomials<S> {
    /// The polynomials for a window, which may be one of a run to an accuracy.
    pub(super) fn new(
        view: &WindowNodes<'_, S>,
        q_t: S,
        metric: &Metric<S>,
        (tables, has_accuracy): (&mut Tables<S>, bool),
    ) -> Self {
        let (window, x, start) = (view.window, view.row(1), [view.start.q[1], -view.start.p[1]]);
        let of_forces = |expansion: &Expansion<S>, x: &[S]| {
            let forces = x.iter().map(|&x| {
                let [g00, slope] = metric.g00_and_slope(x);
                (q_t / g00, acceleration(q_t, g00, slope))
            });
            let (u, a): (Vec<S>, Vec<S>) = forces.unzip();
            let w = integral(&expansion.coefficients(&a));
            let integrals = [integral(&expansion.coefficients(&u)), integral(&w), w];
            Self { length: window.length(), start, integrals }
        };
        let own = of_forces(tables.of(x.len()), x);
        if has_accuracy || own.is_resolved() {
            return own;
        }
        let fine = tables.of((2 * x.len()).min(MOST_NODES));
        // For a start at rest in x = 0 the size of the motion is that of the nodes.
        let reach = x.iter().fold(S::ZERO, |reach, x| reach.max((*x - start[0]).abs()));
        let scale = (start[0].abs() + (window.length() * start[1]).abs()).max(reach);
        let mut refined: Option<Self> = None;
        let mut before = vec![S::ZERO; fine.nodes.len()];
        for sweep in 0..MOST_SWEEPS {
            let last = refined.as_ref().unwrap_or(&own);
            let [x_start, w] = last.start;
            let mut x = fine.values(&last.integrals[1]);
            for (x, &s) in x.iter_mut().zip(&fine.nodes) {
                *x = x_start + last.length * (w * s + last.length * *x);
            }
            if !x.iter().all(|&x| metric.at(x).is_inside()) {
                break;
            }
            let change = x.iter().zip(&before).fold(S::ZERO, |change, (&x, &before)| change.max((x - before).abs()));
            refined = Some(of_forces(fine, &x));
            if sweep > 0 && change <= S::EPSILON * (scale + scale) {
                return refined.unwrap_or(own);
            }
            before = x;
        }
        // The window is too long for the sweeps to converge. The integrals over its own nodes are still more accurate
        // than the values there.
        own
    }

    /// Whether no digit would be gained by more nodes: the highest coefficients of both forces are rounding.
    fn is_resolved(&self) -> bool {
        let [of_u, _, of_a] = &self.integrals;
        !S::IS_EXTENDED
            && [of_u, of_a].into_iter().all(|integral| {
                // Those of an integral are those of its slope, divided by twice their odd degrees.
                let largest = |c: &[S]| c.iter().fold(0.0_f64, |largest, c| largest.max(c.to_f64().abs()));
                let tail = largest(&integral[integral.len().saturating_sub(3)..]);
                tail * (2 * integral.len() - 3) as f64 <= ROUNDING * largest(integral)
            })
    }

    /// t, x and w at `gamma`, counted from the start of the window.
    pub(super) fn at(&self, gamma: S) -> [S; 3] {
        let s = gamma / self.length;
        let basis = legendre(self.integrals[1].len() - 1, s + s - S::ONE);
        let [t, x, w] = self.integrals.each_ref().map(|c| self.length * series(c, &basis));
        let [x_start, w_start] = self.start;
        [t, x_start + self.length * (w_start * s + x), w_start + w]
    }
}
