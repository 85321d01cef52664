//! The quantities that a case watches beside charges and K: its invariants, Newton's energy, the work of a force.

use std::borrow::Cow;

use super::deviations::{Fields, NormDeviation};
use crate::action::Form;
use crate::geometry::{Observable, Start};
use crate::number::norm::max_abs;
use crate::number::{Real, sum};
use crate::solve::{Joint, WorldLine};

/// An invariant, which a user wants to see conserved.
#[derive(Debug, Clone)]
pub struct InvariantDeviation<S = f64> {
    /// Its name.
    pub name: String,
    /// Its value at the start.
    pub value: S,
    /// The deviation on the nodes. At the last node of a window in the strong form it is that of the values that are
    /// handed on.
    pub delta: Vec<S>,
    /// The largest of these.
    pub max: S,
    /// Largest deviation of what the next window starts with, at the ends of the windows.
    pub max_ends: S,
}

/// The energy of a space-time that is the lift of Newton's law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyDeviation<S = f64> {
    /// The charge p_t/p_s at the start.
    pub value: S,
    /// Largest difference between ½mv² + V and the charge on the nodes.
    pub max: S,
    /// The same at the ends of the windows.
    pub max_ends: S,
}

/// The balance of a charge that a force changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorkBalance<S = f64> {
    /// The coordinate a.
    pub coordinate: usize,
    /// Σ_k H_k F_a, summed over the windows.
    pub work: S,
    /// p_a at the end − p_a at the start − work.
    pub defect: S,
}

/// The states on the nodes of a run, row by row.
pub(super) struct States<'r, S: Real> {
    q: Vec<Vec<S>>,
    q_dot: Vec<Cow<'r, [S]>>,
    p: Vec<Vec<S>>,
}

impl<'r, S: Real> States<'r, S> {
    /// Those of a run with this tangent.
    pub(super) fn new(line: &WorldLine<S>, q_dot: Vec<Cow<'r, [S]>>) -> Self {
        let q: Vec<Vec<S>> = (0..q_dot.len()).map(|a| line.q(a).collect()).collect();
        let positions: Vec<&[S]> = q.iter().map(Vec::as_slice).collect();
        let velocities: Vec<&[S]> = q_dot.iter().map(|row| &**row).collect();
        let p = line.geometry().rows_of_momenta(&positions, &velocities);
        Self { q, q_dot, p }
    }

    /// Writes the state on a node into `state`.
    fn get(&self, node: usize, state: &mut Start<S>) {
        state.q.iter_mut().zip(&self.q).for_each(|(value, row)| *value = row[node]);
        state.q_dot.iter_mut().zip(&self.q_dot).for_each(|(value, row)| *value = row[node]);
        state.p.iter_mut().zip(&self.p).for_each(|(value, row)| *value = row[node]);
    }
}

impl<S: Real> InvariantDeviation<S> {
    /// Joins the measures of the first part of a run, `self`, and of its second part, `next`, whose rows are kept.
    pub(super) fn followed_by(self, next: Self) -> Self {
        let (max, max_ends) = (max_abs(&[self.max, next.max]), max_abs(&[self.max_ends, next.max_ends]));
        Self { max, max_ends, ..next }
    }

    /// Measures a formula with this name on a run, which has these states on its nodes and starts with the norm `k`.
    pub(super) fn new(
        line: &WorldLine<S>,
        states: &States<'_, S>,
        (name, invariant): &mut (String, Observable<S>),
        k: S,
    ) -> Self {
        let start = &line.place.start;
        let value = invariant.at(&start.q, &start.q_dot, &start.p, k);
        let mut here = Start::clone(start);
        let mut at = |node: usize| {
            states.get(node, &mut here);
            invariant.at(&here.q, &here.q_dot, &here.p, k) - value
        };
        let delta: Vec<S> = (0..line.nodes()).map(&mut at).collect();
        let ends = line.views().map(|view| view.end);
        let ends: Vec<S> = ends.map(|end| invariant.at(end.q, &line.velocities(end), end.p, k) - value).collect();
        Self { name: name.clone(), value, max: max_abs(&delta), delta, max_ends: max_abs(&ends) }
    }
}

impl<S: Real> EnergyDeviation<S> {
    /// Measures the energy of a run of Newton's law, and makes its row on the nodes.
    pub(super) fn new(line: &WorldLine<S>, norm: &NormDeviation<S>, t_dot: &[S]) -> (Self, Vec<S>) {
        let (geometry, start) = (line.geometry(), &line.place.start);
        let of = |end: Joint<'_, S>| {
            let q_dot = line.velocities(end);
            energy_off(start, geometry.norm(end.q, &q_dot), q_dot[0])
        };
        let ends: Vec<S> = line.views().map(|view| of(view.end)).collect();
        let deviations = norm.delta.iter().zip(t_dot);
        let delta: Vec<S> = deviations.map(|(&delta, &t_dot)| energy_off(start, norm.value + delta, t_dot)).collect();
        let value = start.p[0] / start.p[start.p.len() - 1];
        (Self { value, max: max_abs(&delta), max_ends: max_abs(&ends) }, delta)
    }

    pub(super) fn followed_by(self, next: Self) -> Self {
        Self {
            value: next.value,
            max: max_abs(&[self.max, next.max]),
            max_ends: max_abs(&[self.max_ends, next.max_ends]),
        }
    }
}

impl<S: Real> WorkBalance<S> {
    /// The sums over a run, from those over its first part, `self`, and its second part, `next`.
    pub(super) fn followed_by(self, next: Self) -> Self {
        Self { coordinate: next.coordinate, work: self.work + next.work, defect: self.defect + next.defect }
    }
}

/// In the lift of Newton's law: what the energy of positions and velocities differs by from p_t/p_s where K, which is 0
/// on a world-line, has this value.
pub(crate) fn energy_off<S: Real>(start: &Start<S>, k: S, t_dot: S) -> S {
    let p_s = start.p[start.p.len() - 1];
    -k / ((p_s + p_s) * t_dot)
}

/// The work of the force on coordinates that the Lagrangian does not depend on.
pub(super) fn work<S: Real>(fields: &Fields<'_, S>) -> Vec<WorkBalance<S>> {
    let line = fields.run;
    let structure = line.geometry().structure();
    let depends = |a: usize| structure.first.iter().any(|term| term.by == [a]);
    let forced = structure.force.iter().map(|term| term.a).filter(|&a| !depends(a));
    // In the strong form the equations hold at all nodes but the last, and no sum of them is the whole work.
    let forced = forced.filter(|_| line.form == Form::Weak);
    forced
        .map(|coordinate| {
            let force = &fields.forces[coordinate];
            let work = sum(line.grids().map(|grid| grid.sbp().integrate(&force[grid.nodes()])));
            let gained = line.last_joint().p[coordinate] - line.joint(0).p[coordinate];
            WorkBalance { coordinate, work: line.signed(work), defect: line.signed(gained - work) }
        })
        .collect()
}
