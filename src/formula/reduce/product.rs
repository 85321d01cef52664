//! Normal forms.

use super::super::graph::NodeId;
use crate::number::Real;

/// A number times powers of atoms: of nodes that are no products, in ascending order. Zero has none. A number that is
/// beyond the range of numbers, or so small that it would be zero, is not a number.
#[derive(Debug, Clone)]
pub(super) struct Product<S> {
    pub(super) number: S,
    pub(super) powers: Vec<(NodeId, i32)>,
}

impl<S: Real> Product<S> {
    fn new(number: S, powers: Vec<(NodeId, i32)>) -> Self {
        let powers = if number == S::ZERO { Vec::new() } else { powers };
        Self { number, powers }
    }

    pub(super) fn scaled(self, factor: S) -> Self {
        let number = self.number * factor;
        let is_lost = number == S::ZERO && self.number != S::ZERO && factor != S::ZERO;
        Self::new(if is_lost || !number.is_finite() { S::from(f64::NAN) } else { number }, self.powers)
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        let mut powers = [&self.powers[..], &other.powers].concat();
        powers.sort_by_key(|&(atom, _)| atom);
        powers.dedup_by(|later, kept| {
            let is_same = later.0 == kept.0;
            kept.1 += if is_same { later.1 } else { 0 };
            is_same
        });
        powers.retain(|&(_, exponent)| exponent != 0);
        Self { number: self.number, powers }.scaled(other.number)
    }

    pub(super) fn power(&self, exponent: i32) -> Self {
        let number = if exponent < 0 { S::ONE / self.number } else { self.number };
        let powers = self.powers.iter().map(|&(atom, inner)| (atom, inner * exponent)).collect();
        (0..exponent.unsigned_abs()).fold(Self { number: S::ONE, powers }, |power, _| power.scaled(number))
    }

    pub(super) fn exponent_of(&self, atom: NodeId) -> i32 {
        self.powers.iter().find(|&&(other, _)| other == atom).map_or(0, |&(_, exponent)| exponent)
    }
}
