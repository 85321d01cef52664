//! Errors on their way, against windows that begin with them.

use super::{Local, Transport};
use crate::engine::lobatto::flow::tests::{NONE, geometries, judge, near, solved, start};

/// New errors point to where K goes on changing as it has, and those that do not change it to where they are.
#[test]
fn errors_do_not_cancel() {
    let geometry = &geometries()[0];
    let slopes = [0.5, -2.0, -0.25, 0.0, 0.0];
    let mut transport = Transport::new(geometry);
    let local = |row: usize| Local { size: 1e-9 * (row + 1) as f64, half_norm: slopes[row], rounding: 0.0 };
    let k = |transport: &Transport<'_>| (0..5).map(|row| slopes[row] * transport.of(row)).sum::<f64>();
    let added: f64 = (0..5).map(|row| local(row).size * slopes[row].abs()).sum();
    for windows in 1..10 {
        transport.enlarge(local);
        near(k(&transport), f64::from(windows) * added);
        (0..5).for_each(|row| near(transport.of(row).abs(), f64::from(windows) * local(row).size));
    }
    // With the gradient turned round K is on the other side, and errors shrink it no more.
    let before = k(&transport);
    transport.enlarge(|row| Local { half_norm: -slopes[row], ..local(row) });
    near(k(&transport), before + added);
}

/// Rounding adds up as in a random walk.
#[test]
fn rounding_walks_at_random() {
    let geometry = &geometries()[0];
    let mut transport = Transport::new(geometry);
    for windows in 1..100 {
        transport.enlarge(|_| Local { rounding: 1e-16, ..NONE });
        (0..5).for_each(|row| near(transport.of(row), 1e-16 * f64::from(windows).sqrt()));
    }
    // It adds to the other errors of a window.
    let mut transport = Transport::new(geometry);
    transport.enlarge(|_| Local { size: 3e-10, rounding: 1e-10, ..NONE });
    (0..5).for_each(|row| near(transport.of(row), 4e-10));
}

/// Small errors at the start of a window are at its end what a window from a start that is off says.
#[test]
fn errors_travel_with_the_motion() {
    for geometry in geometries() {
        let start = start(&geometry);
        let (state, window) = solved(&geometry, &start, 0.3);
        // Of x, y, their momenta and t.
        let errors = [1e-6, 2e-6, 3e-6, 1.5e-6, 2.5e-6];
        let (judge, mut transport) = judge(&geometry, (&state, &start), None);
        transport.enlarge(|row| Local { size: errors[row], ..NONE });
        transport.follow(&window, &judge.weights, 1e3);
        let mut off = start.clone();
        let [ex, ey, px, py, et] = errors;
        (off.q, off.p) =
            (vec![off.q[0] + et, off.q[1] + ex, off.q[2] + ey], vec![off.p[0], off.p[1] + px, off.p[2] + py]);
        let (_, other) = solved(&geometry, &off, 0.3);
        let q = |a: usize| other.end.q[a].hi - window.end.q[a].hi;
        let p = |place: usize| other.end.p[place].hi - window.end.p[place].hi;
        for (row, exact) in [q(1), q(2), p(0), p(1), q(0)].into_iter().enumerate() {
            assert!((transport.of(row) - exact).abs() < 1e-3 * 3e-6, "{row}: {:e}, {exact:e}", transport.of(row));
        }
    }
}
