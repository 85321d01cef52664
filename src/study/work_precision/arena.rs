//! The arena of methods: the world-line over one length, and its reference.

use super::{OUTPUTS, RowErrors, RowStatus};
use crate::case::Case;
use crate::methods::{Output, Problem, State, States};
use crate::number::norm::larger;
use crate::number::{Extended, Real};
use crate::reference::{ReferenceEnds, ReferenceTrajectory};
use crate::solve::{Limit, Setup};
use crate::study::subject::{Subject, length_of, norm_and_first_rate, sizes};

/// With an error above this share of the size of a coordinate, a setting has no result. The size is the largest |x|,
/// and of t and the ignorable coordinates of a scene the largest distance from the start.
const INACCURATE: f64 = 0.1;

/// The problem on which all methods are compared: the world-line over one length, and its reference.
pub struct Arena {
    pub(super) problem: Problem,
    /// The settings of a solver, without those of one scheme only.
    pub(super) setup: Setup,
    reference: ReferenceTrajectory<Extended>,
    /// The sizes of the coordinates, by which errors are judged: the largest |x| at the points of output, and of t and
    /// the ignorable ones of a scene the largest distance from the start.
    pub sizes: Vec<f64>,
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
        let subject = Subject::new(case);
        let mut exact = subject.exact.clone();
        // The length in γ to a time is not known, but it is about as long as the time.
        let extent = match (exact.limit, exact.origin) {
            (Limit::Value { value, .. }, Some((_, origin))) => (value - origin).to_f64(),
            _ => 1.0,
        };
        exact.settings.digits = digits(extent);
        let length = length.map_or_else(|| length_of(&exact).map(|length| length.to_f64()), Ok)?;
        let place = &exact.place;
        let reference = ReferenceTrajectory::new(&place.geometry, &place.start, length.into(), digits(length))?;
        let problem = subject.problem(&subject.plain.place, length);
        let output = Output::even(OUTPUTS);
        let points = output.gamma(length).map(|gamma| reference.at(gamma.into()).in_f64().q);
        let sizes = sizes(&subject.plain.place, points);
        Ok(Self { problem, setup: subject.plain, reference, sizes })
    }

    /// γ_f − γ_i.
    pub fn length(&self) -> f64 {
        self.problem.length
    }

    /// The names of the coordinates.
    pub fn coordinates(&self) -> &[String] {
        self.problem.space.names()
    }

    /// The reference's own estimate of its relative error.
    pub fn reference_error(&self) -> f64 {
        self.reference.error_estimate()
    }

    /// Number of Taylor steps of the reference, by which settings are scaled.
    pub(super) fn scale(&self) -> f64 {
        self.reference.steps() as f64
    }

    /// The largest errors of states at the points of `output`.
    pub(super) fn errors(&self, output: &Output, states: &States) -> RowErrors {
        let mut largest = RowErrors { q: vec![0.0; self.sizes.len()], delta_k: 0.0 };
        for (gamma, state) in output.gamma(self.length()).zip(states.iter()) {
            let RowErrors { q, delta_k } = self.error(gamma, state);
            largest.q.iter_mut().zip(q).for_each(|(largest, q)| *largest = larger(*largest, q));
            largest.delta_k = larger(largest.delta_k, delta_k);
        }
        largest
    }

    /// The errors of a state.
    pub(super) fn error(&self, gamma: f64, state: State<'_>) -> RowErrors {
        let exact = self.reference.at(gamma.into());
        let error = |(&q, &exact): (&f64, &Extended)| (Extended::from(q) - exact).to_f64().abs();
        let q = state.q.iter().zip(&exact.q).map(error).collect();
        let (exact, [k, _]) = (exact.in_f64(), norm_and_first_rate(&self.problem, state));
        RowErrors { q, delta_k: (k - self.problem.space.norm(&exact.q, &exact.q_dot)).abs() }
    }

    /// Returns true if errors are small enough for a result: a tenth of the size of every coordinate, with a finite K.
    pub fn judge(&self, errors: &RowErrors) -> RowStatus {
        // Written so that a NaN is inaccurate.
        let is_good = errors.q.iter().zip(&self.sizes).all(|(&error, &size)| error <= INACCURATE * size);
        if is_good && errors.delta_k.is_finite() { RowStatus::Converged } else { RowStatus::Inaccurate }
    }
}
