//! Discs of the complex plane in doubles. They bound what is multiplied by something small, so they need not be sharp.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::functions::half_pi;
use super::{Ball, TINY, U, UP};
use crate::number::{Function, Real};

/// More than the rounding of a sum, a product, an inverse or a square root of complex numbers, in units of the sizes of
/// its operands: each takes at most six roundings of numbers that are no larger than that, 6u = 6.7e-16.
const ROUNDING: f64 = 1e-15;
/// Squares of smaller sizes lose digits to underflow. A size is made larger, or smaller, by it.
const SMALL: f64 = 1e-140;

/// All complex numbers that are at most `rad` away from re + i im.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Disc {
    pub(crate) re: f64,
    pub(crate) im: f64,
    pub(crate) rad: f64,
}

impl Disc {
    /// No number is excluded.
    pub(crate) const UNKNOWN: Self = Self { re: 0.0, im: 0.0, rad: f64::INFINITY };

    /// A real ball.
    #[inline(always)]
    pub(crate) fn of(ball: Ball) -> Self {
        let (re, rad) = ball.rounded();
        Self { re, im: 0.0, rad }
    }

    /// A double.
    #[inline(always)]
    fn exact(re: f64) -> Self {
        Self { re, im: 0.0, rad: 0.0 }
    }

    /// The distance of its middle from 0, by at most four roundings.
    #[inline(always)]
    fn distance(self) -> f64 {
        (self.re * self.re + self.im * self.im).sqrt()
    }

    /// A bound of that distance.
    #[inline(always)]
    fn far(self) -> f64 {
        self.distance() * UP + SMALL
    }

    /// A lower bound of that distance.
    #[inline(always)]
    fn near(self) -> f64 {
        let distance = self.distance();
        // Nothing is known of one whose square overflows.
        if distance.is_finite() { distance * (1.0 - 8.0 * U) - SMALL } else { f64::NEG_INFINITY }
    }

    /// A bound of the absolute value of every number in it.
    #[inline(always)]
    pub(crate) fn size(self) -> f64 {
        (self.far() + self.rad) * UP
    }

    /// Half of the plane on whose side all of it is: 1, −1, or 0 if it may meet the imaginary axis.
    #[inline(always)]
    pub(crate) fn side(self) -> f64 {
        if self.re > self.rad {
            1.0
        } else if self.re < -self.rad {
            -1.0
        } else {
            0.0
        }
    }

    /// i times it.
    #[inline(always)]
    fn turned(self) -> Self {
        Self { re: -self.im, im: self.re, ..self }
    }

    /// A power of two times the disc, or minus that.
    #[inline(always)]
    fn scaled(self, by: f64) -> Self {
        Self { re: by * self.re, im: by * self.im, rad: by.abs() * self.rad }
    }

    /// 1/w − 1/z = (z − w)/wz: at most rad/(|z| (|z| − rad)).
    #[inline(always)]
    pub(super) fn inverse(self) -> Self {
        let square = self.re * self.re + self.im * self.im;
        let (near, least) = (self.near(), self.near() - self.rad * UP);
        let rad = (self.rad / (near * least) + ROUNDING / near + TINY) * UP;
        let is_known = least > 0.0 && near < 1.0 / SMALL;
        Self { re: self.re / square, im: -self.im / square, rad: if is_known { rad } else { f64::INFINITY } }
    }

    /// exp(x + iy) = exp x (cos y + i sin y).
    #[inline(always)]
    fn exp(self) -> Self {
        self.exp_by(self.re, Ball::exact(self.im).sin_cos())
    }

    /// exp x (cos y + i sin y) for the radius at hand: |exp w − exp z| ≤ |exp z| (exp r − 1) for |w − z| ≤ r, where
    /// exp r − 1 ≤ r + r² for r ≤ 1.
    #[inline(always)]
    fn exp_by(self, x: f64, [sin, cos]: [Ball; 2]) -> Self {
        let grows = Ball::exact(x).call(Function::Exp);
        let (re, im) = (Self::of(grows * cos), Self::of(grows * sin));
        let of_radius = match self.rad <= 1.0 {
            true => self.rad + self.rad * self.rad,
            false => Ball::exact(self.rad).call(Function::Exp).size(),
        };
        Self { re: re.re, im: im.re, rad: (re.rad + im.rad + grows.size() * of_radius) * UP }
    }

    /// The principal root, if all of the disc is on the right. The slope there is at most 1/2√(|z| − rad).
    #[inline(always)]
    fn sqrt(self) -> Self {
        let (size, least) = (self.distance(), self.near() - self.rad * UP);
        let re = (0.5 * (size + self.re)).sqrt();
        let rad = (0.5 * self.rad / least.sqrt() + ROUNDING * size.sqrt() + SMALL.sqrt()) * UP;
        if self.side() > 0.0 && least > 0.0 { Self { re, im: 0.5 * self.im / re, rad } } else { Self::UNKNOWN }
    }

    /// ln |z| + i atan(y/x), if all of the disc is on the right. The slope there is at most 1/(|z| − rad).
    #[inline(always)]
    fn ln(self) -> Self {
        let least = self.near() - self.rad * UP;
        if self.side() <= 0.0 || least <= 0.0 {
            return Self::UNKNOWN;
        }
        let (x, y) = (Ball::exact(self.re), Ball::exact(self.im));
        let (twice, angle) = (Self::of((x * x + y * y).ln()), Self::of((y / x).atan()));
        Self { re: 0.5 * twice.re, im: angle.re, rad: (twice.rad + angle.rad + self.rad / least) * UP }
    }

    /// sinh and cosh are half of exp z ∓ exp(−z).
    #[inline(always)]
    fn sinh_cosh(self) -> [Self; 2] {
        let [sin, cos] = Ball::exact(self.im).sin_cos();
        let (grows, falls) = (self.exp_by(self.re, [sin, cos]), self.exp_by(-self.re, [-sin, cos]));
        [(grows - falls).scaled(0.5), (grows + falls).scaled(0.5)]
    }

    /// i sin z = sinh iz, and cos z = cosh iz.
    #[inline(always)]
    pub(crate) fn sin_cos(self) -> [Self; 2] {
        let [sinh, cosh] = self.turned().sinh_cosh();
        [-sinh.turned(), cosh]
    }

    /// atan z = (ln(1 + iz) − ln(1 − iz))/2i, if both logarithms have their argument on the right.
    fn atan(self) -> Self {
        let (one, turned) = (Self::exact(1.0), self.turned());
        -((one + turned).ln() - (one - turned).ln()).turned().scaled(0.5)
    }

    /// asin z = atan(z/√(1 − z²)).
    fn asin(self) -> Self {
        let one = Self::exact(1.0);
        (self / ((one - self) * (one + self)).sqrt()).atan()
    }

    /// A function on the disc, where all discs that belong together are on `side` of the imaginary axis; unknown where
    /// it is not analytic.
    #[inline(always)]
    pub(crate) fn call(self, function: Function, side: f64) -> Self {
        let one = Self::exact(1.0);
        match function {
            Function::Exp => self.exp(),
            Function::Sinh => self.sinh_cosh()[0],
            Function::Cosh => self.sinh_cosh()[1],
            Function::Sin => self.sin_cos()[0],
            Function::Cos => self.sin_cos()[1],
            // On one side no pole is near, and exp decays: tanh z = ±(1 − 2w/(1 + w)) with w = exp(∓2z).
            Function::Tanh if side != 0.0 => {
                let decays = self.scaled(-2.0 * side).exp();
                let above = one + decays;
                let value = (one - (decays + decays) / above).scaled(side);
                if above.side() > 0.0 { value } else { Self::UNKNOWN }
            }
            Function::Asin => self.asin(),
            Function::Acos => Self::of(half_pi()) - self.asin(),
            // On one side and far away atan z = ±π/2 − atan(1/z), which is the same function on that side.
            Function::Atan if side != 0.0 && self.near() > 1.0 => {
                Self::of(half_pi()).scaled(side) - self.inverse().atan()
            }
            Function::Atan => self.atan(),
            Function::Ln => self.ln(),
            Function::Log10 => self.ln() / Self::of(Ball::exact(10.0).ln()),
            Function::Sqrt => self.sqrt(),
            Function::Abs if side != 0.0 => self.scaled(side),
            Function::Sign if side != 0.0 => Self::exact(side),
            Function::Step if side != 0.0 => Self::exact(side.step()),
            // Tan, and tanh on both sides, are quotients, whose divisors all discs have to see together.
            Function::Tan | Function::Tanh => Self::UNKNOWN,
            Function::Abs | Function::Sign | Function::Step | Function::Table(_) => Self::UNKNOWN,
        }
    }

    /// a^b = exp(b ln a).
    #[inline(always)]
    pub(crate) fn power(self, exponent: Self) -> Self {
        (exponent * self.ln()).exp()
    }
}

impl Add for Disc {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (re, im) = (self.re + other.re, self.im + other.im);
        Self { re, im, rad: (self.rad + other.rad + U * (re.abs() + im.abs())) * UP }
    }
}

impl Neg for Disc {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { re: -self.re, im: -self.im, rad: self.rad }
    }
}

impl Sub for Disc {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Disc {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.far(), other.far());
        Self {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
            rad: (a * other.rad + self.rad * b + self.rad * other.rad + a * b * ROUNDING) * UP,
        }
    }
}

impl Div for Disc {
    type Output = Self;

    #[inline(always)]
    #[allow(clippy::suspicious_arithmetic_impl, reason = "the inverse is what divides")]
    fn div(self, other: Self) -> Self {
        self * other.inverse()
    }
}
