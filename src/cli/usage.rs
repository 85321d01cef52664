//! Mistakes on the command line, explained further than the argument parser does.

use clap::error::{ContextKind, ContextValue, Error, ErrorKind};

/// The parser's message, with what to do where a case is missing.
pub(super) fn explained(mut error: Error) -> Error {
    if error.kind() == ErrorKind::MissingRequiredArgument && is_about(&error, "<CASE>") {
        // Of the two commands that must be told a case, the one that the usage line is of.
        let usage = error.get(ContextKind::Usage).map(ToString::to_string).unwrap_or_default();
        let command = if usage.contains(" check ") { "check" } else { "run" };
        let tip = format!(
            "name a file, - for standard input, or a built-in case, for example `{command} quartic`; \
             `init --list` names these, and `init quartic > my-case.toml` starts one's own"
        );
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    error
}

/// Whether `argument` is among those that the message names.
fn is_about(error: &Error, argument: &str) -> bool {
    match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::Strings(names)) => names.iter().any(|name| name == argument),
        Some(ContextValue::String(name)) => name == argument,
        _ => false,
    }
}
