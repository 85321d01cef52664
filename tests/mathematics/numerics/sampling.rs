//! Samples between the nodes are as accurate as the nodes.

use crate::common::{case, solved, solved_in};
use geodesic_ivp::case::builtin;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::trajectory::Sampler;
use geodesic_ivp::{Case, Solution, solve};

const RUN: &str = "grid.gamma_f=4.0";

/// Largest errors of t and x at the nodes, and of t, x, ṫ, ẋ at samples between them.
fn errors(overrides: &str) -> (f64, [f64; 2]) {
    let solution = solved(overrides);
    let case = case(overrides);
    let reference = ReferenceTrajectory::new(&case.geometry(), &case.start(), solution.length, 16).unwrap();
    let at_nodes = (0..solution.x().len()).fold(0.0_f64, |largest, k| {
        let exact = reference.at(solution.sbp().node(k));
        largest.max((solution.x()[k] - exact.q[1]).abs()).max((solution.elapsed()[k] - exact.q[0]).abs())
    });
    let mut sampler = Sampler::new(&solution);
    let mut between = [0.0_f64; 2];
    for k in 0..=1000 {
        let gamma = solution.length * f64::from(k) / 1000.0;
        let (sample, exact) = (sampler.at_gamma(gamma).unwrap(), reference.at(gamma));
        between[0] = between[0].max((sample.q[1] - exact.q[1]).abs()).max((sample.q[0] - exact.q[0]).abs());
        between[1] =
            between[1].max((sample.q_dot[1] - exact.q_dot[1]).abs()).max((sample.q_dot[0] - exact.q_dot[0]).abs());
        // The same point by its time.
        let by_time = sampler.at_value(0, sample.q[0]).unwrap();
        assert!(
            (by_time.gamma - gamma).abs() < 1e-13 && (by_time.q[1] - sample.q[1]).abs() < 1e-13,
            "{overrides} at {gamma}"
        );
    }
    (at_nodes, between)
}

#[test]
fn samples_are_as_accurate_as_nodes() {
    for (scheme, n) in [("SBP21", 401), ("SBP42", 401), ("SBP63", 401), ("SBP84", 401), ("GLL40", 40), ("GLL64", 64)] {
        for system in ["physical-limit", "doubled"] {
            let overrides = format!("{RUN} scheme.sbp={scheme} grid.n_gamma={n} solver.system={system}");
            let (at_nodes, [values, slopes]) = errors(&overrides);
            assert!(values <= 1.5 * at_nodes + 1e-12, "{overrides}: {values:e} between nodes, {at_nodes:e} at them");
            assert!(slopes <= 30.0 * at_nodes + 1e-10, "{overrides}: slopes {slopes:e}, nodes {at_nodes:e}");
        }
    }
}

#[test]
fn nodes_are_samples_of_themselves_and_the_ends_are_inside() {
    for scheme in ["scheme.sbp=SBP42", "scheme.sbp=GLL16 grid.n_gamma=16"] {
        let solution = solved(&format!("{scheme} grid.gamma_i=-0.3 grid.gamma_f=0.7 initial.t=2.5"));
        let mut sampler = Sampler::new(&solution);
        for (k, (gamma, t)) in solution.gamma().zip(solution.t()).enumerate() {
            let sample = sampler.at_gamma(gamma).unwrap();
            assert!(
                (sample.q[0] - t).abs() < 1e-14 && (sample.q[1] - solution.x()[k]).abs() < 1e-14,
                "{scheme}, node {k}"
            );
        }
        assert_eq!(sampler.at_value(0, 2.5).unwrap().q[1], 1.0);
        assert!((sampler.at_value(0, solution.end_state().t).unwrap().gamma - 0.7).abs() < 1e-14);
        assert!(sampler.at_gamma(0.7000001).is_err() && sampler.at_gamma(-0.3000001).is_err());
        assert!(sampler.at_value(0, 2.4999).is_err() && sampler.at_value(0, solution.end_state().t + 1e-6).is_err());
    }
}

#[test]
fn time_that_runs_backwards_is_sampled_too() {
    let solution = solved("initial.t_dot=-1.0 scheme.sbp=SBP42 grid.n_gamma=200");
    let mut sampler = Sampler::new(&solution);
    let sample = sampler.at_value(0, -1.0).unwrap();
    assert!((sampler.at_gamma(sample.gamma).unwrap().q[0] + 1.0).abs() < 1e-13 && sample.q_dot[0] < 0.0);
    assert!(sampler.at_value(0, 0.1).is_err());
}

#[test]
fn samples_keep_the_digits_of_the_run() {
    let solution = solved_in::<Extended>("scheme.sbp=GLL48 grid.n_gamma=48 solver.digits=40");
    let case = case("");
    let reference = ReferenceTrajectory::new(&case.geometry(), &case.start(), Extended::ONE, 40).unwrap();
    let mut sampler = Sampler::new(&solution);
    for k in 1..20 {
        let gamma = Extended::from(f64::from(k) * 0.05);
        let error = (sampler.at_gamma(gamma).unwrap().q[1] - reference.at(gamma).q[1]).abs().to_f64();
        assert!(error < 1e-16, "{error:e} with {} nodes", solution.x().len());
    }
}

#[test]
fn samples_inside_weak_windows_are_as_accurate_as_their_ends() {
    for (scheme, nodes_at_least) in [
        ("scheme.sbp=GLL16 grid.n_gamma=16 grid.windows=8", 1e-10),
        ("scheme.sbp=GLL8 grid.n_gamma=8 grid.windows=20", 1e-8),
        // Newton's method has its turn where windows are long.
        ("scheme.sbp=GLL32 grid.n_gamma=32 grid.windows=2", 1e-9),
    ] {
        let overrides = format!("{RUN} scheme.form=weak {scheme}");
        let solution = solved(&overrides);
        let reference = ReferenceTrajectory::new(&case("").geometry(), &case("").start(), solution.length, 16).unwrap();
        let error = |gamma: f64, t: f64, x: f64| {
            let exact = reference.at(gamma);
            (t - exact.q[0]).abs().max((x - exact.q[1]).abs())
        };
        let nodes = solution.gamma().zip(solution.t()).zip(solution.x());
        let at_nodes = nodes.fold(0.0_f64, |largest, ((gamma, t), &x)| largest.max(error(gamma, t, x)));
        let at_ends = solution.views().fold(0.0_f64, |largest, view| {
            let [t, x] = [view.end.q[0], view.end.q[1]];
            largest.max(error(view.window.gamma[1], t, x))
        });
        let mut sampler = Sampler::new(&solution);
        let between = (0..=1000).fold(0.0_f64, |largest, k| {
            let gamma = solution.length * f64::from(k) / 1000.0;
            let sample = sampler.at_gamma(gamma).unwrap();
            let exact = reference.at(gamma);
            let slopes = (sample.q_dot[1] - exact.q_dot[1]).abs().max((sample.q_dot[0] - exact.q_dot[0]).abs());
            largest.max(error(gamma, sample.q[0], sample.q[1])).max(slopes)
        });
        assert!(at_nodes >= nodes_at_least, "{scheme}: nodes {at_nodes:e}");
        assert!(between <= 10.0 * at_ends + 1e-14, "{scheme}: {between:e} between, {at_ends:e} at the ends");
    }
}

#[test]
fn samples_of_an_accuracy_keep_it() {
    for name in ["quartic", "pendulum", "morse", "double-well", "tanh-wall", "power-20"] {
        for accuracy in [1e-4, 1e-7, 1e-10, 1e-12] {
            let set = format!("solver.accuracy={accuracy:e}");
            let case = Case::parse(name, builtin::text(name).unwrap(), &[set]).unwrap();
            let solution: Solution = solve(&case).unwrap();
            let (metric, initial) = (case.geometry(), case.start());
            let reference = ReferenceTrajectory::new(&metric, &initial, Extended::from(solution.length), 18).unwrap();
            let mut sampler = Sampler::new(&solution);
            let (mut errors, mut sizes) = ([0.0_f64; 2], [1.0_f64; 2]);
            for k in 0..=700 {
                let from_start = solution.length * f64::from(k) / 700.0;
                let sample = sampler.at_gamma(solution.gamma_i + from_start).unwrap();
                let exact = reference.at(Extended::from(sample.gamma - solution.gamma_i));
                let found = [sample.q[0] - solution.t_i(), sample.q[1]];
                for (i, exact) in [exact.q[0].to_f64(), exact.q[1].to_f64()].into_iter().enumerate() {
                    errors[i] = errors[i].max((found[i] - exact).abs());
                    sizes[i] = sizes[i].max(exact.abs());
                }
            }
            let error = (errors[0] / sizes[0]).max(errors[1] / sizes[1]);
            assert!(error < accuracy, "{name}, {accuracy:e}: {error:e}");
        }
    }
}
