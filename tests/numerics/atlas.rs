//! The atlas: the grids that it chooses, and what its cells say of them.

use std::sync::atomic::AtomicBool;

use geodesic_ivp::case::{Form, SbpName, SceneCase};
use geodesic_ivp::methods::{Output, Peer, Problem, Rk4, Setting, State};
use geodesic_ivp::study::stability::{Arena, Cell, Method, Pace, Plan, measure};

use super::common::case;

/// The cells over the length 4.
fn charted(arena: &Arena, methods: Vec<Method>, spacing: f64) -> Vec<Cell> {
    let plan = Plan { methods, lengths: vec![4.0], tangents: vec![1.0], spacings: vec![spacing] };
    measure(arena, &plan, &AtomicBool::new(false), &|_, _| {}).cells
}

#[test]
fn default_grids_go_with_the_pace_of_the_motion() {
    let rate = 20.0;
    for (formula, is_growth) in [("200*x^2", false), ("-200*x^2", true)] {
        let potential = format!("potential={{formula={{expression=\"{formula}\"}}}} particle.c=1e4");
        for own in [0.5, 0.777] {
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
    let arenas = [
        Arena::new(&case(""), &[4.0]).unwrap(),
        Arena::of_scene(&SceneCase::parse("test", text, &[]).unwrap(), &[4.0]).unwrap(),
    ];
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

#[test]
fn k_of_another_method_is_that_of_its_states() {
    let case = case("initial={t=0.0,x=1.0,t_dot=1.3,x_dot=0.4}");
    let (metric, initial) = (case.metric::<f64>(), case.initial_data::<f64>());
    let invariants = initial.invariants(&metric);
    let problem = Problem { metric: metric.clone(), initial, length: 4.0 };
    let states = Rk4.run(&problem, &Output::even(10), Setting::steps(10)).unwrap().states;
    let k = |state: &State| invariants.q_t.powi(2) / metric.at(state.x).g00 - state.w.powi(2);
    let most = states.iter().fold(0.0, |most: f64, state| most.max((k(state) - invariants.k).abs()));
    let arena = Arena::new(&case, &[4.0]).unwrap();
    let found = charted(&arena, vec![Method::Peer(&Rk4)], 0.4)[0].numbers.as_ref().unwrap().delta_k_max;
    assert!((found - most).abs() < 1e-12 && most > 1e-3, "{found} for {most}");
}
