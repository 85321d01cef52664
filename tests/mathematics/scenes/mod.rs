//! Scenes of n coordinates: reference trajectories, Hamilton's equations, the action, the metrics by name.

mod action;
mod curvature;
mod field;
mod formulas;
mod methods;
mod newton;
mod presets;
mod reference;
mod relativity;
mod rounding;
mod texts;
