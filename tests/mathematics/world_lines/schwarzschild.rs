//! An orbit that falls towards a black hole, on coarse grids: published critical points, charges at every node.

use geodesic_ivp::action::Form;
use geodesic_ivp::geometry::{GeometryText, Preset};
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::sbp::SbpName;
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::solve::{Setup, System, WorldLine, solve};

use crate::common;

const START: (&[&str], &[&str]) = (&["0", "10", "0"], &["1.2", "-0.05", "0.03"]);

fn setup<S: Arithmetic>(operator: (SbpName, Form, usize), system: System) -> Setup<S> {
    let text = GeometryText::Metric(Preset::from_name("schwarzschild").unwrap().text());
    common::setup(&text, START, 40.0, operator, system)
}

/// p_a − p_a,i at node k of the only window, from D̄q.
fn deviation<S: Arithmetic>(line: &WorldLine<S>, a: usize, k: usize) -> S {
    let start = &line.place.start;
    let rows: Vec<Vec<S>> = (0..3).map(|a| line.q(a).collect()).collect();
    let q: Vec<S> = rows.iter().map(|row| row[k]).collect();
    let penalty = |a: usize| if k == 0 { (rows[a][0] - start.q[a]) / line.sbp().weights()[0] } else { S::ZERO };
    let q_dot: Vec<S> = (0..3).map(|a| line.sbp().derivative_at(&rows[a], k) + penalty(a)).collect();
    line.geometry().momenta(&q, &q_dot)[a] - start.p[a]
}

struct Expected {
    operator: (SbpName, Form, usize),
    end: [f64; 3],
    last: [f64; 2],
}

fn expected() -> [Expected; 4] {
    let strong = Form::Strong;
    [
        Expected {
            operator: (SbpName::Sbp21, strong, 33),
            end: [53.8760029482, 3.72639917093, 2.49081375858],
            last: [-0.0702064, 0.392967],
        },
        Expected {
            operator: (SbpName::Sbp42, strong, 33),
            end: [53.9568945458, 3.6993501136, 2.50786648864],
            last: [-0.033648, 0.157672],
        },
        Expected {
            operator: (SbpName::Sbp42, Form::Weak, 33),
            end: [54.0514978057, 3.67228113435, 2.52655645927],
            last: [0.0; 2],
        },
        Expected {
            operator: (SbpName::Gll(12), Form::Weak, 12),
            end: [53.9869982576, 3.69493627391, 2.5126063736],
            last: [0.0; 2],
        },
    ]
}

#[test]
fn critical_points_have_the_published_digits_in_both_systems() {
    for Expected { operator, end, last } in expected() {
        for system in [System::PhysicalLimit, System::Doubled] {
            let line = solve(setup::<f64>(operator, system)).unwrap();
            for (a, expected) in end.into_iter().enumerate() {
                let error = (line.end().q[a] - expected).abs();
                assert!(error < 1e-10 * expected, "{operator:?} {system:?}: coordinate {a} is off by {error:e}");
            }
            for (a, expected) in [0, 2].into_iter().zip(last) {
                let error = (deviation(&line, a, operator.2 - 1) - expected).abs();
                assert!(error < 1e-5 * expected.abs() + 1e-12, "{operator:?} {system:?}: charge {a}, {error:e}");
                for k in 0..operator.2 - 1 {
                    let deviation = deviation(&line, a, k).abs();
                    assert!(deviation < 1e-12, "{operator:?} {system:?}: charge {a}, node {k}: {deviation:e}");
                }
            }
            assert!(line.gradient_norm < 1e-9, "{operator:?} {system:?}: {:e}", line.gradient_norm);
        }
    }
}

#[test]
fn charges_are_exact_in_forty_digits() {
    for Expected { operator, end, .. } in expected() {
        for system in [System::PhysicalLimit, System::Doubled] {
            let line = solve(setup::<Extended>(operator, system)).unwrap();
            assert!((line.end().q[0].to_f64() - end[0]).abs() < 1e-10 * end[0]);
            let nodes = if operator.1 == Form::Weak { operator.2 } else { operator.2 - 1 };
            for (a, k) in (0..nodes).flat_map(|k| [(0, k), (2, k)]) {
                let deviation = deviation(&line, a, k).abs().to_f64();
                assert!(deviation < 1e-36, "{operator:?} {system:?}: charge {a}, node {k}: {deviation:e}");
            }
        }
    }
}
