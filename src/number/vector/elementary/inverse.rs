//! Inverse circular functions.

use super::pair::{abs, fma, polynomial, signed, sum};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Up to here what the reciprocal lacks is a normal number.
pub(super) const MOST: f64 = 1e150;

/// The rounding errors of the numbers π/2 and π.
const FRAC_PI_2_LOW: f64 = 6.123_233_995_736_766e-17;
const PI_LOW: f64 = 1.224_646_799_147_353_2e-16;

/// (atan r − r)/r³ by z = r²; error 2.0e-17 of atan.
const ATAN: [f64; 11] = [
    -0.333_333_333_333_333_26,
    0.199_999_999_999_876_55,
    -0.142_857_142_831_276_62,
    0.111_111_108_990_496_64,
    -0.090_909_001_405_855_5,
    0.076_920_862_049_750_24,
    -0.066_632_248_690_844_83,
    0.058_476_124_445_213_65,
    -0.050_334_165_154_982_353,
    0.037_811_600_484_616_9,
    -0.017_532_295_994_972_764,
];
/// (asin s − s)/s³ by z = s²; error 5.4e-18 of asin.
const ASIN: [f64; 13] = [
    0.166_666_666_666_666_69,
    0.074_999_999_999_984_33,
    0.044_642_857_146_355_43,
    0.030_381_944_138_531_247,
    0.022_372_172_942_149_89,
    0.017_352_392_720_869_973,
    0.013_971_212_973_552_933,
    0.011_479_177_415_184_906,
    0.010_322_814_350_185_78,
    0.005_457_506_718_640_358,
    0.017_400_879_442_694_02,
    -0.014_851_887_071_247_204,
    0.028_757_851_367_421_566,
];

/// atan x = atan c + atan((x − c)/(1 + c x)) for c = 0, ½, 1, 3/2 or ∞, the numbers of fdlibm (Sun Microsystems 1993,
/// s_atan.c).
#[inline(always)]
pub(super) fn atan(x: f64) -> f64 {
    let t = abs(x);
    let (mut c, mut angle, mut low) = (0.0, 0.0, 0.0);
    if t >= 0.4375 {
        (c, angle, low) = (0.5, 0.463_647_609_000_806_1, 2.269_877_745_296_168_7e-17);
    }
    if t >= 0.6875 {
        (c, angle, low) = (1.0, FRAC_PI_4, 3.061_616_997_868_383e-17);
    }
    if t >= 1.1875 {
        (c, angle, low) = (1.5, 0.982_793_723_247_329, 1.390_331_103_123_099_8e-17);
    }
    let is_large = t >= 2.4375;
    if is_large {
        (angle, low) = (FRAC_PI_2, FRAC_PI_2_LOW);
    }
    let above = if is_large { -1.0 } else { t - c };
    let below = if is_large { t } else { fma(c, t, 1.0) };
    let r = above / below;
    let r_low = fma(-r, below, above) / below;
    let z = r * r;
    let (s, error) = sum((angle, r));
    signed(s + (error + fma(z * r, polynomial(&ATAN, z), low + r_low)), x.to_bits())
}

/// asin of t = |x| up to ½, beyond it asin of √½(1 − t), of which asin x and acos x are made: whether t is large, the
/// argument, and what asin adds to it.
#[inline(always)]
fn small_angle(t: f64) -> (bool, f64, f64) {
    let is_large = t > 0.5;
    let z = if is_large { fma(-0.5, t, 0.5) } else { t * t };
    let root = z.sqrt();
    let s = if is_large { root } else { t };
    // The rounding error of the root; 0 for 0.
    let lack = fma(-root, root, z) / (root + (root + f64::MIN_POSITIVE));
    let lack = if is_large { lack } else { 0.0 };
    (is_large, s, fma(z * s, polynomial(&ASIN, z), lack))
}

#[inline(always)]
pub(super) fn asin(x: f64) -> f64 {
    let (is_large, s, rest) = small_angle(abs(x));
    let (a, error) = sum((FRAC_PI_2, -2.0 * s));
    let large = a + (error + fma(-2.0, rest, FRAC_PI_2_LOW));
    signed(if is_large { large } else { s + rest }, x.to_bits())
}

#[inline(always)]
pub(super) fn acos(x: f64) -> f64 {
    let (is_large, s, rest) = small_angle(abs(x));
    let negative = x < 0.0;
    // c ± (s + rest) or c ± 2 (s + rest)
    let (c, low) = if !is_large {
        (FRAC_PI_2, FRAC_PI_2_LOW)
    } else if negative {
        (PI, PI_LOW)
    } else {
        (0.0, 0.0)
    };
    let factor = if is_large { 2.0 } else { 1.0 };
    let factor = if is_large ^ negative { factor } else { -factor };
    let (a, error) = sum((c, factor * s));
    a + (error + fma(factor, rest, low))
}
