//! A set keeps each of its terms. Beside each test stands the part of the bound that its example reaches.
//!
//! The rounding of Σ |Fᵀg| over columns has no example: the search for its bound begins a thousandth above it.

use super::super::algebras::LANES;
use super::super::ellipse::Bounds;
use super::super::matrices::Matrices;
use super::super::tests::with_one_coordinate;
use super::*;
use crate::number::{Extended, Real};

/// In every direction what is left of the columns reaches as far as they did, and not much further where they lie
/// along few directions.
#[test]
fn a_smaller_set_contains_the_larger_one() {
    let d = 3;
    let directions = [[1.0, 0.3, -0.2], [-0.3, 1.0, 0.4], [1e-6, 1e-3, 1.0]];
    let mut seed = 1_u64;
    let mut unit = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let mut set = Set {
        start: vec![0.0; d],
        centre: vec![0.0; d],
        errors: Zonotope { columns: vec![Vec::new(); d], generators: 0, rest: vec![0.0; d] },
        differences: None,
        largest: vec![1.0; d],
        of_kind: vec![1.0; d],
    };
    for k in 0..MOST * d + 10 {
        let (size, own) = (1e-10 * unit(), directions[k % 3]);
        (0..d).for_each(|i| set.errors.columns[i].push(size * (own[i] + 0.01 * unit())));
    }
    let reach = |set: &Set, along: &[f64]| -> f64 {
        let column = |k: usize| (0..d).map(|i| along[i] * set.errors.columns[i][k]).sum::<f64>().abs();
        let rest = (0..d).map(|i| (along[i] * set.errors.rest[i]).abs()).sum::<f64>();
        (0..set.errors.columns[0].len()).map(column).sum::<f64>() + rest
    };
    let before = set.clone();
    set.errors.reduce().unwrap();
    assert_eq!(set.errors.columns[0].len(), MOST * d / 2 + d);
    let mut largest = 0.0_f64;
    for _ in 0..500 {
        let along = [unit(), unit(), unit()];
        let share = reach(&before, &along) / reach(&set, &along);
        assert!(share <= 1.0 + 1e-12, "{along:?}: {share}");
        largest = largest.max(share);
    }
    assert!(largest > 0.8, "{largest}");
}

/// Boxes are covered by boxes as rarely as the logarithm of the number of windows says: were they in turn, each would
/// become larger by a factor where the set turns between them, and that of 20 000 windows by 10¹³.
#[test]
fn a_set_that_turns_grows_no_faster_than_what_is_added() {
    let (mut set, mut proved) = quiet();
    let (sin, cos) = 1.0_f64.sin_cos();
    proved.matrices.a_end = vec![cos, sin, -sin, cos];
    proved.added.delta = vec![1e-20; 2];
    let windows = 20_000;
    with_one_coordinate(|equations| {
        for _ in 0..windows {
            set.advance(equations, &proved).unwrap();
        }
    });
    // A square is added, which turns: its width is 4/π of its edge in the mean.
    let least = f64::from(windows) * 1e-20 * 4.0 / std::f64::consts::PI;
    let radius = set.radii()[0];
    assert!(radius > 0.99 * least && radius < 2.0 * least, "{radius:e} {least:e}");
}

/// A set of x and p, and a window of length 1 in which nothing moves and nothing is off.
fn quiet() -> (Set, Proved) {
    let mut set = with_one_coordinate(|equations| Set::new(equations, equations.columns(&[]).unwrap()));
    [&mut set.start, &mut set.centre, &mut set.errors.rest].into_iter().for_each(|numbers| numbers.fill(0.0));
    let (one, zero) = (vec![1.0, 0.0, 0.0, 1.0], vec![0.0; 4]);
    let matrices = Matrices {
        d: 2,
        b: Vec::new(),
        slack: zero.clone(),
        b_most: one.clone(),
        e_most: zero.clone(),
        a_most: one.clone(),
        b_there: one.clone(),
        a_end: one,
        miss: zero,
    };
    let [defect, slope, jacobian, spread, reach, sides] = [(); 6].map(|()| Vec::new());
    let proved = Proved {
        h: 1.0,
        modes: vec![[0.0; LANES]; 2],
        gain: vec![0.0; 2],
        added: Added { delta: vec![0.0; 2], epsilon: vec![0.0; 2] },
        apart: None,
        defect: vec![0.0; 2],
        matrices,
        bounds: Bounds { defect, slope, jacobian, spread, reach, sides },
        quality: 0.0,
        sizes: vec![1.0; 2],
    };
    (set, proved)
}

fn advanced(set: &Set, proved: &Proved) -> Set {
    let mut next = set.clone();
    with_one_coordinate(|equations| next.advance(equations, proved)).unwrap();
    next
}

/// Asserts that a bound holds, and that at least this part of it is met.
#[track_caller]
fn is_met(value: f64, bound: f64, part: f64) {
    assert!(value <= bound && value >= part * bound, "{value:e} of {bound:e}: {}", value / bound);
}

/// The terms of what a window adds, δ, of the box before it, and of |I − A B| ε, one by one. Parts 0.999.
#[test]
fn what_a_window_adds_is_kept() {
    let (mut set, mut proved) = quiet();
    proved.added.delta[0] = 1e-3;
    is_met(1e-3, advanced(&set, &proved).radii()[0], 0.999);
    proved.added.delta[0] = 0.0;
    set.errors.rest[0] = 1e-3;
    is_met(1e-3, advanced(&set, &proved).radii()[0], 0.999);
    set.errors.rest[0] = 0.0;
    (proved.matrices.miss[0], proved.added.epsilon[0]) = (0.5, 1e-3);
    is_met(5e-4, advanced(&set, &proved).radii()[0], 0.999);
    (proved.matrices.miss[0], proved.gain[0]) = (0.0, 1e-3);
    assert_eq!(advanced(&set, &proved).start[0], 1e-3);
}

/// What of A times the middle (0), the columns (1) or what is new (2) is lost, where that alone is not 0, and the box
/// that is to hold it.
fn lost(case: usize, error: [f64; 2]) -> (f64, f64) {
    let exact = Extended::from;
    let (mut set, mut proved) = quiet();
    match case {
        0 => set.centre = error.to_vec(),
        1 => set.errors.columns = error.iter().map(|g| vec![*g]).collect(),
        _ => proved.added.delta = error.to_vec(),
    }
    let factor = 0.7;
    proved.matrices.a_end = vec![factor, -factor, 0.0, 1.0];
    let next = advanced(&set, &proved);
    // What is new is rounded up before it becomes columns.
    let terms = error.map(|error| exact(factor) * exact(if case == 2 { (error + 0.0) * UP } else { error }));
    let off = match case {
        0 => (terms[0] - terms[1] - exact(next.start[0]) - exact(next.centre[0])).abs(),
        1 => (terms[0] - terms[1] - exact(next.errors.columns[0][0])).abs(),
        _ => (terms[0] - exact(next.errors.columns[0][0])).abs() + (terms[1] + exact(next.errors.columns[0][1])).abs(),
    };
    (off.to_f64(), next.errors.rest[0])
}

/// The rounding of A times the middle, the columns and what is new: one or two roundings where some fifty are allowed
/// for. In the middle it is seen where terms cancel, as its own size is rounded, too. Parts 0.01.
#[test]
fn rounding_of_the_map_is_kept() {
    for case in 0..3 {
        let mut largest = 0.0_f64;
        for i in 1..100 {
            let error = [f64::from(i).sqrt(), f64::from(i).sqrt() + 1e-9];
            let (off, rest) = lost(case, error);
            assert!(off <= rest, "{case}: {off:e} {rest:e}");
            largest = largest.max(off / rest);
        }
        assert!(largest > 0.01, "{case}: {largest}");
    }
}

/// The rounding of the place: what the next start leaves is added with one rounding, for which two are allowed. Part
/// 0.02.
#[test]
fn rounding_of_the_place_is_kept() {
    let exact = Extended::from;
    let mut largest = 0.0_f64;
    for i in 1..100 {
        let (mut set, mut proved) = quiet();
        (set.start[0], proved.h) = (1.0, 0.7);
        proved.modes[0][0] = 1e-3 * f64::from(i).sqrt();
        let next = advanced(&set, &proved);
        let end = Extended::ONE + exact(0.7) * exact(proved.modes[0][0]);
        let off = (end - exact(next.start[0]) - exact(next.centre[0])).abs().to_f64();
        assert!(off <= next.errors.rest[0], "{off:e} {:e}", next.errors.rest[0]);
        largest = largest.max(off / next.errors.rest[0]);
    }
    assert!(largest > 0.02, "{largest}");
}

/// The term |N| t of a frame: it is not orthonormal, and g is its second vector. The search takes twice what is needed.
/// Part 0.45.
#[test]
fn a_frame_need_not_be_orthonormal() {
    let frame = [vec![1.0, 0.0], vec![1e-3, 1.0]];
    let reach = reach_in(&frame, &[vec![0.0, 1.0]]).unwrap();
    is_met(1e-3, reach[0], 0.45);
    is_met(1.0, reach[1], 0.99);
    // And where it is none at all nothing is found.
    assert_eq!(reach_in(&[vec![1.0, 0.0], vec![1.0, 1e-3]], &[vec![0.0, 1.0]]), None);
}

/// The rounding of dot products, by Fᵀg and by N together: g is at a right angle to one of the frame but for a
/// rounding. Each of both terms is six roundings of |g|, so that either of them alone would do. Part 0.01.
#[test]
fn rounding_of_a_frame_is_kept() {
    let frame = [vec![0.6, 0.8], vec![-0.8, 0.6]];
    let (exact, mut largest) = (Extended::from, 0.0_f64);
    for i in 1..200 {
        let t = f64::from(i).sqrt();
        let g = vec![0.8 * t, -0.6 * t];
        let reach = reach_in(&frame, std::slice::from_ref(&g)).unwrap();
        // Cramer's rule.
        let [a, b, c, d] = [0.6, -0.8, 0.8, 0.6].map(exact);
        let coordinate = (exact(g[0]) * d - exact(g[1]) * b) / (a * d - b * c);
        let off = coordinate.abs().to_f64();
        assert!(off <= reach[0], "{off:e} {:e}", reach[0]);
        largest = largest.max(off / reach[0]);
    }
    assert!(largest > 0.01, "{largest}");
}

/// The rounding of sums over columns, of which there may be more than the factor for all sums holds: a large one and
/// many that are lost beside it. Part 0.99.
#[test]
fn columns_that_are_lost_in_a_sum_are_kept() {
    let mut row = vec![2.0_f64.powi(-54); 800_000];
    row[0] = 1.0;
    let exact = 1.0 + 799_999.0 * 2.0_f64.powi(-54);
    is_met(exact, sum_of_sizes(&row), 0.99);
}

/// The rounding of columns of a frame times their lengths, which goes into the box. Part 0.02.
#[test]
fn rounding_of_new_columns_is_kept() {
    let (mut set, _) = quiet();
    let number = |k: usize, i: usize| ((7 * k + 13 * i) as f64).sin();
    set.errors.columns = (0..2).map(|i| (0..2 * MOST).map(|k| number(k, i)).collect()).collect();
    let before = set.clone();
    set.errors.reduce().unwrap();
    let scales: Vec<f64> = before.errors.columns.iter().map(|row| power_of_two(sum_of_sizes(row))).collect();
    let mut all: Vec<Vec<f64>> =
        (0..2 * MOST).map(|k| (0..2).map(|i| before.errors.columns[i][k] / scales[i]).collect()).collect();
    all.sort_by(|one, other| norm(one).total_cmp(&norm(other)));
    let smaller = &all[..MOST];
    let frame = frame(smaller, 2);
    let total = reach_in(&frame, smaller).unwrap();
    let exact = Extended::from;
    let off = |i: usize, k: usize| {
        (exact(frame[k][i]) * exact(total[k]) * exact(scales[i]) - exact(set.errors.columns[i][MOST + k]))
            .abs()
            .to_f64()
    };
    let share = |i: usize| (off(i, 0) + off(i, 1)) / set.errors.rest[i];
    assert!(share(0) <= 1.0 && share(1) <= 1.0 && share(0).max(share(1)) > 0.02, "{} {}", share(0), share(1));
}
