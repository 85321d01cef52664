//! `completions SHELL`.

use std::process::ExitCode;

use clap::CommandFactory;

use super::{Cli, stdout};

/// Prints the script. It is generated in memory first, because the generator would panic on a closed pipe.
pub(super) fn completions(shell: clap_complete::Shell) -> anyhow::Result<ExitCode> {
    let mut script = Vec::new();
    let mut command = Cli::command();
    let name = command.get_name().to_owned();
    clap_complete::generate(shell, &mut command, name, &mut script);
    stdout::write_data(&script)?;
    Ok(ExitCode::SUCCESS)
}
