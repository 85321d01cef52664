//! How far a run is from the world-line of the continuum, by a second solve.

mod one;
mod run_error;
mod scene;
mod stepped_over;

pub use one::run_error;
pub use run_error::{Judge, RunError};
pub use scene::{Reach, scene_error};
