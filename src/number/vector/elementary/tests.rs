//! Accuracy against extended precision, and every edge against single numbers.

use pulp::{Simd, WithSimd};

use super::{call, power, sin_cos};
use crate::number::vector::Level;
use crate::number::{Extended, Function, Noise, Real};

/// f(x) or x^y at a level. A sine or a cosine is the same alone and with the other.
struct Values<'a> {
    function: Option<Function>,
    x: &'a [f64],
    y: &'a [f64],
}

impl WithSimd for Values<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) -> Vec<f64> {
        let mut out = vec![0.0; self.x.len()];
        match self.function {
            Some(function) => call(s, function, self.x, &mut out),
            None => power(s, self.x, self.y, &mut out),
        }
        if let Some(Function::Sin | Function::Cos) = self.function {
            let [mut sin, mut cos] = [out.clone(), out.clone()];
            sin_cos(s, self.x, [&mut sin, &mut cos]);
            let found = if self.function == Some(Function::Sin) { sin } else { cos };
            assert!(found.iter().zip(&out).all(|(one, other)| one.to_bits() == other.to_bits()));
        }
        out
    }
}

fn values(level: Level, function: Option<Function>, x: &[f64], y: &[f64]) -> Vec<f64> {
    level.dispatch(Values { function, x, y })
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
    let best = values(Level::Best, function, &x, &y);
    let errors = (0..x.len()).map(|k| error(best[k], exact(function, x[k], y[k])));
    let (worst, at) = errors.zip(0..).fold((0.0, 0), |a, b| if b.0 <= a.0 { a } else { b });
    println!("{function:?} {ends:?} {worst:.3} ulp at {:e} ({:e})", x[at], y[at]);
    assert!(worst <= most, "{function:?}: {worst} ulp at {:e}, {:e}", x[at], y[at]);
    if Level::Best.dispatch(HasVectors) && Level::Avx2.dispatch(HasVectors) {
        assert!(best == values(Level::Avx2, function, &x, &y), "{function:?} depends on the level");
    }
}

struct HasVectors;

impl WithSimd for HasVectors {
    type Output = bool;

    fn with_simd<S: Simd>(self, _: S) -> bool {
        !S::IS_SCALAR
    }
}

const NONE: [f64; 2] = [0.0, 0.0];

#[test]
fn sines_and_cosines() {
    for function in [Function::Sin, Function::Cos] {
        for (thousands, most) in [(80, 1.0), (80, 10.0), (80, 1e6), (8, 1e9)] {
            check(Some(function), thousands, [-most, most], NONE, 0.9);
        }
        check(Some(function), 8, [1e-320, 1e-3], NONE, 0.9);
    }
    for (thousands, most) in [(20, 1.0), (20, 1e3)] {
        check(Some(Function::Tan), thousands, [-most, most], NONE, 1.0);
    }
}

#[test]
fn angles_next_to_quarter_turns() {
    let x: Vec<f64> = (0..8000).map(|k| f64::from(80 * k) * std::f64::consts::FRAC_PI_2).collect();
    let x: Vec<f64> = (0..800).map(|k| f64::from(k) * std::f64::consts::FRAC_PI_2).chain(x).collect();
    for function in [Function::Sin, Function::Cos, Function::Tan] {
        for (&x, value) in x.iter().zip(values(Level::Best, Some(function), &x, &x)) {
            let error = error(value, exact(Some(function), x, 0.0));
            assert!(error < 1.0, "{function:?}: {error} ulp at {x:e}");
        }
    }
}

#[test]
fn exponentials() {
    check(Some(Function::Exp), 40, [-1.0, 1.0], NONE, 0.9);
    check(Some(Function::Exp), 40, [-745.0, 709.7], NONE, 0.9);
    check(Some(Function::Exp), 4, [1e-320, 1e-3], NONE, 0.9);
    for function in [Function::Sinh, Function::Cosh, Function::Tanh] {
        let thousands = if function == Function::Tanh { 15 } else { 5 };
        check(Some(function), thousands, [-1.0, 1.0], NONE, 0.7);
        check(Some(function), thousands, [-20.0, 20.0], NONE, 0.7);
        check(Some(function), 5, [1e-300, 1.0], NONE, 0.7);
    }
    check(Some(Function::Sinh), 4, [20.0, 708.0], NONE, 0.7);
    check(Some(Function::Cosh), 4, [20.0, 708.0], NONE, 0.7);
}

#[test]
fn logarithms() {
    check(Some(Function::Ln), 50, [0.0, 4.0], NONE, 0.6);
    check(Some(Function::Ln), 50, [0.9, 1.1], NONE, 0.6);
    check(Some(Function::Ln), 20, [1e-310, 1e308], NONE, 0.6);
    check(Some(Function::Log10), 20, [0.0, 4.0], NONE, 0.8);
    check(Some(Function::Log10), 20, [1e-300, 1e308], NONE, 0.8);
}

#[test]
fn powers() {
    check(None, 15, [0.0, 2.0], [-3.0, 3.0], 0.7);
    check(None, 15, [0.5, 2.0], [-700.0, 700.0], 0.7);
    check(None, 10, [1e-300, 1e300], [-1.0, 1.0], 0.7);
}

#[test]
fn inverse_functions() {
    check(Some(Function::Asin), 30, [-1.0, 1.0], NONE, 0.7);
    check(Some(Function::Acos), 30, [-1.0, 1.0], NONE, 0.7);
    check(Some(Function::Acos), 10, [0.9, 1.0], NONE, 0.7);
    check(Some(Function::Atan), 50, [-4.0, 4.0], NONE, 0.8);
    check(Some(Function::Atan), 50, [1e-10, 1e10], NONE, 0.8);
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
    let functions = Function::NAMED.iter().map(|&(_, function)| function);
    let x = edges();
    for level in [Level::Best, Level::Avx2, Level::Scalar] {
        for function in functions.clone() {
            for (&x, value) in x.iter().zip(values(level, Some(function), &x, &x)) {
                let wanted: f64 = function.apply(x);
                assert!(is_same(value, wanted), "{level:?}: {function:?} of {x:e} is {value:e}, not {wanted:e}");
            }
        }
        for &exponent in &x {
            let y = vec![exponent; x.len()];
            for (&x, value) in x.iter().zip(values(level, None, &x, &y)) {
                let wanted = x.powf(exponent);
                assert!(is_same(value, wanted), "{level:?}: {x:e}^{exponent:e} is {value:e}, not {wanted:e}");
            }
        }
    }
}
