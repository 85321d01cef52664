//! Nothing steep hides between the nodes of a run to an accuracy: barriers far narrower than windows are met, wherever
//! they are, and smooth scenes are solved in as many windows as without a look.

use std::ops::ControlFlow;

use super::super::adaptive::Adaptive;
use super::super::tests::{kerr, lifted, metric, schwarzschild};
use super::super::{Accuracy, Engine, Failure};
use super::changes_little;
use crate::formula::Kind;
use crate::geometry::{Geometry, Start};

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
    /// The vector to a place from the nearest point of the barrier, for a small step from there.
    fn away(&self, base: [f64; 2], step: [f64; 2]) -> [f64; 2] {
        let [a, b] = self.normal;
        if self.is_point {
            return [base[0] - a + step[0], base[1] - b + step[1]];
        }
        let distance = (a * base[0] + b * base[1] - self.offset) + (a * step[0] + b * step[1]);
        [distance * a, distance * b]
    }

    /// d²q/dγ² where g_tt = 9 + 2V and p_t = 9, and the distance.
    fn force(&self, [x, y]: [f64; 2]) -> ([f64; 2], f64) {
        let square = x * x + y * y;
        let value = self.height * (-square / (self.width * self.width)).exp();
        let u = 9.0 / (9.0 + 2.0 * value);
        let factor = 2.0 * u * u * value / (self.width * self.width);
        ([factor * x, factor * y], square.sqrt())
    }

    /// Where a particle is after `length`: free flight far from the barrier, and the classical Runge–Kutta method in
    /// steps of a thousandth of its width near it, in coordinates that begin there.
    fn truth(&self, mut q: [f64; 2], mut v: [f64; 2], length: f64) -> [f64; 2] {
        let mut gamma = 0.0;
        while length - gamma > 1e-15 {
            let distance = self.force(self.away(q, [0.0; 2])).1;
            if distance > 9.0 * self.width {
                let h = ((distance - 8.0 * self.width) / v[0].hypot(v[1])).min(length - gamma);
                (q, gamma) = ([q[0] + h * v[0], q[1] + h * v[1]], gamma + h);
                continue;
            }
            let (mut step, mut done) = ([0.0; 2], 0.0);
            loop {
                let h = (1e-3 * self.width / v[0].hypot(v[1]).max(1.0)).min(length - gamma - done);
                let state = [step[0], step[1], v[0], v[1]];
                let next = runge_kutta(state, h, |[x, y, vx, vy]| {
                    let [ax, ay] = self.force(self.away(q, [x, y])).0;
                    [vx, vy, ax, ay]
                });
                (step, v, done) = ([next[0], next[1]], [next[2], next[3]], done + h);
                let is_out = self.force(self.away(q, step)).1 > 9.5 * self.width;
                if is_out || length - gamma - done <= 1e-15 {
                    break;
                }
            }
            (q, gamma) = ([q[0] + step[0], q[1] + step[1]], gamma + done);
        }
        q
    }
}

/// A step of the classical method.
fn runge_kutta<const M: usize>(x: [f64; M], h: f64, slope: impl Fn([f64; M]) -> [f64; M]) -> [f64; M] {
    let on = |k: [f64; M], h: f64| std::array::from_fn(|i| x[i] + h * k[i]);
    let first = slope(x);
    let second = slope(on(first, 0.5 * h));
    let third = slope(on(second, 0.5 * h));
    let fourth = slope(on(third, h));
    on(std::array::from_fn(|i| (first[i] + 2.0 * (second[i] + third[i]) + fourth[i]) / 6.0), h)
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
fn scene<const D: usize>(formula: &str, q: [f64; D], v: [f64; D], value: f64) -> (Geometry, Start) {
    let g_tt = format!("9+2*({formula})");
    let components = [(0, 0, &*g_tt), (1, 1, "-1"), (2, 2, "-1")];
    let p = [&[9.0 + 2.0 * value], &v.map(|v| -v)[..]].concat();
    metric(&["t", "x", "y"][..=D], &components[..=D], &[&[0.0], &q[..]].concat(), &p)
}

#[derive(Debug)]
struct Run {
    end: Vec<f64>,
    windows: usize,
    unproved: usize,
}

fn run(mut engine: Engine<'_>) -> Result<Run, Failure> {
    let mut windows = 0;
    engine.run(|window| {
        windows = window.index + 1;
        ControlFlow::Continue(())
    })?;
    Ok(Run { end: engine.place().1, windows, unproved: engine.unproved() })
}

/// A run over a length to an accuracy, in windows of so many nodes.
type Setting = (f64, f64, usize);

fn promised((geometry, start): &(Geometry, Start), (length, accuracy, points): Setting) -> Result<Run, Failure> {
    run(Engine::accurate(geometry, start, length, Accuracy::Promised(accuracy), points).unwrap())
}

/// The run past a barrier of this width ends where it should, or rounding refuses it: rounding of places, relative to
/// the width, moves the end by as much. Returns the number of windows in which something may hide.
fn met(scene: &(Geometry, Start), setting: Setting, truth: &[f64], width: f64, what: &str) -> Option<usize> {
    match promised(scene, setting) {
        Ok(Run { end, unproved, .. }) => {
            let off = end[1..].iter().zip(truth).map(|(found, truth)| (found - truth).abs() / truth.abs().max(1.0));
            let off = off.fold(0.0, f64::max);
            assert!(off <= setting.1 + 1e-11 + 1e-14 / width, "{what} {setting:?}: {off:e}");
            Some(unproved)
        }
        Err(failure) => {
            assert_eq!(failure, Failure::Rounding, "{what} {setting:?}");
            None
        }
    }
}

#[test]
fn barriers_at_random_places_are_met() {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let mut count = 0;
    for number in 0..120 {
        let (width, accuracy, points) = (random.scale(1e-6, 0.05), ACCURACIES[number % 4], [8, 16][number / 4 % 2]);
        let (height, offset) = (random.between(-3.0, 5.0), random.between(0.0, 6.0));
        let barrier = Barrier { height, width, normal: [1.0, 0.0], offset, is_point: false };
        let x_dot = random.between(0.3, 0.9);
        let [truth, _] = barrier.truth([-0.6, 0.0], [x_dot, 0.0], 16.0);
        let scene = scene(&format!("{height:?}*exp(-((x-{offset:?})/{width:?})^2)"), [-0.6], [x_dot], 0.0);
        let what = format!("{number} {barrier:?} {x_dot}");
        let met = met(&scene, (16.0, accuracy, points), &[truth], width, &what);
        assert!(met.is_none_or(|unproved| unproved == 0), "{what}");
        count += usize::from(met.is_some());
    }
    assert!(count > 90, "{count}");
}

#[test]
fn ridges_and_bumps_of_scenes_are_met() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut count = 0;
    for number in 0..60 {
        let (width, accuracy, points) = (random.scale(1e-5, 0.05), ACCURACIES[number / 2 % 4], [8, 16][number / 8 % 2]);
        let (height, angle) = (random.between(-3.0, 5.0), random.between(-0.7, 0.7));
        let (v, q) = ([0.6 * angle.cos(), 0.6 * angle.sin()], [-0.6, random.between(-0.5, 0.5)]);
        let way = random.between(0.5, 6.0);
        let there = [q[0] + way * v[0], q[1] + way * v[1]];
        let is_point = number % 2 == 0;
        let (normal, offset) = if is_point {
            // Off the way by up to the width.
            let beside = random.between(-1.0, 1.0) * width / 0.6;
            ([there[0] - beside * v[1], there[1] + beside * v[0]], 0.0)
        } else {
            let tilt = random.between(-0.8, 0.8);
            ([tilt.cos(), tilt.sin()], tilt.cos() * there[0] + tilt.sin() * there[1])
        };
        let barrier = Barrier { height, width, normal, offset, is_point };
        let [a, b] = normal;
        let square = match is_point {
            true => format!("(x-({a:?}))^2+(y-({b:?}))^2"),
            false => format!("({a:?}*x+({b:?})*y-({offset:?}))^2"),
        };
        let scene = scene(&format!("{height:?}*exp(-({square})/{width:?}^2)"), q, v, 0.0);
        let (truth, what) = (barrier.truth(q, v, 16.0), format!("{number} {barrier:?}"));
        let met = met(&scene, (16.0, accuracy, points), &truth, width, &what);
        assert!(met.is_none_or(|unproved| unproved == 0), "{what}");
        count += usize::from(met.is_some());
    }
    assert!(count > 45, "{count}");
}

/// Small ones in a field that changes everywhere. The truth is by the classical Runge–Kutta method, in steps that
/// follow the distance.
#[test]
fn small_bumps_in_a_field_are_met() {
    let mut random = Random(0x1234_5678_9abc_def1);
    let mut count = 0;
    for number in 0..48 {
        let (w, accuracy, points) = (random.scale(1e-5, 0.05), ACCURACIES[number % 4], [8, 16][number / 4 % 2]);
        let (height, place) = (random.scale(1e-7, 1.0), random.between(-0.9, 0.9));
        let formula = format!("0.3*x^2+0.05*x^4+{height:?}*exp(-((x-({place:?}))/{w:?})^2)");
        let value = |x: f64| 0.3 * x * x + 0.05 * x.powi(4) + height * (-((x - place) / w).powi(2)).exp();
        let scene = scene(&formula, [1.0], [0.1], value(1.0));
        let slope = |[x, v]: [f64; 2]| {
            let bump = height * (-((x - place) / w).powi(2)).exp();
            let slope = 0.6 * x + 0.2 * x.powi(3) - 2.0 * (x - place) / (w * w) * bump;
            [v, -slope * ((9.0 + 2.0 * value(1.0)) / (9.0 + 2.0 * value(x))).powi(2)]
        };
        let (mut state, mut gamma, length) = ([1.0, 0.1], 0.0, 6.0);
        while length - gamma > 1e-15 {
            let distance = f64::abs(state[0] - place);
            let near = w / 250.0;
            let h = near.max((distance - 7.5 * w) / 250.0).min(2e-4_f64).min(length - gamma);
            (state, gamma) = (runge_kutta(state, h, slope), gamma + h);
        }
        let met = met(&scene, (length, accuracy, points), &state[..1], w, &format!("{number} {formula}"));
        count += usize::from(met.is_some());
    }
    assert!(count > 36, "{count}");
}

/// V = |x|: two parabolas, of which every window has one or sees both.
#[test]
fn kinks_are_passed() {
    let step = |side: f64, state: [f64; 2], h: f64| {
        runge_kutta(state, h, |[x, v]| [v, -side * (11.0 / (9.0 + 2.0 * side * x)).powi(2)])
    };
    // On one side at a time; the step that crosses is cut to end at the kink.
    let (mut state, mut side, mut gamma, length) = ([1.0, 0.0], 1.0, 0.0, 8.0);
    while length - gamma > 1e-14 {
        let mut h = f64::min(1e-3, length - gamma);
        if side * step(side, state, h)[0] < 0.0 {
            let mut inside = 0.0;
            for _ in 0..60 {
                let middle = 0.5 * (inside + h);
                *(if side * step(side, state, middle)[0] < 0.0 { &mut h } else { &mut inside }) = middle;
            }
            (state, side) = (step(side, state, h), -side);
        } else {
            state = step(side, state, h);
        }
        gamma += h;
    }
    let scene = scene("abs(x)", [1.0], [0.0], 1.0);
    for (accuracy, points) in [(1e-5, 8), (1e-5, 16), (1e-7, 8), (1e-7, 16)] {
        let Run { end, unproved, .. } = promised(&scene, (length, accuracy, points)).unwrap();
        assert!((end[1] - state[0]).abs() < accuracy + 1e-10, "{accuracy:e} {points}: {end:?}, {state:?}");
        assert_eq!(unproved, 0);
    }
}

/// What cannot be proved, as at a pole of the force, is said or ends the run.
#[test]
fn poles_are_not_certain() {
    let scenes = [
        scene("sqrt(abs(x))", [1.0], [0.0], 1.0),
        scene("abs(x)^0.3", [1.0], [0.0], 1.0),
        scene("abs(x)^0.9", [1.0], [-0.4], 1.0),
        scene("abs(x)^0.9 + y^2/2", [1.0, 0.5], [-0.4, 0.0], 1.125),
    ];
    for (number, scene) in scenes.iter().enumerate() {
        for (accuracy, points) in [(1e-4, 8), (1e-4, 16), (1e-6, 8), (1e-6, 16), (1e-8, 8), (1e-8, 16)] {
            if let Ok(run) = promised(scene, (4.0, accuracy, points)) {
                assert!((1..=run.windows).contains(&run.unproved), "{number} {accuracy:e} {points}: {run:?}");
            }
        }
    }
}

/// The number of windows of a run, with a look between the nodes and without one.
fn windows<const N: usize>((geometry, start): &(Geometry, Start), length: f64, accuracy: f64) -> [usize; 2] {
    [true, false].map(|looks| {
        let wanted = Accuracy::Promised(accuracy);
        let mut windows = Adaptive::<N>::new(geometry, start, (length, None), wanted).unwrap();
        assert!(windows.between.is_some(), "something could hide");
        if !looks {
            windows.between = None;
        }
        let run = run(Engine(Box::new(windows))).unwrap();
        assert_eq!(run.unproved, 0);
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
            let both = [windows::<8>(scene, *length, accuracy), windows::<16>(scene, *length, accuracy)];
            for [looking, plain] in both {
                assert!(looking <= plain + plain / 10, "{name} {accuracy:e}: {both:?}");
            }
        }
    }
}

#[test]
fn what_changes_between_two_nodes_is_looked_at() {
    let values = |at: &dyn Fn(f64) -> f64| -> [f64; 8] { std::array::from_fn(|k| at(k as f64)) };
    assert!(changes_little(Kind::Step, &values(&|k| k)));
    assert!(!changes_little(Kind::Step, &values(&|k| 1.2 * k)));
    // The parabola comes to 0 in the middle between two nodes.
    assert!(!changes_little(Kind::Sign, &values(&|k| (k - 3.5).powi(2))));
    assert!(!changes_little(Kind::Ratio, &values(&|k| (k - 3.5).powi(2))));
    assert!(changes_little(Kind::Ratio, &values(&|k| 1.0 + (k - 3.5).powi(2))));
    assert!(!changes_little(Kind::Ratio, &values(&|k| if k == 4.0 { f64::NAN } else { 1.0 })));
}
