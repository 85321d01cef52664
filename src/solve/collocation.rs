//! The collocation system of the active coordinates as a banded Newton iteration in (q, p*).

use super::derivative::FormDerivative;
use super::explicit;
use super::newton::{self, Failure, LinearFailure, NewtonSystem, Root, RoundingLevels};
use super::refinement::{self, Refined};
use super::status::{InitialGuess, IterationRecord};
use super::window::Window;
use crate::geometry::{Motion, Term};
use crate::linalg::banded::solve_banded;
use crate::number::Real;
use crate::number::norm::max_abs;

/// A solution of the collocation system, with what it was found from.
pub(super) struct Solved<S> {
    /// q^a of all coordinates, where ignorable ones are still what they are at the start.
    pub(super) q: Vec<Vec<S>>,
    /// p*_a of the active coordinates.
    pub(super) p: Vec<Vec<S>>,
    /// h q̇^a of the ignorable coordinates.
    pub(super) steps: Vec<Vec<S>>,
    pub(super) history: Vec<IterationRecord>,
    pub(super) initial_guess: InitialGuess,
}

/// Solves the system of `window`; `rough` is the same in `f64`.
pub(super) fn solve<S: Real, G: Motion<S>, R: Motion<f64, Outside = G::Outside>>(
    window: &Window<'_, S, G>,
    rough: &Window<'_, f64, R>,
    max_iterations: usize,
) -> Result<Solved<S>, Failure<G::Outside>> {
    if window.geometry.active().is_empty() {
        let mut system = System::new(window, Vec::new());
        let steps = system.steps();
        return Ok(Solved { q: system.q, p: system.p, steps, history: Vec::new(), initial_guess: InitialGuess::None });
    }
    let (mut guess, initial_guess) = explicit::guess(rough).map_err(explicit::outside)?;
    let mut linearised = System::new(rough, Vec::new());
    guess.drain(..rough.derivative().first_unknown() * linearised.fields());
    let root = newton::solve(&mut linearised, guess, max_iterations)?;
    if S::IS_EXTENDED {
        let residual = System::new(window, linearised.scales.clone());
        let mut refined = RefinedSystem { residual, linearised };
        let Root { unknowns, history } = refinement::refine(&mut refined, root, window.digits, max_iterations)?;
        let mut system = refined.residual;
        system.evaluate(&unknowns).map_err(explicit::outside)?;
        let steps = system.steps();
        return Ok(Solved { q: system.q, p: system.p, steps, history, initial_guess });
    }
    // The system was evaluated last at its root.
    let in_s = |rows: Vec<Vec<f64>>| rows.into_iter().map(|row| row.into_iter().map(S::from).collect()).collect();
    let steps = in_s(linearised.steps());
    Ok(Solved { q: in_s(linearised.q), p: in_s(linearised.p), steps, history: root.history, initial_guess })
}

/// Entries of the Jacobian, divided by this, stay far from overflow.
const LEAST_SCALE: f64 = 1e-280;
/// A force counts at least as this share of its terms: a residual at the rounding level is that many times larger.
const CANCELLED: f64 = 1e-2;

/// Rows (h du/dγ − h u̇)/s in the unknowns (q_1 … q_m, p_1 … p_m) of one node after the other: at nodes 1 … N−1 for
/// nodes 2 … N in the strong form, at all nodes for all in the weak one.
struct System<'w, S: Real, G: Motion<S>> {
    window: Window<'w, S, G>,
    /// Set at the first residual if they are not given.
    scales: Vec<f64>,
    // What was evaluated last: the fields on all N nodes, their rates and their slopes. Kept, because at a million
    // nodes fresh memory costs more than the arithmetic.
    q: Vec<Vec<S>>,
    p: Vec<Vec<S>>,
    rates: Vec<Vec<S>>,
    slopes: Vec<Vec<S>>,
    room: G::Room,
}

impl<'w, S: Real, G: Motion<S>> System<'w, S, G> {
    fn new(window: &Window<'w, S, G>, scales: Vec<f64>) -> Self {
        let (points, geometry) = (window.points(), window.geometry);
        let m = geometry.active().len();
        Self {
            window: *window,
            scales,
            q: window.start.q.iter().map(|&q| vec![q; points]).collect(),
            p: geometry.active().iter().map(|&a| vec![window.start.p[a]; points]).collect(),
            rates: vec![vec![S::ZERO; points]; 2 * m],
            slopes: vec![vec![S::ZERO; points]; 2 * m],
            room: geometry.motion_room(),
        }
    }

    /// Number of fields at a node, 2m.
    fn fields(&self) -> usize {
        self.slopes.len()
    }

    fn derivative(&self) -> FormDerivative<'w, S> {
        self.window.derivative()
    }

    fn active(&self) -> &'w [usize] {
        self.window.geometry.active()
    }

    /// Updates the fields and their rates to the unknowns `u`.
    fn evaluate(&mut self, u: &[S]) -> Result<(), G::Outside> {
        let (first, fields) = (self.derivative().first_unknown(), self.fields());
        for (place, &a) in self.active().iter().enumerate() {
            let (q, p) = (&mut self.q[a][first..], &mut self.p[place][first..]);
            for ((state, q), p) in u.chunks_exact(fields).zip(q).zip(p) {
                (*q, *p) = (state[place], state[fields / 2 + place]);
            }
        }
        let start = &self.window.start.p;
        self.window.geometry.rates(&self.q, &self.p, start, &mut self.room, &mut self.rates)
    }

    /// Sets the divisor of each kind of row, so that one rounding level holds for all: the size of the field plus its
    /// change in a step, at what was evaluated last.
    fn set_scales(&mut self) {
        let (m, h) = (self.active().len(), self.window.sbp.spacing().to_f64());
        // On a circular orbit a force is what is left of terms that cancel, and rounds like these.
        let terms = self.force_terms();
        let scale = |field: usize, row: &[S], cancelled: f64| {
            match (max_abs(row).to_f64() + h * max_abs(&self.rates[field]).to_f64()).max(CANCELLED * h * cancelled) {
                // At rest without any force there is no scale.
                0.0 => 1.0,
                scale => f64::max(scale, LEAST_SCALE),
            }
        };
        let positions = self.active().iter().enumerate().map(|(place, &a)| scale(place, &self.q[a], 0.0));
        let momenta = self.active().iter().enumerate().map(|(place, &a)| scale(m + place, &self.p[place], terms[a]));
        self.scales = positions.chain(momenta).collect();
    }

    /// Σ |½ ∂_a g_bc q̇^b q̇^c| + Σ |∂_a A_b q̇^b| at the start.
    fn force_terms(&self) -> Vec<f64> {
        let (start, geometry) = (self.window.start, self.window.geometry);
        let samples = geometry.sample_at(&start.q);
        let velocity = |b: usize| start.q_dot.get(b).copied().unwrap_or(S::ONE);
        let mut terms = vec![0.0; start.q.len()];
        for &Term { ab: [b, c], by: [a], value } in &geometry.structure().first {
            let product = (samples.at(value, 0) * velocity(b) * velocity(c)).abs().to_f64();
            terms[a] += if b == c { 0.5 * product } else { product };
        }
        terms
    }

    /// h q̇^a of the ignorable coordinates at what was evaluated last.
    fn steps(&mut self) -> Vec<Vec<S>> {
        let Window { sbp, start, geometry, .. } = self.window;
        geometry.steps(&self.q, &self.p, &start.p, sbp.spacing(), &mut self.room)
    }

    /// `out` = F(u).
    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), G::Outside> {
        self.evaluate(u)?;
        if self.scales.is_empty() {
            self.set_scales();
        }
        let (h, derivative, fields) = (self.window.sbp.spacing(), self.derivative(), self.fields());
        let start = self.window.start;
        for (place, &a) in self.active().iter().enumerate() {
            derivative.apply(&self.q[a], start.q[a], &mut self.slopes[place]);
            derivative.apply(&self.p[place], start.p[a], &mut self.slopes[fields / 2 + place]);
        }
        for (field, (slopes, rates)) in self.slopes.iter().zip(&self.rates).enumerate() {
            let scale = S::from(self.scales[field]);
            for ((rows, &slope), &rate) in out.chunks_exact_mut(fields).zip(slopes).zip(rates) {
                rows[field] = h * (slope - rate) / scale;
            }
        }
        Ok(())
    }

    /// The rows are scaled so that one level holds for all.
    fn rounding(&self, u: &[S]) -> RoundingLevels {
        vec![(0..u.len(), self.window.sbp.row_sum() * S::EPSILON.to_f64())]
    }

    /// The largest absolute value of each field.
    fn sizes(&self, u: &[S]) -> Vec<S> {
        let mut sizes = vec![S::ZERO; self.fields()];
        for state in u.chunks_exact(self.fields()) {
            sizes.iter_mut().zip(state).for_each(|(size, value)| *size = size.max(value.abs()));
        }
        sizes
    }
}

impl<G: Motion<f64>> System<'_, f64, G> {
    /// Overwrites `right` with J⁻¹ `right` for the Jacobian J at what was evaluated last.
    fn solve_linearised(&mut self, right: &mut [f64]) -> Result<(), LinearFailure> {
        let (h, derivative, fields) = (self.window.sbp.spacing(), self.derivative(), self.fields());
        let (first, (lower, upper)) = (derivative.first_unknown(), derivative.reach());
        // Rows of node k stand beside the unknowns of node k + first, so their coupling to the fields of node k reaches
        // (first + 1) nodes, less one field, below the diagonal, and above it only if first is 0.
        let lower = (fields * lower).max(fields * (first + 1) - 1);
        let upper = (fields * upper).max(if first == 0 { fields - 1 } else { 0 });
        let Self { window, scales, q, p, room, .. } = self;
        let geometry = window.geometry;
        let (mut here, mut momenta) = (window.start.q.clone(), window.start.p.clone());
        let mut jacobian = vec![0.0; fields * fields];
        solve_banded(lower, upper, right, |index, row| {
            row.fill(0.0);
            let (k, field) = (index / fields, index % fields);
            if field == 0 && k >= first {
                for (place, &a) in geometry.active().iter().enumerate() {
                    (here[a], momenta[a]) = (q[a][k], p[place][k]);
                }
                jacobian.fill(0.0);
                let see = |row: usize, column: usize, value| jacobian[row * fields + column] = value;
                geometry.jacobian(&here, &momenta, k, room, see);
            }
            let scale = scales[field];
            derivative.row(k).for_each(|(column, d)| row[fields * column + field + lower - index] += h * d / scale);
            // In the strong form the first node is given: it has no unknowns to couple to.
            if k >= first {
                for (other, &coupling) in jacobian[field * fields..][..fields].iter().enumerate() {
                    if coupling != 0.0 {
                        row[fields * (k - first) + other + lower - index] -= h * coupling / scale;
                    }
                }
            }
        })
        .map_err(|_| LinearFailure)
    }
}

impl<G: Motion<f64>> NewtonSystem for System<'_, f64, G> {
    type Outside = G::Outside;

    fn residual(&mut self, u: &[f64], out: &mut [f64]) -> Result<(), G::Outside> {
        System::residual(self, u, out)
    }

    fn rounding(&self, u: &[f64]) -> Option<RoundingLevels> {
        Some(System::rounding(self, u))
    }

    /// `residual` was computed last, so that the fields are those of the unknowns.
    fn newton_step(&mut self, _: &[f64], residual: &[f64], step: &mut [f64]) -> Result<(), LinearFailure> {
        for (step, r) in step.iter_mut().zip(residual) {
            *step = -r;
        }
        self.solve_linearised(step)
    }

    fn sizes(&self, u: &[f64]) -> Vec<f64> {
        System::sizes(self, u)
    }
}

/// The residual with all digits, the Jacobian at the `f64` root, eliminated anew in every round: that is cheap beside
/// an extended residual, and keeps the elimination in one pass without a stored factor L.
struct RefinedSystem<'w, S: Real, G: Motion<S>, R: Motion<f64>> {
    residual: System<'w, S, G>,
    linearised: System<'w, f64, R>,
}

impl<S: Real, G: Motion<S>, R: Motion<f64>> Refined<S> for RefinedSystem<'_, S, G, R> {
    type Outside = G::Outside;

    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), G::Outside> {
        self.residual.residual(u, out)
    }

    fn solve_linearised(&mut self, right: &mut [f64]) -> Result<(), LinearFailure> {
        self.linearised.solve_linearised(right)
    }

    fn rounding(&self, u: &[S]) -> Option<RoundingLevels> {
        Some(self.residual.rounding(u))
    }

    fn sizes(&self, u: &[S]) -> Vec<S> {
        self.residual.sizes(u)
    }
}
