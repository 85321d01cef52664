//! Lengths of windows to choose from: powers of √2, so that few tables serve a whole run.

use super::twofold::Twofold;

/// √2 to 32 digits.
const ROOT_2: Twofold = Twofold { hi: std::f64::consts::SQRT_2, lo: -9.667_293_313_452_913e-17 };

/// The rung 2^(k/2).
pub(super) fn length(rung: i32) -> Twofold {
    let power = 2.0_f64.powi(rung.div_euclid(2));
    if rung.rem_euclid(2) == 0 { Twofold::from(power) } else { ROOT_2 * power }
}

/// The highest rung at or below `length`.
pub(super) fn rung_below(length: f64) -> i32 {
    (2.0 * length.log2()).floor().clamp(-2000.0, 2000.0) as i32
}
