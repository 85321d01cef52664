//! The windows of the engine of few nodes are as it says.

use std::ops::ControlFlow;

use geodesic_ivp::action::{DoubledAction, Form};
use geodesic_ivp::engine::{Accuracy, Engine, Failure, Window};
use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::sbp::SbpName;

use super::engine::{SCENES, scene};
use crate::common::{QUARTIC_POTENTIAL, one, reference, rounding_of_gradients};

/// Scenes of every kind, one of them without a potential and one of one coordinate.
fn scenes() -> Vec<(&'static str, (Geometry, Start))> {
    let one = |name, potential| (name, one(potential, 1.7, [1.0, 0.7, 0.1]));
    let scenes = SCENES.iter().map(|(name, text)| (*name, scene(text.split("grid").next().unwrap())));
    scenes.chain([one("free", "0"), one("one", "exp(-x) + x^2/3")]).collect()
}

/// Windows of one length, and as long as an accuracy needs.
fn engines<'g>((geometry, start): &'g (Geometry, Start), length: f64) -> [Engine<'g>; 2] {
    [
        Engine::equal(geometry, start, length, 8, 12).unwrap(),
        Engine::accurate(geometry, start, length, Accuracy::Promised(1e-9)).unwrap(),
    ]
}

/// Nodes lead from the start of a window to its end, where the next one begins; and a run that is ended says where.
#[test]
fn windows_follow_each_other() {
    for (name, scene) in scenes() {
        for mut engine in engines(&scene, 4.0) {
            let (mut count, mut joint) = (0, (0.0, scene.1.q.clone()));
            let run = engine.run(|mut window| {
                assert_eq!((window.index, window.gamma, window.start().positions()), (count, joint.0, joint.1.clone()));
                joint = (window.gamma + window.length, window.end().positions());
                let [begin, end] = [window.start(), window.end()].map(|state| (state.positions(), state.momenta()));
                let (nodes, active) = (window.nodes(), scene.0.active());
                let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-7 * b.abs().max(1.0), "{name}: {a} {b}");
                let ends = |row: &[f64], begin: f64, end: f64| {
                    near(row[0], begin);
                    near(row[row.len() - 1], end);
                };
                for a in 0..scene.0.dimension() {
                    let origin = if active.contains(&a) { 0.0 } else { begin.0[a] };
                    ends(nodes.q(a), begin.0[a] - origin, end.0[a] - origin);
                }
                (0..active.len()).for_each(|place| ends(nodes.p(place), begin.1[place], end.1[place]));
                count += 1;
                if count == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            assert_eq!((run, engine.place()), (Ok(()), joint), "{name}");
        }
    }
}

/// ∇E_weak of the window, by the action of any operator. Ignorable coordinates are counted from its start.
fn gradient_norm(window: &mut Window<'_>, (geometry, start): &(Geometry, Start)) -> f64 {
    let mut here = Start { q: vec![0.0; geometry.dimension()], q_dot: Vec::new(), p: start.p.clone() };
    for (place, &a) in geometry.active().iter().enumerate() {
        (here.q[a], here.p[a]) = (window.start().positions()[a], window.start().momenta()[place]);
    }
    here.q_dot = geometry.velocities(&here.q, &here.p).unwrap();
    let h = window.length;
    let nodes = window.nodes();
    let n = nodes.points();
    let sbp = SbpName::Gll(n as u8).operator(n, h / (n - 1) as f64).unwrap();
    let branch: Vec<f64> = (0..geometry.dimension()).flat_map(|a| nodes.q(a).to_vec()).collect();
    let unknowns = [&branch[..], &branch[..]].concat();
    let mut gradient = vec![0.0; unknowns.len()];
    DoubledAction::new(Form::Weak, &sbp, geometry, here).gradient(&unknowns, &mut gradient).unwrap();
    gradient.iter().fold(0.0, |most, entry| entry.abs().max(most))
}

#[test]
fn certificates_are_gradients_of_the_action() {
    let mut early = 0;
    for (name, scene) in scenes() {
        let (geometry, start) = &scene;
        let equal = |points| Engine::equal(geometry, start, 0.8, 4, points).unwrap();
        let accurate = |tolerance| Engine::accurate(geometry, start, 4.0, Accuracy::Local(tolerance)).unwrap();
        let accurate = [1e-4, 1e-9].map(accurate);
        let mut largest = 0.0_f64;
        for (number, mut engine) in [2, 5, 8, 16, 24].map(equal).into_iter().chain(accurate).enumerate() {
            let run = engine.run(|mut window| {
                let (found, expected) = (window.gradient_norm().unwrap(), gradient_norm(&mut window, &scene));
                let (h, n) = (window.length, window.nodes().points());
                let ends = [window.start(), window.end()].map(|end| (end.positions(), end.momenta()));
                let ends = ends.each_ref().map(|(q, active)| {
                    let mut p = start.p.clone();
                    geometry.active().iter().zip(active).for_each(|(&a, &momentum)| p[a] = momentum);
                    (&q[..], geometry.velocities(q, &p).unwrap(), h)
                });
                let rounding = rounding_of_gradients(geometry, ends, n);
                let off = (found - expected).abs();
                assert!(off < 1e-6 * expected + rounding, "{name} {number}: {found:e}, {expected:e}, {rounding:e}");
                largest = largest.max(found / rounding);
                ControlFlow::Continue(())
            });
            assert_eq!(run, Ok(()), "{name} {number}");
        }
        early += usize::from(largest > 1.0);
    }
    // Where sweeps are stopped early the certificate says so.
    assert!(early > 3, "{early}");
}

/// The largest error of q and p at 40 fractions of each of `windows` windows.
fn inside_error((geometry, start): &(Geometry, Start), length: f64, windows: usize, points: usize) -> f64 {
    let reference = reference(geometry, start, length);
    let (mut q, mut p) = (vec![0.0; geometry.dimension()], vec![0.0; geometry.active().len()]);
    let (mut engine, mut most) = (Engine::equal(geometry, start, length, windows, points).unwrap(), 0.0);
    while let Some(window) = engine.next().unwrap() {
        let dense = window.dense();
        for fraction in (0..=40).map(|k| f64::from(k) / 40.0) {
            dense.at(fraction, &mut q, &mut p);
            let exact = reference.at((window.gamma + fraction * window.length).min(length));
            let momenta = geometry.active().iter().map(|&a| exact.p[a]);
            let known = exact.q.iter().copied().chain(momenta);
            most =
                q.iter().chain(&p).zip(known).fold(most, |most: f64, (found, known)| most.max((found - known).abs()));
        }
    }
    most
}

#[test]
fn dense_output_is_of_order_n_plus_one() {
    let quartic = one(QUARTIC_POTENTIAL, 1.0, [1.0, 1.0, 0.1]);
    let orbit = scene(SCENES[1].1.split("grid").next().unwrap());
    for (scene, length) in [(&quartic, 1.0), (&orbit, 100.0)] {
        for n in [4, 5, 6, 7] {
            let errors = [8, 16].map(|windows| inside_error(scene, length, windows, n));
            let order = (errors[0] / errors[1]).log2();
            assert!(order > n as f64 + 0.75, "{n} nodes: order {order}, {errors:?}");
        }
    }
    for n in [12, 16, 20, 24] {
        let error = inside_error(&quartic, 1.0, 4, n);
        assert!(error < 1e-11_f64.powf(n as f64 / 12.0).max(2e-15), "{n} nodes: {error}");
    }
}

/// g00 is at least 1 on the world-line, and would be negative at a mixture of values of exp(−x) and x from different
/// nodes.
#[test]
fn lanes_beyond_the_nodes_are_no_points_of_the_world_line() {
    let (geometry, start) = one("3*(exp(-x) - 1 + x)", 1.0, [0.0, 1.0, 0.3]);
    let exact = reference(&geometry, &start, 1.0).at(1.0).q;
    for n in [15, 16, 19, 20, 23, 24] {
        let mut engine = Engine::equal(&geometry, &start, 1.0, 1, n).unwrap();
        let end = engine.next().unwrap().unwrap().end().positions();
        assert!((end[1] - exact[1]).abs() + (end[0] - exact[0]).abs() < 1e-14, "{n} nodes");
    }
}

#[test]
fn windows_of_one_length_fail_with_a_reason_and_a_place() {
    // g00 = 1 + 2x: the particle falls into the horizon at x = −1/2.
    let (geometry, start) = one("x", 1.0, [0.0, 1.0, 0.0]);
    let mut engine = Engine::equal(&geometry, &start, 6.25, 100, 16).unwrap();
    let mut last = (0.0, start.q.clone());
    let failure = engine.run(|window| {
        last = (window.gamma + window.length, window.end().positions());
        ControlFlow::Continue(())
    });
    let ends = ReferenceTrajectory::new(&geometry, &start, 6.25, 16).unwrap_err();
    assert!(matches!(failure, Err(Failure::OutsideDomain(_) | Failure::NotConverged)), "{failure:?}");
    assert!((last.0 - ends.gamma).abs() < 0.0625 && last.1[1] < -0.39, "{last:?}: {ends}");
    assert_eq!(engine.place(), last);
    // Ten units at once are too much for the quartic potential, which has no horizon.
    let (geometry, start) = one(QUARTIC_POTENTIAL, 1.0, [1.0, 1.0, 0.1]);
    let mut engine = Engine::equal(&geometry, &start, 30.0, 3, 16).unwrap();
    assert_eq!(engine.next().err(), Some(Failure::NotConverged));
    assert_eq!(engine.place(), (0.0, start.q.clone()));
}
