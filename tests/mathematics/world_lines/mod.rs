//! Critical points in scenes of n coordinates.

mod accuracy;
mod atlas;
mod backward;
mod conformal;
mod convergence;
mod diagnostics;
mod ends;
mod engine;
mod engine_accuracy;
mod engine_ends;
mod engine_windows;
mod events;
mod explicit_time;
mod features;
mod gaps;
mod kinks;
mod one_coordinate;
mod overflow;
mod reasons;
mod samples;
mod schwarzschild;
mod shipped_scenes;
mod stops;
mod tolerance;
mod units;
mod work_precision;
