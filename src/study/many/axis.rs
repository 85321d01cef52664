//! A key and the values that it takes.

use std::str::FromStr;

use crate::case::key_of;
use crate::number::{Extended, Real};

/// More values than this are taken for a typing mistake.
const MOST_VALUES: usize = 10_000_000;

const EXPECTED: &str = "expected KEY=VALUE,VALUE,… or KEY=START:STOP:COUNT, for example initial.x=0.1:0.9:9";
/// Between the ends of an interval.
const TO: &str = "..";

/// A key of a case with the values that it takes, read from `KEY=VALUE,VALUE,…`, `KEY=START:STOP:COUNT` or
/// `KEY=START..STOP:COUNT`.
///
/// The values of a list are kept as they are written. Those of a range are equidistant, START and STOP among them:
/// START + k (STOP − START)/(COUNT − 1), computed from the decimals that were written and rounded once to `f64`.
/// `0.1:0.3:3` has 0.2 and not a neighbour of it. Between whole ends whole values stay whole numbers.
///
/// With two points between START and STOP the values are COUNT intervals, `[LOW, HIGH]`, which cover all between both:
/// each begins where the one before ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Axis {
    /// The text that it was read from.
    pub text: String,
    /// The key, dotted.
    pub key: String,
    /// The values, in order; there is at least one.
    pub values: Vec<String>,
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (_, values) = text.split_once('=').ok_or(EXPECTED)?;
        let key = key_of(text).ok_or_else(|| format!("there is no dotted key: {EXPECTED}"))?;
        let items = split(values);
        if items.iter().any(String::is_empty) {
            return Err(format!("a value is missing: {EXPECTED}"));
        }
        let values = match items.as_slice() {
            [one] if is_range(one) => range(one)?,
            _ => match items.iter().find(|item| is_range(item)) {
                Some(item) => return Err(format!("{item} is a range: give one range, or a list of values")),
                None => items,
            },
        };
        Ok(Self { text: text.to_owned(), key, values })
    }
}

/// Returns true if a value is meant as a range: no value of a case but a quoted string or an array has a colon.
fn is_range(value: &str) -> bool {
    value.contains(':') && !value.starts_with(['"', '\'', '[', '{'])
}

/// The parts of a list, without blanks around them. Commas inside of quotes and brackets belong to a value.
fn split(list: &str) -> Vec<String> {
    let (mut parts, mut depth, mut quote) = (vec![String::new()], 0_usize, None);
    for c in list.chars() {
        match (c, quote) {
            ('"' | '\'', None) => quote = Some(c),
            (_, Some(open)) if c == open => quote = None,
            ('[' | '{' | '(', None) => depth += 1,
            (']' | '}' | ')', None) => depth = depth.saturating_sub(1),
            (',', None) if depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        let last = parts.len() - 1;
        parts[last].push(c);
    }
    parts.iter().map(|part| part.trim().to_owned()).collect()
}

fn range(text: &str) -> Result<Vec<String>, String> {
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    if let &[ends, count] = parts.as_slice()
        && let Some((first, last)) = ends.split_once(TO)
    {
        return intervals([first.trim(), last.trim()], count);
    }
    let &[first, last, count] = parts.as_slice() else {
        return Err(format!("{text} is no range: expected START:STOP:COUNT, for example 0.1:0.9:9"));
    };
    values([first, last], count)
}

/// So many intervals side by side.
fn intervals(ends: [&str; 2], count: &str) -> Result<Vec<String>, String> {
    let many: usize = match count.parse() {
        Ok(many) if (1..MOST_VALUES).contains(&many) => many,
        _ => return Err(format!("'{count}' is not a number of intervals: expected START..STOP:COUNT")),
    };
    let places = values(ends, &(many + 1).to_string())?;
    let [first, last] = ends.map(|end| end.parse::<f64>().unwrap_or(f64::NAN));
    let order = if first > last { [1, 0] } else { [0, 1] };
    Ok(places.windows(2).map(|pair| format!("[{}, {}]", pair[order[0]], pair[order[1]])).collect())
}

/// So many values between two ends.
fn values([first, last]: [&str; 2], count: &str) -> Result<Vec<String>, String> {
    let number = |text: &str| {
        let is_finite = text.parse::<f64>().is_ok_and(f64::is_finite);
        let number = is_finite.then(|| Extended::from_decimal(text)).flatten();
        number.ok_or_else(|| format!("'{text}' is not a finite number: START and STOP of a range are decimals"))
    };
    let [start, stop] = [number(first)?, number(last)?];
    let count: usize =
        count.parse().map_err(|_| format!("'{count}' is not a number of values: expected START:STOP:COUNT"))?;
    let mistake = match (count, start == stop) {
        (0, _) => Some("a range has at least one value".to_owned()),
        (1, false) => Some(format!("one value cannot reach from {first} to {last}: COUNT counts both ends")),
        (2.., true) => Some(format!("{first} and {last} are the same: give COUNT as 1, or another STOP")),
        _ => (count > MOST_VALUES).then(|| format!("more than {MOST_VALUES} values")),
    };
    if let Some(mistake) = mistake {
        return Err(mistake);
    }
    let steps = Extended::from((count.max(2) - 1) as f64);
    // Both ends are as they are written.
    let value = |k: Extended| {
        let sum = start * (steps - k) + stop * k;
        // What is left of 0 is the rounding of decimals in 71 digits.
        let is_rounding = sum.abs() <= Extended::from(64.0) * Extended::EPSILON * steps * start.abs().max(stop.abs());
        if is_rounding { 0.0 } else { (sum / steps).to_f64() }
    };
    let values: Vec<f64> = (0..count).map(|k| value(Extended::from(k as f64))).collect();
    let is_whole = [first, last].iter().all(|text| text.parse::<i64>().is_ok());
    let are_whole = is_whole && values.iter().all(|value| value.fract() == 0.0 && value.abs() < 1e15);
    Ok(values.iter().map(|value| if are_whole { format!("{value}") } else { value.to_decimal(16) }).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_have_their_ends_and_the_shortest_decimals_and_lists_are_kept() {
        for (text, values) in [
            ("a=0.1:0.9:9", "0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8 0.9"),
            ("a=1:-1:3", "1 0 -1"),
            ("a=10:40:4", "10 20 30 40"),
            ("a=0:1:3", "0.0 0.5 1.0"),
            ("a=-0.1:0.3:5", "-0.1 0.0 0.1 0.2 0.3"),
            ("a=0.5:0.5:1", "0.5"),
            ("a = 1e-3 : 3e-3 : 3", "0.001 0.002 0.003"),
            // The sum of ends that have no double between them in `f64`.
            ("a=-1e308:1e308:3", "-1e+308 0.0 1e+308"),
            ("a.b=1, 2.50 ,SBP21", "1 2.50 SBP21"),
            ("a=\"x, y\",[1, 2],[3]", "\"x, y\" [1, 2] [3]"),
            ("a=\"b:c\"", "\"b:c\""),
            ("a=0.1..0.3:2", "[0.1, 0.2] [0.2, 0.3]"),
            ("a = -1 .. 1 : 1", "[-1, 1]"),
            ("a=2..1:2", "[1.5, 2.0] [1.0, 1.5]"),
        ] {
            assert_eq!(text.parse::<Axis>().unwrap().values.join(" "), values);
        }
        assert_eq!("a.\"b\" = 1".parse::<Axis>().unwrap().key, "a.b");
    }

    #[test]
    fn what_is_no_axis_is_refused() {
        for (text, message) in [
            ("=1", "no dotted key"),
            ("a=1,,2", "a value is missing"),
            ("a=1:2:3:4", "START:STOP:COUNT"),
            ("a=x:2:3", "'x' is not a finite number"),
            ("a=0:inf:3", "'inf' is not a finite number"),
            ("a=0:1:2.5", "'2.5' is not a number of values"),
            ("a=0:1:-2", "'-2' is not a number of values"),
            ("a=0:1:0", "at least one value"),
            ("a=0:1:10000001", "more than 10000000"),
            ("a=1,2:3:4", "2:3:4 is a range"),
            ("a=1..2:0", "'0' is not a number of intervals"),
            ("a=1..1:2", "are the same"),
            ("a=1..x:2", "'x' is not a finite number"),
        ] {
            let error = text.parse::<Axis>().unwrap_err();
            assert!(error.contains(message), "{text}: {error}");
        }
    }
}
