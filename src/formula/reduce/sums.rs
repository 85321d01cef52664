//! Sums: like terms, and factors that terms have in common.

use std::collections::HashMap;

use super::atoms::{Atom, AtomId, Forms, Product};
use crate::number::Real;

impl<S: Real> Forms<'_, S> {
    /// The sum of terms.
    pub(super) fn sum(&mut self, terms: Vec<Product>) -> Product {
        let terms = self.collected(terms);
        match &terms[..] {
            [] => return self.with_number(S::ZERO, Vec::new()),
            [term] => return term.clone(),
            _ => {}
        }
        let factor = self.common(&terms);
        let mut terms: Vec<Product> = terms.iter().map(|term| self.without(term, &factor)).collect();
        if self.factors_out {
            while let Some(atom) = most_frequent(&terms) {
                terms = self.grouped(terms, atom);
            }
        }
        // What is left after a group was formed may be a single product.
        match terms.len() {
            1 => self.times(&factor, &terms[0]),
            _ => {
                let sum = self.atom(Atom::Sum(terms));
                self.times(&factor, &sum)
            }
        }
    }

    /// Like terms as one, each where the first of them stands; without zeros.
    fn collected(&mut self, terms: Vec<Product>) -> Vec<Product> {
        let mut places: HashMap<Vec<(AtomId, i32)>, usize> = HashMap::new();
        let mut collected: Vec<Product> = Vec::with_capacity(terms.len());
        for term in terms {
            match places.get(&term.powers) {
                Some(&place) => {
                    let number = self.number(&collected[place]) + self.number(&term);
                    collected[place].coefficient = self.graph.constant(number);
                }
                None => {
                    places.insert(term.powers.clone(), collected.len());
                    collected.push(term);
                }
            }
        }
        collected.retain(|term| self.number(term) != S::ZERO);
        collected
    }

    /// What all terms have in common: powers of one sign, and the number of the first where the others differ from it
    /// by a sign only. Sums that differ by a number's sign are then the same.
    fn common(&mut self, terms: &[Product]) -> Product {
        let (first, rest) = terms.split_first().expect("terms");
        let shared = |&(atom, exponent): &(AtomId, i32)| {
            let exponents = rest.iter().map(|term| exponent_of(term, atom));
            let least = exponents.fold(exponent, common_exponent);
            (least != 0).then_some((atom, least))
        };
        let powers = first.powers.iter().filter_map(shared).collect();
        let number = self.number(first);
        let is_shared = rest.iter().all(|term| self.number(term).abs() == number.abs());
        let sign = if number < S::ZERO { -S::ONE } else { S::ONE };
        self.with_number(if is_shared { number } else { sign }, powers)
    }

    /// A term divided by a factor that it has, whose number is that of the term or ±1.
    fn without(&mut self, term: &Product, factor: &Product) -> Product {
        let inverse = Product {
            coefficient: self.graph.whole(1),
            powers: factor.powers.iter().map(|&(atom, exponent)| (atom, -exponent)).collect(),
        };
        let rest = self.times(term, &inverse);
        let number = self.number(term) / self.number(factor);
        self.with_number(number, rest.powers)
    }

    /// The terms with those that contain a power of `atom` of the same sign as one product, where the first of them
    /// stood.
    fn grouped(&mut self, terms: Vec<Product>, (atom, exponent): (AtomId, i32)) -> Vec<Product> {
        let is_in = |term: &Product| common_exponent(exponent_of(term, atom), exponent) != 0;
        let least = terms.iter().filter(|term| is_in(term)).map(|term| exponent_of(term, atom));
        let least = least.reduce(common_exponent).expect("a group has terms");
        let factor = Product { coefficient: self.graph.whole(1), powers: vec![(atom, least)] };
        let (inside, outside): (Vec<Product>, Vec<Product>) = terms.iter().cloned().partition(is_in);
        let first = terms.iter().position(is_in).expect("a group has terms");
        let inside = inside.iter().map(|term| self.without(term, &factor)).collect();
        let inside = self.sum(inside);
        let group = self.times(&factor, &inside);
        let mut terms = outside;
        terms.insert(first, group);
        terms
    }
}

fn exponent_of(product: &Product, atom: AtomId) -> i32 {
    product.powers.iter().find(|&&(other, _)| other == atom).map_or(0, |&(_, exponent)| exponent)
}

/// The exponent that divides both powers; 0 if only 1 does.
fn common_exponent(one: i32, other: i32) -> i32 {
    if one.signum() != other.signum() {
        0
    } else if one.abs() < other.abs() {
        one
    } else {
        other
    }
}

/// An atom with a sign of its exponent, in most of the terms: in two at least.
fn most_frequent(terms: &[Product]) -> Option<(AtomId, i32)> {
    let mut counts: Vec<((AtomId, i32), usize)> = Vec::new();
    for &(atom, exponent) in terms.iter().flat_map(|term| &term.powers) {
        let key = (atom, exponent.signum());
        match counts.iter_mut().find(|(other, _)| *other == key) {
            Some((_, count)) => *count += 1,
            None => counts.push((key, 1)),
        }
    }
    // Quotients are dear, so they go first among equals.
    let best = counts.into_iter().max_by_key(|&((atom, sign), count)| (count, -sign, std::cmp::Reverse(atom)));
    best.filter(|&(_, count)| count > 1).map(|(key, _)| key)
}
