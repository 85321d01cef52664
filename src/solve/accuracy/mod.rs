//! Runs to an accuracy: the program chooses operator and windows.

pub(super) mod one;
pub(super) mod scene;
