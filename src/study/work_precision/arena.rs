//! The arena of methods: the world-line over one length, and its reference.

use super::course::Course;
use super::family::Family;
use super::run::{Place, Timed};
use super::{OUTPUTS, RowErrors, RowStatus};
use crate::case::Case;
use crate::methods::{Output, Problem, Setting};
use crate::number::norm::larger;
use crate::number::{Extended, Real};
use crate::reference::ReferenceEnds;
use crate::study::line::Line;
use crate::study::space::distance;

/// With an error above this share of the size of a coordinate, a setting has no result. The size is the largest |x|,
/// and of t and the ignorable coordinates of a scene the largest distance from the start.
const INACCURATE: f64 = 0.1;

/// The problem on which all methods are compared: the world-line over one length, and its reference.
pub struct Arena {
    course: Course,
    /// Largest values at the points of output.
    sizes: Vec<f64>,
}

impl Arena {
    /// The case's own world-line, or that of another length in γ.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if the geodesic does not go so far.
    pub fn new(case: &Case, length: Option<f64>) -> Result<Self, ReferenceEnds> {
        Ok(Self::of(Course::new(Line::new(case), length)?))
    }

    fn of(course: Course) -> Self {
        let Problem { space, start, length, .. } = &course.problem;
        let mut sizes = vec![0.0_f64; space.dimension()];
        for gamma in Output::even(OUTPUTS).gamma(*length) {
            let (exact, _) = course.exact(gamma);
            for (a, (size, exact)) in sizes.iter_mut().zip(exact).enumerate() {
                *size = size.max(distance(&course.setup.place, a, exact.to_f64()));
            }
        }
        let sizes = space.shared(&start.q, &sizes);
        Self { course, sizes }
    }

    /// A method in a setting.
    pub(super) fn timed(&self, family: &Family, setting: Setting, output: Output) -> Timed<'_> {
        Timed::new(&self.course, family, setting, output)
    }

    /// γ_f − γ_i.
    pub fn length(&self) -> f64 {
        self.course.problem.length
    }

    /// The names of the coordinates.
    pub fn coordinates(&self) -> &[String] {
        self.course.problem.space.names()
    }

    /// The reference's own estimate of its relative error.
    pub fn reference_error(&self) -> f64 {
        self.course.reference.error_estimate()
    }

    /// Number of Taylor steps of the reference, by which settings are scaled.
    pub(super) fn scale(&self) -> f64 {
        self.course.reference.steps() as f64
    }

    /// The largest size of a coordinate.
    pub(super) fn size(&self) -> f64 {
        self.sizes.iter().copied().fold(0.0, f64::max)
    }

    /// The errors of `places` at the points of `output`.
    pub(super) fn errors(&self, output: &Output, places: &[Place]) -> RowErrors {
        let mut largest = RowErrors { q: vec![0.0; self.sizes.len()], delta_k: 0.0 };
        for (gamma, place) in output.gamma(self.length()).zip(places) {
            let RowErrors { q, delta_k } = self.error(gamma, place);
            largest.q.iter_mut().zip(q).for_each(|(largest, q)| *largest = larger(*largest, q));
            largest.delta_k = larger(largest.delta_k, delta_k);
        }
        largest
    }

    /// The errors of a place.
    pub(super) fn error(&self, gamma: f64, place: &Place) -> RowErrors {
        let (exact, k) = self.course.exact(gamma);
        let error = |(&q, exact): (&f64, Extended)| (Extended::from(q) - exact).to_f64().abs();
        RowErrors { q: place.q.iter().zip(exact).map(error).collect(), delta_k: (place.k - k).abs() }
    }

    /// The sizes of the coordinates, by which errors are judged: the largest |x|, and of t and the ignorable ones of a
    /// scene the largest distance from the start.
    pub fn sizes(&self) -> &[f64] {
        &self.sizes
    }

    /// Returns true if errors are small enough for a result: a tenth of the size of every coordinate, with a finite K.
    pub fn judge(&self, errors: &RowErrors) -> RowStatus {
        // Written so that a NaN is inaccurate.
        let is_good = errors.q.iter().zip(&self.sizes).all(|(&error, &size)| error <= INACCURATE * size);
        if is_good && errors.delta_k.is_finite() { RowStatus::Converged } else { RowStatus::Inaccurate }
    }
}
