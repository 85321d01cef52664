//! The programs that the formulas of a scene compile to. Cases with the same formulas share them, as most rows of a
//! table do: a number of the start varies, say, and formulas take long to be read and differentiated.

use std::sync::{Arc, OnceLock};

use crate::geometry::{Geometry, GeometryError, GeometryText, Jump, Steps, WrittenRates, value_of};
use crate::number::{Extended, Kind, Real};

/// The programs of a scene, in every precision that was asked for.
#[derive(Debug)]
pub(crate) struct Compiled {
    text: GeometryText,
    /// The parameters that formulas of the scene depend on.
    parameters: Vec<String>,
    is_of_x: bool,
    rough: Geometry,
    exact: OnceLock<Result<Geometry<Extended>, GeometryError>>,
    /// Hamilton's equations as they are written, those of the motion and those of its way back.
    rates: [OnceLock<Option<WrittenRates<Extended>>>; 2],
    steps: OnceLock<Steps>,
}

impl Compiled {
    /// The programs of these formulas: `known`, if it has them.
    ///
    /// # Errors
    /// [`GeometryError`] with the place of the mistake.
    pub(super) fn new(
        text: &GeometryText,
        is_of_x: bool,
        known: Option<&Arc<Self>>,
    ) -> Result<Arc<Self>, GeometryError> {
        let is_same = |known: &&Arc<Self>| known.is_of_x == is_of_x && known.text.is_like(text, &known.parameters);
        if let Some(known) = known.filter(is_same) {
            // Parameters that no formula depends on are numbers, too.
            value_of::<f64>("0", &text.parameters)?;
            return Ok(Arc::clone(known));
        }
        Ok(Arc::new(Self {
            text: text.clone(),
            parameters: text.parameters_in_use(),
            is_of_x,
            rough: compiled(text, is_of_x)?,
            exact: OnceLock::new(),
            rates: Default::default(),
            steps: OnceLock::new(),
        }))
    }

    /// The geometry, whose determinants may have any sign.
    ///
    /// # Errors
    /// [`GeometryError`] if the formulas make none in this precision, as they do in that of doubles.
    pub(super) fn geometry<S: Real>(&self) -> Result<Geometry<S>, GeometryError> {
        let exact = || self.exact.get_or_init(|| compiled(&self.text, self.is_of_x)).clone();
        S::choose::<MaybeGeometry>(|| Ok(self.rough.clone()), exact)
    }

    /// Hamilton's equations as they are written, in 70 digits; `None` if these have none.
    pub(crate) fn rates(&self, is_backward: bool) -> Option<WrittenRates<Extended>> {
        let rates = &self.rates[usize::from(is_backward)];
        rates.get_or_init(|| WrittenRates::new(&self.text, is_backward).ok()).clone()
    }

    /// The places where the metric or the one-form jumps on lines from a point.
    pub(super) fn jumps(&self, from: &[f64]) -> Vec<Jump> {
        self.steps.get_or_init(|| Steps::new(&self.text)).clone().jumps(from)
    }
}

/// A geometry, or why there is none.
struct MaybeGeometry;

impl Kind for MaybeGeometry {
    type Of<S: Real> = Result<Geometry<S>, GeometryError>;
}

fn compiled<S: Real>(text: &GeometryText, is_of_x: bool) -> Result<Geometry<S>, GeometryError> {
    if is_of_x { Geometry::of_x(text) } else { Geometry::new(text) }
}
