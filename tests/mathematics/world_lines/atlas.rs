//! The atlas of scenes: what its cells say of the runs, and that units do not matter.

use std::sync::atomic::AtomicBool;

use geodesic_ivp::Case;
use geodesic_ivp::action::Form;
use geodesic_ivp::methods::{Dop853, Output, Peer, Problem, Rk4, Setting};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::sbp::SbpName;
use geodesic_ivp::solve::Setup;
use geodesic_ivp::study::stability::{Arena, Cell, CellStatus, Method, Plan, measure};

fn scene(text: &str) -> Case {
    Case::parse("test", text, &[]).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn charted(arena: &Arena, methods: Vec<Method>, length: f64, spacings: &[f64]) -> Vec<Cell> {
    let plan = Plan { methods, lengths: vec![length], tangents: vec![1.0], spacings: spacings.to_vec() };
    measure(arena, &plan, &AtomicBool::new(false), &|_, _| {}).cells
}

/// m = 2 in V = x² + 2y² + x²y/3.
fn motion(law: &str) -> Case {
    scene(&format!(
        r#"
        potential = {{ coordinates = ["x", "y"], formula = "x^2 + 2*y^2 + x^2*y/3" }}
        particle = {{ {law}, mass = 2.0 }}
        initial = {{ t = 1.0, t_dot = 3.0, x = 0.6, y = -0.2, x_dot = 0.9, y_dot = 1.5 }}
        grid = {{ gamma_f = 2.0, n_gamma = 41 }}
        scheme.sbp = "SBP21"
        "#
    ))
}

#[test]
fn k_and_energy_of_another_method_are_those_of_its_states() {
    for law in ["law = \"newtonian\"", "c = 9.0"] {
        let case = motion(law);
        let setup: Setup = case.setup();
        let (geometry, start) = (setup.place.geometry.clone(), setup.place.start.clone());
        let k = geometry.norm(&start.q, &start.q_dot);
        let energy = |q: &[f64], u: &[f64]| {
            let [x, y] = [q[1], q[2]];
            (u[1].powi(2) + u[2].powi(2)) / u[0].powi(2) + x * x + 2.0 * y * y + x * x * y / 3.0
        };
        let begun = energy(&start.q, &start.q_dot);
        let problem = Problem { space: geometry.clone(), start: (*start).clone(), length: 2.0, g00: None };
        let states = Rk4.run(&problem, &Output::even(10), Setting::steps(10)).unwrap().states;
        let (mut delta_k, mut delta_energy) = (0.0_f64, 0.0_f64);
        for state in states.iter() {
            let u = geometry.velocities(state.q, state.p).unwrap();
            delta_k = delta_k.max((geometry.norm(state.q, &u) - k).abs());
            delta_energy = delta_energy.max((energy(state.q, &u) - begun).abs());
        }
        let arena = Arena::new(&case, &[2.0]).unwrap();
        let cells = charted(&arena, vec![Method::Peer(&Rk4)], 2.0, &[0.2]);
        let found = cells[0].numbers.as_ref().unwrap();
        assert!((found.delta_k_max - delta_k).abs() < 1e-9 && delta_k > 1e-4, "{law}: {found:?} for {delta_k}");
        match found.delta_energy_max {
            Some(found) => assert!((found - delta_energy).abs() < 1e-12 && delta_energy > 1e-4, "{found}"),
            None => assert!(law == "c = 9.0" && k.abs() > 1.0),
        }
        let exact = ReferenceTrajectory::new(&*problem.space, &problem.start, 2.0, 16).unwrap();
        assert_eq!(arena.reference_error(), exact.error_estimate(), "{law}");
    }
}

/// Steps of different lengths have no sawtooth.
#[test]
fn a_sawtooth_is_one_of_equal_steps() {
    let arena = Arena::new(&motion("c = 9.0"), &[2.0]).unwrap();
    let sawtooth = |peer: &'static dyn Peer| {
        let cells = charted(&arena, vec![Method::Peer(peer)], 2.0, &[0.1]);
        cells.iter().map(|cell| cell.numbers.as_ref().unwrap().sawtooth).collect::<Vec<_>>()
    };
    assert!(sawtooth(&Rk4).iter().all(Option::is_some));
    assert!(!sawtooth(&Dop853).is_empty() && sawtooth(&Dop853).iter().all(Option::is_none));
}

#[test]
fn a_status_does_not_depend_on_the_unit_of_gamma() {
    let methods: Vec<Method> =
        Method::all().into_iter().filter(|m| !m.is_adaptive() && m.unsuitable(true).is_none()).collect();
    let of = |factor: f64| {
        let start = format!("{{ x = 1.0, t_dot = {factor:?}, x_dot = {:?} }}", 0.1 * factor);
        let text = format!(
            "potential = {{ coordinates = [\"x\"], formula = \"x^4/2\" }}\ninitial = {start}\ngrid.n_gamma = 32\n\
             scheme.sbp = \"SBP21\""
        );
        Arena::new(&scene(&text), &[20.0 / factor]).unwrap()
    };
    let map = |factor: f64| {
        let spacings = [0.05, 0.1, 0.2].map(|spacing| spacing / factor);
        charted(&of(factor), methods.clone(), 20.0 / factor, &spacings)
    };
    let omega = |factor: f64| of(factor).omega() / factor;
    assert!((omega(1e-5) / omega(1.0) - 1.0).abs() < 1e-3, "{} and {}", omega(1e-5), omega(1.0));
    let one = map(1.0);
    assert!(one.iter().any(|cell| cell.status == CellStatus::Accurate) && one.len() > 40);
    for factor in [0.01, 100.0] {
        for (here, there) in map(factor).iter().zip(&one) {
            assert_eq!((&here.method, here.status), (&there.method, there.status), "{factor}: {here:?} {there:?}");
        }
    }
}

#[test]
fn a_cell_that_fails_names_its_grid() {
    let falls = r#"
        potential = { coordinates = ["x"], formula = "-x/2" }
        initial = { x = 0.0, t_dot = 1.0, x_dot = 0.0 }
        grid = { gamma_f = 5.0, n_gamma = 51 }
        scheme.sbp = "SBP42"
    "#;
    let arena = Arena::new(&scene(falls), &[5.0]).unwrap();
    for cell in charted(&arena, vec![Method::Peer(&Dop853)], 5.0, &[]) {
        // A method that chooses its steps has none to name.
        assert!(cell.numbers.is_some() || cell.n_gamma.is_none() && cell.delta_gamma_omega.is_none(), "{cell:?}");
        assert!(cell.numbers.is_none() || cell.setting > 1e-2, "{cell:?}");
    }
    for cell in charted(&arena, vec![Method::Block(SbpName::Sbp42, Form::Weak)], 5.0, &[0.05, 0.1]) {
        assert_eq!(cell.status, CellStatus::OutsideDomain);
        assert_eq!(cell.n_gamma, Some((5.0 / cell.setting).round() as usize + 1), "{cell:?}");
    }
}
