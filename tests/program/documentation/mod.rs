//! The documentation is what the program does: links lead somewhere, commands run, cases are valid, lists are complete.

mod cases;
pub(crate) mod commands;
mod dependencies;
mod links;
mod lists;
mod manual;
pub(crate) mod pages;
mod schema;
mod sources;
