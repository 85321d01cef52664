//! Random expressions in each algebra and in 71 digits: none is outside.

use super::functions::{exp_series, sin_cos_series};
use super::{Ball, Disc, PRODUCT, QUOTIENT, SUM, two_sum};
use crate::number::{Extended, Function, Real};

/// Numbers that look random, by a linear congruence (Knuth's MMIX).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % end as u64) as usize
    }

    /// In [−1, 1].
    fn unit(&mut self) -> f64 {
        2.0 * self.below(1 << 30) as f64 / f64::from((1 << 30) - 1) - 1.0
    }

    /// A pair that uses all of its digits, of sizes from 2^-e to 2^e.
    fn pair(&mut self, e: usize) -> (f64, f64) {
        let size = 2.0_f64.powi(self.below(2 * e + 1) as i32 - e as i32);
        let hi = size * (self.unit() + 1e-9 * self.unit() + 1e-17 * self.unit());
        two_sum(hi, 1e-17 * hi * self.unit())
    }
}

/// The number of expressions that are tried.
fn count() -> usize {
    std::env::var("BALL_EXPRESSIONS").ok().and_then(|text| text.parse().ok()).unwrap_or(20_000)
}

fn exact(ball: Ball) -> Extended {
    Extended::from(ball.hi) + Extended::from(ball.lo)
}

/// The share of the radius that is used; above 1 the value is outside.
fn share(ball: Ball, value: Extended) -> f64 {
    let off = (exact(ball) - value).abs().to_f64();
    if ball.rad.is_nan() || off.is_nan() || ball.rad == f64::INFINITY { 0.0 } else { off / ball.rad.max(1e-320) }
}

const ANALYTIC: [Function; 13] = [
    Function::Sin,
    Function::Cos,
    Function::Tan,
    Function::Sinh,
    Function::Cosh,
    Function::Tanh,
    Function::Asin,
    Function::Acos,
    Function::Atan,
    Function::Exp,
    Function::Ln,
    Function::Log10,
    Function::Sqrt,
];

#[test]
fn no_random_expression_leaves_its_ball() {
    let (mut random, mut known, mut largest) = (Random(1), 0, 0.0_f64);
    for _ in 0..count() {
        // Balls with a number in each, many of them at the edge.
        let mut values: Vec<(Ball, Extended)> = (0..4)
            .map(|_| {
                let (hi, lo) = random.pair(3);
                let rad = if random.below(2) == 0 { 0.0 } else { hi.abs() * 10.0_f64.powi(-(random.below(33) as i32)) };
                let inside = [-1.0, 1.0, random.unit()][random.below(3)] * (1.0 - 1e-15);
                let ball = Ball { hi, lo, rad };
                (ball, exact(ball) + Extended::from(rad) * Extended::from(inside))
            })
            .collect();
        for _ in 0..6 {
            let [(a, x), (b, y)] = [(); 2].map(|()| values[random.below(values.len())]);
            let next = match random.below(7) {
                0 => (a + b, x + y),
                1 => (a - b, x - y),
                2 => (a * b, x * y),
                3 => (a / b, x / y),
                // The power of the library for extended numbers is 0 for some, such as 0.9999999995^526744.1.
                4 => (a.power(b), Real::exp(y * Real::ln(x))),
                _ => {
                    let function = ANALYTIC[random.below(ANALYTIC.len())];
                    (a.call(function), function.apply(x))
                }
            };
            let used = share(next.0, next.1);
            assert!(used <= 1.0, "{:?} of {a:?} {b:?}: {used} of the radius, {:?}", next.0, next.1.to_decimal(40));
            let is_useful = next.0.rad < 1e-3 * next.0.hi.abs() && next.0.hi.abs() < 1e9 && next.0.hi.abs() > 1e-9;
            if is_useful {
                known += 1;
                largest = largest.max(used);
                let place = random.below(4);
                values[place] = next;
            }
        }
    }
    assert!(known > 2 * count() && largest > 0.9, "{known} values are known; at most {largest} of a radius is used");
}

/// The worst cases of the algorithms that are known, and how much of each bound random operands use.
#[test]
fn bounds_of_rounding_are_met_and_needed() {
    let mut random = Random(2);
    let mut largest = [0.0_f64; 3];
    for _ in 0..count() {
        let [a, b] = [(); 2].map(|()| {
            let (hi, lo) = random.pair(1);
            Ball { hi, lo, rad: 0.0 }
        });
        let (x, y) = (exact(a), exact(b));
        for (largest, (ball, value)) in largest.iter_mut().zip([(a + b, x + y), (a * b, x * y), (a / b, x / y)]) {
            *largest = largest.max(share(ball, value));
        }
    }
    assert!(largest.iter().all(|used| (0.05..=1.0).contains(used)), "{largest:?} of {SUM} {PRODUCT} {QUOTIENT}");
}

/// Functions of points: without their truncation or their rounding a radius would be too small.
#[test]
fn functions_have_thirty_digits_and_their_radius_holds_the_rest() {
    let (mut random, mut largest) = (Random(3), [0.0_f64; ANALYTIC.len()]);
    for _ in 0..count() / 10 {
        let (hi, lo) = random.pair(4);
        let ball = Ball { hi, lo, rad: 0.0 };
        for (largest, function) in largest.iter_mut().zip(ANALYTIC) {
            let (found, value): (Ball, Extended) = (ball.call(function), function.apply(exact(ball)));
            let is_defined = value.is_finite() && !(function == Function::Sqrt && hi <= 0.0);
            let used = share(found, value);
            assert!(used <= 1.0, "{function:?} of {ball:?}: {used} {found:?}");
            let size = value.abs().to_f64().max(1.0);
            if is_defined && hi.abs() < 15.0 && !matches!(function, Function::Tan) {
                let near_one = (1.0 - hi.abs()).abs();
                let worse = if matches!(function, Function::Asin | Function::Acos) { near_one } else { 1.0 };
                assert!(found.rad * worse < 2e-29 * size, "{function:?} of {ball:?}: {found:?}");
            }
            *largest = largest.max(used);
        }
    }
    assert!(largest.iter().all(|&used| used > 0.01), "{largest:?}");
}

/// A number of 71 digits is in its ball, with what it may be off by; so is a double that leaves its low part.
#[test]
fn what_is_taken_from_a_number_is_in_the_radius() {
    let third = Extended::ONE / Extended::from(3.0);
    let used = share(Ball::of(third, 0.0), third);
    assert!(used <= 1.0 && used > 0.99, "{used}");
    let used = share(Ball::of(Extended::ONE, 1e-30), Extended::ONE + Extended::from(1e-30));
    assert!(used <= 1.0 && used > 0.99, "{used}");
    let (middle, radius) = Ball { hi: 1.0, lo: 1e-17, rad: 1e-17 }.rounded();
    assert!(middle == 1.0 && (2e-17..2.01e-17).contains(&radius), "{radius}");
}

/// The rounding of an inverse alone, which is six roundings of what it is. Part 0.1.
#[test]
fn rounding_of_an_inverse_is_in_its_radius() {
    let (mut random, mut largest) = (Random(5), 0.0_f64);
    for _ in 0..2000 {
        let (re, im) = (random.pair(1).0, random.pair(1).0);
        let found = Disc { re, im, rad: 0.0 }.inverse();
        let exact = Complex::one().over(Complex(Extended::from(re), Extended::from(im)));
        let off = exact.plus(Complex(Extended::from(-found.re), Extended::from(-found.im)));
        let distance = (off.0 * off.0 + off.1 * off.1).sqrt().to_f64();
        assert!(distance <= found.rad, "{re} {im}: {distance:e} {:e}", found.rad);
        largest = largest.max(distance / found.rad);
    }
    assert!(largest > 0.1, "{largest}");
}

/// Truncations, each far above rounding: series of few terms, and steps of Newton's method from bad guesses. Beside
/// each stands the part of its bound that is met. In the functions themselves what series leave out is below 1e-35, a
/// thousandth of rounding, and roots are guessed so well that rounding is ten times what the step leaves.
#[test]
fn what_series_and_steps_leave_out_is_within_the_radius() {
    let is_met = |what: &str, ball: Ball, value: Extended, part: f64| {
        let used = share(ball, value);
        assert!(used <= 1.0 && used > part && ball.rad < 1.0, "{what}: {used} of {ball:?}");
    };
    let exact = Extended::from;
    for y in [0.5, -0.5] {
        is_met("exp", exp_series(Ball::exact(y), 12), Real::exp(exact(y)), 0.45);
    }
    for terms in [8, 10] {
        let [sin, cos] = sin_cos_series(Ball::exact(1.0), terms);
        is_met("sin", sin, Real::sin(exact(1.0)), 0.98);
        is_met("cos", cos, Real::cos(exact(1.0)), 0.98);
    }
    is_met("sqrt", Ball::exact(0.25).sqrt_near(1.5), exact(0.5), 0.5);
    is_met("ln", Ball::exact(1.0).ln_near(0.99e-10), Extended::ZERO, 0.2);
    is_met("atan", Ball::exact(0.0).atan_near(0.99e-10), Extended::ZERO, 0.3);
    // A guess that is worse is none.
    assert!(Ball::exact(1.0).ln_near(1e-9).rad.is_infinite() && Ball::exact(0.0).atan_near(1e-9).rad.is_infinite());
}

#[test]
fn where_a_function_is_not_analytic_nothing_is_known() {
    let (zero, around) = (Ball::exact(0.0), Ball { hi: 1e-3, lo: 0.0, rad: 1e-2 });
    for function in [Function::Abs, Function::Sign, Function::Step, Function::Sqrt, Function::Ln, Function::Log10] {
        assert_eq!([zero.call(function).rad, around.call(function).rad], [f64::INFINITY; 2], "{function:?}");
    }
    let beside = Ball { hi: 0.999, lo: 0.0, rad: 1e-2 };
    for function in [Function::Asin, Function::Acos] {
        assert!(!beside.call(function).rad.is_finite(), "{function:?}");
    }
    assert_eq!((zero / around).rad, f64::INFINITY);
    let left = Ball { hi: -2.0, lo: 0.0, rad: 1.0 };
    let found = [Function::Abs, Function::Sign, Function::Step].map(|function| left.call(function));
    assert_eq!(found, [-left, Ball::exact(-1.0), Ball::exact(0.0)]);
    for huge in [1e200, -1e200, f64::INFINITY, f64::NAN] {
        for function in ANALYTIC {
            let ball = Ball::exact(huge).call(function);
            let value: Extended = function.apply(Extended::from(huge));
            assert!(share(ball, value) <= 1.0, "{function:?} of {huge}: {ball:?}");
        }
        let square = Ball::exact(huge) * Ball::exact(huge);
        let is_bounded = square.rad < f64::MAX;
        assert!(!is_bounded, "{square:?}");
    }
}

/// A complex number in 71 digits.
#[derive(Debug, Clone, Copy)]
struct Complex(Extended, Extended);

impl Complex {
    fn plus(self, other: Self) -> Self {
        Self(self.0 + other.0, self.1 + other.1)
    }

    fn times(self, other: Self) -> Self {
        Self(self.0 * other.0 - self.1 * other.1, self.0 * other.1 + self.1 * other.0)
    }

    fn by(self, factor: f64) -> Self {
        Self(self.0 * Extended::from(factor), self.1 * Extended::from(factor))
    }

    fn over(self, other: Self) -> Self {
        let square = other.0 * other.0 + other.1 * other.1;
        let Self(re, im) = self.times(Self(other.0, -other.1));
        Self(re / square, im / square)
    }

    fn exp(self) -> Self {
        let grows = Real::exp(self.0);
        Self(grows * Real::cos(self.1), grows * Real::sin(self.1))
    }

    fn ln(self) -> Self {
        let size = self.0 * self.0 + self.1 * self.1;
        let half_turn = if self.1 < Extended::ZERO { -<Extended as Real>::PI } else { <Extended as Real>::PI };
        let beyond = if self.0 < Extended::ZERO { half_turn } else { Extended::ZERO };
        Self(Real::ln(size).half(), Real::atan(self.1 / self.0) + beyond)
    }

    fn turned(self) -> Self {
        Self(-self.1, self.0)
    }

    fn one() -> Self {
        Self(Extended::ONE, Extended::ZERO)
    }

    fn atan(self) -> Self {
        let turned = self.turned();
        Self::one().plus(turned).ln().plus(Self::one().plus(turned.by(-1.0)).ln().by(-1.0)).turned().by(-0.5)
    }

    fn call(self, function: Function) -> Option<Self> {
        let half = |sign: f64, z: Self| z.exp().plus(z.by(-1.0).exp().by(sign)).by(0.5);
        let root = |z: Self| z.ln().by(0.5).exp();
        Some(match function {
            Function::Exp => self.exp(),
            Function::Ln => self.ln(),
            Function::Log10 => self.ln().over(Self(<Extended as Real>::LN_10, Extended::ZERO)),
            Function::Sqrt => root(self),
            Function::Sinh => half(-1.0, self),
            Function::Cosh => half(1.0, self),
            Function::Sin => half(-1.0, self.turned()).turned().by(-1.0),
            Function::Cos => half(1.0, self.turned()),
            Function::Tanh => half(-1.0, self).over(half(1.0, self)),
            Function::Atan => self.atan(),
            Function::Asin | Function::Acos => {
                let sine = self.over(root(Self::one().plus(self.times(self).by(-1.0)))).atan();
                let quarter = Self(<Extended as Real>::PI.half(), Extended::ZERO);
                if function == Function::Asin { sine } else { quarter.plus(sine.by(-1.0)) }
            }
            _ => return None,
        })
    }
}

#[test]
fn no_random_expression_leaves_its_disc() {
    let (mut random, mut known, mut largest) = (Random(4), 0, 0.0_f64);
    for _ in 0..count() {
        let mut values: Vec<(Disc, Complex)> = (0..4)
            .map(|_| {
                let (re, im) = (random.pair(2).0, random.pair(2).0);
                let rad = if random.below(3) == 0 { 0.0 } else { 10.0_f64.powi(-(random.below(17) as i32)) };
                let (angle, share) = (4.0 * random.unit(), [1.0, random.unit()][random.below(2)] * (1.0 - 1e-15));
                let off = Complex(Extended::from(angle).cos(), Extended::from(angle).sin()).by(rad).by(share);
                (Disc { re, im, rad }, Complex(Extended::from(re), Extended::from(im)).plus(off))
            })
            .collect();
        for _ in 0..6 {
            let [(a, x), (b, y)] = [(); 2].map(|()| values[random.below(values.len())]);
            let side = a.side();
            let next = match random.below(7) {
                0 => (a + b, x.plus(y)),
                1 => (a - b, x.plus(y.by(-1.0))),
                2 => (a * b, x.times(y)),
                3 => (a / b, x.over(y)),
                4 => (a.power(b), y.times(x.ln()).exp()),
                _ => {
                    let function = ANALYTIC[random.below(ANALYTIC.len())];
                    match x.call(function) {
                        Some(value) => (a.call(function, side), value),
                        None => continue,
                    }
                }
            };
            // exp beyond the range of extended numbers has no value to compare with.
            let has_value = next.1.0.is_finite() && next.1.1.is_finite();
            if !next.0.rad.is_finite() || !has_value {
                continue;
            }
            let off = next.1.plus(Complex(Extended::from(-next.0.re), Extended::from(-next.0.im)));
            let distance = (off.0 * off.0 + off.1 * off.1).sqrt().to_f64();
            assert!(distance <= next.0.rad, "{:?} of {a:?} {b:?}: {distance}", next.0);
            if next.0.rad < 0.1 * next.0.size() && (1e-6..1e6).contains(&next.0.size()) {
                known += 1;
                largest = largest.max(distance / next.0.rad);
                let place = random.below(4);
                values[place] = next;
            }
        }
    }
    assert!(known > count() && largest > 0.9, "{known} values are known; at most {largest} of a radius is used");
}
