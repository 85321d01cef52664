//! The documentation is what the program does: links lead somewhere, commands run, cases are valid, lists are complete.

mod cases;
mod columns;
pub(crate) mod commands;
mod features;
mod layers;
mod licences;
mod links;
mod lists;
mod manual;
pub(crate) mod pages;
mod sizes;
mod twins;
