//! Explains mistakes on the command line further than the argument parser does.

use clap::CommandFactory;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};
use geodesic_ivp::formula::similar::nearest;

use super::Cli;

/// The parser's message, and what to do if a case is missing or a command is misspelt.
pub(super) fn explained(mut error: Error) -> Error {
    match (error.kind(), error.get(ContextKind::InvalidArg), error.get(ContextKind::InvalidSubcommand)) {
        (ErrorKind::MissingRequiredArgument, Some(ContextValue::Strings(names)), _)
            if names.iter().any(|name| name == "<CASE>") =>
        {
            // Two commands require a case; the usage line says which of them this is.
            let usage = error.get(ContextKind::Usage).map(ToString::to_string).unwrap_or_default();
            let command = if usage.contains(" check ") { "check" } else { "run" };
            let tip = format!(
                "name a file, - for standard input, or a built-in case, for example `{command} quartic`; \
                 `init --list` names these, and `init quartic > my-case.toml` starts one's own"
            );
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
        }
        (ErrorKind::InvalidSubcommand, _, Some(ContextValue::String(word)))
            if error.get(ContextKind::SuggestedSubcommand).is_none() =>
        {
            let command = Cli::command();
            let known = command.get_subcommands().map(clap::Command::get_name);
            if let Some(meant) = nearest(word, known).map(str::to_owned) {
                error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(vec![meant]));
            }
        }
        (ErrorKind::UnknownArgument, Some(ContextValue::String(name)), _) if name == "--n-gamma" => {
            let tip = "the numbers of nodes follow from steps and lengths: give --delta-gamma and --gamma-f";
            error.remove(ContextKind::SuggestedArg);
            error.remove(ContextKind::Usage);
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
        }
        _ => {}
    }
    error
}
