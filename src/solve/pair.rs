//! The critical point of one window, in the physical limit or with both branches.

use super::collocation;
use super::critical_point;
use super::explicit;
use super::failure::NoSolution;
use super::guess::{self, Guess};
use super::newton::Failure;
use super::piece::{Piece, Problem};
use super::status::{InitialGuess, Status};
use crate::action::Form;
use crate::number::Real;

/// A window with the same in `f64`, and γ at its start.
#[derive(Clone, Copy)]
pub(super) struct Pair<'w, S> {
    pub(super) window: Problem<'w, S>,
    pub(super) rough: Problem<'w, f64>,
    pub(super) gamma: f64,
}

impl<S: Real> Pair<'_, S> {
    /// The solution of the collocation system that holds where both branches are equal. SBP21 is explicit and needs no
    /// guess; everything else is one banded system.
    pub(super) fn physical_limit(&self) -> Result<Piece<S>, NoSolution> {
        let Self { window, rough, .. } = self;
        let (piece, kind) = if window.settings.form == Form::Strong && window.sbp.is_two_step() {
            (explicit::two_step(window), InitialGuess::None)
        } else {
            if let Some(guess) = guess::by_steps(rough)
                && let Ok(piece) = collocation::solve(window, rough, &guess)
                && explicit::leap(window.geometry, &piece.q).is_none()
            {
                return Ok(piece);
            }
            // This guess follows the geodesic as closely as it needs: nothing is leapt over.
            (collocation::solve(window, rough, &self.guess()?), InitialGuess::Engine)
        };
        piece.map_err(|failure| {
            let (first, fields) = (rough.derivative().first_unknown(), 2 * window.geometry.active().len());
            // The node of a row of the residual, and the active coordinates there.
            let locate = |row: usize, u: &[f64]| {
                let (node, mut q) = (row / fields, rough.start.q.clone());
                let state = node.checked_sub(first).and_then(|unknown| u.get(unknown * fields..)?.get(..fields / 2));
                if let Some(state) = state {
                    rough.geometry.active().iter().zip(state).for_each(|(&a, &value)| q[a] = value);
                }
                (node, q)
            };
            self.no_solution(failure, kind, locate)
        })
    }

    /// The critical point of the doubled action in all its unknowns. Where Newton's method does not find one from the
    /// first guess, it starts once more, from the physical limit.
    pub(super) fn doubled(&self) -> Result<Piece<S>, NoSolution> {
        if self.window.is_at_rest() {
            let rest = self.physical_limit()?;
            return Ok(Piece { backward: rest.q.clone(), p: Vec::new(), ..rest });
        }
        let (rough, guess) = (&self.rough, self.guess()?);
        let failure = match self.doubled_from(&guess.q, &vec![0.0; rough.layout().multiplier_range().len()]) {
            Ok(piece) => return Ok(piece),
            // An unknown belongs to a node, at which the forward branch has a place.
            Err(failure) => self.no_solution(failure, InitialGuess::Engine, |unknown, u| {
                let (layout, node) = (rough.layout(), rough.layout().node(unknown));
                (node, layout.branch(u, 0).into_iter().map(|row| row[node]).collect())
            }),
        };
        let start = Pair { window: *rough, rough: *rough, gamma: self.gamma };
        let found = start.physical_limit().ok().map(|limit| self.doubled_from(&limit.q, &limit.multipliers));
        let found = found.and_then(Result::ok).ok_or(failure)?;
        Ok(Piece { initial_guess: InitialGuess::PhysicalLimit, ..found })
    }

    /// Returns the first guess of Newton's method.
    fn guess(&self) -> Result<Guess, NoSolution> {
        guess::guess(&self.rough).map_err(|(gamma, q, point)| {
            let mut outside = NoSolution::outside(self.rough.geometry, self.gamma + gamma, None, &point);
            outside.reasons.off_table = self.rough.geometry.off_table(&q);
            outside.after(InitialGuess::Engine, Vec::new())
        })
    }

    /// The critical point that Newton's method finds from equal branches with these positions.
    fn doubled_from(&self, q: &[Vec<f64>], multipliers: &[f64]) -> Result<Piece<S>, Failure> {
        let Self { window, rough, .. } = self;
        let rows: Vec<&[f64]> = q.iter().map(Vec::as_slice).collect();
        let settings = window.settings;
        let (action, layout) = (window.action(settings.regularised), window.layout());
        let guess = layout.physical_limit(&rows, multipliers);
        let limits = (settings.digits, settings.max_iterations);
        let root = critical_point::solve(&action, &rough.action(settings.regularised), guess, limits)?;
        let rows = |branch| layout.branch(&root.unknowns, branch).into_iter().map(<[S]>::to_vec).collect::<Vec<_>>();
        let (q, backward) = (rows(0), rows(1));
        let multipliers = layout.multipliers(&root.unknowns).to_vec();
        Ok(Piece {
            gradient_norm: action.gradient_norm(&root.unknowns),
            end: end_momenta(window, &q, &multipliers),
            q,
            p: Vec::new(),
            backward,
            multipliers,
            initial_guess: InitialGuess::Engine,
            history: root.history,
        })
    }

    /// Expresses a failed iteration in terms of the scene. `locate` maps an index of the residual, at the last iterate,
    /// to its node and q there.
    fn no_solution(
        &self,
        failure: Failure,
        initial_guess: InitialGuess,
        locate: impl Fn(usize, &[f64]) -> (usize, Vec<f64>),
    ) -> NoSolution {
        let Problem { geometry, sbp, start, .. } = self.rough;
        let Failure { status, unknowns, residual, outside, history } = failure;
        let gamma = |node: usize| self.gamma + sbp.node(node);
        let worst = (0..residual.len()).max_by(|&a, &b| residual[a].abs().total_cmp(&residual[b].abs()));
        let failure = match outside.filter(|_| status == Status::OutsideDomain) {
            Some(point) => NoSolution::outside(geometry, gamma(point.index), None, &point),
            None => {
                let located = worst.filter(|_| !unknowns.is_empty()).map(|row| locate(row, &unknowns));
                let (node, q) = located.unwrap_or_else(|| (0, start.q.clone()));
                NoSolution::new(status, geometry, gamma(node), &q)
            }
        };
        let residual = worst.map_or(f64::INFINITY, |index| residual[index].abs());
        NoSolution { residual, ..failure.after(initial_guess, history) }
    }
}

/// p*_a of all coordinates at the last node of a window with these positions and multipliers: p_a + κ_a/H_N where the
/// coordinate is active, −ν_a where it is ignorable. In the weak form p_a, and what it was at the start.
fn end_momenta<S: Real>(window: &Problem<'_, S>, q: &[Vec<S>], multipliers: &[S]) -> Vec<S> {
    let (layout, last, active) = (window.layout(), window.points() - 1, window.geometry.active());
    // D̄ is D at the last node.
    let slopes: Vec<S> = q.iter().map(|row| window.sbp.derivative_at(row, last)).collect();
    let end: Vec<S> = q.iter().map(|row| row[last]).collect();
    let mut p = window.geometry.momenta(&end, &slopes);
    for (a, p) in p.iter_mut().enumerate() {
        match (window.settings.form, active.contains(&a)) {
            (Form::Strong, true) => *p += multipliers[layout.kappa(a)] / window.sbp.weights()[last],
            (Form::Strong, false) => *p = -multipliers[layout.nu(a)],
            (Form::Weak, true) => {}
            (Form::Weak, false) => *p = window.start.p[a],
        }
    }
    p
}
