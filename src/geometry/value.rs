//! Numbers of a scene that are given as formulas, such as `pi/3`.

use super::parts;
use super::text::{GeometryError, Place};
use crate::number::Real;

/// The value of a formula in the `parameters` of a scene and no variables.
///
/// # Errors
/// [`GeometryError::Formula`] if there is a mistake in it, or [`GeometryError::NotFinite`].
pub fn value_of<S: Real>(text: &str, parameters: &[(String, String)]) -> Result<S, GeometryError> {
    let values = parts::parameters(parameters)?;
    parts::constant(text, &values, Place::Parameter(String::new()))
}
