//! Sweeps of grids: slopes and errors of every coordinate, for one coordinate and for several.

use geodesic_ivp::Case;
use geodesic_ivp::case::{Form, SbpName};
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::study::convergence::{Convergence, ConvergencePoint, Quantity, Sweep, SweepError};

use crate::common::{case, parsed, shipped};

const LINEAR: &str = "potential={linear={alpha=0.25}}";
const BOTH: [(SbpName, Form); 2] = [(SbpName::Sbp21, Form::Strong), (SbpName::Sbp42, Form::Strong)];

fn swept<S: Real>(case: &Case, schemes: &[(SbpName, Form)], n_gamma: &[usize]) -> Convergence<S> {
    Sweep::new(case, schemes, n_gamma).unwrap().run(&|_, _| ())
}

fn slope(convergence: &Convergence, sbp: SbpName, quantity: Quantity) -> f64 {
    let slopes = convergence.slopes((0, usize::MAX));
    slopes.iter().find(|s| s.sbp == sbp && s.quantity == quantity).unwrap().fit.as_ref().unwrap().slope
}

fn place(case: &Case, name: &str) -> usize {
    case.coordinates().iter().position(|other| other == name).unwrap()
}

#[test]
fn the_orders_are_two_and_three() {
    for potential in [LINEAR, ""] {
        for range in [[16, 32, 64], [64, 128, 256]] {
            let convergence = swept(&case(potential), &BOTH, &range);
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
fn errors_of_every_coordinate_have_the_order_of_the_scheme() {
    let kerr = shipped("kerr-inclined", &["grid.gamma_f=60.0", "grid.windows=1"]);
    let henon = shipped("henon-heiles", &["grid.gamma_f=4.0", "grid.windows=1"]);
    for case in [kerr, henon] {
        for (scheme, at_end, l2, n_gamma) in [
            ((SbpName::Sbp21, Form::Strong), 2.0, 2.0, [128, 256, 512]),
            ((SbpName::Sbp42, Form::Strong), 3.0, 3.0, [256, 512, 1024]),
            ((SbpName::Sbp42, Form::Weak), 4.0, 3.0, [128, 256, 512]),
        ] {
            let convergence = swept::<f64>(&case, &[scheme], &n_gamma);
            assert_eq!(convergence.coordinates, case.coordinates());
            let slopes = convergence.slopes((0, usize::MAX));
            assert_eq!(slopes.len(), 2 * case.coordinates().len());
            for slope in slopes {
                let a = slope.quantity.coordinate.unwrap();
                let Some(fit) = &slope.fit else {
                    // With Newton's law t is γ, exactly.
                    assert!(case.coordinates()[a] == "t" && case.is_lifted(), "{slope:?}");
                    continue;
                };
                let order = if slope.quantity.is_at_end { at_end } else { l2 };
                assert!(fit.slope > order - 0.3, "{} {scheme:?}: {fit:?}", slope.name);
            }
            for point in &convergence.points {
                let errors = point.errors.as_ref().unwrap();
                assert_eq!(errors.charges_last.len(), convergence.charges.len());
                let largest = errors.charges_last.iter().copied().fold(0.0, f64::max);
                assert_eq!(largest < 1e-10, scheme.1 == Form::Weak, "{scheme:?}: {largest}");
            }
        }
    }
}

#[test]
fn the_end_of_the_weak_form_has_the_order_of_the_interior() {
    let case = case("scheme.form=weak solver.digits=30");
    let schemes = [SbpName::Sbp21, SbpName::Sbp42].map(|sbp| (sbp, Form::Weak));
    let convergence = swept::<Extended>(&case, &schemes[1..], &[257]);
    let errors = convergence.points[0].errors.as_ref().unwrap();
    assert!((errors.at_end[1] / 2.806e-11 - 1.0).abs() < 1e-3, "{errors:?}");
    assert!((errors.at_end[0] / 8.353e-11 - 1.0).abs() < 1e-3, "{errors:?}");
    assert!(errors.charges_last[0] < 1e-25, "{errors:?}");
    for slope in swept::<Extended>(&case, &schemes, &[1025, 2049, 4097]).slopes((0, usize::MAX)) {
        assert_eq!(slope.form, Form::Weak);
        let fit = slope.fit.as_ref().unwrap();
        let order = match (slope.sbp, slope.quantity) {
            (SbpName::Sbp21, _) => 2.0,
            (_, Quantity::EPS_T_FINAL | Quantity::EPS_X_FINAL) => 4.0,
            _ => 3.0,
        };
        assert!((fit.slope - order).abs() < 0.05, "{:?} {:?}: {}", slope.sbp, slope.quantity, fit.slope);
    }
}

#[test]
fn absolute_errors_of_the_quartic_case() {
    let convergence = swept::<f64>(&case(""), &BOTH, &[64]);
    let published =
        [[9.71630e-5, 4.04627e-5, 1.88185e-4, 2.45906e-4], [1.30912e-6, 7.43318e-6, 1.31765e-6, 4.02038e-6]];
    for (point, published) in convergence.points.iter().zip(published) {
        let e = point.errors.as_ref().unwrap();
        for (got, want) in [e.at_end[1], e.at_end[0], e.l2[1], e.l2[0]].into_iter().zip(published) {
            assert!((got / want - 1.0).abs() < 1e-4, "{:?}: {got} against {want}", point.sbp);
        }
        let all = Quantity::all(2);
        for (largest, at_end) in [(Quantity::LARGEST_FINAL, true), (Quantity::LARGEST_L2, false)] {
            let of = all.iter().filter(|quantity| quantity.is_at_end == at_end).map(|quantity| quantity.of(e));
            assert_eq!(largest.of(e), of.fold(0.0, f64::max));
        }
    }
}

#[test]
fn the_fit_stops_at_the_rounding_plateau() {
    let n: Vec<usize> = (6..19).map(|power| 1 << power).collect();
    let convergence = swept::<f64>(&case(""), &BOTH[1..], &n);
    for slope in convergence.slopes((0, usize::MAX)) {
        let (n_min, n_max) = slope.n_range.unwrap();
        assert_eq!(n_min, 64);
        assert!((16_384..200_000).contains(&n_max), "{:?}: fitted to {n_max}", slope.quantity);
        assert!(slope.plateau_from.is_some_and(|n| n > n_max));
    }
}

#[test]
#[ignore = "long: a quarter of a million nodes in 40 digits"]
fn the_slope_of_sbp42_goes_on_below_the_rounding_of_f64() {
    let convergence = swept::<Extended>(&case("solver.digits=40"), &BOTH[1..], &[512, 8192, 65_536, 262_144]);
    assert!(convergence.reference.error_estimate < 1e-38);
    for slope in convergence.slopes((0, usize::MAX)) {
        assert_eq!(slope.plateau_from, None, "{:?}", slope.quantity);
        let fit = slope.fit.as_ref().unwrap();
        assert!((fit.slope - 3.0).abs() < 0.02, "{:?}: {}", slope.quantity, fit.slope);
        assert!((fit.local_slopes[2] - 3.0).abs() < 2e-3, "{:?}: {:?}", slope.quantity, fit.local_slopes);
    }
    let finest = convergence.points.last().unwrap().errors.clone().unwrap();
    assert!(Quantity::EPS_X_FINAL.of(&finest) < 1e-16 && Quantity::EPS_T_FINAL.of(&finest) < 1e-16, "{finest:?}");
}

#[test]
fn points_are_ordered_and_failures_are_points() {
    // At N = 8 the long run is hopelessly coarse for SBP42; the sweep goes on.
    let convergence = swept::<f64>(&case("grid.gamma_f=20.0"), &BOTH, &[400, 8, 400, 200]);
    let order: Vec<(SbpName, usize)> = convergence.points.iter().map(|p| (p.sbp, p.n_gamma)).collect();
    let expected: Vec<_> = BOTH.into_iter().flat_map(|(sbp, _)| [8, 200, 400].map(|n| (sbp, n))).collect();
    assert_eq!(order, expected);
    let failed = &convergence.points[3];
    assert!(failed.errors.is_none() && failed.status.as_str() != "converged", "{failed:?}");
    assert!(convergence.points[5].errors.is_some());
}

#[test]
fn a_sweep_that_cannot_be_is_refused() {
    let refused = |case: &Case, sbp, n: usize| Sweep::<f64>::new(case, &[(sbp, Form::Weak)], &[n]).err();
    for case in [case(""), shipped("henon-heiles", &[])] {
        let at_least = refused(&case, SbpName::Sbp42, 7);
        assert!(matches!(at_least, Some(SweepError::Grid(message)) if message.contains("at least 8")));
        assert!(matches!(refused(&case, SbpName::Sbp42, usize::MAX / 2), Some(SweepError::Grid(_))));
    }
    let falls = "potential={linear={alpha=-0.5}} initial.x=0.0 initial.x_dot=0.0 grid.gamma_f=5.0";
    assert!(matches!(refused(&case(falls), SbpName::Sbp42, 64), Some(SweepError::Reference(_))));
}

#[test]
fn a_sweep_ends_where_the_run_ends() {
    let until = shipped("henon-heiles", &["grid.gamma_f=20.0", "grid.until=\"x\"", "grid.windows=1"]);
    let gll16 = [(SbpName::Gll(16), Form::Weak)];
    let convergence = swept::<f64>(&until, &gll16, &[200]);
    let x = place(&until, "x");
    assert!(convergence.reference.end[x].abs() < 1e-12, "{:?}", convergence.reference);
    assert!(convergence.reference.gamma_final < 20.0);
    assert!(convergence.points[0].errors.as_ref().unwrap().at_end[x] < 1e-12);
    let convergence = swept::<f64>(&shipped("kerr-inclined", &["grid={t_f=50.0}"]), &gll16, &[200]);
    assert!((convergence.reference.end[0] - 50.0).abs() < 1e-12, "{:?}", convergence.reference);
    let convergence = swept::<f64>(&case("grid={t_f=1.4686347569557309,n_gamma=32}"), &BOTH, &[64]);
    assert!((convergence.reference.gamma_final - 1.0).abs() < 1e-13);
    assert!((convergence.points[0].errors.as_ref().unwrap().at_end[1] / 9.71630e-5 - 1.0).abs() < 1e-4);
}

/// The grids are swept, and not the run to the accuracy.
#[test]
fn an_accuracy_of_the_case_does_not_take_the_place_of_the_grids() {
    let n_gamma = [64, 128];
    let [with, without] = ["solver.accuracy=1e-9", "grid.windows=1"].map(|key| {
        let case = shipped("henon-heiles", &["grid.gamma_f=4.0", key]);
        swept::<f64>(&case, &[(SbpName::Sbp42, Form::Weak)], &n_gamma).points
    });
    let errors = |points: &[ConvergencePoint]| points.iter().map(|point| point.errors.clone()).collect::<Vec<_>>();
    assert!(with.iter().all(|point| point.errors.is_some()));
    assert_eq!(errors(&with), errors(&without));
    assert_eq!(with.iter().map(|point| point.n_gamma).collect::<Vec<_>>(), n_gamma);
}

#[test]
fn errors_count_against_the_motion_from_its_own_start() {
    // x = 2 cos(γ − 1.5) over a quarter of its period, and t = 5 + 3 (γ − 1.5).
    let wave = r#"
        potential = { coordinates = ["x"], formula = "9*x^2/2" }
        particle.law = "newtonian"
        initial = { t = 5.0, t_dot = 3.0, x = 0.0, x_dot = 6.0 }
        grid = { gamma_i = 1.5, gamma_f = "1.5 + pi/18", n_gamma = 33 }
        scheme.sbp = "SBP21"
    "#;
    // x = 0.3 − 2 γ is largest at the end of the run, which does not begin at 0.
    let line =
        "potential={free={}} initial={t=7.0,x=0.3,t_dot=3.0,x_dot=-2.0} grid={gamma_i=1.5,gamma_f=2.75,n_gamma=32}";
    let length = std::f64::consts::PI / 18.0;
    for (case, length, most) in [(parsed(wave, &[]), length, 2.0 / 3.0), (case(line), 1.25, 2.2)] {
        let convergence = swept::<f64>(&case, &BOTH[..1], &[33]);
        let (reference, point) = (&convergence.reference, &convergence.points[0]);
        let [t, x] = ["t", "x"].map(|name| place(&case, name));
        assert!((reference.gamma_final - 1.5 - length).abs() < 1e-14, "{reference:?}");
        assert!((reference.sizes[t] - 3.0 * length).abs() < 1e-13, "{reference:?}");
        assert!((reference.sizes[x] - most).abs() < 1e-13, "{reference:?}");
        assert!((point.delta_gamma - length / 32.0).abs() < 1e-15 && point.n_gamma == 33, "{point:?}");
        assert!(case.is_of_x || (reference.end[t] - 5.0 - 3.0 * length).abs() < 1e-13, "{reference:?}");
    }
}
