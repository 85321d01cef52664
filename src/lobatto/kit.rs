//! What a march of two needs of its rules, made once in the life of the program.
//!
//! A geodesic may be walked in any affine parameter: with s = γ/h, h Q_t and h w take the place of Q_t and w, and every
//! window has length 1. So one set of tables serves windows of all lengths.

use std::sync::OnceLock;

use super::rule::WeakRule;
use super::tables::{Matrix, Tables, evaluation_matrix};
use super::twofold::Twofold;
use super::window::Continuation;

/// The tables of a rule, and of one with fewer nodes for the companion.
pub(super) struct Kit<const P: usize> {
    pub(super) rules: [&'static WeakRule; 2],
    pub(super) tables: [Box<Tables<P>>; 2],
    /// From the nodes of the one to those of the other.
    pub(super) resample: Box<Matrix<P>>,
    /// From nodal values of the first to Legendre coefficients.
    modes: Box<Matrix<P>>,
    recurrence: Vec<[f64; 2]>,
}

impl<const P: usize> Kit<P> {
    fn new(n: usize, companion: usize) -> Self {
        let rules = [WeakRule::shared(n), WeakRule::shared(companion)];
        // The highest two modes that the companion has.
        let tail = companion - 2;
        let mut modes = Box::new([[0.0; P]; P]);
        for k in 0..n {
            modes.iter_mut().zip(rules[0].mode(k)).for_each(|(column, weight)| column[k] = weight);
        }
        let ratio = |k: usize| [(2 * k + 1) as f64 / (k + 1) as f64, k as f64 / (k + 1) as f64];
        Self {
            rules,
            tables: [
                Tables::new(rules[0], Twofold::ONE, tail).with_guess(rules[0]),
                Tables::new(rules[1], Twofold::ONE, tail),
            ],
            resample: evaluation_matrix::<P>(rules[0], n - 1, |i| rules[1].nodes()[i].hi, companion),
            modes,
            recurrence: (0..=n).map(ratio).collect(),
        }
    }

    /// The forces of a window as a polynomial of `degree`, on one that begins at its start (`begin` 0) or end (1) and is
    /// `ratio` as long.
    pub(super) fn continuation(&self, degree: usize, begin: f64, ratio: f64) -> Continuation<'_, P> {
        Continuation {
            modes: &self.modes,
            recurrence: &self.recurrence,
            degree,
            first: 2.0 * begin - 1.0,
            step: 2.0 * ratio,
            factor: ratio * ratio,
        }
    }
}

/// Made when it is first asked for.
macro_rules! kit {
    ($name:ident, $size:literal, $nodes:literal, $companion:literal) => {
        pub(super) fn $name() -> &'static Kit<$size> {
            static KIT: OnceLock<Kit<$size>> = OnceLock::new();
            KIT.get_or_init(|| Kit::new($nodes, $companion))
        }
    };
}

kit!(coarse, 16, 16, 15);
kit!(medium, 24, 20, 19);
kit!(fine, 24, 24, 23);
