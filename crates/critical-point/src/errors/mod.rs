//! How far a run is from the world-line of the continuum, by a second solve.

mod one;
mod run_error;
mod scene;
mod stepped_over;

pub use one::run_error;
pub use run_error::{Judge, RunError};
pub use scene::{Reach, scene_error};

use crate::metric::Metric;
use crate::sampling::Sample;
use crate::solve::{Setup, Solution, WorldLine};

crate::compiled! {
    /// Numbers in which runs are compared.
    pub trait Compared {
        fn run_error(
            setup: &Setup<f64, Metric>,
            solution: &Solution<Self>,
            samples: &[Sample<Self>],
        ) -> Option<RunError> = one::run_error_here;
        fn scene_error(line: &WorldLine<Self>) -> Option<RunError> = scene::scene_error_here;
    }
}
