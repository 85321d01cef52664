//! Reference trajectories against closed forms and published numbers that no shipped scene has.

use std::f64::consts::{PI, TAU};

use geodesic_ivp::geometry::Geometry;
use geodesic_ivp::reference::ReferenceTrajectory;

use crate::common::{assert_near, geometry, newtonian, newtonian_start, preset, reference, start, start_with_momenta};

#[test]
fn the_rate_of_t_and_a_conformal_factor_leave_the_path() {
    // ẍ = −x³ − v |v|/5 + ½, with t at the start at any rate.
    let mut text = newtonian(&["x"], "x^4/4");
    text.force = vec![(0, "1/2 - x_dot*abs(x_dot)/5".to_owned())];
    let plain: Geometry = geometry(&text);
    let begin = newtonian_start(&plain, &[1.0], &[0.3]);
    let path = reference(&plain, &begin, 6.0);
    text.conformal = Some("1/(1 + x^2)".to_owned());
    let other: Geometry = geometry(&text);
    let q = [0.0, 1.0, 0.0];
    let q_dot = [2.0, 0.6, 2.0 * begin.q_dot[2]];
    let begin = start(&other, &q, &q_dot);
    assert_near(other.norm(&q, &q_dot), 0.0, 1e-15, "K");
    let length = ReferenceTrajectory::length_of(&other, &begin, 0, 6.0, 16).unwrap();
    let conformal = reference(&other, &begin, length);
    for i in 1..=12 {
        let point = conformal.at(length * f64::from(i) / 12.0);
        let same = path.at(point.q[0]);
        assert_near(point.q[1], same.q[1], 1e-12, "x");
        assert_near(point.q_dot[1] / point.q_dot[0], same.q_dot[1], 1e-12, "v");
    }
}

#[test]
fn a_bound_orbit() {
    let geometry = geometry(&preset("schwarzschild", &[]));
    // Semi-latus rectum 10, eccentricity 1/2, from the point nearest to the mass.
    let (e, l) = (0.966_091_783_079_295_9, 3.849_001_794_597_505);
    let start = start_with_momenta(&geometry, &[0.0, 20.0 / 3.0, 0.0], &[e, 0.0, -l]);
    let reference = reference(&geometry, &start, 2000.0);
    // p_r changes its sign at the turning points; it is zero at the start, which does not count.
    let turns = reference.sign_changes(|point| point.p[1]);
    assert_near(reference.at(turns[1]).q[2], 10.055_168_010_175_32, 1e-12, "apsidal angle");
    assert_near(reference.at(turns[0]).q[1], 20.0, 1e-11, "largest r");
}

#[test]
fn periodic_orbits_close() {
    for (a, l, e, [nearest, farthest], closure, periods) in [
        (
            "0.9",
            2.4,
            0.909_460_889_740_790_3,
            [2.437_526_170_841_969, 7.561_235_180_449_384],
            278.377_511_979_950_67,
            3,
        ),
        ("0", 3.9, 0.962_903_137_831_754_2, [8.190_088_655_617_379, 16.109_519_222_938_99], 659.879_719_660_320_6, 2),
    ] {
        let geometry = geometry(&preset("kerr-equatorial", &[("a", a)]));
        let start = start_with_momenta(&geometry, &[0.0, nearest, 0.0], &[e, 0.0, -l]);
        let reference = reference(&geometry, &start, closure + 1.0);
        let end = reference.at(closure);
        assert_near(end.q[1], nearest, 1e-10, "r");
        let revolutions = end.q[2] / TAU;
        assert_near(revolutions, revolutions.round(), 1e-10, "revolutions");
        assert_near(end.p[1], 0.0, 1e-10, "p_r");
        let apsides = reference.sign_changes(|point| point.p[1]);
        assert_eq!(apsides.iter().filter(|gamma| **gamma < closure + 0.5).count(), 2 * periods, "{apsides:?}");
        assert_near(reference.at(apsides[0]).q[1], farthest, 1e-11, "largest r");
    }
}

#[test]
fn innermost_stable_circular_orbits() {
    for (a, r) in [("0", 6.0_f64), ("0.9", 2.320_883_041_761_887), ("-0.9", 8.717_352_279_606_489)] {
        let spin: f64 = a.parse().unwrap();
        let geometry = geometry(&preset("kerr-equatorial", &[("a", a)]));
        // J. M. Bardeen, W. H. Press and S. A. Teukolsky, Astrophys. J. 178 (1972) 347, eqs. 2.12 and 2.13.
        let root = (1.0 - 3.0 / r + 2.0 * spin / r.powf(1.5)).sqrt();
        let e = (1.0 - 2.0 / r + spin / r.powf(1.5)) / root;
        let l = r.sqrt() * (1.0 - 2.0 * spin / r.powf(1.5) + spin * spin / (r * r)) / root;
        if a == "0" {
            assert_near(e, (8.0_f64 / 9.0).sqrt(), 1e-15, "E");
            assert_near(l, 12.0_f64.sqrt(), 1e-15, "L");
        }
        let (mut point, q, p) = (geometry.point(), [0.0, r, 0.0], [e, 0.0, -l]);
        point.evaluate(&q, &p).unwrap();
        assert_near(point.p_dot(0), 0.0, 1e-15, "dp_r/dtau");
        // It is the one where the force has no slope either.
        let mut slope = 0.0;
        let mut see = |row, column, value: f64| {
            if (row, column) == (1, 0) {
                slope = value;
            }
        };
        point.jacobian(&q, &p, &mut see);
        assert_near(slope, 0.0, 1e-14, "its slope");
        let reference = reference(&geometry, &start_with_momenta(&geometry, &q, &p), 100.0);
        assert_near(reference.at(100.0).q[1], r, 1e-8, "r");
    }
}

#[test]
fn light_is_deflected() {
    let geometry = geometry(&preset("schwarzschild", &[]));
    // Closest at r = 6: b = r/√f.
    let b = 6.0 / (2.0_f64 / 3.0).sqrt();
    let start = start_with_momenta(&geometry, &[0.0, 6.0, 0.0], &[1.0, 0.0, -b]);
    assert_near(geometry.norm(&start.q, &start.q_dot), 0.0, 1e-15, "K");
    let gamma = ReferenceTrajectory::length_of(&geometry, &start, 1, 1e4, 16).unwrap();
    let end = reference(&geometry, &start, gamma).at(gamma);
    assert_near(end.q[1], 1e4, 1e-13, "r");
    // From there to infinity: ∫ du/√(1/b² − u² (1 − 2u)), u = 1/r, as a series.
    let u = 1.0 / end.q[1];
    let rest = b * u + b.powi(3) * (u.powi(3) / 6.0 - u.powi(4) / 4.0);
    assert_near(2.0 * (end.q[2] + rest) - PI, 1.014_875_432_217_572, 1e-12, "deflection");
    // The critical impact parameter is that of the circle r = 3.
    let circle = start_with_momenta(&geometry, &[0.0, 3.0, 0.0], &[1.0, 0.0, -27.0_f64.sqrt()]);
    assert_near(geometry.norm(&circle.q, &circle.q_dot), 0.0, 1e-15, "K");
    assert_near(reference(&geometry, &circle, 10.0).at(10.0).q[1], 3.0, 1e-12, "r");
}
