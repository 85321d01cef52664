//! The numbers that everything is compiled for.

use crate::diagnostics::gaps::{Enclosed, Gapped};
use crate::diagnostics::{Diagnosed, Measurable, Suspected};
use crate::errors::Compared;
use crate::geometry::{Formulated, Geometry};
use crate::metric::Metric;
use crate::potential::Parsed;
use crate::reference::{Analytic, Crossed, Traced};
use crate::sampling::{Curved, Sampled, Streamed, Watched};
use crate::solve::{Arithmetic, Solved};
use crate::tables::{Tabled, WrittenIn};

/// A kind of numbers in which scenes are formulated, solved, measured, sampled and compared: `f64` and
/// [`Extended`](crate::scalar::Extended). Code above this package that is generic in its numbers asks for this. What it
/// calls is then compiled here, once, and not again by everything that calls it.
pub trait Numeric:
    Arithmetic
    + NumericIn<Metric<Self>>
    + NumericIn<Geometry<Self>>
    + Parsed
    + Formulated
    + Crossed
    + Diagnosed
    + Streamed
    + Watched
    + Tabled
    + Compared
{
}

impl<S> Numeric for S where
    S: Arithmetic
        + NumericIn<Metric<S>>
        + NumericIn<Geometry<S>>
        + Parsed
        + Formulated
        + Crossed
        + Diagnosed
        + Streamed
        + Watched
        + Tabled
        + Compared
{
}

/// A kind of numbers in which world-lines of one kind of space-time are solved, measured, sampled, written and compared
/// with a reference. Code above this package that is generic in the space-time asks for this.
pub trait NumericIn<G: Analytic<Self> + Curved<Self> + Enclosed<Self> + Measurable<Self>>:
    Solved<G> + Traced<G> + Suspected<G> + Gapped<G> + Sampled<G> + WrittenIn<G>
{
}

impl<S, G: Analytic<S> + Curved<S> + Enclosed<S> + Measurable<S>> NumericIn<G> for S where
    S: Solved<G> + Traced<G> + Suspected<G> + Gapped<G> + Sampled<G> + WrittenIn<G>
{
}
