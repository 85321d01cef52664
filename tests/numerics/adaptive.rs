//! Adaptive marches keep the accuracy that they promise.

use std::ops::ControlFlow;

use geodesic_ivp::Case;
use geodesic_ivp::geodesic::InitialData;
use geodesic_ivp::lobatto::{Adaptive, Goal, MarchFailure, State, WindowView};
use geodesic_ivp::metric::Metric;
use geodesic_ivp::potential::Potential;
use geodesic_ivp::reference::ReferenceTrajectory;

fn shipped(text: &str) -> (Metric, InitialData) {
    let case = Case::parse("test", text, &[]).unwrap_or_else(|error| panic!("{error}"));
    (case.metric(), case.initial_data())
}

fn quartic() -> (Metric, InitialData) {
    shipped(include_str!("../../cases/quartic.toml"))
}

fn go_on(_: &WindowView<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Marches and returns the largest true error at ends and in between, and the estimate.
fn measure(name: &str, (metric, initial): &(Metric, InitialData), length: f64, accuracy: f64) -> [f64; 2] {
    let reference = ReferenceTrajectory::new(metric, *initial, length, 16).expect("it exists");
    let q_t = initial.invariants(metric).q_t;
    let (mut points, mut sizes) = (vec![], [1.0_f64; 2]);
    let mut see = |view: &WindowView<'_>| {
        if view.index == 0 {
            points.clear();
        }
        let dense = view.dense();
        for s in [0.21, 0.5, 0.83] {
            points.push((view.gamma.hi + s * view.length.hi, dense.at(s).t, dense.at(s).x));
        }
        points.push(((view.gamma + view.length).hi, view.end.t.hi, view.end.x.hi));
        ControlFlow::Continue(())
    };
    let march = Adaptive::new(metric, q_t);
    let adapted = march.run((*initial).into(), Goal::Gamma(length), accuracy, &mut see);
    let adapted = adapted.unwrap_or_else(|error| panic!("{name} {accuracy:e}: {error}"));
    let mut errors = [0.0_f64; 2];
    for (gamma, t, x) in points {
        let exact = reference.at(gamma.min(length));
        sizes = [sizes[0].max(exact.elapsed.abs()), sizes[1].max(exact.x.abs())];
        errors[0] = errors[0].max((t - initial.t - exact.elapsed).abs());
        errors[1] = errors[1].max((x - exact.x).abs());
    }
    let error = (errors[0] / sizes[0]).max(errors[1] / sizes[1]);
    let estimate = adapted.error_estimate;
    println!(
        "{name} {length} {accuracy:.0e}: error {error:.1e}, estimate {estimate:.1e}, {} windows, {} evaluations, {} attempts",
        adapted.statistics.windows, adapted.statistics.evaluations, adapted.attempts
    );
    assert!((adapted.gamma.hi - length).abs() <= 1e-15 * length);
    let slack = 2e-14 + reference.error_estimate();
    assert!(error <= accuracy + slack && estimate <= accuracy, "{name} {accuracy:e}: {error:e}, {estimate:e}");
    assert!(error <= estimate + slack, "{name} {accuracy:e}: {error:e} is more than {estimate:e}");
    [error, estimate]
}

#[test]
fn accuracies_are_kept_on_every_kind_of_potential() {
    let cases = [
        ("quartic", quartic(), 20.0),
        ("pendulum", shipped(include_str!("../../cases/pendulum.toml")), 10.0),
        ("morse", shipped(include_str!("../../cases/morse.toml")), 6.0),
        ("double well", shipped(include_str!("../../cases/double-well.toml")), 5.0),
    ];
    for (name, case, length) in &cases {
        for digits in 2..=6 {
            measure(name, case, *length, 10.0_f64.powi(-2 * digits));
        }
    }
}

#[test]
fn accuracies_are_kept_over_a_thousand_units() {
    for accuracy in [1e-4, 1e-8, 1e-10] {
        measure("quartic", &quartic(), 1000.0, accuracy);
    }
}

#[test]
fn the_end_time_is_hit_to_rounding() {
    let (metric, initial) = shipped(include_str!("../../cases/pendulum.toml"));
    let q_t = initial.invariants(&metric).q_t;
    let length = ReferenceTrajectory::length_of(&metric, initial, 10.0, 16).expect("it exists");
    let exact = ReferenceTrajectory::new(&metric, initial, length, 16).expect("it exists").at(length);
    for accuracy in [1e-5, 1e-11] {
        let adapted = Adaptive::new(&metric, q_t).run(initial.into(), Goal::Time(10.0), accuracy, &mut go_on);
        let adapted = adapted.unwrap_or_else(|error| panic!("{error}"));
        assert!((adapted.end.t.hi - 10.0).abs() <= 2e-15, "{}", adapted.end.t.hi);
        assert!((adapted.end.x.hi - exact.x).abs() < accuracy && (adapted.gamma.hi - length).abs() < accuracy);
    }
}

#[test]
fn what_cannot_be_done_fails() {
    let (metric, initial) = quartic();
    let march = Adaptive::new(&metric, 2.0);
    let failure = march.run(initial.into(), Goal::Gamma(100.0), 1e-17, &mut go_on).unwrap_err();
    assert!(matches!(failure, MarchFailure::AccuracyNotReached { estimate, .. } if estimate > 1e-17), "{failure}");
    // The horizon of cases/horizon.toml's kind: g00 = 1 + 2x.
    let metric = Metric::new(Potential::linear(1.0), 1.0, 1.0);
    let start = State { t: 0.0.into(), x: 0.0.into(), w: 0.0.into() };
    let failure = Adaptive::new(&metric, 1.0).run(start, Goal::Gamma(10.0), 1e-8, &mut go_on).unwrap_err();
    let initial = InitialData { t: 0.0, x: 0.0, t_dot: 1.0, x_dot: 0.0 };
    let ends = ReferenceTrajectory::new(&metric, initial, 10.0, 16).unwrap_err();
    let MarchFailure::OutsideDomain { gamma, x, .. } = failure else { panic!("{failure}") };
    assert!((gamma - ends.gamma).abs() < 1e-3 && (x + 0.5).abs() < 1e-2, "{failure} against {ends}");
    // A time that lies behind.
    let failure = Adaptive::new(&metric, 1.0).run(start, Goal::Time(-1.0), 1e-8, &mut go_on).unwrap_err();
    assert!(matches!(failure, MarchFailure::TimeNotReached { .. }), "{failure}");
}

#[test]
fn a_kink_is_met_with_short_windows() {
    let case = shipped(
        "potential.formula = { expression = \"0.05*abs(x)\" }\ninitial = { t = 0.0, x = 1.0, t_dot = 1.0, x_dot = -0.5 }\n\
         grid.n_gamma = 32\nscheme.sbp = \"SBP21\"",
    );
    for accuracy in [1e-4, 1e-7] {
        measure("kink", &case, 8.0, accuracy);
    }
}
