//! The estimate of rounding in the gradient counts what there is to be rounded. That it knows no units is tested on
//! whole runs, in `world_lines/units.rs`.

use geodesic_ivp::action::{DoubledAction, Form, GradientRounding};
use geodesic_ivp::geometry::GeometryText;
use geodesic_ivp::sbp::{SbpOperator, coefficients};

use crate::common::{geometry, metric, start};

const POINTS: usize = 9;

#[test]
fn what_rests_at_zero_is_rounded_as_it_falls_and_multipliers_add_up() {
    let force =
        GeometryText { force: vec![(0, "0.5".to_owned())], ..metric(&["x", "y"], &[("x x", "2"), ("y y", "1")]) };
    let geometry = geometry::<f64>(&force);
    let h = 0.125;
    let sbp = SbpOperator::new(&coefficients::SBP21, POINTS, h).unwrap();
    let action = DoubledAction::new(Form::Strong, &sbp, &geometry, start(&geometry, &[0.0; 2], &[0.0; 2]));
    let layout = action.layout();
    let mut u = vec![0.0; layout.unknowns()];
    let at_rest = action.gradient_rounding(&u).unwrap();
    // x falls by ½h²F/m in a step. y does not, and is not known better than by what acts by ε of that.
    let fall = 0.5 * h * h * 0.5 / 2.0 * f64::EPSILON;
    assert!((0.99..20.0).contains(&(at_rest.values[0] / fall)), "{at_rest:?}");
    assert!(at_rest.values[1] < 1e-7 * at_rest.values[0]);
    // λ and μ/h are terms of one sum.
    let mut rows = |lambda: f64, mu: f64| {
        let multipliers = layout.multipliers_mut(&mut u);
        (multipliers[layout.lambda(0)], multipliers[layout.mu(0)]) = (lambda, mu * h);
        action.gradient_rounding(&u).unwrap().rows[0]
    };
    let [both, first, second] = [rows(1e9, 1e9), rows(1e9, 0.0), rows(0.0, 1e9)];
    assert!(first == second && both == 2.0 * first && first >= 1e9 * f64::EPSILON, "{both} {first} {second}");
}

/// The rows of an operator of higher order amplify what q^a is rounded by, and D is applied twice.
#[test]
fn rounding_grows_with_the_entries_of_the_operator() {
    let geometry = geometry::<f64>(&metric(&["t", "x"], &[("t t", "1"), ("x x", "-1")]));
    let estimate = |sbp: &SbpOperator| {
        let action = DoubledAction::new(Form::Weak, sbp, &geometry, start(&geometry, &[3.0, 2.0], &[0.0; 2]));
        let mut u = vec![0.0; action.layout().unknowns()];
        for branch in 0..2 {
            action.layout().values_mut(&mut u, branch, 0).fill(3.0);
            action.layout().values_mut(&mut u, branch, 1).fill(2.0);
        }
        let GradientRounding { rows, values, .. } = action.gradient_rounding(&u).unwrap();
        [values[0], values[1], rows[0], rows[1]]
    };
    let [plain, high] = [&coefficients::SBP21, &coefficients::SBP84].map(|coefficients| {
        let sbp = SbpOperator::new(coefficients, 24, 0.125).unwrap();
        (estimate(&sbp), sbp.stiffness())
    });
    assert!(plain.1 == 1.0 && high.1 > 1.2, "{}", high.1);
    for (power, (plain, high_estimate)) in [1, 1, 2, 2].into_iter().zip(plain.0.into_iter().zip(high.0)) {
        assert!((high_estimate / (plain * high.1.powi(power)) - 1.0).abs() < 1e-12, "{plain:e} {high_estimate:e}");
    }
}
