//! The values of a Lagrangian on nodes, contracted with velocities.

use std::ops::Range;

use super::structure::{Samples, Source, Structure, Term, other};
use crate::number::Real;

/// Values of a Lagrangian on nodes, and the velocities there. A point is a row of one node.
///
/// The outer loop is over terms and the inner one over nodes, which the compiler turns into vector instructions.
pub struct Contraction<'c, S, V> {
    /// The entries that are not zero.
    pub structure: &'c Structure<S>,
    /// The values of these entries on all nodes.
    pub samples: &'c Samples<S>,
    /// The nodes of the samples that are looked at.
    pub nodes: Range<usize>,
    /// The row of q̇^b on these nodes; `None`, which stands for ones, if b = n.
    pub velocity: V,
}

/// Returns what `add` adds to 0 at a single node.
pub(crate) fn single<S: Real>(add: impl FnOnce(&mut [S])) -> S {
    let mut sum = S::ZERO;
    add(std::slice::from_mut(&mut sum));
    sum
}

impl<'c, S: Real, V: Fn(usize) -> Option<&'c [S]>> Contraction<'c, S, V> {
    /// Adds p_a = g_ab q̇^b + A_a to `out`.
    pub fn add_momentum(&self, a: usize, out: &mut [S]) {
        for term in &self.structure.values {
            if let Some(b) = other(term.ab, a) {
                self.fold(out, term.value, [(self.velocity)(b), None], |sum, product| sum + product);
            }
        }
    }

    /// Adds f_a = ½ ∂_a g_bc q̇^b q̇^c + ∂_a A_b q̇^b to `out`.
    pub fn add_force(&self, a: usize, out: &mut [S]) {
        for &Term { ab: [b, c], value, .. } in self.structure.first.iter().filter(|term| term.by == [a]) {
            let factors = [b, c].map(&self.velocity);
            match b == c {
                true => self.fold(out, value, factors, |sum, product| sum + product.half()),
                false => self.fold(out, value, factors, |sum, product| sum + product),
            }
        }
    }

    /// Adds K = g_ab q̇^a q̇^b to `out`.
    pub fn add_norm(&self, out: &mut [S]) {
        for &Term { ab: [a, b], value, .. } in self.terms_of_metric() {
            let factors = [a, b].map(&self.velocity);
            match a == b {
                true => self.fold(out, value, factors, |sum, product| sum + product),
                false => self.fold(out, value, factors, |sum, product| sum + product + product),
            }
        }
    }

    /// Adds Σ |g_ab q̇^a q̇^b| over a ≤ b without its largest term to `out`: what motion contributes to K.
    pub fn add_motion(&self, out: &mut [S]) {
        let mut largest = vec![S::ZERO; out.len()];
        for &Term { ab, value, .. } in self.terms_of_metric() {
            let factors = ab.map(&self.velocity);
            self.fold(out, value, factors, |sum, product| sum + product.abs());
            self.fold(&mut largest, value, factors, |largest, product| largest.max(product.abs()));
        }
        out.iter_mut().zip(largest).for_each(|(sum, largest)| *sum -= largest);
    }

    fn terms_of_metric(&self) -> impl Iterator<Item = &'c Term<S, 0>> {
        let structure = self.structure;
        structure.values.iter().filter(|term| term.ab[1] < structure.dimension)
    }

    /// Changes `row` to `change(row_k, value_k v_k w_k)` at every node k, for the factors v and w that there are.
    fn fold(&self, row: &mut [S], value: Source<S>, factors: [Option<&[S]>; 2], change: impl Fn(S, S) -> S) {
        match value {
            Source::Constant(value) => fold(row, std::iter::repeat(value), factors, change),
            Source::Row(values) => {
                fold(row, self.samples.row(values)[self.nodes.clone()].iter().copied(), factors, change);
            }
        }
    }
}

fn fold<S: Real>(
    row: &mut [S],
    values: impl Iterator<Item = S>,
    factors: [Option<&[S]>; 2],
    change: impl Fn(S, S) -> S,
) {
    let rows = row.iter_mut().zip(values);
    match factors {
        [Some(v), Some(w)] => {
            rows.zip(v).zip(w).for_each(|(((sum, value), &v), &w)| *sum = change(*sum, value * v * w));
        }
        [Some(v), None] | [None, Some(v)] => {
            rows.zip(v).for_each(|((sum, value), &v)| *sum = change(*sum, value * v));
        }
        [None, None] => rows.for_each(|(sum, value)| *sum = change(*sum, value)),
    }
}
