//! Functions that are known by values at points, the knots: splines of degree 3 or 5 between them.

mod fit;

use std::sync::{Mutex, OnceLock};

use super::{Constants, Extended, Real};
use fit::{COEFFICIENTS, coefficients, even_derivatives};

/// The most different tables of one process.
const MOST_TABLES: usize = 256;

/// The degree of a spline, and its condition at the outer knots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Degree 3, of class C²; the second derivative is zero at both outer knots.
    Natural,
    /// Degree 3, of class C²; the first derivative is zero at both outer knots.
    Clamped,
    /// Degree 5, of class C⁴; the third and the fourth derivative are zero at both outer knots.
    Quintic,
}

impl Kind {
    fn degree(self) -> usize {
        if self == Self::Quintic { 5 } else { 3 }
    }
}

/// An argument is at the end of a table if it is behind it by no more than so many units in the last place of the
/// largest knot: γ, its origin and a shift of t are rounded once each, and an argument is a formula of them.
const AT_END: f64 = 8.0;

/// The values of a spline outside of its knots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outside {
    /// It has no value there.
    Refused,
    /// It goes on as its tangent at the outer knot.
    Linear,
}

/// A mistake in the points of a table, and what to do.
#[derive(Debug, PartialEq)]
pub struct TableError(pub String, pub Option<String>);

/// A derivative of a spline, as a function of formulas. Equal tables are one, which lives as long as the process.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Table {
    index: u16,
    derivative: u8,
}

/// A spline: between neighbouring knots a polynomial.
#[derive(Debug)]
struct Spline {
    degree: usize,
    knots: Constants,
    /// [`COEFFICIENTS`] for each of the n + 1 pieces, in powers of the distance from the knot at their left: first the
    /// tangent at the first knot, then the polynomials, and then the tangent at the last knot.
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
    pub fn new(points: &[[Extended; 2]], kind: Kind, outside: Outside) -> Result<Self, TableError> {
        let spline = Spline::new(points, kind, outside)?;
        let _adding = ADDING.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let is_free = |place: &OnceLock<Spline>| place.get().is_none_or(|known| known.is_same(&spline));
        let index = TABLES.iter().position(is_free).ok_or_else(|| {
            let help = "use fewer tables in one process".to_owned();
            TableError(format!("there are more than {MOST_TABLES} different tables"), Some(help))
        })?;
        TABLES[index].get_or_init(|| spline);
        Ok(Self { index: index as u16, derivative: 0 })
    }

    /// The derivative of this function; `None` where it is zero.
    pub(crate) fn derivative(self) -> Option<Self> {
        let is_constant = usize::from(self.derivative) == self.spline().degree;
        (!is_constant).then_some(Self { derivative: self.derivative + 1, ..self })
    }

    /// True if both are derivatives of one function, or that.
    pub(crate) fn is_of(self, other: Self) -> bool {
        self.index == other.index
    }

    /// The first knot and the last one.
    pub(crate) fn ends(self) -> [f64; 2] {
        let knots = f64::constants(&self.spline().knots);
        [knots[0], knots[knots.len() - 1]]
    }

    /// The number of derivatives of this function that are continuous at knots.
    pub(crate) fn smoothness(self) -> usize {
        self.spline().degree.saturating_sub(1 + usize::from(self.derivative))
    }

    fn spline(self) -> &'static Spline {
        TABLES[usize::from(self.index)].get().expect("a table is there before it has an index")
    }

    /// The value at `u`; NaN where there is none.
    pub(crate) fn at<S: Real>(self, u: S) -> S {
        self.piece(u).map_or(S::from(f64::NAN), |piece| self.of_piece(piece, usize::from(self.derivative), u))
    }

    /// A derivative of the polynomial of a piece at `u`, by Horner's rule.
    fn of_piece<S: Real>(self, piece: usize, order: usize, u: S) -> S {
        let spline = self.spline();
        let distance = u - S::constants(&spline.knots)[piece.max(1) - 1];
        let coefficients = &S::constants(&spline.coefficients)[COEFFICIENTS * piece..][..COEFFICIENTS];
        (order..=spline.degree).rev().fold(S::ZERO, |sum, power| {
            let falling = (power + 1 - order..=power).product::<usize>();
            sum * distance + S::from(falling as f64) * coefficients[power]
        })
    }

    /// The Taylor coefficients of this function at `u`, on the piece there.
    pub(crate) fn expansion<S: Real>(self, u: S) -> [S; COEFFICIENTS] {
        let (first, mut factorial) = (usize::from(self.derivative), S::ONE);
        std::array::from_fn(|k| {
            factorial *= S::from(k.max(1) as f64);
            let value = |piece: usize| self.of_piece(piece, first + k, u);
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
        if is_inside || is_outside && spline.outside == Outside::Linear {
            return Some(piece);
        }
        // Rounding may put an argument behind the end that it comes to.
        let margin = S::from(AT_END * f64::EPSILON) * knots[0].abs().max(knots[last - 1].abs());
        let is_at_start = u < knots[0] && knots[0] - u <= margin;
        let is_at_end = piece == last && u - knots[last - 1] <= margin;
        if is_at_start { Some(1) } else { is_at_end.then_some(last - 1) }
    }

    /// The knots at both ends of a piece, the coefficients of its polynomial in powers of the distance from the first
    /// of them; `None` beyond the outer knots, and of a derivative.
    pub(crate) fn polynomial<S: Real>(self, piece: usize) -> Option<([S; 2], &'static [S])> {
        let spline = self.spline();
        let knots = S::constants(&spline.knots);
        let ends = [*knots.get(piece.checked_sub(1)?)?, *knots.get(piece)?];
        let coefficients = &S::constants(&spline.coefficients)[COEFFICIENTS * piece..][..=spline.degree];
        (self.derivative == 0).then_some((ends, coefficients))
    }

    /// The knots on both sides of `u`, which may be the ends of what is known of the function.
    pub(crate) fn neighbours<S: Real>(self, u: S) -> impl Iterator<Item = S> {
        let knots = S::constants(&self.spline().knots);
        let above = knots.partition_point(|&knot| knot <= u);
        let below = knots[..above].iter().rposition(|&knot| knot < u);
        below.map(|below| knots[below]).into_iter().chain(knots.get(above).copied())
    }

    /// The knots from one argument to another, in this order.
    pub(crate) fn between(self, from: f64, to: f64) -> impl Iterator<Item = f64> {
        let knots = f64::constants(&self.spline().knots);
        let [low, high] = [from.min(to), from.max(to)];
        let first = knots.partition_point(|&knot| knot < low);
        let count = knots[first..].partition_point(|&knot| knot <= high);
        (0..count).map(move |k| knots[first + if from < to { k } else { count - 1 - k }])
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
        for order in first + 1..=self.spline().degree {
            factor *= half / (order - first) as f64;
            radius += (self.of_piece(piece, order, middle) * factor).abs();
        }
        // The terms that of_piece adds up may be larger than their sum.
        let knot = f64::constants(&self.spline().knots)[piece.max(1) - 1];
        let coefficients = &f64::constants(&self.spline().coefficients)[COEFFICIENTS * piece..][..COEFFICIENTS];
        let reach = (from - knot).abs().max((to - knot).abs());
        // No coefficient is multiplied by more than 5! for a derivative.
        let size = coefficients[first..].iter().rev().fold(0.0, |sum, c| sum * reach + 120.0 * c.abs());
        let margin = radius + 8.0 * f64::EPSILON * size + f64::MIN_POSITIVE;
        [value - margin, value + margin]
    }
}

impl Spline {
    fn new(points: &[[Extended; 2]], kind: Kind, outside: Outside) -> Result<Self, TableError> {
        let mistake = |message: String| Err(TableError(message, None));
        let not_finite = |index: usize| mistake(format!("point {} of the table is not finite", index + 1));
        if points.len() < 3 {
            return mistake(format!("a table needs three points at least, and this one has {}", points.len()));
        }
        let is_finite = |point: &[Extended; 2]| point.iter().all(|number| number.to_f64().is_finite());
        if let Some(index) = points.iter().position(|point| !is_finite(point)) {
            return not_finite(index);
        }
        // Knots must be different in f64, too.
        if let Some(index) = points.windows(2).position(|pair| pair[0][0].to_f64() >= pair[1][0].to_f64()) {
            let place = index + 2;
            return mistake(format!("the arguments of a table must increase, and that of point {place} does not"));
        }
        let coefficients = coefficients(points, &even_derivatives(points, kind));
        if let Some(place) = coefficients.iter().position(|number| !number.to_f64().is_finite()) {
            return not_finite((place / COEFFICIENTS).min(points.len() - 1));
        }
        let (degree, knots) = (kind.degree(), points.iter().map(|point| point[0]).collect());
        Ok(Self { degree, knots: Constants::new(knots), coefficients: Constants::new(coefficients), outside })
    }

    fn is_same(&self, other: &Self) -> bool {
        let same = |one: &Constants, other: &Constants| Extended::constants(one) == Extended::constants(other);
        let are_same = same(&self.knots, &other.knots) && same(&self.coefficients, &other.coefficients);
        [self.degree, self.outside as usize] == [other.degree, other.outside as usize] && are_same
    }
}

#[cfg(test)]
mod tests {
    use super::{Kind, Outside, Table};
    use crate::number::{Extended, Real};

    fn points(f: impl Fn(f64) -> f64, knots: &[f64]) -> Vec<[Extended; 2]> {
        knots.iter().map(|&x| [x, f(x)].map(Extended::from)).collect()
    }

    /// Knots at uneven distances.
    const KNOTS: [f64; 7] = [-2.0, -1.5, -0.25, 0.0, 1.0, 1.25, 3.0];

    fn table(kind: Kind, outside: Outside) -> Table {
        Table::new(&points(|x| (1.0 + x * x).ln() - x, &KNOTS), kind, outside).unwrap()
    }

    /// In 70 digits nothing but rounding is left of the difference between both sides of a knot.
    #[test]
    fn a_spline_takes_its_values_and_is_smooth_at_knots() {
        for (kind, smooth, free) in [(Kind::Natural, 3, 2..3), (Kind::Clamped, 3, 1..2), (Kind::Quintic, 5, 3..5)] {
            let table = table(kind, Outside::Refused);
            for (k, &knot) in KNOTS.iter().enumerate() {
                let at = Extended::from(knot);
                let value = Extended::from((1.0 + knot * knot).ln() - knot);
                assert!((table.at(at) - value).abs().to_f64() < 1e-68, "{knot}");
                if k == 0 || k + 1 == KNOTS.len() {
                    continue;
                }
                for order in 0..smooth {
                    let [left, right] = [k, k + 1].map(|piece| table.of_piece(piece, order, at));
                    assert!((left - right).abs().to_f64() < 1e-63, "{knot} {order}");
                }
            }
            for (order, (piece, knot)) in free.flat_map(|order| [(1, KNOTS[0]), (6, KNOTS[6])].map(|end| (order, end)))
            {
                let end = table.of_piece(piece, order, Extended::from(knot));
                assert!(end.abs().to_f64() < 1e-64, "{kind:?} {knot}");
            }
        }
    }

    /// The values in the middle of intervals are those of scipy.interpolate, CubicSpline and make_interp_spline.
    #[test]
    fn splines_are_those_of_other_programs() {
        let cube = points(|x| x * x * x, &[0.0, 1.0, 2.0, 4.0]);
        for (kind, expected) in [
            (Kind::Natural, [0.255_434_782_608_695_57, 2.983_695_652_173_913, 30.913_043_478_260_867]),
            (Kind::Clamped, [0.397_727_272_727_272_7, 2.011_363_636_363_636_2, 41.181_818_181_818_18]),
            (Kind::Quintic, [0.010_110_294_117_604_444, 3.375_919_117_647_006, 27.588_235_294_117_645]),
        ] {
            let table = Table::new(&cube, kind, Outside::Refused).unwrap();
            for (x, expected) in [0.5, 1.5, 3.0].into_iter().zip(expected) {
                let found: f64 = table.at(x);
                assert!((found - expected).abs() < 1e-13 * (1.0 + expected), "{x}: {found} is not {expected}");
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_the_values() {
        let mut table = table(Kind::Quintic, Outside::Linear);
        for _ in 0..5 {
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
        let mut table = Some(table(Kind::Quintic, Outside::Linear));
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
    fn outside_of_its_knots_a_spline_is_refused_or_its_tangent() {
        let [refused, linear] = [Outside::Refused, Outside::Linear].map(|outside| table(Kind::Natural, outside));
        assert!([-2.1, 3.000_001, f64::INFINITY, f64::NAN].map(|u| refused.at(u)).iter().all(|value| value.is_nan()));
        assert!(linear.at(f64::NAN).is_nan());
        let slope = linear.derivative().unwrap();
        for (end, u) in [(-2.0, -5.0), (3.0, 7.0)] {
            assert!((linear.at(u) - (linear.at(end) + (u - end) * slope.at(end))).abs() < 1e-14, "{u}");
        }
        let nothing = [f64::NEG_INFINITY, f64::INFINITY];
        for ends in [nothing, [f64::NEG_INFINITY, 0.0], [0.0, f64::INFINITY], [f64::NAN, 0.0], [1.0, 0.0]] {
            assert_eq!([refused.bounds(ends), linear.bounds(ends)], [nothing; 2], "{ends:?}");
        }
        assert_eq!(refused.bounds([2.0, 3.5]), nothing);
        assert_eq!([linear.passed([1.0, -1.0]), linear.passed([-3.0, 4.0])], [None, Some(7)]);
    }

    #[test]
    fn equal_tables_are_one() {
        assert_eq!(table(Kind::Natural, Outside::Linear), table(Kind::Natural, Outside::Linear));
        assert_ne!(table(Kind::Natural, Outside::Linear), table(Kind::Clamped, Outside::Linear));
        let points = points(|x| x, &[0.0, f64::NAN, 1.0]);
        let error = Table::new(&points, Kind::Natural, Outside::Refused).unwrap_err();
        assert_eq!(error.0, "point 2 of the table is not finite");
    }
}
