//! Scenes of n coordinates: reference trajectories, Hamilton's equations, the action, the metrics by name.

mod common;
mod newton;
mod reference;
mod relativity;
