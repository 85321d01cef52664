//! The mathematics, through the library. One program, so that it links once.

mod cases;
mod common;
mod numerics;
mod random_scenes;
mod studies;
mod world_lines;
