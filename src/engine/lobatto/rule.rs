//! A rule for windows: its operators, and what windows of all lengths need of them.

use std::ops::Deref;
use std::sync::OnceLock;

use super::tables::LengthFree;
use super::unit::SizedUnit;
use crate::sbp::collocation::Collocation;

/// The operators of a weak window, with tables that are made when they are first asked for.
#[derive(Debug, Clone)]
pub struct WeakRule {
    operators: Collocation,
    length_free: OnceLock<LengthFree>,
    unit: OnceLock<SizedUnit>,
}

impl Deref for WeakRule {
    type Target = Collocation;

    fn deref(&self) -> &Collocation {
        &self.operators
    }
}

impl WeakRule {
    /// The rule with `n` nodes, from [`Collocation::FEWEST`] to [`Collocation::MOST`]; a tenth of a millisecond for
    /// 20 of them.
    ///
    /// # Panics
    /// For another `n`.
    pub fn new(n: usize) -> Self {
        Self { operators: Collocation::new(n), length_free: OnceLock::new(), unit: OnceLock::new() }
    }

    /// The rule with `n` nodes, made once in the life of the program.
    ///
    /// # Panics
    /// As [`Self::new`].
    pub fn shared(n: usize) -> &'static Self {
        static RULES: [OnceLock<WeakRule>; Collocation::MOST + 1] = [const { OnceLock::new() }; Collocation::MOST + 1];
        RULES.get(n).expect("a window has 2 to 64 nodes").get_or_init(|| Self::new(n))
    }

    /// What tables of windows are made of, computed when the first is made.
    pub(super) fn length_free(&self) -> &LengthFree {
        self.length_free.get_or_init(|| LengthFree::new(&self.operators))
    }

    /// The tables of windows of length 1, computed when they are first asked for.
    pub(super) fn unit(&self) -> &SizedUnit {
        self.unit.get_or_init(|| SizedUnit::new(&self.operators, self.length_free()))
    }
}
