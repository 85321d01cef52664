//! The arguments of `find`, and what its searches have in common.

use std::str::FromStr;

use clap::Args;
use geodesic_ivp::Case;
use geodesic_ivp::case::{Find, key_of};
use geodesic_ivp::study::many::Axis;

use super::CaseArgs;
use super::out::OutArgs;
use super::report::refused;
use super::told::number;

#[derive(Debug, Args)]
pub(super) struct FindArgs {
    #[command(flatten)]
    pub(super) case: CaseArgs,

    #[command(flatten)]
    pub(super) output: OutArgs,

    /// Prove that there is what was found: numbers, no further away than a printed radius, with which a motion meets
    /// everything exactly, and no others near them
    ///
    /// It needs find.meet with as many conditions as unknowns, on which the start or the end of the run depends
    /// linearly, and the equations of motion do not. No event may end the run or act.
    #[arg(long)]
    pub(super) prove: bool,

    /// Follow the family of what is found in one more number of the case, around folds as well
    ///
    /// It begins at FROM and ends at TO, or where the number comes back to FROM: family.csv has its members.
    #[arg(long, value_name = "KEY=FROM:TO", conflicts_with_all = ["prove", "vary"])]
    pub(super) follow: Option<Followed>,

    /// Draw the run that was found, and data with it; of a family its first unknown over the number that is followed
    #[arg(long, conflicts_with = "vary")]
    pub(super) plot: bool,

    /// Search from each value of a key: one table, with a row for each search
    ///
    /// VALUES is a list, or START:STOP:COUNT for equidistant values. Given several times, every combination is a start.
    #[arg(long, value_name = "KEY=VALUES", conflicts_with = "prove")]
    pub(super) vary: Vec<Axis>,
}

const EXPECTED: &str = "expected KEY=FROM:TO, for example parameters.k=1:2";

/// A number of the case that is followed, and its range.
#[derive(Debug, Clone)]
pub(super) struct Followed {
    pub(super) key: String,
    /// The first value, as it is written.
    pub(super) from: String,
    pub(super) to: f64,
}

impl FromStr for Followed {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let key = key_of(text).ok_or_else(|| format!("there is no dotted key: {EXPECTED}"))?;
        let (_, range) = text.split_once('=').ok_or(EXPECTED)?;
        let (from, to) = range.split_once(':').ok_or(EXPECTED)?;
        let number = |text: &str| {
            let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
            value.ok_or_else(|| format!("{} is no number: {EXPECTED}", text.trim()))
        };
        let (first, to) = (number(from)?, number(to)?);
        if first == to {
            return Err(format!("both ends of the range are {to}: {EXPECTED}"));
        }
        Ok(Self { key, from: from.trim().to_owned(), to })
    }
}

/// The table of a case that says what is to be found, if a search can begin.
pub(super) fn checked(case: &Case) -> anyhow::Result<Find> {
    let help = "for example find = { unknowns = [\"initial.x_dot\"], meet = [\"x - 1\"] }";
    let wanted =
        case.find.clone().ok_or_else(|| refused("the case has no [find], which says what is to be found", help))?;
    if case.settings.is_extended() {
        return Err(refused("a search has 16 digits", "leave solver.digits out"));
    }
    if !case.settings.is_judged {
        let message = "a search ends where the errors of runs begin, and solver.error = false leaves them unknown";
        return Err(refused(message, "leave solver.error out"));
    }
    Ok(wanted)
}

/// A number with its error.
pub(super) fn with_error(value: f64, error: f64) -> String {
    let text = number(value, Some(error), 16);
    if text.contains('±') { text } else { format!("{text} ± {error:.0e}") }
}
