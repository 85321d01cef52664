//! Integrals over γ by the operator of a window: u with du/dγ = r and u = 0 at the start.

use super::newton::{Failure, ROUNDING_UNITS, gains, tolerance};
use super::piece::Problem;
use super::status::Status;
use crate::linalg::Singular;
use crate::linalg::banded::solve_banded;
use crate::number::Real;
use crate::number::norm::max_abs;

/// u on the nodes of `window`, where `h_rate` is h r at a node, with iterative refinement: one round for `f64`, as many
/// as the digits need otherwise. `rough` is the window in `f64`.
pub(super) fn integral<S: Real>(
    window: &Problem<'_, S>,
    rough: &Problem<'_, f64>,
    h_rate: impl Fn(usize) -> S,
) -> Result<Vec<S>, Failure> {
    let (derivative, rough) = (window.derivative(), rough.derivative());
    let (first, unknowns) = (derivative.first_unknown(), derivative.unknowns());
    let (h, h_rough, (lower, upper)) = (window.sbp.spacing(), rough.sbp.spacing(), rough.reach());
    let [mut u, mut slope] = [(); 2].map(|()| vec![S::ZERO; window.points()]);
    let (mut right, mut before) = (vec![0.0; unknowns], S::from(f64::INFINITY));
    let tolerance: S = tolerance(window.settings.digits);
    for round in 0.. {
        let missing = |k: usize| h_rate(k) - h * slope[k];
        // With more digits it is scaled, so that it fits into the range of f64.
        let largest = || (0..unknowns).fold(S::ZERO, |largest, k| largest.max(missing(k).abs()));
        let scale = if S::IS_EXTENDED { largest() } else { S::ONE };
        if scale == S::ZERO {
            break;
        }
        right.iter_mut().enumerate().for_each(|(k, right)| *right = (missing(k) / scale).to_f64());
        let solved = solve_banded(lower, upper, &mut right, |k, row| {
            row.fill(0.0);
            rough.row(k).for_each(|(column, d)| row[column + lower - k] += h_rough * d);
        });
        solved.map_err(|Singular| Failure::without_iterate(Status::Singular))?;
        let (change, size) = (scale * S::from(max_abs(&right)), max_abs(&u));
        let is_last = if S::IS_EXTENDED { change <= tolerance * size } else { round == 1 };
        if S::IS_EXTENDED && !is_last && !gains(change, before) {
            let rounding = ROUNDING_UNITS * derivative.sbp.row_sum() * S::EPSILON.to_f64() * size.to_f64();
            let is_rounding = scale.to_f64() <= rounding;
            return if is_rounding { Ok(u) } else { Err(Failure::without_iterate(Status::PrecisionNotReached)) };
        }
        u[first..].iter_mut().zip(&right).for_each(|(u, &change)| *u += scale * S::from(change));
        if is_last {
            break;
        }
        before = change;
        derivative.apply(&u, S::ZERO, &mut slope);
    }
    Ok(u)
}
