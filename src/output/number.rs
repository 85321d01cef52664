//! Numbers in JSON with all their digits.

use serde::ser::Error as _;
use serde::{Serialize, Serializer};
use serde_json::value::RawValue;

use crate::scalar::Real;

/// A number on its way into JSON: an `f64`, or an extended one by its decimals, which JSON allows any number of.
#[derive(Debug, Clone, PartialEq)]
pub enum Number {
    /// Written as the shortest decimal that reads back as itself; null if it is not finite.
    Double(f64),
    /// Written as it stands.
    Digits(String),
}

impl Number {
    /// `value` with so many significant digits (all that an `f64` has).
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
