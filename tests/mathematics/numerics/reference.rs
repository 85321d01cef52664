//! The reference trajectory against closed forms, invariants and quadrature; it ends early, steps onto
//! kinks, and sees thin walls.

use geodesic_ivp::engine::Engine;
use geodesic_ivp::geometry::{Geometry, GeometryText, Start};
use geodesic_ivp::number::Extended;
use geodesic_ivp::reference::{EndReason, ReferenceTrajectory, time_parametrised};

use crate::common::{
    QUARTIC_POTENTIAL, assert_near, g00, geometry, metric, newtonian, newtonian_start, norm_of, of_x, one, preset,
    reference, start, start_with_momenta,
};

fn quartic() -> Geometry {
    of_x(QUARTIC_POTENTIAL, 1.0, 1.0)
}

fn linear() -> Geometry {
    of_x("0.25*x", 1.0, 1.0)
}

/// c = 3 keeps every one of them away from g00 = 0.
fn formula(expression: &str) -> Geometry {
    of_x(expression, 1.0, 3.0)
}

/// x = 1, ṫ = 1, ẋ = 0.1.
fn begin(geometry: &Geometry) -> Start {
    start(geometry, &[0.0, 1.0], &[1.0, 0.1])
}

fn from_one(geometry: &Geometry, length: f64) -> ReferenceTrajectory {
    reference(geometry, &begin(geometry), length)
}

/// The linear potential's geodesic is a cycloid: with φ from g00 = (Q_t²/K) sin²φ,
/// γ = Q_t²(φ − sin φ cos φ)/(2α K^{3/2}) + const and t = Q_t φ/(α√K) + const (c = m = 1).
#[test]
fn the_linear_potential_s_cycloid() {
    let alpha = 0.25;
    let begun = begin(&linear());
    let (q, k) = (begun.p[0], norm_of(&linear(), &begun));
    // x grows with φ; the start moves to larger x, so φ is in the first quarter and increases.
    let phi_of = |g00: f64| (g00 * k / (q * q)).sqrt().asin();
    let start = phi_of(1.0 + 2.0 * alpha * begun.q[1]);
    let gamma = |phi: f64| q * q * (phi - phi.sin() * phi.cos()) / (2.0 * alpha * k.powf(1.5));
    let trajectory = from_one(&linear(), 4.0);
    for i in 1..=60 {
        let phi = start + 0.01 * f64::from(i);
        let s = gamma(phi) - gamma(start);
        if s > 4.0 {
            break;
        }
        let point = trajectory.at(s);
        let x = (q * q / k * phi.sin().powi(2) - 1.0) / (2.0 * alpha);
        let t = q * (phi - start) / (alpha * k.sqrt());
        assert!((point.q[1] - x).abs() < 1e-13, "phi = {phi}: x = {} against {x}", point.q[1]);
        assert!((point.q[0] - t).abs() < 1e-13, "phi = {phi}: t = {} against {t}", point.q[0]);
    }
}

#[test]
fn both_invariants_are_kept_everywhere() {
    for geometry in [quartic(), formula("sin(x) + exp(-x^2)/3"), formula("ln(x^2+2)*(1 + tanh(x)/2)")] {
        let trajectory = from_one(&geometry, 20.0);
        let begun = begin(&geometry);
        let (q_t, norm) = (begun.p[0], norm_of(&geometry, &begun));
        for i in 0..=1000 {
            let point = trajectory.at(0.02 * f64::from(i));
            let q = g00(&geometry, point.q[1]) * point.q_dot[0];
            assert!((q - q_t).abs() < 1e-11 * q_t.abs(), "Q_t at {i}");
            let k = norm_of(&geometry, &point);
            assert!((k - norm).abs() < 1e-11 * norm.abs().max(1.0), "K at {i}: {k}");
        }
    }
    // Compared with itself at another order; the invariants and DOP853 are the independent judges.
    for geometry in [quartic(), formula("0.3*(1 - exp(-x))^2")] {
        let trajectory = from_one(&geometry, 100.0);
        assert!(trajectory.error_estimate() < 1e-12, "{}", trajectory.error_estimate());
    }
}

/// γ from one turning point of the quartic oscillator to the other, by ∫dx/√(Q²/g00 − K) with x = x_turn sin θ, against
/// the trajectory's own turning points.
#[test]
fn the_quadrature_of_the_half_period() {
    let geometry = quartic();
    let begun = begin(&geometry);
    let (q, k) = (begun.p[0], norm_of(&geometry, &begun));
    // g00 = 1 + x⁴ = Q²/K at the turning point.
    let x_turn = (q * q / k - 1.0).powf(0.25);
    // Q²/g00 − K = K (x_t⁴ − x⁴)/(1 + x⁴), and x_t⁴ − x⁴ = (x_t² − x²)(x_t² + x²).
    let integrand = |theta: f64| {
        let x = x_turn * theta.sin();
        ((1.0 + x.powi(4)) / (k * (x_turn * x_turn + x * x))).sqrt()
    };
    // The integrand is smooth and periodic: the midpoint rule converges geometrically.
    let n = 200;
    let h = std::f64::consts::PI / f64::from(n);
    let half_period: f64 =
        (0..n).map(|i| integrand(-std::f64::consts::FRAC_PI_2 + (f64::from(i) + 0.5) * h)).sum::<f64>() * h;
    let trajectory = from_one(&geometry, 8.0);
    let turns = trajectory.sign_changes(|point| point.q_dot[1]);
    assert!(turns.len() >= 3, "{turns:?}");
    for pair in turns.windows(2) {
        assert!((pair[1] - pair[0] - half_period).abs() < 1e-12, "{} against {half_period}", pair[1] - pair[0]);
    }
}

/// A wrong rule shows at once: the two orders of the estimate would disagree, and K would drift. At rest x has no
/// linear term, and rules that divide by it or by the first coefficient of an exponent would show.
#[test]
fn every_function_of_the_grammar_has_its_series() {
    let moving = "tan(x/4)/9 | sinh(x/2)/9 | cosh(x/2)/9 | tanh(x) | asin(x/40) | acos(x/40) | atan(x) | exp(-x/3)/9 | \
                  ln(x + 40)/9 | log10(x + 40) | sqrt(x^2 + 3)/9 | (x^2 + 1)^0.3/9 | (x^2+2)^(sin(x)/9) | \
                  (x + 40)^-2 | 1/(2 + cos(x))";
    // The length is so short that x stays positive, where all of them are smooth.
    let resting = "2^x | x^2.5 | (1+x^2)^(x/5) | sqrt(x) | exp(-x)*sin(x) | abs(x)^1.5";
    for (expressions, x_dot, length) in [(moving, 0.1, 5.0), (resting, 0.0, 0.8)] {
        for expression in expressions.split(" | ") {
            let geometry = formula(expression);
            let begin = start(&geometry, &[0.0, 1.0], &[1.0, x_dot]);
            let trajectory = reference(&geometry, &begin, length);
            let (k, norm) = (norm_of(&geometry, &trajectory.at(length)), norm_of(&geometry, &begin));
            assert!((k - norm).abs() < 1e-12, "{expression}: K = {k} against {norm}");
            assert!(trajectory.error_estimate() < 1e-13, "{expression}: {}", trajectory.error_estimate());
            assert!(trajectory.steps() < 400, "{expression}: {} steps", trajectory.steps());
        }
    }
}

#[test]
fn what_would_take_too_long_is_refused_with_the_limit_and_not_for_another_reason() {
    let begun = std::time::Instant::now();
    let start_of_it = begin(&quartic());
    for length in [1e6, 1e9, 1e12, 1e15, 1e30] {
        for end in [
            ReferenceTrajectory::new(&quartic(), &start_of_it, length, 16).unwrap_err(),
            ReferenceTrajectory::length_of(&quartic(), &start_of_it, 0, length, 16).unwrap_err(),
        ] {
            assert!(matches!(end.reason, EndReason::TooLong { most_steps: 347_222 }), "{length:e}: {end}");
            assert!(end.to_string().contains("more than 347222 Taylor steps"), "{end}");
        }
    }
    let exact: Geometry<Extended> = of_x(QUARTIC_POTENTIAL, 1.0, 1.0);
    let begin = start(&exact, &[0.0, 1.0].map(Extended::from), &[1.0, 0.1].map(Extended::from));
    let end = ReferenceTrajectory::new(&exact, &begin, 1e9.into(), 20).unwrap_err();
    assert!(matches!(end.reason, EndReason::TooLong { .. }), "{end}");
    assert!(begun.elapsed().as_secs_f64() < 30.0, "{:?}", begun.elapsed());
    // Far behind the start of a long range there still is a horizon.
    let (geometry, start) = one("-0.5*x", 1.0, [0.0, 1.0, 0.0]);
    let end = ReferenceTrajectory::new(&geometry, &start, 1e12, 16).unwrap_err();
    assert_eq!(end.reason, EndReason::OutsideDomain, "{end}");
}

/// A wall so thin that the series before it do not know of it, and a bump behind which everything is as before.
#[test]
fn what_no_coefficient_shows_is_not_jumped_over() {
    for (formula, length) in [("0.2*tanh(40*(x - 1))", 4.0), ("0.1*x^20", 8.0), ("0.2*exp(-(60*(x - 1))^2)", 4.0)] {
        let (geometry, start) = one(formula, 1.0, [0.0, 1.0, 0.5]);
        let windows = (200.0 * length) as usize;
        let mut engine = Engine::equal(&geometry, &start, length, windows, 16).unwrap();
        let mut end = Vec::new();
        while let Some(window) = engine.next().unwrap() {
            end = window.end().positions();
        }
        let reference = reference(&geometry, &start, length);
        let exact = reference.at(length);
        let error = (exact.q[1] - end[1]).abs().max((exact.q[0] - end[0]).abs());
        assert!(error < 1e-11 && reference.error_estimate() < 1e-11, "{formula}: {error:e}");
        assert!(end[1] < 0.95, "{formula}: it is reflected");
    }
}

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
    let geometry: Geometry = geometry(&newtonian(&["x"], "x^2.5"));
    let start = newtonian_start(&geometry, &[0.0], &[1.0]);
    let end = ReferenceTrajectory::new(&geometry, &start, 1.0, 16).unwrap_err();
    assert_eq!(end.reason, EndReason::Singular, "{end}");
    assert!(end.to_string().ends_with("x = 0.000000e0, s = 0.000000e0: a formula has no Taylor series"), "{end}");
}

#[test]
fn kinks_are_seen() {
    // V = |x|/4 is the linear potential on either side; from x = 0 the two halves are mirror images.
    let linear = formula("abs(x)/4");
    let (trajectory, norm) = (from_one(&linear, 40.0), norm_of(&linear, &begin(&linear)));
    for i in 0..=400 {
        assert_near(norm_of(&linear, &trajectory.at(0.1 * f64::from(i))) - norm, 0.0, 1e-12, "K");
    }
    assert!(trajectory.error_estimate() < 1e-12, "{}", trajectory.error_estimate());
    // A force that is only a sign, and one that depends on the sign of a velocity: coasting down by dry friction.
    let coasting: Geometry = geometry(&newtonian(&["x"], "abs(x)"));
    let start = newtonian_start(&coasting, &[0.5], &[0.0]);
    let reference_of_v = reference(&coasting, &start, 8.0);
    // From 1/2 to 0 takes time 1; then it is periodic with period 4.
    for (gamma, x) in [(1.0, 0.0), (1.5, -0.375), (2.0, -0.5), (3.0, 0.0), (4.0, 0.5), (8.0, 0.5)] {
        assert_near(reference_of_v.at(gamma).q[1], x, 1e-13, "x");
    }
    let mut text = newtonian(&["x"], "x^2/2");
    text.force = vec![(0, "-x_dot*abs(x_dot)/5".to_owned())];
    let geometry: Geometry = geometry(&text);
    let with_friction = reference(&geometry, &newtonian_start(&geometry, &[1.0], &[0.0]), 20.0);
    assert!(with_friction.error_estimate() < 1e-12, "{}", with_friction.error_estimate());
    assert_near(geometry.norm(&with_friction.at(20.0).q, &with_friction.at(20.0).q_dot), 0.0, 1e-12, "K");
}

#[test]
fn forces_that_cancel_cost_no_steps() {
    // The forces of two equal masses on a third one between them cancel in z but for rounding.
    let pull = |sign: &str| format!("-1/sqrt(x^2 + y^2 + (z {sign} 0.7)^2)");
    let geometry: Geometry = geometry(&newtonian(&["x", "y", "z"], &(pull("+") + &pull("-"))));
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
    let geometry: Geometry = geometry(&newtonian(&["x"], "x^2/2"));
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
    let with_drift = GeometryText { force: vec![(1, "-exp(x)*t_dot^2/2".to_owned())], ..text };
    let geometry: Geometry = geometry(&with_drift);
    let start = start(&geometry, &[0.0, 0.0], &[1.0, 1.0]);
    let gamma = ReferenceTrajectory::length_of(&geometry, &start, 0, 0.5, 16).unwrap();
    assert_near(gamma, 2.0_f64.ln(), 1e-14, "gamma");
    let end = ReferenceTrajectory::length_of(&geometry, &start, 0, 2.0, 16).unwrap_err();
    assert_eq!(end.reason, EndReason::TimeNotReached, "{end}");
}

/// With time as the parameter an oscillator is x = cos t for all that c = 1e4 changes.
#[test]
fn the_motion_in_time_goes_to_its_end_or_to_where_it_is_defined() {
    let geometry = of_x("x^2/2", 1.0, 1e4);
    let states = time_parametrised(&geometry, &start(&geometry, &[0.0, 1.0], &[1.0, 0.0]), 5.0, 11);
    assert_eq!(states.len(), 11);
    for (time, x) in states {
        assert_near(x, time.cos(), 1e-7, "x");
    }
    // Left of 0 there is no root of x.
    let geometry = of_x("sqrt(x)", 1.0, 1e4);
    let states = time_parametrised(&geometry, &start(&geometry, &[0.0, 1.0], &[1.0, -0.2]), 5.0, 11);
    assert!((2..11).contains(&states.len()), "{states:?}");
}
