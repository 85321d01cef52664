//! Hamilton's equations, their Jacobian, momenta and norms against their definitions.

use geodesic_ivp::geometry::{Geometry, GeometryText};
use nalgebra::{DMatrix, DVector};
use num_dual::Dual64;
use proptest::prelude::*;

use super::formulas::{Everything, Lifted, Null, OneCoordinate, Plane, Scene};
use crate::common::{assert_near, geometry, metric};

/// dq/dγ of all coordinates and dp/dγ of the active ones.
fn rates(geometry: &Geometry, q: &[f64], p: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let mut point = geometry.point();
    point.evaluate(q, p).unwrap();
    let q_dot = (0..q.len()).map(|a| point.q_dot(a)).collect();
    (q_dot, (0..geometry.active().len()).map(|place| point.p_dot(place)).collect())
}

fn check_definitions<G: Scene>(point: &[f64]) {
    let geometry = G::geometry();
    let n = geometry.dimension();
    assert_eq!(geometry.active(), G::ACTIVE);
    let (q, p) = (&point[..n], &point[4..4 + n]);
    let matrix = DMatrix::from_fn(n, n, |a, b| G::metric(q)[a][b]);
    let kinetic = DVector::from_fn(n, |a, _| p[a] - G::one_form(q)[a]);
    let expected = matrix.clone().try_inverse().unwrap() * kinetic;
    let (q_dot, p_dot) = rates(&geometry, q, p);
    let size = q_dot.iter().fold(1.0, |size: f64, u| size.max(u.abs()));
    for a in 0..n {
        assert_near(q_dot[a] / size, expected[a] / size, 1e-13, "dq/dgamma");
    }
    let constant = |values: &[f64]| values.iter().map(|&value| Dual64::from(value)).collect::<Vec<_>>();
    for (place, &a) in G::ACTIVE.iter().enumerate() {
        let mut shifted = constant(q);
        shifted[a].eps = 1.0;
        let force = G::lagrangian(&shifted, &constant(&q_dot)).eps + G::force(q, &q_dot)[a];
        assert_near(p_dot[place], force, 1e-12 * size.powi(3), "dp/dgamma");
    }
    for (got, want) in geometry.momenta(q, &q_dot).iter().zip(p) {
        assert_near(*got, *want, 1e-13 * size, "p");
    }
    let velocity = DVector::from_column_slice(&q_dot);
    let k = (velocity.transpose() * matrix * &velocity)[(0, 0)];
    assert_near(geometry.norm(q, &q_dot), k, 1e-13 * size * size, "K");
}

fn check_jacobian<G: Scene>(point: &[f64]) {
    let geometry = G::geometry();
    let (n, m) = (geometry.dimension(), G::ACTIVE.len());
    let (q, p) = (&point[..n], &point[4..4 + n]);
    let mut jacobian = DMatrix::zeros(2 * m, 2 * m);
    geometry.point().jacobian(q, p, |row, column, value| {
        jacobian[(row, column)] += value;
    });
    let size = 1.0 + rates(&geometry, q, p).0.iter().fold(0.0, |size: f64, u| size.max(u.abs()));
    for column in 0..2 * m {
        let shifted = |step: f64| {
            let (mut q, mut p) = (q.to_vec(), p.to_vec());
            let a = G::ACTIVE[column % m];
            if column < m {
                q[a] += step
            } else {
                p[a] += step
            }
            let (q_dot, p_dot) = rates(&geometry, &q, &p);
            let active = G::ACTIVE.iter().map(|&a| q_dot[a]);
            active.chain(p_dot).collect::<Vec<f64>>()
        };
        let h = 5e-4;
        let (a, b, c, d) = (shifted(h), shifted(-h), shifted(2.0 * h), shifted(-2.0 * h));
        for row in 0..2 * m {
            let difference = (8.0 * (a[row] - b[row]) - (c[row] - d[row])) / (12.0 * h);
            assert_near(jacobian[(row, column)], difference, 2e-8 * size.powi(4), &format!("({row}, {column})"));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn hamilton_s_equations(point in proptest::collection::vec(-1.0..1.0_f64, 8)) {
        check_definitions::<Everything>(&point);
        check_definitions::<Plane>(&point);
        check_definitions::<Null>(&point);
        check_definitions::<OneCoordinate>(&point);
    }

    #[test]
    fn the_jacobian(point in proptest::collection::vec(-1.0..1.0_f64, 8)) {
        check_jacobian::<Everything>(&point);
        check_jacobian::<Plane>(&point);
        check_jacobian::<Null>(&point);
        check_jacobian::<OneCoordinate>(&point);
    }

    /// The last momentum is dt/dγ Ω, by which forces are divided.
    #[test]
    fn with_newton_s_law(point in proptest::collection::vec(-1.0..1.0_f64, 7), p_s in 0.5..2.0_f64) {
        let point: Vec<f64> = point.into_iter().chain([p_s]).collect();
        check_definitions::<Lifted>(&point);
        check_jacobian::<Lifted>(&point);
    }
}

#[test]
fn motion_is_separable_where_accelerations_depend_on_positions_alone() {
    let plane = || metric(&["t", "x", "y"], &[("t t", "1 + x^2 + y^2"), ("x x", "-1"), ("y y", "-3")]);
    let is_separable = |text: GeometryText| {
        let geometry = geometry::<f64>(&text);
        assert_eq!(geometry.active(), [1, 2]);
        geometry.is_separable()
    };
    assert!(is_separable(plane()));
    assert!(!is_separable(GeometryText { force: vec![(1, "x_dot/5".to_owned())], ..plane() }), "friction");
    assert!(!is_separable(GeometryText { one_form: vec![(1, "y".to_owned())], ..plane() }), "a magnetic field");
    // (t, x, s) with a constant determinant, in which p_s drives x.
    let coupled = metric(&["t", "x", "s"], &[("t t", "x^2"), ("t x", "0.5"), ("t s", "1"), ("x x", "-1")]);
    let geometry = geometry::<f64>(&coupled);
    assert!(geometry.active() == [1] && !geometry.is_separable());
}
