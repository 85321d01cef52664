//! `init NAME` and `init --list`.

use std::process::ExitCode;

use clap::Args;
use clap::builder::PossibleValuesParser;
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

    /// List the built-in cases instead: name, group (paper, basic, hard, scene), title and what they are
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

/// One line per case, group by group.
fn list() -> anyhow::Result<String> {
    let mut rows = Vec::new();
    for &name in NAMES {
        let text = builtin::text(name).expect("a listed case is built in");
        let group = builtin::group(name).expect("a listed case is built in").as_str();
        rows.push((name, group, builtin::title(name).unwrap_or_default(), builtin::description(text)));
    }
    let width = |of: fn(&(&str, &str, String, &str)) -> usize| rows.iter().map(of).max().unwrap_or(0);
    let (names, groups, titles) =
        (width(|row| row.0.len()), width(|row| row.1.len()), width(|row| row.2.chars().count()));
    Ok(rows
        .into_iter()
        .map(|(name, group, title, about)| format!("{name:names$}  {group:groups$}  {title:titles$}  {about}\n"))
        .collect())
}
