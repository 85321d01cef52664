//! A run that fails says where: in the γ of the case, and in its own coordinates.

use std::f64::consts::FRAC_PI_2;

use geodesic_ivp::case::Case;
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::solve::{Domain, InitialGuess};
use geodesic_ivp::{Status, solve};

/// From rest at x = 0 the horizon at x = 1 is met after γ − γ_i = π/2.
const FALL: &str = r#"
    initial = { t = 7.0, x = 0.0, t_dot = 1.0, x_dot = 0.0 }
    grid = { gamma_i = 30.0, gamma_f = 35.0, n_gamma = 26 }
    scheme.sbp = "SBP42"
"#;

const GRIDS: [&str; 7] = [
    "grid.windows=10",
    "grid.windows=10 scheme.form='weak'",
    "grid.windows=10 scheme.sbp='SBP21'",
    "grid.windows=10 grid.n_gamma=12 scheme={sbp='GLL12',form='weak'}",
    "grid.windows=10 solver.system='doubled'",
    "grid={gamma_i=30.0,gamma_f=50.0,n_gamma=12} solver.system='doubled'",
    "grid={gamma_i=30.0,gamma_f=35.0} scheme={} solver.accuracy=1e-8",
];

fn settings(set: &str) -> Vec<String> {
    set.split_whitespace().map(str::to_owned).collect()
}

fn check(set: &str, status: Status, gamma: f64) {
    assert_eq!(status, Status::OutsideDomain, "{set}");
    assert!((gamma - 30.0 - FRAC_PI_2).abs() < 0.05, "{set}: {gamma}");
}

/// The iterations of these runs start from this.
fn guess(set: &str) -> InitialGuess {
    match set {
        _ if set.contains("accuracy") => InitialGuess::Extrapolation,
        _ if set.contains("SBP21") => InitialGuess::None,
        _ => InitialGuess::Engine,
    }
}

#[test]
fn of_one_coordinate() {
    for set in GRIDS {
        let text = format!("potential = {{ linear = {{ alpha = -0.5 }} }}\n{FALL}");
        let case = Case::parse("test", &text, &settings(set)).unwrap_or_else(|error| panic!("{error}"));
        let failure = solve::<f64>(&case).unwrap_err();
        check(set, failure.status, failure.gamma);
        assert_eq!(failure.iterations.initial_guess, guess(set), "{set}");
        // The metric is that of the point: g00 = 1 − x.
        let (Domain::G00(g00), [(name, x)]) = (&failure.domain, &failure.point[..]) else { panic!("{failure:?}") };
        assert!(name == "x" && (g00 + x - 1.0).abs() < 1e-14 && *g00 <= 0.0, "{failure:?}");
    }
}

#[test]
fn of_scenes() {
    for set in GRIDS {
        let text = format!("potential = {{ coordinates = [\"x\"], formula = \"-x/2\" }}\n{FALL}");
        let case = Case::parse("test", &text, &settings(set)).unwrap_or_else(|error| panic!("{error}"));
        let failure = solve::<f64>(case.setup()).unwrap_err();
        check(set, failure.status, failure.gamma);
        assert_eq!(failure.iterations.initial_guess, guess(set), "{set}");
        assert!(matches!(failure.domain, Domain::Determinant { value, .. } if value < 0.0), "{failure:?}");
    }
}

/// An iteration that is stopped has a largest residual somewhere, which is a point near the motion.
#[test]
fn of_a_stopped_iteration_the_place_is_on_the_way() {
    let rest = "initial = { t = 7.0, t_dot = 1.3, x = 1.0, x_dot = 0.4 }\n\
                grid = { gamma_i = 30.0, gamma_f = 34.0, n_gamma = 81 }\nsolver.max_iterations = 1\n";
    let exact =
        Case::parse("test", &format!("potential.formula.expression = \"x^4/2\"\n{rest}scheme.sbp=\"SBP42\""), &[]);
    let exact = exact.unwrap();
    let reference = ReferenceTrajectory::<f64>::new(&exact.geometry(), &exact.start(), 4.0, 16).unwrap();
    for scheme in [
        "scheme = { sbp = \"SBP42\" }",
        "scheme = { sbp = \"SBP21\", form = \"weak\" }",
        "scheme = { sbp = \"SBP63\" }\nsolver.system = \"doubled\"",
    ] {
        let one = format!("potential.formula.expression = \"x^4/2\"\n{rest}{scheme}");
        let one = solve::<f64>(&Case::parse("test", &one, &[]).unwrap()).unwrap_err();
        let scene = format!("potential = {{ coordinates = [\"x\"], formula = \"x^4/2\" }}\n{rest}{scheme}");
        let scene = solve::<f64>(&Case::parse("test", &scene, &[]).unwrap().setup()).unwrap_err();
        for failure in [one, scene] {
            assert_eq!(failure.status, Status::MaxIterations, "{scheme}: {failure}");
            let [(name, x)] = &failure.point[..] else { panic!("{scheme}: {failure:?}") };
            assert!(name == "x" && (30.0..=34.0).contains(&failure.gamma), "{scheme}: {failure:?}");
            let there = reference.at(failure.gamma - 30.0).q[1];
            assert!((x - there).abs() < 0.05, "{scheme}: {x} for {there} at {}", failure.gamma);
        }
    }
}

#[test]
fn of_a_stopped_iteration_of_two_coordinates_the_place_is_on_the_way() {
    for scheme in ["{ sbp = 'SBP42' }", "{ sbp = 'SBP21', form = 'weak' }", "{ sbp = 'SBP63' }"] {
        let text = format!(
            "potential = {{ coordinates = ['x', 'y'], formula = 'x^4/2 + 2*y^2 + x^2*y/3' }}\n\
             particle.law = 'newtonian'\ninitial = {{ t_dot = 1.0, x = 1.0, y = 0.5, x_dot = 0.0, y_dot = 0.0 }}\n\
             grid = {{ gamma_i = 30.0, gamma_f = 34.0, n_gamma = 41 }}\nsolver.max_iterations = 1\nscheme = {scheme}"
        );
        let case = Case::parse("test", &text, &[]).unwrap_or_else(|error| panic!("{error}"));
        let setup = case.setup();
        let failure = solve::<f64>(&setup).unwrap_err();
        assert_eq!(failure.status, Status::MaxIterations, "{scheme}: {failure}");
        let [(a, x), (b, y)] = &failure.point[..] else { panic!("{scheme}: {failure:?}") };
        let reference = ReferenceTrajectory::new(&*setup.place.geometry, &setup.place.start, 4.0, 16).unwrap();
        assert!(a == "x" && b == "y" && (30.0..=34.0).contains(&failure.gamma), "{scheme}: {failure:?}");
        let there = reference.at(failure.gamma - 30.0).q;
        assert!((x - there[1]).abs().max((y - there[2]).abs()) < 0.05, "{scheme}: {x}, {y} for {there:?}");
    }
}

/// At the last node there is a place, too.
#[test]
fn of_a_stopped_iteration_the_place_may_be_the_last_node() {
    let text = "potential = { coordinates = ['x', 'y'], formula = 'x^4/2 + 2*y^2 + x^2*y/3' }\n\
                particle.law = 'newtonian'\ninitial = { t_dot = 1.0, x = 1.0, y = 0.5, x_dot = 0.0, y_dot = 0.0 }\n\
                grid = { gamma_f = 4.0, n_gamma = 12 }\nsolver.max_iterations = 1\n\
                scheme = { sbp = 'GLL12', form = 'weak' }";
    let case = Case::parse("test", text, &[]).unwrap_or_else(|error| panic!("{error}"));
    let failure = solve::<f64>(case.setup()).unwrap_err();
    let names: Vec<&str> = failure.point.iter().map(|(name, _)| &name[..]).collect();
    assert_eq!((failure.gamma, &names[..]), (4.0, &["x", "y"][..]), "{failure}");
}

/// A grid that does not resolve a force of many periods is no end of the domain, in any unit of V and c².
#[test]
fn of_a_grid_that_is_too_coarse() {
    for unit in [1.0_f64, 1e-6] {
        let (c, t_dot) = (30.0 * unit.sqrt(), 1.0 / unit.sqrt());
        let (formula, rest) = (
            format!("{unit:?}*sin(1000*x)"),
            format!(
                "particle.c = {c:?}\ninitial = {{ t_dot = {t_dot:?}, x = 0.9, x_dot = -0.3 }}\n\
                 grid = {{ gamma_i = 30.0, gamma_f = 34.0, n_gamma = 8 }}\nscheme.sbp = 'SBP21'\n\
                 solver.system = 'doubled'"
            ),
        );
        let one = Case::parse("test", &format!("potential.formula.expression = '{formula}'\n{rest}"), &[]).unwrap();
        let scene = format!("potential = {{ coordinates = ['x'], formula = '{formula}' }}\n{rest}");
        let scene = Case::parse("test", &scene, &[]).unwrap();
        let (one, scene) = (solve::<f64>(&one).unwrap_err(), solve::<f64>(&scene.setup()).unwrap_err());
        for failure in [one, scene] {
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
        let one = Case::parse("test", &format!("potential.formula.expression = '0*x'\n{rest}"), &[]).unwrap();
        let scene = format!("potential = {{ coordinates = ['x'], formula = '0*x' }}\n{rest}");
        let scene = Case::parse("test", &scene, &[]).unwrap();
        for failure in [solve::<f64>(&one).unwrap_err(), solve::<f64>(&scene.setup()).unwrap_err()] {
            assert_eq!(failure.status, Status::OutsideDomain, "{scheme}: {failure}");
            assert!((1.6e108..1.9e108).contains(&failure.gamma), "{scheme}: {}", failure.gamma);
        }
    }
}

/// Positions and times are finite, and so is the gradient. The squares of velocities are not, and with them K.
#[test]
fn of_velocities_whose_squares_overflow() {
    let one = "potential.formula.expression = 'exp(101/x+pi)'\ninitial = { t_dot = 1.0, x = 0.3, x_dot = 0.2 }\n\
               grid.n_gamma = 16\nscheme.sbp = 'SBP21'";
    let scene = "potential = { coordinates = ['x'], formula = '1/x^20' }\n\
                 initial = { t_dot = 1.0, x = 1e-8, x_dot = 0.2 }\ngrid.n_gamma = 12\nscheme.sbp = 'SBP21'";
    let (one, scene) = (Case::parse("test", one, &[]).unwrap(), Case::parse("test", scene, &[]).unwrap());
    let failure = solve::<f64>(&one).unwrap_err();
    assert!(failure.point[0].1.abs() > 1e154 && failure.point[0].1.is_finite(), "{failure}");
    for failure in [failure, solve::<f64>(&scene.setup()).unwrap_err()] {
        assert_eq!((failure.status, failure.gamma), (Status::OutsideDomain, 1.0), "{failure}");
    }
}

/// (dx/dγ)² is finite, and its integral over a window is not.
#[test]
fn of_a_window_whose_action_overflows() {
    for (length, is_finite) in [(1e2, true), (1e5, false)] {
        let text = format!(
            "potential.free = {{}}\ninitial = {{ t = 0.0, x = 0.0, t_dot = 1.0, x_dot = 1e152 }}\n\
             grid = {{ gamma_f = {length:?}, n_gamma = 12 }}\nscheme = {{ sbp = 'GLL12', form = 'weak' }}"
        );
        let solved = solve::<f64>(&Case::parse("test", &text, &[]).unwrap());
        assert_eq!(solved.as_ref().err().map(|failure| failure.status), (!is_finite).then_some(Status::OutsideDomain));
    }
}
