//! The engine of few nodes in windows that it chooses for an accuracy.

use std::ops::ControlFlow;

use geodesic_ivp::engine::{Accuracy, Engine, Failure};
use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::reference::ReferenceTrajectory;

use super::engine::{SCENES, scene};

/// A run: γ and q^a of all nodes, window by window, with the estimate of its error.
struct Run {
    nodes: Vec<(f64, Vec<f64>)>,
    lengths: Vec<f64>,
    estimate: f64,
}

fn run(geometry: &Geometry, start: &Start, length: f64, accuracy: f64, points: usize) -> Result<Run, Failure> {
    let wanted = Accuracy::Promised(accuracy);
    let mut engine = Engine::accurate(geometry, start, length, wanted, points).unwrap();
    let mut run = Run { nodes: Vec::new(), lengths: Vec::new(), estimate: 0.0 };
    engine.run(|mut window| {
        if window.index == 0 {
            (run.nodes, run.lengths) = (Vec::new(), Vec::new());
        }
        let (gamma, h, begin) = (window.gamma, window.length, window.start().positions());
        assert!(window.gradient_norm().unwrap().is_finite());
        run.lengths.push(h);
        let nodes = window.nodes();
        for (k, fraction) in nodes.fractions().iter().enumerate() {
            let q = (0..begin.len()).map(|a| {
                let q = nodes.q(a)[k];
                if geometry.active().contains(&a) { q } else { begin[a] + q }
            });
            run.nodes.push((gamma + fraction * h, q.collect()));
        }
        ControlFlow::Continue(())
    })?;
    run.estimate = engine.error_estimate().unwrap();
    Ok(run)
}

/// The largest error of a coordinate, relative to its largest value, with the coordinate and γ.
fn error(run: &Run, reference: &ReferenceTrajectory<f64, Geometry>) -> (f64, usize, f64) {
    let n = run.nodes[0].1.len();
    let exact: Vec<Vec<f64>> = run.nodes.iter().map(|(gamma, _)| reference.at(*gamma).q).collect();
    let of = |a: usize| {
        let size = exact.iter().fold(f64::MIN_POSITIVE, |size, q| size.max(q[a].abs()));
        let off = run.nodes.iter().zip(&exact).map(|((gamma, q), exact)| ((q[a] - exact[a]).abs() / size, a, *gamma));
        off.max_by(|one, other| one.0.total_cmp(&other.0)).unwrap()
    };
    (0..n).map(of).max_by(|one, other| one.0.total_cmp(&other.0)).unwrap()
}

/// No coordinate is further off at any node than was asked for. The estimate has one digit: in one run of sixty the
/// true error is larger.
#[test]
fn accuracies_are_kept_and_known() {
    let quartic = (
        "quartic",
        "potential = { coordinates = [\"x\"], formula = \"x^4/2\" }\ninitial = { x = 1.0, t_dot = 1.0, x_dot = 0.1 }\n",
    );
    for (name, text) in SCENES.into_iter().chain([quartic]) {
        let text = text.split("grid").next().unwrap();
        let (geometry, start) = scene(text);
        let length = match name {
            "kerr" | "charged schwarzschild" => 300.0,
            "henon-heiles" | "friction" => 60.0,
            "quartic" => 30.0,
            _ => 4.0,
        };
        let reference = ReferenceTrajectory::new(&geometry, &start, length, 16).unwrap();
        for points in [8, 16] {
            for accuracy in [1e-4, 1e-6, 1e-8, 1e-10] {
                let run = run(&geometry, &start, length, accuracy, points).unwrap();
                let (error, a, gamma) = error(&run, &reference);
                let error = error - 2.0 * reference.error_estimate();
                assert!(
                    error <= accuracy && error <= 2.0 * run.estimate && run.estimate <= accuracy,
                    "{name}, {points} nodes, {accuracy:e}: {error:e} in coordinate {a} at {gamma}, {:e}",
                    run.estimate
                );
            }
        }
    }
}

/// Kepler's problem with e = 0.6 in units in which lengths are 2^a times, times 2^b times and masses 2^c times as
/// large.
fn kepler([a, b, c]: [i32; 3]) -> (Geometry, Start, f64) {
    let two = |k: i32| 2.0_f64.powi(k);
    let (x, v, m, k) = (0.4 * two(a), 2.0 * two(a - b), 0.7 * two(c), 0.7 * two(c + 3 * a - 2 * b));
    let (geometry, start) = scene(&format!(
        "potential = {{ coordinates = [\"x\", \"y\"], formula = \"-{k:?}/sqrt(x^2 + y^2)\" }}\n\
         particle = {{ law = \"newtonian\", mass = {m:?} }}\n\
         initial = {{ x = {x:?}, y = 0.0, x_dot = 0.0, y_dot = {v:?} }}\n"
    ));
    (geometry, start, 20.0 * two(b))
}

/// In other units that are powers of two no digit is another one.
#[test]
fn nothing_depends_on_units() {
    for points in [8, 16] {
        for accuracy in [1e-5, 1e-9] {
            let known = {
                let (geometry, start, length) = kepler([0, 0, 0]);
                run(&geometry, &start, length, accuracy, points).unwrap()
            };
            for [a, b, c] in [[40, -24, -60], [-80, 16, 80], [4, 60, -8], [-12, -44, 0]] {
                let (geometry, start, length) = kepler([a, b, c]);
                let run = run(&geometry, &start, length, accuracy, points).unwrap();
                let [length, time] = [a, b].map(|k| 2.0_f64.powi(-k));
                let lengths: Vec<f64> = run.lengths.iter().map(|h| h * time).collect();
                assert_eq!(lengths, known.lengths, "{a} {b} {c}");
                assert_eq!(run.estimate.to_bits(), known.estimate.to_bits());
                for ((_, q), (_, known)) in run.nodes.iter().zip(&known.nodes) {
                    assert_eq!([q[1] * length, q[2] * length, q[0] * time], [known[1], known[2], known[0]]);
                }
            }
        }
    }
}

/// At an equilibrium nothing moves, and nothing is off.
#[test]
fn rest_stays_rest() {
    let (geometry, start) = scene(
        "potential = { coordinates = [\"x\", \"y\"], formula = \"(x - 3)^2 + (y + 1)^2 + (x - 3)*(y + 1)/2\" }\n\
         particle.law = \"newtonian\"\ninitial = { x = 3.0, y = -1.0, x_dot = 0.0, y_dot = 0.0 }\n",
    );
    for points in [8, 16] {
        let run = run(&geometry, &start, 1000.0, 1e-8, points).unwrap();
        assert!(run.nodes.iter().all(|(_, q)| q[1] == 3.0 && q[2] == -1.0));
        assert!(run.estimate <= 1e-8);
    }
}
