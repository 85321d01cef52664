//! A run handed out window by window is the run that is kept whole.

use crate::common::{case, parsed, solved};
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::solve::solve_window_by_window;
use geodesic_ivp::study::run::{Wanted, run};
use geodesic_ivp::trajectory::{Coordinate, NoSamples, OutsideRun, SampleStream, Sampler};
use geodesic_ivp::{Solution, Status};

const RUNS: [&str; 7] = [
    "grid.windows=6 grid.gamma_f=3.0",
    "grid.windows=6 grid.gamma_f=3.0 scheme.sbp=SBP42 scheme.form=weak initial.t=7.0 grid.gamma_i=-1.0",
    "grid.windows=3 grid.gamma_f=3.0 scheme.sbp=SBP42 solver.system=doubled",
    "grid.windows=6 grid.n_gamma=16 grid.gamma_f=3.0 scheme.sbp=GLL16 scheme.form=weak initial.t_dot=-1.0",
    "grid.windows=4 grid.n_gamma=12 grid.t_f=3.0 scheme.sbp=GLL12 scheme.form=weak",
    "solver.accuracy=1e-9 grid.gamma_f=7.0",
    "solver.accuracy=1e-9 grid.t_f=7.0 potential={linear={alpha=0.2}}",
];

/// Everything that is an extreme value over the run, in words.
fn extremes(found: &Diagnostics) -> String {
    let charges = found.charges.iter().chain(&found.sums);
    let charges: Vec<_> = charges.map(|c| [c.max_interior, c.max_last, c.last, c.max_corrected, c.max_ends]).collect();
    let invariants: Vec<_> = found.invariants.iter().map(|(_, i)| [i.max_interior, i.max_ends]).collect();
    let (norm, mut of_x) = (&found.norm, found.of_x);
    // Sums are compared elsewhere.
    of_x.iter_mut().for_each(|of_x| (of_x.h_bvp, of_x.h_bvp_bound, of_x.distance) = (0.0, 0.0, 0.0));
    let energy = found.energy.as_ref().map(|energy| [energy.value, energy.max_interior, energy.max_ends]);
    let others = (norm.max_interior, norm.max_ends, found.max_delta_g, found.motion, energy, found.branch_distance);
    format!("{charges:?} {invariants:?} {others:?} {:?} {:?} {of_x:?}", found.sawtooth, found.reaches)
}

#[test]
fn windows_one_by_one_are_those_of_the_whole_run() {
    for overrides in RUNS {
        let whole = solved(overrides);
        let backwards = whole.duration() < 0.0;
        let gammas: Vec<f64> = (0..=40).map(|k| whole.gamma_i + whole.length * f64::from(k) / 40.0).collect();
        let times: Vec<f64> = (0..=40).rev().map(|k| whole.t_i() + whole.duration() * f64::from(k) / 40.0).collect();
        let mut by_gamma = SampleStream::new(Coordinate::Gamma, gammas.clone(), false);
        let mut by_time = SampleStream::new(Coordinate::Value(0), times.clone(), backwards);
        let (mut t, mut x, mut gamma, mut windows) = (vec![], vec![], vec![], 0);
        let mut measures: Option<Diagnostics> = None;
        let last = solve_window_by_window(&case(overrides), &mut |window: &Solution| {
            windows += 1;
            assert_eq!((window.windows.len(), window.window_count), (1, windows), "{overrides}");
            t.extend(window.t());
            x.extend_from_slice(window.x());
            gamma.extend(window.gamma());
            let here = Diagnostics::new(window);
            measures = Some(match measures.take() {
                Some(before) => before.followed_by(here),
                None => here,
            });
            by_gamma.see(window);
            by_time.see(window);
        });
        let last = last.unwrap_or_else(|error| panic!("{overrides}: {error}"));
        assert!(windows > 1 && windows == whole.window_count, "{overrides}");
        assert!(t.iter().copied().eq(whole.t()) && x == whole.x(), "{overrides}");
        for (k, (part, all)) in gamma.iter().zip(whole.gamma()).enumerate() {
            assert_eq!(*part, all, "{overrides}: node {k} of {}", gamma.len());
        }
        assert_eq!(last.end_state(), whole.end_state(), "{overrides}");
        assert_eq!((last.gradient_norm, &last.iterations), (whole.gradient_norm, &whole.iterations), "{overrides}");
        assert_eq!((last.length, last.error_estimate), (whole.length, whole.error_estimate), "{overrides}");

        let (parts, all) = (measures.expect("there are windows"), Diagnostics::new(&whole));
        let [ours, theirs] = [&parts, &all].map(|found| found.of_x.unwrap());
        assert!((ours.h_bvp - theirs.h_bvp).abs() < 1e-13 * theirs.h_bvp.abs(), "{overrides}");
        let difference = ours.h_bvp_bound - theirs.h_bvp_bound;
        assert!(difference.abs() < 1e-13 * theirs.h_bvp_bound.abs(), "{overrides}");
        let defect = ours.defect() - theirs.defect();
        assert!(defect.abs() < 1e-12 * theirs.h_bvp_bound.abs(), "{overrides}: {defect:e}");
        assert_eq!(extremes(&parts), extremes(&all), "{overrides}");

        let mut sampler = Sampler::new(&whole);
        for (sample, &gamma) in by_gamma.finish(&last).unwrap().iter().zip(&gammas) {
            assert_eq!(*sample, sampler.at_gamma(gamma).unwrap(), "{overrides}");
        }
        for (sample, &t) in by_time.finish(&last).unwrap().iter().zip(&times) {
            assert_eq!(*sample, sampler.at_value(0, t).unwrap(), "{overrides}");
        }
    }
}

#[test]
fn samples_beyond_the_run_are_refused_with_its_range() {
    let overrides = "grid.windows=4 grid.n_gamma=12 grid.gamma_f=2.0 scheme.sbp=GLL12 scheme.form=weak";
    for values in [vec![0.5, 2.5], vec![-0.5, 0.5], vec![2.5, 0.5]] {
        let mut stream = SampleStream::new(Coordinate::Gamma, values.clone(), false);
        let last = solve_window_by_window(&case(overrides), &mut |window: &Solution| stream.see(window)).unwrap();
        let range = (0.0, 2.0);
        assert_eq!(stream.finish(&last), Err(NoSamples::Outside(OutsideRun { range })), "{values:?}");
    }
}

#[test]
fn a_failure_on_the_way_ends_the_run() {
    let overrides = "potential={linear={alpha=1.0}} initial.x=0.0 initial.x_dot=0.0 grid.gamma_f=10.0";
    for scheme in ["scheme.sbp=GLL12 grid.n_gamma=12 scheme.form=weak grid.windows=20", "solver.accuracy=1e-8"] {
        let (mut windows, mut furthest) = (0, 0.0);
        let failure = solve_window_by_window(&case(&format!("{overrides} {scheme}")), &mut |window: &Solution| {
            windows += 1;
            furthest = window.windows[0].gamma[1];
        });
        let failure = failure.unwrap_err();
        assert_eq!(failure.status, Status::OutsideDomain, "{scheme}");
        assert!(windows > 0 && furthest < failure.gamma + 1e-9, "{scheme}: {furthest} and {}", failure.gamma);
    }
}

/// Scenes with events, invariants, conserved sums, an energy and the work of a force, on grids and to an accuracy.
#[test]
fn scenes_one_window_after_another_are_those_of_the_whole_run() {
    let grid = "scheme = { sbp = \"GLL12\", form = \"weak\" }\ngrid = { gamma_f = 9.0, windows = 15 }";
    let strong = "scheme.sbp = \"SBP42\"\ngrid = { gamma_f = 9.0, windows = 4, n_gamma = 60 }";
    let accuracy = "solver.accuracy = 1e-9\ngrid.gamma_f = 9.0";
    let plane = "potential = { coordinates = [\"x\", \"y\"], formula = \"(x - y)^2/2 + (x - y)^4/8\" }\n\
                 particle.law = \"newtonian\"\ninitial = { x = 1.0, y = -0.5, x_dot = 0.3, y_dot = 0.1 }\n\
                 invariants.sum = \"p_x + p_y\"\nevents.meet.when = \"x - y\"\nevents.late.when = \"t - 9\"\n";
    let damped = "potential = { formula = \"x^2/2\", force = { x = \"-x_dot/9\" } }\nparticle.law = \"newtonian\"\n\
                  initial = { x = 1.0, x_dot = 0.0 }\nevents.turn.when = \"x_dot\"\n";
    for (scene, rest) in [plane, damped].iter().flat_map(|scene| [grid, strong, accuracy].map(|rest| (scene, rest))) {
        let text = format!("{scene}{rest}\n");
        let case = parsed(&text, &[]);
        let setup = case.setup::<f64>();
        let times =
            || Some(SampleStream::new(Coordinate::Value(0), (0..30).map(|k| 0.29 * f64::from(k)).collect(), false));
        let [whole, streamed] = [false, true].map(|is_streamed| {
            run(&case, &setup, Wanted { samples: times(), is_streamed, sums: true, observer: None })
                .0
                .expect("there is a run")
        });
        assert!(streamed.line.windows.len() == 1 && whole.line.windows.len() == streamed.line.window_count);
        assert_eq!((&streamed.samples, &streamed.events), (&whole.samples, &whole.events), "{text}");
        assert!(whole.events.len() >= 2 && streamed.sums == whole.sums, "{text}");
        assert_eq!(extremes(&streamed.diagnostics), extremes(&whole.diagnostics), "{text}");
        for (one, all) in streamed.diagnostics.work.iter().zip(&whole.diagnostics.work) {
            assert!((one.work - all.work).abs() < 1e-14 && (one.defect - all.defect).abs() < 1e-14, "{text}");
        }
        assert_eq!(streamed.line.end(), whole.line.end(), "{text}");
    }
}
