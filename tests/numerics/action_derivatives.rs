//! Gradient and Hessian of the doubled action against differences of the action and of the gradient.

use std::collections::BTreeMap;

use geodesic_ivp::action::DoubledAction;
use geodesic_ivp::geometry::geodesic::InitialData;
use geodesic_ivp::geometry::metric::Metric;
use geodesic_ivp::geometry::potential::{Formula, Potential};
use geodesic_ivp::sbp::{SbpOperator, coefficients};
use proptest::prelude::*;

const INITIAL: InitialData = InitialData { t: 0.4, x: 0.8, t_dot: 1.3, x_dot: -0.2 };
const POINTS: usize = 10;

fn metric() -> Metric {
    let parameters = BTreeMap::from([("a".to_owned(), 0.7)]);
    Metric::new(Potential::Formula(Formula::new("exp(-a*x) + x^3/5", &parameters).unwrap()), 1.7, 1.2)
}

fn with_actions(check: impl Fn(&DoubledAction<'_>)) {
    let metric = metric();
    for c in [&coefficients::SBP21, &coefficients::SBP42] {
        let sbp = SbpOperator::new(c, POINTS, 0.11).unwrap();
        check(&DoubledAction::new(&sbp, &metric, INITIAL.start(&metric)));
        check(&DoubledAction::without_regularisation(&sbp, &metric, INITIAL.start(&metric)));
        check(&DoubledAction::weak(&sbp, &metric, INITIAL.start(&metric)));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn the_gradient_is_the_derivative_of_the_value(u in proptest::collection::vec(-1.0..1.5_f64, 4 * POINTS + 8)) {
        with_actions(|action| {
            let u = u[..action.layout().unknowns()].to_vec();
            let mut gradient = vec![0.0; u.len()];
            action.gradient(&u, &mut gradient).unwrap();
            for i in 0..u.len() {
                let shifted = |step: f64| {
                    let mut u = u.clone();
                    u[i] += step;
                    action.value(&u).unwrap()
                };
                // Richardson's combination of two central differences: fourth order in the step.
                let h = 2e-3;
                let central = |h: f64| shifted(h) - shifted(-h);
                let difference = (8.0 * central(h) - central(2.0 * h)) / (12.0 * h);
                let size = 1.0 + gradient[i].abs();
                let entry = gradient[i];
                assert!((difference - entry).abs() < 2e-7 * size, "entry {i}: {difference} against {entry}");
            }
        });
    }

    #[test]
    fn the_hessian_is_the_derivative_of_the_gradient(u in proptest::collection::vec(-1.0..1.5_f64, 4 * POINTS + 8)) {
        with_actions(|action| {
            let u = u[..action.layout().unknowns()].to_vec();
            let pattern = action.hessian_pattern();
            let hessian = action.hessian(&u, &pattern).unwrap();
            for j in 0..u.len() {
                let shifted = |step: f64| {
                    let mut u = u.clone();
                    u[j] += step;
                    let mut gradient = vec![0.0; u.len()];
                    action.gradient(&u, &mut gradient).unwrap();
                    gradient
                };
                let h = 1e-3;
                let (a, b, c, d) = (shifted(h), shifted(-h), shifted(2.0 * h), shifted(-2.0 * h));
                for i in 0..u.len() {
                    let difference = (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h);
                    let entry = hessian.get(i, j);
                    let size = 1.0 + entry.abs();
                    assert!((difference - entry).abs() < 2e-7 * size, "({i}, {j}): {difference} against {entry}");
                    assert!((entry - hessian.get(j, i)).abs() <= 1e-12 * size, "({i}, {j}) is symmetric");
                }
            }
        });
    }
}

#[test]
fn the_value_vanishes_where_the_branches_agree_and_the_constraints_hold() {
    with_actions(|action| {
        let sbp = action.sbp();
        let line = |start: f64, slope: f64| -> Vec<f64> {
            (0..POINTS).map(|k| start + slope * k as f64 * sbp.spacing()).collect()
        };
        let (t, x) = (line(INITIAL.t, INITIAL.t_dot), line(INITIAL.x, INITIAL.x_dot));
        let multipliers = [1.0, -2.0, 3.0, -4.0, 5.0, -6.0, 7.0, -8.0];
        let u = action.layout().physical_limit(&[&t, &x], &multipliers[..action.layout().multiplier_range().len()]);
        assert!(action.value(&u).unwrap().abs() < 1e-13);
        assert!(action.constraints(&u).iter().all(|c| c.abs() < 1e-13));
    });
}

#[test]
fn a_node_outside_the_domain_is_named() {
    let metric = Metric::new(Potential::linear(-0.5), 1.0, 1.0);
    let sbp = SbpOperator::new(&coefficients::SBP21, 4, 0.1).unwrap();
    let action = DoubledAction::new(&sbp, &metric, INITIAL.start(&metric));
    let u = action.layout().physical_limit(&[&[0.0; 4], &[0.0, 0.5, 1.25, 0.0]], &[0.0; 8]);
    let outside = action.value(&u).unwrap_err();
    assert_eq!((outside.index, outside.x, outside.g00), (2, 1.25, -0.25));
}
