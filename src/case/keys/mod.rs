//! The keys of a case: one table, from which come the checks of what a case gives, the values of what it does not give,
//! hints, the manual page, the list in `docs/cases.md` and the schema.

mod exclusive;
mod former;
mod table;
#[cfg(test)]
mod tests;

pub(super) use exclusive::{EXCLUSIVE, Exclusion};
pub(super) use former::{FORMER, PARAMETERS, is_former, replaced};
pub use table::KEYS;

use std::collections::HashMap;
use std::sync::LazyLock;

use crate::number::{Extended, Real};

/// A key of a case file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key {
    /// Its dotted name. The parts `q`, `q_dot`, `p_q`, `q_final` and `sigma_q` stand for those of any coordinate q,
    /// and `NAME` for a name of the case's own.
    pub name: &'static str,
    pub(super) kind: Kind,
    /// The value without it, as it would be written, or `none`; `required`, perhaps with a condition, if it must be
    /// given; empty if there is no such thing.
    pub default: &'static str,
    /// The cases that have it.
    pub cases: Cases,
    /// Its meaning, in Markdown.
    pub meaning: &'static str,
}

/// The cases that have a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cases {
    /// All.
    All,
    /// Those of x. A scene has another key of this name only if a coordinate has it.
    OfX,
    /// Scenes.
    Scenes,
    /// Scenes: a case with this key is one.
    MakesScene,
}

/// The kind of value that a key takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A string on one line.
    Line,
    /// A string that is no formula.
    Text,
    /// An array of names.
    Names,
    /// An array of dotted keys.
    Keys,
    /// A number that is written as one.
    Number,
    /// An array of these.
    Numbers,
    /// A number, or a formula in the parameters of the scene.
    Value,
    /// The same, or an interval of two of them.
    Start,
    /// A number or a formula which is positive.
    Positive,
    /// An array of numbers and of formulas in the parameters.
    Values,
    /// A formula, or a number.
    Formula,
    /// An array of formulas.
    Formulas,
    /// A formula that is written as a string.
    Expression,
    /// A whole number.
    Whole,
    /// A whole number from 1 on.
    Count,
    /// A number of digits.
    Digits,
    /// A number between 0 and 1.
    Share,
    /// True or false.
    Flag,
    /// One of some words.
    Word(Words),
    /// A number for K, or a word.
    Norm,
    /// The numbers of a column, or its name in a file.
    Column,
    /// A table of the keys below this one.
    Table,
    /// A table of such values below names of the case's own.
    Named(&'static Kind),
}

/// Some words that a key may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Words {
    Preset,
    Law,
    Sign,
    Operator,
    Form,
    System,
    Status,
    Direction,
    Spline,
    Outside,
}

/// The word for a key that must be given wherever its table is.
pub(super) const REQUIRED: &str = "required";

/// Returns true if a part of a dotted name stands for other names.
fn is_placeholder(part: &str) -> bool {
    ["q", "q_dot", "p_q", "q_final", "sigma_q", "NAME"].contains(&part)
}

/// Returns true if a part of a name in the table stands for that part of a name in a case.
fn stands_for(part: &str, own: &str) -> bool {
    match part {
        "q_dot" => own.ends_with("_dot"),
        "p_q" => own.starts_with("p_"),
        "q_final" => own.ends_with("_final"),
        "sigma_q" => own.starts_with("sigma_"),
        "q" => !own.ends_with("_dot") && !own.starts_with("p_"),
        _ => part == "NAME" || part == own,
    }
}

/// The part of a dotted name below the table `path`, if it is there.
fn rest<'k>(name: &'k str, path: &str) -> Option<&'k str> {
    if path.is_empty() { Some(name) } else { name.strip_prefix(path)?.strip_prefix('.') }
}

/// The key of that name in the table.
pub(super) fn named(name: &str) -> Option<&'static Key> {
    KEYS.iter().find(|key| key.name == name)
}

/// The parts of names that stand directly below a table.
#[derive(Default)]
struct Below {
    /// All of them, each once and in the order of the table of keys.
    all: Vec<&'static str>,
    /// Those that are names in all cases that have them.
    named: Vec<&'static str>,
    /// The one that stands for others, if there is one.
    open: Option<&'static str>,
}

/// The same of every table. They are asked for at each table of each case that is read.
static TABLES: LazyLock<HashMap<&'static str, Below>> = LazyLock::new(|| {
    let mut tables: HashMap<&str, Below> = HashMap::new();
    for key in KEYS {
        let ends = key.name.match_indices('.').map(|(end, _)| end);
        for (path, rest) in ends.map(|end| (&key.name[..end], &key.name[end + 1..])).chain([("", key.name)]) {
            let (all, part) = (&mut tables.entry(path).or_default().all, rest.split('.').next().unwrap_or_default());
            if !all.contains(&part) {
                all.push(part);
            }
        }
    }
    for (path, Below { all, named, open }) in &mut tables {
        let is_of_x = |part: &str| {
            KEYS.iter().any(|key| key.cases == Cases::OfX && rest(key.name, path).is_some_and(|rest| rest == part))
        };
        let parts = all.iter().filter(|part| !is_of_x(part));
        let (placeholders, names): (Vec<&str>, Vec<&str>) = parts.partition(|part| is_placeholder(part));
        (*named, *open) = (names, placeholders.first().copied());
    }
    tables
});

/// The parts of names that stand directly below a table, each once and in the order of the table of keys.
pub(super) fn below(path: &str) -> &'static [&'static str] {
    TABLES.get(path).map_or(&[], |below| &below.all)
}

/// The same in two parts: what is a name in all cases that have it, and what stands for others.
pub(super) fn named_and_open(path: &str) -> (&'static [&'static str], Option<&'static str>) {
    TABLES.get(path).map_or((&[], None), |below| (&below.named, below.open))
}

/// The names in a table, with those of a case's own.
pub(super) fn named_in<'n>(path: &str, own: &'n [String]) -> Vec<&'n str> {
    named_and_open(path).0.iter().copied().chain(own.iter().map(String::as_str)).collect()
}

/// The keys that say what the potential is.
pub(super) fn potentials() -> impl Iterator<Item = &'static str> {
    let is_kind = |key: &&Key| matches!(key.kind, Kind::Table | Kind::Expression) && key.parts().0 == "potential";
    KEYS.iter().filter(is_kind).map(|key| key.parts().1)
}

/// The key that a potential of some kind needs.
pub(super) fn of_potential(kind: &str) -> Option<&'static str> {
    let table = format!("potential.{kind}");
    let is_needed = |key: &&Key| key.default == REQUIRED && key.parts().0 == table;
    KEYS.iter().find(is_needed).map(|key| key.parts().1)
}

/// The key that a dotted name of a case has in the table, where it is a name or stands for others.
pub(super) fn of(dotted: &str) -> Option<&'static Key> {
    if let Some((_, now)) = replaced(dotted) {
        return of(&now);
    }
    let is_like = |key: &&Key| {
        let mut parts = dotted.split('.');
        let is_alike = |part: &str| parts.next().is_some_and(|own| stands_for(part, own));
        key.name.split('.').all(is_alike) && parts.next().is_some() <= matches!(key.kind, Kind::Named(_))
    };
    named(dotted).or_else(|| KEYS.iter().find(is_like))
}

impl Key {
    /// The table that it stands in, and its last part.
    pub(super) fn parts(&self) -> (&'static str, &'static str) {
        self.name.rsplit_once('.').unwrap_or(("", self.name))
    }

    /// The table at the top that it stands in, or is.
    fn top(&self) -> &'static str {
        self.name.split('.').next().unwrap_or_default()
    }

    /// Its name up to what stands for others.
    fn fixed(&self) -> &'static str {
        let mut end = 0;
        for part in self.name.split('.').take_while(|part| !is_placeholder(part)) {
            end += part.len() + 1;
        }
        &self.name[..end - 1]
    }

    /// Returns true if its last part is a name, and not one that stands for others.
    pub fn is_fixed(&self) -> bool {
        self.fixed() == self.name
    }

    /// Returns true if nothing holds without it, in some cases at least.
    pub fn is_required(&self) -> bool {
        self.default.starts_with(REQUIRED)
    }

    /// The kind of value that it takes, in words.
    pub fn takes(&self) -> String {
        self.kind.in_words()
    }

    /// The value without it, if that can be written.
    pub(super) fn written_default(&self) -> Option<&'static str> {
        (!self.is_required() && !["", "none"].contains(&self.default)).then_some(self.default)
    }
}

impl Kind {
    /// Returns true if it is made for formulas.
    fn is_formula(self) -> bool {
        matches!(self, Self::Formula | Self::Formulas | Self::Expression | Self::Named(Self::Formula | Self::Start))
    }

    /// Returns true if a string in it may have names of parameters in it.
    pub(super) fn has_names(self) -> bool {
        let is_value = matches!(self, Self::Value | Self::Start | Self::Positive | Self::Values | Self::Norm);
        self.is_formula() || is_value || self == Self::Named(&Self::Value)
    }

    fn in_words(self) -> String {
        let words = match self {
            Self::Line => "string, one line",
            Self::Text => "string",
            Self::Word(_) => "word",
            Self::Names => "names",
            Self::Keys => "keys",
            Self::Number | Self::Value => "number",
            Self::Numbers | Self::Values => "numbers",
            Self::Start => "number or interval",
            Self::Positive => "number > 0",
            Self::Formula => "formula",
            Self::Formulas => "formulas",
            Self::Expression => "formula, a string",
            Self::Whole => "whole number",
            Self::Count => "whole number ≥ 1",
            Self::Digits => return format!("{} … {}", f64::MOST_DIGITS, Extended::MOST_DIGITS),
            Self::Share => "number in (0, 1)",
            Self::Flag => "true or false",
            Self::Norm => "number or word",
            Self::Column => "numbers, or a name",
            Self::Table => "table",
            Self::Named(Self::Start) => "table of formulas or intervals",
            Self::Named(each) => return format!("table of {}s", each.in_words()),
        };
        words.to_owned()
    }
}

/// The places in a case whose presence makes it a scene: tables that only scenes have, and keys of others.
pub(super) static OF_SCENES: LazyLock<Vec<&'static str>> = LazyLock::new(|| {
    let makes = |key: &&Key| key.cases == Cases::MakesScene;
    let place = |key: &'static Key| {
        let is_whole = KEYS.iter().filter(|other| other.top() == key.top()).all(|other| makes(&other));
        if is_whole { key.top() } else { key.fixed() }
    };
    let mut places: Vec<&str> = KEYS.iter().filter(makes).map(place).collect();
    places.dedup();
    places
});
