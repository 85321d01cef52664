//! Critical points in scenes of n coordinates.

mod common;
mod schwarzschild;
mod shipped_scenes;
