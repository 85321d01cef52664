//! Functions that are known by values at points, the knots: cubic splines between them.

use std::sync::{Mutex, OnceLock};

use super::{Constants, Extended, Real};

/// The most different tables of one process.
const MOST_TABLES: usize = 256;

/// The condition at the outer knots of a spline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ends {
    /// The second derivative is zero at both outer knots.
    Natural,
    /// The first derivative is zero at both outer knots.
    Clamped,
}

/// The values of a spline outside of its knots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outside {
    /// It has no value there.
    Refused,
    /// It goes on as its tangent at the outer knot.
    Linear,
}

/// A mistake in the points of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TableError {
    /// There are fewer than three points.
    #[error("a table needs three points at least, and this one has {0}")]
    TooFew(usize),
    /// A point is not beyond the one before; its index.
    #[error("the arguments of a table must increase, and that of point {} does not", .0 + 1)]
    NotIncreasing(usize),
    /// A number is not finite, or differences of numbers are not; the index of the point.
    #[error("point {} of the table is not finite", .0 + 1)]
    NotFinite(usize),
    /// The process has as many tables as it can have.
    #[error("there are more than {MOST_TABLES} different tables")]
    TooMany,
}

/// A derivative of a spline, as a function of formulas. Equal tables are one, which lives as long as the process.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Table {
    index: u16,
    derivative: u8,
}

/// A cubic spline of class C²: between neighbouring knots a polynomial of degree 3.
#[derive(Debug)]
struct Spline {
    knots: Constants,
    /// Four for each of the n + 1 pieces, in powers of the distance from the knot at their left: first the tangent at
    /// the first knot, then the polynomials, and then the tangent at the last knot.
    coefficients: Constants,
    outside: Outside,
}

static TABLES: [OnceLock<Spline>; MOST_TABLES] = [const { OnceLock::new() }; MOST_TABLES];
/// Held while a table is looked for and added.
static ADDING: Mutex<()> = Mutex::new(());

impl Table {
    /// The spline through these points.
    ///
    /// # Errors
    /// [`TableError`], if these are no points of a function.
    pub fn new(points: &[[Extended; 2]], ends: Ends, outside: Outside) -> Result<Self, TableError> {
        let spline = Spline::new(points, ends, outside)?;
        let _adding = ADDING.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let is_free = |place: &OnceLock<Spline>| place.get().is_none_or(|known| known.is_same(&spline));
        let index = TABLES.iter().position(is_free).ok_or(TableError::TooMany)?;
        TABLES[index].get_or_init(|| spline);
        Ok(Self { index: index as u16, derivative: 0 })
    }

    /// The derivative of this function; `None` where it is zero.
    pub(crate) fn derivative(self) -> Option<Self> {
        (self.derivative < 3).then_some(Self { derivative: self.derivative + 1, ..self })
    }

    fn spline(self) -> &'static Spline {
        TABLES[usize::from(self.index)].get().expect("a table is there before it has an index")
    }

    /// The value at `u`; NaN where there is none.
    pub(crate) fn at<S: Real>(self, u: S) -> S {
        let at = |piece: usize| self.of_piece(piece, usize::from(self.derivative), u);
        self.piece(u).map_or_else(|| S::from(f64::NAN), at)
    }

    /// A derivative of the polynomial of a piece at `u`, by Horner's rule.
    fn of_piece<S: Real>(self, piece: usize, order: usize, u: S) -> S {
        let spline = self.spline();
        let distance = u - S::constants(&spline.knots)[piece.max(1) - 1];
        let coefficients = &S::constants(&spline.coefficients)[4 * piece..][..4];
        (order..4).rev().fold(S::ZERO, |sum, power| {
            let falling = (power + 1 - order..=power).product::<usize>();
            sum * distance + S::from(falling as f64) * coefficients[power]
        })
    }

    /// The Taylor coefficients of this function at `u`, on the piece there.
    pub(crate) fn expansion<S: Real>(self, u: S) -> [S; 4] {
        let (first, mut factorial) = (usize::from(self.derivative), S::ONE);
        std::array::from_fn(|k| {
            factorial *= S::from(k.max(1) as f64);
            let value = |piece: usize| if first + k < 4 { self.of_piece(piece, first + k, u) } else { S::ZERO };
            self.piece(u).map_or_else(|| S::from(f64::NAN), value) / factorial
        })
    }

    /// The piece that holds at `u`; `None` where nothing does. At a knot it is the one to the right, at the last knot
    /// the one to the left.
    pub(crate) fn piece<S: Real>(self, u: S) -> Option<usize> {
        let spline = self.spline();
        let knots = S::constants(&spline.knots);
        let piece = knots.partition_point(|&knot| knot <= u);
        let last = knots.len();
        if u == knots[last - 1] {
            return Some(last - 1);
        }
        // A NaN is below no knot.
        let is_inside = 0 < piece && piece < last;
        let is_outside = u < knots[0] || piece == last;
        (is_inside || is_outside && spline.outside == Outside::Linear).then_some(piece)
    }

    /// The number of knots between two arguments, the second of which is larger; `None` where there is no value.
    pub(crate) fn passed(self, [low, high]: [f64; 2]) -> Option<usize> {
        self.piece(high)?.checked_sub(self.piece(low)?)
    }

    /// Bounds of the values between two arguments.
    pub(crate) fn bounds(self, [low, high]: [f64; 2]) -> [f64; 2] {
        // Nothing is known of arguments without bounds, nor where there is no value.
        let is_bounded = low.is_finite() && high.is_finite() && low <= high;
        let (Some(first), Some(last), true) = (self.piece(low), self.piece(high), is_bounded) else {
            return [-f64::INFINITY, f64::INFINITY];
        };
        let knots = f64::constants(&self.spline().knots);
        (first..=last).fold([f64::INFINITY, -f64::INFINITY], |[least, most], piece| {
            let from = if piece == 0 { low } else { knots[piece - 1].max(low) };
            let to = knots.get(piece).map_or(high, |&knot| knot.min(high));
            let [lower, upper] = self.bounds_of_piece(piece, from, to.max(from));
            [least.min(lower), most.max(upper)]
        })
    }

    /// Bounds on a part of a piece, by the Taylor series at its middle: |p(u) − p(m)| ≤ Σ |p⁽ʲ⁾(m)| rʲ/j!.
    fn bounds_of_piece(self, piece: usize, from: f64, to: f64) -> [f64; 2] {
        let (middle, half) = (0.5 * from + 0.5 * to, 0.5 * (to - from));
        let first = usize::from(self.derivative);
        let value = self.of_piece(piece, first, middle);
        let (mut radius, mut factor) = (0.0, 1.0);
        for order in first + 1..4 {
            factor *= half / (order - first) as f64;
            radius += (self.of_piece(piece, order, middle) * factor).abs();
        }
        // The terms that of_piece adds up may be larger than their sum.
        let knot = f64::constants(&self.spline().knots)[piece.max(1) - 1];
        let coefficients = &f64::constants(&self.spline().coefficients)[4 * piece..][..4];
        let reach = (from - knot).abs().max((to - knot).abs());
        let size = coefficients[first..].iter().rev().fold(0.0, |sum, c| sum * reach + 6.0 * c.abs());
        let margin = radius + 8.0 * f64::EPSILON * size + f64::MIN_POSITIVE;
        [value - margin, value + margin]
    }
}

impl Spline {
    fn new(points: &[[Extended; 2]], ends: Ends, outside: Outside) -> Result<Self, TableError> {
        if points.len() < 3 {
            return Err(TableError::TooFew(points.len()));
        }
        let is_finite = |point: &[Extended; 2]| point.iter().all(|number| number.to_f64().is_finite());
        if let Some(index) = points.iter().position(|point| !is_finite(point)) {
            return Err(TableError::NotFinite(index));
        }
        // Knots must be different in f64, too.
        if let Some(index) = points.windows(2).position(|pair| pair[0][0].to_f64() >= pair[1][0].to_f64()) {
            return Err(TableError::NotIncreasing(index + 1));
        }
        let coefficients = coefficients(points, &second_derivatives(points, ends));
        if let Some(place) = coefficients.iter().position(|number| !number.to_f64().is_finite()) {
            return Err(TableError::NotFinite((place / 4).min(points.len() - 1)));
        }
        let knots = points.iter().map(|point| point[0]).collect();
        Ok(Self { knots: Constants::new(knots), coefficients: Constants::new(coefficients), outside })
    }

    fn is_same(&self, other: &Self) -> bool {
        let same = |one: &Constants, other: &Constants| Extended::constants(one) == Extended::constants(other);
        let are_same = same(&self.knots, &other.knots) && same(&self.coefficients, &other.coefficients);
        self.outside == other.outside && are_same
    }
}

/// The length and the slope of every interval between two points.
fn intervals(points: &[[Extended; 2]]) -> Vec<[Extended; 2]> {
    let interval = |pair: &[[Extended; 2]]| {
        let length = pair[1][0] - pair[0][0];
        [length, (pair[1][1] - pair[0][1]) / length]
    };
    points.windows(2).map(interval).collect()
}

/// s″ at the knots, for which the first derivatives on both sides of every inner knot agree:
/// h₋ s″₋ + 2 (h₋ + h₊) s″ + h₊ s″₊ = 6 (slope₊ − slope₋) (C. de Boor, A Practical Guide to Splines, 2001, chapter IV).
fn second_derivatives(points: &[[Extended; 2]], ends: Ends) -> Vec<Extended> {
    let (zero, intervals) = (Extended::ZERO, intervals(points));
    let last = points.len() - 1;
    // A row is the entry on the diagonal, the one to its right, and the right side; matrices are symmetric.
    let row = |k: usize| {
        let [before, slope_before] = if k > 0 { intervals[k - 1] } else { [zero; 2] };
        let [after, slope_after] = if k < last { intervals[k] } else { [zero; 2] };
        match (k == 0 || k == last, ends) {
            (true, Ends::Natural) => [Extended::ONE, zero, zero],
            _ => [Extended::from(2.0) * (before + after), after, Extended::from(6.0) * (slope_after - slope_before)],
        }
    };
    // Gauss's elimination from the top; the matrix is diagonally dominant.
    let mut rows: Vec<[Extended; 3]> = vec![row(0)];
    for k in 1..=last {
        let ([diagonal, right, known], [above, beside, known_above]) = (row(k), rows[k - 1]);
        let left = if k == last && ends == Ends::Natural { zero } else { intervals[k - 1][0] };
        let factor = left / above;
        rows.push([diagonal - factor * beside, right, known - factor * known_above]);
    }
    let mut found = vec![zero; points.len() + 1];
    for k in (0..=last).rev() {
        let [diagonal, right, known] = rows[k];
        found[k] = (known - right * found[k + 1]) / diagonal;
    }
    found.pop();
    found
}

/// The coefficients of all pieces.
fn coefficients(points: &[[Extended; 2]], second: &[Extended]) -> Vec<Extended> {
    let (zero, half, sixth) = (Extended::ZERO, Extended::from(0.5), Extended::ONE / Extended::from(6.0));
    let (intervals, last) = (intervals(points), points.len() - 1);
    let slope = |k: usize| intervals[k][1] - intervals[k][0] * sixth * (second[k] + second[k] + second[k + 1]);
    let [length, secant] = intervals[last - 1];
    let last_slope = secant + length * sixth * (second[last - 1] + second[last] + second[last]);
    let mut coefficients = vec![points[0][1], slope(0), zero, zero];
    for (k, &[length, _]) in intervals.iter().enumerate() {
        let third = sixth * (second[k + 1] - second[k]) / length;
        coefficients.extend([points[k][1], slope(k), half * second[k], third]);
    }
    coefficients.extend([points[last][1], last_slope, zero, zero]);
    coefficients
}

#[cfg(test)]
mod tests {
    use super::{Ends, Outside, Table, TableError};
    use crate::number::{Extended, Real};

    fn points(f: impl Fn(f64) -> f64, knots: &[f64]) -> Vec<[Extended; 2]> {
        knots.iter().map(|&x| [x, f(x)].map(Extended::from)).collect()
    }

    /// Knots at uneven distances.
    const KNOTS: [f64; 7] = [-2.0, -1.5, -0.25, 0.0, 1.0, 1.25, 3.0];

    fn table(ends: Ends, outside: Outside) -> Table {
        Table::new(&points(|x| (1.0 + x * x).ln() - x, &KNOTS), ends, outside).unwrap()
    }

    /// In 70 digits nothing but rounding is left of the difference between both sides of a knot.
    #[test]
    fn a_spline_takes_its_values_and_is_smooth_at_knots() {
        for ends in [Ends::Natural, Ends::Clamped] {
            let table = table(ends, Outside::Refused);
            for (k, &knot) in KNOTS.iter().enumerate() {
                let at = Extended::from(knot);
                let value = Extended::from((1.0 + knot * knot).ln() - knot);
                assert!((table.at(at) - value).abs().to_f64() < 1e-68, "{knot}");
                if k == 0 || k + 1 == KNOTS.len() {
                    continue;
                }
                for order in 0..3 {
                    let [left, right] = [k, k + 1].map(|piece| table.of_piece(piece, order, at));
                    assert!((left - right).abs().to_f64() < 1e-66, "{knot} {order}");
                }
            }
            let free = if ends == Ends::Natural { 2 } else { 1 };
            for (piece, knot) in [(1, KNOTS[0]), (6, KNOTS[6])] {
                let end = table.of_piece(piece, free, Extended::from(knot));
                assert!(end.abs().to_f64() < 1e-66, "{ends:?} {knot}");
            }
        }
    }

    /// The values in the middle of intervals are those of scipy.interpolate.CubicSpline.
    #[test]
    fn splines_are_those_of_other_programs() {
        let cube = points(|x| x * x * x, &[0.0, 1.0, 2.0, 4.0]);
        let natural = Table::new(&cube, Ends::Natural, Outside::Refused).unwrap();
        let clamped = Table::new(&cube, Ends::Clamped, Outside::Refused).unwrap();
        for (table, expected) in [
            (natural, [0.255_434_782_608_695_57, 2.983_695_652_173_913, 30.913_043_478_260_867]),
            (clamped, [0.397_727_272_727_272_7, 2.011_363_636_363_636_2, 41.181_818_181_818_18]),
        ] {
            for (x, expected) in [0.5, 1.5, 3.0].into_iter().zip(expected) {
                let found: f64 = table.at(x);
                assert!((found - expected).abs() < 1e-14, "{x}: {found} is not {expected}");
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_the_values() {
        let mut table = table(Ends::Natural, Outside::Linear);
        for _ in 0..3 {
            let slope = table.derivative().unwrap();
            for u in [-3.0, -1.8, -0.1, 0.6, 2.0, 4.0] {
                let [left, right] = [-1.0, 1.0].map(|side| table.at(Extended::from(u + 1e-6 * side)));
                let difference = ((right - left) / Extended::from(2e-6)).to_f64();
                let found: f64 = slope.at(u);
                assert!((found - difference).abs() < 1e-8 * (1.0 + found.abs()), "{u}: {found} {difference}");
                let [value, first, ..] = table.expansion(u);
                assert_eq!([value, first], [table.at(u), found]);
            }
            table = slope;
        }
        assert_eq!(table.derivative(), None);
    }

    #[test]
    fn bounds_hold_every_value() {
        let mut table = Some(table(Ends::Clamped, Outside::Linear));
        while let Some(of) = table {
            for low in [-3.0, -2.0, -1.6, -0.3, 0.1, 1.0, 2.9, 3.5] {
                for width in [0.0, 1e-9, 0.1, 0.7, 4.0] {
                    let [least, most] = of.bounds([low, low + width]);
                    for k in 0..=100 {
                        let value: f64 = of.at(low + width * f64::from(k) / 100.0);
                        assert!(least <= value && value <= most, "{low} {width}: {value} {least} {most}");
                    }
                }
            }
            table = of.derivative();
        }
    }

    #[test]
    fn nothing_is_known_of_arguments_without_bounds() {
        let [refused, linear] = [Outside::Refused, Outside::Linear].map(|outside| table(Ends::Natural, outside));
        let nothing = [f64::NEG_INFINITY, f64::INFINITY];
        for ends in [nothing, [f64::NEG_INFINITY, 0.0], [0.0, f64::INFINITY], [f64::NAN, 0.0], [1.0, 0.0]] {
            assert_eq!([refused.bounds(ends), linear.bounds(ends)], [nothing; 2], "{ends:?}");
        }
        assert_eq!(refused.bounds([2.0, 3.5]), nothing);
        assert_eq!([linear.passed([1.0, -1.0]), linear.passed([-3.0, 4.0])], [None, Some(7)]);
    }

    #[test]
    fn outside_of_its_knots_a_spline_is_refused_or_its_tangent() {
        let [refused, linear] = [Outside::Refused, Outside::Linear].map(|outside| table(Ends::Natural, outside));
        for u in [-2.1, 3.000_001, f64::INFINITY, f64::NAN] {
            assert!(refused.at(u).is_nan(), "{u}");
        }
        assert!(linear.at(f64::NAN).is_nan());
        let slope = linear.derivative().unwrap();
        for (end, u) in [(-2.0, -5.0), (3.0, 7.0)] {
            assert!((linear.at(u) - (linear.at(end) + (u - end) * slope.at(end))).abs() < 1e-14, "{u}");
        }
    }

    #[test]
    fn equal_tables_are_one_and_bad_points_are_refused() {
        assert_eq!(table(Ends::Natural, Outside::Linear), table(Ends::Natural, Outside::Linear));
        assert_ne!(table(Ends::Natural, Outside::Linear), table(Ends::Clamped, Outside::Linear));
        let mistake = |knots: &[f64]| Table::new(&points(|x| x, knots), Ends::Natural, Outside::Refused).unwrap_err();
        assert_eq!(mistake(&[0.0, 1.0]), TableError::TooFew(2));
        assert_eq!(mistake(&[0.0, 1.0, 1.0, 2.0]), TableError::NotIncreasing(2));
        assert_eq!(mistake(&[0.0, f64::NAN, 1.0]), TableError::NotFinite(1));
    }
}
