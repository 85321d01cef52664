//! The atlas: statuses on real runs, the scheme that fails with an exact charge, the last node, and that nothing
//! inaccurate is called accurate.

use geodesic_ivp::case::{Case, Form, SbpName, on_grid};
use geodesic_ivp::methods::Peer;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::solve::{Setup, solve};
use geodesic_ivp::study::stability::{Arena, Atlas, Cell, CellStatus, Method, Numbers, Plan, measure};

use super::charted;
use crate::common::{case, parsed};

fn chart_of(case: &Case, methods: Vec<Method>, lengths: &[f64], spacings: &[f64]) -> Atlas {
    charted(&Arena::new(case, lengths).unwrap(), methods, lengths, spacings)
}

/// Places of the coordinates.
const T: usize = 0;
const X: usize = 1;

fn error_of(numbers: &Numbers, a: usize) -> f64 {
    numbers.errors.as_ref().unwrap()[a]
}

fn cell<'a>(atlas: &'a Atlas, label: &str, length: f64, spacing: f64) -> &'a Cell {
    let wanted = |cell: &&Cell| cell.method.label() == label && cell.gamma_f == length && cell.setting == spacing;
    atlas.cells.iter().find(wanted).unwrap_or_else(|| panic!("no cell {label} {length} {spacing}"))
}

#[test]
fn the_scheme_that_fails_with_an_exact_charge_and_what_cures_it() {
    let (strong, weak) = (Form::Strong, Form::Weak);
    let methods = vec![
        Method::Block(SbpName::Sbp21, strong),
        Method::Block(SbpName::Sbp21, weak),
        Method::Block(SbpName::Sbp42, strong),
        Method::Windows(SbpName::Sbp21, strong),
        Method::Windows(SbpName::Sbp21, weak),
        Method::Elements(16),
        Method::Peer(Peer::Verlet),
    ];
    let atlas = chart_of(&case(""), methods, &[1.0, 100.0], &[0.05]);
    let at = |label: &str| cell(&atlas, label, 100.0, 0.05);
    let numbers = |label: &str| at(label).numbers.as_ref().unwrap();
    let paper = at("SBP21 strong");
    let of_paper = numbers("SBP21 strong");
    assert_eq!((paper.status, paper.n_gamma), (CellStatus::Sawtooth, Some(2001)));
    assert!(
        (of_paper.delta_k_max - 0.46).abs() < 0.01 && of_paper.charges.as_ref().unwrap()[0] < 1e-12,
        "{of_paper:?}"
    );
    assert!((paper.delta_gamma_omega.unwrap() - 0.109).abs() < 1e-3, "a ninth of what linear theory allows");
    assert!((10.0..13.0).contains(&of_paper.sawtooth_from.unwrap()), "{of_paper:?}");
    assert_eq!(cell(&atlas, "SBP21 strong", 1.0, 0.05).status, CellStatus::Accurate);
    assert_eq!(at("SBP21 weak").status, CellStatus::NoCriticalPoint);
    assert!(numbers("SBP42 strong").delta_k_max < 6e-4);
    assert!(numbers("SBP42 strong").charges.as_ref().unwrap()[0] < 1e-11);
    let sawtooth = |label: &str| numbers(label).sawtooth.unwrap();
    assert!(of_paper.sawtooth.unwrap() > 1e-3_f64.max(100.0 * sawtooth("SBP42 strong")), "{of_paper:?}");
    // Every window starts with a step of Euler's method; the weak form, which does not, keeps K.
    assert!(sawtooth("SBP21 windows strong") < 0.1 * of_paper.sawtooth.unwrap());
    assert_eq!((at("SBP42 strong").status, at("GLL16 weak").status), (CellStatus::Accurate, CellStatus::Accurate));
    assert_eq!(at("SBP21 windows strong").status, CellStatus::Drifting);
    assert!((numbers("SBP21 windows strong").delta_k_max - 0.8).abs() < 0.02);
    // Cured of drift and sawtooth, but not of a wrong phase.
    assert_eq!(at("SBP21 windows weak").status, CellStatus::Inaccurate);
    assert!(numbers("SBP21 windows weak").delta_k_max < 0.03);
    let other = numbers("Verlet");
    assert!(other.charges.is_none() && other.errors.as_ref().unwrap()[X] < 0.02);
}

#[test]
fn the_sawtooth_begins_where_the_square_of_the_step_says() {
    let spacings = [0.03, 0.05, 0.07, 0.1];
    let atlas = chart_of(&case(""), vec![Method::Block(SbpName::Sbp21, Form::Strong)], &[100.0], &spacings);
    let from =
        spacings.map(|h| cell(&atlas, "SBP21 strong", 100.0, h).numbers.as_ref().unwrap().sawtooth_from.unwrap());
    for (pair, h) in from.windows(2).zip(spacings.windows(2)) {
        let order = (pair[0] / pair[1]).ln() / (h[1] / h[0]).ln();
        assert!((1.0..3.5).contains(&order), "{from:?}");
    }
    let mean = (from[0] / from[3]).ln() / (0.1_f64 / 0.03).ln();
    assert!((mean - 2.0).abs() < 0.3, "gamma of the onset goes like the step to the power of -{mean}");
}

#[test]
fn the_charge_at_the_last_node_does_not_change_marginally_and_its_correction_is_exact() {
    let methods = [SbpName::Sbp21, SbpName::Sbp42].map(|sbp| Method::Block(sbp, Form::Strong)).to_vec();
    let lengths = [4.0, 8.0, 16.0, 32.0];
    let atlas = chart_of(&case(""), methods, &lengths, &[0.0625]);
    let last = |label, length| cell(&atlas, label, length, 0.0625).numbers.clone().unwrap().last_node.unwrap()[0];
    for (length, want, digits) in [(4.0, -0.38, 5e-3), (8.0, -0.70, 5e-3), (16.0, -1.48, 5e-3), (32.0, -4.0, 0.05)] {
        let [raw, corrected] = last("SBP21 strong", length);
        assert!((raw - want).abs() < digits && corrected.abs() < 1e-12, "{length}: {raw}, {corrected}");
        let [raw, corrected] = last("SBP42 strong", length);
        assert!(raw.abs() < 0.1 && corrected.abs() < 1e-12, "{length}: {raw}, {corrected}");
    }
}

#[test]
fn a_longer_tangent_is_a_longer_world_line() {
    let arena = Arena::new(&case(""), &[4.0]).unwrap();
    let methods = vec![Method::Block(SbpName::Sbp42, Form::Strong), Method::Peer(Peer::Rk4)];
    let chart = |lengths: &[f64], tangents: &[f64], spacings: &[f64]| {
        let [lengths, tangents, spacings] = [lengths, tangents, spacings].map(<[f64]>::to_vec);
        let plan = Plan { methods: methods.clone(), lengths, tangents, spacings };
        measure(&arena, &plan, &|_, _| {}).cells
    };
    let (long, fast) = (chart(&[4.0], &[1.0], &[0.1]), chart(&[1.0], &[4.0], &[0.025]));
    assert_eq!(long.len(), fast.len());
    assert!(long.iter().chain(&fast).all(|cell| cell.length() == 4.0));
    for (a, b) in long.iter().zip(&fast) {
        let (x, y) = (a.numbers.as_ref().unwrap(), b.numbers.as_ref().unwrap());
        assert_eq!((a.status, b.t_dot), (b.status, Some(4.0)));
        assert!((a.delta_gamma_omega.unwrap() - b.delta_gamma_omega.unwrap()).abs() < 1e-9);
        assert!((error_of(x, X) - error_of(y, X)).abs() < 1e-8, "{a:?} {b:?}");
        assert!((16.0 * x.delta_k_max - y.delta_k_max).abs() < 1e-7);
    }
}

#[test]
fn nothing_inaccurate_is_called_accurate() {
    // Judged again, by a reference in forty digits and at the end, where errors are largest.
    let case = case("");
    let start = case.start::<Extended>();
    let reference = ReferenceTrajectory::new(&case.geometry(), &start, 20.0.into(), 40).unwrap();
    let atlas = chart_of(&case, Method::charted(), &[1.0, 5.0, 20.0], &[0.05, 0.1, 0.2, 0.5]);
    let (setup, mut accurate) = (Setup::<f64>::from(&case), 0);
    for cell in atlas.cells.iter().filter(|cell| cell.status == CellStatus::Accurate) {
        let numbers = cell.numbers.as_ref().unwrap();
        assert!(error_of(numbers, X) < 1.01e-2 && error_of(numbers, T) < 2e-2, "{cell:?}");
        accurate += 1;
        if let Method::Block(sbp, form) = cell.method {
            let again = solve(on_grid(&setup, (sbp, form), cell.n_gamma.unwrap(), cell.gamma_f).unwrap()).unwrap();
            let error = (reference.at(cell.gamma_f.into()).q[1] - Extended::from(again.end_state().x)).abs();
            assert!(error.to_f64() < 1.01e-2, "{cell:?}");
        }
    }
    assert!(accurate > 100, "{accurate}");
    // Every status but one is on this small map, and the ablation is on none of its grids accurate.
    let seen = |status| atlas.cells.iter().any(|cell| cell.status == status);
    assert!(CellStatus::ALL.into_iter().filter(|&status| status != CellStatus::OutsideDomain).all(seen));
    let ablation = |cell: &&Cell| matches!(cell.method, Method::Unregularised(_));
    assert!(atlas.cells.iter().filter(ablation).all(|cell| cell.status != CellStatus::Accurate));
}

#[test]
fn beyond_the_horizon_nothing_is_accurate() {
    let falls = case("potential={linear={alpha=-0.5}} initial.x=0.0 initial.x_dot=0.0 grid.gamma_f=5.0");
    let atlas = chart_of(&falls, Method::charted(), &[1.0, 5.0], &[0.02, 0.1]);
    let arena = Arena::new(&falls, &[1.0, 5.0]).unwrap();
    assert!((arena.ends.as_ref().unwrap().gamma - std::f64::consts::FRAC_PI_2).abs() < 1e-6 && arena.omega() == 0.0);
    assert!(atlas.cells.iter().any(|cell| cell.gamma_f == 1.0 && cell.status == CellStatus::Accurate));
    for cell in atlas.cells.iter().filter(|cell| cell.gamma_f == 5.0) {
        assert_ne!(cell.status, CellStatus::Accurate, "{cell:?}");
        assert!(cell.numbers.as_ref().is_none_or(|numbers| numbers.errors.is_none()), "{cell:?}");
    }
    assert_eq!(cell(&atlas, "SBP42 strong", 5.0, 0.02).status, CellStatus::OutsideDomain);
}

#[test]
fn frequencies_and_sizes_of_a_scene_are_those_of_its_motion() {
    // Two oscillations that know nothing of each other: frequencies 1 and 2, amplitudes 0.1 and 3.
    let text = r#"
        potential = { coordinates = ["x", "y"], formula = "x^2/2 + 2*y^2" }
        particle.law = "newtonian"
        initial = { x = 0.1, y = 3.0, x_dot = 0.0, y_dot = 0.0 }
        grid = { gamma_f = 10.0, n_gamma = 101 }
        scheme.sbp = "SBP21"
    "#;
    let arena = Arena::new(&parsed(text, &[]), &[10.0]).unwrap();
    assert!((arena.omega() - 2.0).abs() < 1e-12, "{}", arena.omega());
    assert!(arena.geometry().c_squared.is_none() && arena.has_energy() && arena.t_dot() == Some(1.0));
    let metric = "metric = { coordinates = [\"x\", \"y\"], components = { \"x x\" = \"1\", \"y y\" = \"1 + x^2\" } }\n\
                  initial = { x = 0.0, y = 0.0, x_dot = 1.0, y_dot = 0.5 }\ngrid = { gamma_f = 1.0, n_gamma = 24 }\n\
                  scheme.sbp = \"SBP42\"";
    let other = Arena::new(&parsed(metric, &[]), &[1.0]).unwrap();
    assert!(other.geometry().c_squared.is_none() && !other.has_energy() && other.t_dot().is_none());
    assert_eq!((arena.geometry().names().len(), arena.geometry().ignorable().collect::<Vec<_>>()), (4, vec![0, 3]));
    // In one coordinate there are no two units; here x is judged by the amplitude of y, whose unit it has.
    let methods = vec![Method::Peer(Peer::Verlet), Method::Block(SbpName::Sbp42, Form::Weak)];
    let atlas = charted(&arena, methods, &[10.0], &[0.01, 0.05, 0.2]);
    for cell in &atlas.cells {
        let numbers = cell.numbers.as_ref().unwrap();
        let accurate = (1..3).all(|a| error_of(numbers, a) <= 0.03) && error_of(numbers, 3) < 0.1;
        assert_eq!(cell.status == CellStatus::Accurate, accurate, "{cell:?}");
        assert!((cell.delta_gamma_omega.unwrap() - 2.0 * cell.setting).abs() < 1e-9);
        // The energy is 18, and goes with the square of the amplitude.
        assert!(!accurate || numbers.delta_energy_max.unwrap() < 0.36, "{cell:?}");
    }
    assert!(atlas.cells.iter().any(|cell| cell.status == CellStatus::Accurate));
}

/// Neither that of x nor that of γ.
#[test]
fn units_are_nobody_s_business() {
    let arena = |unit: f64, rate: f64| {
        let potential = format!("potential={{formula={{expression=\"(x/l)^2/4\",parameters={{l={unit:e}}}}}}}");
        let initial = format!("initial={{t=0.0,x={unit:e},t_dot={rate:e},x_dot={:e}}}", 0.1 * rate);
        let scene = case(&format!("{potential} {initial} grid.gamma_f={:e}", unit / rate));
        Arena::new(&scene, &[unit / rate, 5.0 * unit / rate]).unwrap()
    };
    let map = |unit: f64, rate: f64| {
        let of = |numbers: [f64; 2]| numbers.map(|number| number * unit / rate);
        let fixed =
            Method::charted().into_iter().filter(|method| !method.is_adaptive() && !method.label().contains("unreg"));
        charted(&arena(unit, rate), fixed.collect(), &of([1.0, 5.0]), &of([0.05, 0.3])).cells
    };
    let (one, omega) = (map(1.0, 1.0), arena(1.0, 1.0).omega());
    assert!(one.len() > 50 && one.iter().any(|cell| cell.status == CellStatus::Sawtooth));
    for (unit, rate) in [(1e100, 1.0), (1e-100, 1.0), (1.0, 1e-2), (1.0, 1e5)] {
        assert!((arena(unit, rate).omega() * unit / rate / omega - 1.0).abs() < 1e-3, "{unit:e} {rate:e}");
        for (here, there) in map(unit, rate).iter().zip(&one) {
            assert_eq!((here.status, &here.method), (there.status, &there.method), "{unit:e} {rate:e}");
            let [here, there] = [here, there].map(|cell| cell.numbers.as_ref().map(|numbers| error_of(numbers, X)));
            let (here, there) = (here.unwrap_or(0.0) / unit, there.unwrap_or(0.0));
            assert!((here - there).abs() < 1e-9, "{unit:e} {rate:e}: {here} and {there}");
        }
    }
}

#[test]
fn a_reference_that_would_not_do_is_replaced() {
    // From 1e-10 beside the top of a barrier: after two visits to it nothing is left of sixteen digits.
    let top = "potential={formula={expression=\"2*(x^2-1)^2\"}} particle.c=10.0 initial.x=1e-10 initial.x_dot=0.0";
    let case = case(&format!("{top} grid.gamma_f=40.0"));
    let double = ReferenceTrajectory::<f64>::new(&case.geometry(), &case.start(), 40.0, 16).unwrap();
    let arena = Arena::new(&case, &[40.0]).unwrap();
    assert!(double.error_estimate() > 1e-3 && arena.reference_error() < 1e-8, "{:e}", arena.reference_error());
    let atlas = charted(&arena, vec![Method::Peer(Peer::KahanLi8), Method::Accuracy], &[40.0], &[0.05]);
    assert!(atlas.cells.iter().all(|cell| cell.status != CellStatus::Accurate), "f64 cannot be: {:?}", atlas.cells);
}
