//! What methods are compared on: the world-line over one length, and its reference.

use super::{OUTPUTS, RowErrors, RowStatus, run};
use crate::case::scene::SceneCase;
use crate::case::{Case, End};
use crate::geodesic::Invariants;
use crate::geometry::Geometry;
use crate::methods::{Output, Problem, SceneState, State};
use crate::norm::larger;
use crate::reference::{ReferenceEnds, ReferencePoint, ReferenceTrajectory};
use crate::scalar::{Extended, Real};
use crate::solve::Setup;
use crate::study::scene_length::length_of;

/// With an error above this share of the size of a coordinate, a setting has no result. The size is the largest |x|,
/// and of t and the ignorable coordinates of a scene the largest distance from the start.
const INACCURATE: f64 = 0.1;

/// The problem on which all methods are compared: the world-line over one length, and its reference.
pub struct Arena {
    pub(super) world: World,
    coordinates: Vec<String>,
    length: f64,
    reference_error: f64,
    /// Number of Taylor steps of the reference.
    steps: usize,
    /// Largest values at the points of output.
    sizes: Vec<f64>,
}

/// A world-line of a case or of a scene.
pub(super) enum World {
    One(Box<One>),
    Scene(Box<Scene>),
}

/// A case of one coordinate.
pub(super) struct One {
    pub(super) problem: Problem,
    pub(super) case: Case,
    invariants: Invariants,
    reference: ReferenceTrajectory<Extended>,
}

/// A scene.
pub(super) struct Scene {
    pub(super) problem: Problem<Geometry>,
    pub(super) setup: Setup,
    reference: ReferenceTrajectory<Extended, Geometry<Extended>>,
}

/// The coordinates of a point of a world-line, and its K.
pub(super) struct Place {
    q: Vec<f64>,
    k: f64,
}

/// Sixteen digits of the coordinates at the end, and four more to judge them. Errors of the phase grow with the square
/// of the length.
fn digits(length: f64) -> u32 {
    (20.0 + (2.0 * length.max(1.0).log10()).ceil()) as u32
}

impl Arena {
    /// The case's own world-line, or that of another length in γ.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if the geodesic does not go so far.
    pub fn new(case: &Case, length: Option<f64>) -> Result<Self, ReferenceEnds> {
        let metric = case.metric::<Extended>();
        let initial = case.initial_data::<Extended>();
        let length = match (length, case.end::<Extended>()) {
            (Some(length), _) => length,
            (None, End::Length(length)) => length.to_f64(),
            (None, End::Duration(duration)) => {
                ReferenceTrajectory::length_of(&metric, &initial, 0, duration, digits(duration.to_f64()))?.to_f64()
            }
        };
        let reference = ReferenceTrajectory::new(&metric, &initial, length.into(), digits(length))?;
        let problem = Problem { space: case.metric().into(), start: case.initial_data(), length };
        let invariants = problem.start.invariants(&problem.space);
        let (reference_error, steps) = (reference.error_estimate(), reference.steps());
        let world = World::One(Box::new(One { problem, case: run::plain(case), invariants, reference }));
        let coordinates = ["t", "x"].map(str::to_owned).to_vec();
        Ok(Self { world, coordinates, length, reference_error, steps, sizes: Vec::new() }.sized())
    }

    /// The scene's own world-line, or that of another length in γ.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if it does not go so far.
    pub fn of_scene(case: &SceneCase, length: Option<f64>) -> Result<Self, ReferenceEnds> {
        let mut exact: Setup<Extended> = case.setup();
        exact.settings.digits = digits(1.0);
        let length = length.map_or_else(|| length_of(&exact).map(|length| length.to_f64()), Ok)?;
        let place = &exact.place;
        let reference = ReferenceTrajectory::new(&*place.geometry, &place.start, length.into(), digits(length))?;
        let setup: Setup = case.setup();
        let problem = Problem { space: setup.place.geometry.clone(), start: (*setup.place.start).clone(), length };
        let (reference_error, steps) = (reference.error_estimate(), reference.steps());
        let coordinates = case.coordinates();
        let world = World::Scene(Box::new(Scene { problem, setup, reference }));
        Ok(Self { world, coordinates, length, reference_error, steps, sizes: Vec::new() }.sized())
    }

    /// With the sizes of its coordinates.
    fn sized(mut self) -> Self {
        let mut sizes = vec![0.0_f64; self.coordinates.len()];
        for gamma in Output::even(OUTPUTS).gamma(self.length) {
            let (exact, _) = self.exact(gamma);
            let origin = |a: usize| match &self.world {
                World::Scene(scene) if !scene.problem.space.active().contains(&a) => scene.problem.start.q[a],
                _ => 0.0,
            };
            for (a, (size, exact)) in sizes.iter_mut().zip(exact).enumerate() {
                *size = size.max((exact.to_f64() - origin(a)).abs());
            }
        }
        self.sizes = match &self.world {
            World::One(_) => sizes,
            World::Scene(scene) => scene.problem.space.shared(&scene.problem.start.q, &sizes),
        };
        self
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

    /// The coordinates and K of the reference; t of a case is counted from the start.
    fn exact(&self, gamma: f64) -> (Vec<Extended>, f64) {
        match &self.world {
            World::One(one) => {
                let ReferencePoint { elapsed, x, .. } = one.reference.at(gamma.into());
                (vec![elapsed, x], one.invariants.k)
            }
            World::Scene(scene) => {
                let point = scene.reference.at(gamma.into());
                let [q, q_dot] = [&point.q, &point.q_dot].map(|row| row.iter().map(|v| v.to_f64()).collect::<Vec<_>>());
                let k = scene.problem.space.norm(&q, &q_dot);
                (point.q, k)
            }
        }
    }

    /// A state as what it is judged by.
    pub(super) fn place(&self, state: &State) -> Place {
        let World::One(one) = &self.world else { unreachable!("a scene has other states") };
        let q_t = one.invariants.q_t;
        let k = q_t * (q_t / one.problem.space.g00(state.x)) - state.w * state.w;
        Place { q: vec![state.elapsed, state.x], k }
    }

    /// The same in a scene.
    pub(super) fn place_of(&self, state: SceneState) -> Place {
        let World::Scene(scene) = &self.world else { unreachable!("a case has other states") };
        let (geometry, SceneState { q, p }) = (&scene.problem.space, state);
        let k = geometry.velocities(&q, &p).map_or(f64::NAN, |q_dot| geometry.norm(&q, &q_dot));
        Place { q, k }
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
        let (exact, k) = self.exact(gamma);
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
