//! Each term of the radii at the end by itself: a motion whose errors are these alone. Beside each test stands the part
//! of the radius that its example reaches.

use super::super::tests::with_one_coordinate;
use super::*;

/// The end of the last window, at which x and t are 0, as far as they are known there.
struct Last {
    set: Set,
    slopes: [Disc; 2],
    bends: [f64; 2],
}

fn disc(re: f64, rad: f64) -> Disc {
    Disc { re, im: 0.0, rad }
}

impl Last {
    /// Slopes are 1, and nothing is off.
    fn new() -> Self {
        let mut set = with_one_coordinate(|equations| Set::new(equations, equations.columns(&[]).unwrap()));
        [&mut set.start, &mut set.centre, &mut set.errors.rest].into_iter().for_each(|numbers| numbers.fill(0.0));
        Self { set, slopes: [disc(1.0, 0.0); 2], bends: [0.0; 2] }
    }

    /// With errors of x and t that are these times one number between −1 and 1.
    fn with_column(mut self, of_x: f64, of_t: f64) -> Self {
        self.set.errors.columns = vec![vec![of_x], vec![of_t]];
        self
    }

    /// x at the end of the motion and γ there, with their radii.
    fn end(&self, goal: &Goal) -> [(f64, f64); 2] {
        let Self { set, slopes, bends } = self;
        let back = Back::new(set, goal, (Extended::ONE, 1.0), slopes, bends).unwrap();
        [back.unknown(set, 0, slopes, bends), back.gamma(set, Extended::ONE, slopes, bends)]
            .map(|(value, radius)| (value.to_f64(), radius))
    }
}

/// The end is a way before that of the window.
fn before(way: f64) -> Goal {
    Goal::Length(Extended::from(1.0 - way), 0.0)
}

/// t is to be −way.
fn at_value(way: f64) -> Goal {
    Goal::Value { unknown: 1, value: Extended::from(-way), sign: 1.0, about: 1.0 }
}

/// Asserts that a number is off by no more than its radius, and by at least this part of it.
#[track_caller]
fn is_met(value: f64, (middle, radius): (f64, f64), part: f64) {
    let off = (value - middle).abs();
    assert!(off <= radius && off >= part * radius, "{off:e} of {radius:e}: {}", off / radius);
}

/// The term of curvature: x = γ²/2 around the end of the window, a quarter before it. Part 0.999.
#[test]
fn to_a_length_a_motion_is_curved() {
    let mut last = Last::new();
    (last.slopes[0], last.bends[0]) = (disc(0.0, 0.0), 1.0);
    is_met(0.5 * 0.0625, last.end(&before(0.25))[0], 0.999);
}

/// The term of slopes: f is off by all of its radius. Part 0.999.
#[test]
fn to_a_length_slopes_are_off() {
    let mut last = Last::new();
    last.slopes[0] = disc(1.0, 0.1);
    is_met(-0.25 * 1.1, last.end(&before(0.25))[0], 0.99);
}

/// The terms of the set, and of the length itself, which is off by 1e-60 of it. Parts 0.999.
#[test]
fn to_a_length_errors_stay_and_the_length_is_off() {
    let mut last = Last::new().with_column(0.1, 0.0);
    last.set.errors.rest[0] = 0.1;
    is_met(0.2 - 0.25, last.end(&before(0.25))[0], 0.999);
    let [(_, of_x), (_, of_gamma)] = Last::new().end(&before(0.0));
    assert!(of_x >= OFF && of_gamma >= OFF && of_x < 1.001 * OFF + 1e-299, "{of_x:e} {of_gamma:e}");
}

/// The terms of curvature of x and of t: x = γ + γ²/20 and t = γ − γ²/20 from the end of the window, to t = −1/4. The
/// bound of the way is twice what it is, squared here, so that a quarter is reached. Parts 0.2.
#[test]
fn to_a_value_both_motions_are_curved() {
    // γ − γ²/20 = −1/4.
    let gamma = 10.0 - (100.0 + 5.0_f64).sqrt();
    let mut last = Last::new();
    last.bends[1] = 0.1;
    let [x, g] = last.end(&at_value(0.25));
    is_met(gamma, x, 0.2);
    is_met(1.0 + gamma, g, 0.2);
    last.bends = [0.1; 2];
    is_met(gamma + 0.05 * gamma * gamma, last.end(&at_value(0.25))[0], 0.2);
    last.bends = [0.1, 0.0];
    is_met(-0.25 + 0.05 * 0.0625, last.end(&at_value(0.25))[0], 0.2);
}

/// The terms of slopes: ẋ, or ṫ, is off by all of its radius. Parts 0.9.
#[test]
fn to_a_value_slopes_are_off() {
    let mut last = Last::new();
    last.slopes[0] = disc(1.0, 0.1);
    is_met(-0.25 * 1.1, last.end(&at_value(0.25))[0], 0.99);
    last.slopes = [disc(1.0, 0.0), disc(1.0, 0.1)];
    let [x, gamma] = last.end(&at_value(0.25));
    is_met(-0.25 / 0.9, x, 0.9);
    is_met(1.0 - 0.25 / 0.9, gamma, 0.9);
}

/// The terms of the set: errors of x and t of one origin, which cancel where they are along the motion, and add where
/// not; and the box, where none cancel. Parts 0.99.
#[test]
fn to_a_value_errors_of_one_origin_are_kept_together() {
    let way = 0.25;
    is_met(-way + 0.02, Last::new().with_column(0.01, -0.01).end(&at_value(way))[0], 0.99);
    let (_, radius) = Last::new().with_column(0.01, 0.01).end(&at_value(way))[0];
    assert!(radius < 1e-15, "{radius}");
    let mut last = Last::new();
    last.set.errors.rest = vec![0.01, 0.02];
    let [x, gamma] = last.end(&at_value(way));
    is_met(-way + 0.03, x, 0.99);
    is_met(1.0 - way + 0.02, gamma, 0.99);
}

/// The radius of ṫ with an error of t: the way back is as much longer as t is further on, of columns and of the box.
/// Parts 0.9.
#[test]
fn to_a_value_an_error_of_time_is_multiplied_by_the_error_of_the_slope() {
    let mut last = Last::new().with_column(0.0, 0.1);
    last.slopes[1] = disc(1.0, 0.1);
    let mut other = Last::new();
    (other.slopes, other.set.errors.rest) = (last.slopes, vec![0.0, 0.1]);
    for last in [last, other] {
        let [x, gamma] = last.end(&at_value(0.25));
        is_met(-0.35 / 0.9, x, 0.9);
        is_met(1.0 - 0.35 / 0.9, gamma, 0.9);
    }
}

/// A coordinate that moves at a constant velocity is off by its decimals and by γ. Parts 0.99.
#[test]
fn what_is_steady_is_off_by_its_decimals_and_the_length() {
    let exact = Extended::from;
    let (value, radius) = moved(exact(2.0), exact(-3.0), (exact(4.0), 0.0));
    assert!(value == exact(-10.0) && (14.0 * OFF..14.1 * OFF).contains(&radius), "{radius:e}");
    let (_, radius) = moved(exact(2.0), exact(-3.0), (exact(4.0), 0.1));
    assert!((0.3..0.300_001).contains(&radius), "{radius}");
}

/// |ẍ| ≤ |J| |f|: x′ has the slope of x by p, and p′ that of p by x. Parts 0.999.
#[test]
fn a_motion_bends_by_its_jacobian_and_slopes() {
    let [defect, spread, reach, sides] = [(); 4].map(|()| Vec::new());
    let bounds = Bounds { defect, slope: vec![3.0, 5.0], jacobian: vec![0.5, 2.0], spread, reach, sides };
    let found = with_one_coordinate(|equations| growths(equations, &bounds, &bounds.slope));
    assert!((2.5..2.501).contains(&found[0]) && (6.0..6.001).contains(&found[1]), "{found:?}");
}

/// The rounding of columns: that of x is the rounded product of φ and that of t. It is two roundings of each. Part 0.2.
#[test]
fn to_a_value_columns_are_rounded() {
    let mut largest = 0.0_f64;
    for i in 1..100 {
        let of_t = 1e-3 * f64::from(i);
        let mut last = Last::new();
        last.slopes[0] = disc(1.0 / 3.0, 0.0);
        // Rounding of φ counts with the way back, which is the same without columns.
        let without = last.end(&at_value(0.3))[0].1;
        let phi = (last.slopes[0] / last.slopes[1]).re;
        last = last.with_column(phi * of_t, of_t);
        let with = last.end(&at_value(0.3 - of_t))[0].1;
        let exact = Extended::from(phi) * Extended::from(of_t) - Extended::from(phi * of_t);
        let share = exact.abs().to_f64() / (with - without);
        assert!((0.0..=1.0).contains(&share), "{i}: {share}");
        largest = largest.max(share);
    }
    assert!(largest > 0.2, "{largest}");
}

/// The value at the end is a decimal, off by 1e-60 of it; with a rate of 1/2 x and γ are off by twice that. Part 0.999.
#[test]
fn to_a_value_the_value_is_off() {
    let mut last = Last::new();
    // It is passed by more than that.
    (last.set.start[1], last.set.centre[1]) = (1.0, 1e-50);
    last.slopes[1] = disc(0.5, 0.0);
    let goal = Goal::Value { unknown: 1, value: Extended::ONE, sign: 1.0, about: 1.0 };
    for (_, radius) in last.end(&goal) {
        assert!(radius >= 2.0 * OFF, "{radius:e}");
    }
    let back = Back::new(&last.set, &goal, (Extended::ONE, 1.0), &last.slopes, &last.bends).unwrap();
    assert_eq!(back.unknown(&last.set, 1, &last.slopes, &last.bends).1, OFF);
}

/// A value is passed once: t is beyond it with all of its errors, the way back is no longer than the window, and ṫ
/// keeps half of itself on it.
#[test]
fn a_value_that_may_not_be_passed_is_none() {
    let back = |last: &Last, way: f64| {
        Back::new(&last.set, &at_value(way), (Extended::ONE, 1.0), &last.slopes, &last.bends).map(|_| ())
    };
    let with = |of_t: f64, bend: f64| Last { bends: [0.0, bend], ..Last::new().with_column(0.0, of_t) };
    assert_eq!(back(&with(0.1, 0.0), 0.11), Some(()));
    assert_eq!(back(&with(0.1, 0.0), 0.09), None);
    // The way is at most 2 (0.3 + 0.1).
    assert_eq!(back(&with(0.1, 0.6), 0.3), Some(()));
    assert_eq!(back(&with(0.1, 0.7), 0.3), None);
    assert_eq!(back(&with(0.1, 0.0), 0.39), Some(()));
    assert_eq!(back(&with(0.1, 0.0), 0.41), None);
    // And at most 2 (0.3 + 0.1)/0.75 where ṫ may be 3/4.
    let slow = |rad: f64| Last { slopes: [disc(1.0, 0.0), disc(1.0, rad)], ..with(0.1, 0.0) };
    assert_eq!([back(&slow(0.15), 0.3), back(&slow(0.25), 0.3)], [Some(()), None]);
}
