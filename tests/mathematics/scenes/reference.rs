//! The reference of a scene does more than integrate: it ends early, steps onto kinks, sees thin walls, and agrees
//! with the reference of one coordinate.

use geodesic_ivp::geometry::{Geometry, GeometryText};
use geodesic_ivp::reference::{EndReason, ReferenceTrajectory};

use crate::common::{
    assert_near, geometry, metric, newtonian, newtonian_start, of_potential, preset, reference, start,
    start_with_momenta,
};

#[test]
fn it_ends_where_the_geodesic_leaves_the_domain() {
    // The horizon is not reached in these coordinates at any finite t, but at a finite proper time.
    let schwarzschild = geometry(&preset("schwarzschild", &[]));
    let at_rest = start(&schwarzschild, &[0.0, 10.0, 0.0], &[1.0 / 0.8_f64.sqrt(), 0.0, 0.0]);
    let end = ReferenceTrajectory::new(&schwarzschild, &at_rest, 60.0, 16).unwrap_err();
    assert_eq!(end.reason, EndReason::OutsideDomain, "{end}");
    assert_near(end.gamma, 33.700_869_851_892_335, 1e-4, "tau");
    assert_eq!(end.place[1].0, "r");
    assert_near(end.place[1].1, 2.0, 1e-3, "r");
    assert!(end.to_string().contains("r = 2.0"), "{end}");
    // Inside, where t and r have changed their roles, there is a world-line to the centre.
    let inside = start_with_momenta(&schwarzschild, &[0.0, 1.5, 0.0], &[0.5, -2.0, 0.0]);
    let end = ReferenceTrajectory::new(&schwarzschild, &inside, 10.0, 16).unwrap_err();
    assert!(end.place[1].1 < 1e-3, "{end}");
    // A start on the edge is outside.
    let on_it = start(&schwarzschild, &[0.0, 2.0, 0.0], &[1.0, 0.0, 0.0]);
    let end = ReferenceTrajectory::new(&schwarzschild, &on_it, 1.0, 16).unwrap_err();
    assert_eq!((end.reason, end.gamma), (EndReason::OutsideDomain, 0.0), "{end}");
}

#[test]
fn what_has_no_series_is_singular() {
    let geometry: Geometry = of_potential(&newtonian(&["x"], "x^2.5"));
    let start = newtonian_start(&geometry, &[0.0], &[1.0]);
    let end = ReferenceTrajectory::new(&geometry, &start, 1.0, 16).unwrap_err();
    assert_eq!(end.reason, EndReason::Singular, "{end}");
    assert!(end.to_string().ends_with("x = 0.000000e0, s = 0.000000e0: a formula has no Taylor series"), "{end}");
}

#[test]
fn kinks_and_thin_walls_are_seen() {
    // A force that is only a sign, and one that depends on the sign of a velocity: coasting down by dry friction.
    let geometry: Geometry = of_potential(&newtonian(&["x"], "abs(x)"));
    let start = newtonian_start(&geometry, &[0.5], &[0.0]);
    let reference_of_v = reference(&geometry, &start, 8.0);
    // From 1/2 to 0 takes time 1; then it is periodic with period 4.
    for (gamma, x) in [(1.0, 0.0), (1.5, -0.375), (2.0, -0.5), (3.0, 0.0), (4.0, 0.5), (8.0, 0.5)] {
        assert_near(reference_of_v.at(gamma).q[1], x, 1e-13, "x");
    }
    let mut text = newtonian(&["x"], "x^2/2");
    text.force = vec![(0, "-x_dot*abs(x_dot)/5".to_owned())];
    let geometry: Geometry = of_potential(&text);
    let with_friction = reference(&geometry, &newtonian_start(&geometry, &[1.0], &[0.0]), 20.0);
    assert!(with_friction.error_estimate() < 1e-12, "{}", with_friction.error_estimate());
    assert_near(geometry.norm(&with_friction.at(20.0).q, &with_friction.at(20.0).q_dot), 0.0, 1e-12, "K");
    // It bounces off a wall that the series before it do not know of; far from it the speed is what it was.
    let geometry: Geometry = of_potential(&newtonian(&["x", "y"], "tanh(60*(x - 1))"));
    let start = newtonian_start(&geometry, &[0.0, 0.0], &[1.0, 0.3]);
    let end = reference(&geometry, &start, 2.5).at(2.5);
    assert_near(end.q_dot[1], -1.0, 1e-12, "v_x");
    assert_near(end.q[2], 0.75, 1e-14, "y");
}

#[test]
fn forces_that_cancel_cost_no_steps() {
    // The forces of two equal masses on a third one between them cancel in z but for rounding.
    let pull = |sign: &str| format!("-1/sqrt(x^2 + y^2 + (z {sign} 0.7)^2)");
    let geometry: Geometry = of_potential(&newtonian(&["x", "y", "z"], &(pull("+") + &pull("-"))));
    let start = newtonian_start(&geometry, &[1.0, 0.0, 1e-17], &[0.0, 0.9, 0.0]);
    let reference = reference(&geometry, &start, 20.0);
    assert!(reference.steps() < 200, "{}", reference.steps());
    assert!(reference.error_estimate() < 1e-12, "{}", reference.error_estimate());
    // An orbit in the plane θ = π/2, which is not a number of the computer.
    let kerr = crate::common::geometry(&preset("kerr", &[("a", "0.9")]));
    let q = [0.0, 8.0, std::f64::consts::FRAC_PI_2, 0.0];
    let orbit = start_with_momenta(&kerr, &q, &[0.95, 0.0, 0.0, -3.0]);
    let reference = crate::common::reference(&kerr, &orbit, 100.0);
    assert!(reference.steps() < 300, "{}", reference.steps());
    assert!(reference.error_estimate() < 1e-12, "{}", reference.error_estimate());
}

#[test]
fn lower_orders_are_less_accurate() {
    let geometry: Geometry = geometry(&preset("schwarzschild", &[]));
    let start = start(&geometry, &[0.0, 10.0, 0.0], &[1.2, -0.05, 0.03]);
    let exact = reference(&geometry, &start, 40.0).at(40.0);
    let error = |digits: u32| {
        let rough = ReferenceTrajectory::unchecked(&geometry, &start, 40.0, digits as usize + 4, digits).unwrap();
        assert_eq!(rough.error_estimate(), f64::INFINITY);
        (rough.at(40.0).q[1] - exact.q[1]).abs()
    };
    assert!(error(4) < 1e-2 && error(8) < 1e-6 && error(12) < 1e-10 && error(4) > error(12));
}

#[test]
fn every_sign_change_is_found() {
    let geometry: Geometry = of_potential(&newtonian(&["x"], "x^2/2"));
    let reference = reference(&geometry, &newtonian_start(&geometry, &[1.0], &[0.0]), 20.0);
    let zeros = reference.sign_changes(|point| point.q[1]);
    assert_eq!(zeros.len(), 6);
    for (k, zero) in zeros.iter().enumerate() {
        assert_near(*zero, (k as f64 + 0.5) * std::f64::consts::PI, 1e-14, "a zero of the cosine");
    }
    assert!(reference.sign_changes(|point| point.q[1] - 2.0).is_empty());
}

#[test]
fn a_time_that_is_not_reached() {
    // dt/dγ = exp(−γ): t stays below 1.
    let text = metric(&["t", "x"], &[("t t", "exp(x)"), ("x x", "-1")]);
    let with_drift = geodesic_ivp::geometry::MetricText { force: vec![(1, "-exp(x)*t_dot^2/2".to_owned())], ..text };
    let geometry: Geometry = Geometry::new(&GeometryText::Metric(with_drift)).unwrap();
    let start = start(&geometry, &[0.0, 0.0], &[1.0, 1.0]);
    let gamma = ReferenceTrajectory::length_of(&geometry, &start, 0, 0.5, 16).unwrap();
    assert_near(gamma, 2.0_f64.ln(), 1e-14, "gamma");
    let end = ReferenceTrajectory::length_of(&geometry, &start, 0, 2.0, 16).unwrap_err();
    assert_eq!(end.reason, EndReason::TimeNotReached, "{end}");
}
