//! The methods to compare with, in one coordinate and in scenes: their errors against the reference, and what they do
//! to K.

use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::methods::{Failure, Output, PEERS, Peer, Problem, Setting, State, Step, Trajectory};

use crate::common::{
    QUARTIC_POTENTIAL, geometry, newtonian, newtonian_start, norm_of, one, polynomial, preset, reference, start,
};

/// A potential of one coordinate, with the coefficients of g00 if it is to be evaluated as a polynomial.
fn potential(expression: &str, c: f64, start: [f64; 3], length: f64, g00: Option<Vec<f64>>) -> Problem {
    let (geometry, start) = one(expression, c, start);
    Problem { space: geometry.into(), start, length, g00 }
}

fn quartic(length: f64) -> Problem {
    potential(QUARTIC_POTENTIAL, 1.0, [1.0, 1.0, 0.1], length, Some(vec![1.0, 0.0, 0.0, 0.0, 1.0]))
}

/// The quartic one, a formula, and a polynomial of a degree that is evaluated otherwise.
fn potentials() -> [Problem; 3] {
    let coefficients = [0.0, 0.1, 0.3, 0.0, 0.1, 0.0, 0.02];
    let mut g00: Vec<f64> = coefficients.iter().map(|c| 2.0 * c).collect();
    g00[0] += 4.0;
    let start = [1.0, 1.0, 0.1];
    [
        quartic(5.0),
        potential("0.3*(1 - exp(-x))^2", 2.0, start, 5.0, None),
        potential(&polynomial(&coefficients), 2.0, start, 5.0, Some(g00)),
    ]
}

/// Two active coordinates, separable; one of three; and two of four with an off-diagonal component.
fn scenes() -> [Problem; 3] {
    let scene = |geometry: Geometry, start: Start, length: f64| Problem {
        space: geometry.with_domain_of(&start.q).unwrap().into(),
        start,
        length,
        g00: None,
    };
    let henon_heiles = geometry(&newtonian(&["x", "y"], "(x^2 + y^2)/2 + x^2*y - y^3/3"));
    let [schwarzschild, kerr] =
        [preset("schwarzschild", &[]), preset("kerr", &[("a", "0.9")])].map(|text| geometry(&text));
    let starts = [
        newtonian_start(&henon_heiles, &[0.1, 0.3], &[0.4, 0.0]),
        start(&schwarzschild, &[0.0, 10.0, 0.0], &[1.2, -0.05, 0.03]),
        start(&kerr, &[0.0, 10.0, 1.4, 0.0], &[1.25, -0.05, 0.01, 0.035]),
    ];
    let [a, b, c] = starts;
    [scene(henon_heiles, a, 10.0), scene(schwarzschild, b, 40.0), scene(kerr, c, 40.0)]
}

fn all() -> impl Iterator<Item = (Problem, bool)> {
    let one = potentials().into_iter().map(|problem| (problem, false));
    one.chain(scenes().into_iter().map(|problem| (problem, true)))
}

/// Largest error of a coordinate or momentum at the points of the output.
fn error(problem: &Problem, output: &Output, trajectory: &Trajectory) -> f64 {
    let reference = reference(&problem.space, &problem.start, problem.length);
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

fn error_of(peer: Peer, problem: &Problem, output: &Output, setting: Setting) -> f64 {
    error(problem, output, &peer.run(problem, output, setting).unwrap())
}

fn delta_k(problem: &Problem, trajectory: &Trajectory) -> Vec<f64> {
    let norm = norm_of(&problem.space, &problem.start);
    let k = |q: &[f64], p: &[f64]| problem.space.norm(q, &problem.space.velocities(q, p).unwrap());
    trajectory.states.iter().map(|state| (k(state.q, state.p) - norm).abs()).collect()
}

#[test]
fn every_adaptive_method_follows_its_tolerance() {
    let output = Output::even(5);
    for (problem, is_scene) in all() {
        // Errors, and steps or evaluations, of a method to these tolerances.
        let run = |peer: Peer, tolerances: [f64; 2]| {
            tolerances.map(|tolerance| {
                let trajectory = peer.run(&problem, &output, Setting::tolerance(tolerance)).unwrap();
                let work = if peer.name() == "DOP853" { trajectory.evaluations } else { trajectory.steps };
                (error(&problem, &output, &trajectory), work as f64)
            })
        };
        let order = |[a, b]: [(f64, f64); 2]| (a.0 / b.0).ln() / (b.1 / a.1).ln();
        let factor = if is_scene { 30.0 } else { 20.0 };
        let order_8 = run(Peer::Dop853, [if is_scene { 1e-6 } else { 1e-9 }, 1e-12]);
        let loose = run(Peer::Dop853, [1e-6, 1e-9]);
        assert!(loose[0].0 < factor * 1e-6 && (is_scene || loose[1].0 < 2e-8), "{loose:?}");
        assert!(order_8[1].0 < factor * 1e-12 && order(order_8) > 6.5, "DOP853: order {}", order(order_8));
        let order_5 = run(Peer::Radau5, [if is_scene { 1e-6 } else { 1e-5 }, 1e-10]);
        let (bounds, orders) = if is_scene { ([1e-6, 1e-11], 4.4..8.0) } else { ([1e-4, 1e-10], 4.4..6.0) };
        assert!(order_5[0].0 < bounds[0] && order_5[1].0 < bounds[1], "{order_5:?}");
        assert!(orders.contains(&order(order_5)), "Radau: order {}, {order_5:?}", order(order_5));
        let (tolerances, factor) = if is_scene { ([1e-6, 1e-12], 100.0) } else { ([1e-6, 1e-15], 10.0) };
        for ((error, _), tolerance) in run(Peer::Taylor, tolerances).into_iter().zip(tolerances) {
            assert!(error < factor * tolerance, "Taylor: {error} with {tolerance}");
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
    for (composition, stages) in [(Peer::Verlet, 1), (Peer::KahanLi6, 9), (Peer::KahanLi8, 17)] {
        let growth = late_to_early(composition.run(&problem, &output, Setting::steps(1000 * (180 / stages))).unwrap());
        assert!(growth < 1.2, "{composition:?}: {growth}");
    }
    let growth = late_to_early(Peer::Gauss(4).run(&problem, &output, Setting::steps(2000)).unwrap());
    assert!(growth < 1.2, "{growth}");
    let growth = late_to_early(Peer::Rk4.run(&problem, &output, Setting::steps(20_000)).unwrap());
    assert!(growth > 5.0, "{growth}");
    let growth = late_to_early(Peer::Dop853.run(&problem, &output, Setting::tolerance(1e-8)).unwrap());
    assert!(growth > 5.0, "{growth}");
}

#[test]
fn failures_are_told_apart() {
    let hole = geometry(&preset("schwarzschild", &[]));
    let fall = start(&hole, &[0.0, 3.0, 0.0], &[3.0, -1.0, 0.0]);
    let fall = Problem { space: hole.with_domain_of(&fall.q).unwrap().into(), start: fall, length: 20.0, g00: None };
    let ends = [Failure::OutsideDomain, Failure::TooManySteps, Failure::Diverged, Failure::NotConverged];
    let output = Output::even(5);
    for (problem, is_scene) in
        [(potential("-0.5*x", 1.0, [0.0, 1.0, 0.0], 5.0, Some(vec![1.0, -1.0])), false), (fall, true)]
    {
        let with_horizon = |peer: &Peer| match is_scene {
            true => !peer.about().needs_second_order,
            false => ["RK4", "DOP853", "Taylor"].contains(&peer.name().as_str()),
        };
        for peer in PEERS.into_iter().filter(with_horizon) {
            let setting = match peer.about().step {
                Step::Adaptive => Setting::tolerance(1e-8),
                _ => Setting::steps(500),
            };
            let failure = peer.run(&problem, &output, setting).unwrap_err();
            let among = if is_scene { &ends[..] } else { &ends[..3] };
            assert!(among.contains(&failure), "{peer:?}: {failure}");
        }
    }
    let gauss = Peer::Gauss(8);
    assert_eq!(gauss.run(&quartic(1000.0), &output, Setting::steps(5)).unwrap_err(), Failure::NotConverged);
}

/// The orders of their errors are tested in `studies/orders.rs`.
#[test]
fn every_method_follows_every_motion_at_points_that_need_not_be_even() {
    let output = Output { intervals: 100, marks: vec![1, 2, 7, 50, 100] };
    for (problem, is_scene) in all() {
        for peer in PEERS {
            let about = peer.about();
            if about.needs_second_order && !problem.space.is_separable() {
                assert_eq!(peer.run(&problem, &output, Setting::steps(100)), Err(Failure::NotSeparable), "{peer:?}");
                continue;
            }
            let (setting, bound) = match about.step {
                Step::Adaptive if about.order == Some(5) => (Setting::tolerance(1e-11), 1e-9),
                Step::Adaptive => (Setting::tolerance(1e-13), 1e-11),
                _ if about.order >= Some(8) => (Setting::steps(400), 1e-11),
                _ => (Setting::steps(10_000), 1e-5),
            };
            let trajectory = peer.run(&problem, &output, setting).unwrap();
            let error = error(&problem, &output, &trajectory);
            assert!(error < if is_scene { 10.0 * bound } else { bound }, "{peer:?}: {error}");
        }
    }
}

/// The order of positions and momenta, and so of the largest error, is 4 for the cubic and s + 1 for Gauss; more than
/// eight points are in a step.
#[test]
fn dense_output_has_its_order() {
    let output = Output::even(97);
    // The polynomial is left out.
    for (k, (problem, is_scene)) in all().enumerate().filter(|(k, _)| *k != 2) {
        let gauss: [Peer; 3] = [Peer::Gauss(2), Peer::Gauss(4), Peer::Gauss(6)];
        let rows: &[(Peer, f64, usize, f64)] = match is_scene {
            true => &[(Peer::Rk4, 3.6, 80, 1e-3), (gauss[0], 2.8, 80, 1e-3), (gauss[1], 4.6, 40, 1e-3)],
            false => &[
                (Peer::Rk4, 3.6, 40, 3e-5),
                (gauss[0], 2.8, 40, 1e-4),
                (gauss[1], 4.7, 20, 2e-6),
                (gauss[2], 6.0, 10, 2e-6),
            ],
        };
        for (peer, least, steps, bound) in rows {
            let errors = [*steps, 2 * steps].map(|n| error_of(*peer, &problem, &output, Setting::steps(n)));
            let slope = (errors[0] / errors[1]).log2();
            assert!(slope > *least && errors[1] < *bound, "{}: order {slope}, errors {errors:?}", peer.name());
        }
        // The dense output of DOP853 is about as accurate as the ends of its steps.
        let [of_ends, of_tolerance] = if is_scene { [10.0, 100.0] } else { [3.0, 30.0] };
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let [ends, all] = [1, 97]
                .map(|points| error_of(Peer::Dop853, &problem, &Output::even(points), Setting::tolerance(tolerance)));
            let most = of_ends * ends + of_tolerance * tolerance;
            assert!(k == 1 || all < most, "{tolerance}: {all} inside, {ends} at the end");
        }
    }
}

#[test]
fn charges_are_parameters_and_the_rest_of_a_state_is_consistent() {
    for problem in scenes() {
        let geometry = &problem.space;
        let output = Output { intervals: 4, marks: vec![1, 4] };
        let states = Peer::Dop853.run(&problem, &output, Setting::tolerance(1e-13)).unwrap().states;
        let norm = |state: State<'_>| geometry.norm(state.q, &geometry.velocities(state.q, state.p).unwrap());
        let at_start = norm(State { q: &problem.start.q, p: &problem.start.p });
        for state in states.iter() {
            assert!(geometry.ignorable().all(|a| state.p[a] == problem.start.p[a]));
            // The norm is wrong if the momenta do not belong to the velocities.
            assert!((norm(state) - at_start).abs() < 1e-11);
        }
    }
}
