//! A run handed out part by part is the run that is kept whole.

use crate::common::{case, line_of, parsed};
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::solve::{WorldLine, solve_in_parts};
use geodesic_ivp::study::run::{Wanted, run};
use geodesic_ivp::trajectory::{Coordinate, NoSamples, OutsideRun, Sample, SampleStream, Sampler};
use geodesic_ivp::{Case, Solution, Status};

const RUNS: [&str; 9] = [
    "grid.windows=60 grid.gamma_f=30.0",
    "grid.windows=6 grid.gamma_f=3.0",
    "grid.windows=60 grid.gamma_f=30.0 scheme.sbp=SBP42 scheme.form=weak initial.t=7.0 grid.gamma_i=-1.0",
    "grid.windows=3 grid.n_gamma=300 grid.gamma_f=3.0 scheme.sbp=SBP42 solver.system=doubled",
    "grid.windows=90 grid.n_gamma=16 grid.gamma_f=30.0 scheme.sbp=GLL16 scheme.form=weak initial.t_dot=-1.0",
    "grid.windows=99 grid.n_gamma=12 grid.t_f=30.0 scheme.sbp=GLL12 scheme.form=weak",
    "solver.accuracy=1e-9 grid.gamma_f=70.0",
    "solver.accuracy=1e-9 grid.gamma_f=3.0",
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

/// Scenes with events, invariants, conserved sums, an energy and the work of a force, on grids and to an accuracy.
fn scenes() -> impl Iterator<Item = Case> {
    let grid = "scheme = { sbp = \"GLL12\", form = \"weak\" }\ngrid = { gamma_f = 90.0, windows = 150 }";
    let strong = "scheme.sbp = \"SBP42\"\ngrid = { gamma_f = 9.0, windows = 12, n_gamma = 60 }";
    let accuracy = "solver.accuracy = 1e-9\ngrid.gamma_f = 200.0";
    let plane = "potential = { coordinates = [\"x\", \"y\"], formula = \"(x - y)^2/2 + (x - y)^4/8\" }\n\
                 particle.law = \"newtonian\"\ninitial = { x = 1.0, y = -0.5, x_dot = 0.3, y_dot = 0.1 }\n\
                 invariants.sum = \"p_x + p_y\"\nevents.meet.when = \"x - y\"\nevents.late.when = \"t - 9\"\n";
    let damped = "potential = { formula = \"x^2/2\", force = { x = \"-x_dot/9\" } }\nparticle.law = \"newtonian\"\n\
                  initial = { x = 1.0, x_dot = 0.0 }\nevents.turn.when = \"x_dot\"\n";
    let texts = [plane, damped].into_iter().flat_map(move |scene| [grid, strong, accuracy].map(|rest| (scene, rest)));
    texts.map(|(scene, rest)| parsed(&format!("{scene}{rest}\n"), &[]))
}

/// γ and the coordinates of all nodes.
fn nodes(line: &WorldLine) -> Vec<Vec<f64>> {
    let rows = (0..line.geometry().dimension()).map(|a| line.q(a).collect());
    std::iter::once(line.gamma().collect()).chain(rows).collect()
}

#[test]
fn parts_are_those_of_the_whole_run() {
    for (case, by) in RUNS
        .map(case)
        .into_iter()
        .chain(scenes())
        .flat_map(|case| [Coordinate::Gamma, Coordinate::Value(0)].map(|by| (case.clone(), by)))
    {
        let (setup, text) = (case.setup::<f64>(), case.to_toml());
        let line: WorldLine = line_of(&case);
        let mut sampler = Sampler::new(&line);
        let ends = [line.gamma_i, line.gamma_f()];
        let times = ends.map(|gamma| sampler.at_gamma(gamma).unwrap().q[0]);
        let [from, to] = if by == Coordinate::Gamma { ends } else { times };
        let values: Vec<f64> = (0..=40).rev().map(|k| from + (to - from) * f64::from(k) / 40.0).collect();
        let (mut seen, mut windows) = (vec![Vec::new(); line.geometry().dimension() + 1], 0);
        let mut see = |part: &WorldLine, _: &Diagnostics| {
            windows += part.windows.len();
            assert_eq!(part.window_count, windows, "{text}");
            let before = part.nodes() - part.nodes() / part.windows.len();
            assert!(before < 512, "{text}: a part has no more windows than it needs");
            seen.iter_mut().zip(nodes(part)).for_each(|(seen, row)| seen.extend(row));
        };
        let samples = || Some(SampleStream::new(by, values.clone(), to < from));
        let whole = Wanted { samples: samples(), sums: true, ..Wanted::default() };
        let streamed =
            Wanted { samples: samples(), is_streamed: true, sums: true, observer: Some(&mut see), ..Wanted::default() };
        let [whole, streamed] = [whole, streamed].map(|wanted| run(&case, &setup, wanted).0.expect("there is a run"));
        assert!(windows > 1 && windows == whole.line.windows.len(), "{text}");
        assert!(streamed.line.windows.len() < windows || whole.line.nodes() < 512 + 64, "{text}");
        assert_eq!((seen, nodes(&whole.line)), (nodes(&line), nodes(&line)), "{text}");

        let [error, of_parts] = [&whole, &streamed].map(|run| run.judged(&setup, false, false).verdict.error);
        assert_eq!(error, of_parts, "{text}");
        let (last, all) = (&streamed.line, &whole.line);
        assert_eq!((last.end(), last.length), (all.end(), all.length), "{text}");
        assert_eq!((last.gradient_norm, &last.iterations), (all.gradient_norm, &all.iterations), "{text}");
        assert_eq!((last.error_estimate, &streamed.sums), (all.error_estimate, &whole.sums), "{text}");
        assert_eq!(extremes(&streamed.diagnostics), extremes(&whole.diagnostics), "{text}");
        for (one, all) in streamed.diagnostics.work.iter().zip(&whole.diagnostics.work) {
            assert!((one.work - all.work).abs() < 1e-14 && (one.defect - all.defect).abs() < 1e-14, "{text}");
        }
        if let (Some(parts), Some(all)) = (streamed.diagnostics.of_x, whole.diagnostics.of_x) {
            let most = 1e-13 * all.h_bvp_bound.abs();
            assert!((parts.h_bvp - all.h_bvp).abs() < most, "{text}");
            assert!((parts.h_bvp_bound - all.h_bvp_bound).abs() < most, "{text}");
            assert!((parts.defect() - all.defect()).abs() < 10.0 * most, "{text}");
        }

        assert!(case.is_of_x || whole.events.len() >= 2, "{text}");
        assert_eq!(&streamed.samples, &whole.samples, "{text}");
        // Where a formula changes its sign is found from values that are rounded in other places.
        assert_eq!(streamed.events.len(), whole.events.len(), "{text}");
        for (one, all) in streamed.events.iter().zip(&whole.events) {
            let off = one.sample.q.iter().zip(&all.sample.q).map(|(one, all)| (one - all).abs());
            let off = off.fold((one.sample.gamma - all.sample.gamma).abs(), f64::max);
            assert!(one.watch == all.watch && off < 1e-14, "{text}: {off:e}");
        }
        for (sample, &value) in streamed.samples.iter().zip(&values) {
            let expected = if by == Coordinate::Gamma { sampler.at_gamma(value) } else { sampler.at_value(0, value) };
            assert_eq!(Ok(sample), expected.as_ref(), "{text}");
        }
    }
}

/// A run may begin again, and does so here with smaller tolerances: what was handed out before is void then.
#[test]
fn samples_that_are_handed_out_on_the_way_are_those_of_the_whole_run() {
    for further in ["solver.accuracy=1e-9 grid.t_f=90.0", "solver.accuracy=1e-13 grid.t_f=90.0"] {
        let (case, values) = (case(further), (0..=400).map(|k| f64::from(k) * 90.0 / 400.0).collect::<Vec<f64>>());
        let (setup, samples) =
            (case.setup::<f64>(), || Some(SampleStream::new(Coordinate::Value(0), values.clone(), false)));
        let (mut handed, mut parts) = (Vec::new(), 0);
        let mut see = |samples: &[Sample], begins: bool| {
            if begins {
                handed.clear();
            }
            parts += 1;
            handed.extend(samples.iter().cloned());
        };
        let streamed =
            Wanted { samples: samples(), is_streamed: true, of_samples: Some(&mut see), ..Wanted::default() };
        let streamed = run(&case, &setup, streamed).0.expect("there is a run").samples;
        let whole = run(&case, &setup, Wanted { samples: samples(), ..Wanted::default() }).0.expect("there is a run");
        assert!(parts > 1 && streamed.len() < 400 / 2, "{parts} parts, {} samples", streamed.len());
        handed.extend(streamed);
        assert_eq!(handed, whole.samples, "{further}");
    }
}

#[test]
fn samples_beyond_the_run_are_refused_with_its_range() {
    let overrides = "grid.windows=4 grid.n_gamma=12 grid.gamma_f=2.0 scheme.sbp=GLL12 scheme.form=weak";
    for values in [vec![0.5, 2.5], vec![-0.5, 0.5], vec![2.5, 0.5]] {
        let mut stream = SampleStream::new(Coordinate::Gamma, values.clone(), false);
        let last = solve_in_parts(&case(overrides), &mut |window: &Solution| stream.see(window)).unwrap();
        let range = (0.0, 2.0);
        assert_eq!(stream.finish(&last), Err(NoSamples::Outside(OutsideRun { range })), "{values:?}");
    }
}

#[test]
fn a_failure_on_the_way_ends_the_run() {
    let overrides = "potential={linear={alpha=1.0}} initial.x=0.0 initial.x_dot=0.0 grid.gamma_f=10.0";
    for scheme in ["scheme.sbp=GLL12 grid.n_gamma=12 scheme.form=weak grid.windows=20", "solver.accuracy=1e-8"] {
        let (mut windows, mut furthest) = (0, 0.0);
        let failure = solve_in_parts(&case(&format!("{overrides} {scheme}")), &mut |window: &Solution| {
            windows += 1;
            furthest = window.windows.last().unwrap().gamma[1];
        });
        let failure = failure.unwrap_err();
        assert_eq!(failure.status, Status::OutsideDomain, "{scheme}");
        assert!(windows > 0 && furthest < failure.gamma + 1e-9, "{scheme}: {furthest} and {}", failure.gamma);
    }
}
