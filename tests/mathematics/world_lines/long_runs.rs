//! Long runs and many nodes, in both forms and by both systems.

use crate::common::{case, distance, solved};
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::{Status, solve};

#[test]
fn the_action_alone_finds_long_runs_too() {
    for scheme in ["scheme.sbp=SBP21", "scheme.sbp=SBP42", "scheme.sbp=SBP42 scheme.form=weak"] {
        let run = format!("grid.gamma_f=100.0 grid.n_gamma=2001 {scheme}");
        let (limit, doubled) = (solved(&run), solved(&format!("{run} solver.system=doubled")));
        // Over a hundred units rounding in the second-order system has grown, but it is the same critical point.
        assert!(distance(limit.x(), doubled.x()) < 1e-7, "{scheme}: {}", distance(limit.x(), doubled.x()));
        if scheme.ends_with("weak") {
            let found = Diagnostics::new(&limit);
            assert!(found.norm.max_interior < 1e-3 && found.norm.max_ends < 1e-6);
            assert!(found.charges[0].max_interior < 1e-11);
        }
    }
}

/// SBP21 is fragile in one block of the weak form: whatever comes is a critical point or a failure with its reason.
#[test]
fn a_long_run_that_is_fragile_is_a_critical_point_or_a_failure() {
    for system in ["physical-limit", "doubled"] {
        let run = format!("grid.gamma_f=100.0 grid.n_gamma=2001 scheme.form=weak solver.system={system}");
        match solve::<f64>(&case(&run)) {
            Ok(solution) => assert!(solution.gradient_norm < 1e-10, "{system}"),
            Err(failure) => {
                assert!(failure.status != Status::Converged && !failure.advice().is_empty(), "{system}");
                assert!(failure.residual.is_finite() && (0.0..=100.0).contains(&failure.gamma), "{system}");
            }
        }
    }
}

#[test]
fn sbp42_solves_a_thousand_units_in_one_block() {
    let solution = solved("grid.gamma_f=1000.0 grid.n_gamma=20001 scheme.sbp=SBP42");
    assert!(Diagnostics::new(&solution).norm.max_interior < 1e-3);
    assert!(solution.gradient_norm < 1e-10);
}

/// The ends are those of the continuum to this accuracy, and the gradient is below the last number.
#[test]
fn so_many_nodes_end_at_the_end_of_the_continuum() {
    for (run, accuracy, gradient) in [
        ("grid.n_gamma=1000000", 1e-9, 1e-8),
        ("grid.n_gamma=1000000 scheme.sbp=SBP42", 1e-9, 1e-8),
        ("grid.n_gamma=100000 scheme.form=weak", 1e-9, 1e-9),
        ("grid.n_gamma=100000 scheme.sbp=SBP42 scheme.form=weak", 1e-12, 1e-9),
        ("grid.n_gamma=20000 scheme.sbp=SBP42 solver.system=doubled", 1e-10, f64::INFINITY),
    ] {
        let solution = solved(run);
        let end = solution.end_state();
        for (found, known) in [(end.t, 1.468_634_756_955_731), (end.x, 0.159_778_018_885_407_25)] {
            assert!((found - known).abs() < accuracy, "{run}: {found} for {known}");
        }
        assert!(solution.gradient_norm < gradient, "{run}: {}", solution.gradient_norm);
    }
}
