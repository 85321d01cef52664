//! One window: the work that is compiled for every level of instructions.

use pulp::{Simd, WithSimd};

use super::State;
use super::force::Force;
use super::guess::Guess;
use super::tables::Tables;
use super::window::{Precision, Solved, Window};
use crate::number::vector::{Level, Nodes};

/// A window from `start`; `None` if it does not converge or does not stay inside g00 > 0.
pub(super) struct One<'r, const P: usize, F> {
    pub(super) tables: &'r Tables<P>,
    /// What to judge it by, if it is to be judged.
    pub(super) tail: Option<&'r [Nodes<P>; 2]>,
    pub(super) force: &'r mut F,
    pub(super) window: &'r mut Window<P>,
    pub(super) start: &'r State,
    pub(super) guess: Guess<'r, P>,
    pub(super) precision: Precision,
}

impl<const P: usize, F: Force> One<'_, P, F> {
    /// The same with the instructions of `level`. Where something overflows on the way to finite forces, these are
    /// mended from then on.
    pub(super) fn solve(self, level: Level) -> Option<Solved> {
        let Self { tables, tail, force, window, start, guess, precision } = self;
        let solved = level.dispatch(One { tables, tail, force, window, start, guess, precision });
        if solved.is_some() || window.is_finite() {
            return solved;
        }
        force.mend(true)?;
        let guess = Guess::Parabola;
        let solved = level.dispatch(One { tables, tail, force, window, start, guess, precision });
        let is_mended = force.mend(true)?;
        force.mend(is_mended);
        solved
    }
}

impl<const P: usize, F: Force> WithSimd for One<'_, P, F> {
    type Output = Option<Solved>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) -> Option<Solved> {
        let Self { tables, tail, force, window, start, mut guess, precision } = self;
        loop {
            let solved = window.solve(s, tables, force, start, guess, precision);
            // A guess can be far off, even outside the domain: try once more from the parabola.
            if solved.is_none() && !matches!(guess, Guess::Parabola) {
                guess = Guess::Parabola;
                continue;
            }
            let solved = solved?;
            return Some(match tail {
                Some(tail) => window.judge(s, tail, solved),
                None => solved,
            });
        }
    }
}
