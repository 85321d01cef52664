//! One branch evaluated on its nodes.

use std::ops::Range;

use crate::geometry::{Contraction, Geometry, OutsideGeometry, Samples, Structure, Term};
use crate::number::Real;
use crate::sbp::{RegularisedOperator, SbpOperator};

/// A branch on its nodes: the Lagrangian's structure with its values, and the regularised velocities D̄q^a.
pub(super) struct BranchState<S> {
    pub(super) samples: Samples<S>,
    /// D̄q^a, and a row of ones if there is a one-form.
    pub(super) velocities: Samples<S>,
}

impl<S: Real> BranchState<S> {
    pub(super) fn zeros(lagrangian: &Geometry<S>, points: usize) -> Self {
        let structure = lagrangian.structure();
        let mut velocities = Samples::zeros(structure.velocities(), points);
        if structure.has_one_form {
            velocities.row_mut(structure.dimension).fill(S::ONE);
        }
        Self { samples: lagrangian.room(points), velocities }
    }

    /// Evaluates the branch at the positions `q`.
    pub(super) fn evaluate(
        &mut self,
        lagrangian: &Geometry<S>,
        bars: &[RegularisedOperator<'_, S>],
        q: &[&[S]],
    ) -> Result<(), OutsideGeometry> {
        for (bar, (q, velocity)) in bars.iter().zip(q.iter().zip(self.velocities.rows_mut())) {
            bar.apply(q, velocity);
        }
        lagrangian.fill(q, &mut self.samples)
    }

    /// F of the branch.
    pub(super) fn value(&self, values: &[Term<S, 0>], sbp: &SbpOperator<S>) -> S {
        let integrand: Vec<S> = (0..sbp.points()).map(|k| self.norm(values, k).half()).collect();
        sbp.integrate(&integrand)
    }

    /// Returns true if F overflows at no node.
    pub(super) fn is_finite(&self, values: &[Term<S, 0>]) -> bool {
        (0..self.velocities.row(0).len()).all(|k| self.norm(values, k).is_finite())
    }

    /// 2F at node k.
    #[inline]
    fn norm(&self, values: &[Term<S, 0>], k: usize) -> S {
        values.iter().fold(S::ZERO, |sum, &Term { ab: [a, b], value, .. }| {
            let product = self.samples.at(value, k) * self.velocity(a, k) * self.velocity(b, k);
            if a == b { sum + product } else { sum + product + product }
        })
    }

    #[inline]
    pub(super) fn velocity(&self, a: usize, k: usize) -> S {
        self.velocities.row(a)[k]
    }

    /// The structure with these values and velocities on some of the nodes.
    pub(super) fn contraction<'c>(
        &'c self,
        structure: &'c Structure<S>,
        nodes: Range<usize>,
    ) -> Contraction<'c, S, impl Fn(usize) -> Option<&'c [S]>> {
        let velocity = {
            let nodes = nodes.clone();
            move |b| Some(&self.velocities.row(b)[nodes.clone()])
        };
        Contraction { structure, samples: &self.samples, nodes, velocity }
    }
}

/// The state of the forward (0) or the backward (1) branch.
pub(super) fn of_branch<S>(states: &[BranchState<S>], branch: usize) -> &BranchState<S> {
    &states[branch.min(states.len() - 1)]
}
