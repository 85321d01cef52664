//! Numbers whose exponents reach further than those of their type.

use std::marker::PhantomData;

use super::algebra::{Algebra, binary};
use super::operation::Fused;
use crate::number::{Function, Real};

/// An exponent counts powers of 2^256, and a significand that is neither 0 nor infinite lies between 2^−128 and 2^128.
const BITS: i32 = 256;

/// The exponential of a larger argument cannot be known: its argument is rounded too much.
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

    fn minus(self) -> Self {
        Self { significand: -self.significand, ..self }
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
        let half = |sum: Self| sum.times(Self::new(S::ONE.half(), 0));
        match function {
            Function::Exp => self.exp(),
            Function::Ln => self.ln(),
            Function::Log10 => self.ln().over(Self::new(S::LN_10, 0)),
            Function::Sqrt => self.sqrt(),
            Function::Abs => Self::new(self.significand.abs(), self.exponent),
            Function::Cosh => half(self.exp().plus(self.minus().exp())),
            Function::Sinh if self.nearest().abs() > S::ONE => half(self.exp().plus(self.minus().exp().minus())),
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

/// Wide numbers as values of a program.
pub(super) struct Wides<S>(pub(super) PhantomData<S>);

impl<S: Real> Wides<S> {
    fn binary(to: &mut Wide<S>, a: &Wide<S>, b: &Wide<S>, f: impl Fn(Wide<S>, Wide<S>) -> Wide<S>) {
        *to = f(*a, *b);
    }
}

impl<S: Real> Algebra for Wides<S> {
    type Value = Wide<S>;

    binary!(add Wide::plus, subtract |a, b| a.plus(b.minus()));
    binary!(multiply Wide::times, divide Wide::over, power Wide::powf);

    fn negate(&self, to: &mut Wide<S>, a: &Wide<S>) {
        *to = a.minus();
    }

    fn call(&self, to: &mut Wide<S>, function: Function, a: &Wide<S>) {
        *to = a.call(function);
    }

    fn fused(&self, to: &mut Wide<S>, fused: Fused, [a, b, c]: [&Wide<S>; 3]) {
        let product = a.times(*b);
        *to = match fused {
            Fused::Add => product.plus(*c),
            Fused::Subtract => product.plus(c.minus()),
            Fused::SubtractFrom => product.minus().plus(*c),
        };
    }
}
