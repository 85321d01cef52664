//! Numbers of a case.

use crate::geometry::{GeometryError, value_of};
use crate::number::Real;

/// A number as it is written: a decimal with all its digits, or a formula in the parameters of the scene, such as
/// `sqrt(19)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Quantity(String);

impl Quantity {
    pub(super) fn new(text: impl Into<String>) -> Self {
        Self(text.into())
    }

    /// The text as it is written.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Its value in `S`, rounded once if it is a decimal.
    ///
    /// # Errors
    /// [`GeometryError::Formula`] if there is a mistake in it, or [`GeometryError::NotFinite`].
    pub fn value<S: Real>(&self, parameters: &[(String, String)]) -> Result<S, GeometryError> {
        value_of(&self.0, parameters)
    }
}
