//! Sums: like terms, and factors that terms have in common.

use std::cmp::Reverse;

use super::super::graph::NodeId;
use super::{Product, Reducer};
use crate::number::Real;

impl<S: Real> Reducer<'_, S> {
    /// The sum of terms.
    pub(super) fn sum(&mut self, terms: Vec<Product<S>>) -> Product<S> {
        let mut terms = collected(terms);
        if let Some(lost) = terms.iter().find(|term| !term.number.is_finite()) {
            return lost.clone();
        }
        // The number of the first is taken out where the others differ from it by a sign only, and otherwise its sign.
        // Sums that differ by a number's sign are then the same.
        let number = match &terms[..] {
            [] => return Product { number: S::ZERO, powers: Vec::new() },
            [term] => return term.clone(),
            [first, rest @ ..] if rest.iter().all(|term| term.number.abs() == first.number.abs()) => first.number,
            [first, ..] => first.number.signum(),
        };
        terms.iter_mut().for_each(|term| term.number = term.number / number);
        while let Some(shared) = most_frequent(&terms) {
            terms = self.grouped(terms, shared);
        }
        if let [term] = &terms[..] {
            return term.clone().scaled(number);
        }
        let sum = self.added(&terms);
        self.atom(sum).scaled(number)
    }

    /// The terms with those that contain a power of `atom` of this sign as one product, where the first of them stood.
    fn grouped(&mut self, terms: Vec<Product<S>>, (atom, sign): (NodeId, i32)) -> Vec<Product<S>> {
        let is_in = |term: &Product<S>| term.exponent_of(atom).signum() == sign;
        let first = terms.iter().position(is_in).expect("a group has terms");
        let (inside, mut terms): (Vec<_>, Vec<_>) = terms.into_iter().partition(is_in);
        let least = inside.iter().map(|term| term.exponent_of(atom).abs()).min().expect("a group has terms") * sign;
        let power = |exponent: i32| Product { number: S::ONE, powers: vec![(atom, exponent)] };
        let inside = inside.into_iter().map(|term| term.times(&power(-least))).collect();
        terms.insert(first, self.sum(inside).times(&power(least)));
        terms
    }
}

/// Like terms as one, each where the first of them stands; without zeros.
fn collected<S: Real>(terms: Vec<Product<S>>) -> Vec<Product<S>> {
    let mut collected: Vec<Product<S>> = Vec::with_capacity(terms.len());
    for term in terms {
        match collected.iter_mut().find(|other| other.powers == term.powers) {
            Some(like) => like.number += term.number,
            None => collected.push(term),
        }
    }
    collected.retain(|term| term.number != S::ZERO);
    collected
}

/// An atom with the sign of its exponent, in most of the terms: in two at least. Quotients are dear, so they go first
/// among equals.
fn most_frequent<S: Real>(terms: &[Product<S>]) -> Option<(NodeId, i32)> {
    let mut counts: Vec<((NodeId, i32), usize)> = Vec::new();
    for &(atom, exponent) in terms.iter().flat_map(|term| &term.powers) {
        let key = (atom, exponent.signum());
        match counts.iter_mut().find(|(other, _)| *other == key) {
            Some((_, count)) => *count += 1,
            None => counts.push((key, 1)),
        }
    }
    let best = counts.into_iter().max_by_key(|&((atom, sign), count)| (count, -sign, Reverse(atom)));
    best.filter(|&(_, count)| count > 1).map(|(key, _)| key)
}
