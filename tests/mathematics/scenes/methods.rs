//! The methods to compare with, in scenes: their orders against the reference.

use std::sync::Arc;

use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::methods::{
    Dop853, Failure, Gauss, Output, PEERS, Peer, Problem, Radau5, Rk4, Setting, State, Step, Taylor, Trajectory,
};
use geodesic_ivp::reference::ReferenceTrajectory;

use crate::common::{geometry, newtonian, newtonian_start, of_potential, preset, start};

fn problem(geometry: Geometry, start: Start, length: f64) -> Problem {
    let geometry = Arc::new(geometry.around(&start.q).unwrap());
    Problem { space: geometry, start, length, g00: None }
}

/// Two active coordinates, separable.
fn henon_heiles() -> Problem {
    let geometry = of_potential(&newtonian(&["x", "y"], "(x^2 + y^2)/2 + x^2*y - y^3/3"));
    let start = newtonian_start(&geometry, &[0.1, 0.3], &[0.4, 0.0]);
    problem(geometry, start, 10.0)
}

/// One active coordinate of three.
fn schwarzschild() -> Problem {
    let geometry = geometry(&preset("schwarzschild", &[]));
    let start = start(&geometry, &[0.0, 10.0, 0.0], &[1.2, -0.05, 0.03]);
    problem(geometry, start, 40.0)
}

/// Two active coordinates of four, and an off-diagonal component.
fn kerr() -> Problem {
    let geometry = geometry(&preset("kerr", &[("a", "0.9")]));
    let start = start(&geometry, &[0.0, 10.0, 1.4, 0.0], &[1.25, -0.05, 0.01, 0.035]);
    problem(geometry, start, 40.0)
}

/// Largest error of a coordinate or momentum at the points of the output.
fn error(problem: &Problem, output: &Output, trajectory: &Trajectory) -> f64 {
    let reference = ReferenceTrajectory::new(&*problem.space, &problem.start, problem.length, 16).unwrap();
    assert_eq!(trajectory.states.len(), output.marks.len());
    let mut largest = 0.0;
    for (gamma, state) in output.gamma(problem.length).zip(trajectory.states.iter()) {
        let exact = reference.at(gamma);
        for (found, exact) in state.q.iter().chain(state.p).zip(exact.q.iter().chain(&exact.p)) {
            let error = (found - exact).abs();
            largest = if error <= largest { largest } else { error };
        }
    }
    largest
}

/// The numbers of steps per interval between which the errors show the order of a method of constant steps, and the
/// least slope that shows it.
fn expected(peer: &dyn Peer) -> ([usize; 2], f64) {
    match peer.name().as_str() {
        "RK4" => ([32, 64], 3.8),
        "Verlet" => ([64, 128], 1.95),
        "Kahan-Li 6" => ([8, 16], 5.8),
        "Kahan-Li 8" | "Kahan-Li 8 compensated" => ([4, 8], 7.6),
        "Gauss 2" => ([32, 64], 3.9),
        "Gauss 4" => ([4, 8], 7.0),
        "Gauss 6" => ([2, 4], 8.9),
        // Not asymptotic before rounding.
        "Gauss 8" => ([1, 2], 9.5),
        "Gauss 12" => ([1, 2], 9.0),
        name => panic!("what is expected of {name}?"),
    }
}

#[test]
fn every_method_of_constant_steps_has_its_order() {
    let output = Output::even(5);
    for problem in [henon_heiles(), schwarzschild(), kerr()] {
        for peer in PEERS.into_iter().filter(|peer| peer.about().step != Step::Adaptive) {
            if peer.about().needs_second_order && !problem.space.is_separable() {
                let refused = peer.run(&problem, &output, Setting::steps(5));
                assert_eq!(refused, Err(Failure::NotSeparable), "{peer:?}");
                continue;
            }
            let (steps, least) = expected(peer);
            let errors = steps.map(|n| {
                let trajectory = peer.run(&problem, &output, Setting::steps(n * output.intervals)).unwrap();
                error(&problem, &output, &trajectory)
            });
            let slope = (errors[0] / errors[1]).ln() / (steps[1] as f64 / steps[0] as f64).ln();
            assert!(slope > least || errors[1] < 3e-14, "{peer:?}: order {slope}, errors {errors:?}");
            assert!(errors[1] < 3e-4, "{peer:?}: {errors:?}");
        }
    }
}

#[test]
fn every_adaptive_method_follows_its_tolerance() {
    let output = Output::even(5);
    for problem in [henon_heiles(), schwarzschild(), kerr()] {
        let order_8 = [1e-6, 1e-12].map(|tolerance| {
            let trajectory = Dop853.run(&problem, &output, Setting::tolerance(tolerance)).unwrap();
            (error(&problem, &output, &trajectory), trajectory.evaluations as f64)
        });
        assert!(order_8[0].0 < 3e-5 && order_8[1].0 < 3e-11, "{order_8:?}");
        let order = (order_8[0].0 / order_8[1].0).ln() / (order_8[1].1 / order_8[0].1).ln();
        assert!(order > 6.5, "DOP853: order {order}, {order_8:?}");
        let order_5 = [1e-6, 1e-10].map(|tolerance| {
            let trajectory = Radau5.run(&problem, &output, Setting::tolerance(tolerance)).unwrap();
            (error(&problem, &output, &trajectory), trajectory.steps as f64)
        });
        assert!(order_5[0].0 < 1e-6 && order_5[1].0 < 1e-11, "{order_5:?}");
        let order = (order_5[0].0 / order_5[1].0).ln() / (order_5[1].1 / order_5[0].1).ln();
        assert!((4.4..8.0).contains(&order), "Radau: order {order}, {order_5:?}");
        for tolerance in [1e-6, 1e-12] {
            let trajectory = Taylor.run(&problem, &output, Setting::tolerance(tolerance)).unwrap();
            let error = error(&problem, &output, &trajectory);
            assert!(error < 100.0 * tolerance, "Taylor: {error} with {tolerance}");
        }
    }
}

#[test]
fn dense_output_has_its_order() {
    // The order of the cubic is 4, and that of Gauss is s + 1; more than eight points are in a step.
    let output = Output::even(97);
    for problem in [henon_heiles(), schwarzschild(), kerr()] {
        for (peer, least, steps, bound) in [
            (&Rk4 as &dyn Peer, 3.6, [80, 160], 1e-3),
            (&Gauss { stages: 2 }, 2.8, [80, 160], 1e-3),
            (&Gauss { stages: 4 }, 4.6, [40, 80], 1e-3),
        ] {
            let errors =
                steps.map(|n| error(&problem, &output, &peer.run(&problem, &output, Setting::steps(n)).unwrap()));
            let slope = (errors[0] / errors[1]).log2();
            assert!(slope > least && errors[1] < bound, "{peer:?}: order {slope}, errors {errors:?}");
        }
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let [ends, all] = [1, 97].map(|points| {
                let output = Output::even(points);
                error(&problem, &output, &Dop853.run(&problem, &output, Setting::tolerance(tolerance)).unwrap())
            });
            assert!(all < 10.0 * ends + 100.0 * tolerance, "{tolerance}: {all} inside, {ends} at the end");
        }
    }
}

#[test]
fn charges_are_parameters_and_the_rest_of_a_state_is_consistent() {
    for problem in [henon_heiles(), schwarzschild(), kerr()] {
        let geometry = &problem.space;
        let output = Output { intervals: 4, marks: vec![0, 1, 4] };
        let states = Dop853.run(&problem, &output, Setting::tolerance(1e-13)).unwrap().states;
        assert_eq!(states.at(0), State { q: &problem.start.q, p: &problem.start.p });
        let norm = |state: State<'_>| geometry.norm(state.q, &geometry.velocities(state.q, state.p).unwrap());
        let at_start = norm(states.at(0));
        for state in states.iter() {
            assert!(geometry.ignorable().all(|a| state.p[a] == problem.start.p[a]));
            // The norm is wrong if the momenta do not belong to the velocities.
            assert!((norm(state) - at_start).abs() < 1e-11);
        }
    }
}

#[test]
fn a_horizon_ends_every_method() {
    let geometry = geometry(&preset("schwarzschild", &[]));
    let start = start(&geometry, &[0.0, 3.0, 0.0], &[3.0, -1.0, 0.0]);
    let problem = problem(geometry, start, 20.0);
    let output = Output::even(5);
    for peer in PEERS.into_iter().filter(|peer| !peer.about().needs_second_order) {
        let setting = match peer.about().step {
            Step::Adaptive => Setting::tolerance(1e-8),
            _ => Setting::steps(500),
        };
        let failure = peer.run(&problem, &output, setting).unwrap_err();
        let ends = [Failure::OutsideDomain, Failure::TooManySteps, Failure::Diverged, Failure::NotConverged];
        assert!(ends.contains(&failure), "{peer:?}: {failure}");
    }
}
