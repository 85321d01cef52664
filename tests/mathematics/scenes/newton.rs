//! Reference trajectories of Newtonian motion, in closed orbits and published numbers, and of light in media.

use std::f64::consts::{PI, TAU};

use geodesic_ivp::geometry::Geometry;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::reference::ReferenceTrajectory;

use crate::common::{
    assert_near, geometry, newtonian, newtonian_start, numbers, of_potential, preset_with, reference, start,
};

#[test]
fn kepler_s_ellipse_closes() {
    let geometry: Geometry = of_potential(&newtonian(&["x", "y"], "-1/sqrt(x^2 + y^2)"));
    // Eccentricity 0.9, from the point nearest to the centre.
    let start = newtonian_start(&geometry, &[0.1, 0.0], &[0.0, 19.0_f64.sqrt()]);
    let reference = reference(&geometry, &start, TAU);
    let end = reference.at(TAU);
    assert_near(start.p[0] / start.p[3], -0.5, 1e-14, "energy");
    assert_near(start.q[1] * -start.p[2], 0.19_f64.sqrt(), 1e-15, "angular momentum");
    assert_near(end.q[1] * -end.p[2] + end.q[2] * end.p[1], 0.19_f64.sqrt(), 1e-13, "angular momentum");
    for (got, want) in end.q[..3].iter().zip([TAU, 0.1, 0.0]) {
        // A phase error is 4.4 times as large in y.
        assert_near(*got, want, 1e-12, "q");
    }
    let half = reference.at(PI);
    assert_near(half.q[1], -1.9, 1e-12, "farthest");
    assert_near(geometry.norm(&half.q, &half.q_dot), 0.0, 1e-13, "K");
}

#[test]
fn henon_and_heiles() {
    let text = newtonian(&["x", "y"], "(x^2 + y^2)/2 + x^2*y - y^3/3");
    let want = ["-0.040194237876068815", "0.67901692177202166", "0.038450928951859836", "0.048594831553003641"];
    let geometry: Geometry = of_potential(&text);
    let start = newtonian_start(&geometry, &[0.1, 0.0], &[0.0, 0.5]);
    let reference = reference(&geometry, &start, 100.0);
    let end = reference.at(100.0);
    for (got, want) in [end.q[1], end.q[2], -end.p[1], -end.p[2]].iter().zip(numbers::<f64>(&want)) {
        assert_near(*got, want, 2e-13, "x, y, p_x, p_y");
    }
    assert_near(end.q[0], 100.0, 1e-15, "t");
    let geometry: Geometry<Extended> = of_potential(&text);
    let start = newtonian_start(&geometry, &numbers(&["0.1", "0"]), &numbers(&["0", "0.5"]));
    let end = ReferenceTrajectory::new(&geometry, &start, 100.0.into(), 24).unwrap().at(100.0.into());
    for (got, want) in [end.q[1], end.q[2], -end.p[1], -end.p[2]].iter().zip(numbers::<Extended>(&want)) {
        let error = (*got - want).to_f64().abs();
        // The last one of the 17 digits of y is off by two.
        assert!(error < 2e-17, "{} against {want:?}: {error:e}", got.to_decimal(22));
    }
}

#[test]
fn three_bodies_on_an_eight() {
    // A. Chenciner and R. Montgomery, Ann. of Math. 152 (2000) 881.
    let distance = |a: usize, b: usize| format!("1/sqrt((x{a} - x{b})^2 + (y{a} - y{b})^2)");
    let expression = format!("-{} - {} - {}", distance(1, 2), distance(1, 3), distance(2, 3));
    let geometry: Geometry = of_potential(&newtonian(&["x1", "y1", "x2", "y2", "x3", "y3"], &expression));
    let [x, y] = [0.970_004_356_647_124_7, -0.243_087_530_467_588_27];
    let [u, v] = [-0.932_407_370_694_326_2, -0.864_731_462_019_137_1];
    let (q, q_dot) = ([x, y, -x, -y, 0.0, 0.0], [-u / 2.0, -v / 2.0, -u / 2.0, -v / 2.0, u, v]);
    let start = newtonian_start(&geometry, &q, &q_dot);
    let period = 6.325_913_98;
    let reference = reference(&geometry, &start, period);
    let end = reference.at(period);
    // The initial data are known to eight or nine digits only.
    for (got, want) in end.q[1..7].iter().zip(q) {
        assert_near(*got, want, 1e-7, "q");
    }
    for direction in 0..2 {
        let total: f64 = (0..3).map(|body| end.p[1 + 2 * body + direction]).sum();
        assert_near(total, 0.0, 1e-14, "total momentum");
    }
    assert!(reference.error_estimate() < 1e-12, "{}", reference.error_estimate());
}

#[test]
fn maxwell_s_fish_eye() {
    let geometry: Geometry = geometry(&preset_with("optics", "n", "2/(1 + x^2 + y^2)"));
    for (x, y, angle) in [(0.3, -0.2, 0.7_f64), (1.5, 0.4, 2.0), (-0.1, 0.05, 4.0)] {
        let n = 2.0 / (1.0 + x * x + y * y);
        let start = start(&geometry, &[x, y], &[angle.cos() / n, angle.sin() / n]);
        let reference = reference(&geometry, &start, TAU);
        let (half, end) = (reference.at(PI), reference.at(TAU));
        let square = x * x + y * y;
        for (a, q) in [x, y].into_iter().enumerate() {
            assert_near(half.q[a], -q / square, 2e-13, "the image");
            assert_near(end.q[a], q, 1e-12, "the start again");
        }
    }
}

#[test]
fn a_field_that_is_perpendicular_to_the_plane() {
    // A = B (−y, x)/2 turns a charge about B, without a force in the potential.
    let mut text = newtonian(&["x", "y"], "0");
    text.one_form = vec![(0, "-1.5*y/2".to_owned()), (1, "1.5*x/2".to_owned())];
    let geometry: Geometry = of_potential(&text);
    let start = newtonian_start(&geometry, &[0.3, -0.2], &[0.7, 0.4]);
    let reference = reference(&geometry, &start, 10.0);
    let end = reference.at(10.0);
    // v turns by −Bt.
    let (sin, cos) = 15.0_f64.sin_cos();
    assert_near(end.q_dot[1], 0.7 * cos + 0.4 * sin, 1e-13, "v_x");
    assert_near(end.q_dot[2], 0.4 * cos - 0.7 * sin, 1e-13, "v_y");
}

#[test]
fn an_exponential_by_friction() {
    // m ẍ = −ẋ + 1 from rest: x = t − 1 + e^−t.
    let mut text = newtonian(&["x"], "-x");
    text.force = vec![(0, "-x_dot".to_owned())];
    let geometry: Geometry = of_potential(&text);
    let start = newtonian_start(&geometry, &[0.0], &[0.0]);
    let end = reference(&geometry, &start, 5.0).at(5.0);
    assert_near(end.q[1], 4.0 + (-5.0_f64).exp(), 1e-14, "x");
    assert_near(geometry.norm(&end.q, &end.q_dot), 0.0, 1e-13, "K");
}

#[test]
fn the_rate_of_t_and_a_conformal_factor_leave_the_path() {
    // ẍ = −x³ − v |v|/5 + ½, with t at the start at any rate.
    let mut text = newtonian(&["x"], "x^4/4");
    text.force = vec![(0, "1/2 - x_dot*abs(x_dot)/5".to_owned())];
    let plain: Geometry = of_potential(&text);
    let begin = newtonian_start(&plain, &[1.0], &[0.3]);
    let path = reference(&plain, &begin, 6.0);
    text.conformal = Some("1/(1 + x^2)".to_owned());
    let other: Geometry = of_potential(&text);
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
