//! A scene with everything at once: off-diagonal components, a one-form, a force, and coefficients that depend on time.

use std::sync::Arc;

use geodesic_ivp::action::Form;
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::geometry::{GeometryText, MetricText};
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::sbp::SbpName;
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::solve::{System, WorldLine, solve};

use crate::common;

/// Coordinates t, x, y and z; z is ignorable and coupled to x.
fn text() -> GeometryText {
    let components = [
        ("t t", "1 + x^2/4"),
        ("t x", "0.2*cos(t)"),
        ("x x", "-1 - y^2/10"),
        ("y y", "-1"),
        ("x z", "0.3*y"),
        ("z z", "-2 - sin(x)"),
    ];
    GeometryText::Metric(MetricText {
        one_form: vec![(1, "0.1*y".into()), (2, "0.2*x*t".into())],
        force: vec![(0, "0.05*x_dot^2".into()), (1, "-k*x_dot".into()), (2, "-k*y_dot*t_dot".into())],
        parameters: vec![("k".into(), "0.3".into())],
        ..common::metric(&["t", "x", "y", "z"], &components)
    })
}

const START: (&[&str], &[&str]) = (&["0.1", "0.5", "-0.2", "0.3"], &["1", "0.3", "-0.4", "0.2"]);

fn solved<S: Arithmetic>(sbp: SbpName, form: Form, n_gamma: usize, windows: usize, system: System) -> WorldLine<S> {
    let setup = common::setup::<S>(&text(), START, 2.0, (sbp, form, n_gamma), system);
    solve(common::in_windows(setup, windows)).unwrap_or_else(|failure| panic!("{sbp:?} {form:?}: {failure}"))
}

fn error(line: &WorldLine<f64>, exact: &[f64]) -> f64 {
    line.end().q.iter().zip(exact).fold(0.0, |most: f64, (q, exact)| most.max((q - exact).abs()))
}

#[test]
fn every_operator_has_its_order_in_both_forms() {
    let exact = solved::<f64>(SbpName::Gll(20), Form::Weak, 20, 8, System::PhysicalLimit).end().q.clone();
    let orders = [
        (SbpName::Sbp21, [2.0, 2.0]),
        (SbpName::Sbp42, [3.0, 4.0]),
        (SbpName::Sbp63, [4.0, 6.0]),
        (SbpName::Sbp84, [5.0, 8.0]),
    ];
    for (sbp, [strong, weak]) in orders {
        for (form, order) in [(Form::Strong, strong), (Form::Weak, weak)] {
            let nodes = if order > 6.0 { [25, 37] } else { [61, 121] };
            let [coarse, fine] = nodes.map(|nodes| error(&solved(sbp, form, nodes, 1, System::PhysicalLimit), &exact));
            let slope = (coarse / fine).ln() / ((nodes[1] - 1) as f64 / (nodes[0] - 1) as f64).ln();
            assert!(slope > order - 0.35, "{sbp:?} {form:?}: {coarse:e}, {fine:e}, slope {slope}");
        }
    }
    for n in [3_u8, 4, 5, 6] {
        let windows = if n < 5 { [16, 32] } else { [2, 4] };
        let [coarse, fine] = windows.map(|windows| {
            error(&solved(SbpName::Gll(n), Form::Weak, n.into(), windows, System::PhysicalLimit), &exact)
        });
        let (slope, order) = ((coarse / fine).log2(), f64::from(2 * n - 2));
        assert!((slope - order).abs() < 0.6, "GLL{n}: {coarse:e}, {fine:e}, slope {slope}");
    }
}

#[test]
fn the_physical_limit_is_a_critical_point_of_the_whole_action() {
    for (sbp, n_gamma) in [(SbpName::Sbp21, 12), (SbpName::Sbp42, 12), (SbpName::Sbp63, 16), (SbpName::Gll(12), 12)] {
        for form in [Form::Strong, Form::Weak] {
            let limit = solved::<f64>(sbp, form, n_gamma, 1, System::PhysicalLimit);
            let bound = 1e-13 * n_gamma as f64 * limit.sbp().stiffness().powi(2);
            assert!(limit.gradient_norm < bound, "{sbp:?} {form:?}: {:e}", limit.gradient_norm);
            let doubled = solved::<f64>(sbp, form, n_gamma, 1, System::Doubled);
            assert!(doubled.branch_distance() < 1e-11, "{sbp:?} {form:?}: {:e}", doubled.branch_distance());
            let apart = error(&doubled, &limit.end().q);
            assert!(apart < 1e-11, "{sbp:?} {form:?}: the systems end {apart:e} apart");
            let [doubled, limit] = [doubled, limit].map(|line| line.end().p);
            let momenta = doubled.iter().zip(&limit);
            assert!(momenta.clone().all(|(a, b)| (a - b).abs() < 1e-10), "{sbp:?} {form:?}: {momenta:?}");
        }
    }
}

#[test]
fn the_charge_of_an_ignorable_coordinate_is_exact_beside_everything_else() {
    for form in [Form::Strong, Form::Weak] {
        for system in [System::PhysicalLimit, System::Doubled] {
            let line = solved::<Extended>(SbpName::Sbp42, form, 24, 1, system);
            let names = Arc::clone(&line.place.geometry);
            assert_eq!(names.ignorable().collect::<Vec<_>>(), [3]);
            let measured = Diagnostics::of(&line, &[], &mut [], false);
            let charge = &measured.charges[0];
            assert!(charge.max_interior.to_f64() < 1e-36, "{form:?} {system:?}: {:e}", charge.max_interior.to_f64());
            assert!(charge.max_corrected.to_f64() < 1e-36, "{form:?} {system:?}");
            assert!(measured.max_delta_g.to_f64() < 1e-34, "{form:?} {system:?}: {:e}", measured.max_delta_g.to_f64());
            if form == Form::Strong {
                assert!(charge.max_last.to_f64() > 1e-9, "the last node takes up a defect");
            }
        }
    }
}
