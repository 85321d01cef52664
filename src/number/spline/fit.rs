//! The spline through given points, from its even derivatives at the knots.

use super::Kind;
use crate::number::{Extended, Real};

/// Coefficients of a piece.
pub(super) const COEFFICIENTS: usize = 6;

/// The length and the slope of every interval between two points.
fn intervals(points: &[[Extended; 2]]) -> Vec<[Extended; 2]> {
    let interval = |pair: &[[Extended; 2]]| {
        let length = pair[1][0] - pair[0][0];
        [length, (pair[1][1] - pair[0][1]) / length]
    };
    points.windows(2).map(interval).collect()
}

/// M = s″ and N = s⁗ at every knot, for which s′ and s‴ on both sides of every inner knot agree. With the lengths h
/// and slopes Δ of the intervals before and after it
///
/// ```text
/// h₋M₋/6 + (h₋ + h₊)M/3 + h₊M₊/6 − (7h₋³N₋ + 8(h₋³ + h₊³)N + 7h₊³N₊)/360 = Δ₊ − Δ₋
/// h₋N₋/6 + (h₋ + h₊)N/3 + h₊N₊/6 = (M₊ − M)/h₊ − (M − M₋)/h₋        or N = 0, for degree 3
/// ```
///
/// (J. H. Ahlberg, E. N. Nilson, J. L. Walsh, The Theory of Splines, 1967). At an end the first one says s′ = 0 without
/// the interval that is missing, and the second one s‴ = 0 where N = 0.
pub(super) fn even_derivatives(points: &[[Extended; 2]], kind: Kind) -> Vec<[Extended; 2]> {
    let (zero, one, number) = (Extended::ZERO, Extended::ONE, |value: f64| Extended::from(value));
    let (intervals, last) = (intervals(points), points.len() - 1);
    let sixth = |[h, _]: [Extended; 2]| h / Extended::from(6.0);
    let third = |[h, _]: [Extended; 2]| h / Extended::from(3.0);
    let row = |k: usize, [of_before, of_here, of_after, of_known]: [fn([Extended; 2]) -> Extended; 4]| {
        let before = if k > 0 { Some(intervals[k - 1]) } else { None };
        let after = intervals.get(k).copied();
        let [left, right] = [before.map_or(zero, of_before), after.map_or(zero, of_after)];
        let here = [before, after].into_iter().flatten().fold(zero, |sum, interval| sum + of_here(interval));
        [left, here, right, after.map_or(zero, of_known) - before.map_or(zero, of_known)]
    };
    let slopes = |k: usize| {
        let [m_left, m, m_right, known] = row(k, [sixth, third, sixth, |[_, slope]| slope]);
        let cube = |[h, _]: [Extended; 2]| h * h * h / Extended::from(360.0);
        let [n_left, n, n_right, _] = row(k, [cube, cube, cube, |_| Extended::ZERO]);
        let [n_left, n, n_right] = [number(-7.0) * n_left, number(-8.0) * n, number(-7.0) * n_right];
        [zero, m_left, n_left, m, n, m_right, n_right, known]
    };
    let thirds = |k: usize| {
        let [n_left, n, n_right, _] = row(k, [sixth, third, sixth, |_| Extended::ZERO]);
        let inverse = |[h, _]: [Extended; 2]| Extended::ONE / h;
        let [m_left, m, m_right, _] = row(k, [inverse, inverse, inverse, |_| Extended::ZERO]);
        [-m_left, n_left, m, n, -m_right, n_right, zero, zero]
    };
    let only = |place: usize| std::array::from_fn(|i| if i == place { one } else { zero });
    // Columns are those from three before to three behind the diagonal, and then the right side.
    let rows = (0..=last).flat_map(|k| match (k == 0 || k == last, kind) {
        (true, Kind::Natural) => [only(3), only(3)],
        (false, Kind::Natural) | (_, Kind::Clamped) => [slopes(k), only(3)],
        (false, Kind::Quintic) => [slopes(k), thirds(k)],
        (true, Kind::Quintic) => {
            let [m_left, n_left, m, n, m_right, n_right, ..] = thirds(k);
            [[zero, m_left, n_left, m, n, m_right, n_right, zero], only(3)]
        }
    });
    let found = solved(rows.collect());
    found.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// Solves a system of seven diagonals by Gauss's elimination from the top: 70 digits leave room for what that loses.
fn solved(mut rows: Vec<[Extended; 8]>) -> Vec<Extended> {
    let count = rows.len();
    for pivot in 0..count {
        let above = rows[pivot];
        for below in 1..=3.min(count - 1 - pivot) {
            let row = &mut rows[pivot + below];
            let factor = row[3 - below] / above[3];
            (1..=3).for_each(|k| row[3 - below + k] -= factor * above[3 + k]);
            row[7] -= factor * above[7];
        }
    }
    let mut found = vec![Extended::ZERO; count + 3];
    for k in (0..count).rev() {
        let known = (1..=3).fold(rows[k][7], |sum, j| sum - rows[k][3 + j] * found[k + j]);
        found[k] = known / rows[k][3];
    }
    found.truncate(count);
    found
}

/// The coefficients of all pieces, from M = s″ and N = s⁗ at the knots.
pub(super) fn coefficients(points: &[[Extended; 2]], even: &[[Extended; 2]]) -> Vec<Extended> {
    let (zero, number) = (Extended::ZERO, |value: f64| Extended::from(value));
    let (intervals, last) = (intervals(points), points.len() - 1);
    // s′ at one end of an interval, where M and N are those at this end and at the other one.
    let slope = |[h, secant]: [Extended; 2], [m, n]: [Extended; 2], [m_other, n_other]: [Extended; 2]| {
        let by_fourth = h * h * h * (number(8.0) * n + number(7.0) * n_other) / number(360.0);
        secant - h * (m + m + m_other) / number(6.0) + by_fourth
    };
    let first_slope = slope(intervals[0], even[0], even[1]);
    let [length, secant] = intervals[last - 1];
    let last_slope = slope([-length, secant], even[last], even[last - 1]);
    let mut coefficients = vec![points[0][1], first_slope, zero, zero, zero, zero];
    for (k, &[h, secant]) in intervals.iter().enumerate() {
        let ([m, n], [m_next, n_next]) = (even[k], even[k + 1]);
        let third = (m_next - m) / h - h * (n + n + n_next) / number(6.0);
        let powers = [m.half(), third / number(6.0), n / number(24.0), (n_next - n) / (number(120.0) * h)];
        coefficients.extend([points[k][1], slope([h, secant], even[k], even[k + 1])]);
        coefficients.extend(powers);
    }
    coefficients.extend([points[last][1], last_slope, zero, zero, zero, zero]);
    coefficients
}
