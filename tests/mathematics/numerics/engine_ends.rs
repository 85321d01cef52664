//! Where runs of the engine of few nodes to an accuracy come to, and where they do not.

use std::ops::ControlFlow;

use geodesic_ivp::engine::{Accuracy, Engine, Failure};
use geodesic_ivp::geometry::{Geometry, Start};

use crate::common::{QUARTIC_POTENTIAL, geometry, newtonian, one, start};

/// The end of a run, or where it fails.
fn end(mut engine: Engine<'_>) -> (Result<(), Failure>, f64, Vec<f64>) {
    let run = engine.run(|_| ControlFlow::Continue(()));
    let (gamma, q) = engine.place();
    (run, gamma, q)
}

/// Returns the end of a run to a value of t.
fn to_time((geometry, start): &(Geometry, Start), t: f64, accuracy: f64) -> (Result<(), Failure>, f64, Vec<f64>) {
    end(Engine::accurate_to_value(geometry, start, (0, t), Accuracy::Promised(accuracy)).unwrap())
}

/// Returns the end of a run over a length.
fn to_gamma((geometry, start): &(Geometry, Start), length: f64, accuracy: f64) -> (Result<(), Failure>, f64, Vec<f64>) {
    end(Engine::accurate(geometry, start, length, Accuracy::Promised(accuracy)).unwrap())
}

/// A time is reached from a window that also reaches a horizon beyond it.
#[test]
fn an_end_time_just_before_a_horizon_is_reached() {
    let fall = one("x", 1.0, [0.0, 1.0, 0.0]);
    // The cycloid of section 1: t runs to π/2 at the horizon.
    for t in [0.3, 1.0, 1.5, 1.57] {
        let (run, _, q) = to_time(&fall, t, 1e-8);
        assert_eq!((run, q[0]), (Ok(()), t));
        assert!((q[1] - 0.5 * (t.cos().powi(2) - 1.0)).abs() < 1e-8, "{t}: {}", q[1]);
    }
    for t in [1.6, -1.0] {
        let (run, ..) = to_time(&fall, t, 1e-8);
        assert!(matches!(run, Err(Failure::OutsideDomain(_) | Failure::ValueNotReached)), "{t}: {run:?}");
    }
}

/// Where t does not move, a horizon is passed without a force; behind it is outside the domain.
#[test]
fn a_horizon_ends_free_motion() {
    let (geometry, mut start) = one("x", 1.0, [0.0, 0.0, -1.0]);
    for x in [0.0, 2.0] {
        start.q[1] = x;
        for accuracy in [1e-4, 1e-10] {
            let (run, gamma, q) = to_gamma(&(geometry.clone(), start.clone()), 5.0, accuracy);
            assert!(matches!(run, Err(Failure::OutsideDomain(_))), "{x} {accuracy:e}: {run:?}");
            assert!((gamma - 0.5 - x).abs() < 0.01 && (q[1] + 0.5).abs() < 0.01, "{x} {accuracy:e}: {gamma}, {q:?}");
        }
    }
}

/// With g00 = 1 + x² and dt/dγ = 1, dx/dγ = 2 at the start, t ends at half of the complete elliptic integral K of the
/// parameter 1/4.
#[test]
fn a_time_that_never_comes_is_told_of() {
    let whole = 0.5 * 1.685_750_354_812_596;
    for (t_dot, x_dot, accuracy) in [(1.0, 2.0, 1e-6), (1.0, -2.0, 1e-9), (-1.0, 2.0, 1e-12)] {
        let flight = one("x^2/2", 1.0, [0.0, t_dot, x_dot]);
        assert_eq!(to_time(&flight, 0.99 * whole * t_dot, accuracy).0, Ok(()));
        let (run, gamma, q) = to_time(&flight, 1.5 * whole * t_dot, accuracy);
        assert_eq!(run, Err(Failure::ValueNotReached), "{t_dot} {x_dot}");
        assert!(gamma > 1e6 && (whole - q[0] * t_dot).abs() < accuracy, "{gamma:e}, {}", q[0]);
    }
}

/// At rest at x = 0, t grows by as little as dt/dγ says.
#[test]
fn what_takes_long_is_reached() {
    for potential in ["0", "x^2/2"] {
        for (t_dot, t) in [(1e-60, 1.0), (1e-120, 1.0), (1e-60, 1e20), (-1e-120, -1.0)] {
            let (run, gamma, q) = to_time(&one(potential, 1.0, [0.0, t_dot, 0.0]), t, 1e-6);
            assert_eq!((run, q[0]), (Ok(()), t), "{t_dot:e}");
            assert!((gamma * t_dot / t - 1.0).abs() < 1e-12, "{t_dot:e}: {gamma:e}");
        }
    }
}

/// Lengths and accuracies beyond reason end somehow, and never by a wrong result. Who reads that an accuracy is not
/// reached reads for which one rounding leaves room: for one that is lower.
#[test]
fn extremes_end() {
    let (geometry, start) = one(QUARTIC_POTENTIAL, 1.0, [1.0, 1.0, 0.1]);
    let runs = [(1e-300, 1e-6), (1e-8, 1e-13), (50.0, 1e-15), (50.0, 1e-16), (5.0, 1.0)];
    for (length, accuracy) in runs.into_iter().chain([1e-13, 1e-14, 1e-15, 1e-16, 1e-17].map(|a| (100.0, a))) {
        let mut engine = Engine::accurate(&geometry, &start, length, Accuracy::Promised(accuracy)).unwrap();
        match engine.run(|_| ControlFlow::Continue(())) {
            Ok(()) => assert!(engine.error_estimate().unwrap() <= accuracy && engine.place().0 == length),
            Err(failure) => {
                let room = engine.reachable().unwrap();
                let is_high = accuracy < 1e-13 || length == 100.0;
                assert!(
                    failure == Failure::Accuracy && is_high && room > accuracy,
                    "{accuracy:e}: {failure:?}, {room:e}"
                );
            }
        }
    }
    // A free particle needs two windows at most, whatever the length.
    let (geometry, start) = one("0", 1.0, [1.0, 1.0, 0.1]);
    let mut engine = Engine::accurate(&geometry, &start, 1e8, Accuracy::Promised(1e-12)).unwrap();
    let mut windows = 0;
    let run = engine.run(|window| {
        windows = window.index + 1;
        ControlFlow::Continue(())
    });
    assert!(run.is_ok() && engine.place().1[0] == 1e8 && windows < 3, "{windows}");
}

/// In a stiff valley the forces of small errors are large: where sweeps converge slowly, what they leave has one sign
/// in every window, and so has the error of s, in which oscillations are twice as fast.
#[test]
fn the_ends_of_windows_in_a_stiff_valley_add_up_to_no_more_than_the_accuracy() {
    let first = "6621241.231209457*(y + 0.47870439296038314*x^2 + 0.42339634668689363*sin(x))^2 + x^2/2";
    let second = "27081774.609244987*(y - 0.4037425822335793*x^2 + 0.0753574616417998*sin(x))^2 + x^2/2";
    let scenes = [
        (first, [-0.7007780022870009, 0.03795190548103064], 0.8032548448093868, 0.24471713765569633, 1.9e-10),
        (second, [0.9911177144429043, 0.33356873803625214], 0.5366371734429103, 0.07443578584186492, 5.1e-10),
    ];
    for (potential, [x, y], speed, length, accuracy) in scenes {
        let geometry = geometry(&newtonian(&["x", "y"], potential));
        let begin = start(&geometry, &[0.0, x, y, 0.0], &[1.0, speed, 0.0, 0.0]);
        let [found, known] = [Accuracy::Promised(accuracy), Accuracy::Local(1e-15)].map(|wanted| {
            let mut engine = Engine::accurate(&geometry, &begin, length, wanted).unwrap();
            engine.run(|_| ControlFlow::Continue(())).unwrap();
            (engine.place().1, engine.sizes())
        });
        for (a, known) in known.0.iter().enumerate() {
            let error = (found.0[a] - known).abs() / found.1[a];
            assert!(error <= accuracy, "{potential}: coordinate {a}, {error:e}");
        }
    }
}
