//! Witnesses: numbers that the motion keeps, and what may explain that they change.
//!
//! A run claims that every coordinate is within δq^a of the truth at every node. If that is so, a number W(q, q̇) that
//! the motion keeps is off by no more than what these errors do to it, and the rounding of its terms:
//!
//! ```text
//! |ΔW| ≤ Σ_a ( |∂W/∂q^a| + |∂W/∂q̇^a| Σ_j |D_kj| ) δq^a + rounding.
//! ```
//!
//! The velocities are Dq^a, so that errors of positions make errors Σ_j D_kj e_j of them, and nothing is assumed of
//! their signs or of how smooth they are. The error that D itself makes of the true motion is not in that sum. It is
//! what the errors of the nodes come from: where a row of D is off by τ, the next nodes are off by about τ over the
//! size of the row. A claim that is true thus explains both, and a factor is not needed.
//!
//! The claim is known when a run is at its end, and its nodes may be gone by then. So every window keeps the place
//! where a witness changes most, with its derivatives there. Of all windows two are kept: where the change is the
//! largest, and where it is the largest relative to the terms of the witness. (At the pericentre of an orbit an error
//! does much to K and is soon undone; what stays of it is seen at the apocentre, where the terms are small.)

use super::verdict::Reason;
use crate::number::norm::{larger, times};

/// Where a witness changes, and what may explain it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Place {
    /// γ of the place.
    pub gamma: f64,
    /// The change there; NaN if it is no number.
    pub change: f64,
    /// The sizes of the terms of the witness, Σ |term|.
    pub terms: f64,
    /// By how much an error of one unit may change the witness there: of each coordinate, and behind them of each force
    /// and of K itself, as far as it contains these.
    pub(super) by: Vec<f64>,
    /// The rounding of its terms.
    pub(super) rounding: f64,
}

impl Place {
    /// A place with these derivatives, at which nothing changes.
    pub(super) fn of(gamma: f64, by: Vec<f64>) -> Self {
        Self { gamma, change: 0.0, terms: 0.0, by, rounding: 0.0 }
    }

    /// The change that errors of this size explain. Errors that are not known explain everything.
    pub fn explained(&self, errors: Option<&[f64]>) -> f64 {
        let Some(errors) = errors else { return f64::INFINITY };
        self.by.iter().zip(errors).map(|(&by, &error)| times(by, error)).sum::<f64>() + self.rounding
    }

    /// The change relative to the terms.
    fn share(&self) -> f64 {
        share(self.change, self.terms)
    }

    /// A witness that is the sum of two, whose change is not known yet.
    pub(super) fn plus(mut self, next: Self) -> Self {
        self.add(&next);
        self
    }

    /// Adds a witness to this one, whose change is not known then.
    pub(super) fn add(&mut self, next: &Self) {
        self.by.iter_mut().zip(&next.by).for_each(|(sum, by)| *sum += by);
        (self.gamma, self.change) = (next.gamma, 0.0);
        self.terms += next.terms;
        self.rounding += next.rounding;
    }

    /// A witness of which only the largest change is known, which is at one of two places.
    pub(super) fn or(mut self, next: Self) -> Self {
        self.by.iter_mut().zip(&next.by).for_each(|(by, &next)| *by = larger(*by, next));
        Self {
            gamma: next.gamma,
            change: larger(self.change, next.change),
            terms: larger(self.terms, next.terms),
            by: self.by,
            rounding: larger(self.rounding, next.rounding),
        }
    }

    /// The same witness, multiplied by a number.
    pub(super) fn scaled(mut self, factor: f64) -> Self {
        self.scale(factor);
        self
    }

    /// Multiplies it by a number.
    pub(super) fn scale(&mut self, factor: f64) {
        self.by.iter_mut().for_each(|by| *by *= factor);
        [&mut self.change, &mut self.terms, &mut self.rounding].into_iter().for_each(|value| *value *= factor);
    }
}

/// A change relative to the terms.
fn share(change: f64, terms: f64) -> f64 {
    if change == 0.0 { 0.0 } else { change / terms }
}

/// Returns true if a change is larger than another one. NaN is the largest of all.
fn is_more(new: f64, old: f64) -> bool {
    new > old || (new.is_nan() && !old.is_nan())
}

/// What is kept of a witness: where it changes most, and where it does relative to its terms.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Heard(Option<[Place; 2]>);

impl Heard {
    /// A witness that is known at one place.
    pub(super) fn of(place: Place) -> Self {
        let mut heard = Self::default();
        heard.see(place);
        heard
    }

    /// Returns true if a place with this change and these terms would be kept.
    pub(super) fn keeps(&self, change: f64, terms: f64) -> bool {
        let is_more =
            |[most, other]: &[Place; 2]| is_more(change, most.change) || is_more(share(change, terms), other.share());
        self.0.as_ref().is_none_or(is_more)
    }

    /// Takes a place into account.
    pub(super) fn see(&mut self, place: Place) {
        match &mut self.0 {
            None => self.0 = Some([place.clone(), place]),
            Some([most, share]) => {
                if is_more(place.share(), share.share()) {
                    share.clone_from(&place);
                }
                if is_more(place.change, most.change) {
                    *most = place;
                }
            }
        }
    }

    /// Takes the places of a later part of a run into account.
    pub(super) fn followed_by(mut self, next: Self) -> Self {
        next.0.into_iter().flatten().for_each(|place| self.see(place));
        self
    }

    /// The place where the change is the largest.
    pub fn most(&self) -> Option<&Place> {
        self.0.as_ref().map(|[most, _]| most)
    }

    /// The size of the terms where the change is the largest.
    pub fn terms(&self) -> f64 {
        self.most().map_or(0.0, |most| most.terms)
    }

    /// The largest change relative to the terms.
    pub fn share(&self) -> f64 {
        self.0.as_ref().map_or(0.0, |[_, share]| share.share())
    }

    /// The reason to doubt a run whose coordinates are off by at most `errors`, if these do not explain the change of
    /// this witness, which has a name.
    pub(super) fn doubt(&self, name: &str, errors: Option<&[f64]>, remedy: &str) -> Option<Reason> {
        let told = |place: &Place| {
            let explained = place.explained(errors);
            // What is not a number is not explained.
            let is_explained = place.change <= explained && place.change.is_finite();
            (!is_explained).then(|| {
                let Place { gamma, change, .. } = place;
                let finding = format!(
                    "{name} changes by {change:.1e} at gamma = {gamma:.6}, of which the error of the coordinates and \
                     rounding explain {explained:.1e}"
                );
                Reason::new(finding, remedy)
            })
        };
        self.0.as_ref()?.iter().find_map(told)
    }
}
