//! World-lines between their nodes, of one coordinate and of several.

use geodesic_ivp::case::Case;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::solve::WorldLine;
use geodesic_ivp::trajectory::{Coordinate, NoSamples, SampleStream, Sampler};

use crate::common::{line_of, parsed, reference_of, shipped, solved};

/// An expanding, rotating space with a charge: every coordinate is active, and components off the diagonal.
const SPACE: &str = "initial = { t = 0.1, x = 0.5, z = 0.3, t_dot = 1, x_dot = 0.3, z_dot = 0.2 }\n\
                     metric = { coordinates = ['t', 'x', 'z'], components = { 't t' = '1 + x^2/4', \
                     't x' = '0.2*cos(t)', 'x x' = '-1 - x^2/10', 'z z' = '-2 - sin(x)' } }\n";
const QUARTIC: &str = "initial = { t = 0.0, x = 1.0, t_dot = 1.0, x_dot = 0.1 }\npotential.quartic.kappa = 0.5\n";

/// A run over the length 4 from γ = −0.7.
fn case(scene: &str, (sbp, form, system): (&str, &str, &str), n_gamma: usize, windows: usize) -> Case {
    parsed(
        &format!(
            "{scene}grid = {{ gamma_i = -0.7, gamma_f = 3.3, n_gamma = {n_gamma}, windows = {windows} }}\n\
             scheme = {{ sbp = '{sbp}', form = '{form}' }}\nsolver.system = '{system}'\n"
        ),
        &[],
    )
}

/// The largest errors of positions and of velocities and momenta at so many values of γ.
fn errors(line: &WorldLine, samples: u32) -> [f64; 2] {
    let (reference, mut sampler) = (reference_of(line), Sampler::new(line));
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
    let reference = reference_of(line);
    let exact: Vec<_> = line.gamma().map(|gamma| reference.at(gamma - line.gamma_i)).collect();
    let of = |a: usize| line.q(a).zip(&exact).fold(0.0, |most: f64, (q, exact)| most.max((q - exact.q[a]).abs()));
    (0..line.geometry().dimension()).map(of).fold(0.0, f64::max)
}

#[test]
fn samples_are_as_accurate_as_nodes() {
    for (sbp, n, windows, is_weak_too) in [
        ("SBP21", 201, 1, false),
        ("SBP42", 101, 2, true),
        ("SBP63", 101, 1, true),
        ("SBP84", 101, 2, true),
        ("GLL12", 12, 3, true),
        ("GLL24", 24, 1, true),
    ] {
        let mut schemes = vec![(sbp, "strong", "physical-limit")];
        if is_weak_too {
            schemes.extend([(sbp, "weak", "physical-limit"), (sbp, "strong", "doubled")]);
        }
        for scheme in schemes {
            let line = line_of(&case(SPACE, scheme, n, windows));
            let (at_nodes, [positions, rates]) = (error_at_nodes(&line), errors(&line, 1000));
            let what = format!("{scheme:?}: nodes {at_nodes:e}, between {positions:e}, rates {rates:e}");
            assert!(positions <= 2.0 * at_nodes + 1e-13, "{what}");
            assert!(rates <= 60.0 * at_nodes + 1e-12, "{what}");
        }
    }
    for (sbp, n, form) in [("SBP42", 40, "strong"), ("GLL16", 16, "strong"), ("GLL16", 16, "weak")] {
        let line = line_of(&case(QUARTIC, (sbp, form, "physical-limit"), n, 8));
        let (at_nodes, [positions, _]) = (error_at_nodes(&line), errors(&line, 90));
        assert!(positions < 2.0 * at_nodes + 1e-12, "{sbp} {form}: {positions:e} against {at_nodes:e}");
    }
}

#[test]
fn samples_inside_weak_elements_are_as_accurate_as_their_ends() {
    for (n, windows) in [(6, 10), (10, 3), (16, 2)] {
        let line: WorldLine = line_of(&case(SPACE, (&format!("GLL{n}"), "weak", "physical-limit"), n, windows));
        let reference = reference_of(&line);
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
    let are_samples = |line: &WorldLine, most: f64| {
        let mut sampler = Sampler::new(line);
        for (k, gamma) in line.gamma().enumerate() {
            for (a, found) in sampler.at_gamma(gamma).unwrap().q.iter().enumerate() {
                let node = line.q(a).nth(k).unwrap();
                assert!((found - node).abs() < most, "{}, node {k}: {found} {node}", line.sbp_name);
            }
        }
    };
    for sbp in ["SBP42", "GLL20"] {
        let line: WorldLine = line_of(&case(SPACE, (sbp, "strong", "physical-limit"), 20, 3));
        are_samples(&line, 1e-13);
        let mut sampler = Sampler::new(&line);
        let (first, last) = (sampler.at_gamma(-0.7).unwrap(), sampler.at_gamma(3.3).unwrap());
        let (start, end) = (&line.place.start, line.end());
        assert_eq!((&first.q, &first.p, &last.q, &last.p), (&start.q, &start.p, &end.q, &end.p));
        let outside = sampler.at_gamma(3.301).unwrap_err();
        assert!((outside.range.0 + 0.7).abs() < 1e-15 && (outside.range.1 - 3.3).abs() < 1e-15);
        assert!(sampler.at_gamma(-0.701).is_err());
    }
    for scheme in ["scheme.sbp=SBP42", "scheme.sbp=GLL16 grid.n_gamma=16"] {
        let line = solved(&format!("{scheme} grid.gamma_i=-0.3 grid.gamma_f=0.7 initial.t=2.5"));
        are_samples(&line, 1e-14);
        let (mut sampler, end) = (Sampler::new(&line), line.end_state().t);
        assert_eq!(sampler.at_value(0, 2.5).unwrap().q[1], 1.0);
        assert!((sampler.at_value(0, end).unwrap().gamma - 0.7).abs() < 1e-14);
        assert!(sampler.at_gamma(0.7000001).is_err() && sampler.at_gamma(-0.3000001).is_err());
        assert!(sampler.at_value(0, 2.4999).is_err() && sampler.at_value(0, end + 1e-6).is_err());
    }
}

#[test]
fn a_value_of_a_coordinate_that_grows_is_found() {
    for (sbp, n) in [("GLL16", 16), ("SBP42", 200)] {
        let line = line_of(&case(SPACE, (sbp, "weak", "physical-limit"), n, 3));
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
            let gamma = 0.08 * f64::from(k) - 0.7;
            let sample = sampler.at_gamma(gamma).unwrap();
            let found = sampler.at_value(0, sample.q[0]).unwrap();
            let apart = (found.gamma - gamma).abs().max((found.q[2] - sample.q[2]).abs());
            assert!(apart < 1e-13, "{sbp}, {gamma}: {apart:e}");
        }
        assert!(sampler.at_value(0, 0.09).is_err());
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
    let text = format!(
        "{SPACE}grid = {{ gamma_f = 4.0, windows = 12 }}\nscheme = {{ sbp = 'GLL32', form = 'weak' }}\n\
         solver.digits = 40\n"
    );
    let line: WorldLine<Extended> = line_of(&parsed(&text, &[]));
    let (reference, mut sampler) = (reference_of(&line), Sampler::new(&line));
    for k in 1..8 {
        let gamma = Extended::from(f64::from(k) * 0.51);
        let (sample, exact) = (sampler.at_gamma(gamma).unwrap(), reference.at(gamma));
        let error = sample.q.iter().zip(&exact.q).fold(0.0, |most: f64, (a, b)| most.max((*a - *b).abs().to_f64()));
        assert!(error < 1e-34, "{error:e} at {}", gamma.to_f64());
    }
}

#[test]
fn a_circular_orbit_has_samples_though_its_radial_momentum_is_rounding() {
    // E = 0.8/sqrt(0.7) and L = 10/sqrt(7) at r = 10.
    let start = ["initial.r=10.0", "initial.p_t=0.95618288746751490", "initial.p_phi=-3.7796447300922722"];
    let case = shipped("schwarzschild-orbit", &[&start[..], &["grid.gamma_f=100.0", "grid.windows=4"]].concat());
    let line: WorldLine = line_of(&case);
    let mut sampler = Sampler::new(&line);
    for k in 0..=100 {
        let gamma = f64::from(k);
        let sample = sampler.at_gamma(gamma).unwrap();
        let phi = gamma * 0.1 / 7.0_f64.sqrt();
        assert!((sample.q[1] - 10.0).abs() < 1e-11 && (sample.q[2] - phi).abs() < 1e-11, "{gamma}: {:?}", sample.q);
    }
}

/// Windows that are cut to meet a jump are shorter than the rounding of t.
#[test]
fn a_time_is_a_place_also_where_windows_are_shorter_than_its_rounding() {
    let mut ties = 0;
    for x in 11..21 {
        let text = format!(
            "potential.coordinates = ['x']\npotential.formula = '0'\npotential.force.x = '-3 + sign(x - 0.3)'\n\
             particle.law = 'newtonian'\ninitial = {{ t = 1000.3, x = {}, x_dot = 0.7 }}\ngrid.t_f = 1003.0\n\
             solver.accuracy = 1e-12\n",
            f64::from(x) / 10.0
        );
        let line: WorldLine = line_of(&parsed(&text, &[]));
        ties += line.views().filter(|view| view.end.q[0] == view.start.q[0]).count();
        let mut stream = SampleStream::new(Coordinate::Value(0), vec![1000.5, 1001.0, 1002.0], false);
        stream.see(&line);
        let samples = stream.finish(&line).unwrap_or_else(|none| panic!("{x}: {none:?}"));
        assert_eq!(samples.len(), 3);
        assert!(samples.iter().all(|sample| (sample.gamma + 1000.3 - sample.q[0]).abs() < 1e-11), "{x}");
    }
    assert!(ties > 0, "no window is so short");
}
