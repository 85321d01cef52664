//! An event that acts carries small changes of the motion behind it.
//!
//! A neighbouring motion meets the event a little earlier or later, by δτ = −∇g·δ/(∇g·f), where g is the formula that
//! changes its sign and f the rates before. With the state R(x) that the event makes of x, and the rates f⁺ behind it,
//!
//! ```text
//! δ⁺ = S δ,      S = DR − (DR f − f⁺) ∇gᵀ/(∇g·f)
//! ```
//!
//! is the change behind it at equal γ (M. A. Aizerman and F. R. Gantmacher, Q. J. Mech. Appl. Math. 11 (1958) 525).

use super::jets::{Jet, Jets};
use super::resets::Reset;
use super::{Geometry, Start};
use crate::number::ball::Ball;

/// The derivatives of an event that acts.
#[derive(Debug)]
pub(crate) struct Saltation {
    when: Jets,
    reset: Reset,
    /// The momentum of t as a function of the others, where they are followed together: the energy by Newton's law.
    energy: Option<Jets>,
}

impl Saltation {
    /// That of an event with this formula, which makes the state that `reset` says, and sets `parameters`.
    ///
    /// # Errors
    /// The reason why the changes of active coordinates and momenta do not tell what becomes of them.
    pub(crate) fn new(
        geometry: &Geometry,
        (when, energy): (Jets, Option<Jets>),
        reset: Reset,
        parameters: &Jets,
    ) -> Result<Self, &'static str> {
        let n = geometry.dimension();
        let is_active = |a: usize| geometry.active().contains(&a);
        let changes = |a: usize| reset.changed.iter().any(|(b, _)| *b == a);
        // The position of t under Newton's law is the same in all motions.
        let moves = |a: usize| !is_active(a) && (changes(a) || !geometry.is_steady(a));
        let of_change = |depends: &[bool]| (0..2 * n).any(|k| depends[k] && is_active(k % n));
        let of_place = |depends: &[bool]| (0..n).any(|a| depends[a] && moves(a));
        let all = [&when, &reset.jets, parameters];
        if all.into_iter().flat_map(Jets::depends).any(of_place) {
            return Err("its formulas depend on the place of an ignorable coordinate");
        }
        let of_constants = reset.changed.iter().zip(reset.jets.depends()).filter(|((a, _), _)| !is_active(*a));
        if of_constants.into_iter().any(|(_, depends)| of_change(depends)) {
            return Err("it makes a conserved momentum depend on what changes");
        }
        if parameters.depends().any(of_change) {
            return Err("it makes a parameter depend on what changes");
        }
        let energy = energy.filter(|_| is_active(0));
        if energy.is_some() && parameters.depends().len() > 0 {
            return Err("it sets a parameter, and the energy is not conserved");
        }
        Ok(Self { when, reset, energy })
    }

    /// S, by rows: positions of active coordinates, then their momenta. It acts on a state in one geometry, and leaves
    /// another one in that behind it. Its entries are not finite where the motion grazes the surface.
    pub(crate) fn matrix(&self, before: (&Geometry, &Start), behind: (&Geometry, &Start)) -> Vec<f64> {
        let (n, active) = (before.0.dimension(), before.0.active());
        let [rates, after] = [before, behind].map(|(geometry, start)| rates(geometry, start));
        let along = |row: &[f64]| row.iter().zip(&rates).map(|(slope, rate)| slope * rate).sum::<f64>();
        let when = gradients(&self.when, before.1).swap_remove(0);
        let reset = self.derivatives([before.1, behind.1], n);
        let unknowns: Vec<usize> = active.iter().copied().chain(active.iter().map(|a| n + a)).collect();
        let row = |&unknown: &usize| {
            let row = &reset[unknown];
            let late = (along(row) - after[unknown]) / along(&when);
            unknowns.iter().map(|&k| row[k] - late * when[k]).collect::<Vec<f64>>()
        };
        unknowns.iter().flat_map(row).collect()
    }

    /// DR by rows, of all positions and momenta.
    fn derivatives(&self, [before, behind]: [&Start; 2], n: usize) -> Vec<Vec<f64>> {
        let unit = |row: usize| (0..2 * n).map(|k| f64::from(u8::from(k == row))).collect::<Vec<f64>>();
        let mut rows: Vec<Vec<f64>> = (0..2 * n).map(unit).collect();
        let changed = self.reset.changed.iter().zip(gradients(&self.reset.jets, before));
        changed.for_each(|((a, is_momentum), gradient)| rows[a + n * usize::from(*is_momentum)] = gradient);
        if let Some(energy) = &self.energy {
            // It changes by as much as the energy of the others does.
            let [own, there] = [before, behind].map(|start| gradients(energy, start).swap_remove(0));
            let through = |k: usize| rows.iter().zip(&there).map(|(row, slope)| slope * row[k]).sum::<f64>();
            rows[n] = (0..2 * n).map(|k| f64::from(u8::from(k == n)) + through(k) - own[k]).collect();
        }
        rows
    }
}

/// The derivatives of formulas by all positions and momenta of a state.
fn gradients(jets: &Jets, Start { q, p, .. }: &Start) -> Vec<Vec<f64>> {
    let of_start = std::iter::repeat_n(0.0, 2 * q.len());
    let state: Vec<Ball> = q.iter().chain(p).copied().chain(of_start).map(Ball::exact).collect();
    let gradient = |jet: Jet| jet.gradient[..2 * q.len()].iter().map(|slope| slope.hi).collect();
    jets.at(&state).into_iter().map(gradient).collect()
}

/// The rates of all positions and momenta.
fn rates(geometry: &Geometry, Start { q, p, .. }: &Start) -> Vec<f64> {
    let state = [&q[..], p].concat();
    let mut rates = vec![f64::NAN; state.len()];
    // A point outside of the domain has none.
    let _ = geometry.point().slopes(&state, &mut rates);
    rates
}
