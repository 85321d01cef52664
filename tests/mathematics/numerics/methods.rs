//! The methods to compare with: their orders against the reference, and what they do to K.

use geodesic_ivp::methods::{
    Composition, Dop853, Failure, Gauss, Output, PEERS, Peer, Problem, Radau5, Rk4, Setting, Step, Taylor, Trajectory,
};
use geodesic_ivp::reference::ReferenceTrajectory;

use crate::common::{QUARTIC_POTENTIAL, norm_of, one, polynomial};

/// With the coefficients of g00, if it is to be evaluated as a polynomial.
fn problem(expression: &str, c: f64, start: [f64; 3], length: f64, g00: Option<Vec<f64>>) -> Problem {
    let (geometry, start) = one(expression, c, start);
    Problem { space: geometry.into(), start, length, g00 }
}

fn quartic(length: f64) -> Problem {
    problem(QUARTIC_POTENTIAL, 1.0, [1.0, 1.0, 0.1], length, Some(vec![1.0, 0.0, 0.0, 0.0, 1.0]))
}

/// A formula, and a polynomial of a degree that is evaluated otherwise.
fn others(length: f64) -> [Problem; 2] {
    let coefficients = [0.0, 0.1, 0.3, 0.0, 0.1, 0.0, 0.02];
    let mut g00: Vec<f64> = coefficients.iter().map(|c| 2.0 * c).collect();
    g00[0] += 4.0;
    let start = [1.0, 1.0, 0.1];
    [
        problem("0.3*(1 - exp(-x))^2", 2.0, start, length, None),
        problem(&polynomial(&coefficients), 2.0, start, length, Some(g00)),
    ]
}

/// Largest error of t and x at the points of the output.
fn error(problem: &Problem, output: &Output, trajectory: &Trajectory) -> f64 {
    let reference = ReferenceTrajectory::new(&*problem.space, &problem.start, problem.length, 16).unwrap();
    assert_eq!(trajectory.states.len(), output.marks.len());
    let errors = output.gamma(problem.length).zip(trajectory.states.iter()).map(|(gamma, state)| {
        let exact = reference.at(gamma);
        (state.q[0] - exact.q[0]).abs().max((state.q[1] - exact.q[1]).abs()).max((-state.p[1] - exact.q_dot[1]).abs())
    });
    errors.fold(0.0, f64::max)
}

fn delta_k(problem: &Problem, trajectory: &Trajectory) -> Vec<f64> {
    let norm = norm_of(&problem.space, &problem.start);
    let k = |q: &[f64], p: &[f64]| problem.space.norm(q, &problem.space.velocities(q, p).unwrap());
    trajectory.states.iter().map(|state| (k(state.q, state.p) - norm).abs()).collect()
}

/// The numbers of steps per interval between which the errors show the order of a method of constant steps, the least
/// slope that shows it, and a bound for the error at the second of them.
fn expected(peer: &dyn Peer) -> ([usize; 2], f64, f64) {
    match peer.name().as_str() {
        "RK4" => ([20, 40], 3.4, 1e-6),
        "Verlet" => ([100, 200], 1.9, 1e-4),
        "Kahan-Li 6" => ([8, 16], 5.4, 2e-7),
        "Kahan-Li 8" | "Kahan-Li 8 compensated" => ([8, 12], 7.4, 5e-9),
        "Gauss 2" => ([20, 40], 3.4, 1e-6),
        "Gauss 4" => ([8, 12], 7.4, 1e-9),
        "Gauss 6" => ([3, 4], 11.4, 1e-9),
        // Not asymptotic before rounding, but above the one before it.
        "Gauss 8" => ([1, 2], 10.0, 1e-7),
        "Gauss 12" => ([1, 2], 10.0, 1e-10),
        name => panic!("what is expected of {name}?"),
    }
}

#[test]
fn every_method_of_constant_steps_has_its_order() {
    let output = Output::even(5);
    for problem in [&quartic(5.0), &others(5.0)[0], &others(5.0)[1]] {
        for peer in PEERS.into_iter().filter(|peer| peer.about().step != Step::Adaptive) {
            let (steps, least, bound) = expected(peer);
            let errors = steps.map(|n| {
                let trajectory = peer.run(problem, &output, Setting::steps(n * output.intervals)).unwrap();
                error(problem, &output, &trajectory)
            });
            let slope = (errors[0] / errors[1]).ln() / (steps[1] as f64 / steps[0] as f64).ln();
            // Where the potential is smoother than the quartic one, the highest orders leave only rounding.
            assert!(slope > least || errors[1] < 1e-14, "{peer:?}: order {slope}, errors {errors:?}");
            assert!(errors[1] < bound, "{peer:?}: {errors:?}");
        }
    }
}

#[test]
fn every_adaptive_method_follows_its_tolerance() {
    let output = Output::even(5);
    for problem in [&quartic(5.0), &others(5.0)[0], &others(5.0)[1]] {
        let order_8 = [1e-6, 1e-9, 1e-12].map(|tolerance| {
            let trajectory = Dop853.run(problem, &output, Setting::tolerance(tolerance)).unwrap();
            (error(problem, &output, &trajectory), trajectory.evaluations as f64)
        });
        assert!(order_8.iter().zip([2e-5, 2e-8, 2e-11]).all(|((error, _), bound)| *error < bound), "{order_8:?}");
        let work = (order_8[2].1 / order_8[1].1).ln() / (order_8[1].0 / order_8[2].0).ln();
        assert!(1.0 / work > 6.5, "DOP853: order {}", 1.0 / work);
        let order_5 = [1e-5, 1e-10].map(|tolerance| {
            let trajectory = Radau5.run(problem, &output, Setting::tolerance(tolerance)).unwrap();
            (error(problem, &output, &trajectory), trajectory.steps as f64)
        });
        assert!(order_5[0].0 < 1e-4 && order_5[1].0 < 1e-10, "{order_5:?}");
        let order = (order_5[0].0 / order_5[1].0).ln() / (order_5[1].1 / order_5[0].1).ln();
        assert!((4.4..6.0).contains(&order), "Radau: order {order}, {order_5:?}");
        for tolerance in [1e-6, 1e-15] {
            let trajectory = Taylor.run(problem, &output, Setting::tolerance(tolerance)).unwrap();
            let error = error(problem, &output, &trajectory);
            assert!(error < 10.0 * tolerance, "Taylor: {error} with {tolerance}");
        }
    }
}

#[test]
fn symplectic_methods_keep_k_bounded_and_runge_kutta_lets_it_drift() {
    let problem = quartic(1000.0);
    let output = Output::even(1000);
    let late_to_early = |trajectory: Trajectory| {
        let delta = delta_k(&problem, &trajectory);
        let largest = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
        largest(&delta[900..]) / largest(&delta[..100])
    };
    for composition in [Composition::VERLET, Composition::KAHAN_LI_6, Composition::KAHAN_LI_8] {
        let growth = late_to_early(
            composition.run(&problem, &output, Setting::steps(1000 * (180 / composition.stages()))).unwrap(),
        );
        assert!(growth < 1.2, "{composition:?}: {growth}");
    }
    let growth = late_to_early(Gauss { stages: 4 }.run(&problem, &output, Setting::steps(2000)).unwrap());
    assert!(growth < 1.2, "{growth}");
    let growth = late_to_early(Rk4.run(&problem, &output, Setting::steps(20_000)).unwrap());
    assert!(growth > 5.0, "{growth}");
    let growth = late_to_early(Dop853.run(&problem, &output, Setting::tolerance(1e-8)).unwrap());
    assert!(growth > 5.0, "{growth}");
}

#[test]
fn failures_are_told_apart() {
    let problem = problem("-0.5*x", 1.0, [0.0, 1.0, 0.0], 5.0, Some(vec![1.0, -1.0]));
    let output = Output::even(5);
    for failure in [
        Rk4.run(&problem, &output, Setting::steps(500)).unwrap_err(),
        Dop853.run(&problem, &output, Setting::tolerance(1e-8)).unwrap_err(),
        Taylor.run(&problem, &output, Setting::tolerance(1e-14)).unwrap_err(),
    ] {
        assert!([Failure::OutsideDomain, Failure::TooManySteps, Failure::Diverged].contains(&failure), "{failure}");
    }
    let gauss = Gauss { stages: 8 };
    assert_eq!(gauss.run(&quartic(1000.0), &output, Setting::steps(5)).unwrap_err(), Failure::NotConverged);
}

#[test]
fn output_need_not_be_even() {
    let problem = quartic(10.0);
    // The start, and a point that is asked for twice.
    let output = Output { intervals: 100, marks: vec![0, 1, 2, 7, 7, 50, 100] };
    for peer in PEERS {
        let about = peer.about();
        let (setting, bound) = match about.step {
            Step::Adaptive if about.order == Some(5) => (Setting::tolerance(1e-11), 1e-9),
            Step::Adaptive => (Setting::tolerance(1e-13), 1e-11),
            _ if about.order >= Some(8) => (Setting::steps(400), 1e-11),
            _ => (Setting::steps(10_000), 1e-5),
        };
        let trajectory = peer.run(&problem, &output, setting).unwrap();
        assert_eq!(trajectory.states.len(), output.marks.len(), "{peer:?}");
        assert_eq!(trajectory.states.at(3), trajectory.states.at(4), "{peer:?}");
        let error = error(&problem, &output, &trajectory);
        assert!(error < bound, "{peer:?}: {error}");
    }
}

#[test]
fn dense_output_has_its_order() {
    // The order of t and w, and so of the largest error, is 4 for the cubic and s + 1 for Gauss.
    let cases: [(&dyn Peer, f64, [usize; 2], f64); 4] = [
        (&Rk4, 3.6, [40, 80], 3e-5),
        (&Gauss { stages: 2 }, 2.8, [40, 80], 1e-4),
        (&Gauss { stages: 4 }, 4.7, [20, 40], 2e-6),
        (&Gauss { stages: 6 }, 6.0, [10, 20], 2e-6),
    ];
    let output = Output::even(97);
    for (peer, least, steps, bound) in cases {
        for problem in [&quartic(5.0), &others(5.0)[0]] {
            let errors =
                steps.map(|n| error(problem, &output, &peer.run(problem, &output, Setting::steps(n)).unwrap()));
            let slope = (errors[0] / errors[1]).log2();
            assert!(slope > least && errors[1] < bound, "{}: order {slope}, errors {errors:?}", peer.name());
        }
    }
    // The dense output of DOP853 is about as accurate as the ends of its steps.
    let problem = quartic(5.0);
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let [ends, all] = [1, 97].map(|points| {
            let output = Output::even(points);
            error(&problem, &output, &Dop853.run(&problem, &output, Setting::tolerance(tolerance)).unwrap())
        });
        assert!(all < 3.0 * ends + 30.0 * tolerance, "{tolerance}: {all} inside, {ends} at the end");
    }
}
