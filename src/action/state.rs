//! One branch evaluated on its nodes.

use std::ops::Range;

use super::layout::Unknowns;
use crate::geometry::{Contraction, Geometry, OutsideGeometry, Samples, Source, Structure, Term};
use crate::number::Real;
use crate::number::norm::max_abs;
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

    /// The largest absolute value on the nodes.
    pub(super) fn size(&self, source: Source<S>) -> f64 {
        size(&self.samples, source)
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

/// The largest absolute value on the nodes.
pub(super) fn size<S: Real>(samples: &Samples<S>, source: Source<S>) -> f64 {
    match source {
        Source::Constant(value) => value.abs().to_f64(),
        Source::Row(row) => max_abs(samples.row(row)).to_f64(),
    }
}

/// The states of both branches of `u`. In the physical limit they are the same, and there is one.
pub(super) fn states<S: Real>(
    lagrangian: &Geometry<S>,
    bars: &[RegularisedOperator<'_, S>],
    Unknowns { branches: [one, two], .. }: &Unknowns<'_, S>,
) -> Result<Vec<BranchState<S>>, OutsideGeometry> {
    let is_same = |(one, two): (&&[S], &&[S])| std::ptr::eq(*one, *two) || one == two;
    let branches = if one.iter().zip(two).all(is_same) { vec![one] } else { vec![one, two] };
    let evaluated = |branch: &Vec<&[S]>| {
        let mut state = BranchState::zeros(lagrangian, branch[0].len());
        state.evaluate(lagrangian, bars, branch).map(|()| state)
    };
    branches.into_iter().map(evaluated).collect()
}

/// The state of the forward (0) or the backward (1) branch.
pub(super) fn of_branch<S>(states: &[BranchState<S>], branch: usize) -> &BranchState<S> {
    &states[branch.min(states.len() - 1)]
}
