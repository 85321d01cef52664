//! World-lines between their nodes.

use super::OutsideRun;
use super::cursor::Cursor;
use super::legendre::Tables;
use super::scene::{Curve, Sample, sample, sample_at_value};
use crate::geometry::Point;
use crate::number::Real;
use crate::solve::WorldLine;

/// Interpolates one world-line. A window is prepared when a value in it is requested, and kept until a value in another
/// window is.
///
/// ```
/// use geodesic_ivp::case::{Case, builtin};
/// use geodesic_ivp::trajectory::Sampler;
/// use geodesic_ivp::solve::{WorldLine, solve};
///
/// let case = Case::parse("kepler", builtin::text("kepler").expect("it is built in"), &[])?;
/// let line: WorldLine = solve(case.setup())?;
/// let half = Sampler::new(&line).at_gamma(std::f64::consts::PI).expect("inside the run");
/// assert!((half.q[1] + 1.6).abs() < 1e-13 && (half.q_dot[2] + 0.5).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Sampler<'l, S: Real = f64> {
    pub(super) cursor: Cursor<'l, S>,
    pub(super) tables: Tables<S>,
    point: Point<S>,
}

impl<S: Real> Sampler<'_, S> {
    /// The world-line at `gamma`.
    ///
    /// # Errors
    /// [`OutsideRun`] beyond the ends by more than rounding.
    pub fn at_gamma(&mut self, gamma: S) -> Result<Sample<S>, OutsideRun<S>> {
        let (window, place) = self.cursor.at_gamma(gamma)?;
        // The number that was asked for stands in place of the one that was found.
        Ok(Sample { gamma, ..self.in_window(window, place) })
    }

    /// The world-line where coordinate `a`, which grows or falls all the way, has the given value.
    ///
    /// # Errors
    /// [`OutsideRun`] with the range of the coordinate, beyond it by more than rounding.
    pub fn at_value(&mut self, a: usize, value: S) -> Result<Sample<S>, OutsideRun<S>> {
        let reached = self.cursor.at_value(a, value)?;
        let line = self.cursor.line;
        let (curve, point) = self.of_window(reached.window);
        let mut sample = sample_at_value(line, (a, &reached), curve, point);
        sample.q[a] = value;
        Ok(sample)
    }
}

impl<'l, S: Real> Sampler<'l, S> {
    /// A sampler of `line`.
    pub fn new(line: &'l WorldLine<S>) -> Self {
        Self::with_tables(line, Tables::default())
    }

    pub(super) fn with_tables(line: &'l WorldLine<S>, tables: Tables<S>) -> Self {
        Self { cursor: Cursor::new(line), tables, point: line.geometry().point() }
    }

    /// The world-line at `place`, which is γ from the start of a window.
    pub(super) fn in_window(&mut self, window: usize, place: S) -> Sample<S> {
        let line = self.cursor.line;
        let (curve, point) = self.of_window(window);
        sample(line, window, curve, place, point)
    }

    /// The curve of a window, and a point to compute in.
    pub(super) fn of_window(&mut self, window: usize) -> (&Curve<S>, &mut Point<S>) {
        let Self { cursor, tables, point } = self;
        (cursor.of_window(window, |line| Curve::new(line, &line.view(window), tables, point)), point)
    }
}
