//! The program as its users meet it, and what the documentation says about it.

mod cli;
mod common;
mod documentation;
#[cfg(target_os = "linux")]
mod transcripts;
