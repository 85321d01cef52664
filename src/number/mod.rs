//! The trait of number types, [`Real`], and its two implementations: `f64` and [`Extended`].
//!
//! Operators, metric, action gradient, collocation, diagnostics and reference are written once for both types. Only the
//! quantities that steer an iteration (Jacobians, damping, first guesses) are always `f64`: a correction needs only a
//! few digits, whereas a residual needs all of them.
//!
//! ```
//! use geodesic_ivp::number::{Extended, Real};
//!
//! fn tenth<S: Real>() -> S {
//!     S::from_decimal("0.1").expect("it is a number")
//! }
//! assert_eq!(tenth::<f64>() * 3.0 - 0.3, 5.551115123125783e-17);
//! let three = Extended::from(3.0);
//! assert!((tenth::<Extended>() * three - Extended::from_decimal("0.3").expect("a number")).to_f64().abs() < 1e-70);
//! ```

pub(crate) mod ball;
mod compensated;
mod decimal;
mod function;
mod noise;
pub mod norm;
pub(crate) mod root;
pub(crate) mod runge_kutta;
pub mod spline;
pub(crate) mod vector;

pub(crate) use compensated::Compensated;
pub use function::Function;
pub(crate) use noise::Noise;

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// IEEE 754 binary256: 237 significant bits, 71 decimal digits, correctly rounded arithmetic.
pub type Extended = f256::f256;

/// Functions by their names in formulas.
macro_rules! functions {
    ($($name:ident)*) => {$(
        #[doc = concat!("The function `", stringify!($name), "` of formulas.")]
        fn $name(self) -> Self;
    )*};
}

/// A kind of things of which there is one for every type of numbers.
pub trait Kind {
    /// Such a thing in numbers of this type.
    type Of<S: Real>;
}

/// A type of real numbers. Its functions are those of the formula grammar, in the full precision of the type.
pub trait Real:
    Copy
    + Debug
    + Default
    + PartialOrd
    + Send
    + Sync
    + 'static
    + From<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// π.
    const PI: Self;
    /// ln 10.
    const LN_10: Self;
    /// Distance from 1 to the next larger number.
    const EPSILON: Self;
    /// Smallest positive normal number.
    const MIN_POSITIVE: Self;
    /// Largest number of significant decimal digits that can be asked for in this type.
    const MOST_DIGITS: u32;
    /// True if this type has more digits than `f64`.
    const IS_EXTENDED: bool;

    /// The `numbers` in this type.
    fn constants(numbers: &Constants) -> &[Self];
    /// The thing of this type, where code that does not know the type has one of each, made when it is asked for.
    fn choose<K: Kind>(in_f64: impl FnOnce() -> K::Of<f64>, extended: impl FnOnce() -> K::Of<Extended>) -> K::Of<Self>;
    /// A thing of this type, if that is `f64`.
    fn in_f64<K: Kind>(own: K::Of<Self>) -> Option<K::Of<f64>>;
    /// The nearest `f64`.
    fn to_f64(self) -> f64;
    /// The number nearest to a decimal such as `-1.5e-3`; `None` if the text is not one.
    fn from_decimal(text: &str) -> Option<Self>;
    /// The number as a decimal in `room`: the shortest that reads back as the same `f64`, or the given number of
    /// significant digits without trailing zeros.
    fn write_decimal(self, digits: u32, room: &mut DecimalRoom) -> &str;

    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// NaN.
    fn is_nan(self) -> bool;
    /// |self|.
    fn abs(self) -> Self;
    /// The larger of the two; if one is NaN, the other one.
    fn max(self, other: Self) -> Self;
    /// 1 or −1, with the sign of the number; for 0 and −0 too.
    fn signum(self) -> Self;
    /// self^exponent.
    fn powf(self, exponent: Self) -> Self;
    functions!(sqrt exp ln log10 sin cos tan asin acos atan sinh cosh tanh);

    /// The number as text, see [`Self::write_decimal`].
    fn to_decimal(self, digits: u32) -> String {
        self.write_decimal(digits, &mut DecimalRoom::default()).to_owned()
    }

    /// ½ self.
    #[inline]
    fn half(self) -> Self {
        Self::from(0.5) * self
    }

    /// 1, −1 or 0, also for −0: the derivative of [`Self::abs`]. NaN of a NaN.
    #[inline(always)]
    fn sign(self) -> Self {
        if self > Self::ZERO {
            Self::ONE
        } else if self < Self::ZERO {
            -Self::ONE
        } else {
            self.abs()
        }
    }

    /// 0 below 0, and 1 from 0 on. NaN of a NaN.
    #[inline(always)]
    fn step(self) -> Self {
        if self >= Self::ZERO {
            Self::ONE
        } else if self < Self::ZERO {
            Self::ZERO
        } else {
            self
        }
    }
}

/// Numbers that are computed once, in extended precision, for both types. [`Real::constants`] takes those of one type.
#[derive(Debug)]
pub struct Constants {
    exact: Vec<Extended>,
    rounded: Vec<f64>,
}

impl Constants {
    /// Keeps these numbers in 70 digits and as doubles, so that neither is converted in a loop.
    pub fn new(exact: Vec<Extended>) -> Self {
        let rounded = exact.iter().map(|number| number.to_f64()).collect();
        Self { exact, rounded }
    }
}

/// A buffer for the decimals of a number, which can be used again for the next number.
#[derive(Default)]
pub struct DecimalRoom {
    double: zmij::Buffer,
    extended: String,
}

/// Σ terms, from left to right.
pub(crate) fn sum<S: Real>(terms: impl Iterator<Item = S>) -> S {
    terms.fold(S::ZERO, |sum, term| sum + term)
}

/// Methods that the type has itself.
macro_rules! inherent {
    ($type:ty: $($name:ident($($other:ident)?) -> $out:ty),*) => {$(
        #[inline]
        fn $name(self $(, $other: Self)?) -> $out {
            <$type>::$name(self $(, $other)?)
        }
    )*};
    ($type:ty: $($name:ident)*) => { inherent!($type: $($name() -> Self),*); };
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const PI: Self = std::f64::consts::PI;
    const LN_10: Self = std::f64::consts::LN_10;
    const EPSILON: Self = f64::EPSILON;
    const MIN_POSITIVE: Self = f64::MIN_POSITIVE;
    const MOST_DIGITS: u32 = 16;
    const IS_EXTENDED: bool = false;

    fn constants(numbers: &Constants) -> &[Self] {
        &numbers.rounded
    }

    fn choose<K: Kind>(in_f64: impl FnOnce() -> K::Of<Self>, _: impl FnOnce() -> K::Of<Extended>) -> K::Of<Self> {
        in_f64()
    }

    fn in_f64<K: Kind>(own: K::Of<Self>) -> Option<K::Of<Self>> {
        Some(own)
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self
    }

    fn from_decimal(text: &str) -> Option<Self> {
        text.parse().ok()
    }

    #[inline]
    fn write_decimal(self, _: u32, room: &mut DecimalRoom) -> &str {
        room.double.format(self)
    }

    inherent!(f64: is_finite() -> bool, is_nan() -> bool, max(other) -> Self, powf(exponent) -> Self);
    inherent!(f64: abs signum sqrt exp ln log10 sin cos tan asin acos atan sinh cosh tanh);
}

macro_rules! by_reference {
    ($($name:ident)*) => {
        $(fn $name(self) -> Self { Extended::$name(&self) })*
    };
}

/// Exponents of extended numbers are below it.
const MOST_EXPONENT: f64 = 2_147_483_647.0;

impl Real for Extended {
    const ZERO: Self = Extended::ZERO;
    const ONE: Self = Extended::ONE;
    const PI: Self = f256::consts::PI;
    const LN_10: Self = f256::consts::LN_10;
    const EPSILON: Self = Extended::EPSILON;
    const MIN_POSITIVE: Self = Extended::MIN_POSITIVE;
    // The type has a little more than 71 digits; the last one is left to rounding.
    const MOST_DIGITS: u32 = 70;
    const IS_EXTENDED: bool = true;

    fn constants(numbers: &Constants) -> &[Self] {
        &numbers.exact
    }

    fn choose<K: Kind>(_: impl FnOnce() -> K::Of<f64>, extended: impl FnOnce() -> K::Of<Self>) -> K::Of<Self> {
        extended()
    }

    fn in_f64<K: Kind>(_: K::Of<Self>) -> Option<K::Of<f64>> {
        None
    }

    fn to_f64(self) -> f64 {
        decimal::to_f64(self)
    }

    fn from_decimal(text: &str) -> Option<Self> {
        decimal::parse(text)
    }

    fn write_decimal(self, digits: u32, room: &mut DecimalRoom) -> &str {
        room.extended.clear();
        decimal::push(self, digits, &mut room.extended);
        &room.extended
    }

    inherent!(Extended: is_finite() -> bool, is_nan() -> bool, max(other) -> Self, sqrt() -> Self);
    by_reference!(abs exp ln log10 sin cos tan asin acos atan);

    fn powf(self, exponent: Self) -> Self {
        if exponent.abs() < Self::from(MOST_EXPONENT) {
            return Extended::powf(&self, &exponent);
        }
        // The library takes no others, and panics.
        match exponent.is_finite() && self > Self::ZERO {
            true => (exponent * self.ln()).exp(),
            false => Self::from(self.to_f64().powf(exponent.to_f64())),
        }
    }

    fn signum(self) -> Self {
        Extended::ONE.copysign(self)
    }

    // The hyperbolic functions are computed from e^u − 1, which is accurate for small u.
    fn sinh(self) -> Self {
        let e = Extended::exp_m1(&Extended::abs(&self));
        let size = if e.is_finite() { (e + e / (e + Self::ONE)).half() } else { e };
        size.copysign(self)
    }

    fn cosh(self) -> Self {
        let e = Extended::exp(&Extended::abs(&self));
        (e + Self::ONE / e).half()
    }

    fn tanh(self) -> Self {
        let e = Extended::exp_m1(&Extended::abs(&self).mul2());
        // e/(e + 2) of what is beyond the range of numbers; NaN stays what it is.
        let size = if e == Extended::INFINITY { Self::ONE } else { e / (e + Extended::TWO) };
        size.copysign(self)
    }
}
