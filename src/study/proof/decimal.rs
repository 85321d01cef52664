//! Numbers with a bound of what they are off by, as decimals.

use crate::number::{Extended, Real};

/// No number at the end is written with more digits.
const MOST_DIGITS: i32 = 40;

/// The decimal with the digits above `radius` and one more, and a bound of the distance of the true number from it.
pub fn decimal(value: Extended, radius: f64) -> (String, f64) {
    let size = value.abs().to_f64();
    let place = |number: f64| number.log10().floor() as i32;
    // A number that may be 0 has the digits of its radius.
    let significant = if size > 0.0 && radius > 0.0 {
        place(size).saturating_sub(place(radius)).saturating_add(2)
    } else {
        MOST_DIGITS
    };
    let text = value.to_decimal(significant.clamp(1, MOST_DIGITS) as u32);
    let read = Extended::from_decimal(&text).unwrap_or(value);
    // The difference is exact to its last digits, and the sum rounds once.
    let radius = (radius + (value - read).abs().to_f64()) * (1.0 + 8.0 * f64::EPSILON);
    (text, radius)
}
