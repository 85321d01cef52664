//! The reference trajectory against closed forms, invariants, the quadrature and published digits.

use std::collections::BTreeMap;

use geodesic_ivp::engine::Engine;
use geodesic_ivp::geometry::geodesic::InitialData;
use geodesic_ivp::geometry::metric::Metric;
use geodesic_ivp::geometry::potential::{Formula, Potential};
use geodesic_ivp::number::Extended;
use geodesic_ivp::reference::{EndReason, ReferenceTrajectory};

const START: InitialData = InitialData { t: 0.0, x: 1.0, t_dot: 1.0, x_dot: 0.1 };

fn quartic() -> Metric {
    Metric::new(Potential::quartic(0.5), 1.0, 1.0)
}

fn linear() -> Metric {
    Metric::new(Potential::linear(0.25), 1.0, 1.0)
}

fn formula(expression: &str) -> Metric {
    // c = 3 keeps every one of them away from g00 = 0.
    Metric::new(Potential::Formula(Formula::new(expression, &BTreeMap::new()).unwrap()), 1.0, 3.0)
}

fn reference(metric: &Metric, length: f64) -> ReferenceTrajectory {
    ReferenceTrajectory::new(metric, &START, length, 16).unwrap()
}

#[test]
#[allow(clippy::excessive_precision)] // The continuum digits as they were computed.
fn the_base_cases_to_the_last_digit() {
    let published = [
        (linear(), 0.997129598504376989402741, 0.976046390793498338329943, -0.148570533876599546619322),
        (quartic(), 1.46863475695573088737134, 0.15977801888540724822026, -1.41682559809315428413482),
    ];
    for (metric, t, x, x_dot) in published {
        let trajectory = reference(&metric, 1.0);
        let end = trajectory.at(1.0);
        for (got, want) in [(end.elapsed, t), (end.x, x), (end.x_dot, x_dot)] {
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
    let invariants = START.invariants(&linear());
    let (q, k) = (invariants.q_t, invariants.k);
    // x grows with φ; the start moves to larger x, so φ is in the first quarter and increases.
    let phi_of = |g00: f64| (g00 * k / (q * q)).sqrt().asin();
    let start = phi_of(1.0 + 2.0 * alpha * START.x);
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
        assert!((point.x - x).abs() < 1e-13, "phi = {phi}: x = {} against {x}", point.x);
        assert!((point.elapsed - t).abs() < 1e-13, "phi = {phi}: t = {} against {t}", point.elapsed);
    }
}

#[test]
fn both_invariants_are_kept_everywhere() {
    for metric in [quartic(), formula("sin(x) + exp(-x^2)/3"), formula("ln(x^2+2)*(1 + tanh(x)/2)")] {
        let trajectory = reference(&metric, 20.0);
        let invariants = START.invariants(&metric);
        for i in 0..=1000 {
            let point = trajectory.at(0.02 * f64::from(i));
            let g00 = metric.at(point.x).g00;
            assert!((g00 * point.t_dot - invariants.q_t).abs() < 1e-11 * invariants.q_t.abs(), "Q_t at {i}");
            let k = g00 * point.t_dot.powi(2) - point.x_dot.powi(2);
            assert!((k - invariants.k).abs() < 1e-11 * invariants.k.abs().max(1.0), "K at {i}: {k}");
        }
    }
}

/// γ from one turning point of the quartic oscillator to the other, by ∫dx/√(Q²/g00 − K) with x = x_turn sin θ, against
/// the trajectory's own turning points.
#[test]
fn the_quadrature_of_the_half_period() {
    let metric = quartic();
    let invariants = START.invariants(&metric);
    let (q, k) = (invariants.q_t, invariants.k);
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
    let trajectory = reference(&metric, 8.0);
    // dx/dγ vanishes at the turning points: bisection between sign changes.
    let mut turns = Vec::new();
    for i in 0..800 {
        let (mut a, mut b) = (0.01 * f64::from(i), 0.01 * f64::from(i + 1));
        let sign = trajectory.at(a).x_dot;
        if sign * trajectory.at(b).x_dot < 0.0 {
            for _ in 0..60 {
                let middle = 0.5 * (a + b);
                if trajectory.at(middle).x_dot * sign > 0.0 { a = middle } else { b = middle }
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
    for metric in [quartic(), formula("0.3*(1 - exp(-x))^2")] {
        let trajectory = reference(&metric, 100.0);
        assert!(trajectory.error_estimate() < 1e-12, "{}", trajectory.error_estimate());
    }
}

#[test]
fn a_kink_is_stepped_onto() {
    // V = |x|/4 is the linear potential on either side; from x = 0 the two halves are mirror images.
    let metric = formula("abs(x)/4");
    let trajectory = reference(&metric, 40.0);
    let invariants = START.invariants(&metric);
    for i in 0..=400 {
        let point = trajectory.at(0.1 * f64::from(i));
        let g00 = metric.at(point.x).g00;
        let k = g00 * point.t_dot.powi(2) - point.x_dot.powi(2);
        assert!((k - invariants.k).abs() < 1e-12, "K at gamma = {}: {k}", 0.1 * f64::from(i));
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
        let metric = formula(expression);
        let trajectory = reference(&metric, 5.0);
        // A wrong rule shows at once: the two orders of the estimate would disagree, and K would drift.
        let invariants = START.invariants(&metric);
        let point = trajectory.at(5.0);
        let g00 = metric.at(point.x).g00;
        let k = g00 * point.t_dot.powi(2) - point.x_dot.powi(2);
        assert!((k - invariants.k).abs() < 1e-12, "{expression}: K = {k} against {}", invariants.k);
        assert!(trajectory.error_estimate() < 1e-13, "{expression}: {}", trajectory.error_estimate());
        assert!(trajectory.steps() < 400, "{expression}: {} steps", trajectory.steps());
    }
}

#[test]
fn a_horizon_ends_the_trajectory() {
    let metric = Metric::new(Potential::linear(-0.5), 1.0, 1.0);
    let start = InitialData { t: 0.0, x: 0.0, t_dot: 1.0, x_dot: 0.0 };
    let end = ReferenceTrajectory::new(&metric, &start, 5.0, 16).unwrap_err();
    // K = Q = 1 and g00 = sin²φ from φ = π/2: γ = π/2 at the horizon.
    assert!((end.gamma - std::f64::consts::FRAC_PI_2).abs() < 1e-6, "{end}");
    assert!((end.place[0].1 - 1.0).abs() < 1e-3, "{end}");
    assert_eq!(end.reason, EndReason::OutsideDomain);
}

#[test]
fn the_length_of_a_physical_time() {
    let length = ReferenceTrajectory::length_of(&quartic(), &START, 0, 10.0, 16).unwrap();
    assert!((reference(&quartic(), length).at(length).elapsed - 10.0).abs() < 1e-13);
}

#[test]
fn a_start_at_rest_has_a_reference_too() {
    // At rest x has no linear term, and rules that divide by it or by the first coefficient of an exponent would show.
    let rest = InitialData { x_dot: 0.0, ..START };
    for expression in ["2^x", "x^2.5", "(1+x^2)^(x/5)", "sqrt(x)", "exp(-x)*sin(x)", "abs(x)^1.5"] {
        let metric = formula(expression);
        // Short enough that x stays positive, where all of them are smooth.
        let trajectory =
            ReferenceTrajectory::new(&metric, &rest, 0.8, 16).unwrap_or_else(|e| panic!("{expression}: {e}"));
        let point = trajectory.at(0.8);
        let (invariants, g00) = (rest.invariants(&metric), metric.at(point.x).g00);
        let k = g00 * point.t_dot.powi(2) - point.x_dot.powi(2);
        assert!((k - invariants.k).abs() < 1e-12, "{expression}: K = {k} against {}", invariants.k);
        assert!(trajectory.error_estimate() < 1e-13, "{expression}: {}", trajectory.error_estimate());
    }
}

#[test]
fn a_potential_without_a_series_is_an_error() {
    let at_zero = InitialData { x: 0.0, ..START };
    let end = ReferenceTrajectory::new(&formula("x^2.5"), &at_zero, 1.0, 16).unwrap_err();
    assert_eq!(end.reason, EndReason::Singular, "{end}");
}

#[test]
fn what_would_take_too_long_is_refused_with_the_limit_and_not_for_another_reason() {
    let begun = std::time::Instant::now();
    for length in [1e6, 1e9, 1e12, 1e15, 1e30] {
        for end in [
            ReferenceTrajectory::new(&quartic(), &START, length, 16).unwrap_err(),
            ReferenceTrajectory::length_of(&quartic(), &START, 0, length, 16).unwrap_err(),
        ] {
            assert!(matches!(end.reason, EndReason::TooLong { most_steps: 347_222 }), "{length:e}: {end}");
            assert!(end.to_string().contains("more than 347222 Taylor steps"), "{end}");
        }
    }
    let metric: Metric<Extended> = Metric::new(Potential::quartic(0.5.into()), 1.0.into(), 1.0.into());
    let [x, x_dot] = [1.0, 0.1].map(Extended::from);
    let start = InitialData { t: 0.0.into(), x, t_dot: 1.0.into(), x_dot };
    let end = ReferenceTrajectory::new(&metric, &start, 1e9.into(), 20).unwrap_err();
    assert!(matches!(end.reason, EndReason::TooLong { .. }), "{end}");
    assert!(begun.elapsed().as_secs_f64() < 30.0, "{:?}", begun.elapsed());
    // Far behind the start of a long range there still is a horizon.
    let metric = Metric::new(Potential::linear(-0.5), 1.0, 1.0);
    let start = InitialData { t: 0.0, x: 0.0, t_dot: 1.0, x_dot: 0.0 };
    let end = ReferenceTrajectory::new(&metric, &start, 1e12, 16).unwrap_err();
    assert_eq!(end.reason, EndReason::OutsideDomain, "{end}");
}

/// A wall so thin that the series before it do not know of it, and a bump behind which everything is as before.
#[test]
fn what_no_coefficient_shows_is_not_jumped_over() {
    for (formula, length) in [("0.2*tanh(40*(x - 1))", 4.0), ("0.1*x^20", 8.0), ("0.2*exp(-(60*(x - 1))^2)", 4.0)] {
        let potential = Potential::Formula(Formula::new(formula, &BTreeMap::new()).unwrap());
        let metric = Metric::new(potential, 1.0, 1.0);
        let initial = InitialData { t: 0.0, x: 0.0, t_dot: 1.0, x_dot: 0.5 };
        let (windows, start) = ((200.0 * length) as usize, initial.start(&metric));
        let mut engine = Engine::equal(metric.scene(), &start, length, windows, 16).unwrap();
        let mut end = Vec::new();
        while let Some(window) = engine.next().unwrap() {
            end = window.end().positions();
        }
        let reference = ReferenceTrajectory::new(&metric, &initial, length, 16).unwrap();
        let exact = reference.at(length);
        let error = (exact.x - end[1]).abs().max((exact.elapsed - end[0]).abs());
        assert!(error < 1e-11 && reference.error_estimate() < 1e-11, "{formula}: {error:e}");
        assert!(end[1] < 0.95, "{formula}: it is reflected");
    }
}
