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

/// Both branches. In the physical limit they are the same, and there is one state.
pub(super) struct BothStates<S> {
    forward: BranchState<S>,
    backward: Option<BranchState<S>>,
}

impl<S: Real> BothStates<S> {
    /// All zero, to look at the structure.
    pub(super) fn zeros(lagrangian: &Geometry<S>, points: usize) -> Self {
        Self { forward: BranchState::zeros(lagrangian, points), backward: None }
    }

    /// Evaluates both branches of `u`.
    pub(super) fn new(
        lagrangian: &Geometry<S>,
        bars: &[RegularisedOperator<'_, S>],
        u: &Unknowns<'_, S>,
    ) -> Result<Self, OutsideGeometry> {
        let evaluated = |branch: &[&[S]]| {
            let mut state = BranchState::zeros(lagrangian, branch[0].len());
            state.evaluate(lagrangian, bars, branch).map(|()| state)
        };
        let [one, two] = &u.branches;
        let forward = evaluated(one)?;
        let is_same = |(one, two): (&&[S], &&[S])| std::ptr::eq(*one, *two) || one == two;
        let backward = if one.iter().zip(two).all(is_same) { None } else { Some(evaluated(two)?) };
        Ok(Self { forward, backward })
    }

    /// Returns true if both branches are the same.
    pub(super) fn are_equal(&self) -> bool {
        self.backward.is_none()
    }

    /// Forward (0) or backward (1).
    pub(super) fn get(&self, branch: usize) -> &BranchState<S> {
        self.backward.as_ref().filter(|_| branch == 1).unwrap_or(&self.forward)
    }
}
