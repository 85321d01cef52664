//! Normal forms.

use super::super::graph::NodeId;
use crate::number::Real;

/// A number times powers of atoms: of nodes that are no products, in ascending order. Zero has none. A number that is
/// beyond the range of numbers, or so small that it would be zero, is not a number; nor is that of a product with an
/// exponent beyond the range of exponents.
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
        let mut number = other.number;
        powers.dedup_by(|later, kept| {
            let is_same = later.0 == kept.0;
            if is_same {
                kept.1 = in_range(kept.1.checked_add(later.1), &mut number);
            }
            is_same
        });
        powers.retain(|&(_, exponent)| exponent != 0);
        Self { number: self.number, powers }.scaled(number)
    }

    pub(super) fn power(&self, exponent: i32) -> Self {
        let mut number = if exponent < 0 { S::ONE / self.number } else { self.number };
        let mut raised = |inner: i32| in_range(inner.checked_mul(exponent), &mut number);
        let powers = self.powers.iter().map(|&(atom, inner)| (atom, raised(inner))).collect();
        (0..exponent.unsigned_abs()).fold(Self { number: S::ONE, powers }, |power, _| power.scaled(number))
    }

    pub(super) fn exponent_of(&self, atom: NodeId) -> i32 {
        self.powers.iter().find(|&&(other, _)| other == atom).map_or(0, |&(_, exponent)| exponent)
    }
}

/// An exponent, if it is in the range of exponents; otherwise the number of its product becomes none.
fn in_range<S: Real>(exponent: Option<i32>, number: &mut S) -> i32 {
    exponent.filter(|exponent| *exponent != i32::MIN).unwrap_or_else(|| {
        *number = S::from(f64::NAN);
        1
    })
}
