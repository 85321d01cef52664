//! The command line, as a user meets it: every test runs the program in a folder of its own.

mod acting;
mod arrays;
mod cases;
mod enclose;
mod find;
mod folders;
#[cfg(unix)]
mod interrupts;
mod limits;
mod malformed;
mod one_picture;
mod prove;
mod restart;
mod run;
mod samples;
mod scenes;
mod stability;
mod streams;
mod studies;
mod tables;
#[cfg(unix)]
mod together;
mod vary;
mod vary_samples;
mod verdict;
