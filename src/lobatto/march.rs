//! Windows of one length, one after the other.

use std::ops::ControlFlow;

use pulp::{Simd, WithSimd};

use super::force::{Force, PolynomialForce};
use super::formula::FormulaForce;
use super::probe;
use super::rule::WeakRule;
use super::simd::Level;
use super::tables::Tables;
use super::twofold::Twofold;
use super::view::WindowView;
use super::window::{Guess, MOST_EVALUATIONS, Precision, Solved, Window};
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

/// A march in windows of one length, with the tables for it.
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
pub struct March<'a> {
    metric: &'a Metric,
    q_t: f64,
    rule: &'a WeakRule,
    length: Twofold,
    precision: Precision,
    level: Level,
    walker: Box<dyn Walk>,
}

impl<'a> March<'a> {
    /// Windows of `length` on the nodes of `rule`. Iterates to rounding unless [`Self::with_tolerance`] says otherwise.
    pub fn new(metric: &'a Metric, q_t: f64, rule: &'a WeakRule, length: Twofold) -> Self {
        let walker = walker(metric, q_t, rule, length);
        let precision = Precision { tolerance: 0.0, refine: true, most: MOST_EVALUATIONS };
        Self { metric, q_t, rule, length, precision, level: Level::Best, walker }
    }

    /// Stops the iteration of a window when the error of X is below `tolerance`, relative to its size: a hundredth of
    /// the error wanted at the ends. 0 goes to rounding, and then evaluates the forces once more in twofold precision
    /// where the potential is pure arithmetic.
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.precision = Precision { tolerance, refine: tolerance == 0.0, most: MOST_EVALUATIONS };
        self
    }

    /// Uses the instructions of `level`.
    pub fn with_level(mut self, level: Level) -> Self {
        self.level = level;
        self
    }

    /// `windows` windows from `start` on; `observe` sees each of them and may end the march.
    ///
    /// # Errors
    /// [`MarchFailure`] where the world-line leaves the domain or a window is too long to converge.
    pub fn run(
        &mut self,
        start: State,
        windows: usize,
        observe: &mut dyn FnMut(&WindowView<'_>) -> ControlFlow<()>,
    ) -> Result<Marched, MarchFailure> {
        let (metric, q_t, rule, length) = (self.metric, self.q_t, self.rule, self.length);
        let gamma = |index: usize| length * index as f64;
        let mut see = |index: usize, start: &State, end: &State, [x, t_dot, acceleration]: [&[f64]; 3]| {
            let gamma = gamma(index);
            let (start, end) = (*start, *end);
            observe(&WindowView { index, gamma, length, rule, start, end, x, t_dot, acceleration })
        };
        let (marched, complete) = self.walker.walk(self.level, start, windows, self.precision, &mut see);
        if complete {
            return Ok(marched);
        }
        let window = marched.statistics.windows;
        Err(probe::why(metric, q_t, &marched.end, length.hi, window, gamma(window).hi))
    }
}

/// Sees the index of a window, its start and end, and X, u, a on its nodes.
type See<'s> = &'s mut dyn FnMut(usize, &State, &State, [&[f64]; 3]) -> ControlFlow<()>;

/// A march with everything that is known at compile time hidden.
trait Walk {
    /// The end, and whether it is the one asked for.
    fn walk(
        &mut self,
        level: Level,
        start: State,
        windows: usize,
        precision: Precision,
        see: See<'_>,
    ) -> (Marched, bool);
}

struct Walker<const P: usize, F> {
    tables: Box<Tables<P>>,
    force: F,
}

/// The smallest sizes that hold n nodes are compiled in.
fn walker(metric: &Metric, q_t: f64, rule: &WeakRule, length: Twofold) -> Box<dyn Walk> {
    match rule.points() {
        ..=8 => sized::<8>(metric, q_t, rule, length),
        9..=16 => sized::<16>(metric, q_t, rule, length),
        17..=24 => sized::<24>(metric, q_t, rule, length),
        25..=32 => sized::<32>(metric, q_t, rule, length),
        _ => sized::<64>(metric, q_t, rule, length),
    }
}

fn sized<const P: usize>(metric: &Metric, q_t: f64, rule: &WeakRule, length: Twofold) -> Box<dyn Walk> {
    let tables = Tables::<P>::new(rule, length, rule.points() - 2).with_guess(rule);
    match metric.potential() {
        Potential::Polynomial(p) => {
            Box::new(Walker { tables, force: PolynomialForce::new(metric, q_t, p.coefficients()) })
        }
        Potential::Formula(f) => {
            Box::new(Walker { tables, force: FormulaForce::<P>::new(metric, q_t, f.program(), rule.points()) })
        }
    }
}

impl<const P: usize, F: Force> Walk for Walker<P, F> {
    fn walk(
        &mut self,
        level: Level,
        start: State,
        windows: usize,
        precision: Precision,
        see: See<'_>,
    ) -> (Marched, bool) {
        let mut window = Window::<P>::new();
        let mut marched = Marched { end: start, statistics: Statistics::default() };
        let n = self.tables.points;
        let mut seen = |window: &Window<P>, index: usize, start: &State, solved: &Solved| {
            see(index, start, &solved.end, [&window.x.0[..n], &window.u.0[..n], &window.a.0[..n]])
        };
        let run = Run {
            tables: &self.tables,
            force: &mut self.force,
            window: &mut window,
            guess: Guess::Parabola,
            precision,
            windows,
            marched: &mut marched,
            see: &mut seen,
        };
        let complete = level.dispatch(run);
        (marched, complete)
    }
}

/// Sees a window, its index, its start and what came of it.
type SeeWindow<'r, const P: usize> = &'r mut dyn FnMut(&Window<P>, usize, &State, &Solved) -> ControlFlow<()>;

/// The work that is compiled for every level: windows of one table.
struct Run<'r, const P: usize, F> {
    tables: &'r Tables<P>,
    force: &'r mut F,
    window: &'r mut Window<P>,
    /// Of the first window; the others extrapolate from the one before.
    guess: Guess<'r, P>,
    precision: Precision,
    windows: usize,
    marched: &'r mut Marched,
    see: SeeWindow<'r, P>,
}

impl<const P: usize, F: Force> WithSimd for Run<'_, P, F> {
    /// Whether it came to its end, or to where `see` stopped it.
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) -> bool {
        let Run { tables, force, window, mut guess, precision, windows, marched, see } = self;
        let mut done = 0;
        while done < windows {
            let start = marched.end;
            let Some(solved) = window.solve(s, tables, force, &start, guess, precision) else {
                // An extrapolation can be far off, even outside the domain: once more from the parabola.
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
