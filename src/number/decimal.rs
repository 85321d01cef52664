//! Conversion of extended numbers from and to decimals, correctly rounded by exact integer arithmetic.
//!
//! The f256 crate can convert both ways, at the price of 15 MB of tables. But its formatting with a given precision (in
//! version 0.11.3) writes numbers just below a power of ten ten times too large: 9.99…97 as 9.99…97e1.

use std::sync::LazyLock;

use num_bigint::BigUint;

use super::Extended;

/// Numbers with a decimal exponent beyond this become zero or infinity. No quantity of a case is that small or large,
/// and exact integers of that length would take too long.
const MOST_EXPONENT: i64 = 5000;
/// Numbers are written without an exponent if their decimal exponent is in this range.
const PLAIN: std::ops::Range<i64> = -5..16;

const FRACTION_BITS: u32 = 236;
const FRACTION_BITS_OF_HIGH: u32 = FRACTION_BITS - 128;
const EXPONENT_BIAS: i64 = 262_143;

/// A finite number as sign · significand · 2^exponent.
struct Binary {
    negative: bool,
    /// High and low half, with the leading bit, which the format leaves out.
    significand: (u128, u128),
    exponent: i64,
}

fn decode(number: Extended) -> Binary {
    let (high, low) = number.to_bits();
    let biased = ((high >> FRACTION_BITS_OF_HIGH) & 0x7_ffff) as i64;
    let fraction = high & ((1 << FRACTION_BITS_OF_HIGH) - 1);
    let leading = u128::from(biased != 0) << FRACTION_BITS_OF_HIGH;
    Binary {
        negative: high >> 127 == 1,
        significand: (fraction | leading, low),
        exponent: biased.max(1) - EXPONENT_BIAS - i64::from(FRACTION_BITS),
    }
}

/// The nearest `f64` (in the range of subnormal numbers one of the two nearest).
pub(super) fn to_f64(number: Extended) -> f64 {
    if !number.is_finite() {
        return match (number.is_nan(), number.is_sign_negative()) {
            (true, _) => f64::NAN,
            (_, negative) => f64::INFINITY.copysign(if negative { -1.0 } else { 1.0 }),
        };
    }
    if number.eq_zero() {
        return 0.0_f64.copysign(if number.is_sign_negative() { -1.0 } else { 1.0 });
    }
    let Binary { negative, significand: (high, low), exponent } = decode(number);
    // The first 64 bits are rounded to `f64`. The last of them is set if any later bit is, so that ties are seen.
    let dropped = FRACTION_BITS_OF_HIGH + 1 - 64;
    let sticky = high & ((1 << dropped) - 1) != 0 || low != 0;
    let first = (high >> dropped) as u64 | u64::from(sticky);
    // The power of two is applied in two factors, which are both in the range of `f64` even if their product is not.
    let scale = (exponent + 128 + i64::from(dropped)).clamp(-2400, 2400) as i32;
    let size = first as f64 * power_of_two(scale / 2) * power_of_two(scale - scale / 2);
    if negative { -size } else { size }
}

/// 2^`exponent`.
fn power_of_two(exponent: i32) -> f64 {
    const LAST: i32 = f64::MAX_EXP - 1;
    match exponent {
        -1022..=LAST => f64::from_bits(((exponent + LAST) as u64) << (f64::MANTISSA_DIGITS - 1)),
        _ => 2.0_f64.powi(exponent),
    }
}

/// 10^k for those k for which it is a number of the type.
static POWERS: LazyLock<[Extended; 72]> = LazyLock::new(|| {
    let mut next = Extended::ONE;
    std::array::from_fn(|_| {
        let power = next;
        next *= Extended::from(10.0);
        power
    })
});

/// The number nearest to a decimal of the form `[+-]digits[.digits][e[+-]digits]`; `None` if the text is not one.
pub(super) fn parse(text: &str) -> Option<Extended> {
    // The standard library reads the same texts, and infinities and NaN.
    text.parse::<f64>().ok().filter(|_| !text.contains(['n', 'N']))?;
    let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits = [whole.trim_start_matches(['+', '-']), fraction].concat();
    let exponent = exponent.parse::<i64>().ok()?.saturating_sub(fraction.len() as i64);
    let power = usize::try_from(exponent.unsigned_abs()).ok().and_then(|power| POWERS.get(power));
    if let (Ok(digits), Some(&power)) = (digits.parse::<u128>(), power) {
        // Both are numbers of the type, so that this operation is the only one that rounds.
        let digits = Extended::from(digits);
        let size = if exponent < 0 { digits / power } else { digits * power };
        return Some(if text.starts_with('-') { -size } else { size });
    }
    let digits = BigUint::parse_bytes(digits.as_bytes(), 10)?;
    let size = if digits.bits() == 0 || exponent.saturating_add(mantissa.len() as i64) < -MOST_EXPONENT {
        Extended::ZERO
    } else if exponent > MOST_EXPONENT {
        Extended::INFINITY
    } else {
        let [above, below] = powers_of_ten(exponent);
        nearest(digits * above, below)
    };
    Some(if text.starts_with('-') { -size } else { size })
}

/// 10^`exponent` as a fraction.
fn powers_of_ten(exponent: i64) -> [BigUint; 2] {
    [exponent, -exponent].map(|exponent| BigUint::from(10_u32).pow(exponent.max(0) as u32))
}

/// `number` 2^`exponent`, rounded down.
fn shifted(number: BigUint, exponent: i64) -> BigUint {
    if exponent >= 0 { number << exponent } else { number >> -exponent }
}

/// The number nearest to a quotient of positive integers.
fn nearest(numerator: BigUint, denominator: BigUint) -> Extended {
    // The quotient gets at least 250 bits: more than the 237 of the result, and few enough for two halves of 128 bits.
    let shift = 251 - (numerator.bits() as i64 - denominator.bits() as i64);
    let [numerator, denominator] =
        [(numerator, shift), (denominator, -shift)].map(|(n, shift)| shifted(n, shift.max(0)));
    let quotient = &numerator / &denominator;
    let sticky = quotient.clone() * denominator != numerator;
    let mut limbs = quotient.iter_u64_digits();
    let mut half = || u128::from(limbs.next().unwrap_or(0)) | u128::from(limbs.next().unwrap_or(0)) << 64;
    let (low, high) = (half() | u128::from(sticky), half());
    // This sum is the only operation that rounds.
    let rounded = Extended::from(high).mul_pow2(128) + Extended::from(low);
    if shift >= 0 { rounded.div_pow2(shift as u32) } else { rounded.mul_pow2(shift.unsigned_abs() as u32) }
}

/// Appends `number` to `out`, rounded to `digits` significant digits and without trailing zeros.
pub(super) fn push(number: Extended, digits: u32, out: &mut String) {
    if !number.is_finite() {
        out.push_str(zmij::Buffer::new().format(to_f64(number)));
        return;
    }
    if number.is_sign_negative() {
        out.push('-');
    }
    if number.eq_zero() {
        out.push_str("0.0");
        return;
    }
    let (digits, exponent) = significant(&decode(number), i64::from(digits.max(1)));
    let digits = digits.trim_end_matches('0');
    let zeros = |count: i64| "0".repeat(count as usize);
    if !PLAIN.contains(&exponent) {
        let (first, rest) = digits.split_at(1);
        let point = if rest.is_empty() { "" } else { "." };
        *out += &format!("{first}{point}{rest}e{exponent}");
    } else if exponent < 0 {
        *out += &format!("0.{}{digits}", zeros(-exponent - 1));
    } else {
        let whole = exponent + 1;
        match digits.split_at_checked(whole as usize) {
            Some((whole, rest)) => *out += &format!("{whole}.{}", if rest.is_empty() { "0" } else { rest }),
            None => *out += &format!("{digits}{}.0", zeros(whole - digits.len() as i64)),
        }
    }
}

/// The first `count` digits of |number|, rounded, and the decimal exponent of the first digit.
fn significant(number: &Binary, count: i64) -> (String, i64) {
    let (high, low) = number.significand;
    let significand = (BigUint::from(high) << 128_u32) | BigUint::from(low);
    let log_2 = significand.bits() as f64 - 1.0 + number.exponent as f64;
    let mut exponent = (log_2 * std::f64::consts::LOG10_2).floor() as i64;
    loop {
        // ½ + significand · 2^e · 10^(count − 1 − exponent), rounded down.
        let [above, below] = powers_of_ten(count - 1 - exponent);
        let doubled = shifted(&significand * above, number.exponent + 1) / below;
        let digits = ((doubled + 1_u32) >> 1_u32).to_string();
        match digits.len() as i64 - count {
            0 => return (digits, exponent),
            // The estimate of the exponent was off by one, or rounding carried into another digit.
            more => exponent += more,
        }
    }
}

#[cfg(test)]
mod tests {
    use num_bigint::BigInt;
    use num_rational::Ratio;
    use proptest::prelude::*;

    use super::*;

    type BigRational = Ratio<BigInt>;

    /// A decimal, and the exponent of its last digit.
    fn rational(text: &str) -> (BigRational, i32) {
        let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let power = exponent.parse::<i32>().unwrap() - fraction.len() as i32;
        let digits = BigRational::from_integer(format!("{whole}{fraction}").parse().unwrap());
        (digits * BigRational::from_integer(10.into()).pow(power), power)
    }

    fn exact(number: Extended) -> BigRational {
        let Binary { negative, significand: (high, low), exponent } = decode(number);
        let significand = BigRational::from_integer(((BigUint::from(high) << 128_u32) | BigUint::from(low)).into());
        let size = significand * BigRational::from_integer(2.into()).pow(exponent as i32);
        if negative { -size } else { size }
    }

    fn written(number: Extended, digits: u32) -> String {
        let mut text = String::new();
        push(number, digits, &mut text);
        text
    }

    fn size(value: BigRational) -> BigRational {
        if value < BigRational::from_integer(0.into()) { -value } else { value }
    }

    /// Returns true if neither neighbour of `number` is nearer to `value`.
    fn is_nearest(number: Extended, value: &BigRational) -> bool {
        let error = |number: Extended| size(exact(number) - value);
        error(number) <= error(number.next_up()) && error(number) <= error(number.next_down())
    }

    /// Finite numbers, many of them of ordinary size, with random bits.
    fn numbers() -> impl Strategy<Value = Extended> {
        (any::<u128>(), any::<u128>(), prop_oneof![-300_i64..300, -3000_i64..3000]).prop_map(|(high, low, exponent)| {
            let biased = (exponent + EXPONENT_BIAS) as u128;
            let sign_and_fraction = high & !(0x7_ffff << FRACTION_BITS_OF_HIGH);
            Extended::from_bits((sign_and_fraction | biased << FRACTION_BITS_OF_HIGH, low))
        })
    }

    proptest! {
        #[test]
        fn decimals_of_73_digits_read_back_as_the_same_number(number in numbers()) {
            prop_assert_eq!(parse(&written(number, 73)).unwrap().to_bits(), number.to_bits());
        }

        #[test]
        fn writing_is_correctly_rounded(number in numbers(), digits in 1_u32..75) {
            let text = written(number, digits);
            // |text − number| ≤ half a unit of the last digit asked for.
            let (value, power) = rational(&text);
            let mantissa = text.split('e').next().unwrap().replace(['-', '.'], "");
            let leading = mantissa.trim_start_matches('0').len() as i32 - 1 + power;
            let unit = BigRational::from_integer(10.into()).pow(leading + 1 - digits as i32);
            let distance = value - exact(number);
            prop_assert!(size(distance.clone() + distance) <= unit, "{}", text);
        }

        #[test]
        fn reading_is_correctly_rounded(
            digits in "[1-9][0-9]{0,120}",
            point in 0_usize..120,
            exponent in -400_i64..400,
        ) {
            let (whole, fraction) = digits.split_at(point.min(digits.len()));
            let text = format!("{whole}.{fraction}e{exponent}");
            prop_assert!(is_nearest(parse(&text).unwrap(), &rational(&text).0));
        }

        #[test]
        fn f64_is_exact_there_and_back(number in any::<f64>()) {
            let back = to_f64(Extended::from(number));
            prop_assert!(back.to_bits() == number.to_bits() || number.is_nan() && back.is_nan());
        }

        #[test]
        fn rounding_to_f64_is_to_the_nearest(number in numbers()) {
            let rounded = to_f64(number);
            prop_assume!(rounded.is_normal());
            let error = |f: f64| size(exact(number) - exact(Extended::from(f)));
            prop_assert!(error(rounded) <= error(rounded.next_up()) && error(rounded) <= error(rounded.next_down()));
        }
    }

    #[test]
    fn numbers_are_written_like_doubles() {
        let read = |text: &str| parse(text).unwrap();
        for (text, digits, expected) in [
            ("0", 40, "0.0"),
            ("-0", 40, "-0.0"),
            ("1", 40, "1.0"),
            ("-10", 40, "-10.0"),
            ("123.45", 40, "123.45"),
            ("0.1", 40, "0.1"),
            ("1e15", 40, "1000000000000000.0"),
            ("1e16", 40, "1e16"),
            ("1.25e-5", 40, "0.0000125"),
            ("1.25e-6", 40, "1.25e-6"),
            ("-1.25e-300", 40, "-1.25e-300"),
            ("2e2000", 40, "2e2000"),
            ("1e-999999999", 40, "0.0"),
            ("1e999999999", 40, "inf"),
            // Numbers just below a power of ten, which the formatting of the f256 crate gets wrong.
            ("9.99999999999999999999999999999999999999997", 42, "9.99999999999999999999999999999999999999997"),
            ("9.99999999999999999999999999999999999999997", 41, "10.0"),
            ("0.00099999999999999999", 5, "0.001"),
            ("6.25", 2, "6.3"),
        ] {
            assert_eq!(written(read(text), digits), expected, "{text} in {digits} digits");
        }
        for bad in ["", "-", ".", "e5", "1e", "1e5.0", "0x10", "1_000", "nan", "inf", "--1", "1.2.3", " 1"] {
            assert!(parse(bad).is_none(), "{bad}");
        }
        assert_eq!(to_f64(Extended::MAX), f64::INFINITY);
        assert_eq!(to_f64(Extended::MIN_POSITIVE), 0.0);
    }
}
