//! Numbers in JSON with all their digits.

use crate::number::Real;
use serde::ser::Error as _;
use serde::{Serialize, Serializer};
use serde_json::value::RawValue;

/// A number to be written as JSON: an `f64`, or the decimals of an extended number. JSON allows any number of digits.
#[derive(Debug, Clone, PartialEq)]
pub enum Number {
    /// Written as the shortest decimal that reads back as itself; null if it is not finite.
    Double(f64),
    /// Written as it is.
    Digits(String),
}

impl Number {
    /// `value` with the given number of significant digits; an `f64` keeps all of its digits.
    pub fn new<S: Real>(value: S, digits: u32) -> Self {
        if S::IS_EXTENDED && value.is_finite() {
            Self::Digits(value.to_decimal(digits))
        } else {
            Self::Double(value.to_f64())
        }
    }
}

impl Serialize for Number {
    fn serialize<T: Serializer>(&self, serializer: T) -> Result<T::Ok, T::Error> {
        match self {
            Self::Double(value) => serializer.serialize_f64(*value),
            Self::Digits(text) => RawValue::from_string(text.clone()).map_err(T::Error::custom)?.serialize(serializer),
        }
    }
}
