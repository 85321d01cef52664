//! Scenes for the tests of the engine, and pairs of motions that begin beside each other.

use super::rule::{Order, Rule};
use super::sizes::Sizes;
use super::window::{Known, Solver};
use crate::geometry::{Geometry, GeometryText, Law, Start};
use crate::number::Compensated;
use crate::sbp::collocation::Collocation;
use crate::sbp::legendre::Family;

/// A scene at this point, with these momenta.
fn scene(text: &GeometryText, q: &[f64], p: &[f64]) -> (Geometry, Start) {
    let geometry: Geometry = Geometry::new(text).unwrap().with_domain_of(q).unwrap();
    let q_dot = geometry.velocities(q, p).unwrap();
    (geometry, Start { q: q.to_vec(), q_dot, p: p.to_vec() })
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
    scene(&text, q, p)
}

/// Newton's law in a potential, from a point with a velocity.
pub(super) fn lifted(formula: &str, coordinates: &[&str], x: &[f64], v: &[f64]) -> (Geometry, Start) {
    let q = [&[0.0], x, &[0.0]].concat();
    let geometry: Geometry = Geometry::new(&GeometryText::of_potential(coordinates, formula, Law::Newtonian)).unwrap();
    let p = geometry.momenta(&q, &[&[1.0], v, &[0.0]].concat());
    scene(&GeometryText::of_potential(coordinates, formula, Law::Newtonian), &q, &p)
}

/// The quartic well g_tt = 1 + x⁴.
pub(super) fn well() -> (Geometry, Start) {
    scene(&GeometryText::of_potential(&["x"], "x^4/2", Law::Relativistic), &[0.0, 1.0], &[2.0, -0.1])
}

/// An orbit around a black hole with p = 10, e = 0.5.
pub(super) fn schwarzschild() -> (Geometry, Start) {
    let components = [(0, 0, "1 - 2/r"), (1, 1, "-1/(1 - 2/r)"), (2, 2, "-r^2")];
    let p = [0.966_091_783_079_295_9, 0.0, -3.849_001_794_597_505];
    metric(&["t", "r", "phi"], &components, &[0.0, 20.0 / 3.0, 0.0], &p)
}

/// An inclined orbit around a rotating one with a = 0.9.
pub(super) fn kerr() -> (Geometry, Start) {
    let components = [
        (0, 0, "1 - 2*r/(r^2 + 0.81*cos(theta)^2)"),
        (0, 3, "1.8*r*sin(theta)^2/(r^2 + 0.81*cos(theta)^2)"),
        (1, 1, "-(r^2 + 0.81*cos(theta)^2)/(r^2 - 2*r + 0.81)"),
        (2, 2, "-(r^2 + 0.81*cos(theta)^2)"),
        (3, 3, "-(r^2 + 0.81 + 1.62*r*sin(theta)^2/(r^2 + 0.81*cos(theta)^2))*sin(theta)^2"),
    ];
    let p = [0.941_816_181_145_791_8, 0.0, 0.0, -2.513_146_042_747_529_4];
    metric(&["t", "r", "theta", "phi"], &components, &[0.0, 4.0, std::f64::consts::FRAC_PI_3, 0.0], &p)
}

/// Two motions in windows of the same lengths.
pub(super) struct Pair<'g> {
    start: &'g Start,
    sizes: Sizes,
    pub(super) first: Solver<'g, 16>,
    second: Solver<'g, 16>,
    /// By how much ignorable coordinates of the second one are ahead.
    pub(super) ignorable: Vec<f64>,
}

impl<'g> Pair<'g> {
    pub(super) fn new(geometry: &'g Geometry, start: &'g Start) -> Self {
        let sizes = Sizes::new(geometry, start, 1e9).unwrap();
        let begun = || {
            let mut solver = Solver::new(geometry, Rule::new(Collocation::shared(Family::Lobatto, 16)), true);
            solver.begin(start, &sizes);
            solver
        };
        let ignorable = vec![0.0; geometry.ignorable().count()];
        Self { first: begun(), second: begun(), start, ignorable, sizes }
    }

    /// Begins the second motion beside the state that the first one has come to, by positions and momenta or
    /// velocities.
    pub(super) fn begin_second(&mut self, beside: Vec<f64>) {
        let (geometry, m) = (self.first.geometry, self.first.geometry.active().len());
        let mut start = self.start.clone();
        let state = &self.first.end;
        for (place, &a) in geometry.active().iter().enumerate() {
            start.q[a] = state.q[a].high + beside[place];
            let by = match self.first.system.order {
                Order::First => beside[m + place],
                // Momenta of these scenes are −q̇.
                Order::Second => -beside[m + place],
            };
            start.p[a] = state.p[place].high + by;
        }
        self.second.begin(&start, &self.sizes);
    }

    pub(super) fn advance_first(&mut self, h: f64) {
        advance(&mut self.first, h);
    }

    /// Advances both by a window of length `h`.
    pub(super) fn advance(&mut self, h: f64) {
        let gains = [advance(&mut self.first, h), advance(&mut self.second, h)];
        self.ignorable.iter_mut().enumerate().for_each(|(j, off)| *off += gains[1][j] - gains[0][j]);
    }

    /// By how much the unknowns of the second one are off at the end of the last window.
    pub(super) fn deviation(&self) -> Vec<f64> {
        let end = |solver: &Solver<'_, 16>| -> Vec<f64> {
            let rows = solver.rows.iter();
            match solver.system.order {
                Order::First => rows.map(|row| row.end.high).collect(),
                Order::Second => {
                    rows.clone().map(|row| row.end.high).chain(rows.map(|row| row.velocity_end.high)).collect()
                }
            }
        };
        end(&self.second).iter().zip(end(&self.first)).map(|(second, first)| second - first).collect()
    }
}

/// Solves the next window. Returns by how much ignorable coordinates grow.
fn advance(solver: &mut Solver<'_, 16>, h: f64) -> Vec<f64> {
    // At the start of a run that changes nothing.
    solver.advance();
    let tables = solver.rule.tables(solver.system.order, Compensated::from(h), true);
    solver.solve(&tables, None, 1e-15).unwrap();
    solver.finish(&tables, Known::Velocities);
    let geometry = solver.geometry;
    geometry.ignorable().map(|a| solver.end.q[a].high - solver.start.q[a].high).collect()
}
