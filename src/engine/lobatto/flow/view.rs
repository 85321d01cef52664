//! What an observer sees of a window of a scene.

use super::state::FlowState;
use super::window::FlowWindow;

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
    /// By how much every q^a, and every p_a by place, has changed after a fraction of the window.
    fn changes(&self, fraction: f64, q: &mut [f64], p: &mut [f64]);
    /// q^a of an ignorable coordinate on the nodes, from the start of the window.
    fn elapsed(&self, a: usize) -> Vec<f64>;
    /// The place of a coordinate among the active ones.
    fn place(&self, a: usize) -> Option<usize>;
}

impl<const P: usize> Nodal for FlowWindow<'_, P> {
    fn row(&self, row: usize) -> &[f64] {
        &self.fields[row].0[..self.rule.rule.points()]
    }

    fn changes(&self, fraction: f64, q: &mut [f64], p: &mut [f64]) {
        self.changes_at(fraction, q, p);
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

    /// Hands out all q^a, and p_a by place among the active coordinates, at fractions of the window: from the integrals
    /// of the polynomials through the rates on its nodes. They are of order n + 1, as against 2n − 2 at the end.
    pub fn inside(&self, fractions: &[f64], mut see: impl FnMut(&[f64], &[f64])) {
        if fractions.is_empty() {
            return;
        }
        let (mut q, mut p) = (vec![0.0; self.start.q.len()], vec![0.0; self.start.p.len()]);
        for &fraction in fractions {
            if fraction == 1.0 {
                let fields = q.iter_mut().zip(&self.end.q).chain(p.iter_mut().zip(&self.end.p));
                fields.for_each(|(value, end)| *value = end.hi);
            } else {
                self.window.changes(fraction, &mut q, &mut p);
                let fields = q.iter_mut().zip(&self.start.q).chain(p.iter_mut().zip(&self.start.p));
                fields.for_each(|(value, start)| *value = start.hi + (start.lo + *value));
            }
            see(&q, &p);
        }
    }
}
