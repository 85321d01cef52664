//! Hamiltonians that are known in fewer operations than inverses of metrics give: those of presets, and of Newton's
//! law.

use std::collections::BTreeMap;

use super::parts::Scope;
use super::text::Tau;
use crate::formula::{self, Names, NodeId};
use crate::number::Real;

impl<S: Real> Scope<'_, S> {
    /// H of a metric with the one-form, `tau` and Ω, from that of the metric alone.
    pub(super) fn hamiltonian(
        &mut self,
        text: &str,
        one_form: &BTreeMap<usize, NodeId>,
        tau: Option<Tau>,
        omega: Option<NodeId>,
    ) -> NodeId {
        let n = self.all;
        let momenta: Vec<String> = self.coordinates.iter().map(|name| format!("p_{name}")).collect();
        let mut variables = vec![""; 3 * n];
        for (a, (name, momentum)) in self.coordinates.iter().zip(&momenta).enumerate() {
            (variables[a], variables[2 * n + a]) = (name, momentum);
        }
        let (parameters, definitions) = (&self.parameters, &self.definitions);
        let names = Names { variables: &variables, parameters, definitions, tables: self.tables };
        let alone = formula::parse(text, names, self.graph).expect("the formulas of presets are correct");
        let mut kinetic: Vec<NodeId> = (0..3 * n).map(|variable| self.graph.variable(variable)).collect();
        for (&a, &component) in one_form {
            kinetic[2 * n + a] = self.graph.subtract(kinetic[2 * n + a], component);
        }
        let mut terms = self.graph.substitute(&[alone], &kinetic);
        if let Some(tau) = tau {
            let factor = self.graph.constant(tau.component::<S>().half());
            let square = self.graph.power_integer(kinetic[3 * n - 1], 2);
            terms.push(self.graph.multiply(factor, square));
        }
        if let Some(omega) = omega {
            terms.iter_mut().for_each(|term| *term = self.graph.divide(*term, omega));
            // What Ω and H have in common is left out before there are derivatives.
            terms = self.graph.reduced(&terms, |_| 1);
        }
        terms.into_iter().reduce(|sum, term| self.graph.add(sum, term)).expect("there is one at least")
    }

    /// H = (p_t p_s − V p_s² − Σ (p_a + A_a p_s)²/2m_a)/Ω of Newton's law, from the metric without Ω.
    pub(super) fn lift(&mut self, metric: &BTreeMap<[usize; 2], NodeId>, omega: Option<NodeId>) -> NodeId {
        let n = self.all;
        let p: Vec<NodeId> = (2 * n..3 * n).map(|variable| self.graph.variable(variable)).collect();
        let mut sum = self.graph.multiply(p[0], p[n - 1]);
        let half = self.graph.constant(S::ONE.half());
        for (a, &p_a) in p[..n - 1].iter().enumerate() {
            let Some(&g_aa) = metric.get(&[a, a]) else { continue };
            let (factor, kinetic) = match (a, metric.get(&[0, a])) {
                (0, _) => (self.graph.multiply(half, g_aa), p[n - 1]),
                (_, None) => (self.graph.divide(half, g_aa), p_a),
                (_, Some(&g_ta)) => {
                    let product = self.graph.multiply(g_ta, p[n - 1]);
                    (self.graph.divide(half, g_aa), self.graph.subtract(p_a, product))
                }
            };
            let square = self.graph.power_integer(kinetic, 2);
            let term = self.graph.multiply(factor, square);
            sum = if a == 0 { self.graph.subtract(sum, term) } else { self.graph.add(sum, term) };
        }
        omega.map_or(sum, |omega| self.graph.divide(sum, omega))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Geometry, GeometryText, Law, MetricText, PotentialText};

    fn rates(text: &GeometryText) -> Vec<f64> {
        let geometry: Geometry = Geometry::new(text).unwrap();
        let mut point = geometry.point();
        point.evaluate(&[0.1, 1.2, -0.7, 0.3], &[-0.4, 0.6, 1.1, 0.9]).unwrap();
        let velocities = (0..4).map(|a| point.q_dot(a));
        velocities.chain((0..2).map(|place| point.p_dot(place))).collect()
    }

    #[test]
    fn rates_of_the_lift_are_those_of_its_metric() {
        let owned = |texts: &[&str]| texts.iter().map(|&text| text.to_owned()).collect::<Vec<_>>();
        for conformal in [None, Some("1 + x^2".to_owned())] {
            let potential = PotentialText {
                coordinates: owned(&["x", "y"]),
                expression: "x^2*y - y/x".to_owned(),
                masses: owned(&["2", "3"]),
                mass: "1".to_owned(),
                c: "1".to_owned(),
                law: Law::Newtonian,
                one_form: vec![(0, "y^2".to_owned()), (1, "x*y".to_owned())],
                conformal: conformal.clone(),
                ..PotentialText::default()
            };
            let components = [
                ([0, 0], "2*(x^2*y - y/x)"),
                ([0, 1], "-y^2"),
                ([0, 2], "-x*y"),
                ([0, 3], "1"),
                ([1, 1], "-2"),
                ([2, 2], "-3"),
            ];
            let metric = MetricText {
                coordinates: owned(&["t", "x", "y", "s"]),
                components: components.map(|(pair, text)| (pair, text.to_owned())).to_vec(),
                conformal,
                ..MetricText::default()
            };
            let [one, other] = [GeometryText::Potential(potential), GeometryText::Metric(metric)].map(|t| rates(&t));
            let is_near = |(one, other): (&f64, &f64)| (one - other).abs() <= 1e-14 * other.abs().max(1.0);
            assert!(one.iter().zip(&other).all(is_near), "{one:?} {other:?}");
        }
    }
}
