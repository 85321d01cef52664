//! The pictures of `--plot`, many of them as in the paper.

mod convergence;
mod look;
mod of_x;
mod run;
mod scan;
mod stability;
mod work_precision;

pub use convergence::errors;
pub use run::{names_of_run, of_run};
pub use scan::{Varied, scan};
pub use stability::{last_node, sawtooth_onset, stability_map};
pub use work_precision::{Work, drift, work_precision};
