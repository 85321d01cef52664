//! A reference trajectory of a scene that ends early.

use std::fmt;

use super::super::EndReason;

/// The error that the reference trajectory of a scene ends before the end of the requested range.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneReferenceEnds {
    /// Why it ends.
    pub reason: EndReason,
    /// γ − γ_i where it ends.
    pub gamma: f64,
    /// The coordinates there, with their names.
    pub q: Vec<(String, f64)>,
}

impl fmt::Display for SceneReferenceEnds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the reference trajectory ends at gamma - gamma_i = {:.6}", self.gamma)?;
        for (name, value) in &self.q {
            write!(f, ", {name} = {value:.6e}")?;
        }
        write!(f, ": {}", self.reason.in_words("a formula", "the value of the coordinate"))
    }
}

impl std::error::Error for SceneReferenceEnds {}
