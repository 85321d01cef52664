//! Advice for mistakes in a formula.

use super::functions;
use crate::formula::similar::nearest;

/// Words and signs of other languages, and what is written here instead.
const OTHERS: [(&str, &str); 23] = [
    ("pow", "pow(a, b) is written a^b"),
    ("log", "the natural logarithm is ln, the one to base 10 is log10"),
    ("log2", "the logarithm to base 2 is ln(x)/ln(2)"),
    ("cot", "cot(x) is written 1/tan(x)"),
    ("sec", "sec(x) is written 1/cos(x)"),
    ("csc", "csc(x) is written 1/sin(x)"),
    ("cbrt", "for x > 0 the cube root is x^(1/3)"),
    ("square", "a square is written x^2"),
    ("sqr", "a square is written x^2, a square root sqrt(x)"),
    ("arcsin", "the inverse sine is asin"),
    ("arccos", "the inverse cosine is acos"),
    ("arctan", "the inverse tangent is atan"),
    ("fabs", "the absolute value is abs"),
    ("sgn", "the sign is sign"),
    ("heaviside", "0 below 0, and 1 from 0 on, is step"),
    ("arctan2", "the angle of (x, y) is atan2(y, x)"),
    ("e", "Euler's number is exp(1)"),
    ("²", "a square is written ^2"),
    ("³", "a cube is written ^3"),
    ("−", "a minus sign is written -"),
    ("·", "a product is written with *"),
    ("×", "a product is written with *"),
    ("|", "an absolute value is written abs(x)"),
];

/// Returns the name to write instead of the text at `offset`, where `names` exist besides functions.
pub(super) fn at<'n>(expression: &str, offset: usize, names: impl Iterator<Item = &'n str>) -> Option<String> {
    let (before, rest) = expression.split_at(offset);
    if rest.starts_with('*') && before.trim_end().ends_with('*') {
        return Some("a power is written ^, for example x^2".to_owned());
    }
    // A number before a name is pointed at where it begins, one before a parenthesis where that does.
    let digits = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
    let (number, factor) = rest.split_at(digits);
    let end = factor.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(factor.len());
    if digits > 0 && end > 0 {
        return Some(format!("a product is written with *: {number}*{}", &factor[..end]));
    }
    if rest.starts_with('(') && before.trim_end().ends_with(|c: char| c.is_ascii_digit() || ").".contains(c)) {
        return Some("a product is written with *".to_owned());
    }
    let length = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(rest.len());
    let word = match length {
        0 => &rest[..rest.chars().next().map_or(0, char::len_utf8)],
        length => &rest[..length],
    };
    let other = |name: &str| OTHERS.iter().find(|(other, _)| *other == name).map(|(_, meaning)| (*meaning).to_owned());
    if let Some(meaning) = other(word).or_else(|| other(&word.to_lowercase())) {
        return Some(meaning);
    }
    let known = functions().map(|name| -> &str { name }).chain(names);
    nearest(word, known).filter(|name| *name != word).map(|name| format!("did you mean '{name}'?"))
}
