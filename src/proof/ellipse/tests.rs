//! Each term of the discs of a motion by itself. Beside each test stands the part of the bound that its example
//! reaches.
//!
//! The rounding of Σ c_k ∫P_k in the radius of a place has no example: next to it stands the way from the middle of a
//! disc to its edge, a twentieth of the same sum where |v| is not small, and a thousandth where it is. That is 1e10
//! times as large in every window.

use super::*;
use crate::number::{Extended, Real};

/// Coefficients of P_k.
fn modes(first: &[f64]) -> Row {
    std::array::from_fn(|k| first.get(k).copied().unwrap_or(0.0))
}

/// The place on the ellipse at an angle, and the middle of the disc next to its top.
fn on_ellipse(angle: f64) -> [f64; 2] {
    [5.0 / 3.0 * angle.cos(), 4.0 / 3.0 * angle.sin()]
}

const TOP: usize = LANES / 2;
const STEP: f64 = std::f64::consts::PI / LANES as f64;

fn middle() -> [f64; 2] {
    on_ellipse((TOP as f64 + 0.5) * STEP)
}

/// Places along the part of the ellipse that the disc next to the top covers.
fn along() -> impl Iterator<Item = [f64; 2]> {
    (0..=100).map(|i| on_ellipse((TOP as f64 + f64::from(i) / 100.0) * STEP))
}

/// Asserts that a bound holds, and that at least this part of it is met.
#[track_caller]
fn is_met(value: f64, bound: f64, part: f64) {
    assert!(value <= bound && value >= part * bound, "{value:e} of {bound:e}: {}", value / bound);
}

/// The term |v(z)| in the radius of a place: v = 1. Part 0.99.
#[test]
fn a_disc_covers_its_part_of_the_ellipse() {
    let modes = modes(&[1.0]);
    let found = place(0.0, 2.0, &modes, &slope_there(&modes));
    let far = along().map(|z| (z[0] + 1.0 - found.re[TOP]).hypot(z[1] - found.im[TOP])).fold(0.0, f64::max);
    is_met(far, found.rad[TOP], 0.99);
}

/// The term |v′| in the radius of a place: v = |x − z|² is 0 in the middle of the disc, so that the motion leaves it by
/// v′ alone. v′ is bounded by its value where the ellipse meets the real axis. Part 0.7.
#[test]
fn a_disc_covers_a_motion_that_turns_in_its_middle() {
    let [re, im] = middle();
    let square = re * re + im * im;
    // x² = (2 P_2 + P_0)/3.
    let modes = modes(&[1.0 / 3.0 + square, -2.0 * re, 2.0 / 3.0]);
    let slope = slope_there(&modes);
    assert!(slope.size(TOP) < 1e-13);
    let found = place(0.0, 2.0, &modes, &slope);
    // ∫ (x² − 2 re x + |z|²) from −1.
    let integral = |[x, y]: [f64; 2]| {
        let [square_x, square_y] = [x * x - y * y, 2.0 * x * y];
        let [cube_x, cube_y] = [square_x * x - square_y * y, square_x * y + square_y * x];
        let real = (cube_x + 1.0) / 3.0 - re * (square_x - 1.0) + square * (x + 1.0);
        [real, cube_y / 3.0 - re * square_y + square * y]
    };
    let far = along().map(integral).map(|[x, y]| (x - found.re[TOP]).hypot(y - found.im[TOP])).fold(0.0, f64::max);
    is_met(far, found.rad[TOP], 0.7);
}

/// The rounding of y = start + way: a way that is lost beside the start. It is four roundings of the start and of the
/// place, and here is a quarter of one. Part 0.01.
#[test]
fn a_disc_holds_the_rounding_of_its_middle() {
    let modes = modes(&[3e-17]);
    let found = place(1.0, 2.0, &modes, &slope_there(&modes));
    let way = 3e-17 * (1.0 + middle()[0]);
    assert_eq!(found.re[TOP], 1.0);
    let far = along().map(|z| (3e-17 * (1.0 + z[0])).hypot(3e-17 * z[1] - found.im[TOP])).fold(0.0, f64::max);
    assert!(way <= far);
    is_met(far, found.rad[TOP], 0.01);
}

/// The term |v′| in the bound of v − f: v = x, and f is what v is in the middle of each disc. Part 0.98.
#[test]
fn a_defect_changes_within_a_disc() {
    let modes = modes(&[0.0, 1.0]);
    let slope = slope_there(&modes);
    let found = Discs { re: slope.there[0], im: slope.there[1], rad: [0.0; LANES] };
    let far = along().map(|z| (z[0] - middle()[0]).hypot(z[1] - middle()[1])).fold(0.0, f64::max);
    is_met(far, defect(&slope, &found), 0.98);
}

/// The radius of f in the bound of v − f. Part 0.999.
#[test]
fn a_defect_has_the_radius_of_the_slope() {
    let found = Discs { re: [0.0; LANES], im: [0.0; LANES], rad: [0.1; LANES] };
    is_met(0.1, defect(&slope_there(&modes(&[])), &found), 0.999);
}

/// The rounding of v in the bound of v − f, and in |v(z)|: a second coefficient that is lost beside the first. 32 terms
/// are rounded here, and one has any rounding. Part 0.005.
#[test]
fn a_defect_holds_the_rounding_of_the_slope() {
    let modes = modes(&[1.0, -3e-17]);
    let slope = slope_there(&modes);
    let found = Discs { re: slope.there[0], im: slope.there[1], rad: [0.0; LANES] };
    let largest = (0..LANES).fold(0.0_f64, |most, i| {
        let exact = Extended::ONE - Extended::from(3e-17) * Extended::from(TABLES.legendre_there[0][1][i]);
        most.max((exact - Extended::from(slope.there[0][i])).abs().to_f64())
    });
    is_met(largest, defect(&slope, &found), 0.002);
}
