//! What the equations leave on the nodes of a run, row by row, for any number of coordinates.

use super::rows::{corrected, derivative, handed_on, largest};
use crate::action::Form;
use crate::geometry::{Lagrangian, Samples, Source, Structure, Term, other};
use crate::norm::max_abs;
use crate::scalar::Real;
use crate::solve::Extremal;

/// How far a momentum, or a sum of momenta, is from its value at the start of the run.
#[derive(Debug, Clone)]
pub struct ChargeDeviation<S = f64> {
    /// Constants c^a of Σ c^a p_a, for the coordinates that occur.
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
    /// Largest |corrected|.
    pub max_corrected: S,
    /// Largest deviation of what the next window starts with, at the ends of the windows.
    pub max_ends: S,
}

/// The deviation of K.
#[derive(Debug, Clone)]
pub struct NormDeviation<S = f64> {
    /// K at the start.
    pub value: S,
    /// ΔK = g_ab Dq^a Dq^b − K on the nodes.
    pub delta: Vec<S>,
    /// ΔK at the end of each window, for the values that the next window starts with.
    pub ends: Vec<S>,
    /// Largest |ΔK| where charges are exact.
    pub max_interior: S,
    /// Largest |ΔK| at the ends.
    pub max_ends: S,
}

/// A run with its velocities, its metric and its momenta on the nodes.
pub(super) struct Fields<'r, S: Real, R: Extremal<S>> {
    pub(super) run: &'r R,
    /// Dq^a or D̄q^a.
    pub(super) velocities: Vec<Vec<S>>,
    /// The metric and the one-form.
    pub(super) samples: Samples<S>,
    /// F_a, empty where no force acts.
    pub(super) forces: Vec<Vec<S>>,
    /// p_a.
    momenta: Vec<Vec<S>>,
}

impl<'r, S: Real, R: Extremal<S>> Fields<'r, S, R> {
    /// Differentiates the rows of `run`, and fills in the rest.
    pub(super) fn new(run: &'r R) -> Self {
        let (lagrangian, rows) = (run.lagrangian(), run.rows());
        let (structure, points) = (lagrangian.structure(), rows[0].len());
        let n = structure.dimension;
        let velocities: Vec<Vec<S>> = (0..n).map(|a| derivative(run.grids(), rows[a], run.starts(a))).collect();
        let mut samples = lagrangian.room(points);
        lagrangian.fill(&rows, &mut samples).expect("a solution lies inside the domain");
        let mut forces = vec![Vec::new(); n];
        if !structure.force.is_empty() {
            let velocities: Vec<&[S]> = velocities.iter().map(Vec::as_slice).collect();
            let mut force = Samples::zeros(structure.force_rows, points);
            lagrangian.fill_force(&rows, &velocities, &mut force);
            for term in &structure.force {
                forces[term.a] = (0..points).map(|k| force.at(term.value, k)).collect();
            }
        }
        let mut fields = Self { run, velocities, samples, forces, momenta: Vec::new() };
        fields.momenta = (0..n).map(|a| fields.momentum(a)).collect();
        fields
    }

    fn structure(&self) -> &'r Structure<S> {
        self.run.lagrangian().structure()
    }

    /// A zero for every node.
    fn zeros(&self) -> Vec<S> {
        vec![S::ZERO; self.velocities[0].len()]
    }

    /// Changes `row` to `change(row_k, value_k q̇^b_k q̇^c_k)` at every node k, where q̇ is 1 for the one-form.
    fn fold(&self, row: &mut [S], value: Source<S>, factors: &[usize], change: impl Fn(S, S) -> S) {
        let [one, two] = [0, 1].map(|k| factors.get(k).and_then(|&b| self.velocities.get(b)));
        let at = |row: Option<&Vec<S>>, k: usize| row.map_or(S::ONE, |row| row[k]);
        // A loop for each frequent kind of term: they are most of the time that diagnostics take.
        match (value, one, two) {
            (Source::Row(g), Some(one), None) => {
                let rows = self.samples.row(g).iter().zip(one);
                row.iter_mut().zip(rows).for_each(|(sum, (&g, &v))| *sum = change(*sum, g * v));
            }
            (Source::Row(g), Some(one), Some(two)) => {
                let rows = self.samples.row(g).iter().zip(one).zip(two);
                row.iter_mut().zip(rows).for_each(|(sum, ((&g, &v), &w))| *sum = change(*sum, g * v * w));
            }
            _ => {
                for (k, sum) in row.iter_mut().enumerate() {
                    *sum = change(*sum, self.samples.at(value, k) * at(one, k) * at(two, k));
                }
            }
        }
    }

    /// p_a = g_ab q̇^b + A_a.
    fn momentum(&self, a: usize) -> Vec<S> {
        let mut row = self.zeros();
        for term in &self.structure().values {
            if let Some(b) = other(term.ab, a) {
                self.fold(&mut row, term.value, &[b], |sum, product| sum + product);
            }
        }
        row
    }

    /// f_a + F_a = ½ ∂_a g_bc q̇^b q̇^c + ∂_a A_b q̇^b + F_a.
    fn force(&self, a: usize) -> Vec<S> {
        let mut row = self.zeros();
        for &Term { ab: [b, c], value, .. } in self.structure().first.iter().filter(|term| term.by == [a]) {
            let is_square = b == c;
            self.fold(&mut row, value, &[b, c], |sum, product| sum + if is_square { product.half() } else { product });
        }
        row.iter_mut().zip(&self.forces[a]).for_each(|(sum, &force)| *sum += force);
        row
    }

    /// g_ab q̇^a q̇^b.
    fn norms(&self) -> Vec<S> {
        let mut row = self.zeros();
        for &Term { ab: [a, b], value, .. } in self.terms_of_metric() {
            match a == b {
                true => self.fold(&mut row, value, &[a, b], |sum, product| sum + product),
                false => self.fold(&mut row, value, &[a, b], |sum, product| sum + product + product),
            }
        }
        row
    }

    fn terms_of_metric(&self) -> impl Iterator<Item = &'r Term<S, 0>> {
        let structure = self.structure();
        structure.values.iter().filter(|term| term.ab[1] < structure.dimension)
    }

    /// The deviation of Σ c^a p_a.
    pub(super) fn charge(&self, terms: Vec<(usize, S)>) -> ChargeDeviation<S> {
        let (run, start) = (self.run, self.run.start());
        let value = terms.iter().fold(S::ZERO, |sum, &(a, c)| sum + c * start.p[a]);
        let mut delta = self.zeros();
        for &(a, c) in &terms {
            delta.iter_mut().zip(&self.momenta[a]).for_each(|(sum, &p)| *sum += c * p);
        }
        delta.iter_mut().for_each(|delta| *delta -= value);
        let mut ends = vec![-value; run.grids().len()];
        for &(a, c) in &terms {
            ends.iter_mut().zip(run.end_momenta(a)).for_each(|(sum, p)| *sum += c * p);
        }
        let mut shares: Vec<Option<S>> = Vec::new();
        for &(a, c) in &terms {
            let of_a = run.kappas(a).map(|kappa| Some(c * kappa?));
            match shares.is_empty() {
                true => shares = of_a.collect(),
                false => shares.iter_mut().zip(of_a).for_each(|(sum, share)| *sum = sum.zip(share).map(|(s, t)| s + t)),
            }
        }
        let corrected = corrected(run.grids(), &delta, shares.into_iter());
        ChargeDeviation {
            max_interior: largest(&delta, run.grids().map(|grid| grid.exact())),
            max_last: largest(&delta, run.grids().map(|grid| grid.last())),
            max_corrected: max_abs(&corrected),
            max_ends: max_abs(&ends),
            terms,
            value,
            delta,
            corrected,
        }
    }

    /// The deviation of K.
    pub(super) fn norm(&self) -> NormDeviation<S> {
        let (run, start) = (self.run, self.run.start());
        let value = run.lagrangian().norm(&start.q, &start.q_dot);
        let mut delta = self.norms();
        delta.iter_mut().for_each(|delta| *delta -= value);
        let ends: Vec<S> = run.end_norms(&self.samples).map(|norm| norm - value).collect();
        NormDeviation {
            max_interior: largest(&delta, run.grids().map(|grid| grid.exact())),
            max_ends: max_abs(&ends),
            value,
            delta,
            ends,
        }
    }

    /// ΔG_a = (Dp_a) − f_a − F_a on the nodes, in the weak form with D̄ and the initial momenta; divided by the constant
    /// g_aa if a is a coordinate of a potential, so that it is a deviation of d²q^a/dγ².
    pub(super) fn residual(&self, a: usize) -> Vec<S> {
        let mut residual = derivative(self.run.grids(), &self.momenta[a], self.run.start_momenta(a));
        residual.iter_mut().zip(self.force(a)).for_each(|(residual, force)| *residual += -force);
        if let Some(inertia) = self.structure().inertia(a) {
            let scale = S::ONE / inertia;
            // The sum with 0 takes the sign away from a zero.
            residual.iter_mut().for_each(|residual| *residual = S::ZERO + scale * *residual);
        }
        residual
    }

    /// The largest |ΔG_a| over the nodes whose row of D does not reach the last node of the window (weak: all nodes).
    pub(super) fn max_residual(&self, residual: &[S]) -> S {
        largest(residual, self.run.grids().map(|grid| grid.uncoupled()))
    }

    /// dq^a/dγ on the nodes: Dq^a, and at the last node of a window in the strong form, where D takes up the defect,
    /// what the next window starts with.
    pub(super) fn tangent(&self, a: usize) -> Vec<S> {
        tangent(self.run, a, &self.velocities[a])
    }

    /// The largest of Σ |g_ab Dq^a Dq^b| without its largest term, where charges are exact: what motion contributes to
    /// K.
    pub(super) fn motion(&self) -> f64 {
        let structure = self.structure();
        let motion = |k: usize| structure.motion(&self.samples, |a| self.velocities[a][k], k);
        let motion: Vec<S> = (0..self.velocities[0].len()).map(motion).collect();
        largest(&motion, self.run.grids().map(|grid| grid.exact())).to_f64()
    }
}

/// The row Dq^a of a run as dq^a/dγ, see [`Fields::tangent`].
pub(super) fn tangent<S: Real>(run: &impl Extremal<S>, a: usize, velocity: &[S]) -> Vec<S> {
    match run.form() {
        Form::Weak => velocity.to_vec(),
        Form::Strong => handed_on(run.grids(), velocity.to_vec(), run.end_velocities(a)),
    }
}
