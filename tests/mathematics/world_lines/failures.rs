//! A run that fails says where: in the γ of the case, and in its own coordinates.

use std::f64::consts::FRAC_PI_2;

use geodesic_ivp::solve::{Domain, InitialGuess, NoSolution};
use geodesic_ivp::{Case, Status, solve};

use crate::common::{one_and_scene, parsed, reference, shipped};

/// From rest at x = 0 the horizon at x = 1 is met after γ − γ_i = π/2.
const FALL: &str = r#"
    initial = { t = 7.0, x = 0.0, t_dot = 1.0, x_dot = 0.0 }
    grid = { gamma_i = 30.0, gamma_f = 35.0, n_gamma = 26 }
    scheme.sbp = "SBP42"
"#;

/// Grids, and from what the iterations start there.
const GRIDS: [(&str, InitialGuess); 7] = [
    ("grid.windows=10", InitialGuess::Engine),
    ("grid.windows=10 scheme.form='weak'", InitialGuess::Engine),
    ("grid.windows=10 scheme.sbp='SBP21'", InitialGuess::None),
    ("grid.windows=10 grid.n_gamma=12 scheme={sbp='GLL12',form='weak'}", InitialGuess::Engine),
    ("grid.windows=10 solver.system='doubled'", InitialGuess::Engine),
    ("grid={gamma_i=30.0,gamma_f=50.0,n_gamma=12} solver.system='doubled'", InitialGuess::Engine),
    ("grid={gamma_i=30.0,gamma_f=35.0} scheme={} solver.accuracy=1e-8", InitialGuess::Extrapolation),
];

fn failed(case: &Case) -> NoSolution {
    solve::<f64>(case).expect_err("there is no solution")
}

#[test]
fn at_a_horizon_in_one_coordinate_and_in_scenes() {
    for (set, guess) in GRIDS {
        let set: Vec<&str> = set.split(' ').collect();
        for potential in ["linear = { alpha = -0.5 }", "coordinates = ['x'], formula = '-x/2'"] {
            let failure = failed(&parsed(&format!("potential = {{ {potential} }}\n{FALL}"), &set));
            assert_eq!((failure.status, failure.iterations.initial_guess), (Status::OutsideDomain, guess), "{set:?}");
            assert!((failure.gamma - 30.0 - FRAC_PI_2).abs() < 0.05, "{set:?}: {}", failure.gamma);
            match failure.domain {
                // The metric is that of the point: g00 = 1 − x.
                Domain::G00(g00) => {
                    let [(name, x)] = &failure.point[..] else { panic!("{failure:?}") };
                    assert!(name == "x" && (g00 + x - 1.0).abs() < 1e-14 && g00 <= 0.0, "{failure:?}");
                    assert!(potential.starts_with("linear"));
                }
                Domain::Determinant { value, .. } => assert!(value < 0.0 && potential.ends_with("'-x/2'")),
                _ => panic!("{failure:?}"),
            }
        }
    }
    for (sbp, system) in ["SBP21", "SBP42"].iter().flat_map(|sbp| ["physical-limit", "doubled"].map(|s| (sbp, s))) {
        let set = ["scheme.form=weak", &format!("solver.system={system}"), &format!("scheme.sbp={sbp}")];
        let failure = failed(&shipped("horizon", &set));
        assert_eq!(failure.status, Status::OutsideDomain, "{sbp} {system}: {failure}");
    }
}

/// An iteration that is stopped has a largest residual somewhere, which is a point near the motion.
#[test]
fn of_a_stopped_iteration_the_place_is_on_the_way() {
    let rest = "initial = { t = 7.0, t_dot = 1.3, x = 1.0, x_dot = 0.4 }\n\
                grid = { gamma_i = 30.0, gamma_f = 34.0, n_gamma = 81 }\nscheme.sbp = 'SBP42'\n";
    let plane = "potential = { coordinates = ['x', 'y'], formula = 'x^4/2 + 2*y^2 + x^2*y/3' }\n\
                 particle.law = 'newtonian'\ninitial = { t_dot = 1.0, x = 1.0, y = 0.5, x_dot = 0.0, y_dot = 0.0 }\n\
                 grid = { gamma_i = 30.0, gamma_f = 34.0, n_gamma = 41 }\nscheme.sbp = 'SBP42'\n";
    let [one, scene] = one_and_scene("x^4/2", rest);
    for case in [one, scene, parsed(plane, &[])] {
        let reference = reference(&case.geometry(), &case.start(), 4.0);
        for scheme in [
            "scheme={sbp='SBP42'} solver.max_iterations=1",
            "scheme={sbp='SBP21',form='weak'} solver.max_iterations=1",
            "scheme={sbp='SBP63'} solver.max_iterations=1 solver.system='doubled'",
        ] {
            let failure = failed(&parsed(&case.to_toml(), &scheme.split(' ').collect::<Vec<_>>()));
            assert_eq!(failure.status, Status::MaxIterations, "{scheme}: {failure}");
            assert!((30.0..=34.0).contains(&failure.gamma), "{scheme}: {failure:?}");
            let there = reference.at(failure.gamma - 30.0).q;
            for ((name, found), (known, a)) in failure.point.iter().zip(["x", "y"].into_iter().zip(1..)) {
                assert!(name == known && (found - there[a]).abs() < 0.05, "{scheme}: {failure:?} for {there:?}");
            }
        }
    }
    // At the last node there is a place, too.
    let set = ["grid={gamma_f=4.0,n_gamma=12}", "scheme={sbp='GLL12',form='weak'}", "solver.max_iterations=1"];
    let failure = failed(&parsed(plane, &set));
    let names: Vec<&str> = failure.point.iter().map(|(name, _)| &name[..]).collect();
    assert_eq!((failure.gamma, &names[..]), (4.0, &["x", "y"][..]), "{failure}");
}

/// A grid that does not resolve a force of many periods is no end of the domain, in any unit of V and c².
#[test]
fn of_a_grid_that_is_too_coarse() {
    for unit in [1.0_f64, 1e-6] {
        let (c, t_dot) = (30.0 * unit.sqrt(), 1.0 / unit.sqrt());
        let rest = format!(
            "particle.c = {c:?}\ninitial = {{ t_dot = {t_dot:?}, x = 0.9, x_dot = -0.3 }}\n\
             grid = {{ gamma_i = 30.0, gamma_f = 34.0, n_gamma = 8 }}\nscheme.sbp = 'SBP21'\n\
             solver.system = 'doubled'"
        );
        for failure in one_and_scene(&format!("{unit:?}*sin(1000*x)"), &rest).map(|case| failed(&case)) {
            assert!([Status::Stalled, Status::Singular].contains(&failure.status), "{unit}: {failure}");
            assert!((30.0..=34.0).contains(&failure.gamma), "{unit}: {failure}");
        }
    }
}

/// Windows that are finite each, and a sum that is not: after 18 of them Q_t t, the action from the start, is beyond
/// the range of numbers.
#[test]
fn of_an_action_that_overflows() {
    for scheme in ["sbp = 'SBP42'", "sbp = 'SBP21', form = 'weak'", "sbp = 'GLL12', form = 'weak'", "sbp = 'GLL12'"] {
        let rest = format!(
            "initial = {{ t = 0.0, t_dot = 1e100, x = 1.0, x_dot = 0.0 }}\nscheme = {{ {scheme} }}\n\
             grid = {{ gamma_f = 2e108, n_gamma = 12, windows = 20 }}\n"
        );
        for failure in one_and_scene("0*x", &rest).map(|case| failed(&case)) {
            assert_eq!(failure.status, Status::OutsideDomain, "{scheme}: {failure}");
            assert!((1.6e108..1.9e108).contains(&failure.gamma), "{scheme}: {}", failure.gamma);
        }
    }
    // (dx/dγ)² is finite, and its integral over a window is not.
    for (length, is_finite) in [(1e2, true), (1e5, false)] {
        let text = format!(
            "potential.free = {{}}\ninitial = {{ t = 0.0, x = 0.0, t_dot = 1.0, x_dot = 1e152 }}\n\
             grid = {{ gamma_f = {length:?}, n_gamma = 12 }}\nscheme = {{ sbp = 'GLL12', form = 'weak' }}"
        );
        let status = solve::<f64>(&parsed(&text, &[])).err().map(|failure| failure.status);
        assert_eq!(status, (!is_finite).then_some(Status::OutsideDomain));
    }
}

/// Positions and times are finite, and so is the gradient. The squares of velocities are not, and with them K.
#[test]
fn of_velocities_whose_squares_overflow() {
    let one = "potential.formula.expression = 'exp(101/x+pi)'\ninitial = { t_dot = 1.0, x = 0.3, x_dot = 0.2 }\n\
               grid = { gamma_f = 1, n_gamma = 16 }\nscheme.sbp = 'SBP21'";
    let scene = "potential = { coordinates = ['x'], formula = '1/x^20' }\n\
                 initial = { t_dot = 1.0, x = 1e-8, x_dot = 0.2 }\n\
                 grid = { gamma_f = 1, n_gamma = 12 }\nscheme.sbp = 'SBP21'";
    for (text, is_one) in [(one, true), (scene, false)] {
        let failure = failed(&parsed(text, &[]));
        assert_eq!((failure.status, failure.gamma), (Status::OutsideDomain, 1.0), "{failure}");
        let is_large = |x: f64| x.abs() > 1e154 && x.is_finite();
        assert!(!is_one || is_large(failure.point[0].1), "{failure}");
    }
}
