//! World-lines between their nodes.

use super::OutsideRun;
use super::cursor::Cursor;
use super::curved::Curved;
use super::legendre::Tables;
use crate::geometry::metric::Metric;
use crate::number::Real;
use crate::solve::WorldLine;

/// Interpolates one world-line. A window is prepared when a value in it is requested, and kept until a value in another
/// window is.
///
/// ```
/// use geodesic_ivp::case::{SceneCase, builtin};
/// use geodesic_ivp::trajectory::Sampler;
/// use geodesic_ivp::solve::{WorldLine, solve};
///
/// let case = SceneCase::parse("kepler", builtin::text("kepler").expect("it is built in"), &[])?;
/// let line: WorldLine = solve(case.setup())?;
/// let half = Sampler::new(&line).at_gamma(std::f64::consts::PI).expect("inside the run");
/// assert!((half.q[1] + 1.6).abs() < 1e-13 && (half.q_dot[2] + 0.5).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Sampler<'l, S: Real = f64, G: Curved<S> = Metric<S>> {
    pub(super) cursor: Cursor<'l, S, G, G::Curve>,
    pub(super) tables: Tables<S>,
    room: G::Rates,
}

impl<S: Real, G: Curved<S>> Sampler<'_, S, G> {
    /// The world-line at `gamma`.
    ///
    /// # Errors
    /// [`OutsideRun`] beyond the ends by more than rounding.
    pub fn at_gamma(&mut self, gamma: S) -> Result<G::Sample, OutsideRun<S>> {
        let (window, place) = self.cursor.at_gamma(gamma)?;
        Ok(G::as_asked(self.in_window(window, place), Some(gamma), None))
    }

    /// The world-line where coordinate `a`, which grows or falls all the way, has the given value. In one coordinate
    /// `a` is 0, that of t.
    ///
    /// # Errors
    /// [`OutsideRun`] with the range of the coordinate, beyond it by more than rounding.
    ///
    /// # Panics
    /// In one coordinate if `a` is not 0.
    pub fn at_value(&mut self, a: usize, value: S) -> Result<G::Sample, OutsideRun<S>> {
        let reached = self.cursor.at_value(a, value)?;
        let line = self.cursor.line;
        let (curve, room) = self.of_window(reached.window);
        let sample = G::sample_at_value(line, (a, &reached), curve, room);
        Ok(G::as_asked(sample, None, Some((a, value))))
    }
}

impl<'l, S: Real, G: Curved<S>> Sampler<'l, S, G> {
    /// A sampler of `line`.
    pub fn new(line: &'l WorldLine<S, G>) -> Self {
        Self::with_tables(line, Tables::default())
    }

    pub(super) fn with_tables(line: &'l WorldLine<S, G>, tables: Tables<S>) -> Self {
        Self { cursor: Cursor::new(line), tables, room: line.geometry().rates_room() }
    }

    /// Whether coordinate `a` grows, or falls, from window to window.
    pub fn is_monotonic(&self, a: usize) -> bool {
        let joints = || self.cursor.line.views().map(|view| view.end.q[a] - view.start.q[a]);
        joints().all(|change| change > S::ZERO) || joints().all(|change| change < S::ZERO)
    }

    /// The world-line at `place`, which is γ from the start of a window.
    pub(super) fn in_window(&mut self, window: usize, place: S) -> G::Sample {
        let line = self.cursor.line;
        let (curve, room) = self.of_window(window);
        G::sample(line, window, curve, place, room)
    }

    /// The curve of a window, and room to compute in.
    pub(super) fn of_window(&mut self, window: usize) -> (&G::Curve, &mut G::Rates) {
        let Self { cursor, tables, room } = self;
        (cursor.of_window(window, |line| G::curve(line, window, tables, room)), room)
    }
}
