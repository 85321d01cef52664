//! The command line, as a user meets it: every test runs the program in a folder of its own.

mod acting;
mod base_cases;
mod built_in_cases;
mod enclose;
mod folders;
mod help;
mod hints;
#[cfg(unix)]
mod interrupts;
mod json;
mod limits;
mod malformed;
mod pages;
mod restart;
mod run;
mod samples;
mod scenes;
mod sensitivity;
mod stability;
#[cfg(unix)]
mod streams;
mod studies;
mod tables;
#[cfg(unix)]
mod together;
mod vary;
mod verdict;
