//! Hamiltonians that are known in fewer operations than inverses of metrics give: those of presets, and of Newton's
//! law.

use std::collections::BTreeMap;

use super::parts::Scope;
use super::text::{Place, Tau};
use crate::formula::NodeId;
use crate::number::Real;

impl<S: Real> Scope<S> {
    /// H of a metric with the one-form, `tau` and Ω, from that of the metric alone.
    pub(super) fn hamiltonian(
        &mut self,
        text: &str,
        one_form: &BTreeMap<usize, NodeId>,
        tau: Option<Tau>,
        omega: Option<NodeId>,
    ) -> NodeId {
        let n = self.all;
        let alone = self.parse(text, Place::Potential, 3).expect("the formulas of presets are correct");
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
        let (s, zero) = (p[n - 1], self.graph.constant(S::ZERO));
        let mut sum = self.graph.multiply(p[0], s);
        for (a, &p) in p[..n - 1].iter().enumerate() {
            let Some(&g) = metric.get(&[a, a]) else { continue };
            let one_form = metric.get(&[0, a]).filter(|_| a > 0).map_or(zero, |&g_ta| self.graph.multiply(g_ta, s));
            let text = if a == 0 { "h - 0.5*g*s^2" } else { "h + 0.5/g*(p - a)^2" };
            sum = self.graph.written(text, &[("h", sum), ("g", g), ("s", s), ("p", p), ("a", one_form)]);
        }
        omega.map_or(sum, |omega| self.graph.divide(sum, omega))
    }
}
