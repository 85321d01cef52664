//! The estimate of rounding in the gradient: it has the units of the gradient, and counts what there is to be rounded.

use geodesic_ivp::action::{DoubledAction, Form, GradientRounding};
use geodesic_ivp::geometry::MetricText;
use geodesic_ivp::sbp::{SbpOperator, coefficients};

use crate::common::{geometry, metric, start};

const POINTS: usize = 9;
const COORDINATES: usize = 3;

/// A scene with coordinates q^a → s_a q^a and γ → r γ, in which the action is divided by r.
fn scene([t, x, y]: [f64; COORDINATES], r: f64) -> MetricText {
    let components = [
        ("t t", "(1 + (x/sx)^2/2)/st^2"),
        ("x x", "-1/sx^2"),
        ("x y", "0.3*(x/sx)*(y/sy)/(sx*sy)"),
        ("y y", "-(2 + (x/sx)^2)/sy^2"),
    ];
    let parameters = [("st", t), ("sx", x), ("sy", y), ("r", r)];
    MetricText {
        parameters: parameters.map(|(name, value)| (name.to_owned(), format!("{value:?}"))).to_vec(),
        one_form: vec![(0, "0.7*(x/sx)^2/(r*st)".to_owned())],
        force: vec![(1, "-(0.4*(r*x_dot/sx) + 0.1*(r*y_dot/sy)^2)/(r^2*sx)".to_owned())],
        ..metric(&["t", "x", "y"], &components)
    }
}

/// The estimates in those units, in units of the scene that is not scaled.
fn estimates(form: Form, s: [f64; COORDINATES], r: f64) -> GradientRounding {
    let geometry = geometry::<f64>(&scene(s, r));
    let scaled = |values: [f64; COORDINATES], by: f64| -> Vec<f64> {
        values.iter().zip(s).map(|(value, s)| value * (s * by)).collect()
    };
    let start = start(&geometry, &scaled([0.1, 0.7, -0.4], 1.0), &scaled([1.2, -0.3, 0.6], 1.0 / r));
    let sbp = SbpOperator::new(&coefficients::SBP42, POINTS, 0.125 * r).unwrap();
    let action = DoubledAction::new(form, &sbp, &geometry, start);
    let layout = action.layout();
    let mut u = vec![0.0; layout.unknowns()];
    for (a, s) in s.into_iter().enumerate() {
        for branch in 0..2 {
            let wave = |k: usize| (0.9 * k as f64 + a as f64 + 0.1 * branch as f64).sin();
            let row = layout.values_mut(&mut u, branch, a);
            row.iter_mut().enumerate().for_each(|(k, q)| *q = s * wave(k));
        }
        if form == Form::Strong {
            let multipliers = layout.multipliers_mut(&mut u);
            for place in [layout.lambda(a), layout.nu(a)] {
                multipliers[place] = 1.5 / (r * s);
            }
            for place in [layout.mu(a), layout.kappa(a)] {
                multipliers[place] = 0.25 / s;
            }
        }
    }
    let GradientRounding { rows, values, sizes } = action.gradient_rounding(&u).unwrap();
    GradientRounding {
        sizes: sizes.iter().zip(s).map(|(size, s)| size / s).collect(),
        rows: rows.iter().zip(s).map(|(row, s)| row * (r * s)).collect(),
        values: values.iter().zip(s).map(|(value, s)| value / s).collect(),
    }
}

#[test]
fn the_estimate_knows_no_units() {
    // Powers of two, so that nothing is rounded.
    let (large, small) = (2.0_f64.powi(40), 2.0_f64.powi(-40));
    for form in [Form::Strong, Form::Weak] {
        let plain = estimates(form, [1.0; COORDINATES], 1.0);
        assert!(plain.rows.iter().chain(&plain.values).all(|size| (1e-17..1e-11).contains(size)), "{plain:?}");
        for factor in [large, small] {
            assert_eq!(estimates(form, [1.0; COORDINATES], factor), plain, "gamma, {factor:e}");
            // Coordinates that are coupled have one unit.
            for s in [[factor, 1.0, 1.0], [1.0, factor, factor]] {
                assert_eq!(estimates(form, s, 1.0), plain, "{s:?}");
            }
        }
    }
}

#[test]
fn what_rests_at_zero_is_rounded_as_it_falls_and_multipliers_add_up() {
    let force = MetricText { force: vec![(0, "0.5".to_owned())], ..metric(&["x", "y"], &[("x x", "2"), ("y y", "1")]) };
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
