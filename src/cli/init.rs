//! `init NAME`, `init --list`, and `schema`: what a case of one's own begins with.

use std::process::ExitCode;

use clap::Args;
use clap::builder::PossibleValuesParser;
use geodesic_ivp::case::builtin::{self, ALL, BuiltIn, NAMES};

use super::out;

#[derive(Debug, Args)]
pub(super) struct InitArgs {
    /// The built-in case to print
    #[arg(
        value_name = "NAME",
        value_parser = PossibleValuesParser::new(NAMES.iter().copied()),
        hide_possible_values = true,
        required_unless_present = "list"
    )]
    name: Option<String>,

    /// List the built-in cases instead, each with what it shows
    #[arg(long, conflicts_with = "name")]
    list: bool,
}

pub(super) fn init(args: &InitArgs) -> anyhow::Result<ExitCode> {
    let text = match &args.name {
        Some(name) => builtin::text(name).expect("clap takes known names only").to_owned(),
        None => list(),
    };
    out::write_data(text.as_bytes())?;
    Ok(ExitCode::SUCCESS)
}

pub(super) fn schema() -> anyhow::Result<ExitCode> {
    out::write_data(geodesic_ivp::case::schema().as_bytes())?;
    Ok(ExitCode::SUCCESS)
}

/// One line for each case, below the heading of its section.
fn list() -> String {
    let width = NAMES.iter().map(|name| name.len()).max().unwrap_or(0);
    let (mut text, mut last) = (String::new(), "");
    for &BuiltIn { name, heading, text: case, .. } in ALL.iter() {
        if heading != last {
            text += &format!("{}{heading}\n", if last.is_empty() { "" } else { "\n" });
            last = heading;
        }
        text += &format!("  {name:<width$}  {}\n", builtin::description(case));
    }
    text
}
