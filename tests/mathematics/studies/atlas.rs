//! The atlas: the grids that it chooses, and what its cells say of the runs.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use geodesic_ivp::action::Form;
use geodesic_ivp::case::Case;
use geodesic_ivp::methods::{Output, Peer, Problem, Setting, State};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::sbp::SbpName;
use geodesic_ivp::study::stability::{Arena, Cell, CellStatus, Method, Pace, Plan, measure};

use super::charted;
use crate::common::{case, norm_of, one_and_scene, parsed, reference, start};

/// The cells over the length 4.
fn over_four(arena: &Arena, methods: Vec<Method>, spacing: f64) -> Vec<Cell> {
    charted(arena, methods, &[4.0], &[spacing]).cells
}

#[test]
fn default_grids_go_with_the_pace_of_the_motion() {
    let rate = 20.0;
    for (formula, is_growth) in [("200*x^2", false), ("-200*x^2", true)] {
        let potential = format!("potential={{formula={{expression=\"{formula}\"}}}} particle.c=1e4");
        // Far out, where a motion that grows has met its horizon.
        let far = if is_growth { 0.25 } else { 20.0 };
        for own in [0.5, 0.777, far] {
            let arena = Arena::new(
                &case(&format!("{potential} grid.gamma_f={own:?} initial={{t=0.0,x=1e-9,t_dot=1.0,x_dot=0.0}}")),
                &[own],
            )
            .unwrap();
            assert_eq!(matches!(arena.pace, Pace::Growth(_)), is_growth);
            assert!((arena.pace.rate() / rate - 1.0).abs() < 1e-3, "{:?}", arena.pace);
            assert!(arena.reference_error() > 0.0 && arena.geometry().c_squared.is_some() && !arena.has_energy());
            let (lengths, spacings) = (arena.default_lengths(), arena.default_spacings());
            // Two radians to a thousand, and the length of the case, once.
            assert!(lengths.is_sorted_by(|a, b| 1.1 * a < *b) && lengths.contains(&own), "{lengths:?}");
            let [first, last] = [lengths[0], lengths[lengths.len() - 1]].map(|length| length * rate);
            assert!((2.0..5.0).contains(&first) && (440.0..=1100.0).contains(&last), "{lengths:?}");
            let [first, last] = [spacings[0], spacings[spacings.len() - 1]].map(|spacing| spacing * rate);
            assert!((0.02..0.03).contains(&first) && (1.5..=2.2).contains(&last), "{spacings:?}");
        }
    }
}

#[test]
fn only_one_block_of_the_strong_form_has_a_last_node_that_is_told() {
    let rest =
        "initial = { x = 1.0, t_dot = 1.0, x_dot = 0.1 }\ngrid = { gamma_f = 1, n_gamma = 32 }\nscheme.sbp = 'SBP21'\n";
    let arenas = one_and_scene("x^4/2", rest).map(|case| Arena::new(&case, &[4.0]).unwrap());
    let methods = vec![
        Method::Block(SbpName::Sbp21, Form::Strong),
        Method::Block(SbpName::Sbp21, Form::Weak),
        Method::Windows(SbpName::Sbp21, Form::Strong),
        Method::Elements(4),
        Method::Elements(16),
    ];
    for arena in arenas {
        for cell in over_four(&arena, methods.clone(), 0.05) {
            let last_node = &cell.numbers.as_ref().unwrap().last_node;
            assert_eq!(last_node.is_some(), cell.method == methods[0], "{cell:?}");
            // Windows and elements are whole, with about the step that was asked for.
            let intervals = cell.n_gamma.unwrap() - 1;
            let whole = match cell.method {
                Method::Windows(..) => 20,
                Method::Elements(nodes) => nodes - 1,
                _ => 80,
            };
            assert!(intervals.is_multiple_of(whole) && intervals.abs_diff(80) < whole, "{cell:?}");
        }
    }
}

/// The states of a method over a length in a case whose start is stretched by `tangent`.
fn problem(case: &Case, length: f64, tangent: f64) -> Problem {
    let (geometry, own) = (case.geometry::<f64>(), case.start::<f64>());
    let q_dot: Vec<f64> = own.q_dot.iter().map(|rate| rate * tangent).collect();
    let start = if tangent == 1.0 { own } else { start(&geometry, &own.q, &q_dot) };
    Problem { space: geometry.into(), start, length, g00: case.g00() }
}

/// The largest |ΔK| of states, and of the differences of an energy of positions and velocities from that at the start.
fn largest_deltas(
    problem: &Problem,
    (peer, output, setting): (Peer, usize, Setting),
    energy: impl Fn(&[f64], &[f64]) -> f64,
) -> [f64; 2] {
    let (space, start) = (&problem.space, &problem.start);
    let (norm, begun) = (norm_of(space, start), energy(&start.q, &start.q_dot));
    let states = peer.run(problem, &Output::even(output), setting).unwrap().states;
    let deltas = |state: State<'_>| {
        let u = space.velocities(state.q, state.p).unwrap();
        [(space.norm(state.q, &u) - norm).abs(), (energy(state.q, &u) - begun).abs()]
    };
    states.iter().map(deltas).fold([0.0; 2], |most: [f64; 2], here| [most[0].max(here[0]), most[1].max(here[1])])
}

#[test]
fn methods_that_choose_their_steps_are_looked_at_every_two_radians() {
    let case = case("initial={t=0.0,x=1.0,t_dot=1.3,x_dot=0.4}");
    for (length, tangent) in [(40.0, 1.0), (40.0, 3.0), (60.0, 0.5)] {
        let arena = Arena::new(&case, &[length * tangent]).unwrap();
        let methods = vec![Method::Peer(Peer::Dop853)];
        let plan = Plan { methods, lengths: vec![length], tangents: vec![tangent], spacings: vec![0.1] };
        let cells = measure(&arena, &plan, &|_, _| {}).cells;
        let count = (length * tangent * arena.omega() / 2.0).ceil() as usize;
        let cell = cells.iter().find(|cell| cell.setting == 1e-3).unwrap();
        let run: (Peer, usize, Setting) = (Peer::Dop853, count, Setting::tolerance(1e-3));
        let [most, _] = largest_deltas(&problem(&case, length, tangent), run, |_, _| 0.0);
        let numbers = cell.numbers.as_ref().unwrap();
        assert!(numbers.sawtooth.is_none() && numbers.sawtooth_from.is_none(), "between its steps there is none");
        let found = numbers.delta_k_max;
        assert!((found / most - 1.0).abs() < 1e-9 && most > 1e-6, "{tangent}: {found} for {most}");
    }
}

#[test]
fn k_and_energy_of_another_method_are_those_of_its_states() {
    for law in ["law = 'newtonian'", "c = 9.0"] {
        // m = 2 in V = x² + 2y² + x²y/3.
        let case = parsed(
            &format!(
                "potential = {{ coordinates = ['x', 'y'], formula = 'x^2 + 2*y^2 + x^2*y/3' }}\n\
                 particle = {{ {law}, mass = 2.0 }}\nscheme.sbp = 'SBP21'\ngrid = {{ gamma_f = 2.0, n_gamma = 41 }}\n\
                 initial = {{ t = 1.0, t_dot = 3.0, x = 0.6, y = -0.2, x_dot = 0.9, y_dot = 1.5 }}\n"
            ),
            &[],
        );
        let energy = |q: &[f64], u: &[f64]| {
            let [x, y] = [q[1], q[2]];
            (u[1].powi(2) + u[2].powi(2)) / u[0].powi(2) + x * x + 2.0 * y * y + x * x * y / 3.0
        };
        let problem = problem(&case, 2.0, 1.0);
        let [delta_k, delta_energy] = largest_deltas(&problem, (Peer::Rk4, 10, Setting::steps(10)), energy);
        let arena = Arena::new(&case, &[2.0]).unwrap();
        let cells = charted(&arena, vec![Method::Peer(Peer::Rk4)], &[2.0], &[0.2]).cells;
        let found = cells[0].numbers.as_ref().unwrap();
        assert!((found.delta_k_max - delta_k).abs() < 1e-9 && delta_k > 1e-4, "{law}: {found:?} for {delta_k}");
        assert!(found.sawtooth.is_some(), "it is one of equal steps");
        match found.delta_energy_max {
            Some(found) => assert!((found - delta_energy).abs() < 1e-12 && delta_energy > 1e-4, "{found}"),
            None => assert!(law == "c = 9.0" && norm_of(&problem.space, &problem.start).abs() > 1.0),
        }
        let exact = reference(&problem.space, &problem.start, 2.0);
        assert_eq!(arena.reference_error(), exact.error_estimate(), "{law}");
    }
}

#[test]
fn elements_are_as_many_as_come_closest_to_the_step() {
    let arena = Arena::new(&case(""), &[4.0]).unwrap();
    let methods = vec![Method::Elements(16), Method::Unregularised(SbpName::Sbp42)];
    for wanted in [40, 53, 67, 80, 82, 120] {
        let cells = over_four(&arena, methods.clone(), 4.0 / wanted as f64);
        let intervals: Vec<usize> = cells.iter().map(|cell| cell.n_gamma.unwrap() - 1).collect();
        assert!(intervals[0].is_multiple_of(15) && 2 * intervals[0].abs_diff(wanted) <= 15, "{wanted}: {intervals:?}");
        assert_eq!(intervals[1], wanted);
    }
}

#[test]
fn where_nothing_moves_in_a_circle_the_pace_is_that_of_the_run() {
    let free = case("potential={free={}} grid.gamma_f=5.0");
    assert_eq!(Arena::new(&free, &[5.0]).unwrap().pace, Pace::Length(TAU / 5.0));
    // t = 2θ where γ = θ + sin θ cos θ: it is π at the horizon, and never 5. The chart goes twice as far.
    let falls = "potential={linear={alpha=-0.5}} initial.x=0.0 initial.x_dot=0.0 grid={t_f=5.0,n_gamma=32}";
    let arena = Arena::new(&case(falls), &[]).unwrap();
    assert!((arena.ends.as_ref().unwrap().gamma - FRAC_PI_2).abs() < 1e-6);
    assert!(arena.default_lengths().iter().any(|length| (length - PI).abs() < 1e-5), "{:?}", arena.default_lengths());
}

#[test]
fn a_reference_is_as_good_as_the_motion_is_small() {
    // An amplitude of 1e-4 at 1e8: sixteen digits of x are not enough for it.
    let far = "potential={formula={expression=\"(x-1e8)^2/2\"}} particle.c=1e3";
    let case = case(&format!("{far} initial={{t=0.0,x=100000000.0001,t_dot=1.0,x_dot=0.0}} grid.gamma_f=20.0"));
    let double = ReferenceTrajectory::<f64>::new(&case.geometry(), &case.start(), 20.0, 16).unwrap();
    let needed = 1e-4 * 1e-4 / 1e8;
    let arena = Arena::new(&case, &[20.0]).unwrap();
    assert!(double.error_estimate() > needed && arena.reference_error() <= needed, "{:e}", double.error_estimate());
}

#[test]
fn a_cell_that_fails_names_its_grid() {
    let falls = r#"
        potential = { coordinates = ["x"], formula = "-x/2" }
        initial = { x = 0.0, t_dot = 1.0, x_dot = 0.0 }
        grid = { gamma_f = 5.0, n_gamma = 51 }
        scheme.sbp = "SBP42"
    "#;
    let arena = Arena::new(&parsed(falls, &[]), &[5.0]).unwrap();
    for cell in charted(&arena, vec![Method::Peer(Peer::Dop853)], &[5.0], &[]).cells {
        // A method that chooses its steps has none to name.
        assert!(cell.numbers.is_some() || cell.n_gamma.is_none() && cell.delta_gamma_omega.is_none(), "{cell:?}");
        assert!(cell.numbers.is_none() || cell.setting > 1e-2, "{cell:?}");
    }
    for cell in charted(&arena, vec![Method::Block(SbpName::Sbp42, Form::Weak)], &[5.0], &[0.05, 0.1]).cells {
        assert_eq!(cell.status, CellStatus::OutsideDomain);
        assert_eq!(cell.n_gamma, Some((5.0 / cell.setting).round() as usize + 1), "{cell:?}");
    }
}
