//! What a march knows of its error, against what errors are.

use super::{CALIBRATION, CAUTION, Joint, Judge, K_ROUNDS, PHASE, ROUNDING, Rounding, is_rough};
use crate::engine::lobatto::State;
use crate::engine::lobatto::window::Solved;
use crate::geometry::metric::Metric;
use crate::geometry::potential::Potential;

fn near(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-9 * a.abs().max(b.abs()), "{a:e}, {b:e}");
}

fn state([t, x, w]: [f64; 3]) -> State {
    State { t: t.into(), x: x.into(), w: w.into() }
}

/// A window that ends there, with these highest modes of a and u, both of which are at most 1.
fn solved(end: [f64; 3], tail: [f64; 2], rate: f64) -> Solved {
    Solved { end: state(end), evaluations: 1, u: [rate; 2], tail, largest: [1.0; 2] }
}

/// A free particle with dt/dγ = 1.
fn free() -> Metric {
    Metric::new(Potential::free(), 1.0, 1.0)
}

/// The judge after some windows of length 1 of a free particle with that velocity, from t and x on.
fn after(metric: &Metric, windows: usize, [t, x, w]: [f64; 3], tail: [f64; 2]) -> Judge<'_> {
    let mut judge = Judge::new(metric, 1.0, 16, &state([t, x, w]), 1.0);
    for k in 1..=windows {
        let gamma = k as f64;
        let solved = solved([t + gamma, x + gamma * w, w], tail, 1.0);
        let here = judge.joint(&solved.end);
        judge.see(&solved, here, 1.0, 1.0, 0.0);
    }
    judge
}

#[test]
fn rounding_errors_add_up_as_in_a_random_walk() {
    let (mut rounding, mut roots) = (Rounding::default(), 0.0);
    for windows in 1..=100 {
        rounding.add(1e-16, 2.0, [3.0, 5.0], 0.7);
        // An error of x by 1e-16 is a shift of 1e-16/5, and an energy of 1e-16·5/2, which shears from then on.
        roots += f64::from(windows).sqrt();
        near(rounding.shift(), 1e-16 / 5.0 * f64::from(windows).sqrt() + 1e-16 * 2.5 * 0.7 / 15.0 * roots);
    }
}

#[test]
fn local_errors_add_up() {
    let metric = free();
    let tail = 1e-5;
    let [once, none] = [[tail, 0.0], [0.0; 2]].map(|tail| after(&metric, 1, [0.0, 0.0, 0.5], tail).errors()[1]);
    assert_eq!(none, 0.0);
    near(once, CAUTION * CALIBRATION * tail * tail);
    for windows in [2, 10] {
        let judge = after(&metric, windows, [0.0, 0.0, 0.5], [tail, tail]);
        let (sizes, local) = (judge.sizes, windows as f64 * once);
        assert_eq!(sizes, [windows as f64, (0.5 * windows as f64).max(1.0)]);
        let [t, x] = judge.errors();
        near(t * sizes[0], local);
        near(x * sizes[1], local);
    }
}

/// Where a time is given, an error of t moves the end by dx/dt as much.
#[test]
fn an_error_of_the_time_is_one_of_the_place() {
    let metric = free();
    let judge = after(&metric, 3, [0.0, -24.0, 16.0], [0.0, 1e-3]);
    let [t, x] = judge.errors();
    assert!(t > 0.0 && x == 0.0);
    near(judge.at_time() - judge.beyond(0.0), 16.0 * (t * 3.0) / 24.0);
}

#[test]
fn the_origin_of_time_changes_nothing() {
    let metric = free();
    let tail = [1e-4, 1e-3];
    let [here, later] = [0.0, 4096.0].map(|t| after(&metric, 5, [t, 0.25, 0.5], tail));
    assert_eq!(here.so_far(), later.so_far());
    assert_eq!(here.at_time(), later.at_time());
    let window = |t: f64| solved([t + 7.0, 3.0, 0.5], tail, 1.0);
    assert_eq!(here.inside(&window(0.0)), later.inside(&window(4096.0)));
}

/// The error of x inside a window is in units of n⁻², and both are relative to the sizes.
#[test]
fn errors_inside_a_window_end_with_it() {
    let metric = free();
    let start = state([0.0, 0.0, 0.5]);
    let inside = |points: usize, end: [f64; 3], tail: [f64; 2]| {
        Judge::new(&metric, 1.0, points, &start, 1.0).inside(&solved(end, tail, 1.0))
    };
    let end = [1.0, 0.5, 0.5];
    near(inside(16, end, [1e-6, 0.0]), 4.0 * inside(32, end, [1e-6, 0.0]));
    near(inside(16, end, [0.0, 1e-6]), inside(32, end, [0.0, 1e-6]));
    near(inside(16, end, [1e-6, 0.0]), 8.0 * inside(16, [1.0, 8.0, 0.5], [1e-6, 0.0]));
    near(inside(16, end, [0.0, 1e-6]), 8.0 * inside(16, [8.0, 0.5, 0.5], [0.0, 1e-6]));
    assert!(inside(16, end, [1e-6, 0.0]) < 1e-7 && inside(16, end, [0.0, 1e-6]) < 1e-6);
    let large = Solved { largest: [100.0; 2], ..solved(end, [0.5; 2], 1.0) };
    assert!(!is_rough(&large) && !is_rough(&solved(end, [1e-6; 2], 1.0)) && is_rough(&solved(end, [0.5, 0.0], 1.0)));
}

/// What a change of the velocity by δ does in a window of length h is an error of δ h, and K = Q_t²/g00 − w² tells.
#[test]
fn a_change_of_k_is_an_error_of_the_velocity() {
    let metric = free();
    for (w, h, delta) in [(3.0, 2.0, 1e-6), (0.5, 4.0, -1e-7)] {
        let start = state([0.0, 0.0, w]);
        let judge = Judge::new(&metric, 1.0, 16, &start, 1.0);
        let solved = Solved { largest: [0.0, 1.0], ..solved([h, w * h, w + delta], [0.0; 2], h) };
        let error = judge.of_window(&solved, judge.joint(&solved.end), &start, h, 1.0);
        assert!((error / (delta.abs() * h) - 1.0).abs() < 1e-5, "{error:e}");
        // It goes on for as long as the motion takes.
        let error = judge.of_window(&solved, judge.joint(&solved.end), &start, h, 10.0 * h);
        assert!((error / (delta.abs() * 10.0 * h) - 1.0).abs() < 1e-5, "{error:e}");
    }
    // At rest the velocity shortly afterwards counts.
    let start = state([0.0; 3]);
    let judge = Judge::new(&metric, 1.0, 16, &start, 1.0);
    let window = Solved { largest: [0.5, 1.0], ..solved([0.25, 0.0, 1e-2], [0.0; 2], 0.25) };
    let error = judge.of_window(&window, judge.joint(&window.end), &start, 0.25, 1.0);
    near(error, 0.5 * 1e-4 / (0.5 / 0.0625));
}

/// A velocity that is off by δ since the middle of a window takes x along by δ in a unit of γ; and x is off at once by
/// what δ does in the time scale.
#[test]
fn a_velocity_that_is_off_goes_on() {
    let metric = free();
    let (w, delta, time) = (2.0, 1e-6, 0.5);
    let mut judge = Judge::new(&metric, 1.0, 16, &state([0.0, 0.0, w]), time);
    for windows in 1..6 {
        let gamma = f64::from(windows);
        let solved = Solved { largest: [0.0; 2], ..solved([gamma, 0.0, w + delta], [0.0; 2], 1.0) };
        let here = judge.joint(&solved.end);
        judge.see(&solved, here, 1.0, 1.0, 0.0);
        let x = judge.errors()[1] * judge.sizes[1];
        let expected = PHASE * (gamma - 0.5) * delta + time * delta;
        assert!((x / expected - 1.0).abs() < 1e-5, "{windows}: {x:e}, {expected:e}");
    }
}

#[test]
fn errors_of_short_windows_last_and_rounding_adds_to_them() {
    let metric = free();
    let error = |tail: f64, scale: f64, rounds: f64| {
        let mut judge = Judge::new(&metric, 1.0, 16, &state([0.0, 0.0, 0.5]), 1.0);
        let solved = solved([1.0, 0.5, 0.5], [tail, 0.0], 1.0);
        let here = judge.joint(&solved.end);
        judge.see(&solved, here, 1.0, scale, rounds);
        near(judge.so_far(), judge.errors()[1] + judge.inside(&solved) + ROUNDING);
        judge.errors()[1]
    };
    near(error(1e-4, 4.0, 0.0), 4.0 * error(1e-4, 1.0, 0.0));
    near(error(1e-4, 0.25, 0.0), error(1e-4, 1.0, 0.0));
    near(error(1e-4, 1.0, 1e-10), error(1e-4, 1.0, 0.0) + error(0.0, 1.0, 1e-10));
}

/// A shift moves x by dx/dγ, also where that is about to change.
#[test]
fn a_shift_moves_x_by_its_velocity() {
    // At x = 0 the acceleration is a quarter.
    let metric = Metric::new(Potential::linear(0.25), 1.0, 1.0);
    let (tail, push, length, time) = (1e-4, 0.25, 2.0, 0.5);
    for w in [0.0, 3.0_f64] {
        let mut judge = Judge::new(&metric, 1.0, 16, &state([0.0, 0.0, w]), time);
        let solved = solved([length, 0.0, w], [tail, 0.0], length);
        let here = judge.joint(&solved.end);
        judge.see(&solved, here, length, length, 0.0);
        let shift = CAUTION * CALIBRATION * tail * tail / w.hypot(push * time);
        near(judge.errors()[1], (w + push * length) * shift);
    }
}

#[test]
fn a_velocity_is_one_by_time() {
    let metric = free();
    // With Q_t = 2 time passes twice as fast as γ.
    let mut judge = Judge::new(&metric, 2.0, 16, &state([0.0, -24.0, 16.0]), 1.0);
    let solved = solved([6.0, 24.0, 16.0], [0.0, 1e-3], 6.0);
    let here = judge.joint(&solved.end);
    judge.see(&solved, here, 3.0, 3.0, 0.0);
    near(judge.at_time() - judge.beyond(0.0), 8.0 * (judge.errors()[0] * 6.0) / 24.0);
}

/// K = Q_t²/g00 − w² is rounded as its terms are, and g00 = c² + 2V/m as its own: with V = x/2, at x = −4, that is
/// 100 − 4.
#[test]
fn k_is_off_by_more_than_rounding_or_not_at_all() {
    let metric = Metric::new(Potential::linear(0.5), 1.0, 10.0);
    let judge = Judge::new(&metric, 7.0, 16, &state([0.0, -4.0, 3.0]), 1.0);
    let u = 7.0 / 96.0;
    near(judge.first.rounds, K_ROUNDS * (u * u * (100.0 + 4.0 + 4.0) + 9.0));
    let joint = |k: f64, rounds: f64| Joint { k, rounds, ..Joint::default() };
    for sign in [1.0, -1.0] {
        assert_eq!(joint(sign * 8.0, 2.0).off(joint(0.0, 1.0)), sign * 5.0);
        assert_eq!(joint(0.0, 2.0).off(joint(sign * 8.0, 1.0)), -sign * 5.0);
        assert_eq!(joint(sign * 8.0, 5.0).off(joint(0.0, 4.0)), 0.0);
    }
}
