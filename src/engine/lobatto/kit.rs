//! What an adaptive march needs of its rule, made once in the life of the program.

use std::sync::OnceLock;

use super::rule::WeakRule;
use super::unit::{SizedUnit, Unit};
use crate::number::vector::Nodes;

/// A rule with all that windows of any length need.
pub(super) struct Kit<const P: usize> {
    pub(super) rule: &'static WeakRule,
    pub(super) unit: &'static Unit<P>,
    /// Two rows from nodal values to Legendre modes, the highest but the very last, by which windows are judged.
    pub(super) tail: [Nodes<P>; 2],
}

impl<const P: usize> Kit<P> {
    fn new(rule: &'static WeakRule, unit: &'static Unit<P>) -> Self {
        let row = |k: usize| {
            let mut row = Nodes::ZERO;
            row.0.iter_mut().zip(rule.mode(k)).for_each(|(row, mode)| *row = mode);
            row
        };
        let n = rule.points();
        Self { rule, unit, tail: [n - 3, n - 2].map(row) }
    }
}

/// Made when it is first asked for.
macro_rules! kit {
    ($name:ident, $size:ident, $padded:literal, $nodes:literal) => {
        pub(super) fn $name() -> &'static Kit<$padded> {
            static KIT: OnceLock<Kit<$padded>> = OnceLock::new();
            KIT.get_or_init(|| match WeakRule::shared($nodes).unit() {
                SizedUnit::$size(unit) => Kit::new(WeakRule::shared($nodes), unit),
                _ => unreachable!("the size of so many nodes"),
            })
        }
    };
}

kit!(coarse, P16, 16, 16);
kit!(medium, P24, 24, 20);
kit!(fine, P24, 24, 24);
