//! The rules that adaptive windows take, made once in the life of the program.

use std::sync::OnceLock;

use super::tables::FlowTables;
use crate::engine::lobatto::kit::{self, Kit};
use crate::engine::lobatto::rule::WeakRule;
use crate::engine::lobatto::unit::Unit;
use crate::number::vector::Nodes;

/// What a rule brings to all windows.
#[derive(Clone, Copy)]
pub(super) struct Rule<const P: usize> {
    pub(super) rule: &'static WeakRule,
    pub(super) unit: &'static Unit<P>,
    /// From nodal values to the two highest modes but the last.
    pub(super) tail: &'static [Nodes<P>; 2],
    pub(super) tables: &'static FlowTables<P>,
}

/// Made when it is first asked for.
macro_rules! rule {
    ($name:ident, $padded:literal) => {
        pub(super) fn $name() -> Rule<$padded> {
            static TABLES: OnceLock<FlowTables<$padded>> = OnceLock::new();
            let Kit { rule, unit, tail } = kit::$name();
            let tables = TABLES.get_or_init(|| FlowTables::new(rule));
            Rule { rule, unit, tail, tables }
        }
    };
}

rule!(coarse, 16);
rule!(medium, 24);
rule!(fine, 24);
