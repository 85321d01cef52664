//! A run tells its error and its last velocity.

use std::ops::ControlFlow;

use std::borrow::Cow;

use geodesic_ivp::Solution;
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::engine::{Accuracy, Engine};
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::output::tables::{trajectory, write_nodes};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::solve::{Setup, WorldLine, solve_in_parts};
use geodesic_ivp::study::errors::{Judge, RunError, run_error};
use geodesic_ivp::trajectory::{Coordinate, SampleStream};

use crate::common::{case, line_of, parsed, reference, reference_of, solved, solved_in};

/// The largest errors of the coordinates over the nodes, and those at the end, against a Taylor trajectory.
fn true_errors<S: Real>(line: &WorldLine<S>) -> [Vec<f64>; 2] {
    let (reference, n) = (reference_of(line), line.geometry().dimension());
    let rows: Vec<Vec<S>> = (0..n).map(|a| line.q(a).collect()).collect();
    let (mut largest, mut last) = (vec![0.0_f64; n], vec![0.0; n]);
    for (k, gamma) in line.gamma_from_start().enumerate() {
        let exact = reference.at(gamma).q;
        last = (0..n).map(|a| (rows[a][k] - exact[a]).to_f64().abs()).collect();
        largest.iter_mut().zip(&last).for_each(|(largest, last)| *largest = largest.max(*last));
    }
    [largest, last]
}

#[test]
fn every_scheme_knows_its_error() {
    let schemes = [
        "scheme.sbp=SBP21",
        "scheme.sbp=SBP42",
        "scheme.sbp=SBP63 grid.n_gamma=64",
        "scheme.sbp=SBP84 grid.n_gamma=64",
        "scheme.sbp=SBP42 scheme.form=weak",
        "scheme.sbp=SBP21 scheme.form=weak grid.windows=4",
        "scheme.sbp=SBP42 solver.system=doubled",
        "scheme.sbp=GLL8 scheme.form=weak grid.n_gamma=8 grid.windows=2",
        "scheme.sbp=SBP42 grid.gamma_f=100.0 grid.n_gamma=2001",
        "scheme.sbp=SBP42 potential={formula={expression=\"1-cos(x)\",parameters={}}} grid.gamma_f=5.0",
        "scheme.sbp=SBP42 initial.t_dot=-1.0 initial.x_dot=-0.1",
        "scheme.sbp=GLL24 scheme.form=weak grid.n_gamma=24",
    ];
    let plane = "potential = { coordinates = ['x', 'y'], formula = 'x^2 + 2*y^2 + x^2*y/3' }\n\
                 particle = { law = 'newtonian', mass = 2.0 }\n\
                 initial = { t = 1.0, t_dot = 3.0, x = 0.6, y = -0.2, x_dot = 0.9, y_dot = 1.5 }\n\
                 grid = { gamma_f = 2.0, n_gamma = 41 }\nscheme.sbp = 'SBP21'\n";
    for case in schemes.map(case).into_iter().chain([parsed(plane, &[])]) {
        let (line, text): (WorldLine, _) = (line_of(&case), case.to_toml());
        let error = run_error(&case.setup(), &line, &[]).unwrap();
        let (end, largest, judge) = (error.at_most_at_end(), error.at_most(), error.judge);
        assert!(matches!(judge, Judge::SecondSolve(_)), "{text}");
        let [true_largest, true_end] = true_errors(&line);
        for (found, known) in largest.iter().zip(&true_largest).chain(end.iter().zip(&true_end)) {
            assert!(*known <= found * (1.0 + 1e-9) && *found <= 1.01 * known + 2e-11, "{found} for {known} in\n{text}");
        }
    }
}

#[test]
fn an_error_below_the_digits_of_f64_is_seen_by_a_series_in_the_precision_of_the_run() {
    let scheme = "scheme.sbp=GLL24 scheme.form=weak grid.n_gamma=24 grid.windows=4 solver.digits=40";
    let solution: Solution<Extended> = solved_in(scheme);
    let error = run_error(&Setup::from(&case(scheme)), &solution, &[]).unwrap();
    let [_, true_end] = true_errors(&solution);
    assert!(matches!(error.judge, Judge::Taylor(own) if own < 1e-38));
    assert!(error.at_most_at_end()[1] > 0.0 && error.at_most_at_end()[1] < 1e-20, "{:?}", error.end);
    for (found, wanted) in error.at_most_at_end().into_iter().zip(true_end) {
        assert!(wanted <= found && found < 1.1 * wanted, "{found} for {wanted}");
    }
}

#[test]
fn where_the_time_is_given_an_error_of_t_is_one_of_x() {
    fn error_of_x<S: Real>(scheme: &str) -> (f64, RunError) {
        let (solution, case): (Solution<S>, _) = (solved_in(scheme), case(scheme));
        let (geometry, start, digits) = (case.geometry::<S>(), case.start::<S>(), solution.digits);
        let duration = S::from_decimal("1.2").unwrap();
        let length = ReferenceTrajectory::length_of(&geometry, &start, 0, duration, digits).unwrap();
        let exact = ReferenceTrajectory::new(&geometry, &start, length, digits).unwrap().at(length);
        let error = run_error(&Setup::from(&case), &solution, &[]).unwrap();
        assert_eq!(error.at_most_at_end()[0], 0.0, "{scheme}");
        ((solution.end_state().x - exact.q[1]).abs().to_f64(), error)
    }
    let to_accuracy = "solver.accuracy=1e-9 grid.t_f=1.2";
    let error = run_error(&Setup::from(&case(to_accuracy)), &solved(to_accuracy), &[]).unwrap();
    assert_eq!(error.at_most_at_end()[0], 0.0);
    let (off, error) = error_of_x::<f64>("scheme.sbp=SBP42 grid.t_f=1.2");
    let most = error.at_most_at_end()[1];
    assert!(off <= most && most < 1.05 * off + 1e-11, "{off} and {most}");
    // Beyond the digits of f64, too.
    let elements = "scheme.sbp=GLL20 scheme.form=weak grid={t_f=1.2,n_gamma=20,windows=3} solver.digits=40";
    let (off, error) = error_of_x::<Extended>(elements);
    assert!(matches!(error.judge, Judge::Taylor(_)), "{error:?}");
    assert!(off > 1e-36 && (error.at_most_at_end()[1] / off - 1.0).abs() < 1e-3, "{off:e} and {error:?}");
}

#[test]
fn samples_take_the_place_of_nodes_that_are_gone() {
    let scheme = "scheme.sbp=SBP42 grid={gamma_i=3.0,gamma_f=35.0,n_gamma=33,windows=64} initial.t=7.0";
    let case = case(scheme);
    let marks = (0..=640).map(|k| 3.0 + 0.05 * f64::from(k)).collect();
    let mut stream = SampleStream::new(Coordinate::Gamma, marks, false);
    let last = solve_in_parts(Setup::from(&case), &mut |window: &Solution| stream.see(window)).unwrap();
    let mut samples = stream.finish(&last).unwrap();
    let reference = reference(&case.geometry(), &case.start(), 32.0);
    let off = |gamma: f64, t: f64, x: f64| {
        let exact = reference.at(gamma - 3.0);
        [(t - 7.0 - exact.q[0]).abs(), (x - exact.q[1]).abs()]
    };
    let larger = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].max(b[1])];
    let first = last.gamma().next().unwrap();
    assert!(first > 26.0, "the last windows are kept: {first}");
    let nodes = last.gamma().zip(last.t()).zip(last.x()).map(|((gamma, t), &x)| off(gamma, t, x));
    let before = samples.iter().filter(|sample| sample.gamma < first);
    let largest = before.map(|sample| off(sample.gamma, sample.q[0], sample.q[1])).chain(nodes).fold([0.0; 2], larger);
    // In either order.
    for _ in 0..2 {
        let found = run_error(&Setup::from(&case), &last, &samples).unwrap();
        for (found, wanted) in found.at_most().into_iter().zip(largest) {
            assert!((found - wanted).abs() < 1e-10 + 1e-6 * wanted && wanted > 1e-9, "{found:e} for {wanted:e}");
        }
        samples.reverse();
    }
    // The samples before the last window count.
    samples[3].q[1] += 0.5;
    let found = run_error(&Setup::from(&case), &last, &samples).unwrap().at_most()[1];
    assert!((found - 0.5).abs() < 1e-2, "{found}");
}

/// The series is asked for where a second solve agrees to its last digits, in both coordinates, relative to their
/// sizes; and only where the run has more digits than that.
#[test]
fn a_series_is_asked_for_where_a_second_solve_sees_nothing() {
    let judge = |overrides: &str| {
        let solution: Solution<Extended> = solved_in(&format!("{overrides} solver.digits=40"));
        run_error(&Setup::from(&case(overrides)), &solution, &[]).unwrap().judge
    };
    let fine = "scheme.sbp=GLL24 scheme.form=weak grid={gamma_f=1.0,n_gamma=24,windows=4}";
    let in_f64 = run_error(&Setup::from(&case(fine)), &solved(fine), &[]).unwrap();
    assert!(matches!(in_f64.judge, Judge::SecondSolve(_)) && in_f64.at_most()[1] < 1e-11, "{in_f64:?}");
    for far in ["t=0.0,x=1.0,t_dot=1e4,x_dot=0.1", "t=0.0,x=-5e3,t_dot=1.0,x_dot=1e4"] {
        let far = format!("{fine} potential={{linear={{alpha=1e-4}}}} initial={{{far}}} particle.c=10.0");
        assert!(matches!(judge(&far), Judge::Taylor(_)), "{far}");
    }
    // In a weak field the time is exact to far more digits than the place.
    let slow = "potential={polynomial={coefficients=[0.0,0.0,0.5]}} particle.c=1e6 scheme.sbp=SBP42 grid.n_gamma=33";
    assert!(matches!(judge(slow), Judge::SecondSolve(_)));
}

/// Its own estimate, which is relative to the sizes of t and x, is a part of the error that a second solve finds.
#[test]
fn the_error_of_a_second_solve_counts_in_units_of_the_sizes() {
    let overrides = "potential={linear={alpha=1e-4}} particle.c=10.0 scheme.sbp=GLL24 \
                     scheme.form=weak grid={gamma_f=3.0,n_gamma=24,windows=12} \
                     initial={t=0.0,x=-30.0,t_dot=100.0,x_dot=2.0}";
    let (geometry, start) = (case(overrides).geometry::<f64>(), case(overrides).start::<f64>());
    let mut engine = Engine::accurate(&geometry, &start, 3.0, Accuracy::Estimated(1e-13)).unwrap();
    engine.run(|_| ControlFlow::Continue(())).unwrap();
    let own = engine.error_estimate().unwrap();
    let (solution, error) =
        (solved(overrides), run_error(&Setup::from(&case(overrides)), &solved(overrides), &[]).unwrap());
    let t = solution.duration().abs();
    let x = solution.x().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    assert!(t > 100.0 && x >= 30.0 && error.judge == Judge::SecondSolve(own));
    for (found, size) in error.at_most().into_iter().zip([t, x]) {
        assert!(found >= own * size && found < (own + 2e-14) * size, "{found:e}, {own:e}, {size}");
    }
}

#[test]
fn the_last_row_of_a_trajectory_is_a_velocity() {
    let well = "potential={polynomial={coefficients=[0.0,0.0,-0.25,0.0,0.25]}} initial.x=0.4 grid.gamma_f=8.0";
    for scheme in ["scheme.sbp=SBP21 grid.n_gamma=64", "scheme.sbp=SBP42 grid.n_gamma=32 grid.windows=2"] {
        let overrides = format!("{well} {scheme}");
        let solution = solved(&overrides);
        let diagnostics = Diagnostics::new(&solution);
        let exact = reference_of(&solution).at(8.0);
        let last = solution.x().len() - 1;
        let off = |tangent: &[Vec<f64>]| {
            (tangent[0][last] - exact.q_dot[0]).abs().max((tangent[1][last] - exact.q_dot[1]).abs())
        };
        let tangent: Vec<Vec<f64>> = diagnostics.tangent(&solution).into_iter().map(Cow::into_owned).collect();
        let of_operator = &diagnostics.q_dot;
        assert!(off(&tangent) < 0.1 * off(of_operator), "{} and {}", off(&tangent), off(of_operator));
        assert_eq!(tangent[0][..32 - 1], of_operator[0][..32 - 1], "all others are the operator's");

        let mut table = Vec::new();
        write_nodes(&mut table, &[(&solution, &diagnostics)], 1, trajectory).unwrap();
        let text = String::from_utf8(table).unwrap();
        let row: Vec<f64> = text.lines().last().unwrap().split(',').map(|field| field.parse().unwrap()).collect();
        assert_eq!(row[3..5], [tangent[0][last], tangent[1][last]]);
        assert_eq!(row[4], solution.end_state().x_dot);
    }
}
