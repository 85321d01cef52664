//! The rates of a motion at one place, as windows compute them: products are rounded with sums where the machine can.

use super::kernel::Evaluate;
use crate::formula::Step;
use crate::geometry::Geometry;
use crate::number::vector::{Level, Nodes};

/// Places that are computed side by side, of which one is used.
const LANES: usize = 8;

/// Room to compute rates in.
#[derive(Debug)]
pub(crate) struct Rates {
    registers: Vec<Nodes<LANES>>,
    steps: Box<[Step]>,
}

impl Rates {
    /// For this geometry, which is the same in every call.
    pub(crate) fn new(geometry: &Geometry) -> Self {
        Self::with_constants(geometry, |constant| constant)
    }

    /// The rates of formulas whose constants are others.
    pub(super) fn with_constants(geometry: &Geometry, other: impl Fn(f64) -> f64) -> Self {
        let equations = &geometry.hamiltonian;
        let outputs = equations.velocities.iter().chain(&equations.forces);
        Self {
            registers: equations.program.registers(|constant| Nodes([other(constant); LANES])),
            steps: equations.program.schedule(outputs.copied(), |_| false),
        }
    }

    /// q̇^a of all coordinates, and then ṗ_a of all, 0 where nothing depends on one.
    pub(crate) fn at(&mut self, geometry: &Geometry, q: &[f64], p: &[f64]) -> Vec<f64> {
        let (n, equations) = (q.len(), &geometry.hamiltonian);
        q.iter().enumerate().for_each(|(a, &q)| self.registers[a] = Nodes([q; LANES]));
        p.iter().enumerate().for_each(|(a, &p)| self.registers[2 * n + a] = Nodes([p; LANES]));
        Level::Best.dispatch(Evaluate { registers: &mut self.registers, steps: &self.steps });
        let mut rates: Vec<f64> = equations.velocities.iter().map(|&register| self.registers[register].0[0]).collect();
        rates.resize(2 * n, 0.0);
        let forces = geometry.active().iter().zip(&equations.forces);
        forces.for_each(|(&a, &register)| rates[n + a] = self.registers[register].0[0]);
        rates
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{kerr, lifted, schwarzschild};
    use super::*;

    #[test]
    fn rates_are_those_of_a_point() {
        let well = lifted("x^4/2 + sin(3*x)", &["x"], &[0.7], &[0.3]);
        for (geometry, start) in [kerr(), schwarzschild(), well] {
            let (n, mut point) = (start.q.len(), geometry.point());
            point.evaluate(&start.q, &start.p).unwrap();
            let found = Rates::new(&geometry).at(&geometry, &start.q, &start.p);
            let near = |found: f64, known: f64| (found - known).abs() <= 1e-13 * (1.0 + known.abs());
            (0..n).for_each(|a| assert!(near(found[a], point.q_dot(a)), "{a}"));
            let active = geometry.active().iter().enumerate();
            active.for_each(|(place, &a)| assert!(near(found[n + a], point.p_dot(place)), "{a}"));
        }
    }
}
