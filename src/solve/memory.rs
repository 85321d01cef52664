//! How much memory a run takes, estimated before it starts.

use super::setup::{Setup, System};
use crate::action::Form;

/// Numbers kept for every node: the solution, its diagnostics, and what writing the tables needs.
const NUMBERS: f64 = 17.0;
/// Numbers kept for every sample.
const SAMPLE_NUMBERS: f64 = 6.0;
/// Bytes per node of the banded systems of the physical limit, always in `f64`: a fixed part, and one for every order.
const BANDED: [f64; 2] = [45.0, 18.0];
/// The same for the sparse factors of the doubled system.
const DOUBLED: [f64; 2] = [200.0, 950.0];
/// The program itself.
const PROGRAM: f64 = 6e6;

/// About how many bytes solving `setup` and writing its tables takes, with `samples` samples, in the memory of one
/// window if `one_window` says so. The constants come from runs of a hundred thousand nodes, whose memory the estimate
/// meets within a third. With an accuracy asked for, the nodes are not known beforehand and do not count.
pub fn bytes_needed<S>(setup: &Setup<S>, one_window: bool, samples: usize) -> f64 {
    let number = size_of::<S>() as f64;
    let window = setup.n_gamma as f64;
    let nodes = if one_window { window } else { window * setup.windows as f64 };
    let order = setup.sbp.coefficients().map_or(0, |table| table.interior_order) as f64;
    let factors = |[constant, by_order]: [f64; 2]| window * (constant + by_order * order);
    let solver = match (setup.system, setup.form) {
        (System::Doubled, _) => factors(DOUBLED),
        // Two-step leapfrog is explicit.
        (System::PhysicalLimit, Form::Strong) if order == 2.0 => 0.0,
        (System::PhysicalLimit, _) => factors(BANDED),
    };
    PROGRAM + number * (NUMBERS * nodes + SAMPLE_NUMBERS * samples as f64) + solver
}
