//! What an observer sees of a window of a scene.

use super::state::FlowState;
use super::window::FlowWindow;
use crate::lobatto::Twofold;
use crate::lobatto::rule::legendre_values;

/// An accepted window.
pub struct FlowView<'v> {
    /// Its index, from 0.
    pub index: usize,
    /// γ − γ_i at its start.
    pub gamma: f64,
    /// Its length.
    pub length: f64,
    /// Number of nodes.
    pub points: usize,
    /// Where it starts.
    pub start: &'v FlowState,
    /// Where it ends.
    pub end: &'v FlowState,
    /// The largest entry of the gradient of its action, if certificates are wanted.
    pub gradient_norm: Option<f64>,
    pub(super) window: &'v dyn Nodal,
}

/// The nodal values of a window, whatever the padding of its arrays.
pub(super) trait Nodal {
    /// q^a of an active coordinate on the nodes, and after those p_a.
    fn row(&self, row: usize) -> &[f64];
    /// h q̇^a on the nodes, of any coordinate.
    fn velocity(&self, a: usize) -> Vec<f64>;
    /// h ṗ_a on the nodes, by place.
    fn force(&self, place: usize) -> &[f64];
    /// Legendre coefficient k of nodal values.
    fn mode(&self, k: usize, values: &[f64]) -> f64;
    /// q^a of an ignorable coordinate on the nodes, from the start of the window.
    fn elapsed(&self, a: usize) -> Vec<f64>;
    /// The place of a coordinate among the active ones.
    fn place(&self, a: usize) -> Option<usize>;
}

impl<const P: usize> Nodal for FlowWindow<'_, P> {
    fn row(&self, row: usize) -> &[f64] {
        &self.fields[row].0[..self.rule.rule.points()]
    }

    fn velocity(&self, a: usize) -> Vec<f64> {
        self.velocity_row(a)
    }

    fn force(&self, place: usize) -> &[f64] {
        &self.rows.forces()[place].0[..self.rule.rule.points()]
    }

    fn mode(&self, k: usize, values: &[f64]) -> f64 {
        self.rule.rule.mode_of(k, values)
    }

    fn elapsed(&self, a: usize) -> Vec<f64> {
        self.elapsed_row(a)
    }

    fn place(&self, a: usize) -> Option<usize> {
        self.place_of(a)
    }
}

impl FlowView<'_> {
    /// q^a on the nodes, of an ignorable coordinate from the start of the window.
    pub fn q(&self, a: usize) -> Vec<f64> {
        match self.window.place(a) {
            Some(place) => self.window.row(place).to_vec(),
            None => self.window.elapsed(a),
        }
    }

    /// p_a on the nodes, by place among the active coordinates.
    pub fn p(&self, place: usize) -> &[f64] {
        self.window.row(self.start.p.len() + place)
    }

    /// q^a at fractions of the window, from the integral of the polynomial through the velocities on its nodes. It is of
    /// order n + 1, as against 2n − 2 at the end.
    pub fn inside(&self, a: usize, fractions: &[f64]) -> Vec<f64> {
        self.integrals(&self.window.velocity(a), [self.start.q[a], self.end.q[a]], fractions)
    }

    /// p_a there, by place among the active coordinates.
    pub fn momentum_inside(&self, place: usize, fractions: &[f64]) -> Vec<f64> {
        self.integrals(self.window.force(place), [self.start.p[place], self.end.p[place]], fractions)
    }

    fn integrals(&self, rates: &[f64], [start, end]: [Twofold; 2], fractions: &[f64]) -> Vec<f64> {
        let modes: Vec<f64> = (0..self.points).map(|k| self.window.mode(k, rates)).collect();
        let at = |&fraction: &f64| {
            if fraction == 1.0 {
                return end.hi;
            }
            // ∫_0^s P_k(2s − 1) = (P_{k+1} − P_{k−1})/(2(2k + 1)), with P_{−1} = −1.
            let p = legendre_values(self.points, 2.0 * fraction - 1.0);
            let integral = |k: usize| (p[k + 1] - if k == 0 { -1.0 } else { p[k - 1] }) / (4 * k + 2) as f64;
            start.hi + (start.lo + (0..self.points).rev().map(|k| modes[k] * integral(k)).sum::<f64>())
        };
        fractions.iter().map(at).collect()
    }
}
