//! A window to be solved, and its critical point as a piece of a run.
//!
//! With D̄ᵀH = −HD + E_N the critical point of the doubled action is, where both branches are equal,
//!
//! ```text
//! strong    (Dq^a)_k = g^ab (p*_b − A_b),   (Dp*_a)_k = f_a + F_a    on k = 1 … N−1,    q_1 = q_i,  p*_1 = p_i
//! weak       D̄q^a    = g^ab (p_b − A_b),     D̄p_a     = f_a + F_a    on all nodes
//! ```
//!
//! with λ_a = μ_a = 0, κ_a = H_N (p*_a − p_a)[N] and ν_a = (HDp*_a − H(f_a + F_a))_N − p*_a[N] in the strong form. An
//! ignorable p*_a is constant. Only active coordinates are unknowns; ignorable ones are integrals afterwards.

use super::grid::FormDerivative;
use super::setup::Settings;
use super::status::{InitialGuess, IterationRecord};
use crate::action::{DoubledAction, Form, Layout};
use crate::geometry::{Geometry, Point, Start};
use crate::number::Real;
use crate::sbp::SbpOperator;

/// A window to be solved: operator, geometry and start. Ignorable coordinates are counted from its start, so that no
/// digit of their increments is lost.
#[derive(Debug, Clone, Copy)]
pub(super) struct Problem<'w, S> {
    pub(super) settings: &'w Settings,
    pub(super) sbp: &'w SbpOperator<S>,
    pub(super) geometry: &'w Geometry<S>,
    pub(super) start: &'w Start<S>,
}

impl<'w, S: Real> Problem<'w, S> {
    pub(super) fn derivative(&self) -> FormDerivative<'w, S> {
        FormDerivative { sbp: self.sbp, form: self.settings.form }
    }

    /// Returns true if nothing moves but ignorable coordinates: the constants are the solution then, to the last bit.
    pub(super) fn is_at_rest(&self) -> bool {
        let mut point = self.geometry.point();
        let is_zero = |point: &Point<S>| {
            let mut active = self.geometry.active().iter().enumerate();
            active.all(|(place, &a)| point.q_dot(a) == S::ZERO && point.p_dot(place) == S::ZERO)
        };
        point.evaluate(&self.start.q, &self.start.p).is_ok() && is_zero(&point)
    }

    /// The action with D̄, or the one that is asked for.
    pub(super) fn action(&self, is_regularised: bool) -> DoubledAction<'w, S> {
        let action = DoubledAction::new(self.settings.form, self.sbp, self.geometry, self.start.clone());
        if is_regularised { action } else { action.without_regularisation() }
    }

    /// The order of the unknowns of the action.
    pub(super) fn layout(&self) -> Layout {
        Layout::new(self.start.q.len(), self.points(), self.settings.form)
    }

    pub(super) fn points(&self) -> usize {
        self.sbp.points()
    }
}

/// The critical point of one window, in which ignorable coordinates are counted from its start.
pub(super) struct Piece<S> {
    /// q^a on the nodes, a row for each coordinate.
    pub(super) q: Vec<Vec<S>>,
    /// p*_a on the nodes, a row for each active coordinate; nothing in the doubled system.
    pub(super) p: Vec<Vec<S>>,
    /// p*_a of all coordinates at the end.
    pub(super) end: Vec<S>,
    /// The backward branch in the rows of `q`; nothing in the physical limit.
    pub(super) backward: Vec<Vec<S>>,
    /// Those of the action; the weak form has none.
    pub(super) multipliers: Vec<S>,
    pub(super) gradient_norm: S,
    pub(super) initial_guess: InitialGuess,
    pub(super) history: Vec<IterationRecord>,
}

impl<S: Real> Piece<S> {
    /// The one with these positions and the momenta p*_a of active coordinates, which solve the collocation system.
    pub(super) fn in_limit(
        window: &Problem<'_, S>,
        [q, p]: [Vec<Vec<S>>; 2],
        history: Vec<IterationRecord>,
        initial_guess: InitialGuess,
    ) -> Self {
        let last = window.points() - 1;
        let mut end = window.start.p.clone();
        window.geometry.active().iter().zip(&p).for_each(|(&a, row)| end[a] = row[last]);
        let rows: Vec<&[S]> = q.iter().map(Vec::as_slice).collect();
        let multipliers =
            if window.settings.form == Form::Strong { multipliers(window, &rows, &p, &end) } else { Vec::new() };
        let gradient_norm = window.action(true).gradient_norm_in_limit(&rows, &multipliers);
        Self { end, q, p, backward: Vec::new(), multipliers, gradient_norm, initial_guess, history }
    }
}

/// The multipliers of the strong form in the physical limit, in the order of its layout; p*_a is `end` at the last
/// node.
fn multipliers<S: Real>(window: &Problem<'_, S>, q: &[&[S]], p: &[Vec<S>], end: &[S]) -> Vec<S> {
    let (layout, last, geometry) = (window.layout(), window.points() - 1, window.geometry);
    let mut multipliers = vec![S::ZERO; layout.multiplier_range().len()];
    let weight = window.sbp.weights()[last];
    let slopes: Vec<S> = q.iter().map(|row| window.sbp.derivative_at(row, last)).collect();
    let q: Vec<S> = q.iter().map(|row| row[last]).collect();
    let (momenta, forces) = (geometry.momenta(&q, &slopes), geometry.forces(&q, &slopes));
    for a in 0..q.len() {
        let place = geometry.active().iter().position(|&active| active == a);
        let slope = place.map_or(S::ZERO, |place| window.sbp.derivative_at(&p[place], last));
        multipliers[layout.nu(a)] = weight * (slope - forces[a]) - end[a];
        multipliers[layout.kappa(a)] = weight * (end[a] - momenta[a]);
    }
    multipliers
}
