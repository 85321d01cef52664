//! Slopes and absolute errors of the sweep, for both potentials and operators.

use std::sync::atomic::{AtomicBool, Ordering};

use geodesic_ivp::case::{Form, SbpName};
use geodesic_ivp::study::convergence::{Convergence, Quantity, SweepError, sweep};

use crate::common::case;

const LINEAR: &str = "potential={linear={alpha=0.25}}";
const BOTH: [(SbpName, Form); 2] = [(SbpName::Sbp21, Form::Strong), (SbpName::Sbp42, Form::Strong)];

fn swept(overrides: &str, n_gamma: &[usize]) -> Convergence {
    sweep(&case(overrides), &BOTH, n_gamma, &AtomicBool::new(false), &|_| {}).unwrap()
}

fn slope(convergence: &Convergence, sbp: SbpName, quantity: Quantity) -> f64 {
    let slopes = convergence.slopes((0, usize::MAX));
    slopes.iter().find(|s| s.sbp == sbp && s.quantity == quantity).unwrap().fit.as_ref().unwrap().slope
}

#[test]
fn the_orders_are_two_and_three() {
    for potential in [LINEAR, ""] {
        for range in [[16, 32, 64], [64, 128, 256]] {
            let convergence = swept(potential, &range);
            for quantity in Quantity::all(2) {
                let got = slope(&convergence, SbpName::Sbp21, quantity);
                assert!((got - 2.0).abs() < 0.02, "{potential} {range:?} SBP21 {quantity:?}: {got}");
            }
            for quantity in [Quantity::EPS_T_L2, Quantity::EPS_X_L2] {
                let got = slope(&convergence, SbpName::Sbp42, quantity);
                assert!((got - 3.0).abs() < 0.02, "{potential} {range:?} SBP42 {quantity:?}: {got}");
            }
        }
    }
}

#[test]
fn the_paper_s_pre_asymptotic_regime() {
    let coarse = swept("", &[16, 32, 64]);
    let fine = swept("", &[64, 128, 256]);
    assert!(slope(&coarse, SbpName::Sbp42, Quantity::EPS_X_FINAL) < 2.0);
    assert!(slope(&fine, SbpName::Sbp42, Quantity::EPS_X_FINAL) > 2.85);
    let warned = |c: &Convergence| {
        c.slopes((0, usize::MAX))
            .iter()
            .filter_map(|s| s.warning())
            .any(|w| w.contains("SBP42 eps_x_final: not asymptotic"))
    };
    assert!(warned(&coarse));
    // The published fits are against 1/N.
    let slopes = coarse.slopes((0, usize::MAX));
    let inverse = |quantity| {
        slopes
            .iter()
            .find(|s| s.sbp == SbpName::Sbp21 && s.quantity == quantity)
            .unwrap()
            .fit
            .as_ref()
            .unwrap()
            .slope_vs_inverse_n
    };
    assert!((inverse(Quantity::EPS_X_FINAL) - 2.08).abs() < 0.005);
    assert!((inverse(Quantity::EPS_T_FINAL) - 2.06).abs() < 0.005);
}

#[test]
fn absolute_errors_of_the_quartic_case() {
    let convergence = swept("", &[64]);
    let published =
        [[9.71630e-5, 4.04627e-5, 1.88185e-4, 2.45906e-4], [1.30912e-6, 7.43318e-6, 1.31765e-6, 4.02038e-6]];
    for (point, published) in convergence.points.iter().zip(published) {
        let e = point.errors.as_ref().unwrap();
        for (got, want) in [e.at_end[1], e.at_end[0], e.l2[1], e.l2[0]].into_iter().zip(published) {
            assert!((got / want - 1.0).abs() < 1e-4, "{:?}: {got} against {want}", point.sbp);
        }
    }
}

#[test]
fn the_fit_stops_at_the_rounding_plateau() {
    let n: Vec<usize> = (6..19).map(|power| 1 << power).collect();
    let convergence = sweep::<f64>(&case(""), &BOTH[1..], &n, &AtomicBool::new(false), &|_| {}).unwrap();
    for slope in convergence.slopes((0, usize::MAX)) {
        let (n_min, n_max) = slope.n_range.unwrap();
        assert_eq!(n_min, 64);
        assert!((16_384..200_000).contains(&n_max), "{:?}: fitted to {n_max}", slope.quantity);
        assert!(slope.plateau_from.is_some_and(|n| n > n_max));
    }
}

#[test]
fn a_fit_does_not_end_where_the_order_settles() {
    let scene = "potential={polynomial={coefficients=[0.0,0.0,1.5]}} particle.mass=1.5 particle.c=2.0 initial.t=0.5 \
                 initial.x=-0.8 initial.t_dot=1.25 initial.x_dot=0.3 grid.gamma_i=-1.0 grid.gamma_f=0.5";
    let n = [24, 48, 96, 192, 384, 768];
    let convergence = sweep::<f64>(&case(scene), &BOTH[1..], &n, &AtomicBool::new(false), &|_| {}).unwrap();
    for slope in convergence.slopes((0, usize::MAX)) {
        assert_eq!((slope.n_range, slope.plateau_from), (Some((24, 768)), None), "{:?}", slope.quantity);
        let fit = slope.fit.as_ref().unwrap();
        assert!((2.6..3.8).contains(&fit.slope), "{:?}: {}", slope.quantity, fit.slope);
        if slope.quantity == Quantity::EPS_X_L2 {
            let (low, high) = fit.local_range();
            assert!(low > 3.0 && low < 3.1 && high > 3.5, "{:?}", fit.local_slopes);
        }
    }
}

#[test]
fn points_are_ordered_and_failures_are_points() {
    // At N = 8 the long run is hopelessly coarse for SBP42; the sweep goes on.
    let convergence = swept("grid.gamma_f=20.0", &[400, 8, 400, 200]);
    let order: Vec<(SbpName, usize)> = convergence.points.iter().map(|p| (p.sbp, p.n_gamma)).collect();
    let expected: Vec<_> = BOTH.into_iter().flat_map(|(sbp, _)| [8, 200, 400].map(|n| (sbp, n))).collect();
    assert_eq!(order, expected);
    let failed = &convergence.points[3];
    assert!(failed.errors.is_none() && failed.status.as_str() != "converged", "{failed:?}");
    assert!(convergence.points[5].errors.is_some());
}

#[test]
fn a_cancelled_sweep_keeps_what_is_finished() {
    let cancel = AtomicBool::new(false);
    let stop_after_first = |_: &_| cancel.store(true, Ordering::Relaxed);
    // On one thread exactly one grid is done before the flag is seen.
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let convergence: Convergence =
        one_thread.install(|| sweep(&case(""), &BOTH, &[8, 16, 32, 64, 128, 256], &cancel, &stop_after_first)).unwrap();
    assert!(convergence.interrupted);
    assert_eq!(convergence.points.len(), 1);
}

#[test]
fn a_sweep_that_cannot_be_is_refused() {
    let impossible = |overrides: &str, n: usize| {
        sweep::<f64>(&case(overrides), &BOTH, &[n], &AtomicBool::new(false), &|_| {}).unwrap_err()
    };
    assert!(matches!(impossible("", 7), SweepError::Grid(_)));
    let falls = "potential={linear={alpha=-0.5}} initial.x=0.0 initial.x_dot=0.0 grid.gamma_f=5.0";
    assert!(matches!(impossible(falls, 64), SweepError::Reference(_)));
}

#[test]
fn a_case_that_ends_at_a_time_is_swept_too() {
    let convergence = swept("grid={t_f=1.4686347569557309,n_gamma=32}", &[64]);
    assert!((convergence.reference.gamma_final - 1.0).abs() < 1e-13);
    assert!((convergence.points[0].errors.as_ref().unwrap().at_end[1] / 9.71630e-5 - 1.0).abs() < 1e-4);
}

#[test]
fn errors_count_against_the_largest_values_of_the_motion() {
    // x = 0.3 − 2 γ is largest at the end of the run, which does not begin at 0.
    let line =
        "potential={free={}} initial={t=7.0,x=0.3,t_dot=3.0,x_dot=-2.0} grid={gamma_i=1.5,gamma_f=2.75,n_gamma=32}";
    let reference = swept(line, &[16, 32]).reference;
    assert!((reference.gamma_final - 2.75).abs() < 1e-15, "{reference:?}");
    assert!((reference.sizes[0] - 3.75).abs() < 1e-12 && (reference.sizes[1] - 2.2).abs() < 1e-12, "{reference:?}");
}
