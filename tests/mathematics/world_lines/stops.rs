//! Runs to an accuracy that end where a formula changes its sign.

use geodesic_ivp::case::Case;
use geodesic_ivp::engine::{Accuracy, Engine, Failure, POINTS};
use geodesic_ivp::solve::{NoSolution, WorldLine, solve};

use crate::common::{line_of, parsed, shipped};

/// A shipped scene of this length to an accuracy.
fn run(name: &str, length: f64, accuracy: f64, until: Option<String>) -> WorldLine {
    let until = until.map(|formula| format!("grid.until={formula}"));
    let grid = [format!("grid.gamma_f={length:?}"), format!("solver.accuracy={accuracy:e}")];
    let set: Vec<&str> = grid.iter().chain(&until).map(String::as_str).collect();
    line_of(&shipped(name, &set))
}

/// A run is begun again so often.
fn restarts(case: &Case, length: f64, accuracy: f64) -> usize {
    let (geometry, start) = (case.geometry(), case.start());
    let mut engine = Engine::accurate(&geometry, &start, length, Accuracy::Promised(accuracy)).unwrap();
    let mut restarts = 0;
    loop {
        match engine.next() {
            Ok(Some(_)) => {}
            Err(Failure::BeginAgain) => {
                engine.begin_again();
                restarts += 1;
            }
            Ok(None) | Err(_) => return restarts,
        }
    }
}

/// A run that is begun again leaves nothing of the attempts before in a world-line, and forgets on which side of a
/// formula it was: half of the time is left behind once, in the direction that does not count.
#[test]
fn a_run_that_is_begun_again_looks_afresh() {
    let text = "potential = { coordinates = [\"x\", \"y\"], formula = \"-1/sqrt(x^2 + y^2)\" }\n\
                particle.law = \"newtonian\"\n\
                initial = { x = 0.1, y = 0.0, x_dot = 0.0, y_dot = \"sqrt(19)\" }\n\
                events.half = { when = \"30 - t\", direction = \"up\", until = true }\n\
                grid.gamma_f = 60.0\n";
    let mut begun_again = 0;
    for digits in 4..=12 {
        let accuracy = 10.0_f64.powi(-digits);
        let case = parsed(text, &[&format!("solver.accuracy={accuracy:e}")]);
        let line: Result<WorldLine, NoSolution> = solve(&case);
        let restarts = restarts(&case, 60.0, accuracy);
        let Ok(line) = line else { continue };
        begun_again += usize::from(restarts > 0);
        assert_eq!((line.ended_by, line.length, line.window_count), (None, 60.0, line.windows.len()), "{digits}");
        assert!(line.windows.windows(2).all(|pair| pair[0].gamma[1] == pair[1].gamma[0]), "{digits}");
        assert!(line.windows[0].gamma[0] == 0.0 && line.nodes() == line.window_count * POINTS, "{digits}");
    }
    assert!(begun_again > 0);
}

/// A stop at the very joint of two windows, or a few last digits beside it, is found in one of them.
#[test]
fn a_stop_at_a_joint_is_not_missed() {
    for (name, coordinate, length) in [("schwarzschild-orbit", "r", 2000.0), ("double-pendulum", "a", 20.0)] {
        let line = run(name, length, 1e-9, None);
        let (gamma, value) = (line.windows[0].gamma[1], line.joint(1).q[1]);
        for ulps in -4..=4 {
            let value = value + f64::from(ulps) * f64::EPSILON * value.abs();
            let line = run(name, length, 1e-9, Some(format!("{coordinate} - ({value:?})")));
            let off = (line.length - gamma).abs();
            assert!(line.ended_by == Some(0) && off < 1e-10 * gamma, "{name} {ulps}: {}, {gamma}", line.length);
        }
    }
}

/// A thin wall that sends a particle back is met on a run of any length.
#[test]
fn a_wall_is_met_on_a_run_of_any_length() {
    let wall = "metric = { coordinates = [\"t\", \"x\"], \
                components = { \"t t\" = \"9 + x^2/50 + 4*exp(-((x - 2)/1e-4)^2)\", \"x x\" = \"-1\" } }\n\
                initial = { t = 0.0, x = 0.0, t_dot = 1.0, x_dot = 0.5 }\ngrid.until = \"x + 0.5\"\n";
    for accuracy in [1e-4, 1e-9] {
        let [short, long, endless] = [15.0, 1e3, 1e12].map(|length: f64| {
            let set = [format!("grid.gamma_f={length:?}"), format!("solver.accuracy={accuracy:e}")];
            line_of::<f64>(&parsed(wall, &[&set[0], &set[1]])).length
        });
        // Without the wall it comes back after half a period of more than 20.
        assert!(short < 12.0 && (long - short).abs() < 10.0 * accuracy, "{short}, {long}");
        assert!((endless - short).abs() < 10.0 * accuracy, "{short}, {endless}");
    }
}

/// Between the start and the next node a formula may change its sign, whatever its size; and one that stays zero does
/// not.
#[test]
fn a_stop_is_met_right_after_the_start() {
    let rate = shipped("schwarzschild-orbit", &[]).start::<f64>().q_dot[2];
    for factor in ["1e-12", "1", "-1e12"] {
        let line = run("schwarzschild-orbit", 20.0, 1e-9, Some(format!("{factor}*(phi - {:?})", 1e-3 * rate)));
        assert!(line.ended_by == Some(0) && (line.length - 1e-3).abs() < 1e-6, "{factor}: {}", line.length);
    }
    let line = run("schwarzschild-orbit", 20.0, 1e-9, Some("0*phi".to_owned()));
    assert_eq!((line.ended_by, line.length), (None, 20.0));
}
