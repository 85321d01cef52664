//! The rules that adaptive windows take, made once in the life of the program.

use std::sync::OnceLock;

use super::tables::FlowTables;
use super::window::Rule;
use crate::lobatto::kit::{self, Kit};

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
