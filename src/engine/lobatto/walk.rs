//! A world-line, window by window.

use super::certificate::{Certificate, Certify};
use super::force::Force;
use super::guess::Guess;
use super::kit::Kit;
use super::one::One;
use super::tables::EXTRAPOLATED;
use super::view::{Certified, NodeValues};
use super::window::{Precision, Solved, Window};
use super::{State, Statistics};
use crate::engine::enclosure::Enclosure;
use crate::number::vector::{Level, Nodes, Twofold};

/// The length of a window in γ, and what it makes of the charge.
///
/// The charge of the window, h Q_t, is a number and the length is computed from it to twice the precision: the other
/// way round, the rounding of h Q_t would be an error of the same sign in every window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Length {
    pub(super) h: Twofold,
    inverse: Twofold,
    charge: f64,
}

impl Length {
    /// Not above `h` and close to it, taken from few lengths, so that anything stored for every length stays small.
    pub(super) fn near(h: f64, q_t: f64) -> Self {
        const STEPS_TO_DOUBLE: f64 = 24.0;
        let h = ((STEPS_TO_DOUBLE * h.log2()).floor() / STEPS_TO_DOUBLE).exp2();
        let charge = h * q_t;
        if charge.is_normal() { Self::with(Twofold::ratio(charge, q_t), charge) } else { Self::with(h.into(), charge) }
    }

    /// Exactly `h`, for a single window.
    pub(super) fn exactly(h: Twofold, q_t: f64) -> Self {
        Self::with(h, (h * q_t).hi)
    }

    fn with(h: Twofold, charge: f64) -> Self {
        Self { h, inverse: h.reciprocal(), charge }
    }
}

/// The forces of a window, in units of its length.
struct Forces<const P: usize> {
    length: f64,
    values: Nodes<P>,
}

/// Everything that a march needs, reusable for the next attempt.
pub(super) struct Walk<const P: usize, F> {
    pub(super) kit: &'static Kit<P>,
    force: F,
    pub(super) window: Window<P>,
    /// What looks between nodes, where something could hide there.
    pub(super) enclosure: Option<Enclosure>,
    /// Those of the window before.
    previous: Option<Forces<P>>,
    /// Those of the window that begins at the same point and was too long.
    rejected: Option<Forces<P>>,
    /// Whether the window still holds them.
    is_untouched: bool,
    /// Where certificates go, if they are wanted.
    certificate: Option<Certificate<P>>,
}

impl<const P: usize, F: Force> Walk<P, F> {
    pub(super) fn new(kit: &'static Kit<P>, force: F, enclosure: Option<Enclosure>, certify: bool) -> Self {
        let (window, certificate) = (Window::new(), certify.then(Certificate::new));
        Self { kit, force, window, enclosure, previous: None, rejected: None, is_untouched: false, certificate }
    }

    /// Forgets the previous window: a new march begins.
    pub(super) fn forget(&mut self) {
        (self.previous, self.rejected, self.is_untouched) = (None, None, false);
    }

    /// The window from `start`.
    pub(super) fn solve(
        &mut self,
        length: Length,
        start: &State,
        precision: Precision,
        statistics: &mut Statistics,
    ) -> Option<Solved> {
        let n = self.kit.rule.points();
        let ratio = |forces: &Forces<P>| length.h.hi / forces.length;
        let (degree, begin, forces) = match (&self.rejected, &self.previous) {
            (Some(forces), _) => (n - 1, 0.0, Some(forces)),
            (None, forces) => (EXTRAPOLATED, 1.0, forces.as_ref()),
        };
        let continuation = forces.map(|forces| self.kit.unit.continuation(degree, begin, ratio(forces)));
        let guess = match (forces, &continuation) {
            (Some(forces), _) if self.rejected.is_none() && self.is_untouched && forces.length == length.h.hi => {
                Guess::Same
            }
            (Some(forces), Some(from)) => Guess::Continued { from, values: &forces.values },
            _ => Guess::Parabola,
        };
        self.is_untouched = false;
        let (unit, tail) = (self.kit.unit, Some(&self.kit.tail));
        self.force.set(length.charge, n);
        let (force, window) = (&mut self.force, &mut self.window);
        let tables = &*unit.tables;
        in_gamma(One { tables, tail, force, window, start, guess, precision }, length, statistics)
    }

    /// What [`Self::solve`] made is too long; the forces are a good guess for a part of it.
    pub(super) fn reject(&mut self, length: Length) {
        self.rejected = Some(Forces { length: length.h.hi, values: self.window.a });
    }

    /// What [`Self::solve`] made is accepted.
    pub(super) fn accept(&mut self, length: Length) {
        self.previous = Some(Forces { length: length.h.hi, values: self.window.a });
        (self.rejected, self.is_untouched) = (None, true);
    }

    /// Whether forces can be evaluated in twofold precision.
    pub(super) fn refines(&self) -> bool {
        self.force.refines()
    }

    /// Computes the certificate of the window from `start`, if it is wanted.
    pub(super) fn certify(&mut self, length: Length, start: &State) {
        let Some(out) = &mut self.certificate else { return };
        let (unit, force, charge) = (self.kit.unit, &mut self.force, length.charge);
        force.set(charge, unit.tables.points);
        let start = &State { w: start.w * length.h, ..*start };
        let (window, length) = (&self.window, length.h.hi);
        Level::Best.dispatch(Certify { unit, force, charge, window, start, stretch: 1.0, length, out });
    }

    /// The last certificate.
    pub(super) fn certified(&self) -> Option<Certified<'_>> {
        self.certificate.as_ref().map(|certificate| certificate.view(self.kit.rule.points()))
    }

    /// X, u and a on the nodes.
    pub(super) fn nodes(&self, length: Length) -> NodeValues<'_> {
        self.window.nodes(self.kit.rule.points(), length.h)
    }
}

/// Solves the window `one` of a table of length 1, whose start and end are in γ.
fn in_gamma<const P: usize, F: Force>(
    one: One<'_, P, F>,
    length: Length,
    statistics: &mut Statistics,
) -> Option<Solved> {
    let start = State { w: one.start.w * length.h, ..*one.start };
    let most = one.precision.most;
    let Some(mut solved) = (One { start: &start, ..one }).solve(Level::Best) else {
        statistics.evaluations += most;
        return None;
    };
    solved.end.w = solved.end.w * length.inverse;
    statistics.evaluations += solved.evaluations;
    Some(solved)
}

#[cfg(test)]
mod tests {
    use super::{Length, Walk};
    use crate::engine::lobatto::formula::FormulaForce;
    use crate::engine::lobatto::window::Precision;
    use crate::engine::lobatto::{State, Statistics, kit};
    use crate::geometry::metric::Metric;
    use crate::geometry::potential::{Formula, Potential};

    #[test]
    fn only_arithmetic_is_refined() {
        for (text, refines) in [("x^4/2 - 1/(3 + x)", true), ("cos(x)", false), ("x^x", false)] {
            let formula = Formula::new(text, &Default::default()).unwrap();
            let metric = Metric::new(Potential::Formula(formula), 1.0, 1.0);
            let Potential::Formula(formula) = metric.potential() else { panic!("a formula") };
            let force = FormulaForce::<16>::new(&metric, 1.0, formula.program(), 16);
            assert_eq!(Walk::new(kit::coarse(), force, None, false).refines(), refines, "{text}");
        }
    }

    /// A window is judged by the modes of a and of u, in this order.
    #[test]
    fn a_window_is_judged_by_its_forces() {
        let formula = Formula::new("x^4/2", &Default::default()).unwrap();
        let metric = Metric::new(Potential::Formula(formula), 1.0, 1.0);
        let Potential::Formula(formula) = metric.potential() else { panic!("a formula") };
        let (kit, q_t) = (kit::coarse(), 2.0);
        let n = kit.rule.points();
        let mut walk = Walk::new(kit, FormulaForce::<16>::new(&metric, q_t, formula.program(), n), None, false);
        let (length, start) = (Length::exactly(0.5.into(), q_t), State { t: 0.0.into(), x: 1.0.into(), w: 0.1.into() });
        let precision = Precision { tolerance: 0.0, refine: false, most: 60 };
        let solved = walk.solve(length, &start, precision, &mut Statistics::default()).unwrap();
        for (k, values) in [&walk.window.a.0[..n], &walk.window.u.0[..n]].into_iter().enumerate() {
            let largest = values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
            let tail = [n - 3, n - 2].map(|mode| kit.rule.mode_of(mode, values).abs());
            assert_eq!(solved.largest[k], largest);
            assert!((solved.tail[k] - tail[0].max(tail[1])).abs() < 1e-14, "{k}: {:e}, {tail:?}", solved.tail[k]);
        }
    }
}
