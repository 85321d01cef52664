//! Methods that a study is to measure, by the beginnings of their names.

use super::lines::broken;
use super::report::Refusal;

/// Help begins after its label.
const HELP_COLUMNS: usize = 90;

/// The methods whose names begin with one of `names`, and those that are left out although nobody said so.
pub(super) type Chosen<M> = (Vec<M>, Vec<M>);

/// Those of `all` whose names begin with one of `names`; without names all that suit the case.
///
/// # Errors
/// If a name is that of no method, or of one that does not suit the case.
pub(super) fn chosen<M>(
    names: &[String],
    all: Vec<M>,
    label: impl Fn(&M) -> String,
    unsuitable: impl Fn(&M) -> Option<&'static str>,
) -> anyhow::Result<Chosen<M>> {
    let (methods, left_out): Chosen<M> = all.into_iter().partition(|method| unsuitable(method).is_none());
    if names.is_empty() {
        return Ok((methods, left_out));
    }
    let begins = |method: &M, name: &str| label(method).to_lowercase().starts_with(&name.trim().to_lowercase());
    if let Some(name) = names.iter().find(|name| !methods.iter().any(|method| begins(method, name))) {
        let other = left_out.iter().find(|method| begins(method, name));
        let message = match other.and_then(|method| Some((label(method), unsuitable(method)?))) {
            Some((label, reason)) => format!("{label} {reason}"),
            None => format!("no method is called '{name}'"),
        };
        let list = methods.iter().map(|method| label(method).replace(' ', "\u{a0}")).collect::<Vec<_>>().join(", ");
        let help = format!("the methods for this case are\n{}", broken(&list, 0, HELP_COLUMNS).trim_end());
        return Err(Refusal::usage(message).help(help).into());
    }
    let methods = methods.into_iter().filter(|method| names.iter().any(|name| begins(method, name))).collect();
    Ok((methods, Vec::new()))
}

/// The list of values of `--methods`, for the long help.
pub(super) fn help(names: impl Iterator<Item = String>) -> String {
    format!(
        "Measure only these methods: names, or the beginnings of names [default: all that suit the case]\n\n\
         [possible values: {}]",
        names.collect::<Vec<_>>().join(", ")
    )
}
