//! `geodesic-ivp`: parse, dispatch, exit code.

mod cli;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    cli::Cli::parse().execute().unwrap_or_else(|error| cli::exit_code(&error))
}
