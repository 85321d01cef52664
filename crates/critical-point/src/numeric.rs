//! The numbers that everything is compiled for.

use crate::diagnostics::gaps::Gapped;
use crate::diagnostics::{Diagnosed, Suspected};
use crate::errors::Compared;
use crate::geometry::{Formulated, Geometry};
use crate::metric::Metric;
use crate::potential::Parsed;
use crate::reference::{Crossed, Traced};
use crate::sampling::{Sampled, Streamed, Watched};
use crate::solve::{Arithmetic, Solved};
use crate::tables::{Tabled, WrittenIn};

/// A kind of numbers in which scenes are formulated, solved, measured, sampled and compared: `f64` and
/// [`Extended`](crate::scalar::Extended). Code above this package that is generic in its numbers asks for this. What it
/// calls is then compiled here, once, and not again by everything that calls it.
pub trait Numeric:
    Arithmetic
    + Solved<Metric<Self>>
    + Solved<Geometry<Self>>
    + Parsed
    + Formulated
    + Traced<Metric<Self>>
    + Traced<Geometry<Self>>
    + Crossed
    + Diagnosed
    + Suspected<Metric<Self>>
    + Suspected<Geometry<Self>>
    + Gapped<Metric<Self>>
    + Gapped<Geometry<Self>>
    + Sampled<Metric<Self>>
    + Sampled<Geometry<Self>>
    + Streamed
    + Watched
    + Tabled
    + WrittenIn<Metric<Self>>
    + WrittenIn<Geometry<Self>>
    + Compared
{
}

impl<S> Numeric for S where
    S: Arithmetic
        + Solved<Metric<S>>
        + Solved<Geometry<S>>
        + Parsed
        + Formulated
        + Traced<Metric<S>>
        + Traced<Geometry<S>>
        + Crossed
        + Diagnosed
        + Suspected<Metric<S>>
        + Suspected<Geometry<S>>
        + Gapped<Metric<S>>
        + Gapped<Geometry<S>>
        + Sampled<Metric<S>>
        + Sampled<Geometry<S>>
        + Streamed
        + Watched
        + Tabled
        + WrittenIn<Metric<S>>
        + WrittenIn<Geometry<S>>
        + Compared
{
}
