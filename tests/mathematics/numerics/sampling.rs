//! Samples between the nodes are as accurate as the nodes.

use crate::common::solved;
use geodesic_ivp::case::builtin;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::trajectory::Sampler;
use geodesic_ivp::{Case, Solution, solve};

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
