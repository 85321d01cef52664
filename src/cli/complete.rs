//! What a shell offers for the word at the cursor: commands, options and their values, and of a case its name, its keys
//! and the values that these take. The scripts of `completions` ask the program itself, by a variable.

use std::collections::HashSet;
use std::ffi::OsStr;
use std::path::Path;
use std::process::ExitCode;
use std::{fs, io};

use clap::CommandFactory;
use clap_complete::engine::{CompletionCandidate, PathCompleter, ValueCompleter};
use clap_complete::env::Shells;
use clap_complete::{CompleteEnv, Shell};
use geodesic_ivp::case::builtin::{self, ALL, BuiltIn};
use geodesic_ivp::case::{KEYS, choices};
use toml_edit::{DocumentMut, TableLike};

use super::{Cli, out};

/// The variable by which a script asks.
const VARIABLE: &str = "GEODESIC_IVP_COMPLETE";

/// Bash splits words at what its COMP_WORDBREAKS has, as at the equals sign of KEY=VALUE, and replaces only what is
/// behind the last one. This puts them together again before it asks, and takes off afterwards what stays.
const OF_BASH: &str = r#"
_geodesic_ivp() {
    local joined=() index=0 word last= here
    for here in "${!COMP_WORDS[@]}"; do
        word=${COMP_WORDS[here]}
        if [[ $here -gt 0 && ( $word == [=:] || $last == [=:] ) ]]; then
            joined[${#joined[@]} - 1]+=$word
        else
            joined+=("$word")
        fi
        [[ $here -eq $COMP_CWORD ]] && index=$((${#joined[@]} - 1))
        last=$word
    done
    local COMP_WORDS=("${joined[@]}") COMP_CWORD=$index current=${joined[index]}
    _clap_complete_geodesic_ivp "$1" "$current" "$3"
    if [[ $current == *[=:]* && $COMP_WORDBREAKS == *=* ]]; then
        COMPREPLY=("${COMPREPLY[@]#"${current%"${current##*[=:]}"}"}")
    fi
}
complete -o nospace -o bashdefault -F _geodesic_ivp geodesic-ivp
"#;

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
    if shell == Shell::Bash {
        script.extend_from_slice(OF_BASH.as_bytes());
    }
    out::write_data(&script)?;
    Ok(ExitCode::SUCCESS)
}

/// The built-in cases and the files whose names begin so; for a search those that say what is to be found.
pub(super) fn cases(current: &OsStr) -> Vec<CompletionCandidate> {
    let (begun, is_search) = (current.to_string_lossy(), words().any(|word| word == "find"));
    let is_asked = |case: &&BuiltIn| case.name.starts_with(&*begun) && (!is_search || case.text.contains("[find]"));
    let names = ALL.iter().filter(is_asked).map(|case| case.name);
    let is_case = |path: &Path| path.extension().is_some_and(|end| end == "toml");
    let files = PathCompleter::file().filter(is_case).stdio().complete(current);
    names.map(CompletionCandidate::new).chain(files).collect()
}

/// The keys of a case that begin so, with an equals sign, or behind that the words that a key takes. Names that the
/// case at hand has given itself come first.
pub(super) fn settings(current: &OsStr) -> Vec<CompletionCandidate> {
    let begun = current.to_string_lossy();
    let mut keys = KEYS.iter().filter(|key| key.is_fixed());
    let mut candidates: Vec<String> = match begun.split_once('=') {
        Some((name, value)) => {
            let words = keys.find(|key| key.name == name).map_or_else(Vec::new, choices);
            words.into_iter().filter(|word| word.starts_with(value)).map(|word| format!("{name}={word}")).collect()
        }
        None => {
            let own = text_of_case().map_or_else(Vec::new, |text| keys_of(&text));
            let all = own.into_iter().chain(keys.map(|key| key.name.to_owned()));
            all.filter(|key| key.starts_with(&*begun)).map(|key| format!("{key}=")).collect()
        }
    };
    let mut seen = HashSet::new();
    candidates.retain(|candidate| seen.insert(candidate.clone()));
    candidates.into_iter().map(CompletionCandidate::new).collect()
}

/// The words of the line, with which a script asks.
fn words() -> impl Iterator<Item = String> {
    std::env::args().skip_while(|word| word != "--").skip(2)
}

/// The text of the case that the line names.
fn text_of_case() -> Option<String> {
    words().find_map(|word| {
        let is_file = word.ends_with(".toml") && Path::new(&word).is_file();
        if is_file { fs::read_to_string(&word).ok() } else { builtin::text(&word).map(str::to_owned) }
    })
}

/// The keys that a case gives, those of tables with dots.
fn keys_of(text: &str) -> Vec<String> {
    fn gather(table: &dyn TableLike, path: &str, keys: &mut Vec<String>) {
        for (name, item) in table.iter() {
            let key = format!("{path}{name}");
            match item.as_table_like() {
                Some(inner) => gather(inner, &format!("{key}."), keys),
                None => keys.push(key),
            }
        }
    }
    let mut keys = Vec::new();
    if let Ok(document) = text.parse::<DocumentMut>() {
        gather(document.as_table(), "", &mut keys);
    }
    keys
}
