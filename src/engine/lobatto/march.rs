//! Windows of one length, one after the other.

use std::ops::ControlFlow;

use super::certificate::{Certificate, Certify};
use super::force::{Force, PolynomialForce};
use super::formula::FormulaForce;
use super::guess::Guess;
use super::one::One;
use super::probe;
use super::rule::WeakRule;
use super::tables::Tables;
use super::unit::{Unit, with_unit};
use super::view::WindowView;
use super::window::{MOST_EVALUATIONS, Precision, Window};
use super::{MarchFailure, State, Statistics};
use crate::geometry::metric::Metric;
use crate::geometry::potential::Potential;
use crate::number::vector::{Level, Twofold};

/// Where a march ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marched {
    /// The last state.
    pub end: State,
    /// What it took.
    pub statistics: Statistics,
}

/// A march in windows of one length.
///
/// ```
/// use std::ops::ControlFlow;
///
/// use geodesic_ivp::engine::lobatto::{March, State, WeakRule};
/// use geodesic_ivp::geometry::metric::Metric;
/// use geodesic_ivp::geometry::potential::Potential;
///
/// let metric = Metric::new(Potential::quartic(0.5), 1.0, 1.0);
/// let rule = WeakRule::new(16);
/// let start = State { t: 0.0.into(), x: 1.0.into(), w: 0.1.into() };
/// let end = March::new(&metric, 2.0, &rule, 0.5.into()).run(start, 2, &mut |_| ControlFlow::Continue(()))?.end;
/// assert!((end.x.hi - 0.159_778_018_885_407).abs() < 1e-15);
/// # Ok::<(), geodesic_ivp::engine::lobatto::MarchFailure>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct March<'a> {
    metric: &'a Metric,
    q_t: f64,
    rule: &'a WeakRule,
    length: Twofold,
    precision: Precision,
    level: Level,
    certify: bool,
}

impl<'a> March<'a> {
    /// Windows of `length` on the nodes of `rule`. Iterates to rounding unless [`Self::with_tolerance`] says otherwise.
    pub fn new(metric: &'a Metric, q_t: f64, rule: &'a WeakRule, length: Twofold) -> Self {
        let precision = Precision { tolerance: 0.0, refine: true, most: MOST_EVALUATIONS };
        Self { metric, q_t, rule, length, precision, level: Level::Best, certify: false }
    }

    /// Stops the iteration of a window when the error of X is below `tolerance`, relative to its size; use a hundredth
    /// of the error wanted at the ends. 0 iterates to rounding, and then evaluates the forces once more in twofold
    /// precision where the potential is pure arithmetic. With a tolerance a window is accurate to about 1e-16 at best.
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.precision = Precision { tolerance, refine: tolerance == 0.0, most: MOST_EVALUATIONS };
        self
    }

    /// Computes the certificate of every window too, for [`WindowView::certified`]; a fifth more time.
    pub fn certified(mut self) -> Self {
        self.certify = true;
        self
    }

    /// Uses the instructions of `level`.
    pub fn with_level(mut self, level: Level) -> Self {
        self.level = level;
        self
    }

    /// Marches `windows` windows from `start`; `observe` sees each of them and may end the march.
    ///
    /// # Errors
    /// [`MarchFailure`] where the world-line leaves the domain or a window is too long to converge.
    pub fn run(
        &self,
        start: State,
        windows: usize,
        observe: &mut dyn FnMut(&WindowView<'_>) -> ControlFlow<()>,
    ) -> Result<Marched, MarchFailure> {
        let (marched, complete) = with_unit!(self.rule, unit => self.with(unit, start, windows, observe));
        if complete {
            return Ok(marched);
        }
        let window = marched.statistics.windows;
        let gamma = (self.length * window as f64).hi;
        Err(probe::why(self.metric, self.q_t, &marched.end, self.length.hi, window, gamma))
    }

    fn with<const P: usize>(&self, unit: &Unit<P>, start: State, windows: usize, observe: See<'_>) -> (Marched, bool) {
        let Self { metric, q_t, .. } = *self;
        match metric.potential() {
            Potential::Polynomial(p) => {
                self.walk(unit, PolynomialForce::new(metric, q_t, p.coefficients()), start, windows, observe)
            }
            Potential::Formula(f) => {
                let force = FormulaForce::<P>::new(metric, q_t, f.program(), self.rule.points());
                self.walk(unit, force, start, windows, observe)
            }
        }
    }

    /// The end, and whether it is the one requested.
    ///
    /// When going to rounding, uses tables of this length, so that nothing drifts. Otherwise works in units of the
    /// length, with tables that exist already: h Q_t is rounded to a number, an error of 1e-16 with the same sign in
    /// every window.
    fn walk<const P: usize, F: Force>(
        &self,
        unit: &Unit<P>,
        mut force: F,
        start: State,
        windows: usize,
        observe: See<'_>,
    ) -> (Marched, bool) {
        let Self { rule, length, precision, .. } = *self;
        let own;
        let (tables, scale, charge) = if precision.tolerance == 0.0 {
            own = Tables::<P>::new(rule, rule.length_free(), length);
            (&*own, Twofold::ONE, self.q_t)
        } else {
            let charge = (length * self.q_t).hi;
            force.set(charge, rule.points());
            (&*unit.tables, length, charge)
        };
        let mut certificate: Option<Certificate<P>> = None;
        let inverse = scale.reciprocal();
        let physical = |state: &State| State { w: state.w * inverse, ..*state };
        let mut window = Window::<P>::new();
        let start = State { w: start.w * scale, ..start };
        let mut marched = Marched { end: start, statistics: Statistics::default() };
        let mut guess = Guess::Parabola;
        while marched.statistics.windows < windows {
            let begin = marched.end;
            let one =
                One { tables, tail: None, force: &mut force, window: &mut window, start: &begin, guess, precision };
            let Some(solved) = one.solve(self.level) else {
                return (Marched { end: physical(&begin), ..marched }, false);
            };
            guess = Guess::Same;
            let index = marched.statistics.windows;
            marched.end = solved.end;
            marched.statistics.evaluations += solved.evaluations;
            marched.statistics.windows += 1;
            let (start, end) = (physical(&begin), physical(&solved.end));
            if self.certify {
                let out = certificate.get_or_insert_with(Certificate::new);
                let stretch = length.hi / scale.hi;
                let (force, window, start, length) = (&mut force, &window, &begin, length.hi);
                self.level.dispatch(Certify { unit, force, charge, window, start, stretch, length, out });
            }
            let nodes = window.nodes(rule.points(), scale);
            let certified = certificate.as_ref().map(|certificate| certificate.view(rule.points()));
            let view = WindowView { index, gamma: length * index as f64, length, rule, start, end, nodes, certified };
            if observe(&view).is_break() {
                break;
            }
        }
        (Marched { end: physical(&marched.end), ..marched }, true)
    }
}

/// Sees a window.
type See<'s> = &'s mut dyn FnMut(&WindowView<'_>) -> ControlFlow<()>;
