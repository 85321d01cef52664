//! Nothing steep hides between the nodes of a run to an accuracy: barriers far narrower than windows are met, wherever
//! they are, and smooth scenes are solved in as many windows as without a look.

use std::convert::Infallible;
use std::ops::ControlFlow;

use super::super::adaptive::Adaptive;
use super::super::tests::{kerr, lifted, metric, schwarzschild};
use super::super::{Accuracy, Engine, Failure};
use super::changes_little;
use crate::formula::{Function, Kind, Watched};
use crate::geometry::{Geometry, Start};
use crate::number::runge_kutta::runge_kutta;

const ACCURACIES: [f64; 4] = [1e-4, 1e-6, 1e-8, 1e-10];

/// V = height exp(−(d/width)²), where d is the distance from a line, or from a point.
#[derive(Debug, Clone, Copy)]
struct Barrier {
    height: f64,
    width: f64,
    /// The normal of the line and its distance from the origin, or the point.
    normal: [f64; 2],
    offset: f64,
    is_point: bool,
}

impl Barrier {
    /// d²q/dγ² where g_tt = 9 + 2V and p_t = 9, and the distance, at a small step from a base.
    fn force(&self, base: [f64; 2], step: &[f64]) -> ([f64; 2], f64) {
        let [a, b] = self.normal;
        let [x, y] = if self.is_point {
            [base[0] - a + step[0], base[1] - b + step[1]]
        } else {
            let distance = (a * base[0] + b * base[1] - self.offset) + (a * step[0] + b * step[1]);
            [distance * a, distance * b]
        };
        let square = x * x + y * y;
        let value = self.height * (-square / (self.width * self.width)).exp();
        let u = 9.0 / (9.0 + 2.0 * value);
        let factor = 2.0 * u * u * value / (self.width * self.width);
        ([factor * x, factor * y], square.sqrt())
    }

    /// Where a particle is after `length`: free flight far from the barrier, and the classical Runge–Kutta method in
    /// steps of a thousandth of its width near it, in coordinates that begin there.
    fn truth(&self, mut q: [f64; 2], mut v: [f64; 2], length: f64) -> [f64; 2] {
        let mut rest = length;
        while rest > 1e-15 {
            let speed = v[0].hypot(v[1]);
            let distance = self.force(q, &[0.0; 2]).1;
            if distance > 9.0 * self.width {
                let h = ((distance - 8.0 * self.width) / speed).min(rest);
                (q, rest) = ([q[0] + h * v[0], q[1] + h * v[1]], rest - h);
                continue;
            }
            let mut state = [0.0, 0.0, v[0], v[1]];
            while rest > 1e-15 && self.force(q, &state).1 <= 9.5 * self.width {
                let h = (1e-3 * self.width / state[2].hypot(state[3]).max(1.0)).min(rest);
                let _ = runge_kutta(&mut state, h, |state, rates| {
                    let force = self.force(q, state).0;
                    rates.copy_from_slice(&[state[2], state[3], force[0], force[1]]);
                    Ok::<_, Infallible>(())
                });
                rest -= h;
            }
            (q, v) = ([q[0] + state[0], q[1] + state[1]], [state[2], state[3]]);
        }
        q
    }
}

/// Numbers that look random.
struct Random(u64);

impl Random {
    fn between(&mut self, least: f64, most: f64) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        least + (most - least) * (self.0 >> 11) as f64 / 2.0_f64.powi(53)
    }

    /// All sizes are equally frequent.
    fn scale(&mut self, least: f64, most: f64) -> f64 {
        self.between(least.ln(), most.ln()).exp()
    }
}

/// The motion where g_tt = 9 + 2V, from a place where V is `value`, with p_t = 9 + 2 `value`.
fn scene(formula: &str, [x, y]: [f64; 2], [v, w]: [f64; 2], value: f64) -> (Geometry, Start) {
    let g_tt = format!("9+2*({formula})");
    let components = [(0, 0, &*g_tt), (1, 1, "-1"), (2, 2, "-1")];
    metric(&["t", "x", "y"], &components, &[0.0, x, y], &[9.0 + 2.0 * value, -v, -w])
}

#[derive(Debug)]
struct Run {
    end: Vec<f64>,
    windows: usize,
    unresolved: usize,
}

fn run(mut engine: Engine<'_>) -> Result<Run, Failure> {
    let mut windows = 0;
    engine.run(|window| {
        windows = window.index + 1;
        ControlFlow::Continue(())
    })?;
    Ok(Run { end: engine.place().1, windows, unresolved: engine.unresolved() })
}

fn promised((geometry, start): &(Geometry, Start), length: f64, accuracy: f64) -> Result<Run, Failure> {
    run(Engine::accurate(geometry, start, length, Accuracy::Promised(accuracy)).unwrap())
}

/// High ones and low ones, across the way of one active coordinate and of two, there straight ones and round ones. The
/// run past a barrier ends where it should, or rounding refuses it: rounding of places, relative to the width, moves
/// the end by as much.
#[test]
fn barriers_at_random_places_are_met() {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let mut count = 0;
    for number in 0..180 {
        let (is_one, is_point) = (number % 3 == 0, number % 3 == 2);
        let (width, accuracy) = (random.scale(if is_one { 1e-6 } else { 1e-5 }, 0.05), ACCURACIES[number / 3 % 4]);
        let is_high = number / 12 % 2 == 0;
        let height = if is_high { random.between(-3.0, 5.0) } else { random.scale(1e-7, 1.0) };
        let (angle, tilt) = (random.between(-0.7, 0.7), random.between(-0.8, 0.8));
        let (speed, way, beside) = (random.between(0.3, 0.9), random.between(0.5, 6.0), random.between(-1.0, 1.0));
        let [direction, across] = [angle, tilt].map(|at| if is_one { [1.0, 0.0] } else { [at.cos(), at.sin()] });
        let (q, v) = ([-0.6, if is_one { 0.0 } else { 0.3 }], direction.map(|part| speed * part));
        let there = [q[0] + way * direction[0], q[1] + way * direction[1]];
        // Off the way by up to the width.
        let off = beside * width;
        let point = [there[0] - off * direction[1], there[1] + off * direction[0]];
        let (normal, offset) =
            if is_point { (point, 0.0) } else { (across, across[0] * there[0] + across[1] * there[1]) };
        let [a, b] = normal;
        let square = match (is_one, is_point) {
            (true, _) => format!("(x-({offset:?}))^2"),
            (_, false) => format!("({a:?}*x+({b:?})*y-({offset:?}))^2"),
            (_, true) => format!("(x-({a:?}))^2+(y-({b:?}))^2"),
        };
        let barrier = Barrier { height, width, normal, offset, is_point };
        let scene = scene(&format!("{height:?}*exp(-({square})/{width:?}^2)"), q, v, 0.0);
        match promised(&scene, 16.0, accuracy) {
            Ok(Run { end, unresolved, .. }) => {
                let truth = barrier.truth(q, v, 16.0);
                let off = end[1..].iter().zip(truth).map(|(found, truth)| (found - truth).abs() / truth.abs().max(1.0));
                let off = off.fold(0.0, f64::max);
                assert!(off <= accuracy + 1e-11 + 1e-14 / width, "{number} {barrier:?} {v:?} {accuracy:e}: {off:e}");
                assert_eq!(unresolved, 0, "{number} {barrier:?}");
                count += 1;
            }
            Err(failure) => assert_eq!(failure, Failure::Accuracy, "{number} {barrier:?} {accuracy:e}"),
        }
    }
    assert!(count > 135, "{count}");
}

/// What cannot be proved, as at a pole of the force, is said or ends the run.
#[test]
fn poles_are_not_certain() {
    let scenes = [
        scene("sqrt(abs(x))", [1.0, 0.0], [0.0; 2], 1.0),
        scene("abs(x)^0.3", [1.0, 0.0], [0.0; 2], 1.0),
        scene("abs(x)^0.9", [1.0, 0.0], [-0.4, 0.0], 1.0),
        scene("abs(x)^0.9 + y^2/2", [1.0, 0.5], [-0.4, 0.0], 1.125),
    ];
    for (number, scene) in scenes.iter().enumerate() {
        for accuracy in [1e-4, 1e-6, 1e-8] {
            if let Ok(run) = promised(scene, 4.0, accuracy) {
                assert!((1..=run.windows).contains(&run.unresolved), "{number} {accuracy:e}: {run:?}");
            }
        }
    }
}

/// The number of windows of a run, with a look between the nodes and without one.
fn windows((geometry, start): &(Geometry, Start), length: f64, accuracy: f64) -> [usize; 2] {
    [true, false].map(|looks| {
        let mut windows = Adaptive::new(geometry, start, (length, None), Accuracy::Local(accuracy)).unwrap();
        assert!(windows.between.is_some(), "something could hide");
        if !looks {
            windows.between = None;
        }
        let run = run(Engine(Box::new(windows))).unwrap();
        assert_eq!(run.unresolved, 0);
        run.windows
    })
}

#[test]
fn smooth_scenes_keep_their_windows() {
    let bodies = ["x", "y", "u", "v", "w", "z"];
    let pairs = ["(x-u)^2+(y-v)^2", "(x-w)^2+(y-z)^2", "(u-w)^2+(v-z)^2"].map(|square| format!("-1/sqrt({square})"));
    let eight = [0.970_004_36, -0.243_087_53, -0.970_004_36, 0.243_087_53, 0.0, 0.0];
    let [v, w] = [0.466_203_685, 0.432_365_73];
    let double_pendulum =
        [(0, 0, "2*(-2*cos(a)-cos(b))"), (0, 3, "1"), (1, 1, "-2"), (1, 2, "-cos(a-b)"), (2, 2, "-1")];
    let energy = 2.0 * (-2.0 * f64::cos(1.5) - f64::cos(1.0));
    let scenes = [
        ("pendulum", lifted("-cos(x)", &["x"], &[2.0], &[0.1]), 100.0),
        ("morse", lifted("(1-exp(-x))^2", &["x"], &[1.0], &[0.2]), 100.0),
        ("schwarzschild", schwarzschild(), 2000.0),
        ("kerr", kerr(), 400.0),
        ("kepler", lifted("-1/sqrt(x^2+y^2)", &["x", "y"], &[0.1, 0.0], &[0.0, f64::sqrt(19.0)]), 20.0),
        ("three bodies", lifted(&pairs.concat(), &bodies, &eight, &[v, w, v, w, -2.0 * v, -2.0 * w]), 6.3),
        (
            "double pendulum",
            metric(&["t", "a", "b", "s"], &double_pendulum, &[0.0, 1.5, 1.0, 0.0], &[energy, 0.0, 0.0, 1.0]),
            20.0,
        ),
    ];
    for (name, scene, length) in &scenes {
        for accuracy in ACCURACIES {
            let [looking, plain] = windows(scene, *length, accuracy);
            assert!(looking <= plain + plain / 10, "{name} {accuracy:e}: {looking} {plain}");
        }
    }
}

#[test]
fn what_changes_between_two_nodes_is_looked_at() {
    let values = |at: &dyn Fn(f64) -> f64| -> [f64; 8] { std::array::from_fn(|k| at(k as f64)) };
    let nodes = values(&|k| k);
    let changes_little = |kind, values: &[f64; 8]| changes_little(&Watched::new(0, kind, 1.0), &nodes, values);
    assert!(changes_little(Kind::Step, &values(&|k| k)));
    assert!(!changes_little(Kind::Step, &values(&|k| 1.2 * k)));
    // The parabola comes to 0 in the middle between two nodes.
    assert!(!changes_little(Kind::Side(Function::Sign), &values(&|k| (k - 3.5).powi(2))));
    assert!(!changes_little(Kind::Ratio, &values(&|k| (k - 3.5).powi(2))));
    assert!(changes_little(Kind::Ratio, &values(&|k| 1.0 + (k - 3.5).powi(2))));
    assert!(!changes_little(Kind::Ratio, &values(&|k| if k == 4.0 { f64::NAN } else { 1.0 })));
    // What is linear is nowhere larger than on the nodes, also where it comes to 0; the parabola is.
    assert!(changes_little(Kind::Base, &values(&|k| k - 3.5)));
    assert!(!changes_little(Kind::Base, &values(&|k| 1.1 * 2.25 / 8.0 - (k - 3.5).powi(2))));
}
