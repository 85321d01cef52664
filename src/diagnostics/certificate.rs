//! The certificate as a witness: the gradient of the doubled action at the nodes, relative to the size of its terms.
//!
//! With respect to one of two equal branches it is −H ΔG_a (see [`Diagnostics::delta_g`](super::Diagnostics::delta_g)),
//! with ΔG_a = Dp_a − f_a − F_a. Errors of the coordinates change p_a as they change any sum of momenta, so that Dp_a
//! changes by at most Σ_j |D_kj| |Δp_a|_j; and they change f_a + F_a at the node itself.

use super::fields::{Fields, Room, Weights, gamma_at, row_of, row_sum};
use super::witnesses::{Heard, Place};
use crate::action::Form;
use crate::geometry::{ForceTerm, Term};
use crate::number::Real;

/// The gradient of the doubled action.
#[derive(Debug, Clone, PartialEq)]
pub struct Certificate {
    /// As the nodes have it.
    pub nodes: Heard,
    /// As it was found in solving, in the strong form: the largest one of all windows, which may change by what is the
    /// largest of all windows.
    pub(super) solved: Option<Place>,
}

impl Certificate {
    /// Joins the gradients of a part of a run, and of the next one.
    pub(super) fn followed_by(self, next: Self) -> Self {
        Self {
            nodes: self.nodes.followed_by(next.nodes),
            solved: self.solved.into_iter().chain(next.solved).reduce(Place::or),
        }
    }
}

impl<S: Real> Fields<'_, S> {
    /// The gradient that the nodes have, from the residuals `delta_g`, in every window for the coordinate whose
    /// residual is largest beside its momentum, as long as that is larger than in the windows before. Rows that reach
    /// the last node of the strong form contain multipliers, and the gradient that was found in solving stands for
    /// them.
    pub(super) fn certificate(&self, delta_g: &[Vec<S>]) -> Certificate {
        let (mut nodes, n) = (Heard::default(), delta_g.len());
        let is_strong = self.run.form == Form::Strong;
        let solved = is_strong.then(|| (0..self.run.windows.len()).map(|index| self.gradient_norm(index)));
        let solved = solved.and_then(|places| places.reduce(Place::or));
        let (mut most, inertia) = ([-1.0; 2], |a| self.structure().inertia(a).map_or(1.0, S::to_f64));
        let inertias: Vec<f64> = (0..n).map(inertia).collect();
        for (index, window) in self.run.windows.iter().enumerate() {
            let weights = window.sbp().weights();
            let (first, mut largest) = (window.nodes().start, None::<([f64; 2], (usize, usize))>);
            for (a, inertia) in inertias.iter().enumerate() {
                for k in window.uncoupled() {
                    let change = (inertia * (weights[k - first] * delta_g[a][k]).to_f64()).abs();
                    let share = if change == 0.0 { 0.0 } else { change / self.momenta[a][k].to_f64().abs() };
                    // NaN is larger than any number, and comes first.
                    let share = if share.is_nan() { f64::INFINITY } else { share };
                    if largest.is_none_or(|([most, _], _)| share.total_cmp(&most).is_ge()) {
                        largest = Some(([share, change], (a, k)));
                    }
                }
            }
            let is_more =
                |(here, _): &([f64; 2], _)| here.iter().zip(&most).any(|(here, most)| *here > *most || here.is_nan());
            if let Some((here @ [_, change], (a, k))) = largest.filter(is_more) {
                most = here;
                let weight = weights[k - window.nodes().start].to_f64();
                if nodes.keeps(change, weight * self.residual_terms(index, k, a)) {
                    nodes.see(Place { change, ..self.residual_place(index, k, a).scaled(weight) });
                }
            }
        }
        Certificate { nodes, solved }
    }

    /// The gradient that was found in solving, whose rows are those of all coordinates, and the constraints.
    fn gradient_norm(&self, index: usize) -> Place {
        let (window, n) = (&self.run.windows[index], self.velocities.len());
        let (first, middle) = (window.nodes().start, window.points() / 2);
        let of_constraints = 1.0 + row_sum(window, 0);
        let by = [vec![of_constraints; n], vec![0.0; n]].concat();
        let constraints = Place::of(gamma_at(self.run, index, first), by);
        let rows = (0..n).flat_map(|a| [0, middle].map(|k| (a, k))).map(|(a, k)| {
            let weight = window.sbp().weights()[k].to_f64();
            self.residual_place(index, first + k, a).scaled(weight)
        });
        Place { change: self.run.gradient_norm.to_f64(), ..rows.fold(constraints, Place::plus) }
    }

    /// The sizes of the terms of ΔG_a at node k of a window, as [`Self::residual_place`] has them.
    fn residual_terms(&self, index: usize, k: usize, a: usize) -> f64 {
        let (window, one, mut room) = (&self.run.windows[index], [(a, S::ONE)], Room::default());
        let first = window.nodes().start;
        let mut of = |(j, d): (usize, f64)| d.abs() * self.terms(first + j, Weights::Constants(&one), &mut room);
        row_of(window, k - first).fold(self.force_terms(k, a), |sum, entry| sum + of(entry))
    }

    /// The sizes of the terms of f_a + F_a at node k.
    fn force_terms(&self, k: usize, a: usize) -> f64 {
        let (structure, n) = (self.structure(), self.velocities.len());
        let q_dot = |b: usize| if b < n { self.velocities[b][k].to_f64() } else { 1.0 };
        let mut terms = 0.0;
        for &Term { ab: [b, c], value, .. } in structure.first.iter().filter(|term| term.by == [a]) {
            terms += (half(b, c) * self.samples.at(value, k).to_f64() * q_dot(b) * q_dot(c)).abs();
        }
        if let Some(force) = &self.force {
            let own = structure.force.iter().filter(|term| term.a == a);
            terms += own.map(|term| force.at(term.value, k).to_f64().abs()).sum::<f64>();
        }
        terms
    }

    /// What may change ΔG_a at node k of a window: D p_a, and f_a + F_a.
    fn residual_place(&self, index: usize, k: usize, a: usize) -> Place {
        let (window, one) = (&self.run.windows[index], [(a, S::ONE)]);
        let first = window.nodes().start;
        let (mut place, mut here, mut room) = (self.force_place(index, k, a), Place::default(), Room::default());
        for (j, d) in row_of(window, k - first) {
            self.look(index, first + j, Weights::Constants(&one), (&mut room, &mut here));
            here.scale(d.abs());
            place.add(&here);
        }
        Place { gamma: gamma_at(self.run, index, k), ..place }
    }

    /// By how much rounding of the place and of the velocities may change f_a + F_a at node k of a window, if something
    /// jumps there: no derivative tells.
    fn jump(&self, index: usize, k: usize, a: usize) -> f64 {
        let (n, window) = (self.velocities.len(), &self.run.windows[index]);
        let row_sum = row_sum(window, k - window.nodes().start);
        // Two points for each variable, of which it is a little larger at the first one, and smaller at the other.
        let beside = |(variable, row): (usize, &Vec<S>)| {
            let mut row = vec![row[k]; 4 * n];
            let of_place = S::EPSILON * self.run.q[variable % n][k].abs();
            let off = if variable < n { of_place } else { of_place * S::from(row_sum) };
            row[2 * variable] += off;
            row[2 * variable + 1] += -off;
            row
        };
        let rows: Vec<Vec<S>> = self.run.q.iter().chain(&self.velocities).enumerate().map(beside).collect();
        let rows: Vec<&[S]> = rows.iter().map(Vec::as_slice).collect();
        let (q, q_dot) = rows.split_at(n);
        let forces = &self.run.geometry().rows_of_forces(q, q_dot)[a];
        let changes = forces.chunks_exact(2).map(|pair| (pair[0] - pair[1]).to_f64().abs());
        changes.filter(|change| change.is_finite()).sum()
    }

    /// Errors of all coordinates at node k of a window may change f_a + F_a there, and behind them those of forces.
    fn force_place(&self, index: usize, k: usize, a: usize) -> Place {
        let (structure, n, window) = (self.structure(), self.velocities.len(), &self.run.windows[index]);
        let q_dot = |b: usize| if b < n { self.velocities[b][k].to_f64() } else { 1.0 };
        let (mut positions, mut velocities) = (vec![0.0_f64; n], vec![0.0_f64; n]);
        for &Term { ab: [b, c], value, .. } in structure.first.iter().filter(|term| term.by == [a]) {
            let g = half(b, c) * self.samples.at(value, k).to_f64();
            velocities[b] += g * q_dot(c);
            velocities.get_mut(c).into_iter().for_each(|by| *by += g * q_dot(b));
        }
        let here = self.run.geometry().at(&self.run.q.iter().map(|row| row[k]).collect::<Vec<S>>());
        for &Term { ab: [b, c], by: [one, other], value } in &structure.second {
            let g = half(b, c) * here.at(value, 0).to_f64() * q_dot(b) * q_dot(c);
            // Where a second derivative is not finite, an error may do anything.
            let g = if g.is_finite() { g } else { f64::INFINITY };
            if one == a {
                positions[other] += g;
            }
            if other == a && one != other {
                positions[one] += g;
            }
        }
        if let Some(force) = &self.force {
            for &ForceTerm { by: [variable], value, .. } in structure.force_first.iter().filter(|term| term.a == a) {
                let slope = force.at(value, k).to_f64();
                if variable < n { positions[variable] += slope } else { velocities[variable - n] += slope }
            }
        }
        let (row_sum, terms) = (row_sum(window, k - window.nodes().start), self.force_terms(k, a));
        let mut by: Vec<f64> = positions.iter().zip(&velocities).map(|(q, u)| q.abs() + row_sum * u.abs()).collect();
        let rounding = self.rounding(index, &by, structure.first.len() + 2, terms) + self.jump(index, k, a);
        by.extend((0..n).map(|b| f64::from(u8::from(b == a))));
        Place { terms, rounding, ..Place::of(gamma_at(self.run, index, k), by) }
    }
}

/// The factor of a product of two velocities in a force, ½ Σ over both orders.
fn half(b: usize, c: usize) -> f64 {
    if b == c { 0.5 } else { 1.0 }
}
