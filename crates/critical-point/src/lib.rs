//! The middle of [geodesic-ivp](https://crates.io/crates/geodesic-ivp): the doubled action, its critical points, and
//! what judges them. A package of its own, so that it is compiled beside the others; programs use `geodesic_ivp`, which
//! hands all of this on.

pub mod action;
pub mod diagnostics;
pub mod errors;
mod numeric;
pub mod sampling;
pub mod solve;
pub mod tables;

pub use numeric::{Numeric, NumericIn};
pub use solve::solve;

// So that modules have one path in all packages.
use geodesic_ivp_engine::{
    banded, compiled, enclosure, geodesic, geometry, lobatto, metric, norm, potential, reference, root, runge_kutta,
    sbp, scalar, sparse,
};
