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
    let (number, last) = (|value: f64| Extended::from(value), points.len() - 1);
    // Columns are those from three before to three behind the diagonal, and then the right side. Unknowns are M and N
    // of the first knot, then of the second one, and so on.
    let mut rows = vec![[Extended::ZERO; 8]; 2 * points.len()];
    let mut add = |row: usize, factors: [(usize, Extended); 4], known: Extended| {
        let factors = factors.into_iter().filter(|(_, factor)| !factor.eq_zero());
        factors.for_each(|(unknown, factor)| rows[row][3 + unknown - row] += factor);
        rows[row][7] += known;
    };
    let (of_six, of_cube) = (Extended::ONE / number(6.0), Extended::ONE / number(360.0));
    for (k, [h, slope]) in intervals(points).into_iter().enumerate() {
        let sixth = h * of_six;
        let third = sixth + sixth;
        // N is 0 where the degree is 3.
        let (inverse, cube) = match kind {
            Kind::Quintic => (Extended::ONE / h, h * h * h * of_cube),
            _ => (Extended::ZERO, Extended::ZERO),
        };
        for (knot, other, slope) in [(k, k + 1, slope), (k + 1, k, -slope)] {
            let ([m, n], [m_other, n_other]) = ([2 * knot, 2 * knot + 1], [2 * other, 2 * other + 1]);
            let is_end = knot == 0 || knot == last;
            if kind == Kind::Clamped || !is_end {
                let fourth = [(n, number(-8.0)), (n_other, number(-7.0))].map(|(of, factor)| (of, factor * cube));
                add(m, [(m, third), (m_other, sixth), fourth[0], fourth[1]], slope);
            }
            if kind == Kind::Quintic {
                let row = if is_end { m } else { n };
                add(row, [(n, third), (n_other, sixth), (m, inverse), (m_other, -inverse)], Extended::ZERO);
            }
        }
    }
    // What nothing is said about is zero.
    rows.iter_mut().filter(|row| row[3] == Extended::ZERO).for_each(|row| row[3] = Extended::ONE);
    solved(rows).as_chunks().0.to_vec()
}

/// Solves a system of seven diagonals by Gauss's elimination from the top: 70 digits leave room for what that loses. Of
/// splines of degree 3 most of the diagonals are zeros, which are passed over.
fn solved(mut rows: Vec<[Extended; 8]>) -> Vec<Extended> {
    let count = rows.len();
    for pivot in 0..count {
        let above = rows[pivot];
        for below in 1..=3.min(count - 1 - pivot) {
            let row = &mut rows[pivot + below];
            if row[3 - below].eq_zero() {
                continue;
            }
            let factor = row[3 - below] / above[3];
            (1..=4).filter(|k| !above[3 + k].eq_zero()).for_each(|k| {
                let column = if k == 4 { 7 } else { 3 - below + k };
                row[column] -= factor * above[3 + k];
            });
        }
    }
    let mut found = vec![Extended::ZERO; count + 3];
    for k in (0..count).rev() {
        let row = &rows[k];
        let factors = (1..=3).filter(|j| !row[3 + j].eq_zero());
        let known = factors.fold(row[7], |sum, j| sum - row[3 + j] * found[k + j]);
        found[k] = if known.eq_zero() { known } else { known / row[3] };
    }
    found.truncate(count);
    found
}

/// The coefficients of all pieces, from M = s″ and N = s⁗ at the knots.
pub(super) fn coefficients(points: &[[Extended; 2]], even: &[[Extended; 2]]) -> Vec<Extended> {
    let (zero, number) = (Extended::ZERO, |value: f64| Extended::from(value));
    let (intervals, last) = (intervals(points), points.len() - 1);
    // s′ at one end of an interval, where M and N are those at this end and at the other one.
    let of_six = Extended::ONE / number(6.0);
    let slope = |[h, secant]: [Extended; 2], [m, n]: [Extended; 2], [m_other, n_other]: [Extended; 2]| {
        let cubic = secant - h * (m + m + m_other) * of_six;
        if n.eq_zero() && n_other.eq_zero() {
            return cubic;
        }
        cubic + h * h * h * (number(8.0) * n + number(7.0) * n_other) / number(360.0)
    };
    let first_slope = slope(intervals[0], even[0], even[1]);
    let [length, secant] = intervals[last - 1];
    let last_slope = slope([-length, secant], even[last], even[last - 1]);
    let mut coefficients = vec![points[0][1], first_slope, zero, zero, zero, zero];
    for (k, &[h, secant]) in intervals.iter().enumerate() {
        let ([m, n], [m_next, n_next]) = (even[k], even[k + 1]);
        let third = (m_next - m) / h;
        let powers = if n.eq_zero() && n_next.eq_zero() {
            [m.half(), third * of_six, zero, zero]
        } else {
            let third = third - h * (n + n + n_next) * of_six;
            [m.half(), third * of_six, n / number(24.0), (n_next - n) / (number(120.0) * h)]
        };
        coefficients.extend([points[k][1], slope([h, secant], even[k], even[k + 1])]);
        coefficients.extend(powers);
    }
    coefficients.extend([points[last][1], last_slope, zero, zero, zero, zero]);
    coefficients
}
