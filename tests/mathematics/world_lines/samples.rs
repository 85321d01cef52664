//! Scenes between their nodes.

use geodesic_ivp::action::Form;
use geodesic_ivp::case::{Case, builtin};
use geodesic_ivp::geometry::GeometryText;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::sbp::SbpName;
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::solve::{Setup, System, WorldLine, solve};
use geodesic_ivp::trajectory::{Coordinate, NoSamples, SampleStream, Sampler};

use crate::common;

/// An expanding, rotating space with a charge: every coordinate is active, and components off the diagonal.
fn setup<S: Arithmetic>(sbp: SbpName, form: Form, n_gamma: usize, windows: usize, system: System) -> Setup<S> {
    let components = [("t t", "1 + x^2/4"), ("t x", "0.2*cos(t)"), ("x x", "-1 - x^2/10"), ("z z", "-2 - sin(x)")];
    let text = GeometryText::Metric(common::metric(&["t", "x", "z"], &components));
    let start: (&[&str], &[&str]) = (&["0.1", "0.5", "0.3"], &["1", "0.3", "0.2"]);
    common::in_windows(common::setup(&text, start, 4.0, (sbp, form, n_gamma), system), windows)
}

fn reference<S: Arithmetic>(line: &WorldLine<S>) -> ReferenceTrajectory<S> {
    ReferenceTrajectory::new(line.geometry(), &line.place.start, line.length, line.digits).unwrap()
}

/// The largest errors of positions and of velocities and momenta at so many values of γ.
fn errors(line: &WorldLine, samples: u32) -> [f64; 2] {
    let (reference, mut sampler) = (reference(line), Sampler::new(line));
    let mut most = [0.0_f64; 2];
    for k in 0..=samples {
        let gamma = line.length * f64::from(k) / f64::from(samples);
        let (sample, exact) = (sampler.at_gamma(line.gamma_i + gamma).unwrap(), reference.at(gamma));
        let rates = sample.q_dot.iter().chain(&sample.p).zip(exact.q_dot.iter().chain(&exact.p));
        let largest = |most: f64, (a, b): (&f64, &f64)| most.max((a - b).abs());
        most[0] = sample.q.iter().zip(&exact.q).fold(most[0], largest);
        most[1] = rates.fold(most[1], largest);
    }
    most
}

/// The largest error of a position at the nodes.
fn error_at_nodes(line: &WorldLine) -> f64 {
    let reference = reference(line);
    let exact: Vec<_> = line.gamma().map(|gamma| reference.at(gamma - line.gamma_i)).collect();
    let of = |a: usize| line.q(a).zip(&exact).fold(0.0, |most: f64, (q, exact)| most.max((q - exact.q[a]).abs()));
    (0..line.geometry().dimension()).map(of).fold(0.0, f64::max)
}

#[test]
fn samples_are_as_accurate_as_nodes() {
    for (sbp, n, windows) in [
        (SbpName::Sbp21, 201, 1),
        (SbpName::Sbp42, 101, 2),
        (SbpName::Sbp63, 101, 1),
        (SbpName::Sbp84, 101, 2),
        (SbpName::Gll(12), 12, 3),
        (SbpName::Gll(24), 24, 1),
    ] {
        for (form, system) in [
            (Form::Strong, System::PhysicalLimit),
            (Form::Weak, System::PhysicalLimit),
            (Form::Strong, System::Doubled),
        ] {
            if (sbp, system) == (SbpName::Sbp21, System::Doubled) || (sbp, form) == (SbpName::Sbp21, Form::Weak) {
                continue;
            }
            let line = solve(setup::<f64>(sbp, form, n, windows, system)).unwrap();
            let (at_nodes, [positions, rates]) = (error_at_nodes(&line), errors(&line, 1000));
            let what =
                format!("{sbp:?} {form:?} {system:?}: nodes {at_nodes:e}, between {positions:e}, rates {rates:e}");
            assert!(positions <= 2.0 * at_nodes + 1e-13, "{what}");
            assert!(rates <= 60.0 * at_nodes + 1e-12, "{what}");
        }
    }
}

#[test]
fn samples_inside_weak_elements_are_as_accurate_as_their_ends() {
    for (n, windows) in [(6, 10), (10, 3), (16, 2)] {
        let line = solve(setup::<f64>(SbpName::Gll(n), Form::Weak, n.into(), windows, System::PhysicalLimit));
        let line = line.unwrap();
        let reference = reference(&line);
        let at_ends = line.views().fold(0.0, |most: f64, view| {
            let exact = reference.at(view.window.gamma[1]);
            let joint = view.end.q.iter().chain(view.end.p).zip(exact.q.iter().chain(&exact.p));
            joint.fold(most, |most, (a, b)| most.max((a - b).abs()))
        });
        let (at_nodes, [positions, rates]) = (error_at_nodes(&line), errors(&line, 1000));
        assert!(at_nodes > 20.0 * at_ends, "GLL{n}: nodes {at_nodes:e}, ends {at_ends:e}");
        assert!(positions.max(rates) < 10.0 * at_ends + 1e-14, "GLL{n}: {positions:e} {rates:e}, ends {at_ends:e}");
    }
}

#[test]
fn nodes_are_samples_of_themselves_and_the_ends_are_inside() {
    for (sbp, form, n) in [(SbpName::Sbp42, Form::Strong, 20), (SbpName::Gll(20), Form::Strong, 20)] {
        let mut setup = setup::<f64>(sbp, form, n, 3, System::PhysicalLimit);
        setup.gamma_i = -0.7;
        let line = solve(&setup).unwrap();
        let mut sampler = Sampler::new(&line);
        for (k, gamma) in line.gamma().enumerate() {
            let sample = sampler.at_gamma(gamma).unwrap();
            for a in 0..3 {
                let node = line.q(a).nth(k).unwrap();
                assert!((sample.q[a] - node).abs() < 1e-13, "{sbp:?}, node {k}: {} {node}", sample.q[a]);
            }
        }
        let (first, last) = (sampler.at_gamma(-0.7).unwrap(), sampler.at_gamma(3.3).unwrap());
        let (start, end) = (&line.place.start, line.end());
        assert_eq!((&first.q, &first.p, &last.q, &last.p), (&start.q, &start.p, &end.q, &end.p));
        let outside = sampler.at_gamma(3.301).unwrap_err();
        assert!((outside.range.0 + 0.7).abs() < 1e-15 && (outside.range.1 - 3.3).abs() < 1e-15);
        assert!(sampler.at_gamma(-0.701).is_err());
    }
}

#[test]
fn a_value_of_a_coordinate_that_grows_is_found() {
    for (sbp, n) in [(SbpName::Gll(16), 16), (SbpName::Sbp42, 200)] {
        let line = solve(setup::<f64>(sbp, Form::Weak, n, 3, System::PhysicalLimit)).unwrap();
        let mut sampler = Sampler::new(&line);
        let taken = |a: usize| {
            let values = vec![line.q(a).nth(5).unwrap()];
            let mut stream = SampleStream::new(Coordinate::Value(a), values, false);
            stream.see(&line);
            stream.finish(&line)
        };
        assert!(taken(0).is_ok() && taken(1) == Err(NoSamples::Turns));
        // The first node of a weak grid is off its start by the truncation error.
        for k in 1..50 {
            let gamma = 0.08 * f64::from(k);
            let sample = sampler.at_gamma(gamma).unwrap();
            let found = sampler.at_value(0, sample.q[0]).unwrap();
            assert!(
                (found.gamma - gamma).abs() < 1e-13 && (found.q[2] - sample.q[2]).abs() < 1e-13,
                "{sbp:?}, {gamma}"
            );
        }
        assert!(sampler.at_value(0, 0.09).is_err());
    }
}

#[test]
fn samples_keep_the_digits_of_the_run() {
    let line: WorldLine<Extended> = solve(setup(SbpName::Gll(32), Form::Weak, 32, 12, System::PhysicalLimit)).unwrap();
    let (reference, mut sampler) = (reference(&line), Sampler::new(&line));
    for k in 1..8 {
        let gamma = Extended::from(f64::from(k) * 0.51);
        let (sample, exact) = (sampler.at_gamma(gamma).unwrap(), reference.at(gamma));
        let error = sample.q.iter().zip(&exact.q).fold(0.0, |most: f64, (a, b)| most.max((*a - *b).abs().to_f64()));
        assert!(error < 1e-34, "{error:e} at {}", gamma.to_f64());
    }
}

#[test]
fn a_circular_orbit_has_samples_though_its_radial_momentum_is_rounding() {
    let text = builtin::text("schwarzschild-orbit").unwrap();
    // E = 0.8/sqrt(0.7) and L = 10/sqrt(7) at r = 10.
    let set = ["r=10.0", "p_t=0.95618288746751490", "p_phi=-3.7796447300922722"];
    let set: Vec<String> = set
        .iter()
        .map(|set| format!("initial.{set}"))
        .chain(["grid.gamma_f=100.0".into(), "grid.windows=4".into()])
        .collect();
    let case = Case::parse("circle", text, &set).unwrap();
    let line: WorldLine = solve(case.setup()).unwrap();
    let mut sampler = Sampler::new(&line);
    for k in 0..=100 {
        let gamma = f64::from(k);
        let sample = sampler.at_gamma(gamma).unwrap();
        let phi = gamma * 0.1 / 7.0_f64.sqrt();
        assert!((sample.q[1] - 10.0).abs() < 1e-11 && (sample.q[2] - phi).abs() < 1e-11, "{gamma}: {:?}", sample.q);
    }
}
