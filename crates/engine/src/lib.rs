//! The lowest part of [geodesic-ivp](https://crates.io/crates/geodesic-ivp): numbers, formulas, geometry, operators,
//! and what integrates motion. A package of its own, so that it is compiled beside what stands above it; programs use
//! `geodesic_ivp`, which hands all of this on.

mod compiled;

pub mod banded;
#[doc(hidden)]
pub mod enclosure;
pub mod expr;
pub mod geodesic;
pub mod geometry;
pub mod lobatto;
pub mod methods;
pub mod metric;
#[doc(hidden)]
pub mod norm;
pub mod potential;
pub mod reference;
#[doc(hidden)]
pub mod root;
#[doc(hidden)]
pub mod runge_kutta;
pub mod sbp;
pub mod scalar;
#[doc(hidden)]
pub mod similar;
pub mod sparse;
#[doc(hidden)]
pub mod vector;
