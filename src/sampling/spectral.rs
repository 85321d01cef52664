//! Interpolation in windows of weak spectral elements.
//!
//! The scheme is the Lobatto IIIC method, which has order 2n − 2 at the end of a window but only order n at its nodes.
//! The values at the start of a window are those at the end of the previous one. Inside the window the world-line
//! becomes as accurate as at the ends if it is computed once more from the start with enough stages: by fixed-point
//! (Picard) sweeps on 2n nodes, which begin with the forces at the n nodes of the window.

use std::collections::HashMap;

use crate::geodesic::acceleration;
use crate::metric::Metric;
use crate::sbp::gll::{LobattoRule, MOST_NODES};
use crate::scalar::{Real, sum};
use crate::solve::Window;

/// Largest number of sweeps. Each gains two digits or more.
const MOST_SWEEPS: usize = 100;

/// Conversion between nodal values on one rule and coefficients of Legendre polynomials. Both matrices are stored in
/// the order of access, so that products vectorise.
#[derive(Debug)]
struct Expansion<S> {
    /// Nodes on [0, 1].
    nodes: Vec<S>,
    /// For node j: its weights in coefficients 0 … n − 1.
    modes: Vec<S>,
    /// For degree k = 0 … n + 1: P_k at the nodes.
    basis: Vec<S>,
}

impl<S: Real> Expansion<S> {
    fn new(points: usize) -> Self {
        let rule: LobattoRule<S> = LobattoRule::new(points);
        let at_nodes: Vec<Vec<S>> = rule.nodes.iter().map(|&z| legendre(points + 1, z)).collect();
        let last = points - 1;
        let mode = |j: usize, k: usize| {
            // The rule does not integrate P_{n−1}² exactly, so the factor of the last coefficient is another one.
            let norm = if k < last { 2 * k + 1 } else { last };
            S::from(norm as f64).half() * rule.weights[j] * at_nodes[j][k]
        };
        Self {
            nodes: rule.nodes.iter().map(|&z| (S::ONE + z).half()).collect(),
            modes: (0..points * points).map(|place| mode(place / points, place % points)).collect(),
            basis: (0..points * (points + 2)).map(|place| at_nodes[place % points][place / points]).collect(),
        }
    }

    /// Legendre coefficients of the polynomial through `values`.
    fn coefficients(&self, values: &[S]) -> Vec<S> {
        let mut coefficients = vec![S::ZERO; values.len()];
        for (modes, &value) in self.modes.chunks_exact(values.len()).zip(values) {
            coefficients.iter_mut().zip(modes).for_each(|(c, &mode)| *c += mode * value);
        }
        coefficients
    }

    /// Σ c_k P_k at the nodes, smallest terms first.
    fn values(&self, coefficients: &[S]) -> Vec<S> {
        let mut values = vec![S::ZERO; self.nodes.len()];
        for (basis, &c) in self.basis.chunks_exact(values.len()).zip(coefficients).rev() {
            values.iter_mut().zip(basis).for_each(|(value, &p)| *value += c * p);
        }
        values
    }
}

/// Expansions by number of nodes, each computed once.
#[derive(Debug)]
pub(super) struct Tables<S>(HashMap<usize, Expansion<S>>);

impl<S> Default for Tables<S> {
    fn default() -> Self {
        Self(HashMap::new())
    }
}

impl<S: Real> Tables<S> {
    fn of(&mut self, points: usize) -> &Expansion<S> {
        self.0.entry(points).or_insert_with(|| Expansion::new(points))
    }
}

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
    /// The polynomials for `window`, which has the values `x` on its nodes.
    pub(super) fn new(window: &Window<S>, x: &[S], q_t: S, metric: &Metric<S>, tables: &mut Tables<S>) -> Self {
        let of_forces = |expansion: &Expansion<S>, x: &[S]| {
            let jets: Vec<_> = x.iter().map(|&x| metric.at(x)).collect();
            let u: Vec<S> = jets.iter().map(|g| q_t / g.g00).collect();
            let a: Vec<S> = jets.iter().map(|g| acceleration(q_t, g.g00, g.first)).collect();
            let w = integral(&expansion.coefficients(&a));
            let integrals = [integral(&expansion.coefficients(&u)), integral(&w), w];
            Self { length: window.length(), start: [window.start.x, window.start.x_dot], integrals }
        };
        let own = of_forces(tables.of(x.len()), x);
        let fine = tables.of((2 * x.len()).min(MOST_NODES));
        // For a start at rest in x = 0 the size of the motion is that of the nodes.
        let reach = x.iter().fold(S::ZERO, |reach, x| reach.max((*x - window.start.x).abs()));
        let scale = (window.start.x.abs() + (window.length() * window.start.x_dot).abs()).max(reach);
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

    /// t, x and w at `gamma`, counted from the start of the window.
    pub(super) fn at(&self, gamma: S) -> [S; 3] {
        let s = gamma / self.length;
        let basis = legendre(self.integrals[1].len() - 1, s + s - S::ONE);
        let [t, x, w] = self.integrals.each_ref().map(|c| self.length * series(c, &basis));
        let [x_start, w_start] = self.start;
        [t, x_start + self.length * (w_start * s + x), w_start + w]
    }
}

/// Σ c_k P_k, smallest terms first.
fn series<S: Real>(c: &[S], basis: &[S]) -> S {
    sum(c.iter().zip(basis).rev().map(|(&c, &p)| c * p))
}

/// P_0 … P_degree at z.
fn legendre<S: Real>(degree: usize, z: S) -> Vec<S> {
    let mut p = vec![S::ONE; degree + 1];
    p[1] = z;
    for k in 1..degree {
        let [k_, next, twice] = [k, k + 1, 2 * k + 1].map(|k| S::from(k as f64));
        p[k + 1] = (twice * z * p[k] - k_ * p[k - 1]) / next;
    }
    p
}

/// The Legendre coefficients of the integral from 0 to s ∈ [0, 1] of the series with coefficients `c`. They follow from
/// ∫_{−1}^z P_k = (P_{k+1} − P_{k−1})/(2k + 1), half of which is the integral on [0, 1].
fn integral<S: Real>(c: &[S]) -> Vec<S> {
    let mut integral = vec![S::ZERO; c.len() + 1];
    for (k, &c) in c.iter().enumerate() {
        let share = c.half() / S::from((2 * k + 1) as f64);
        integral[k + 1] += share;
        if k == 0 { integral[0] += share } else { integral[k - 1] -= share }
    }
    integral
}
