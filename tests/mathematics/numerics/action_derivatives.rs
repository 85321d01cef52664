//! Gradient and Hessian of the doubled action against differences of the action and of the gradient.

use geodesic_ivp::action::{DoubledAction, Form};
use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::sbp::{SbpOperator, coefficients};
use proptest::prelude::*;

use crate::common::{of_x, start};

const POINTS: usize = 10;
/// t and x at the start, and their velocities.
const PLACE: [f64; 2] = [0.4, 0.8];
const TANGENT: [f64; 2] = [1.3, -0.2];

fn geometry() -> Geometry {
    of_x("exp(-0.7*x) + x^3/5", 1.7, 1.2)
}

fn begin(geometry: &Geometry) -> Start {
    start(geometry, &PLACE, &TANGENT)
}

fn with_actions(check: impl Fn(&DoubledAction<'_>)) {
    let geometry = geometry();
    for c in [&coefficients::SBP21, &coefficients::SBP42] {
        let sbp = SbpOperator::new(c, POINTS, 0.11).unwrap();
        let action = |form| DoubledAction::new(form, &sbp, &geometry, begin(&geometry));
        check(&action(Form::Strong));
        check(&action(Form::Strong).without_regularisation());
        check(&action(Form::Weak));
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
}

#[test]
fn the_value_vanishes_where_the_branches_agree_and_the_constraints_hold() {
    with_actions(|action| {
        let sbp = action.sbp();
        let line = |start: f64, slope: f64| -> Vec<f64> {
            (0..POINTS).map(|k| start + slope * k as f64 * sbp.spacing()).collect()
        };
        let (t, x) = (line(PLACE[0], TANGENT[0]), line(PLACE[1], TANGENT[1]));
        let multipliers = [1.0, -2.0, 3.0, -4.0, 5.0, -6.0, 7.0, -8.0];
        let u = action.layout().physical_limit(&[&t, &x], &multipliers[..action.layout().multiplier_range().len()]);
        assert!(action.value(&u).unwrap().abs() < 1e-13);
        assert!(action.constraints(&u).iter().all(|c| c.abs() < 1e-13));
    });
}

#[test]
fn a_node_outside_the_domain_is_named() {
    let geometry = of_x("-0.5*x", 1.0, 1.0);
    let sbp = SbpOperator::new(&coefficients::SBP21, 4, 0.1).unwrap();
    let action = DoubledAction::new(Form::Strong, &sbp, &geometry, begin(&geometry));
    let u = action.layout().physical_limit(&[&[0.0; 4], &[0.0, 0.5, 1.25, 0.0]], &[0.0; 8]);
    let outside = action.value(&u).unwrap_err();
    assert_eq!((outside.index, outside.position, outside.determinant), (2, 1.25, -0.25));
}
