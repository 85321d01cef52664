//! The pictures of `--plot`, many of them as in the paper.

mod convergence;
mod family;
mod fit;
mod hull;
mod look;
mod of_x;
mod run;
mod scan;
mod stability;
mod together;
mod work_precision;

pub use convergence::errors;
pub use family::family;
pub use fit::fit;
pub use hull::{ends_of, hulls, of_hull};
pub use run::{MOST_COLOURS, names_of_run, of_run, places_of_events, section_of_runs};
pub use scan::{Varied, line, scan};
pub use stability::{last_node, sawtooth_onset, stability_map};
pub use together::{MOST_TOGETHER, are_apart, names_of_together, together};
pub use work_precision::{Work, drift, work_precision};
