//! Marches along world-lines of scenes: what they say of themselves, and where they stop.

use std::ops::ControlFlow;

use geodesic_ivp::action::DoubledAction;
use geodesic_ivp::case::{SceneCase, builtin};
use geodesic_ivp::engine::lobatto::flow::{Flow, FlowFailure, FlowView, PhasePoint, Stop};
use geodesic_ivp::geometry::{Geometry, GeometryText, Start};
use geodesic_ivp::sbp::SbpName;

use crate::common;

fn scene(name: &str) -> (Geometry, Start) {
    let case = SceneCase::parse(name, builtin::text(name).unwrap(), &[]).unwrap();
    (case.geometry(), case.start())
}

/// ∇E_weak of the window, by the action of any operator. Ignorable coordinates are counted from its start.
fn gradient_norm(view: &FlowView<'_>, geometry: &Geometry, momenta: &[f64]) -> f64 {
    let n = view.points;
    let sbp = SbpName::Gll(n as u8).operator(n, view.length / (n - 1) as f64).expect("a rule");
    let (mut q, mut p) = (vec![0.0; geometry.dimension()], momenta.to_vec());
    for (place, &a) in geometry.active().iter().enumerate() {
        (q[a], p[a]) = (view.start.q[a].hi, view.start.p[place].hi);
    }
    let q_dot = geometry.velocities(&q, &p).unwrap();
    let branch: Vec<f64> = (0..geometry.dimension()).flat_map(|a| view.q(a)).collect();
    let unknowns = [&branch[..], &branch[..]].concat();
    let mut gradient = vec![0.0; unknowns.len()];
    DoubledAction::weak(&sbp, geometry, Start { q, q_dot, p }).gradient(&unknowns, &mut gradient).unwrap();
    gradient.iter().fold(0.0, |most, v| v.abs().max(most))
}

#[test]
fn certificates_are_gradients_of_the_action() {
    for (name, length) in [("schwarzschild-orbit", 400.0), ("kerr-inclined", 100.0), ("double-pendulum", 4.0)] {
        let (geometry, start) = scene(name);
        for accuracy in [1e-4, 1e-9] {
            let mut seen = 0;
            let see = &mut |view: &FlowView<'_>| {
                let (found, expected) = (view.gradient_norm.unwrap(), gradient_norm(view, &geometry, &start.p));
                // Two derivatives of norm 2n² and a quadrature weight of 1/n² of rounded momenta.
                let largest = start.p.iter().copied().chain(view.end.p.iter().map(|p| p.hi)).fold(1.0, f64::max);
                let rounding = 16.0 * f64::EPSILON * (view.points * view.points) as f64 * largest;
                assert!((found - expected).abs() < 1e-3 * expected + rounding, "{name}: {found:e}, {expected:e}");
                seen += usize::from(found > rounding);
                ControlFlow::Continue(())
            };
            Flow::new(&geometry).certified().run(&start, length, &mut [], accuracy, see).unwrap();
            // Where iterations are stopped early the certificate says so.
            assert!(accuracy < 1e-4 || seen > 0, "{name}");
        }
    }
}

/// The value of a coordinate, counted from one that it has on the way.
struct Passes {
    coordinate: usize,
    value: f64,
    sign: f64,
    to_positive: bool,
}

impl Stop for Passes {
    fn value(&mut self, point: PhasePoint<'_>) -> f64 {
        self.sign * (point.q[self.coordinate] - self.value)
    }

    fn counts(&self, to_positive: bool) -> bool {
        self.to_positive == to_positive
    }
}

fn go_on(_: &FlowView<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// A march that is begun again forgets on which side of a stop it was.
#[test]
fn a_march_that_is_begun_again_looks_afresh() {
    let (geometry, start) = scene("kepler-eccentric");
    let length = 60.0;
    // Half of the time is left behind once, in the direction that does not count.
    let mut stop = Passes { coordinate: 0, value: 1.0, sign: -1.0, to_positive: true };
    // Which accuracies need a second attempt hangs on last digits, which differ between machines.
    let mut begun_again = 0;
    for accuracy in [1e-12, 8e-13, 7e-13, 6e-13, 5e-13, 4e-13, 3e-13, 2.5e-13, 2e-13, 1.5e-13, 1.2e-13, 1e-13] {
        let Ok(followed) = Flow::new(&geometry).run(&start, length, &mut [&mut stop], accuracy, &mut go_on) else {
            continue;
        };
        begun_again += usize::from(followed.attempts > 1);
        assert_eq!((followed.stopped_by, followed.gamma), (None, length), "{accuracy:e}");
    }
    assert!(begun_again > 0);
}

/// A stop at the very joint of two windows, or a few last digits beside it, is found in one of them.
#[test]
fn a_stop_at_a_joint_is_not_missed() {
    for name in ["schwarzschild-orbit", "double-pendulum"] {
        let (geometry, start) = scene(name);
        let coordinate = geometry.active()[0];
        let mut joint = (0.0, 0.0);
        let see = &mut |view: &FlowView<'_>| {
            joint = (view.gamma + view.length, view.end.q[coordinate].hi);
            ControlFlow::Break(())
        };
        let length = if name == "double-pendulum" { 20.0 } else { 2000.0 };
        Flow::new(&geometry).run(&start, length, &mut [], 1e-9, see).unwrap();
        let (gamma, value) = joint;
        let to_positive = value > start.q[coordinate];
        for ulps in -4..=4 {
            let value = value + f64::from(ulps) * f64::EPSILON * value.abs();
            let mut stop = Passes { coordinate, value, sign: 1.0, to_positive };
            let followed = Flow::new(&geometry).run(&start, length, &mut [&mut stop], 1e-9, &mut go_on).unwrap();
            let off = (followed.gamma - gamma).abs();
            assert!(
                followed.stopped_by == Some(0) && off < 1e-10 * gamma,
                "{name} {ulps}: {}, {gamma}",
                followed.gamma
            );
        }
    }
}

/// Where t does not move, a horizon is passed without a force; behind it is outside the domain.
#[test]
fn a_horizon_ends_free_motion() {
    let text = common::metric(&["t", "x"], &[("t t", "1 + 2*x"), ("x x", "-1")]);
    let geometry: Geometry = Geometry::new(&GeometryText::Metric(text)).unwrap().around(&[0.0, 0.0]).unwrap();
    let start = Start { q: vec![0.0, 0.0], q_dot: vec![0.0, -1.0], p: vec![0.0, 1.0] };
    for accuracy in [1e-4, 1e-10] {
        let failure = Flow::new(&geometry).run(&start, 2.0, &mut [], accuracy, &mut go_on).unwrap_err();
        let FlowFailure::OutsideDomain { gamma, q, .. } = failure else { panic!("{failure}") };
        assert!((gamma - 0.5).abs() < 0.01 && (q[1] + 0.5).abs() < 0.01, "{gamma}, {q:?}");
    }
}

/// A thin wall that sends a particle back is met on a run of any length, also of one without an end but for a stop.
#[test]
fn a_wall_is_met_on_a_run_of_any_length() {
    let text = common::metric(&["t", "x"], &[("t t", "9 + x^2/50 + 4*exp(-((x - 2)/1e-4)^2)"), ("x x", "-1")]);
    let geometry: Geometry = Geometry::new(&GeometryText::Metric(text)).unwrap().around(&[0.0, 0.0]).unwrap();
    let start = Start { q: vec![0.0, 0.0], q_dot: vec![1.0, 0.5], p: vec![9.0, -0.5] };
    for accuracy in [1e-4, 1e-9] {
        let [short, long, endless] = [15.0, 1e3, f64::INFINITY].map(|length| {
            let mut stop = Passes { coordinate: 1, value: -0.5, sign: 1.0, to_positive: false };
            let march = Flow::new(&geometry);
            march.run(&start, length, &mut [&mut stop], accuracy, &mut go_on).unwrap().gamma
        });
        // Without the wall it comes back after half a period of more than 20.
        assert!(short < 12.0 && (long - short).abs() < 10.0 * accuracy, "{short}, {long}");
        assert!((endless - short).abs() < 10.0 * accuracy, "{short}, {endless}");
    }
}

/// What is seen on the nodes begins at the start of a window and ends at its end.
#[test]
fn rows_lead_from_the_start_to_the_end() {
    for name in ["schwarzschild-orbit", "kerr-inclined", "double-pendulum"] {
        let (geometry, start) = scene(name);
        let see = &mut |view: &FlowView<'_>| {
            let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-6 * b.abs().max(1.0), "{name}: {a} {b}");
            for place in 0..geometry.active().len() {
                let p = view.p(place);
                near(p[0], view.start.p[place].hi);
                near(p[view.points - 1], view.end.p[place].hi);
            }
            for a in 0..geometry.dimension() {
                let (q, start) = (view.q(a), view.start.q[a].hi);
                let origin = if geometry.active().contains(&a) { 0.0 } else { start };
                near(origin + q[0], start);
                near(origin + q[view.points - 1], view.end.q[a].hi);
            }
            ControlFlow::Break(())
        };
        Flow::new(&geometry).run(&start, 20.0, &mut [], 1e-9, see).unwrap();
    }
}

/// A march that is ended before its length says how far it has come.
#[test]
fn a_march_that_is_ended_says_where() {
    let (geometry, start) = scene("schwarzschild-orbit");
    let mut joint = 0.0;
    let see = &mut |view: &FlowView<'_>| {
        joint = view.gamma + view.length;
        if view.index == 1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let followed = Flow::new(&geometry).run(&start, 2000.0, &mut [], 1e-6, see).unwrap();
    assert!(joint > 1.0 && followed.gamma == joint && followed.stopped_by.is_none());
    // Also in the only window, whose end would be that of the run.
    let phi = start.q.len() - 1;
    let value = start.q[phi] + 0.5 * start.q_dot[phi];
    let mut stop = Passes { coordinate: phi, value, sign: 1.0, to_positive: true };
    let followed = Flow::new(&geometry).run(&start, 1.0, &mut [&mut stop], 1e-6, &mut go_on).unwrap();
    assert!(followed.statistics.windows == 1 && followed.stopped_by == Some(0));
    assert!((followed.gamma - 0.5).abs() < 1e-3, "{}", followed.gamma);
    let whole = Flow::new(&geometry).run(&start, 1.0, &mut [], 1e-6, &mut go_on).unwrap();
    assert!(whole.gamma == 1.0 && whole.stopped_by.is_none());
}

/// The error of a run that a stop ends early is that of the window which is left of the one that was solved first.
#[test]
fn the_estimate_is_that_of_the_windows_that_are_kept() {
    let (geometry, start) = scene("double-pendulum");
    let a = geometry.active()[0];
    let run = |part: f64| {
        let mut value = start.q[a];
        let see = &mut |view: &FlowView<'_>| {
            view.inside(&[part], |q, _| value = q[a]);
            ControlFlow::Break(())
        };
        Flow::new(&geometry).run(&start, 20.0, &mut [], 1e-4, see).unwrap();
        let mut stop = Passes { coordinate: a, value, sign: 1.0, to_positive: value > start.q[a] };
        Flow::new(&geometry).run(&start, 20.0, &mut [&mut stop], 1e-4, &mut go_on).unwrap().error_estimate
    };
    let [early, late] = [0.1, 0.9].map(run);
    assert!(early < 1e-9 && late > 1e3 * early, "{early:e}, {late:e}");
}

/// A run that would take a day is not begun for long.
#[test]
fn a_march_without_an_end_in_sight_says_what_it_would_need() {
    let (geometry, start) = scene("schwarzschild-orbit");
    let length = 1e16;
    let failure = Flow::new(&geometry).run(&start, length, &mut [], 1e-4, &mut go_on).unwrap_err();
    let FlowFailure::EvaluationLimit { gamma, q, evaluations, needed } = failure else { panic!("{failure}") };
    assert!(
        q.len() == geometry.dimension()
            && gamma > 1e4
            && (needed * gamma / (evaluations as f64 * length) - 1.0).abs() < 1e-12
    );
    assert!(evaluations < 100_000 && needed > 1e12, "{evaluations}, {needed:e}");
}

/// Between the start and the next node a stop may change its sign, whatever its size; and one that stays zero does not.
#[test]
fn a_stop_is_met_right_after_the_start() {
    let (geometry, start) = scene("schwarzschild-orbit");
    for sign in [1e-12, 1.0, -1e12] {
        let phi = start.q.len() - 1;
        let value = start.q[phi] + 1e-3 * start.q_dot[phi];
        let mut stop = Passes { coordinate: phi, value, sign, to_positive: sign > 0.0 };
        let followed = Flow::new(&geometry).run(&start, 20.0, &mut [&mut stop], 1e-9, &mut go_on).unwrap();
        assert!(followed.stopped_by == Some(0) && (followed.gamma - 1e-3).abs() < 1e-6, "{sign}: {}", followed.gamma);
    }
    for to_positive in [false, true] {
        let mut stop = Zero { to_positive };
        let followed = Flow::new(&geometry).run(&start, 20.0, &mut [&mut stop], 1e-9, &mut go_on).unwrap();
        assert!(followed.stopped_by.is_none() && followed.gamma == 20.0);
    }
}

/// A value that is always zero.
struct Zero {
    to_positive: bool,
}

impl Stop for Zero {
    fn value(&mut self, _: PhasePoint<'_>) -> f64 {
        0.0
    }

    fn counts(&self, to_positive: bool) -> bool {
        self.to_positive == to_positive
    }
}
