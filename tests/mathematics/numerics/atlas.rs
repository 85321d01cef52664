//! The atlas: the grids that it chooses, and what its cells say of them.

use std::sync::atomic::AtomicBool;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use geodesic_ivp::case::{Case, Form, SbpName};
use geodesic_ivp::methods::{Dop853, Output, Peer, Problem, Setting, State};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::study::stability::{Arena, Cell, Method, Pace, Plan, measure};

use crate::common::{case, norm_of, start};

/// The cells over the length 4.
fn charted(arena: &Arena, methods: Vec<Method>, spacing: f64) -> Vec<Cell> {
    let plan = Plan { methods, lengths: vec![4.0], tangents: vec![1.0], spacings: vec![spacing] };
    let atlas = measure(arena, &plan, &AtomicBool::new(false), &|_, _| {});
    assert!(!atlas.interrupted);
    atlas.cells
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
            assert_eq!(matches!(arena.pace(), Pace::Growth(_)), is_growth);
            assert!((arena.pace().rate() / rate - 1.0).abs() < 1e-3, "{:?}", arena.pace());
            assert!(arena.reference_error() > 0.0 && !arena.is_scene() && !arena.has_energy());
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
    let text = r#"
        potential = { coordinates = ["x"], formula = "x^4/2" }
        initial = { x = 1.0, t_dot = 1.0, x_dot = 0.1 }
        grid.n_gamma = 32
        scheme.sbp = "SBP21"
    "#;
    let arenas =
        [Arena::new(&case(""), &[4.0]).unwrap(), Arena::new(&Case::parse("test", text, &[]).unwrap(), &[4.0]).unwrap()];
    let methods = vec![
        Method::Block(SbpName::Sbp21, Form::Strong),
        Method::Block(SbpName::Sbp21, Form::Weak),
        Method::Windows(SbpName::Sbp21, Form::Strong),
        Method::Elements(4, Form::Weak),
        Method::Elements(16, Form::Weak),
    ];
    for arena in arenas {
        for cell in charted(&arena, methods.clone(), 0.05) {
            let last_node = &cell.numbers.as_ref().unwrap().last_node;
            assert_eq!(last_node.is_some(), cell.method == methods[0], "{cell:?}");
            // Windows and elements are whole, with about the step that was asked for.
            let intervals = cell.n_gamma.unwrap() - 1;
            let whole = match cell.method {
                Method::Windows(..) => 20,
                Method::Elements(nodes, _) => nodes - 1,
                _ => 80,
            };
            assert!(intervals.is_multiple_of(whole) && intervals.abs_diff(80) < whole, "{cell:?}");
        }
    }
}

/// The largest |ΔK| of a method's states in a case whose start is stretched by `tangent`.
fn largest_delta_k(
    case: &Case,
    peer: &dyn Peer,
    (length, tangent): (f64, f64),
    output: usize,
    setting: Setting,
) -> f64 {
    let (geometry, own) = (case.geometry::<f64>(), case.start::<f64>());
    let q_dot: Vec<f64> = own.q_dot.iter().map(|rate| rate * tangent).collect();
    let start = start(&geometry, &own.q, &q_dot);
    let norm = norm_of(&geometry, &start);
    let problem = Problem { space: geometry.clone().into(), start, length, g00: case.g00() };
    let states = peer.run(&problem, &Output::even(output), setting).unwrap().states;
    let k = |state: State<'_>| geometry.norm(state.q, &geometry.velocities(state.q, state.p).unwrap());
    states.iter().fold(0.0, |most: f64, state| most.max((k(state) - norm).abs()))
}

#[test]
fn methods_that_choose_their_steps_are_looked_at_every_two_radians() {
    let case = case("initial={t=0.0,x=1.0,t_dot=1.3,x_dot=0.4}");
    for (length, tangent) in [(40.0, 1.0), (40.0, 3.0), (60.0, 0.5)] {
        let arena = Arena::new(&case, &[length * tangent]).unwrap();
        let methods = vec![Method::Peer(&Dop853)];
        let plan = Plan { methods, lengths: vec![length], tangents: vec![tangent], spacings: vec![0.1] };
        let cells = measure(&arena, &plan, &AtomicBool::new(false), &|_, _| {}).cells;
        let count = (length * tangent * arena.omega() / 2.0).ceil() as usize;
        let cell = cells.iter().find(|cell| cell.setting == 1e-3).unwrap();
        let most = largest_delta_k(&case, &Dop853, (length, tangent), count, Setting::tolerance(1e-3));
        let numbers = cell.numbers.as_ref().unwrap();
        assert!(numbers.sawtooth.is_none() && numbers.sawtooth_from.is_none(), "between its steps there is none");
        let found = numbers.delta_k_max;
        assert!((found / most - 1.0).abs() < 1e-9 && most > 1e-6, "{tangent}: {found} for {most}");
    }
}

#[test]
fn elements_are_as_many_as_come_closest_to_the_step() {
    let arena = Arena::new(&case(""), &[4.0]).unwrap();
    let methods = vec![Method::Elements(16, Form::Weak), Method::Unregularised(SbpName::Sbp42)];
    for wanted in [40, 53, 67, 80, 82, 120] {
        let cells = charted(&arena, methods.clone(), 4.0 / wanted as f64);
        let intervals: Vec<usize> = cells.iter().map(|cell| cell.n_gamma.unwrap() - 1).collect();
        assert!(intervals[0].is_multiple_of(15) && 2 * intervals[0].abs_diff(wanted) <= 15, "{wanted}: {intervals:?}");
        assert_eq!(intervals[1], wanted);
    }
}

#[test]
fn where_nothing_moves_in_a_circle_the_pace_is_that_of_the_run() {
    let free = case("potential={free={}} grid.gamma_f=5.0");
    assert_eq!(Arena::new(&free, &[5.0]).unwrap().pace(), Pace::Length(TAU / 5.0));
    // t = 2θ where γ = θ + sin θ cos θ: it is π at the horizon, and never 5. The chart goes twice as far.
    let falls = "potential={linear={alpha=-0.5}} initial.x=0.0 initial.x_dot=0.0 grid={t_f=5.0,n_gamma=32}";
    let arena = Arena::new(&case(falls), &[]).unwrap();
    assert!((arena.ends().unwrap().gamma - FRAC_PI_2).abs() < 1e-6);
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
