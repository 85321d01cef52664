//! The command line, as a user meets it: every test runs the program in a folder of its own.

mod built_in_cases;
mod common;
mod folders;
mod hints;
mod limits;
#[cfg(unix)]
mod streams;
#[cfg(unix)]
mod together;
