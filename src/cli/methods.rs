//! Methods that a study is to measure, by the beginnings of their names.

use geodesic_ivp::study::{stability, work_precision};

use super::lines::broken;
use super::report::Refusal;

/// Help begins after its label.
const HELP_COLUMNS: usize = 90;

/// A method of a study.
pub(super) trait Method: Clone {
    /// All methods, those that suit some cases only among them.
    fn all() -> Vec<Self>;
    /// Its name in the tables.
    fn label(&self) -> String;
    /// Why there is no such method for a case, if there is none; of a scene it is known whether that is separable.
    fn unsuitable(&self, is_separable: Option<bool>) -> Option<&'static str>;
}

impl Method for stability::Method {
    fn all() -> Vec<Self> {
        Self::all()
    }

    fn label(&self) -> String {
        self.label()
    }

    fn unsuitable(&self, is_separable: Option<bool>) -> Option<&'static str> {
        self.unsuitable(is_separable?)
    }
}

impl Method for work_precision::Family {
    fn all() -> Vec<Self> {
        Self::all()
    }

    fn label(&self) -> String {
        self.name()
    }

    fn unsuitable(&self, is_separable: Option<bool>) -> Option<&'static str> {
        self.unsuitable(is_separable?)
    }
}

/// The methods that are asked for, and those that are left out although nobody said so.
pub(super) struct Chosen<M> {
    pub(super) methods: Vec<M>,
    pub(super) left_out: Vec<M>,
}

/// The methods whose names begin with one of `names`, all without names.
///
/// # Errors
/// If a name is that of no method, or of one that does not suit the case.
pub(super) fn chosen<M: Method>(names: &[String], is_separable: Option<bool>) -> anyhow::Result<Chosen<M>> {
    let (methods, left_out): (Vec<M>, Vec<M>) =
        M::all().into_iter().partition(|method| method.unsuitable(is_separable).is_none());
    if names.is_empty() {
        return Ok(Chosen { methods, left_out });
    }
    let begins = |method: &M, name: &str| method.label().to_lowercase().starts_with(&name.trim().to_lowercase());
    if let Some(name) = names.iter().find(|name| !methods.iter().any(|method| begins(method, name))) {
        let other = left_out.iter().find(|method| begins(method, name));
        let refusal = match other.and_then(|method| Some((method.label(), method.unsuitable(is_separable)?))) {
            Some((label, reason)) => Refusal::usage(format!("{label} {reason}")),
            None => Refusal::usage(format!("no method is called '{name}'")),
        };
        return Err(refusal.help(format!("the methods for this case are\n{}", list(&methods))).into());
    }
    let methods = methods.into_iter().filter(|method| names.iter().any(|name| begins(method, name))).collect();
    Ok(Chosen { methods, left_out: Vec::new() })
}

/// The names of methods, in lines.
fn list<M: Method>(methods: &[M]) -> String {
    let names: Vec<String> = methods.iter().map(|method| method.label().replace(' ', "\u{a0}")).collect();
    broken(&names.join(", "), 0, HELP_COLUMNS).trim_end().to_owned()
}

/// What `--methods` takes, for the long help.
pub(super) fn help<M: Method>() -> String {
    let names: Vec<String> = M::all().iter().map(Method::label).collect();
    format!(
        "Measure only these methods: names, or the beginnings of names [default: all that suit the case]\n\n\
         [possible values: {}]",
        names.join(", ")
    )
}
