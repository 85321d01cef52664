//! The values that the end of a run hands on, so that a run that continues it has the digits of one.

use serde::{Deserialize, Serialize};

/// The rounding errors of the numbers at the end of a run, and the state of the march there.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Handed {
    /// The rounding errors of q^a of all coordinates and of p_a of active ones; nothing where they are not known.
    pub q_low: Vec<f64>,
    /// The same of p_a.
    pub p_low: Vec<f64>,
    /// The march.
    pub march: Option<Marched>,
}

/// The state of a march: the unknowns that are not among q and p, the sizes that changes are compared with, and the
/// slopes that its next first guess continues.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Marched {
    /// The length of its last window.
    pub length: f64,
    /// Velocities where these are unknowns, each with what rounding took from it.
    pub velocities: Vec<[f64; 2]>,
    /// 1/size of every unknown, and of its slope.
    pub inverse_sizes: Vec<[f64; 2]>,
    /// Where ignorable coordinates began, and 1/size of their ways.
    pub ways: Vec<[f64; 2]>,
    /// Slopes on the nodes.
    pub slopes: Vec<Vec<f64>>,
}
