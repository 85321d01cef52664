//! Accuracy against extended precision, and every edge against single numbers.

use pulp::{Simd, WithSimd};

use super::{call, power, sin_cos};
use crate::number::vector::Level;
use crate::number::{Extended, Function, Noise, Real};

/// f(x) or x^y at a level, and whether that has vectors. A sine or a cosine is the same alone and with the other.
struct Values<'a> {
    function: Option<Function>,
    x: &'a [f64],
    y: &'a [f64],
}

impl WithSimd for Values<'_> {
    type Output = (Vec<f64>, bool);

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) -> (Vec<f64>, bool) {
        let [mut out, mut sin, mut cos] = [(); 3].map(|()| vec![0.0; self.x.len()]);
        match self.function {
            Some(function) => call(s, function, self.x, &mut out),
            None => power(s, self.x, self.y, &mut out),
        }
        sin_cos(s, self.x, [&mut sin, &mut cos]);
        if let Some(found) = [(Function::Sin, sin), (Function::Cos, cos)].iter().find(|of| Some(of.0) == self.function)
        {
            assert!(found.1.iter().zip(&out).all(|(one, other)| one.to_bits() == other.to_bits()));
        }
        (out, !S::IS_SCALAR)
    }
}

fn values(level: Level, function: Option<Function>, x: &[f64], y: &[f64]) -> Vec<f64> {
    level.dispatch(Values { function, x, y }).0
}

fn exact(function: Option<Function>, x: f64, y: f64) -> Extended {
    let x = Extended::from(x);
    function.map_or_else(|| Real::powf(x, Extended::from(y)), |function| function.apply(x))
}

/// The unit of the last digit.
fn ulp(value: f64) -> f64 {
    let binade = f64::from_bits(value.to_bits() & f64::INFINITY.to_bits());
    binade.clamp(f64::MIN_POSITIVE, f64::MAX) * f64::EPSILON
}

fn error(value: f64, exact: Extended) -> f64 {
    let unit = Extended::from(ulp(Real::to_f64(exact)));
    Real::to_f64((Extended::from(value) - exact) / unit).abs()
}

/// `count` numbers between the ends; every second one by its logarithm, if the ends have no sign change.
fn between(noise: &mut Noise, count: usize, [from, to]: [f64; 2]) -> Vec<f64> {
    let by_size = from * to > 0.0;
    let number = |k: usize| match noise.next().half() + 0.5 {
        r if by_size && k % 2 == 1 => (from * (to / from).powf(r)).clamp(from.min(to), from.max(to)),
        r => from + (to - from) * r,
    };
    (0..count).map(number).collect()
}

/// Asserts that `count` thousand values between the ends are within `most` ulp, and that all levels with vectors agree.
fn check(function: Option<Function>, thousands: usize, ends: [f64; 2], exponents: [f64; 2], most: f64) {
    let mut noise = Noise::default();
    let [x, y] = [ends, exponents].map(|ends| between(&mut noise, 1000 * thousands, ends));
    let [(best, has_vectors), (other, has_others)] =
        [Level::Best, Level::Avx2].map(|level| level.dispatch(Values { function, x: &x, y: &y }));
    let errors = (0..x.len()).map(|k| error(best[k], exact(function, x[k], y[k])));
    let (worst, at) = errors.zip(0..).fold((0.0, 0), |a, b| if b.0 <= a.0 { a } else { b });
    println!("{function:?} {ends:?} {worst:.3} ulp at {:e} ({:e})", x[at], y[at]);
    assert!(worst <= most, "{function:?}: {worst} ulp at {:e}, {:e}", x[at], y[at]);
    assert!(!(has_vectors && has_others) || best == other, "{function:?} depends on the level");
}

/// Checks functions on thousands of numbers between ends, each within so many ulp.
fn check_all(rows: &[(&[Function], usize, [f64; 2], f64)]) {
    for &(functions, thousands, ends, most) in rows {
        functions.iter().for_each(|&function| check(Some(function), thousands, ends, [0.0; 2], most));
    }
}

#[test]
fn circular_functions() {
    use Function::{Acos, Asin, Atan, Cos, Sin, Tan};
    check_all(&[
        (&[Sin, Cos], 80, [-1.0, 1.0], 0.9),
        (&[Sin, Cos], 80, [-10.0, 10.0], 0.9),
        (&[Sin, Cos], 80, [-1e6, 1e6], 0.9),
        (&[Sin, Cos], 8, [-1e9, 1e9], 0.9),
        (&[Sin, Cos], 8, [1e-320, 1e-3], 0.9),
        (&[Tan], 20, [-1.0, 1.0], 1.0),
        (&[Tan], 20, [-1e3, 1e3], 1.0),
        (&[Asin, Acos], 30, [-1.0, 1.0], 0.7),
        (&[Acos], 10, [0.9, 1.0], 0.7),
        (&[Atan], 50, [-4.0, 4.0], 0.8),
        (&[Atan], 50, [1e-10, 1e10], 0.8),
    ]);
    let quarters = (0..800).chain((0..8000).map(|k| 80 * k));
    let x: Vec<f64> = quarters.map(|k| f64::from(k) * std::f64::consts::FRAC_PI_2).collect();
    for function in [Sin, Cos, Tan] {
        for (&x, value) in x.iter().zip(values(Level::Best, Some(function), &x, &x)) {
            let error = error(value, exact(Some(function), x, 0.0));
            assert!(error < 1.0, "{function:?}: {error} ulp at {x:e}");
        }
    }
}

#[test]
fn exponentials_and_logarithms() {
    use Function::{Cosh, Exp, Ln, Log10, Sinh, Tanh};
    check_all(&[
        (&[Exp], 40, [-1.0, 1.0], 0.9),
        (&[Exp], 40, [-745.0, 709.7], 0.9),
        (&[Exp], 4, [1e-320, 1e-3], 0.9),
        (&[Tanh], 15, [-1.0, 1.0], 0.7),
        (&[Tanh], 15, [-20.0, 20.0], 0.7),
        (&[Sinh, Cosh], 5, [-1.0, 1.0], 0.7),
        (&[Sinh, Cosh], 5, [-20.0, 20.0], 0.7),
        (&[Sinh, Cosh, Tanh], 5, [1e-300, 1.0], 0.7),
        (&[Sinh, Cosh], 4, [20.0, 708.0], 0.7),
        (&[Ln], 50, [0.0, 4.0], 0.6),
        (&[Ln], 50, [0.9, 1.1], 0.6),
        (&[Ln], 20, [1e-310, 1e308], 0.6),
        (&[Log10], 20, [0.0, 4.0], 0.8),
        (&[Log10], 20, [1e-300, 1e308], 0.8),
    ]);
    check(None, 15, [0.0, 2.0], [-3.0, 3.0], 0.7);
    check(None, 15, [0.5, 2.0], [-700.0, 700.0], 0.7);
    check(None, 10, [1e-300, 1e300], [-1.0, 1.0], 0.7);
}

/// Zeros, subnormal numbers, the ends of all ranges, infinities and NaN.
fn edges() -> Vec<f64> {
    let [below, above] = [1.0_f64.next_down(), 1.0_f64.next_up()];
    let large = [1e6, 1_000_000.1, 1e15, 1e22, 1e150, 1.1e150, 1e300, f64::MAX, f64::INFINITY];
    let exponents = [707.999_999_9, 708.0, 708.000_000_1, 709.78, 709.79, 710.47, 710.48, 745.13, 745.14];
    let small = [0.0, 5e-324, 1e-310, f64::MIN_POSITIVE, 1e-200, 1e-20, 0.4375, 0.5, 0.6875, below, 1.0, above];
    let ends = [1.5, 2.0, 2.4375, 3.0, 20.0, 22.5].into_iter().chain(small).chain(exponents).chain(large);
    let mut all: Vec<f64> = ends.flat_map(|end| [end, -end]).collect();
    all.resize(all.len().next_multiple_of(8), f64::NAN);
    all
}

/// Equal to the last sign of zero, or within two ulp, or both NaN.
fn is_same(a: f64, b: f64) -> bool {
    let is_near = a == b || (a - b).abs() <= 2.0 * ulp(b);
    a.is_nan() && b.is_nan() || is_near && (a != 0.0 || b != 0.0 || a.is_sign_negative() == b.is_sign_negative())
}

#[test]
fn edges_are_those_of_single_numbers() {
    let x = edges();
    let functions = Function::NAMED.iter().map(|&(_, function)| (Some(function), 0.0));
    let all: Vec<(Option<Function>, f64)> = functions.chain(x.iter().map(|&exponent| (None, exponent))).collect();
    for level in [Level::Best, Level::Avx2, Level::Scalar] {
        for &(function, y) in &all {
            for (&x, value) in x.iter().zip(values(level, function, &x, &vec![y; x.len()])) {
                let wanted = function.map_or_else(|| x.powf(y), |function| function.apply(x));
                assert!(is_same(value, wanted), "{level:?}: {function:?} of {x:e}, {y:e}: {value:e}, not {wanted:e}");
            }
        }
    }
}
