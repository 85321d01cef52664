//! Numbers whose exponents reach further than those of their type.

use super::graph::Fused;
use super::machine::Machine;
use super::program::Register;
use crate::number::Function;
use crate::number::Real;

/// An exponent counts powers of 2^256, and a significand that is neither 0 nor infinite lies between 2^−128 and 2^128.
const BITS: i32 = 256;

/// What the exponential of a larger argument is cannot be known: its argument is rounded too much.
const MOST_ARGUMENT: f64 = 1e15;

/// significand · 2^(256 exponent). Functions but exp, ln and roots are those of the type, as far as that reaches.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wide<S> {
    significand: S,
    exponent: i64,
}

/// 2^(128 halves).
fn power<S: Real>(halves: i32) -> S {
    S::from(2.0_f64.powi(BITS / 2 * halves))
}

impl<S: Real> Wide<S> {
    fn new(significand: S, exponent: i64) -> Self {
        let mut number = Self { significand, exponent };
        if significand == S::ZERO || !significand.is_finite() {
            return Self { exponent: 0, ..number };
        }
        while number.significand.abs() >= power(1) {
            number = Self { significand: number.significand * power(-2), exponent: number.exponent + 1 };
        }
        while number.significand.abs() < power(-1) {
            number = Self { significand: number.significand * power(2), exponent: number.exponent - 1 };
        }
        number
    }

    /// The nearest number of the type.
    pub(super) fn nearest(self) -> S {
        let (mut value, factor) = (self.significand, power(if self.exponent > 0 { 2 } else { -2 }));
        for _ in 0..self.exponent.unsigned_abs() {
            if value == S::ZERO || !value.is_finite() {
                break;
            }
            value *= factor;
        }
        value
    }

    fn plus(self, other: Self) -> Self {
        let is_larger = self.significand == S::ZERO || self.exponent < other.exponent && other.significand != S::ZERO;
        let (large, small) = if is_larger { (other, self) } else { (self, other) };
        match large.exponent.saturating_sub(small.exponent) {
            0 => Self::new(large.significand + small.significand, large.exponent),
            1 => Self::new(large.significand + small.significand * power(-2), large.exponent),
            _ => Self::new(large.significand + small.significand * S::ZERO, large.exponent),
        }
    }

    fn times(self, other: Self) -> Self {
        Self::new(self.significand * other.significand, self.exponent.saturating_add(other.exponent))
    }

    fn over(self, other: Self) -> Self {
        Self::new(self.significand / other.significand, self.exponent.saturating_sub(other.exponent))
    }

    fn sqrt(self) -> Self {
        let root = self.significand.sqrt();
        let odd = if self.exponent.rem_euclid(2) == 1 { power(1) } else { S::ONE };
        Self::new(root * odd, self.exponent.div_euclid(2))
    }

    fn exp(self) -> Self {
        let (argument, unit) = (self.nearest(), S::from(2.0).ln() * S::from(f64::from(BITS)));
        if argument.abs() > S::from(MOST_ARGUMENT) || argument.is_nan() {
            return Self::new(argument.exp(), 0);
        }
        let exponent = (argument / unit).to_f64().round();
        Self::new((argument - S::from(exponent) * unit).exp(), exponent as i64)
    }

    fn ln(self) -> Self {
        let unit = S::from(2.0).ln() * S::from(f64::from(BITS));
        Self::new(self.significand.ln() + S::from(self.exponent as f64) * unit, 0)
    }

    fn call(self, function: Function) -> Self {
        let minus = Self::new(-self.significand, self.exponent);
        let half = |sum: Self| sum.times(Self::new(S::ONE.half(), 0));
        match function {
            Function::Exp => self.exp(),
            Function::Ln => self.ln(),
            Function::Log10 => self.ln().over(Self::new(S::LN_10, 0)),
            Function::Sqrt => self.sqrt(),
            Function::Abs => Self::new(self.significand.abs(), self.exponent),
            Function::Cosh => half(self.exp().plus(minus.exp())),
            Function::Sinh if self.nearest().abs() > S::ONE => {
                let other = minus.exp();
                half(self.exp().plus(Self::new(-other.significand, other.exponent)))
            }
            _ => Self::new(function.apply(self.nearest()), 0),
        }
    }

    fn powf(self, exponent: Self) -> Self {
        let usual = self.nearest().powf(exponent.nearest());
        let is_usual = usual.is_finite() && usual != S::ZERO || self.significand <= S::ZERO;
        if is_usual { Self::new(usual, 0) } else { self.ln().times(exponent).exp() }
    }
}

impl<S: Real> From<S> for Wide<S> {
    fn from(number: S) -> Self {
        Self::new(number, 0)
    }
}

/// A wide number in every register.
pub(super) struct Wides<'r, S>(pub(super) &'r mut [Wide<S>]);

impl<S: Real> Machine for Wides<'_, S> {
    fn add(&mut self, to: Register, a: Register, b: Register) {
        self.0[to] = self.0[a].plus(self.0[b]);
    }

    fn subtract(&mut self, to: Register, a: Register, b: Register) {
        self.negate(to, b);
        self.add(to, a, to);
    }

    fn multiply(&mut self, to: Register, a: Register, b: Register) {
        self.0[to] = self.0[a].times(self.0[b]);
    }

    fn divide(&mut self, to: Register, a: Register, b: Register) {
        self.0[to] = self.0[a].over(self.0[b]);
    }

    fn negate(&mut self, to: Register, a: Register) {
        let Wide { significand, exponent } = self.0[a];
        self.0[to] = Wide { significand: -significand, exponent };
    }

    fn power(&mut self, to: Register, a: Register, b: Register) {
        self.0[to] = self.0[a].powf(self.0[b]);
    }

    fn call(&mut self, to: Register, function: Function, a: Register) {
        self.0[to] = self.0[a].call(function);
    }

    fn fused(&mut self, to: Register, fused: Fused, [a, b, c]: [Register; 3]) {
        self.multiply(to, a, b);
        match fused {
            Fused::Add => self.add(to, to, c),
            Fused::Subtract => {
                let Wide { significand, exponent } = self.0[c];
                self.0[to] = self.0[to].plus(Wide { significand: -significand, exponent });
            }
            Fused::SubtractFrom => {
                self.negate(to, to);
                self.add(to, to, c);
            }
        }
    }
}
