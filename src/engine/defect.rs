//! The defect of a window: by how much its motion misses the equations between its nodes.
//!
//! Collocation makes x′ = f(x) true on the nodes, and its sweeps see nothing else. Between the nodes the slope is the
//! polynomial through the slopes on the nodes, and x is its integral. What the polynomial differs by from f(x) there is
//! the part of f that no polynomial of its degree follows: it is as small as the highest modes of the slopes foretell,
//! or f has a feature that the nodes do not see.

use std::sync::OnceLock;

use pulp::{Simd, WithSimd};

use super::POINTS;
use super::dense::integrated;
use super::kernel::{On, evaluate};
use super::local::larger;
use super::rule::{Order, Rule};
use super::system::System;
use super::window::Solver;
use crate::number::vector::{Lanes, Level, Nodes};
use crate::sbp::legendre::legendre;

/// The number of places, which a vector has: more than two of them cost nothing.
const PLACES: usize = 8;
/// Looks at windows between their nodes.
pub(super) struct Defect<'g> {
    system: System<'g, PLACES>,
}

/// The tables of the places: from slopes on the nodes to those at the places, and to the increments there for length 1,
/// once and twice integrated, by columns.
struct At {
    places: Nodes<PLACES>,
    integrals: [Vec<Nodes<PLACES>>; 3],
}

impl At {
    fn new(rule: &Rule<POINTS>) -> Self {
        let nodes = &rule.nodes[0].0;
        // The middles of every other gap.
        let places: [f64; PLACES] = std::array::from_fn(|i| 0.5 * (nodes[2 * i] + nodes[2 * i + 1]));
        let column = |node: usize, times: usize| {
            let mut unit = Nodes::ZERO;
            unit.0[node] = 1.0;
            let mut modes = rule.modes(&unit).to_vec();
            for _ in 0..times {
                modes = integrated(&modes, 1.0);
            }
            let value = |at: f64| modes.iter().zip(legendre(modes.len() - 1, 2.0 * at - 1.0)).map(|(c, p)| c * p).sum();
            Nodes(places.map(value))
        };
        let integrals = [0, 1, 2].map(|times| (0..POINTS).map(|node| column(node, times)).collect());
        Self { places: Nodes(places), integrals }
    }

    /// The tables, made once in the life of the program.
    fn shared(rule: &Rule<POINTS>) -> &'static Self {
        static TABLES: OnceLock<At> = OnceLock::new();
        TABLES.get_or_init(|| Self::new(rule))
    }
}

impl<'g> Defect<'g> {
    /// For windows of a run.
    pub(super) fn new(solver: &Solver<'g, POINTS>) -> Self {
        Self { system: solver.system.with_lanes(&solver.initial.p) }
    }

    /// The error that the solved window of length h makes between its nodes beyond what the modes of its slopes
    /// foretell, as an estimate: that of a push as long as a gap between two nodes, relative to sizes. Where the
    /// equations have no value at a place, it is infinite.
    pub(super) fn look(&mut self, solver: &Solver<'g, POINTS>, h: f64) -> f64 {
        Level::Best.dispatch(On((self, solver, h)))
    }
}

impl WithSimd for On<(&mut Defect<'_>, &Solver<'_, POINTS>, f64)> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) -> f64 {
        let On((Defect { system }, solver, h)) = self;
        let (at, order) = (At::shared(&solver.rule), solver.system.order);
        let (m, power) = (solver.rows.len() / 2, order.power_of(h));
        let zero = Lanes::splat(s, 0.0);
        for pass in &solver.system.passes {
            for k in 0..pass.slopes.len() {
                let row = &solver.rows[pass.first + k];
                let times = if order == Order::Second { 2 } else { 1 };
                let slopes = &solver.system.registers[pass.slopes[k]];
                let mut way = of_nodes(s, &at.integrals[times], slopes).scale_add(power, zero);
                if order == Order::Second {
                    way = Lanes::new(s, &at.places).scale_add(h * solver.rows[m + k].start.high, way);
                }
                system.registers[pass.unknowns[k]] = ((way + row.start.low) + row.start.high).nodes();
            }
        }
        let mended = solver.is_mended.then(|| &solver.geometry.hamiltonian.program);
        for pass in &system.passes {
            evaluate(s, &pass.steps, &mut system.registers, mended);
        }
        let (mut most, mut sum) = (0.0_f64, zero);
        for pass in &system.passes {
            for k in 0..pass.slopes.len() {
                let row = &solver.rows[pass.first + k];
                let slope = of_nodes(s, &at.integrals[0], &solver.system.registers[pass.slopes[k]]);
                let defect = (Lanes::new(s, &system.registers[pass.slopes[k]]) - slope).abs();
                let velocity = if order == Order::Second { h * solver.rows[m + k].size.inverse } else { 0.0 };
                let weight = larger(power * row.size.inverse, velocity);
                most = larger(most, (defect.largest() - row.foreseen) * weight);
                sum = sum + defect;
            }
        }
        // The maximum may lose a NaN, the sum does not.
        if sum.dot(Lanes::splat(s, 1.0)).is_finite() { most / (POINTS - 1) as f64 } else { f64::INFINITY }
    }
}

/// The values at the places of what has these values on the nodes.
#[inline(always)]
fn of_nodes<S: Simd>(s: S, columns: &[Nodes<PLACES>], values: &Nodes<POINTS>) -> Lanes<S, PLACES> {
    let [mut even, mut odd] = [Lanes::splat(s, 0.0); 2];
    for (columns, values) in columns.as_chunks::<2>().0.iter().zip(values.0.as_chunks::<2>().0) {
        even = Lanes::new(s, &columns[0]).scale_add(values[0], even);
        odd = Lanes::new(s, &columns[1]).scale_add(values[1], odd);
    }
    even + odd
}

#[cfg(test)]
mod tests {
    use super::super::tests::{advance, kerr, lifted, schwarzschild, well};
    use super::{Defect, Solver};
    use crate::geometry::{Geometry, Start};
    use crate::sbp::collocation::Collocation;
    use crate::sbp::legendre::Family;

    /// The largest defect of windows of these lengths.
    fn largest((geometry, start): &(Geometry, Start), h: f64, windows: usize) -> f64 {
        let mut solver = Solver::new(geometry, start, 1e9, Collocation::shared(Family::Lobatto, 16), true).unwrap();
        let mut defect = Defect::new(&solver);
        let mut look = || {
            advance(&mut solver, h);
            defect.look(&solver, h)
        };
        (0..windows).fold(0.0, |most, _| f64::max(most, look()))
    }

    /// Modes foretell the defect of windows that resolve the motion, well or just so.
    #[test]
    fn smooth_motion_has_no_unforeseen_defect() {
        let stars = lifted("(x^2 + y^2)/2 + x^2*y - y^3/3", &["x", "y"], &[0.1, 0.0], &[0.0, 0.5]);
        for (scene, unit) in [(well(), 0.5), (schwarzschild(), 8.0), (kerr(), 3.0), (stars, 0.7)] {
            for h in [0.1, 0.3, 1.0].map(|part| part * unit) {
                let found = largest(&scene, h, 30);
                assert!(found < 1e-9, "{h}: {found:e}");
            }
        }
    }

    /// A hill between two nodes, which no node sees, pushes by its slope there.
    #[test]
    fn a_feature_between_two_nodes_is_seen() {
        let nodes = &Collocation::shared(Family::Lobatto, 16).nodes;
        for gap in [2, 6, 8, 12] {
            let middle = 0.5 * (nodes[gap].high + nodes[gap + 1].high);
            let hill = |width: f64| format!("1e-3*exp(-((x - {} - {width})/{width})^2)", middle);
            let scene = lifted(&hill(2e-3), &["x"], &[0.0], &[1.0]);
            let found = largest(&scene, 1.0, 1);
            // V′ = 2e-3/e/w where V is 1/e of the hill, as a push over a fifteenth of the window.
            let push = 2e-3 / std::f64::consts::E / 2e-3 / 15.0;
            assert!((found / push - 1.0).abs() < 0.1, "{gap}: {found:e} {push:e}");
        }
    }
}
