//! Elementary functions of balls.
//!
//! Each is computed at the midpoint by a series or one step of Newton's method, whose truncation stands beside it, in
//! the operations of balls, which count their own rounding. Functions of the standard library give first guesses, and
//! nothing rests on these: where a guess is off, the radius is infinite. Then comes what the radius of the argument
//! makes of the result, by a bound of the slope on the ball. By the addition theorems sinh, cosh, tanh, tan, asin and
//! acos follow from the others.

use std::sync::LazyLock;

use super::{Ball, TINY, UP};
use crate::number::{Extended, Function, Real};

/// Extended numbers that take at most a few hundred correctly rounded operations are off by less, relative to them.
const OFF: f64 = 1e-66;

/// The terms of exp, and those of sin and cos together: after so many what is left out is far below the roundings.
const TERMS: usize = 30;

/// Arguments of sin and cos may be so large: the count of quarter turns is a whole double then.
const WIDEST_ANGLE: f64 = 1e15;

/// A first guess from the library of the system is better than this, which is checked: if it is not, the function
/// returns a ball of which nothing is known, so that no proof rests on that library.
const GUESS: f64 = 1e-10;

/// Constants of the functions.
struct Constants {
    /// 1/n!.
    factorials: [Ball; TERMS + 2],
    ln_2: Ball,
    ln_10: Ball,
    half_pi: Ball,
}

static CONSTANTS: LazyLock<Constants> = LazyLock::new(|| {
    let mut factorial = Extended::ONE;
    let factorials = std::array::from_fn(|n| {
        factorial /= Extended::from(n.max(1) as f64);
        Ball::of(factorial, OFF)
    });
    Constants {
        factorials,
        ln_2: Ball::of(Real::ln(Extended::from(2.0)), OFF),
        ln_10: Ball::of(<Extended as Real>::LN_10, OFF),
        half_pi: Ball::of(<Extended as Real>::PI.half(), OFF),
    }
});

/// π/2.
pub(super) fn half_pi() -> Ball {
    CONSTANTS.half_pi
}

/// 2^k for |k| ≤ 1000.
#[inline(always)]
fn power_of_two(k: i64) -> f64 {
    f64::from_bits(((k + 1023) as u64) << 52)
}

/// exp y for |y| ≤ ½ by the series to y^(terms − 1)/(terms − 1)!: what is left out is at most twice the next term,
/// which is at most 2^-terms/terms!.
#[inline(always)]
pub(super) fn exp_series(y: Ball, terms: usize) -> Ball {
    let (factorials, mut sum) = (&CONSTANTS.factorials, Ball::default());
    // Loops and no iterators, whose parts would not all be inlined.
    for n in (0..terms).rev() {
        sum = sum * y + factorials[n];
    }
    sum.widened(2.0 * power_of_two(-(terms as i64)) * factorials[terms].size())
}

/// sin y and cos y for |y| ≤ 1 by their series, which have an even number of terms together. Terms fall and alternate,
/// so that what is left out is at most the first of them: 1/terms! of cos y, and of (sin y)/y the next one.
#[inline(always)]
pub(super) fn sin_cos_series(y: Ball, terms: usize) -> [Ball; 2] {
    let (factorials, square) = (&CONSTANTS.factorials, y * y);
    let [mut sin, mut cos] = [Ball::default(); 2];
    for n in (0..terms / 2).rev() {
        cos = factorials[2 * n] - cos * square;
        sin = factorials[2 * n + 1] - sin * square;
    }
    [sin.widened(factorials[terms + 1].size()) * y, cos.widened(factorials[terms].size())]
}

impl Ball {
    /// The midpoint alone.
    #[inline(always)]
    fn middle(self) -> Self {
        Self { rad: 0.0, ..self }
    }

    /// With x = k ln 2 + y, exp x is 2^k exp y; and |exp x′ − exp x| = exp x |exp(x′ − x) − 1| ≤ exp x (r + r²) for
    /// |x′ − x| ≤ r ≤ 1.
    #[inline(always)]
    fn exp(self) -> Self {
        if self.hi < -690.0 && self.rad < 1.0 {
            // exp(−689) < 1e-299.
            return Self { rad: 1e-299, ..Self::default() };
        }
        let k = (self.hi * std::f64::consts::LOG2_E).round();
        let y = self.middle() - Self::exact(k) * CONSTANTS.ln_2;
        let is_known = y.size() <= 0.5 && self.rad <= 1.0 && k.abs() <= 1000.0;
        if !is_known {
            return Self::UNKNOWN;
        }
        let value = exp_series(y, TERMS).scaled(power_of_two(k as i64)).widened(TINY);
        value.widened(value.size() * (self.rad + self.rad * self.rad))
    }

    /// Sine and cosine, of y after n quarter turns are taken away. No slope is above 1.
    #[inline(always)]
    pub(crate) fn sin_cos(self) -> [Self; 2] {
        let n = (self.hi * std::f64::consts::FRAC_2_PI).round();
        let y = self.middle() - Self::exact(n) * CONSTANTS.half_pi;
        let is_known = y.size() <= 1.0 && self.hi.abs() <= WIDEST_ANGLE;
        if !is_known {
            return [Self::UNKNOWN; 2];
        }
        let [sin, cos] = sin_cos_series(y, TERMS).map(|value| value.widened(self.rad));
        match (n as i64).rem_euclid(4) {
            0 => [sin, cos],
            1 => [cos, -sin],
            2 => [-sin, -cos],
            _ => [-cos, sin],
        }
    }

    /// With a guess g, ln x = g + ln(1 + w) for 1 + w = x exp(−g), and |ln(1 + w) − w + w²/2| ≤ |w|³ for |w| ≤ ½. The
    /// slope on the ball is at most 1/(x − rad).
    #[inline(always)]
    pub(super) fn ln(self) -> Self {
        self.ln_near(self.hi.ln())
    }

    #[inline(always)]
    pub(super) fn ln_near(self, guess: f64) -> Self {
        let w = self.middle() * (-Self::exact(guess)).exp() - Self::exact(1.0);
        let (most, least) = (w.size(), self.least());
        let is_known = most <= GUESS && self.hi > 0.0 && least > 0.0;
        if !is_known {
            return Self::UNKNOWN;
        }
        let value = Self::exact(guess) + (w - (w * w).scaled(0.5)).widened(most * most * most * UP);
        value.widened(self.rad / least * UP)
    }

    /// With a guess g, tan(atan x − g) = w = (x cos g − sin g)/(cos g + x sin g). For |g| ≤ 2 and a divisor above 0,
    /// which is √(1 + x²) cos(atan x − g), that angle is between −π/2 and π/2, so that it is atan w, and
    /// |atan w − w| ≤ |w|³/3. The slope is at most 1/(1 + (|x| − rad)²).
    #[inline(always)]
    pub(super) fn atan(self) -> Self {
        self.atan_near(self.hi.atan())
    }

    #[inline(always)]
    pub(super) fn atan_near(self, guess: f64) -> Self {
        let [sin, cos] = Self::exact(guess).sin_cos();
        let x = self.middle();
        let divisor = cos + x * sin;
        let w = (x * cos - sin) / divisor;
        let most = w.size();
        let is_known = most <= GUESS && guess.abs() <= 2.0 && divisor.hi > 0.0 && divisor.least() > 0.0;
        if !is_known {
            return Self::UNKNOWN;
        }
        let value = Self::exact(guess) + w.widened(most * most * most * UP);
        let least = self.least().max(0.0);
        value.widened(self.rad / (1.0 + least * least) * UP)
    }

    /// asin x = atan(x/√((1 − x)(1 + x))).
    fn asin(self) -> Self {
        let one = Self::exact(1.0);
        (self / ((one - self) * (one + self)).sqrt()).atan()
    }

    /// sinh and cosh are half of exp x ∓ exp(−x).
    fn sinh_cosh(self) -> [Self; 2] {
        let (grows, falls) = (self.exp(), (-self).exp());
        [(grows - falls).scaled(0.5), (grows + falls).scaled(0.5)]
    }

    /// tanh x = 1 − 2 exp(−2x)/(1 + exp(−2x)) for x > 0, and odd.
    fn tanh(self) -> Self {
        if self.hi < 0.0 {
            return -(-self).tanh();
        }
        let (one, falls) = (Self::exact(1.0), (-self.scaled(2.0)).exp());
        one - falls.scaled(2.0) / (one + falls)
    }

    /// The value of a function on the ball; [`Ball::UNKNOWN`] where it is not analytic, or its values are not bounded.
    #[inline(always)]
    pub(crate) fn call(self, function: Function) -> Self {
        let has_sign = self.least() > 0.0;
        match function {
            Function::Sin => self.sin_cos()[0],
            Function::Cos => self.sin_cos()[1],
            Function::Tan => {
                let [sin, cos] = self.sin_cos();
                sin / cos
            }
            Function::Sinh => self.sinh_cosh()[0],
            Function::Cosh => self.sinh_cosh()[1],
            Function::Tanh => self.tanh(),
            Function::Asin => self.asin(),
            Function::Acos => CONSTANTS.half_pi - self.asin(),
            Function::Atan => self.atan(),
            Function::Exp => self.exp(),
            Function::Ln => self.ln(),
            Function::Log10 => self.ln() / CONSTANTS.ln_10,
            Function::Sqrt => self.sqrt(),
            Function::Abs if has_sign => self.scaled(self.hi.signum()),
            Function::Sign if has_sign => Self::exact(self.hi.signum()),
            Function::Step if has_sign => Self::exact(self.hi.step()),
            Function::Abs | Function::Sign | Function::Step | Function::Table(_) => Self::UNKNOWN,
        }
    }

    /// x^y = exp(y ln x) for x > 0.
    #[inline(always)]
    pub(crate) fn power(self, exponent: Self) -> Self {
        (exponent * self.ln()).exp()
    }
}
