//! What a kind of space-time has to be measured in.

use std::fmt::Debug;

use super::Diagnostics;
use super::verdict::Reason;
use crate::number::Real;
use crate::solve::{Space, WorldLine};

/// A space-time whose world-lines are measured.
pub trait Measurable<S: Real>: Space<S> {
    /// What is measured in it alone.
    type Measures: Debug + Clone;

    /// What is suspicious about a run that was measured.
    fn suspicions(diagnostics: &Diagnostics<S, Self>, run: &WorldLine<S, Self>) -> Vec<Reason>;

    /// What tables have besides charges, ΔG and ΔK.
    fn further(measures: &Self::Measures) -> Further<'_, S>;
}

/// What tables have besides charges, ΔG and ΔK.
#[derive(Debug, Clone)]
pub struct Further<'m, S> {
    /// The deviation of the energy, which takes the place of that of K.
    pub delta_energy: Option<&'m [S]>,
    /// Further rows with their names.
    pub rows: Vec<(&'m str, &'m [S])>,
}
