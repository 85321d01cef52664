//! What a march of a world-line and its companion needs of its rules, made once in the life of the program.

use std::sync::OnceLock;

use super::rule::WeakRule;
use super::tables::{Matrix, Nodes, evaluation_matrix};
use super::unit::{SizedUnit, Unit};

/// A rule, and one with fewer nodes for the companion.
pub(super) struct Kit<const P: usize> {
    pub(super) rules: [&'static WeakRule; 2],
    pub(super) units: [&'static Unit<P>; 2],
    /// From the nodes of the first rule to those of the second.
    pub(super) resample: Box<Matrix<P>>,
    /// For each rule, two rows from nodal values to Legendre modes: the highest that the companion has, by which
    /// windows are judged.
    pub(super) tails: [[Nodes<P>; 2]; 2],
}

impl<const P: usize> Kit<P> {
    fn new(rules: [&'static WeakRule; 2], units: [&'static Unit<P>; 2]) -> Self {
        let [n, companion] = rules.map(WeakRule::points);
        let row = |rule: &WeakRule, k: usize| {
            let mut row = Nodes::ZERO;
            row.0.iter_mut().zip(rule.mode(k)).for_each(|(row, mode)| *row = mode);
            row
        };
        Self {
            rules,
            units,
            resample: evaluation_matrix::<P>(rules[0], n - 1, |i| rules[1].nodes()[i].hi, companion),
            tails: rules.map(|rule| [companion - 2, companion - 1].map(|k| row(rule, k))),
        }
    }
}

/// Made when it is first asked for.
macro_rules! kit {
    ($name:ident, $size:ident, $padded:literal, $nodes:literal, $companion:literal) => {
        pub(super) fn $name() -> &'static Kit<$padded> {
            static KIT: OnceLock<Kit<$padded>> = OnceLock::new();
            KIT.get_or_init(|| {
                let rules = [$nodes, $companion].map(WeakRule::shared);
                let units = rules.map(|rule| match rule.unit() {
                    SizedUnit::$size(unit) => &**unit,
                    _ => unreachable!("both rules have the size of the larger one"),
                });
                Kit::new(rules, units)
            })
        }
    };
}

kit!(coarse, P16, 16, 16, 15);
kit!(medium, P24, 24, 20, 19);
kit!(fine, P24, 24, 24, 23);
