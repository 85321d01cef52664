//! Long runs, many nodes, and the growing mode of SBP21.

use crate::common::{distance, solved};
use geodesic_ivp::diagnostics::Diagnostics;

#[test]
fn the_paper_s_long_runs_converge_in_both_systems() {
    for run in ["initial.t_dot=4.0 initial.x_dot=0.4", "initial.t_dot=8.0 initial.x_dot=0.8 grid.n_gamma=64"] {
        for sbp in ["SBP21", "SBP42"] {
            let limit = solved(&format!("{run} scheme.sbp={sbp}"));
            let doubled = solved(&format!("{run} scheme.sbp={sbp} solver.system=doubled"));
            assert!(distance(limit.x(), doubled.x()) < 1e-10, "{run} {sbp}");
            assert!(distance(limit.elapsed(), doubled.elapsed()) < 1e-10, "{run} {sbp}");
            println!("{run} {sbp}: {:?}", doubled.iterations.initial_guess);
        }
    }
}

#[test]
fn sbp42_keeps_k_where_sbp21_splits_even_and_odd_nodes() {
    let sbp21 = Diagnostics::new(&solved("grid.gamma_f=100.0 grid.n_gamma=2001"));
    let sbp42 = Diagnostics::new(&solved("grid.gamma_f=100.0 grid.n_gamma=2001 scheme.sbp=SBP42"));
    assert!((sbp21.norm.max_interior - 0.46).abs() < 0.01, "{}", sbp21.norm.max_interior);
    assert!(sbp42.norm.max_interior < 7e-4, "{}", sbp42.norm.max_interior);
    // Q_t stays exact in both: it says nothing about x.
    assert!(sbp21.charges[0].max_interior < 1e-11 && sbp42.charges[0].max_interior < 1e-11);
    let (rough, smooth) = (sbp21.sawtooth[0].1.amplitude.unwrap(), sbp42.sawtooth[0].1.amplitude.unwrap());
    assert!(rough > 1e-3 && rough > 100.0 * smooth, "{rough} against {smooth}");
}

#[test]
fn sbp42_solves_a_thousand_units_in_one_block() {
    let solution = solved("grid.gamma_f=1000.0 grid.n_gamma=20001 scheme.sbp=SBP42");
    assert!(Diagnostics::new(&solution).norm.max_interior < 1e-3);
    assert!(solution.gradient_norm < 1e-10);
}

#[test]
fn the_action_alone_finds_long_runs_too() {
    for sbp in ["SBP21", "SBP42"] {
        let run = format!("grid.gamma_f=100.0 grid.n_gamma=2001 scheme.sbp={sbp}");
        let (limit, doubled) = (solved(&run), solved(&format!("{run} solver.system=doubled")));
        // Over a hundred units rounding in the second-order system has grown, but it is the same critical point.
        assert!(distance(limit.x(), doubled.x()) < 1e-7, "{sbp}: {}", distance(limit.x(), doubled.x()));
    }
}

#[test]
fn the_last_node_deviates_more_on_longer_runs() {
    // Against the remark that the deviation changes only marginally: spacing 1/16, SBP21.
    for (length, expected, digits) in [(4, -0.38, 5e-3), (8, -0.70, 5e-3), (16, -1.48, 5e-3), (32, -4.0, 0.05)] {
        let solution = solved(&format!("grid.gamma_f={length}.0 grid.n_gamma={}", 16 * length + 1));
        let last = Diagnostics::new(&solution).charges[0].last;
        assert!((last - expected).abs() < digits, "gamma_f = {length}: {last}");
    }
}

#[test]
fn a_million_nodes() {
    for sbp in ["SBP21", "SBP42"] {
        let solution = solved(&format!("grid.n_gamma=1000000 scheme.sbp={sbp}"));
        assert!((solution.end_state().t - 1.468_634_756_955_731).abs() < 1e-9, "{sbp}: {}", solution.end_state().t);
        assert!((solution.end_state().x - 0.159_778_018_885_407).abs() < 1e-9, "{sbp}: {}", solution.end_state().x);
        assert!(solution.gradient_norm < 1e-8, "{sbp}: {}", solution.gradient_norm);
    }
}

#[test]
fn twenty_thousand_nodes_of_the_doubled_action() {
    let doubled = solved("grid.n_gamma=20000 scheme.sbp=SBP42 solver.system=doubled");
    assert!((doubled.end_state().x - 0.159_778_018_885_407).abs() < 1e-10);
}
