//! The reference trajectory against closed forms, invariants, the quadrature and published digits.

use geodesic_ivp::engine::Engine;
use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::number::Extended;
use geodesic_ivp::reference::{EndReason, ReferenceTrajectory};

use crate::common::{QUARTIC_POTENTIAL, g00, norm_of, of_x, start};

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

fn reference(geometry: &Geometry, length: f64) -> ReferenceTrajectory {
    ReferenceTrajectory::new(geometry, &begin(geometry), length, 16).unwrap()
}

#[test]
#[allow(clippy::excessive_precision)] // The continuum digits as they were computed.
fn the_base_cases_to_the_last_digit() {
    let published = [
        (linear(), 0.997129598504376989402741, 0.976046390793498338329943, -0.148570533876599546619322),
        (quartic(), 1.46863475695573088737134, 0.15977801888540724822026, -1.41682559809315428413482),
    ];
    for (geometry, t, x, x_dot) in published {
        let trajectory = reference(&geometry, 1.0);
        let end = trajectory.at(1.0);
        for (got, want) in [(end.q[0], t), (end.q[1], x), (end.q_dot[1], x_dot)] {
            assert!(((got - want) / want).abs() < 1e-14, "{got} against {want}");
        }
        assert!(trajectory.error_estimate() < 1e-14, "{}", trajectory.error_estimate());
    }
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
    let trajectory = reference(&linear(), 4.0);
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
        let trajectory = reference(&geometry, 20.0);
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
    // The integrand is smooth and periodic: the midpoint rule converges geogeometryally.
    let n = 200;
    let h = std::f64::consts::PI / f64::from(n);
    let half_period: f64 =
        (0..n).map(|i| integrand(-std::f64::consts::FRAC_PI_2 + (f64::from(i) + 0.5) * h)).sum::<f64>() * h;
    let trajectory = reference(&geometry, 8.0);
    // dx/dγ vanishes at the turning points: bisection between sign changes.
    let mut turns = Vec::new();
    for i in 0..800 {
        let (mut a, mut b) = (0.01 * f64::from(i), 0.01 * f64::from(i + 1));
        let sign = trajectory.at(a).q_dot[1];
        if sign * trajectory.at(b).q_dot[1] < 0.0 {
            for _ in 0..60 {
                let middle = 0.5 * (a + b);
                if trajectory.at(middle).q_dot[1] * sign > 0.0 { a = middle } else { b = middle }
            }
            turns.push(0.5 * (a + b));
        }
    }
    assert!(turns.len() >= 3, "{turns:?}");
    for pair in turns.windows(2) {
        assert!((pair[1] - pair[0] - half_period).abs() < 1e-12, "{} against {half_period}", pair[1] - pair[0]);
    }
}

#[test]
fn a_hundred_units_to_twelve_digits() {
    // Compared with itself at another order; the invariants and DOP853 above are the independent judges.
    for geometry in [quartic(), formula("0.3*(1 - exp(-x))^2")] {
        let trajectory = reference(&geometry, 100.0);
        assert!(trajectory.error_estimate() < 1e-12, "{}", trajectory.error_estimate());
    }
}

#[test]
fn a_kink_is_stepped_onto() {
    // V = |x|/4 is the linear potential on either side; from x = 0 the two halves are mirror images.
    let geometry = formula("abs(x)/4");
    let trajectory = reference(&geometry, 40.0);
    let norm = norm_of(&geometry, &begin(&geometry));
    for i in 0..=400 {
        let k = norm_of(&geometry, &trajectory.at(0.1 * f64::from(i)));
        assert!((k - norm).abs() < 1e-12, "K at gamma = {}: {k}", 0.1 * f64::from(i));
    }
    assert!(trajectory.error_estimate() < 1e-12, "{}", trajectory.error_estimate());
}

#[test]
fn every_function_of_the_grammar_has_its_series() {
    let expressions = [
        "tan(x/4)/9",
        "sinh(x/2)/9",
        "cosh(x/2)/9",
        "tanh(x)",
        "asin(x/40)",
        "acos(x/40)",
        "atan(x)",
        "exp(-x/3)/9",
        "ln(x + 40)/9",
        "log10(x + 40)",
        "sqrt(x^2 + 3)/9",
        "(x^2 + 1)^0.3/9",
        "(x^2+2)^(sin(x)/9)",
        "(x + 40)^-2",
        "1/(2 + cos(x))",
    ];
    for expression in expressions {
        let geometry = formula(expression);
        let trajectory = reference(&geometry, 5.0);
        // A wrong rule shows at once: the two orders of the estimate would disagree, and K would drift.
        let norm = norm_of(&geometry, &begin(&geometry));
        let k = norm_of(&geometry, &trajectory.at(5.0));
        assert!((k - norm).abs() < 1e-12, "{expression}: K = {k} against {norm}");
        assert!(trajectory.error_estimate() < 1e-13, "{expression}: {}", trajectory.error_estimate());
        assert!(trajectory.steps() < 400, "{expression}: {} steps", trajectory.steps());
    }
}

#[test]
fn the_length_of_a_physical_time() {
    let length = ReferenceTrajectory::length_of(&quartic(), &begin(&quartic()), 0, 10.0, 16).unwrap();
    assert!((reference(&quartic(), length).at(length).q[0] - 10.0).abs() < 1e-13);
}

#[test]
fn a_start_at_rest_has_a_reference_too() {
    // At rest x has no linear term, and rules that divide by it or by the first coefficient of an exponent would show.
    for expression in ["2^x", "x^2.5", "(1+x^2)^(x/5)", "sqrt(x)", "exp(-x)*sin(x)", "abs(x)^1.5"] {
        let geometry = formula(expression);
        let rest = start(&geometry, &[0.0, 1.0], &[1.0, 0.0]);
        // Short enough that x stays positive, where all of them are smooth.
        let trajectory =
            ReferenceTrajectory::new(&geometry, &rest, 0.8, 16).unwrap_or_else(|e| panic!("{expression}: {e}"));
        let (k, norm) = (norm_of(&geometry, &trajectory.at(0.8)), norm_of(&geometry, &rest));
        assert!((k - norm).abs() < 1e-12, "{expression}: K = {k} against {norm}");
        assert!(trajectory.error_estimate() < 1e-13, "{expression}: {}", trajectory.error_estimate());
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
    let [zero, one, x_dot] = [0.0, 1.0, 0.1].map(Extended::from);
    let begin = start(&exact, &[zero, one], &[one, x_dot]);
    let end = ReferenceTrajectory::new(&exact, &begin, 1e9.into(), 20).unwrap_err();
    assert!(matches!(end.reason, EndReason::TooLong { .. }), "{end}");
    assert!(begun.elapsed().as_secs_f64() < 30.0, "{:?}", begun.elapsed());
    // Far behind the start of a long range there still is a horizon.
    let geometry = of_x("-0.5*x", 1.0, 1.0);
    let start = start(&geometry, &[0.0, 0.0], &[1.0, 0.0]);
    let end = ReferenceTrajectory::new(&geometry, &start, 1e12, 16).unwrap_err();
    assert_eq!(end.reason, EndReason::OutsideDomain, "{end}");
}

/// A wall so thin that the series before it do not know of it, and a bump behind which everything is as before.
#[test]
fn what_no_coefficient_shows_is_not_jumped_over() {
    for (formula, length) in [("0.2*tanh(40*(x - 1))", 4.0), ("0.1*x^20", 8.0), ("0.2*exp(-(60*(x - 1))^2)", 4.0)] {
        let geometry = of_x(formula, 1.0, 1.0);
        let (windows, start) = ((200.0 * length) as usize, start(&geometry, &[0.0, 0.0], &[1.0, 0.5]));
        let mut engine = Engine::equal(&geometry, &start, length, windows, 16).unwrap();
        let mut end = Vec::new();
        while let Some(window) = engine.next().unwrap() {
            end = window.end().positions();
        }
        let reference = ReferenceTrajectory::new(&geometry, &start, length, 16).unwrap();
        let exact = reference.at(length);
        let error = (exact.q[1] - end[1]).abs().max((exact.q[0] - end[0]).abs());
        assert!(error < 1e-11 && reference.error_estimate() < 1e-11, "{formula}: {error:e}");
        assert!(end[1] < 0.95, "{formula}: it is reflected");
    }
}
