//! Normal forms.

use super::super::graph::NodeId;
use crate::number::Real;

/// A number times powers of atoms: of nodes that are no products, in ascending order. Zero has none.
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
        Self::new(self.number * factor, self.powers)
    }

    pub(super) fn times(mut self, other: &Self) -> Self {
        for &(atom, exponent) in &other.powers {
            match self.powers.binary_search_by_key(&atom, |&(atom, _)| atom) {
                Ok(place) => self.powers[place].1 += exponent,
                Err(place) => self.powers.insert(place, (atom, exponent)),
            }
        }
        self.powers.retain(|&(_, exponent)| exponent != 0);
        self.scaled(other.number)
    }

    pub(super) fn power(&self, exponent: i32) -> Self {
        let mut power = S::ONE;
        (0..exponent.unsigned_abs()).for_each(|_| power *= self.number);
        let power = if exponent < 0 { S::ONE / power } else { power };
        Self::new(power, self.powers.iter().map(|&(atom, inner)| (atom, inner * exponent)).collect())
    }

    pub(super) fn exponent_of(&self, atom: NodeId) -> i32 {
        self.powers.iter().find(|&&(other, _)| other == atom).map_or(0, |&(_, exponent)| exponent)
    }
}
