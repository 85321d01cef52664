//! The certificates of marches in one coordinate.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use geodesic_ivp::action::DoubledAction;
use geodesic_ivp::engine::lobatto::{Adaptive, Goal, Level, March, State, WeakRule, WindowView};
use geodesic_ivp::geometry::geodesic::InitialData;
use geodesic_ivp::geometry::metric::Metric;
use geodesic_ivp::geometry::potential::{Formula, Potential};
use geodesic_ivp::sbp::SbpName;

fn formula(expression: &str) -> Potential {
    Potential::Formula(Formula::new(expression, &BTreeMap::new()).expect("a valid formula"))
}

fn base() -> State {
    State { t: 0.0.into(), x: 1.0.into(), w: 0.1.into() }
}

/// ∇E_weak of the window, by the action of any operator.
fn gradient_norm(view: &WindowView<'_>, metric: &Metric, q_t: f64) -> f64 {
    let n = view.rule.points();
    let sbp = SbpName::Gll(n as u8).operator(n, view.length.hi / (n - 1) as f64).expect("a rule");
    let (x, x_dot) = (view.start.x.hi, view.start.w.hi);
    let initial = InitialData { t: 0.0, x, t_dot: q_t / metric.at(x).g00, x_dot };
    let branch = [view.certified().expect("certified").elapsed, view.x()].concat();
    let unknowns = [&branch[..], &branch[..]].concat();
    let mut gradient = vec![0.0; unknowns.len()];
    DoubledAction::weak(&sbp, metric, initial.start(metric))
        .gradient(&unknowns, &mut gradient)
        .expect("inside the domain");
    gradient.iter().fold(0.0, |most, v| v.abs().max(most))
}

#[test]
fn certificates_are_gradients_of_the_action() {
    let potentials = [Potential::quartic(0.5), formula("exp(-x) + x^2/3"), formula("x^4/2"), Potential::free()];
    for potential in potentials {
        for (n, length) in [(2, 0.1), (5, 0.3), (8, 0.5), (16, 0.7), (24, 1.1), (40, 1.6)] {
            for (tolerance, level) in
                [(0.0, Level::Best), (1e-3, Level::Best), (0.1, Level::Avx2), (0.1, Level::Scalar)]
            {
                let metric = Metric::new(potential.clone(), 1.3, 1.7);
                let q_t = 2.6;
                let rule = WeakRule::shared(n);
                let mut seen = 0;
                let mut see = |view: &WindowView<'_>| {
                    let found = view.certified().unwrap().gradient_norm;
                    let expected = gradient_norm(view, &metric, q_t);
                    // Rounding of x and t, taken through two derivatives.
                    let rounding = 2e-15 * (n * n) as f64 / length;
                    let difference = (found - expected).abs();
                    assert!(difference < 1e-9 * expected + rounding, "{n}, {tolerance}: {found:e}, {expected:e}");
                    if tolerance == 0.0 {
                        assert!(found < rounding, "{n}: {found:e}");
                    } else if found > 1e3 * rounding {
                        seen += 1;
                    }
                    ControlFlow::Continue(())
                };
                let march = March::new(&metric, q_t, rule, length.into()).with_tolerance(tolerance).with_level(level);
                march.certified().run(base(), 4, &mut see).expect("the run converges");
                // Where iterations are stopped early the certificate says so. (A free particle needs none.)
                let is_free = matches!(&potential, Potential::Polynomial(p) if p.coefficients().is_empty());
                assert!(tolerance < 0.1 || is_free || n < 5 || seen > 0, "{n}, {tolerance}");
            }
        }
    }
}

#[test]
fn certificates_of_adaptive_marches_are_the_same() {
    for potential in [Potential::quartic(0.5), formula("exp(-x) + x^2/3"), Potential::free()] {
        let (metric, q_t) = (Metric::new(potential, 1.3, 1.7), 2.6);
        for accuracy in [1e-4, 1e-8, 1e-12] {
            let mut see = |view: &WindowView<'_>| {
                let found = view.certified().expect("certified").gradient_norm;
                let expected = gradient_norm(view, &metric, q_t);
                let rounding = 2e-15 * view.rule.points().pow(2) as f64 / view.length.hi;
                let difference = (found - expected).abs();
                assert!(difference < 1e-9 * expected + rounding, "{accuracy:e}: {found:e}, {expected:e}");
                ControlFlow::Continue(())
            };
            let march = Adaptive::new(&metric, q_t).certified();
            march.run(base(), Goal::Gamma(6.0), accuracy, &mut see).expect("it is reached");
        }
    }
}
