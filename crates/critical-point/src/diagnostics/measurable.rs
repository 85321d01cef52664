//! What a kind of space-time has to be measured in.

use std::fmt::Debug;

use super::Diagnostics;
use super::verdict::Reason;
use crate::geometry::Geometry;
use crate::metric::Metric;
use crate::scalar::Real;
use crate::solve::{Space, WorldLine};

/// A space-time whose world-lines are measured.
pub trait Measurable<S: Real>: Space<S> {
    /// What is measured in it alone.
    type Measures: Debug + Clone;

    /// What is suspicious about a run that was measured.
    #[doc(hidden)]
    fn suspicions(diagnostics: &Diagnostics<S, Self>, run: &WorldLine<S, Self>) -> Vec<Reason>;

    /// What tables have besides charges, ΔG and ΔK.
    #[doc(hidden)]
    fn further(measures: &Self::Measures) -> Further<'_, S>;
}

/// What tables have besides charges, ΔG and ΔK.
#[doc(hidden)]
#[derive(Debug, Clone)]
pub struct Further<'m, S> {
    /// The deviation of the energy, which takes the place of that of K.
    pub delta_energy: Option<&'m [S]>,
    /// Further rows with their names.
    pub rows: Vec<(&'m str, &'m [S])>,
}

fn suspicions_here<S: Real, G: Measurable<S>>(this: &Diagnostics<S, G>, run: &WorldLine<S, G>) -> Vec<Reason> {
    G::suspicions(this, run)
}

crate::compiled! {
    /// Numbers in which runs are judged.
    pub trait Suspected<G: Measurable> for [Metric, Geometry] {
        fn suspicions(this: &Diagnostics<Self, G>, run: &WorldLine<Self, G>) -> Vec<Reason> = suspicions_here;
    }
}
