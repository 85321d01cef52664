//! The numbers of a case, kept exactly as they are written.

use crate::number::Real;
use std::fmt;

use serde::de::{self, Deserialize, Deserializer, Visitor};
use serde::{Serialize, Serializer};

/// A decimal number with all its digits, so that 0.1 is one tenth in every precision and not the nearest `f64`.
#[derive(Debug, Clone)]
pub struct Decimal {
    /// The number as TOML, without underscores or a plus sign.
    text: String,
    /// The nearest `f64`.
    value: f64,
}

impl Decimal {
    /// The number in `S`, rounded once.
    pub fn to<S: Real>(&self) -> S {
        S::from_decimal(&self.text).unwrap_or_else(|| S::from(self.value))
    }

    /// The nearest `f64`.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Restores the digits that the deserialiser rounded away: `literal` is the same number as it stands in the file.
    pub(super) fn set_literal(&mut self, literal: &str) {
        let text = literal.trim_start_matches('+').replace('_', "");
        // Hexadecimal, octal and binary literals do not parse here; they are integers and were read exactly.
        if text.parse::<f64>().is_ok_and(|value| value == self.value) {
            self.text = text;
        }
    }

    /// The number as TOML.
    pub(super) fn literal(&self) -> &str {
        &self.text
    }
}

/// With so many digits, any number of either precision is read back as the same number.
const ROUND_TRIP_DIGITS: u32 = 73;

impl<S: Real> From<S> for Decimal {
    fn from(value: S) -> Self {
        Self { text: value.to_decimal(ROUND_TRIP_DIGITS), value: value.to_f64() }
    }
}

/// Two decimals are equal if they round to the same number in every precision.
impl PartialEq for Decimal {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value && self.to::<crate::number::Extended>() == other.to::<crate::number::Extended>()
    }
}

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.value, f)
    }
}

impl<'de> Deserialize<'de> for Decimal {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Number;

        impl Visitor<'_> for Number {
            type Value = Decimal;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number")
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> Result<Decimal, E> {
                Ok(Decimal::from(value))
            }

            fn visit_i64<E: de::Error>(self, value: i64) -> Result<Decimal, E> {
                Ok(Decimal { text: value.to_string(), value: value as f64 })
            }

            fn visit_u64<E: de::Error>(self, value: u64) -> Result<Decimal, E> {
                Ok(Decimal { text: value.to_string(), value: value as f64 })
            }
        }

        deserializer.deserialize_f64(Number)
    }
}

/// Writes an `f64`; [`super::Case::to_toml`] replaces it by the exact decimal afterwards.
impl Serialize for Decimal {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(self.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::Extended;

    fn read(literal: &str) -> Decimal {
        let mut decimal = Decimal::from(literal.replace('_', "").parse::<f64>().unwrap());
        decimal.set_literal(literal);
        decimal
    }

    #[test]
    fn a_tenth_is_a_tenth() {
        let tenth = Extended::from(1.0) / Extended::from(10.0);
        for literal in ["0.1", "+0.1", "1e-1", "0.10", "1.0e-1", "0.1_0"] {
            assert_eq!(read(literal).to::<Extended>(), tenth, "{literal}");
            assert_eq!(read(literal).to::<f64>(), 0.1);
        }
        assert_eq!(Decimal::from(tenth).to::<Extended>(), tenth);
        let long = "0.1000000000000000000000000000000000000000001";
        assert_eq!(read(long).literal(), long);
        assert!(read(long) != read("0.1") && read(long).value() == 0.1);
        assert_eq!(read("0.10000000000000000000000000"), read("0.1"));
    }
}
