//! `completions SHELL` and `man`.

use std::io::Write;
use std::process::ExitCode;

use clap::CommandFactory;
use clap_mangen::Man;

use super::{Cli, stdout};

/// Generated into memory first: the generator itself would panic on a closed pipe.
pub(super) fn completions(shell: clap_complete::Shell) -> anyhow::Result<ExitCode> {
    let mut script = Vec::new();
    let mut command = Cli::command();
    let name = command.get_name().to_owned();
    clap_complete::generate(shell, &mut command, name, &mut script);
    stdout::write_data(&script)?;
    Ok(ExitCode::SUCCESS)
}

/// One page with all commands; there are no further pages to refer to.
pub(super) fn man() -> anyhow::Result<ExitCode> {
    let mut page = Vec::new();
    let mut command = Cli::command();
    command.build();
    let main = Man::new(command.clone());
    main.render_title(&mut page)?;
    main.render_name_section(&mut page)?;
    main.render_synopsis_section(&mut page)?;
    main.render_description_section(&mut page)?;
    for subcommand in command.get_subcommands().filter(|subcommand| subcommand.get_name() != "help") {
        writeln!(page, ".SH \"COMMAND {}\"", subcommand.get_name().to_uppercase())?;
        let section = Man::new(subcommand.clone());
        let mut text = Vec::new();
        section.render_description_section(&mut text)?;
        section.render_synopsis_section(&mut text)?;
        section.render_options_section(&mut text)?;
        // Sections of a command are sub-sections of the page.
        page.extend(String::from_utf8(text)?.replace(".SH ", ".SS ").into_bytes());
    }
    main.render_extra_section(&mut page)?;
    stdout::write_data(&page)?;
    Ok(ExitCode::SUCCESS)
}
