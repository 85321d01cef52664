//! `geodesic-ivp`: parse, dispatch, exit code.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::Cli::from_command_line().execute().unwrap_or_else(|error| cli::exit_code(&error))
}
