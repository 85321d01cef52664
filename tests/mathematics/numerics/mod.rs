//! What solves are made of: operators, formulas, metrics and their actions, reference trajectories, the engine, and the
//! methods to compare with.

mod action;
mod curvature;
mod elementary_functions;
mod engine;
mod engine_companion;
mod engine_ends;
mod engine_windows;
mod field;
mod formula;
mod formulas;
mod methods;
mod orbits;
mod presets;
mod proof;
mod proof_digits;
mod proof_events;
mod proof_intervals;
mod proof_sets;
mod published;
mod reference;
mod rounding;
mod sbp_identities;
mod texts;
