//! The deviations of charges, of K and of what a case watches from their values at the start, and the residuals of the
//! equations, on the nodes of a run, row by row, for any number of coordinates.

use std::borrow::Cow;

use super::fields::{Fields, Weights, derivative};
use super::witnesses::{Heard, Place};
use crate::action::{Form, Layout};
use crate::geometry::{Observable, Start};
use crate::number::norm::{larger, max_abs};
use crate::number::{Real, sum};
use crate::solve::{Window, WindowNodes, WorldLine};

/// The deviation of K, of Newton's energy or of an invariant of the user from its value at the start of the run.
#[derive(Debug, Clone)]
pub struct Deviation<S = f64> {
    /// The value at the start: K, the charge p_t/p_s, or that of the formula.
    pub value: S,
    /// The deviation on the nodes. K has the velocities Dq^a there; at the last node of a window in the strong form the
    /// others have the values that are handed on.
    pub delta: Vec<S>,
    /// The deviation at the end of each window, for the values that the next window starts with.
    pub ends: Vec<S>,
    /// Largest |delta|; that of K where charges are exact.
    pub max_interior: S,
    /// Largest |ends|.
    pub max_ends: S,
    /// Where it is largest, and what may explain that.
    pub heard: Heard,
}

impl<S: Real> Deviation<S> {
    /// A deviation of which every node counts.
    pub(super) fn new(value: S, delta: Vec<S>, ends: Vec<S>, heard: Heard) -> Self {
        Self { value, max_interior: max_abs(&delta), delta, max_ends: max_abs(&ends), ends, heard }
    }

    /// The largest deviation on all nodes, and in what is handed on.
    pub fn drift(&self) -> f64 {
        larger(self.max_interior, self.max_ends).to_f64()
    }

    /// True if rounding may be all of the largest deviation: in the short windows at a kink D makes noise of that of
    /// places. At the ends of windows there are momenta in place of D.
    pub fn is_rounding(&self) -> bool {
        self.heard.most().is_some_and(|most| self.drift() <= most.rounding)
    }

    /// Joins the measures of the first part of a run, `self`, and of its second part, `next`, whose rows are kept.
    pub(super) fn followed_by(self, next: Self) -> Self {
        let max_interior = max_abs(&[self.max_interior, next.max_interior]);
        let heard = self.heard.followed_by(next.heard);
        Self { max_interior, max_ends: max_abs(&[self.max_ends, next.max_ends]), heard, ..next }
    }
}

/// The deviation of a momentum, or of a sum of momenta, from its value at the start of the run.
#[derive(Debug, Clone)]
pub struct ChargeDeviation<S = f64> {
    /// Constants c^a of Σ c^a p_a, for the coordinates that occur, with momenta as a user sees them.
    pub terms: Vec<(usize, S)>,
    /// Its value at the start.
    pub value: S,
    /// The deviation on the nodes.
    pub delta: Vec<S>,
    /// The same with the multipliers' share κ_a/H_N at the last node of each window.
    pub corrected: Vec<S>,
    /// Largest |delta| where the charge is exact: at all nodes but the last of each window (strong), or at all (weak).
    pub max_interior: S,
    /// Largest |delta| at the last node of a window.
    pub max_last: S,
    /// The deviation at the last node of the run.
    pub last: S,
    /// Largest |corrected|.
    pub max_corrected: S,
    /// Largest deviation of what the next window starts with, at the ends of the windows.
    pub max_ends: S,
    /// The largest deviation where the charge is exact, with its place, and with what may explain it.
    pub heard: Heard,
}

impl<S: Real> ChargeDeviation<S> {
    /// Joins the measures of the first part of a run, `self`, and of its second part, `next`, whose rows are kept.
    pub(super) fn followed_by(self, next: Self) -> Self {
        Self {
            max_interior: max_abs(&[self.max_interior, next.max_interior]),
            max_last: max_abs(&[self.max_last, next.max_last]),
            max_corrected: max_abs(&[self.max_corrected, next.max_corrected]),
            max_ends: max_abs(&[self.max_ends, next.max_ends]),
            heard: self.heard.followed_by(next.heard),
            ..next
        }
    }
}

impl<S: Real> Fields<'_, S> {
    /// The deviation of Σ c^a p_a; of the motion, where γ falls, and not of the reversed one.
    pub(super) fn charge(&self, terms: Vec<(usize, S)>) -> ChargeDeviation<S> {
        let (run, sign) = (self.run, |p: S| self.run.signed(p));
        let inside: Vec<_> = terms.iter().map(|&(a, c)| (a, run.geometry().seen(a, c))).collect();
        let value = inside.iter().fold(S::ZERO, |sum, &(a, c)| sum + c * run.place.start.p[a]);
        let mut delta = self.zeros();
        for &(a, c) in &inside {
            delta.iter_mut().zip(&self.momenta[a]).for_each(|(sum, &p)| *sum += c * p);
        }
        delta.iter_mut().for_each(|delta| *delta = sign(*delta - value));
        let mut corrected = delta.clone();
        for &(a, c) in &inside {
            let place = Layout::new(run.q.len(), 0, Form::Strong).kappa(a);
            for window in &run.windows {
                if let Some(&kappa) = window.multipliers.get(place) {
                    let weight = window.sbp().weights()[window.points() - 1];
                    corrected[window.nodes().end - 1] += sign(c * kappa / weight);
                }
            }
        }
        let sum_at_end =
            |view: WindowNodes<'_, S>| inside.iter().fold(-value, |sum, &(a, c)| sum + c * view.end_momentum(a));
        let ends: Vec<S> = run.views().map(sum_at_end).collect();
        ChargeDeviation {
            heard: self.heard([&delta, &ends], Weights::Constants(&inside), |_| 1.0),
            max_interior: self.largest(&delta, Window::exact),
            max_last: self.largest(&delta, |window| window.nodes().end - 1..window.nodes().end),
            last: delta.last().copied().unwrap_or(S::ZERO),
            max_corrected: max_abs(&corrected),
            max_ends: max_abs(&ends),
            value: sign(value),
            terms,
            delta,
            corrected,
        }
    }

    /// The deviation of K.
    pub(super) fn norm(&self) -> Deviation<S> {
        let (run, start) = (self.run, &self.run.place.start);
        let value = run.geometry().norm(&start.q, &start.q_dot);
        let mut delta = self.zeros();
        self.contraction().add_norm(&mut delta);
        delta.iter_mut().for_each(|delta| *delta -= value);
        let max_interior = self.largest(&delta, Window::exact);
        let [mut ends, _] = self.norms_at_ends(|view, a| view.end_momentum(a));
        ends.iter_mut().for_each(|end| *end -= value);
        let heard = self.heard([&delta, &ends], Weights::Velocities, |_| 1.0);
        Deviation { max_interior, ..Deviation::new(value, delta, ends, heard) }
    }

    /// K at the ends of all windows, where momenta are these, and dq/dγ of the first coordinate there.
    fn norms_at_ends(&self, momentum: impl Fn(&WindowNodes<'_, S>, usize) -> S) -> [Vec<S>; 2] {
        let (geometry, n) = (self.run.geometry(), self.velocities.len());
        let [mut q, mut q_dot] = [(); 2].map(|()| vec![Vec::with_capacity(self.run.windows.len()); n]);
        let (mut point, mut p) = (geometry.point(), vec![S::ZERO; n]);
        for view in self.run.views() {
            p.iter_mut().enumerate().for_each(|(a, p)| *p = momentum(&view, a));
            // A joint lies inside the domain.
            let _ = point.evaluate(view.end.q, &p);
            q.iter_mut().zip(view.end.q).for_each(|(row, &q)| row.push(q));
            q_dot.iter_mut().enumerate().for_each(|(a, row)| row.push(point.q_dot(a)));
        }
        let [of_q, of_q_dot] = [&q, &q_dot].map(|rows| rows.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let [norms, _] = geometry.norm_and_motion(&of_q, &of_q_dot);
        [norms, q_dot.swap_remove(0)]
    }

    /// ΔG_a = (Dp_a) − f_a − F_a on the nodes, in the weak form with D̄ and the initial momenta; divided by the
    /// constant g_aa if a is a coordinate of a potential, so that it is a deviation of d²q^a/dγ². Here f_a is
    /// ½ ∂_a g_bc q̇^b q̇^c + ∂_a A_b q̇^b.
    pub(super) fn residual(&self, a: usize) -> Vec<S> {
        let mut force = self.zeros();
        self.contraction().add_force(a, &mut force);
        force.iter_mut().zip(&self.forces[a]).for_each(|(sum, &force)| *sum += force);
        let mut residual = derivative(self.run, &self.momenta[a], |view| view.start.p[a]);
        residual.iter_mut().zip(force).for_each(|(residual, force)| *residual += -force);
        if let Some(inertia) = self.structure().inertia(a) {
            let scale = S::ONE / inertia;
            // The sum with 0 takes the sign away from a zero.
            residual.iter_mut().for_each(|residual| *residual = S::ZERO + scale * *residual);
        }
        residual
    }

    /// The largest of Σ |g_ab Dq^a Dq^b| without its largest term, where charges are exact: what motion contributes to
    /// K.
    pub(super) fn motion(&self) -> f64 {
        let mut motion = self.zeros();
        self.contraction().add_motion(&mut motion);
        self.largest(&motion, Window::exact).to_f64()
    }
}

/// The row Dq^a of a run as dq^a/dγ, see [`Diagnostics::tangent`](super::Diagnostics::tangent).
pub(super) fn tangent<'r, S: Real>(run: &WorldLine<S>, a: usize, velocity: &'r [S]) -> Cow<'r, [S]> {
    let mut row = Cow::Borrowed(velocity);
    if run.form == Form::Strong {
        let row = row.to_mut();
        run.views().for_each(|view| row[view.window.nodes().end - 1] = view.end_velocities()[a]);
    }
    row
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

/// Measures the formulas of the user, with their names, on a run with this tangent, which starts with the norm `k`.
pub(super) fn invariants<S: Real>(
    fields: &Fields<'_, S>,
    tangent: &[Cow<'_, [S]>],
    formulas: &mut [(String, Observable<S>)],
    k: S,
) -> Vec<(String, Deviation<S>)> {
    let line = fields.run;
    let q: Vec<Vec<S>> = (0..tangent.len()).map(|a| line.q(a).collect()).collect();
    let positions: Vec<&[S]> = q.iter().map(Vec::as_slice).collect();
    let velocities: Vec<&[S]> = tangent.iter().map(|row| &**row).collect();
    let momenta = line.geometry().rows_of_momenta(&positions, &velocities);
    let momenta: Vec<&[S]> = momenta.iter().map(Vec::as_slice).collect();
    let mut point = line.geometry().point();
    let mut of_end = |view: WindowNodes<'_, S>| -> Vec<S> {
        // A joint lies inside the domain.
        let _ = point.evaluate(view.end.q, view.end.p);
        (0..view.end.q.len()).map(|a| point.q_dot(a)).collect()
    };
    let of_ends: Vec<Vec<S>> = line.views().map(&mut of_end).collect();
    let measured = |(name, formula): &mut (String, Observable<S>)| {
        let Start { q, q_dot, p } = &*line.place.start;
        let value = formula.at(q, q_dot, p, k);
        let mut delta = fields.zeros();
        formula.along([&positions, &velocities, &momenta], k, &mut delta);
        delta.iter_mut().for_each(|here| *here -= value);
        let ends = line.views().zip(&of_ends).map(|(view, q_dot)| formula.at(view.end.q, q_dot, view.end.p, k) - value);
        let ends: Vec<S> = ends.collect();
        let heard = fields.formula_heard(&delta, [&positions, &velocities], (formula, k));
        (name.clone(), Deviation::new(value, delta, ends, heard))
    };
    formulas.iter_mut().map(measured).collect()
}

/// Measures the energy ½mv² + V of a run of Newton's law, whose charge is p_t/p_s: they differ by −K/(2 ṫ p_s).
pub(super) fn energy<S: Real>(fields: &Fields<'_, S>, norm: &Deviation<S>, t_dot: &[S]) -> Deviation<S> {
    let line = fields.run;
    let start = &line.place.start;
    let [norms, t_dots] = fields.norms_at_ends(|view, a| view.end.p[a]);
    let ends: Vec<S> = norms.into_iter().zip(t_dots).map(|(norm, t_dot)| energy_off(start, norm, t_dot)).collect();
    let nodes = norm.delta.iter().zip(t_dot);
    let delta: Vec<S> = nodes.map(|(&delta, &t_dot)| energy_off(start, norm.value + delta, t_dot)).collect();
    let of_k = |k: usize| energy_off(start, S::ONE, t_dot[k]).to_f64().abs();
    let heard = fields.heard([&delta, &ends], Weights::Velocities, of_k);
    Deviation::new(start.p[0] / start.p[start.p.len() - 1], delta, ends, heard)
}

/// In the lift of Newton's law: what the energy of positions and velocities differs by from p_t/p_s where K, which is 0
/// on a world-line, has this value.
pub(crate) fn energy_off<S: Real>(start: &Start<S>, k: S, t_dot: S) -> S {
    let p_s = start.p[start.p.len() - 1];
    -k / ((p_s + p_s) * t_dot)
}

/// The work of the force on coordinates that the Lagrangian does not depend on, and what may explain its defect: the
/// force and the momentum at the end are those of the nodes.
pub(super) fn work<S: Real>(fields: &Fields<'_, S>) -> Vec<(WorkBalance<S>, Place)> {
    let line = fields.run;
    let structure = line.geometry().structure();
    let depends = |a: usize| structure.first.iter().any(|term| term.by == [a]);
    let forced = structure.force.iter().map(|term| term.a).filter(|&a| !depends(a));
    // In the strong form the equations hold at all nodes but the last, and no sum of them is the whole work.
    let forced = forced.filter(|_| line.form == Form::Weak);
    forced
        .map(|coordinate| {
            let force = &fields.forces[coordinate];
            let work = sum(line.windows.iter().map(|window| window.sbp().integrate(&force[window.nodes()])));
            let gained = line.last_joint().p[coordinate] - line.joint(0).p[coordinate];
            let seen = |p: S| line.geometry().seen(coordinate, line.signed(p));
            let balance = WorkBalance { coordinate, work: seen(work), defect: seen(gained - work) };
            (balance, fields.balance_place(coordinate, balance.defect.to_f64().abs()))
        })
        .collect()
}
