//! Scenes for the tests of the engine.

use super::window::{Known, Solver};
use crate::geometry::{Geometry, GeometryText, Law, Preset, Start};
use crate::number::Compensated;

/// A scene at this point, with momenta.
fn scene(text: &GeometryText, q: &[f64], p: impl Fn(&Geometry) -> Vec<f64>) -> (Geometry, Start) {
    let geometry: Geometry = Geometry::new(text).unwrap().with_domain_of(q).unwrap();
    let p = p(&geometry);
    let q_dot = geometry.velocities(q, &p).unwrap();
    (geometry, Start { q: q.to_vec(), q_dot, p })
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

pub(super) fn metric(
    coordinates: &[&str],
    components: &[(usize, usize, &str)],
    q: &[f64],
    p: &[f64],
) -> (Geometry, Start) {
    let text = GeometryText {
        coordinates: names(coordinates),
        components: components.iter().map(|&(a, b, formula)| ([a, b], formula.to_owned())).collect(),
        ..GeometryText::default()
    };
    scene(&text, q, |_| p.to_vec())
}

/// Newton's law in a potential, from a point with a velocity.
pub(super) fn lifted(formula: &str, coordinates: &[&str], x: &[f64], v: &[f64]) -> (Geometry, Start) {
    let [q, q_dot] = [(0.0, x), (1.0, v)].map(|(first, rest)| [&[first], rest, &[0.0]].concat());
    let text = GeometryText::of_potential(coordinates, formula, Law::Newtonian);
    scene(&text, &q, |geometry| geometry.momenta(&q, &q_dot))
}

/// The quartic well g_tt = 1 + x⁴.
pub(super) fn well() -> (Geometry, Start) {
    scene(&GeometryText::of_potential(&["x"], "x^4/2", Law::Relativistic), &[0.0, 1.0], |_| vec![2.0, -0.1])
}

/// A preset, whose last parameter has this value.
fn preset(name: &str, last: &str, q: &[f64], p: &[f64]) -> (Geometry, Start) {
    let mut text = Preset::from_name(name).unwrap().text();
    text.parameters.last_mut().unwrap().1 = last.to_owned();
    scene(&text, q, |_| p.to_vec())
}

/// An orbit around a black hole with p = 10, e = 0.5.
pub(super) fn schwarzschild() -> (Geometry, Start) {
    let p = [0.966_091_783_079_295_9, 0.0, -3.849_001_794_597_505];
    preset("schwarzschild", "1", &[0.0, 20.0 / 3.0, 0.0], &p)
}

/// An inclined orbit around a rotating one.
pub(super) fn kerr() -> (Geometry, Start) {
    let p = [0.941_816_181_145_791_8, 0.0, 0.0, -2.513_146_042_747_529_4];
    preset("kerr", "0.9", &[0.0, 4.0, std::f64::consts::FRAC_PI_3, 0.0], &p)
}

/// Solves the next window. Returns by how much ignorable coordinates grow.
pub(super) fn advance(solver: &mut Solver<'_, 16>, h: f64) -> Vec<f64> {
    // At the start of a run that changes nothing.
    solver.advance();
    let tables = solver.rule.tables(solver.system.order, Compensated::from(h), true);
    solver.solve(&tables, None, 1e-15).unwrap();
    solver.finish(&tables, Known::All);
    solver.ignorable.iter().map(|&a| solver.end.q[a].high - solver.start.q[a].high).collect()
}
