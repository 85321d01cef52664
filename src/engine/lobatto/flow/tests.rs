//! What is known of a window that was solved, against the geometry itself.

use super::judge::{BY_NORM, CAUTION, Judge, ROUNDED_NODES, ROUNDING};
use super::rule;
use super::state::FlowState;
use super::transport::{Local, Transport};
use super::window::{FlowWindow, Outcome, Task, Weights};
use super::work::Tail;
use crate::geometry::{Geometry, GeometryText, MetricText, Start};
use crate::number::runge_kutta::runge_kutta;

pub(super) const NONE: Local = Local { size: 0.0, half_norm: 0.0, rounding: 0.0 };

pub(super) fn near(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-9 * a.abs().max(b.abs()), "{a:e}, {b:e}");
}

/// Two oscillators that are coupled, with t, and with some other components in place of −1.
pub(super) fn geometry(others: &[([usize; 2], &str)], force: &[(usize, &str)]) -> Geometry {
    let components = [([0, 0], "2 + x^2 + 3*y^2 + x*y")].iter().chain(others);
    let text = MetricText {
        coordinates: ["t", "x", "y"].map(str::to_owned).to_vec(),
        components: components.map(|&(pair, text)| (pair, text.to_owned())).collect(),
        force: force.iter().map(|&(a, text)| (a, text.to_owned())).collect(),
        ..MetricText::default()
    };
    Geometry::new(&GeometryText::Metric(text)).unwrap().around(&[0.0, 0.5, -0.3]).unwrap()
}

/// One with a constant kinetic part, and one without.
pub(super) fn geometries() -> [Geometry; 2] {
    let uneven = [([1, 1], "-1 - y^2/4"), ([2, 2], "-1 - x^2/3"), ([1, 2], "x*y/5")];
    [geometry(&[([1, 1], "-1"), ([2, 2], "-2")], &[]), geometry(&uneven, &[])]
}

pub(super) fn start(geometry: &Geometry) -> Start {
    let (q, q_dot) = (vec![0.25, 0.5, -0.3], vec![1.25, 0.2, 0.7]);
    let p = geometry.momenta(&q, &q_dot);
    Start { q, q_dot, p }
}

/// The window of that length, to rounding.
pub(super) fn solved<'g>(geometry: &'g Geometry, start: &Start, h: f64) -> (FlowState, FlowWindow<'g, 16>) {
    let mut window = FlowWindow::new(geometry, rule::coarse());
    window.begin(&start.p);
    let state = FlowState::new(start, geometry.active());
    let weights = Weights { q: vec![1.0; 3], p: vec![1.0; geometry.active().len()] };
    let task = Task { start: &state, h, weights: &weights, tolerance: 1e-16, is_new: false };
    assert!(matches!(window.solve(task, &|_, _| false), Outcome::Solved(_)));
    (state, window)
}

/// All q^a and p_a at the end of a window.
fn end(window: &FlowWindow<'_, 16>, start: &Start) -> (Vec<f64>, Vec<f64>) {
    let mut p = start.p.clone();
    for (place, &a) in window.geometry.active().iter().enumerate() {
        p[a] = window.end.p[place].hi;
    }
    (window.end.q.iter().map(|q| q.hi).collect(), p)
}

#[test]
fn rates_are_those_of_the_field() {
    for geometry in geometries() {
        let start = start(&geometry);
        let (state, window) = solved(&geometry, &start, 0.3);
        let (q, p) = end(&window, &start);
        let mut point = geometry.point();
        point.evaluate(&q, &p).unwrap();
        for (place, &a) in geometry.active().iter().enumerate() {
            let [velocity, force] = window.rates_at_end(place);
            near(velocity, point.q_dot(a));
            near(force, point.p_dot(place));
        }
        (0..3).for_each(|a| near(window.velocity_at_end(a), point.q_dot(a)));
        near(window.norm_terms(), (0..3).map(|a| (p[a] * point.q_dot(a)).abs()).sum());
        near(window.norm, geometry.norm(&q, &geometry.velocities(&q, &p).unwrap()));
        for node in 0..window.points() {
            let [mut q, mut q_dot, mut p] = [start.q.clone(), vec![0.0; 3], start.p.clone()];
            window.node(&state, 0.3, node, [&mut q, &mut q_dot, &mut p]);
            geometry.velocities(&q, &p).unwrap().into_iter().zip(q_dot).for_each(|(exact, found)| near(exact, found));
        }
    }
}

/// The terms of K are those of all coordinates, also of an ignorable one that is not the first.
#[test]
fn the_size_of_k_is_that_of_its_terms() {
    let text = MetricText {
        coordinates: ["t", "x", "y"].map(str::to_owned).to_vec(),
        components: [([0, 0], "2 + x^2"), ([1, 1], "-1"), ([2, 2], "-2 - x^2/3")]
            .map(|(pair, text)| (pair, text.to_owned()))
            .to_vec(),
        ..MetricText::default()
    };
    let geometry = Geometry::new(&GeometryText::Metric(text)).unwrap().around(&[0.0, 0.5, -0.3]).unwrap();
    let start = start(&geometry);
    let (_, window) = solved(&geometry, &start, 0.3);
    let (q, p) = end(&window, &start);
    let q_dot = geometry.velocities(&q, &p).unwrap();
    near(window.norm_terms(), p.iter().zip(&q_dot).map(|(p, q_dot)| (p * q_dot).abs()).sum());
}

/// The end of a window is that of the classical Runge–Kutta method in many steps, and all rows of rates are looked at.
#[test]
fn the_end_is_where_the_motion_leads() {
    for geometry in geometries() {
        let start = start(&geometry);
        let (_, window) = solved(&geometry, &start, 0.3);
        let mut point = geometry.point();
        let mut state = [start.q.clone(), start.p.clone()].concat();
        let mut slopes = [(); 4].map(|()| vec![0.0; 6]);
        for _ in 0..1000 {
            runge_kutta(&mut state, 3e-4, &mut slopes, |_, trial, out| point.slopes(trial, out)).unwrap();
        }
        let (q, p) = end(&window, &start);
        let off = q.iter().chain(&p).zip(&state).map(|(found, exact)| (found - exact).abs()).fold(0.0, f64::max);
        assert!(off < 1e-13, "{off:e}");
        for (tail, rates) in window.tails.iter().zip(window.unknowns.rates()) {
            assert_eq!(tail.largest, rates.0.iter().fold(0.0, |most: f64, rate| most.max(rate.abs())));
            assert!(tail.tail > 0.0 && tail.tail < 1e-6 * tail.largest, "{tail:?}");
        }
    }
}

/// With S the square of the linearised equations it is the fourth root of ½ Σ |S_ij S_ji|; ω for an oscillator.
#[test]
fn the_rate_of_the_motion_is_that_of_the_linearised_equations() {
    for geometry in geometries() {
        let start = start(&geometry);
        let (state, _) = solved(&geometry, &start, 0.3);
        let mut jacobian = [[0.0; 4]; 4];
        let see = |row: usize, column: usize, value| jacobian[row][column] = value;
        geometry.point().jacobian(&start.q, &start.p, see);
        let entry = |i: usize, j: usize| (0..4).map(|k| jacobian[i][k] * jacobian[k][j]).sum::<f64>();
        let sum: f64 = (0..16).map(|k| (entry(k / 4, k % 4) * entry(k % 4, k / 4)).abs()).sum();
        let mut judge = Judge::new(&geometry, &state, &start.p, None);
        let mut transport = Transport::new(&geometry);
        transport.begin(&start.p, &state);
        near(judge.look_at(&transport), (0.5 * sum).powf(0.25));
        // Errors of momenta count by what they do to positions in the time scale.
        judge.set_scale(0.5);
        for place in 0..2 {
            let most = (0..2).map(|row| jacobian[row][2 + place].abs()).fold(0.0, f64::max);
            near(judge.weights.p[place], 0.5 * most);
        }
    }
}

/// What rows of errors say about K is its gradient: half of it, by differences.
#[test]
fn the_gradient_of_k_is_made_of_rates() {
    for geometry in geometries() {
        let start = start(&geometry);
        let (state, window) = solved(&geometry, &start, 0.3);
        let judge = Judge::new(&geometry, &state, &start.p, None);
        let (q, p) = end(&window, &start);
        let norm = |q: &[f64], p: &[f64]| geometry.norm(q, &geometry.velocities(q, p).unwrap());
        let along = |a: usize, is_momentum: bool| {
            let [before, after] = [-1e-5, 1e-5].map(|step| {
                let (mut q, mut p) = (q.clone(), p.clone());
                *(if is_momentum { &mut p[a] } else { &mut q[a] }) += step;
                norm(&q, &p)
            });
            0.5 * (after - before) / 2e-5
        };
        for (place, &a) in geometry.active().iter().enumerate() {
            assert!((judge.local(&window, place).half_norm - along(a, false)).abs() < 1e-8);
            assert!((judge.local(&window, 2 + place).half_norm - along(a, true)).abs() < 1e-8);
        }
        assert_eq!(judge.local(&window, 4).half_norm, 0.0);
    }
}

/// A judge that has seen the time scale 0.5, and a transport of errors, both at the start.
pub(super) fn judge<'g>(
    geometry: &'g Geometry,
    (state, start): (&FlowState, &Start),
    clock: Option<usize>,
) -> (Judge<'g>, Transport<'g>) {
    let mut judge = Judge::new(geometry, state, &start.p, clock);
    let mut transport = Transport::new(geometry);
    transport.begin(&start.p, state);
    judge.look_at(&transport);
    judge.set_scale(0.5);
    (judge, transport)
}

/// A change of K means errors of a size that makes it, unless a force changes K.
#[test]
fn a_change_of_k_says_how_large_errors_are() {
    let forced = geometry(&[([1, 1], "-1"), ([2, 2], "-2")], &[(1, "1e-300*x_dot")]);
    let [separable, uneven] = geometries();
    let [near, far] = [start(&uneven), start(&separable)].map(|start| start.q);
    let far: Vec<f64> = far.iter().map(|q| 16.0 * q).collect();
    for (geometry, q, h) in
        [(&separable, &near, 0.3), (&uneven, &near, 0.3), (&forced, &near, 0.3), (&separable, &far, 0.1)]
    {
        let start = Start { q: q.clone(), p: geometry.momenta(q, &start(geometry).q_dot), ..start(geometry) };
        let (state, mut window) = solved(geometry, &start, h);
        let (mut judge, transport) = judge(geometry, (&state, &start), None);
        // Errors of one size in all rows, each with the sign that makes K larger.
        let error = 1e-6;
        let active = geometry.active().iter().enumerate();
        let half: f64 = active
            .map(|(place, &a)| {
                let [velocity, force] = window.rates_at_end(place);
                error * (velocity.abs() / judge.weights.p[place] + force.abs() / judge.weights.q[a])
            })
            .sum();
        judge.see(&window, 0.0, &transport);
        assert_eq!(judge.at_ends(), 0.0);
        window.norm += 2.0 * half;
        judge.see(&window, 0.0, &transport);
        let expected = if geometry.has_force() { 0.0 } else { BY_NORM * error };
        assert!((judge.at_ends() - expected).abs() <= 1e-6 * expected, "{:e}", judge.at_ends());
    }
}

/// The unit of the metric changes nothing.
#[test]
fn the_unit_of_k_changes_nothing() {
    let worst = |unit: f64| {
        let unit_of = |text: &str| format!("{unit}*({text})");
        let [t, x, y] = ["2 + x^2", "-1", "-1"].map(unit_of);
        let components = [([0, 0], t), ([1, 1], x), ([2, 2], y)];
        let text = MetricText {
            coordinates: ["t", "x", "y"].map(str::to_owned).to_vec(),
            components: components.to_vec(),
            ..MetricText::default()
        };
        let geometry: Geometry = Geometry::new(&GeometryText::Metric(text)).unwrap().around(&[0.0; 3]).unwrap();
        let start = start(&geometry);
        let (state, mut window) = solved(&geometry, &start, 0.3);
        let (mut judge, transport) = judge(&geometry, (&state, &start), None);
        window.norm += unit * 1e-13;
        judge.see(&window, 0.0, &transport);
        judge.at_ends()
    };
    let expected = worst(1.0);
    assert!(expected > 0.0);
    for unit in [2.0_f64.powi(40), 2.0_f64.powi(-40)] {
        near(worst(unit), expected);
    }
}

/// Ignorable coordinates count from the start, and active ones from zero.
#[test]
fn sizes_are_those_of_what_matters() {
    let geometry = &geometries()[0];
    let start = Start { q: vec![1000.0, 4.0, -0.5], ..start(geometry) };
    let judge = Judge::new(geometry, &FlowState::new(&start, geometry.active()), &start.p, None);
    assert_eq!(judge.weights.q, [1.0, 0.25, 1.0]);
}

/// The error is that of the coordinate with the largest one, and that of a clock besides.
#[test]
fn errors_at_equal_values_of_a_clock_are_larger() {
    let [geometry, _] = geometries();
    let start = start(&geometry);
    let (state, window) = solved(&geometry, &start, 0.3);
    let errors = [3e-9, 2e-9, 0.0, 0.0, 1e-9];
    for clock in [None, Some(0), Some(1)] {
        let (mut judge, mut transport) = judge(&geometry, (&state, &start), clock);
        transport.enlarge(|row| Local { size: errors[row], ..NONE });
        judge.see(&window, 1e-7, &transport);
        // Rows of errors are x, y, their momenta, t.
        let [t, x, y] = [4, 0, 1].map(|row| errors[row]);
        // With x as the clock an error of x counts as one of t or y by how fast these move with x.
        let pace = |a: usize, by: usize| {
            let before = start.q_dot[a] / start.q_dot[by];
            before.abs().max((window.velocity_at_end(a) / window.velocity_at_end(by)).abs())
        };
        let expected = match clock {
            None => x.max(y).max(t),
            Some(0) => x.max(y) + t * pace(1, 0).max(pace(2, 0)).max(1.0),
            Some(_) => y.max(t) + x * pace(0, 1).max(pace(2, 1)).max(1.0),
        };
        near(judge.at_ends(), CAUTION * expected);
        near(judge.so_far(), CAUTION * expected + 1e-7 + ROUNDING);
    }
    // A clock that stands still has no pace.
    let still = Start { q_dot: vec![1.0, 0.0, 0.7], p: geometry.momenta(&start.q, &[1.0, 0.0, 0.7]), ..start };
    let state = FlowState::new(&still, geometry.active());
    let judge = Judge::new(&geometry, &state, &still.p, Some(1));
    assert_eq!(judge.weights.q, [1.0; 3]);
}

/// What sweeps have left is an error of the active rows, and rounding of all that a row depends on is one of it.
#[test]
fn what_sweeps_leave_and_rounding_are_errors() {
    for geometry in geometries() {
        let start = start(&geometry);
        let (state, mut window) = solved(&geometry, &start, 0.3);
        let (mut judge, mut transport) = judge(&geometry, (&state, &start), None);
        transport.follow(&window, &judge.weights, 1.0);
        judge.look_back(&transport);
        let local = |window: &FlowWindow<'_, 16>| [0, 1, 2, 3, 4].map(|row| judge.local(window, row));
        window.left = 0.0;
        let before = local(&window);
        window.left = 1e-3;
        let after = local(&window);
        for row in 0..5 {
            let weight = if row < 2 { judge.weights.q[1 + row] } else { judge.weights.p[(row - 2) % 2] };
            let expected = if row < 4 { 1e-3 / weight } else { 0.0 };
            assert!((after[row].size - before[row].size - expected).abs() < 1e-12, "{row}");
        }
        // The linearised equations in the middle, with the values at the end.
        let mut sums = [0.0; 4];
        let values = [1, 2].map(|a| window.end.q[a].hi).into_iter().chain(window.end.p.iter().map(|p| p.hi));
        let values: Vec<f64> = values.collect();
        transport.at_middle(|row, column, entry| {
            if row < 4 {
                sums[row] += (entry * values[column]).abs();
            }
        });
        let ratio = if geometry.is_separable() { 0.5 } else { 2.0 };
        for (row, local) in before.iter().enumerate() {
            let nodes = if row < 4 { ROUNDED_NODES * 0.3 * sums[row] } else { 0.0 };
            near(local.rounding, f64::EPSILON * (ratio * window.tails[row].largest + nodes));
        }
    }
}

/// Where the kinetic part is constant momenta follow from positions, and what is integrated twice is better inside.
#[test]
fn modes_say_what_a_window_lacks() {
    for geometry in geometries() {
        let start = start(&geometry);
        let (state, mut window) = solved(&geometry, &start, 0.3);
        let (judge, _) = judge(&geometry, (&state, &start), None);
        let mut errors = |row: usize, lasting: f64| {
            window.tails.fill(Tail { tail: 0.0, largest: 1.0 });
            window.tails[row].tail = 1e-12;
            judge.of_window(&window, lasting)
        };
        for row in 0..5 {
            let [once, longer] = [1.0, 2.0].map(|lasting| errors(row, lasting));
            match (row, geometry.is_separable()) {
                (2 | 3, true) => assert!(once.end == 0.0 && once.inside == 0.0),
                (0 | 1, true) => {
                    near(longer.end, 2.0 * once.end);
                    near(longer.inside, once.inside);
                    assert!((1e-15..1e-13).contains(&once.inside), "{:e}", once.inside);
                }
                _ => assert!(longer.end == once.end && once.end > 0.0 && once.inside < 1e-12, "{once:?}"),
            }
        }
    }
}
