//! Windows of one length, one after the other.

use std::ops::ControlFlow;

use pulp::{Simd, WithSimd};

use super::force::{Force, PolynomialForce};
use super::formula::FormulaForce;
use super::guess::Guess;
use super::probe;
use super::rule::WeakRule;
use super::simd::Level;
use super::tables::Tables;
use super::twofold::Twofold;
use super::unit::{Unit, with_unit};
use super::view::WindowView;
use super::window::{MOST_EVALUATIONS, Precision, Solved, Window};
use super::{MarchFailure, State, Statistics};
use crate::metric::Metric;
use crate::potential::Potential;

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
/// use geodesic_ivp::lobatto::{March, State, WeakRule};
/// use geodesic_ivp::metric::Metric;
/// use geodesic_ivp::potential::Potential;
///
/// let metric = Metric::new(Potential::quartic(0.5), 1.0, 1.0);
/// let rule = WeakRule::new(16);
/// let start = State { t: 0.0.into(), x: 1.0.into(), w: 0.1.into() };
/// let end = March::new(&metric, 2.0, &rule, 0.5.into()).run(start, 2, &mut |_| ControlFlow::Continue(()))?.end;
/// assert!((end.x.hi - 0.159_778_018_885_407).abs() < 1e-15);
/// # Ok::<(), geodesic_ivp::lobatto::MarchFailure>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct March<'a> {
    metric: &'a Metric,
    q_t: f64,
    rule: &'a WeakRule,
    length: Twofold,
    precision: Precision,
    level: Level,
}

impl<'a> March<'a> {
    /// Windows of `length` on the nodes of `rule`. Iterates to rounding unless [`Self::with_tolerance`] says otherwise.
    pub fn new(metric: &'a Metric, q_t: f64, rule: &'a WeakRule, length: Twofold) -> Self {
        let precision = Precision { tolerance: 0.0, refine: true, most: MOST_EVALUATIONS };
        Self { metric, q_t, rule, length, precision, level: Level::Best }
    }

    /// Stops the iteration of a window when the error of X is below `tolerance`, relative to its size; use a hundredth
    /// of the error wanted at the ends. 0 iterates to rounding, and then evaluates the forces once more in twofold
    /// precision where the potential is pure arithmetic. With a tolerance a window is accurate to about 1e-16 at best.
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.precision = Precision { tolerance, refine: tolerance == 0.0, most: MOST_EVALUATIONS };
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
        let (tables, scale) = if precision.tolerance == 0.0 {
            own = Tables::<P>::new(rule, length);
            (&*own, Twofold::ONE)
        } else {
            force.set((length * self.q_t).hi, rule.points());
            (&*unit.tables, length)
        };
        let inverse = scale.reciprocal();
        let physical = |state: &State| State { w: state.w * inverse, ..*state };
        let mut window = Window::<P>::new();
        let start = State { w: start.w * scale, ..start };
        let mut marched = Marched { end: start, statistics: Statistics::default() };
        let mut see = |window: &Window<P>, index: usize, start: &State, solved: &Solved| {
            let (start, end) = (physical(start), physical(&solved.end));
            let nodes = window.nodes(rule.points(), scale);
            observe(&WindowView { index, gamma: length * index as f64, length, rule, start, end, nodes })
        };
        let run = Run {
            tables,
            force: &mut force,
            window: &mut window,
            precision,
            windows,
            marched: &mut marched,
            see: &mut see,
        };
        let complete = self.level.dispatch(run);
        marched.end = physical(&marched.end);
        (marched, complete)
    }
}

/// Sees a window.
type See<'s> = &'s mut dyn FnMut(&WindowView<'_>) -> ControlFlow<()>;

/// Sees a window, its index, its start and its result.
type SeeWindow<'r, const P: usize> = &'r mut dyn FnMut(&Window<P>, usize, &State, &Solved) -> ControlFlow<()>;

/// The work that is compiled for every level: windows of one table.
struct Run<'r, const P: usize, F> {
    tables: &'r Tables<P>,
    force: &'r mut F,
    window: &'r mut Window<P>,
    precision: Precision,
    windows: usize,
    marched: &'r mut Marched,
    see: SeeWindow<'r, P>,
}

impl<const P: usize, F: Force> WithSimd for Run<'_, P, F> {
    /// Whether it reached its end, or the point where `see` stopped it.
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) -> bool {
        let Run { tables, force, window, precision, windows, marched, see } = self;
        let mut guess = Guess::Parabola;
        let mut done = 0;
        while done < windows {
            let start = marched.end;
            let Some(solved) = window.solve(s, tables, force, &start, guess, precision) else {
                // An extrapolation can be far off, even outside the domain: try once more from the parabola.
                if matches!(guess, Guess::Parabola) {
                    return false;
                }
                guess = Guess::Parabola;
                continue;
            };
            guess = Guess::Same;
            done += 1;
            marched.end = solved.end;
            marched.statistics.evaluations += solved.evaluations;
            marched.statistics.windows += 1;
            if see(window, marched.statistics.windows - 1, &start, &solved).is_break() {
                break;
            }
        }
        true
    }
}
