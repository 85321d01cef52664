//! Lengths of windows, h = h₀ 2^(k/4), with the tables of each, which are made when they are first used.

use std::sync::OnceLock;

use super::rule::{Order, Rule, Tables};
use super::{MOST_POINTS, POINTS};
use crate::number::Compensated;
use crate::number::vector::Matrix;

/// k runs from −REACH to REACH.
const REACH: i32 = 200;
/// A window is continued into one that is longer by at most so many rungs,
const LONGEST: i32 = 8;
/// or shorter by at most so many.
const SHORTEST: i32 = -16;
/// The number of lengths into which a window is continued.
const CONTINUED: usize = (LONGEST - SHORTEST + 1) as usize;

/// The tables of all lengths that were used.
pub(super) struct Ladder {
    order: Order,
    is_exact: bool,
    /// h₀.
    first: f64,
    rungs: Vec<Option<Box<Rung>>>,
}

struct Rung {
    tables: Tables<POINTS>,
    /// The matrices of [`Rule::continuation`] from windows that are shorter by j = SHORTEST … LONGEST rungs.
    continuations: [Option<Box<Matrix<POINTS>>>; CONTINUED],
}

impl Ladder {
    /// The ladder whose rung 0 has the length `first`. Exact tables keep what rounding takes from their entries.
    pub(super) fn new(order: Order, first: f64, is_exact: bool) -> Self {
        Self { order, is_exact, first, rungs: (-REACH..=REACH).map(|_| None).collect() }
    }

    /// The rung k or the longest one; `None` if there is none so short.
    pub(super) fn nearest(k: i32) -> Option<i32> {
        (k >= -REACH).then(|| k.min(REACH))
    }

    /// The length of rung k. The fourth roots of powers of two are rounded alike in every unit of length.
    pub(super) fn length(&self, k: i32) -> f64 {
        let roots = [1.0, std::f64::consts::SQRT_2.sqrt(), std::f64::consts::SQRT_2, 2.0_f64.powf(0.75)];
        let power_of_two = f64::from_bits(((k.div_euclid(4) + 1023) as u64) << 52);
        self.first * roots[k.rem_euclid(4) as usize] * power_of_two
    }

    /// The tables of rung k, and the matrix that continues a window of rung `previous`, if that is near enough.
    pub(super) fn rung(
        &mut self,
        rule: &Rule<POINTS>,
        k: i32,
        previous: Option<i32>,
    ) -> (&Tables<POINTS>, Option<&Matrix<POINTS>>) {
        let (order, is_exact, h) = (self.order, self.is_exact, self.length(k));
        let rung = self.rungs[(k + REACH) as usize].get_or_insert_with(|| {
            let tables = rule.tables(order, Compensated::from(h), is_exact);
            Box::new(Rung { tables, continuations: [const { None }; CONTINUED] })
        });
        let longer = previous.map(|previous| k - previous).filter(|j| (SHORTEST..=LONGEST).contains(j));
        let continuation = longer.map(|j| {
            let place = (j - SHORTEST) as usize;
            &**rung.continuations[place]
                .get_or_insert_with(|| rule.matrix(order.power_of(h), continued(rule, order, j)))
        });
        (&rung.tables, continuation)
    }

    /// Tables for one window of any length. It is guessed without the window before: that would save a few sweeps,
    /// which cost a tenth of the matrix for it.
    #[cold]
    pub(super) fn odd(&self, rule: &Rule<POINTS>, h: f64) -> Tables<POINTS> {
        rule.tables(self.order, Compensated::from(h), self.is_exact)
    }
}

/// A or A² after continuation by j rungs, for length 1, made once in the life of the program.
pub(super) fn continued<const N: usize>(rule: &Rule<N>, order: Order, j: i32) -> &'static [f64] {
    static TABLES: [OnceLock<Vec<f64>>; 4 * (MOST_POINTS + 1) * CONTINUED] =
        [const { OnceLock::new() }; 4 * (MOST_POINTS + 1) * CONTINUED];
    let kind = 2 * usize::from(rule.has_end()) + usize::from(order == Order::Second);
    let table = &TABLES[(4 * rule.points() + kind) * CONTINUED + (j - SHORTEST) as usize];
    table.get_or_init(|| rule.continued(order, 2.0_f64.powf(0.25 * f64::from(j))))
}
