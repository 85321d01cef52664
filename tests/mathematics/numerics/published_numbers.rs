//! The paper's base cases to the digits of a 50-digit computation, in both systems.

use crate::common::{distance, solved};
use geodesic_ivp::diagnostics::Diagnostics;

struct Base {
    overrides: &'static str,
    t_final: f64,
    x_final: f64,
    delta_e_last: f64,
}

#[allow(clippy::excessive_precision)] // The digits of the 50-digit computation, as published.
const BASES: [Base; 4] = [
    Base {
        overrides: "potential={linear={alpha=0.25}} scheme.sbp=SBP21",
        t_final: 0.997133574629157764,
        x_final: 0.976191605648003795,
        delta_e_last: 1.70339476621e-3,
    },
    Base {
        overrides: "potential={linear={alpha=0.25}} scheme.sbp=SBP42",
        t_final: 0.997129607104816606,
        x_final: 0.976047023202856525,
        delta_e_last: 1.004786223e-6,
    },
    Base {
        overrides: "scheme.sbp=SBP21",
        t_final: 1.46880142306432611,
        x_final: 0.160180164366140702,
        delta_e_last: 5.93454699655e-2,
    },
    Base {
        overrides: "scheme.sbp=SBP42",
        t_final: 1.46870037119779931,
        x_final: 0.159785267746955074,
        delta_e_last: 5.78416591035e-3,
    },
];

const SYSTEMS: [&str; 2] = ["solver.system=physical-limit", "solver.system=doubled"];

/// ε|t|/h, the rounding level of Dt at N = 32, with room for the operator's row sum and g00.
const ROUNDING: f64 = 32.0 * 8.0 * f64::EPSILON;
/// One more application of D.
const ROUNDING_OF_SECOND_DERIVATIVE: f64 = 32.0 * ROUNDING;

#[test]
fn end_values_and_the_deviation_at_the_last_node() {
    for base in BASES {
        for system in SYSTEMS {
            let solution = solved(&format!("{} {system}", base.overrides));
            let diagnostics = Diagnostics::new(&solution);
            let name = format!("{} {system}", base.overrides);
            assert!((solution.end_state().t - base.t_final).abs() < 1e-11, "{name}: t = {}", solution.end_state().t);
            assert!((solution.end_state().x - base.x_final).abs() < 1e-11, "{name}: x = {}", solution.end_state().x);
            let last = diagnostics.charges[0].last;
            assert!((last - base.delta_e_last).abs() < 1e-11, "{name}: delta E = {last}");
        }
    }
}

#[test]
fn charge_and_residuals_are_exact_away_from_the_end() {
    for base in BASES {
        for system in SYSTEMS {
            let solution = solved(&format!("{} {system}", base.overrides));
            let diagnostics = Diagnostics::new(&solution);
            let name = format!("{} {system}", base.overrides);
            assert!(diagnostics.charges[0].max_interior < ROUNDING, "{name}");
            assert!(diagnostics.charges[0].max_corrected < ROUNDING, "{name}");
            assert!(diagnostics.max_delta_g < ROUNDING_OF_SECOND_DERIVATIVE, "{name}");
            // The check can fail: the nodes left out of it do deviate.
            let deviating = if base.overrides.contains("SBP21") { 2 } else { 4 };
            for residual in [&diagnostics.delta_g[0], &diagnostics.delta_g[1]] {
                assert!(residual[32 - deviating].abs() > 1e4 * ROUNDING_OF_SECOND_DERIVATIVE, "{name}");
            }
        }
    }
}

#[test]
fn multipliers_and_branches_are_those_of_the_physical_limit() {
    for base in BASES {
        let limit = solved(&format!("{} {}", base.overrides, SYSTEMS[0]));
        let doubled = solved(&format!("{} {}", base.overrides, SYSTEMS[1]));
        let (lambda, doubled_lambda) = (limit.multipliers().unwrap(), doubled.multipliers().unwrap());
        assert!(limit.gradient_norm < 1e-10 && doubled.gradient_norm < 1e-10, "{}", base.overrides);
        assert!(doubled_lambda[..4].iter().all(|lambda| lambda.abs() < 1e-11), "{doubled_lambda:?}");
        assert!(distance(lambda, doubled_lambda) < 1e-11, "{doubled_lambda:?}");
        assert!((doubled_lambda[4] + doubled.q_t()).abs() < 1e-11);
        assert!(doubled.branch_distance() < 1e-11);
        assert!(distance(limit.x(), doubled.x()) < 1e-11 && distance(limit.elapsed(), doubled.elapsed()) < 1e-11);
        assert!((limit.end_state().x_dot - doubled.end_state().x_dot).abs() < 1e-11);
    }
}

#[test]
fn the_end_velocities_of_the_paper() {
    let solution = solved("scheme.sbp=SBP21");
    let diagnostics = Diagnostics::new(&solution);
    assert!((diagnostics.q_dot[0][31] - 2.058).abs() < 5e-4, "the paper: 2.06");
    let linear = Diagnostics::new(&solved("potential={linear={alpha=0.25}}"));
    assert!((linear.q_dot[0][31] - 1.00914).abs() < 5e-6);
}

#[test]
fn h_bvp_keeps_its_bound_and_its_exact_value() {
    let solution = solved("scheme.sbp=SBP42 grid.n_gamma=512");
    let bound = Diagnostics::new(&solution).of_x.unwrap().bound;
    assert!(bound.h_bvp <= bound.h_bvp_bound);
    let exact = bound.h_bvp_bound - 0.5 * solution.norm();
    assert!((bound.h_bvp - exact).abs() < 1e-6, "{} against {exact}", bound.h_bvp);
    // A spacelike start breaks the bound.
    let spacelike =
        Diagnostics::new(&solved("scheme.sbp=SBP42 potential={free={}} initial.x_dot=1.5")).of_x.unwrap().bound;
    assert!(spacelike.h_bvp > spacelike.h_bvp_bound);
}

#[test]
fn without_regularisation_the_critical_point_is_wrong_or_missing() {
    let ablation = "solver.system=doubled scheme.regularised=false";
    for (sbp, t_final) in [("SBP21", 1.0324), ("SBP42", 0.6350)] {
        let linear = solved(&format!("{ablation} potential={{linear={{alpha=0.25}}}} scheme.sbp={sbp}"));
        assert!((linear.end_state().t - t_final).abs() < 5e-5, "{sbp}: t = {}", linear.end_state().t);
        // In the quartic case Newton's method fails, or its damping carries it to a spurious point in which even and
        // odd nodes lie on two different curves.
        let quartic = format!("{ablation} scheme.sbp={sbp} solver.max_iterations=100");
        let Ok(spurious) = geodesic_ivp::solve::<f64>(&crate::common::case(&quartic)) else { continue };
        let splitting = Diagnostics::new(&spurious).sawtooth[0].1.amplitude.unwrap();
        assert!(splitting > 1e-2, "{sbp}: {splitting:e}");
    }
}
