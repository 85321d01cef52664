//! World-lines of scenes between the nodes, and where a formula of their state changes its sign.

pub(super) mod crossings;
mod curve;
mod shape;

pub use crossings::{Crossing, Watch, crossings};

use self::curve::Curve;
use super::legendre::Tables;
use super::{Cursor, OutsideRun, Reached, Sampled};
use crate::geometry::{Geometry, Rates, Start};
use crate::root::root;
use crate::scalar::Real;
use crate::solve::WorldLine;

/// A world-line at one value of γ.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneSample<S = f64> {
    /// γ.
    pub gamma: S,
    /// q^a.
    pub q: Vec<S>,
    /// dq^a/dγ.
    pub q_dot: Vec<S>,
    /// p_a.
    pub p: Vec<S>,
}

/// Interpolates a world-line. A window is prepared when a value in it is requested, and kept until a value in another
/// window is.
///
/// ```
/// use geodesic_ivp::case::{SceneCase, builtin};
/// use geodesic_ivp::sampling::SceneSampler;
/// use geodesic_ivp::solve::{WorldLine, solve_scene};
///
/// let case = SceneCase::parse("kepler", builtin::text("kepler").expect("it is built in"), &[])?;
/// let line: WorldLine = solve_scene(&case.setup())?;
/// let half = SceneSampler::new(&line).at_gamma(std::f64::consts::PI).expect("inside the run");
/// assert!((half.q[1] + 1.6).abs() < 1e-13 && (half.q_dot[2] + 0.5).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct SceneSampler<'l, S = f64> {
    cursor: Cursor<'l, S, Geometry<S>, Curve<S>>,
    tables: Tables<S>,
    rates: Rates<S>,
}

impl<'l, S: Sampled> SceneSampler<'l, S> {
    /// The world-line at `gamma`.
    ///
    /// # Errors
    /// [`OutsideRun`] beyond the ends by more than rounding.
    pub fn at_gamma(&mut self, gamma: S) -> Result<SceneSample<S>, OutsideRun<S>> {
        S::scene_sample_at_gamma(self, gamma)
    }

    /// The world-line where coordinate `a`, which grows or falls all the way, has the given value.
    ///
    /// # Errors
    /// [`OutsideRun`] with the range of the coordinate, beyond it by more than rounding.
    pub fn at_value(&mut self, a: usize, value: S) -> Result<SceneSample<S>, OutsideRun<S>> {
        S::scene_sample_at_value(self, a, value)
    }
}

impl<'l, S: Real> SceneSampler<'l, S> {
    /// A sampler of `line`.
    pub fn new(line: &'l WorldLine<S>) -> Self {
        Self { cursor: Cursor::new(line), tables: Tables::default(), rates: line.geometry().field().room() }
    }

    pub(super) fn at_gamma_here(&mut self, gamma: S) -> Result<SceneSample<S>, OutsideRun<S>> {
        let (window, place) = self.cursor.at_gamma(gamma)?;
        Ok(SceneSample { gamma, ..self.in_window(window, place) })
    }

    pub(super) fn at_value_here(&mut self, a: usize, value: S) -> Result<SceneSample<S>, OutsideRun<S>> {
        let Reached { window, value: value_inside, .. } = self.cursor.at_value(a, value)?;
        let line = self.cursor.line;
        let [start, end] = [window, window + 1].map(|joint| line.joint(joint).q[a] - value_inside);
        let length = line.windows[window].length();
        let place = if start == S::ZERO {
            S::ZERO
        } else if end == S::ZERO {
            length
        } else {
            let least = self.least(window);
            root([S::ZERO, start], [length, end], least, |place| self.in_window(window, place).q[a] - value_inside)
        };
        let mut sample = self.in_window(window, place);
        sample.q[a] = value;
        Ok(sample)
    }

    /// Whether coordinate `a` grows, or falls, from window to window.
    pub fn is_monotonic(&self, a: usize) -> bool {
        let joints = || self.cursor.line.views().map(|view| view.end.q[a] - view.start.q[a]);
        joints().all(|change| change > S::ZERO) || joints().all(|change| change < S::ZERO)
    }

    /// The distance in γ that counts as none.
    fn least(&self, window: usize) -> S {
        let (line, window) = (self.cursor.line, &self.cursor.line.windows[window]);
        let gamma = line.gamma_i.abs().max(window.gamma[1]);
        let digits = S::from(0.1_f64.powi(line.digits as i32));
        S::EPSILON.max(digits) * gamma.max(window.length())
    }

    /// The world-line at `place`, which is γ from the start of a window.
    fn in_window(&mut self, window: usize, place: S) -> SceneSample<S> {
        let (line, [first, last]) = (self.cursor.line, self.cursor.line.windows[window].gamma);
        let gamma = line.gamma_i + first + place;
        // The end of the run is known exactly.
        if place == last - first && window + 1 == line.windows.len() {
            let Start { q, q_dot, p } = line.end();
            return SceneSample { gamma: line.gamma_f(), q, q_dot, p };
        }
        let Start { q, p, .. } = self.prepare(window).at(place, line.geometry());
        let field = line.geometry().field();
        // A curve that leaves the domain between nodes inside it has velocities that mean as little as its positions.
        let _ = field.evaluate(&q, &p, &mut self.rates);
        let q_dot = (0..q.len()).map(|a| field.q_dot(&self.rates, a)).collect();
        SceneSample { gamma, q, q_dot, p }
    }

    /// The curve of a window.
    fn prepare(&mut self, window: usize) -> &Curve<S> {
        let Self { cursor, tables, rates } = self;
        cursor.of_window(window, |line| Curve::new(line, &line.view(window), tables, rates))
    }
}
