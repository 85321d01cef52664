//! The elementary functions of intervals, from their values at points.

use super::{BOXES, Intervals, TINY};
use crate::formula::Function;

/// More than the functions of [`crate::number::vector::elementary`] and of the standard library are off by, relative to
/// the result: one unit in the last place, or two.
const ERROR: f64 = 4.0 * f64::EPSILON;

/// Angles that differ by more are not followed.
const WIDEST: f64 = 3.0;

/// The points at which the function is wanted, in the places of the bounds that follow from them.
pub(super) fn before(function: Function, x: &Intervals, to: &mut Intervals) {
    let (lo, hi) = x.0.split_at(BOXES);
    let (at_lo, at_hi) = to.0.split_at_mut(BOXES);
    for k in 0..BOXES {
        (at_lo[k], at_hi[k]) = match function {
            Function::Sqrt | Function::Ln | Function::Log10 => (lo[k].max(0.0), hi[k]),
            Function::Asin => (lo[k].max(-1.0), hi[k].min(1.0)),
            Function::Acos => (hi[k].min(1.0), lo[k].max(-1.0)),
            Function::Cosh | Function::Abs => (lo[k].max(-hi[k]).max(0.0), (-lo[k]).max(hi[k])),
            Function::Sin | Function::Cos if is_wide(lo[k], hi[k]) => (0.0, 0.0),
            Function::Sin | Function::Cos | Function::Tan | Function::Sinh | Function::Tanh => (lo[k], hi[k]),
            Function::Atan | Function::Exp | Function::Sign | Function::Step => (lo[k], hi[k]),
            Function::Table(_) => (lo[k], hi[k]),
        };
    }
}

fn is_wide(lo: f64, hi: f64) -> bool {
    // Also where it is NaN, as of infinities.
    let is_narrow = hi - lo <= WIDEST;
    !is_narrow
}

/// From the values there to an interval that holds all values on `x`.
pub(super) fn after(function: Function, x: &Intervals, out: &mut Intervals) {
    let (x_lo, x_hi) = x.0.split_at(BOXES);
    let (lo, hi) = out.0.split_at_mut(BOXES);
    for k in 0..BOXES {
        (lo[k], hi[k]) = match function {
            Function::Abs | Function::Sign | Function::Step => (lo[k], hi[k]),
            Function::Sin | Function::Cos => angle(x_lo[k], x_hi[k], lo[k], hi[k]),
            Function::Table(table) => table.bounds([x_lo[k], x_hi[k]]).into(),
            _ => interval(lo[k], hi[k], range(function)),
        };
    }
}

/// Where the values of a function are.
fn range(function: Function) -> [f64; 2] {
    match function {
        Function::Exp | Function::Sqrt | Function::Acos => [0.0, f64::INFINITY],
        Function::Cosh => [1.0, f64::INFINITY],
        Function::Tanh => [-1.0, 1.0],
        _ => [-f64::INFINITY, f64::INFINITY],
    }
}

/// Bounds from two values of a monotone function. Where it is not defined, nothing is known.
fn interval(at_lo: f64, at_hi: f64, [least, most]: [f64; 2]) -> (f64, f64) {
    if at_lo.is_nan() || at_hi.is_nan() || at_hi < at_lo {
        return (-f64::INFINITY, f64::INFINITY);
    }
    let (lo, hi) = (at_lo.min(f64::MAX), at_hi.max(-f64::MAX));
    ((lo - (lo.abs() * ERROR + TINY)).max(least), (hi + (hi.abs() * ERROR + TINY)).min(most))
}

/// Bounds of a sine or a cosine. As its second derivative is at most 1, it leaves the chord between its ends by at most
/// an eighth of the squared distance of these.
fn angle(x_lo: f64, x_hi: f64, at_lo: f64, at_hi: f64) -> (f64, f64) {
    if is_wide(x_lo, x_hi) {
        return (-1.0, 1.0);
    }
    let distance = x_hi - x_lo;
    let margin = distance * distance * (0.125 + ERROR) + ERROR;
    ((at_lo.min(at_hi) - margin).max(-1.0), (at_lo.max(at_hi) + margin).min(1.0))
}
