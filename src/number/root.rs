//! The root of a function between two places where it has different signs.

use crate::number::Real;

/// Most steps of a search; bisection alone would take as many in extended precision.
const MOST_STEPS: usize = 1000;
/// Every so many steps are a bisection, so that a bracket shrinks whatever the function.
const BISECTION: usize = 4;

/// Where `f` changes its sign between two places with their values, up to `least`: regula falsi in the form that is
/// called Illinois (M. Dowell and P. Jarratt, BIT 11 (1971) 168).
pub(crate) fn root<S: Real>(low: [S; 2], high: [S; 2], least: S, mut f: impl FnMut(S) -> S) -> S {
    try_root(low, high, least, |at| Some(f(at))).expect("the function has a value everywhere")
}

/// The same of a function that may have no value; `None` if it has none at a place that is tried.
pub(crate) fn try_root<S: Real>(low: [S; 2], high: [S; 2], least: S, mut f: impl FnMut(S) -> Option<S>) -> Option<S> {
    let ([mut low, mut at_low], [mut high, mut at_high]) = (low, high);
    let side = at_low.signum();
    // The sizes of the values at both ends, of which regula falsi halves one.
    let mut sizes = [at_low, at_high].map(S::abs);
    let mut last = S::ZERO;
    for step in 1..=MOST_STEPS {
        let middle = (low + high).half();
        let falsi = low + (high - low) * (at_low / (at_low - at_high));
        let at = if step % BISECTION == 0 {
            middle
        } else if falsi > low && falsi < high {
            falsi
        } else {
            // An end is the root as far as the straight line tells: the other side should be right beside it.
            let beside = if falsi >= high { high - least } else { low + least };
            if beside > low && beside < high { beside } else { middle }
        };
        if high - low <= least || at <= low || at >= high {
            break;
        }
        let here = f(at)?;
        if here == S::ZERO {
            return Some(at);
        }
        let is_before = here.signum() == side;
        if is_before {
            (low, at_low, sizes[0]) = (at, here, here.abs());
        } else {
            (high, at_high, sizes[1]) = (at, here, here.abs());
        }
        // The end that stays twice counts half.
        if here.signum() == last && step > 1 {
            if is_before { at_high = at_high.half() } else { at_low = at_low.half() }
        }
        last = here.signum();
    }
    Some(if sizes[0] < sizes[1] { low } else { high })
}
