//! Windows of the weak scheme: tables, long marches, levels, failures, and the world-line between the ends.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use geodesic_ivp::engine::lobatto::{Level, March, MarchFailure, Marched, State, Twofold, WeakRule, WindowView};
use geodesic_ivp::geometry::geodesic::InitialData;
use geodesic_ivp::geometry::metric::Metric;
use geodesic_ivp::geometry::potential::{Formula, Potential};
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::reference::ReferenceTrajectory;

/// t(1), x(1) and w(1) of the quartic base case, from its continuum solution with 24 digits.
const QUARTIC_END: [f64; 3] = [1.468_634_756_955_731, 0.159_778_018_885_407_25, -1.416_825_598_093_154_3];

fn quartic() -> Metric {
    Metric::new(Potential::quartic(0.5), 1.0, 1.0)
}

fn formula(expression: &str) -> Potential {
    Potential::Formula(Formula::new(expression, &BTreeMap::new()).expect("a valid formula"))
}

fn base() -> State {
    State { t: 0.0.into(), x: 1.0.into(), w: 0.1.into() }
}

fn go_on(_: &WindowView<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// ΔK of the quartic base case in double-double.
fn delta_k(state: &State) -> f64 {
    let square = state.x * state.x;
    let k = Twofold::from(4.0) / (square * square + Twofold::ONE) - state.w * state.w;
    (k - (Twofold::from(2.0) - Twofold::from(0.1) * Twofold::from(0.1))).hi
}

fn worst_delta_k(metric: &Metric, n: usize, windows: usize, length: f64, level: Level) -> f64 {
    let rule = WeakRule::new(n);
    let mut worst = 0.0_f64;
    let mut see = |view: &WindowView<'_>| {
        worst = worst.max(delta_k(&view.end).abs());
        ControlFlow::Continue(())
    };
    let march = March::new(metric, 2.0, &rule, length.into()).with_level(level);
    march.run(base(), windows, &mut see).expect("the run converges");
    worst
}

fn sum(terms: impl Iterator<Item = Twofold>) -> Twofold {
    terms.fold(Twofold::ZERO, |sum, term| sum + term)
}

#[test]
fn rules_are_exact_to_thirty_digits() {
    for n in [2, 3, 5, 16, 20, 33, 64] {
        let rule = WeakRule::new(n);
        let (c, b) = (rule.nodes(), rule.weights());
        for j in 0..n {
            assert!((c[j] + c[n - 1 - j] - Twofold::ONE).hi.abs() < 1e-31 && b[j] == b[n - 1 - j]);
        }
        // The quadrature integrates s^d up to d = 2n − 3, and not 2n − 2.
        let mut powers = vec![Twofold::ONE; n];
        for degree in 0..=2 * n - 2 {
            let error = (sum((0..n).map(|j| b[j] * powers[j])) * (degree + 1) as f64 - Twofold::ONE).abs().hi;
            if degree < 2 * n - 2 {
                assert!(error < 1e-29, "n {n} degree {degree}: {error:e}");
            } else if n < 20 {
                assert!(error > 1e-20, "n {n} degree {degree}: {error:e}");
            }
            powers.iter_mut().zip(c).for_each(|(p, &c)| *p = *p * c);
        }
    }
}

#[test]
fn the_operators_satisfy_their_identities() {
    for n in [2, 3, 8, 20, 64] {
        let rule = WeakRule::new(n);
        let (c, b, a, a_squared) = (rule.nodes(), rule.weights(), rule.a(), rule.a_squared());
        for i in 0..n {
            let close = |x: Twofold, y: Twofold| assert!((x - y).hi.abs() < 1e-29, "n {n} row {i}");
            // A 1 = c and, with three nodes, A c = c²/2: polynomials of degree n − 2 are integrated exactly.
            close(sum((0..n).map(|j| a[i * n + j])), c[i]);
            assert_eq!(a[i * n], b[0]);
            assert_eq!(a[(n - 1) * n + i], b[i]);
            if n > 2 {
                close(sum((0..n).map(|j| a[i * n + j] * c[j])), (c[i] * c[i]).half());
                close(sum((0..n).map(|j| a_squared[i * n + j])), (c[i] * c[i]).half());
            }
            // bᵀA = b (1 − c)
            close(sum((0..n).map(|j| b[j] * a[j * n + i])), rule.position_weight(i));
            close(sum((0..n).map(|j| rule.integration()[i * n + j])), c[i]);
        }
    }
}

#[test]
fn the_base_case_is_solved_to_the_last_digits_at_every_level_and_size() {
    let metric = quartic();
    for level in [Level::Best, Level::Avx2, Level::Scalar] {
        for (n, windows) in [(8, 16), (16, 2), (24, 1), (30, 1), (40, 1), (64, 1)] {
            let rule = WeakRule::new(n);
            let length = Twofold::ONE / Twofold::from(windows as f64);
            let marched = March::new(&metric, 2.0, &rule, length).with_level(level).run(base(), windows, &mut go_on);
            let Marched { end, statistics } = marched.expect("it converges");
            for (value, exact) in [end.t, end.x, end.w].iter().zip(QUARTIC_END) {
                assert!((value.hi - exact).abs() < 4e-15, "n {n} {level:?}: {} {exact}", value.hi);
            }
            assert_eq!(statistics.windows, windows);
        }
    }
}

#[test]
fn k_stays_over_a_thousand_units() {
    for level in [Level::Best, Level::Avx2, Level::Scalar] {
        let worst = worst_delta_k(&quartic(), 16, 2000, 0.5, level);
        assert!(worst < 1e-13, "{level:?}: {worst:e}");
        let worst = worst_delta_k(&quartic(), 20, 4000, 0.25, level);
        assert!(worst < 1e-15, "{level:?}: {worst:e}");
    }
}

#[test]
fn a_formula_and_the_same_polynomial_agree() {
    let of_formula = |text: &str| Metric::new(formula(text), 1.0, 1.0);
    for text in ["x^4/2", "x^2*(x^2 + 1)/2 - x*x/2"] {
        let worst = worst_delta_k(&of_formula(text), 20, 4000, 0.25, Level::Best);
        assert!(worst < 1e-15, "{text}: {worst:e}");
    }
    // Every kind of instruction: arithmetic, negation, powers, functions; the last ones are not refined.
    for text in
        ["x^4/2", "-(0 - x^4)/2", "1/(2*x^(-4))", "x*x*x/(2/x)", "exp(ln(x^2)*2)/2", "abs(x)^4.0/2", "sqrt(x^8)/2"]
    {
        for level in [Level::Best, Level::Scalar] {
            let metric = of_formula(text);
            let rule = WeakRule::new(16);
            let marched = March::new(&metric, 2.0, &rule, 0.25.into()).with_level(level).run(base(), 4, &mut go_on);
            let end = marched.expect("it converges").end;
            assert!((end.x.hi - QUARTIC_END[1]).abs() < 1e-14, "{text} {level:?}: {}", end.x.hi);
            assert!((end.t.hi - QUARTIC_END[0]).abs() < 1e-14, "{text} {level:?}: {}", end.t.hi);
        }
    }
}

/// Without a tolerance, which is the default, windows are exact beyond the digits of one number.
#[test]
fn without_a_tolerance_windows_are_exact_to_more_than_one_number() {
    let exact = Metric::<Extended>::new(Potential::quartic(0.5.into()), 1.0.into(), 1.0.into());
    let [t, x, t_dot, x_dot] = [0.0, 1.0, 1.0, 0.1].map(Extended::from);
    let reference = ReferenceTrajectory::new(&exact, &InitialData { t, x, t_dot, x_dot }, 10.0.into(), 40).unwrap();
    let there = reference.at(10.0.into());
    let off =
        |found: Twofold, exact: Extended| (Extended::from(found.hi) + Extended::from(found.lo) - exact).to_f64().abs();
    let (metric, rule) = (Metric::new(Potential::quartic(0.5), 1.0, 1.0), WeakRule::new(24));
    // Lengths of which twice is no number: rounded, each of the windows would be off by the same.
    let march = March::new(&metric, 2.0, &rule, Twofold::ONE / Twofold::from(10.0));
    let error = |march: March<'_>| {
        let end = march.run(base(), 100, &mut go_on).expect("it converges").end;
        off(end.x, there.x).max(off(end.t, there.elapsed))
    };
    assert_eq!(error(march), error(march.with_tolerance(1e-3).with_tolerance(0.0)));
    assert!(error(march) < 5e-18, "{:e}", error(march));
    assert!(error(march.with_tolerance(1e-15)) > 5e-17, "{:e}", error(march.with_tolerance(1e-15)));
}

/// A tolerance is relative to the size of x, also where functions are called and Newton's method is used.
#[test]
fn tolerances_are_relative_to_the_size_of_x() {
    for s in [1.0, 2.0_f64.powi(-12)] {
        let metric = Metric::new(formula(&format!("{:?}*(1 - cos(x/{s:?}))", s * s)), 1.0, 1.0);
        let initial = InitialData { t: 0.0, x: 0.9 * s, t_dot: 1.2, x_dot: 0.3 * s };
        let q_t = initial.invariants(&metric).q_t;
        let end = ReferenceTrajectory::new(&metric, &initial, 2.0, 16).expect("it gets there").at(2.0);
        let march = March::new(&metric, q_t, WeakRule::shared(24), Twofold::from(2.0 / 3.0));
        for tolerance in [1e-5, 1e-8, 1e-11] {
            let marched = march.with_tolerance(tolerance).run(initial.into(), 3, &mut go_on).expect("it converges");
            let error = (marched.end.x.hi - end.x).abs() / s;
            assert!(error < 10.0 * tolerance, "{s}, {tolerance:e}: {error:e}");
        }
    }
}

#[test]
fn polynomials_of_any_length_and_rest_at_zero() {
    let rule = WeakRule::new(12);
    let march = |potential, start| {
        let metric = Metric::new(potential, 1.0, 1.0);
        let marched = March::new(&metric, 2.0, &rule, 0.25.into()).run(start, 40, &mut go_on);
        (marched.expect("it converges").end, metric)
    };
    // Free motion is exact.
    let (end, _) = march(Potential::free(), base());
    let line = Twofold::from(0.1) * 10.0 + Twofold::ONE;
    assert!((end.x - line).hi.abs() < 1e-30 && end.t.hi == 20.0 && end.w == 0.1.into());
    let rest = State { x: 0.0.into(), w: 0.0.into(), ..base() };
    let long = vec![0.1, 0.02, 0.2, 0.0, 0.03, 0.05, 0.02, 0.001, 0.003];
    for degree in 1..long.len() {
        let coefficients = long[..=degree].to_vec();
        let (end, metric) = march(Potential::polynomial(coefficients.clone()), rest);
        // Zeros at the end do not count.
        let longer = [coefficients, vec![0.0; 3]].concat();
        assert_eq!(march(Potential::polynomial(longer), rest).0, end, "{degree}");
        let k = |s: &State| 4.0 / metric.at(s.x.hi).g00 - s.w.hi * s.w.hi;
        assert!((k(&end) - k(&rest)).abs() < 1e-14 && end.x.hi != 0.0);
    }
    // Backwards in time, and no motion in time at all.
    let metric = quartic();
    for q_t in [-2.0, 0.0] {
        let end = March::new(&metric, q_t, &rule, 0.25.into()).run(base(), 4, &mut go_on).expect("it converges").end;
        let expected = if q_t == 0.0 { [0.0, 1.1] } else { [-QUARTIC_END[0], QUARTIC_END[1]] };
        assert!((end.t.hi - expected[0]).abs() < 1e-12 && (end.x.hi - expected[1]).abs() < 1e-12, "{q_t}: {end:?}");
    }
}

#[test]
fn failures_say_what_and_where() {
    // g00 = 1 + 2x: the particle falls into the horizon at x = −1/2.
    let metric = Metric::new(Potential::linear(1.0), 1.0, 1.0);
    let rule = WeakRule::new(16);
    let start = State { t: 0.0.into(), x: 0.0.into(), w: 0.0.into() };
    let failure = March::new(&metric, 1.0, &rule, 0.0625.into()).run(start, 100, &mut go_on).unwrap_err();
    let MarchFailure::OutsideDomain { window, gamma, x, g00 } = failure else { panic!("{failure}") };
    let initial = InitialData { t: 0.0, x: 0.0, t_dot: 1.0, x_dot: 0.0 };
    let ends = ReferenceTrajectory::new(&metric, &initial, 10.0, 16).unwrap_err();
    assert!((gamma - ends.gamma).abs() < 0.0625, "{failure} against {ends}");
    assert!(window as f64 * 0.0625 <= gamma && x < -0.4 && g00.is_nan() | (g00 <= 0.0));
    // Ten units at once are too much for the quartic potential, which has no horizon.
    let failure = March::new(&quartic(), 2.0, &rule, 10.0.into()).run(base(), 3, &mut go_on).unwrap_err();
    assert!(matches!(failure, MarchFailure::NotConverged { window: 0, gamma: 0.0, x: 1.0 }), "{failure}");
}

#[test]
fn observers_see_windows_and_can_stop() {
    let (metric, rule) = (quartic(), WeakRule::new(16));
    let mut indices = vec![];
    let mut see = |view: &WindowView<'_>| {
        indices.push(view.index);
        assert_eq!(view.gamma.hi, 0.5 * view.index as f64);
        let (w, t) = (view.w(), view.t());
        assert!((w[15] - view.end.w.hi).abs() < 1e-14 && (t[15] - view.end.t.hi).abs() < 1e-13);
        assert!((view.x()[15] - view.end.x.hi).abs() < 1e-14);
        if view.index == 4 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let marched = March::new(&metric, 2.0, &rule, 0.5.into()).run(base(), 100, &mut see).expect("it converges");
    assert_eq!((marched.statistics.windows, indices), (5, vec![0, 1, 2, 3, 4]));
}

/// Largest error of t, x and w at 40 fractions of each of `windows` windows on [0, 1].
fn inside_error(n: usize, windows: usize, tolerance: f64) -> f64 {
    let metric = quartic();
    let State { t, x, w } = base();
    let initial = InitialData { t: t.hi, x: x.hi, t_dot: 1.0, x_dot: w.hi };
    let reference = ReferenceTrajectory::new(&metric, &initial, 1.0, 16).expect("it gets there");
    let fractions: Vec<f64> = (0..=40).map(|k| f64::from(k) / 40.0).collect();
    let length = Twofold::ONE / Twofold::from(windows as f64);
    let (mut points, mut largest) = (Vec::new(), 0.0_f64);
    let mut see = |view: &WindowView<'_>| {
        view.inside(fractions.iter().copied(), |point| points.push(point));
        assert_eq!(points.len(), fractions.len());
        assert_eq!(points[40].x, view.end.x.hi);
        let mut backwards = Vec::new();
        view.inside(fractions.iter().rev().copied(), |point| backwards.push(point));
        assert!(backwards.iter().rev().eq(&points), "the order does not matter");
        for (point, &fraction) in points.drain(..).zip(&fractions) {
            let exact = reference.at(view.gamma.hi + fraction * view.length.hi);
            for error in [point.t - exact.elapsed, point.x - exact.x, point.w - exact.x_dot] {
                largest = largest.max(error.abs());
            }
        }
        ControlFlow::Continue(())
    };
    let march = March::new(&metric, 2.0, WeakRule::shared(n), length).with_tolerance(tolerance);
    march.run(base(), windows, &mut see).expect("it converges");
    largest
}

#[test]
fn dense_output_is_of_order_n_plus_one_and_the_same_for_all_vectors_and_units() {
    for n in [4, 5, 6, 7] {
        let errors = [8, 16].map(|windows| inside_error(n, windows, 0.0));
        let order = (errors[0] / errors[1]).log2();
        assert!(order > n as f64 + 0.75, "{n} nodes: order {order}, {errors:?}");
    }
    for n in [12, 16, 20, 24, 32] {
        for tolerance in [0.0, 1e-16] {
            let error = inside_error(n, 4, tolerance);
            assert!(error < 1e-11_f64.powf(n as f64 / 12.0).max(2e-15), "{n} nodes: {error}");
        }
    }
}

#[test]
fn potentials_that_call_functions_take_few_evaluations_and_keep_their_tolerance() {
    let cases = [
        ("0.3*(1 - exp(-x))^2", 3),
        ("1 - cos(x)", 3),
        ("0.5*tanh(3*(x - 1.2))", 8),
        ("0.1*abs(x)^2.5 + 0.2*sqrt(1 + x^2)", 4),
        ("ln(2 + x) + 1/(3 + sin(x))", 2),
    ];
    let initial = InitialData { t: 0.0, x: 0.9, t_dot: 1.2, x_dot: 0.3 };
    for (expression, windows) in cases {
        let metric = Metric::new(formula(expression), 1.5, 1.0);
        let q_t = initial.invariants(&metric).q_t;
        let end = ReferenceTrajectory::new(&metric, &initial, 2.0, 16).expect("it gets there").at(2.0);
        let march = March::new(&metric, q_t, WeakRule::shared(24), Twofold::from(2.0) / Twofold::from(windows as f64));
        let start = State { t: 0.0.into(), x: 0.9.into(), w: 0.3.into() };
        for tolerance in [1e-5, 1e-8, 1e-11, 1e-14, 0.0] {
            let marched = march.with_tolerance(tolerance).run(start, windows, &mut go_on).expect("it converges");
            let error = (marched.end.x.hi - end.x).abs().max((marched.end.t.hi - end.elapsed).abs());
            let evaluations = marched.statistics.evaluations as f64 / windows as f64;
            assert!(error < 10.0 * tolerance + 3e-15, "{expression}, {tolerance}: error {error}");
            assert!(evaluations < if tolerance > 0.0 { 5.0 } else { 9.0 }, "{expression}: {evaluations} evaluations");
        }
    }
}

#[test]
fn padding_is_no_point_of_the_world_line() {
    // g00 is at least 1 on it, and would be negative at a mixture of values of exp(−x) and x from different nodes.
    let metric = Metric::new(formula("3*(exp(-x) - 1 + x)"), 1.0, 1.0);
    let initial = InitialData { t: 0.0, x: 0.0, t_dot: 1.0, x_dot: 0.3 };
    let q_t = initial.invariants(&metric).q_t;
    let exact = ReferenceTrajectory::new(&metric, &initial, 1.0, 16).expect("it gets there").at(1.0);
    for n in [15, 16, 19, 20, 23, 24] {
        for tolerance in [1e-15, 0.0] {
            let start = State { t: 0.0.into(), x: 0.0.into(), w: 0.3.into() };
            let march = March::new(&metric, q_t, WeakRule::shared(n), 1.0.into()).with_tolerance(tolerance);
            let end = march.run(start, 1, &mut go_on).unwrap_or_else(|failure| panic!("{n} nodes: {failure}")).end;
            assert!((end.x.hi - exact.x).abs() + (end.t.hi - exact.elapsed).abs() < 1e-14, "{n} nodes");
        }
    }
}

#[test]
fn slopes_do_not_trust_a_large_x_nor_a_steep_wall() {
    let far = 2000.0 * std::f64::consts::PI;
    for (expression, x, w, sign) in [
        ("1 - cos(x)", far + 0.9, 0.3, 1.0),
        ("1 - cos(x)", 0.9, 0.3, -1.0),
        ("0.2*tanh(40*(x - 1))", 0.8, 0.4, 1.0),
        ("1 - cos(x)", 0.0, 0.0, 1.0),
    ] {
        let metric = Metric::new(formula(expression), 1.0, 1.0);
        let initial = InitialData { t: 0.0, x, t_dot: sign, x_dot: w };
        let q_t = initial.invariants(&metric).q_t;
        let windows = if expression.contains("tanh") { 40 } else { 2 };
        let length = Twofold::from(2.0) / Twofold::from(windows as f64);
        let start = State { t: 0.0.into(), x: x.into(), w: w.into() };
        for level in [Level::Best, Level::Scalar] {
            let march = March::new(&metric, q_t, WeakRule::shared(20), length).with_level(level);
            let exact = march.run(start, windows, &mut go_on).expect("it converges").end;
            for tolerance in [1e-6, 1e-8, 1e-10] {
                let Marched { end, statistics } =
                    march.with_tolerance(tolerance).run(start, windows, &mut go_on).expect("it converges");
                let errors = [(end.x.hi - exact.x.hi).abs(), (end.t.hi - exact.t.hi).abs()];
                let bounds = [10.0 * tolerance * x.abs().max(1.0), 100.0 * tolerance];
                assert!(errors[0] < bounds[0] && errors[1] < bounds[1], "{expression} at {x}, {tolerance}: {errors:?}");
                assert!(statistics.evaluations <= 6 * windows, "{expression} at {x}: {statistics:?}");
            }
            let same = march.with_tolerance(1e-8).run(start, 0, &mut go_on).expect("nothing to do").end;
            assert!(same.w.hi == w && same.w.lo.abs() < 1e-31);
        }
    }
}

#[test]
fn the_derivative_of_a_rule_is_the_inverse_of_a() {
    for n in [2, 3, 8, 20, 33, 64] {
        let rule = WeakRule::new(n);
        for i in 0..n {
            for j in 0..n {
                let entry = sum((0..n).map(|k| rule.derivative(i, k) * rule.a()[k * n + j]));
                let expected = if i == j { Twofold::ONE } else { Twofold::ZERO };
                assert!((entry - expected).hi.abs() < 1e-30 * (n * n) as f64, "{n}, {i}, {j}: {entry:?}");
            }
        }
    }
}
