//! What a shell offers for the word at the cursor: commands, options and their values, and of a case its name, its keys
//! and the values that these take. The scripts of `completions` ask the program itself, by a variable.

use std::ffi::OsStr;
use std::io;
use std::process::ExitCode;

use clap::CommandFactory;
use clap_complete::engine::{CompletionCandidate, PathCompleter, ValueCompleter};
use clap_complete::env::Shells;
use clap_complete::{CompleteEnv, Shell};
use geodesic_ivp::case::builtin::ALL;
use geodesic_ivp::case::{KEYS, choices};

use super::{Cli, out};

/// The variable by which a script asks.
const VARIABLE: &str = "GEODESIC_IVP_COMPLETE";

/// Answers a script of a shell, if one asks, and ends the program then.
pub(super) fn answer() {
    CompleteEnv::with_factory(Cli::command).var(VARIABLE).complete();
}

/// Prints the script of a shell. It is made in memory first, because a closed pipe is no reason to panic.
pub(super) fn completions(shell: Shell) -> anyhow::Result<ExitCode> {
    let (mut script, name) = (Vec::new(), env!("CARGO_PKG_NAME"));
    let shells = Shells::builtins();
    let completer = shells.completer(&shell.to_string()).ok_or_else(|| io::Error::from(io::ErrorKind::Unsupported))?;
    completer.write_registration(VARIABLE, name, name, name, &mut script)?;
    out::write_data(&script)?;
    Ok(ExitCode::SUCCESS)
}

/// The built-in cases and the files whose names begin so.
pub(super) fn cases(current: &OsStr) -> Vec<CompletionCandidate> {
    let begun = current.to_string_lossy();
    let names = ALL.iter().map(|case| case.name).filter(|name| name.starts_with(&*begun));
    let is_case = |path: &std::path::Path| path.extension().is_some_and(|end| end == "toml");
    let files = PathCompleter::file().filter(is_case).stdio().complete(current);
    names.map(CompletionCandidate::new).chain(files).collect()
}

/// The keys of a case that begin so, with an equals sign, or behind that the words that a key takes.
pub(super) fn settings(current: &OsStr) -> Vec<CompletionCandidate> {
    let begun = current.to_string_lossy();
    let mut keys = KEYS.iter().filter(|key| key.is_fixed());
    let candidates: Vec<String> = match begun.split_once('=') {
        Some((name, value)) => {
            let words = keys.find(|key| key.name == name).map_or_else(Vec::new, choices);
            words.into_iter().filter(|word| word.starts_with(value)).map(|word| format!("{name}={word}")).collect()
        }
        None => keys.filter(|key| key.name.starts_with(&*begun)).map(|key| format!("{}=", key.name)).collect(),
    };
    candidates.into_iter().map(CompletionCandidate::new).collect()
}
