//! What methods are compared on: the world-line over one length, and its reference.

use super::course::Course;
use super::family::Family;
use super::run::Job;
use super::{OUTPUTS, RowErrors, RowStatus};
use crate::case::Case;
use crate::case::scene::SceneCase;
use crate::geometry::Geometry;
use crate::geometry::metric::Metric;
use crate::methods::{Output, Setting};
use crate::number::norm::larger;
use crate::number::{Extended, Real};
use crate::reference::ReferenceEnds;
use crate::study::line::Line;

/// With an error above this share of the size of a coordinate, a setting has no result. The size is the largest |x|,
/// and of t and the ignorable coordinates of a scene the largest distance from the start.
const INACCURATE: f64 = 0.1;

/// The problem on which all methods are compared: the world-line over one length, and its reference.
pub struct Arena {
    world: Box<dyn World>,
    coordinates: Vec<String>,
    length: f64,
    reference_error: f64,
    /// Number of Taylor steps of the reference.
    steps: usize,
    /// Largest values at the points of output.
    sizes: Vec<f64>,
}

/// A world-line with its reference.
pub(super) trait World: Send + Sync {
    /// The names of the coordinates.
    fn coordinates(&self) -> Vec<String>;

    /// γ_f − γ_i.
    fn length(&self) -> f64;

    /// The reference's own estimate of its relative error, and the number of its Taylor steps.
    fn reference(&self) -> (f64, usize);

    /// The coordinates and K of the reference; t of a case is counted from the start.
    fn exact(&self, gamma: f64) -> (Vec<Extended>, f64);

    /// How far a coordinate is from where its size is counted from.
    fn distance(&self, a: usize, q: f64) -> f64;

    /// The `sizes` of coordinates, each the largest of all that have its unit.
    fn shared(&self, sizes: Vec<f64>) -> Vec<f64>;

    /// A method in a setting.
    fn job<'w>(&'w self, family: &Family, setting: Setting, output: Output) -> Box<dyn Job + 'w>;
}

/// The coordinates of a point of a world-line, and its K.
pub(super) struct Place {
    pub(super) q: Vec<f64>,
    pub(super) k: f64,
}

impl Arena {
    /// The case's own world-line, or that of another length in γ.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if the geodesic does not go so far.
    pub fn new(case: &Case, length: Option<f64>) -> Result<Self, ReferenceEnds> {
        Ok(Self::of(Course::<Metric>::new(Line::new(case, false), length)?))
    }

    /// The scene's own world-line, or that of another length in γ.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_scene(case: &SceneCase, length: Option<f64>) -> Result<Self, ReferenceEnds> {
        Ok(Self::of(Course::<Geometry>::new(Line::new(case, case.is_lifted()), length)?))
    }

    fn of(world: impl World + 'static) -> Self {
        let (coordinates, length) = (world.coordinates(), world.length());
        let mut sizes = vec![0.0_f64; coordinates.len()];
        for gamma in Output::even(OUTPUTS).gamma(length) {
            let (exact, _) = world.exact(gamma);
            for (a, (size, exact)) in sizes.iter_mut().zip(exact).enumerate() {
                *size = size.max(world.distance(a, exact.to_f64()));
            }
        }
        let (sizes, (reference_error, steps)) = (world.shared(sizes), world.reference());
        Self { world: Box::new(world), coordinates, length, reference_error, steps, sizes }
    }

    /// A method in a setting.
    pub(super) fn job(&self, family: &Family, setting: Setting, output: Output) -> Box<dyn Job + '_> {
        self.world.job(family, setting, output)
    }

    /// γ_f − γ_i.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The names of the coordinates.
    pub fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    /// The reference's own estimate of its relative error.
    pub fn reference_error(&self) -> f64 {
        self.reference_error
    }

    /// Number of Taylor steps of the reference, by which settings are scaled.
    pub(super) fn scale(&self) -> f64 {
        self.steps as f64
    }

    /// The largest size of a coordinate.
    pub(super) fn size(&self) -> f64 {
        self.sizes.iter().copied().fold(0.0, f64::max)
    }

    /// The errors of `places` at the points of `output`.
    pub(super) fn errors(&self, output: &Output, places: &[Place]) -> RowErrors {
        let mut largest = RowErrors { q: vec![0.0; self.coordinates.len()], delta_k: 0.0 };
        for (gamma, place) in output.gamma(self.length).zip(places) {
            let RowErrors { q, delta_k } = self.error(gamma, place);
            largest.q.iter_mut().zip(q).for_each(|(largest, q)| *largest = larger(*largest, q));
            largest.delta_k = larger(largest.delta_k, delta_k);
        }
        largest
    }

    /// The errors of a place.
    pub(super) fn error(&self, gamma: f64, place: &Place) -> RowErrors {
        let (exact, k) = self.world.exact(gamma);
        let error = |(&q, exact): (&f64, Extended)| (Extended::from(q) - exact).to_f64().abs();
        RowErrors { q: place.q.iter().zip(exact).map(error).collect(), delta_k: (place.k - k).abs() }
    }

    /// The sizes of the coordinates, by which errors are judged: the largest |x|, and of t and the ignorable ones of a
    /// scene the largest distance from the start.
    pub fn sizes(&self) -> &[f64] {
        &self.sizes
    }

    /// Whether errors are small enough for a result: a tenth of the size of every coordinate, with a finite K.
    pub fn judge(&self, errors: &RowErrors) -> RowStatus {
        // Written so that a NaN is inaccurate.
        let is_good = errors.q.iter().zip(&self.sizes).all(|(&error, &size)| error <= INACCURATE * size);
        if is_good && errors.delta_k.is_finite() { RowStatus::Converged } else { RowStatus::Inaccurate }
    }
}
