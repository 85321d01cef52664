//! The world-line between the ends of a window.

use super::State;
use super::rule::{WeakRule, legendre_values};
use super::view::WindowView;
use crate::geodesic::acceleration;

/// Most sweeps of the refinement; it gains two digits and more in each.
const MOST_SWEEPS: usize = 40;

/// A point of the world-line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DensePoint {
    /// t.
    pub t: f64,
    /// x.
    pub x: f64,
    /// w = dx/dγ.
    pub w: f64,
}

/// Polynomials for t, x and w over one window, as integrals of polynomials for u and a.
#[derive(Debug, Clone)]
pub struct DenseWindow {
    start: State,
    length: f64,
    /// Legendre coefficients of ∫u, ∬a and ∫a over s ∈ [0, 1].
    t: Vec<f64>,
    x: Vec<f64>,
    w: Vec<f64>,
}

/// Σ_j of every mode with the nodal values: their Legendre coefficients.
fn coefficients(rule: &WeakRule, values: &[f64]) -> Vec<f64> {
    (0..rule.points()).map(|k| rule.mode(k).zip(values).map(|(mode, v)| mode * v).sum()).collect()
}

/// The Legendre coefficients of ∫_0^s, from ∫_{−1}^z P_k = (P_{k+1} − P_{k−1})/(2k + 1), half of it on [0, 1].
fn integral(c: &[f64]) -> Vec<f64> {
    let mut integral = vec![0.0; c.len() + 1];
    for (k, c) in c.iter().enumerate() {
        let share = 0.5 * c / (2 * k + 1) as f64;
        integral[k + 1] += share;
        if k == 0 { integral[0] += share } else { integral[k - 1] -= share }
    }
    integral
}

impl DenseWindow {
    /// From the nodal values of a and u.
    fn new(start: State, length: f64, rule: &WeakRule, a: &[f64], u: &[f64]) -> Self {
        let w = integral(&coefficients(rule, a));
        Self { start, length, t: integral(&coefficients(rule, u)), x: integral(&w), w }
    }

    pub(super) fn own(view: &WindowView<'_>) -> Self {
        Self::new(view.start, view.length.hi, view.rule, view.acceleration, view.t_dot)
    }

    /// Picard sweeps with twice as many nodes: the scheme's superconvergence at the ends is that of a method with such
    /// stages, so that the integrals of the refined a and u are as accurate everywhere.
    pub(super) fn refined(view: &WindowView<'_>) -> Self {
        let mut dense = Self::own(view);
        let rule = WeakRule::shared((2 * view.rule.points()).min(WeakRule::MOST));
        let (mut x, mut a, mut u) = (vec![0.0; rule.points()], vec![0.0; rule.points()], vec![0.0; rule.points()]);
        let basis: Vec<Vec<f64>> =
            rule.nodes().iter().map(|c| legendre_values(rule.points() + 1, 2.0 * c.hi - 1.0)).collect();
        for _ in 0..MOST_SWEEPS {
            let mut change = 0.0_f64;
            for (k, (node, basis)) in rule.nodes().iter().zip(&basis).enumerate() {
                let at = dense.x_with(node.hi, basis);
                change = change.max((at - x[k]).abs());
                x[k] = at;
                let g = view.metric.at(at);
                u[k] = view.q_t / g.g00;
                a[k] = acceleration(view.q_t, g.g00, g.first);
            }
            if !a.iter().chain(&u).all(|v| v.is_finite()) {
                return Self::own(view);
            }
            dense = Self::new(view.start, view.length.hi, rule, &a, &u);
            let scale = view.start.x.hi.abs() + (view.length.hi * view.start.w.hi).abs();
            if change <= 2.0 * f64::EPSILON * scale {
                break;
            }
        }
        dense
    }

    fn x_with(&self, s: f64, basis: &[f64]) -> f64 {
        let h = self.length;
        let force = sum(&self.x, basis);
        self.start.x.hi + (h * self.start.w.hi * s + (h * h * force + self.start.x.lo))
    }

    /// The point at γ = γ(start) + s · length, s ∈ [0, 1].
    pub fn at(&self, s: f64) -> DensePoint {
        let h = self.length;
        let basis = legendre_values(self.x.len() - 1, 2.0 * s - 1.0);
        DensePoint {
            t: self.start.t.hi + (h * sum(&self.t, &basis) + self.start.t.lo),
            x: self.x_with(s, &basis),
            w: self.start.w.hi + (h * sum(&self.w, &basis) + self.start.w.lo),
        }
    }
}

/// Σ c_k P_k, smallest terms first.
fn sum(c: &[f64], basis: &[f64]) -> f64 {
    c.iter().zip(basis).rev().fold(0.0, |sum, (c, p)| sum + c * p)
}
