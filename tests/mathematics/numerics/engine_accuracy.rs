//! The engine of few nodes in windows that it chooses for an accuracy.

use std::ops::ControlFlow;

use geodesic_ivp::engine::{Accuracy, Engine, Failure};
use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::reference::ReferenceTrajectory;

use super::engine::scene;
use crate::common::{one, reference};

/// A run: γ and q^a of all nodes, window by window, with the estimate of its error.
struct Run {
    nodes: Vec<(f64, Vec<f64>)>,
    lengths: Vec<f64>,
    estimate: f64,
}

fn run(geometry: &Geometry, start: &Start, length: f64, accuracy: f64) -> Result<Run, Failure> {
    let wanted = Accuracy::Promised(accuracy);
    let mut engine = Engine::accurate(geometry, start, length, wanted).unwrap();
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
fn error(run: &Run, reference: &ReferenceTrajectory) -> (f64, usize, f64) {
    let n = run.nodes[0].1.len();
    let exact: Vec<Vec<f64>> = run.nodes.iter().map(|(gamma, _)| reference.at(*gamma).q).collect();
    let of = |a: usize| {
        let size = exact.iter().fold(f64::MIN_POSITIVE, |size, q| size.max(q[a].abs()));
        let off = run.nodes.iter().zip(&exact).map(|((gamma, q), exact)| ((q[a] - exact[a]).abs() / size, a, *gamma));
        off.max_by(|one, other| one.0.total_cmp(&other.0)).unwrap()
    };
    (0..n).map(of).max_by(|one, other| one.0.total_cmp(&other.0)).unwrap()
}

/// A scene with a name, and the length of a run in it.
type Case<'n> = (&'n str, (Geometry, Start), f64);

/// Lists what is wrong with runs to accuracies of so many digits. No coordinate is further off at any node than was
/// asked for. The estimate has one digit: in one run of sixty the true error is larger.
fn complaints((name, (geometry, start), length): &Case<'_>, digits: &[i32]) -> Vec<String> {
    let length = *length;
    let reference = reference(geometry, start, length);
    let slack = 2e-14 + 2.0 * reference.error_estimate();
    assert!(slack < 1e-11, "{name}: no reference");
    let mut complaints = Vec::new();
    for &digits in digits {
        let accuracy = 10.0_f64.powi(-digits);
        let run = match run(geometry, start, length, accuracy) {
            Ok(run) => run,
            Err(failure) => {
                complaints.push(format!("{name}, {accuracy:e}: {failure:?}"));
                continue;
            }
        };
        let ((error, a, gamma), estimate) = (error(&run, &reference), run.estimate);
        assert!((run.nodes[run.nodes.len() - 1].0 - length).abs() <= 1e-15 * length);
        if !(error <= accuracy + slack && error <= 3.0 * estimate + slack && estimate <= accuracy) {
            let off = format!("{error:e} in coordinate {a} at {gamma}, {estimate:e}");
            complaints.push(format!("{name}, {accuracy:e}: {off}"));
        }
    }
    complaints
}

/// Nothing may be wrong.
fn assert_kept(cases: &[Case<'_>], digits: &[i32]) {
    let wrong: Vec<String> = cases.iter().flat_map(|case| complaints(case, digits)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A straight line in polar coordinates passes the pole at a millionth of r and less. There a change of r by what
/// rounding makes of its largest value is a change of the motion.
#[test]
fn accuracies_are_kept_past_the_pole_of_polar_coordinates() {
    let components = "{ \"r r\" = \"1\", \"phi phi\" = \"r^2\" }";
    let metric = format!("metric = {{ coordinates = [\"r\", \"phi\"], components = {components} }}\n");
    for (phi_dot, length) in [(2e-7, 3e6), (1e-6, 1e5), (1e-5, 1e4), (1e-3, 1e6), (0.1, 30.0)] {
        let (r, r_dot) = (1.005, -0.53);
        let start = format!("initial = {{ r = {r}, phi = 0.0, r_dot = {r_dot}, phi_dot = {phi_dot} }}\n");
        let (geometry, start) = scene(&format!("{metric}{start}"));
        let run = run(&geometry, &start, length, 1e-10).unwrap();
        let off = run.nodes.iter().map(|(gamma, q)| {
            let exact = (r + r_dot * gamma).hypot(r * phi_dot * gamma);
            (q[0] - exact).abs()
        });
        let (off, size) = (off.fold(0.0, f64::max), run.nodes.iter().fold(0.0, |size: f64, (_, q)| size.max(q[0])));
        assert!(off <= 1e-10 * size, "{phi_dot}: {:e}", off / size);
    }
}

/// A shipped case of one coordinate.
fn shipped(name: &str) -> (Geometry, Start) {
    let case = crate::common::shipped(name, &[]);
    (case.geometry(), case.start())
}

#[test]
fn accuracies_are_kept_in_every_kind_of_potential() {
    let of_formula = |name, text, c, start, length| (name, one(text, c, start), length);
    let cases = [
        ("quartic", shipped("quartic"), 20.0),
        ("quartic-t-dot-8", shipped("quartic-t-dot-8"), 1.0),
        ("linear", shipped("linear"), 1.0),
        ("free", shipped("free"), 1.0),
        ("harmonic", shipped("harmonic"), std::f64::consts::TAU),
        ("pendulum", shipped("pendulum"), 10.0),
        ("morse", shipped("morse"), 6.0),
        ("double-well", shipped("double-well"), 5.0),
        ("units", shipped("units"), 4.0),
        // Walls so thin that a long window has no node in them.
        of_formula("thin wall", "0.2*tanh(40*(x - 1))", 1.0, [0.0, 1.0, 0.5], 4.0),
        of_formula("steep power", "0.1*x^20", 1.0, [0.0, 1.0, 0.5], 8.0),
    ];
    assert_kept(&cases, &[4, 5, 6, 7, 8, 9, 10, 11, 12, 13]);
}

#[test]
fn accuracies_are_kept_where_it_is_difficult() {
    let of_formula = |name, text, c, start, length| (name, one(text, c, start), length);
    let cases = [
        // Almost up to the unstable point of a pendulum, where errors grow exponentially; and almost at rest there.
        of_formula("separatrix", "0.1*(1 - cos(x))", 1.0, [0.1, 1.0, 0.59], 20.0),
        of_formula("barrier top", "0.1*(x^2 - 1)^2", 1.0, [1e-6, 1.0, 0.0], 30.0),
        of_formula("steep wall", "0.2*tanh(8*(x - 1))", 1.0, [0.0, 1.0, 0.5], 4.0),
        of_formula("cusp", "0.806348*sqrt(x^2 + 0.00231836^2)", 3.0, [-0.884378, 4.0, -0.02371412], 4.703152),
        of_formula("backwards in time", "x^4/2", 1.0, [1.0, -1.0, 0.1], 5.0),
        of_formula("small", "x^2/2", 1.0, [1e-9, 1.0, 0.0], 10.0),
        of_formula("short", "x^4/2", 1.0, [1.0, 1.0, 0.1], 1e-8),
        of_formula("no motion in time", "x^4/2", 1.0, [1.0, 0.0, 0.1], 10.0),
        of_formula("at rest", "x^4/2", 1.0, [0.0, 1.0, 0.0], 10.0),
        of_formula("far away", "0*x", 1.0, [1e6, 1.0, 0.3], 100.0),
        of_formula("at rest beside the origin", "(x - 1)^2/2", 1.0, [1.0, 1.0, 0.0], 10.0),
        of_formula("in slow motion", "x^2/2", 1.0, [1e-4, 1.0, 0.0], 100.0),
    ];
    assert_kept(&cases, &[4, 6, 8, 10, 12]);
}

#[test]
fn accuracies_are_kept_over_long_runs() {
    let cases = [("quartic", shipped("quartic"), 1000.0), ("pendulum", shipped("pendulum"), 100.0)];
    assert_kept(&cases, &[4, 5, 6, 7, 8, 9, 10]);
}

/// Rounding alone makes an error of about 1e-11 there.
#[test]
fn what_rounding_leaves_room_for_is_kept_over_a_thousand_units() {
    let (geometry, start) = shipped("quartic");
    let mut engine = Engine::equal(&geometry, &start, 1000.0, 4000, 20).unwrap();
    engine.run(|_| ControlFlow::Continue(())).unwrap();
    let (exact, found) = (engine.place().1, run(&geometry, &start, 1000.0, 2e-11).unwrap());
    let end = &found.nodes[found.nodes.len() - 1].1;
    let errors = [(end[0] / exact[0] - 1.0).abs(), (end[1] - exact[1]).abs()];
    assert_eq!(run(&geometry, &start, 1000.0, 3e-12).err(), Some(Failure::Rounding));
    assert!(found.estimate <= 2e-11 && errors.iter().all(|&error| error <= found.estimate + 2e-14), "{errors:?}");
}
