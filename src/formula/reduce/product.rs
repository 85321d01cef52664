//! Normal forms.

use std::cmp::Ordering;

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
        let mut powers = Vec::with_capacity(self.powers.len() + other.powers.len());
        let (mut one, mut two) = (&self.powers[..], &other.powers[..]);
        while let (Some((&first, later)), Some((&second, after))) = (one.split_first(), two.split_first()) {
            match first.0.cmp(&second.0) {
                Ordering::Less => {
                    powers.push(first);
                    one = later;
                }
                Ordering::Greater => {
                    powers.push(second);
                    two = after;
                }
                Ordering::Equal => {
                    powers.extend(Some((first.0, first.1 + second.1)).filter(|&(_, exponent)| exponent != 0));
                    (one, two) = (later, after);
                }
            }
        }
        powers.extend_from_slice(one);
        powers.extend_from_slice(two);
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
