//! `init NAME` and `init --list`.

use std::process::ExitCode;

use clap::Args;
use clap::builder::PossibleValuesParser;
use geodesic_ivp::Case;
use geodesic_ivp::case::builtin::{self, NAMES};

use super::stdout;

#[derive(Debug, Args)]
pub(super) struct InitArgs {
    /// Name of the built-in case to write
    #[arg(
        value_name = "NAME",
        value_parser = PossibleValuesParser::new(NAMES.iter().copied()),
        hide_possible_values = true,
        required_unless_present = "list"
    )]
    name: Option<String>,

    /// List the built-in cases instead: name, title and what they are
    #[arg(long, conflicts_with = "name")]
    list: bool,
}

pub(super) fn init(args: &InitArgs) -> anyhow::Result<ExitCode> {
    let text = match &args.name {
        Some(name) => builtin::text(name).expect("clap takes known names only").to_owned(),
        None => list()?,
    };
    stdout::write_data(text.as_bytes())?;
    Ok(ExitCode::SUCCESS)
}

/// One line a case.
fn list() -> anyhow::Result<String> {
    let mut rows = Vec::new();
    for &name in NAMES {
        let text = builtin::text(name).expect("a listed case is built in");
        rows.push((name, Case::parse(name, text, &[])?.title.unwrap_or_default(), builtin::description(text)));
    }
    let names = rows.iter().map(|row| row.0.len()).max().unwrap_or(0);
    let titles = rows.iter().map(|row| row.1.chars().count()).max().unwrap_or(0);
    Ok(rows
        .into_iter()
        .map(|(name, title, description)| format!("{name:names$}  {title:titles$}  {description}\n"))
        .collect())
}
