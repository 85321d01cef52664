//! Values of a case with their places, so that every mistake is told where it is.

use std::ops::Range;
use std::sync::LazyLock;

use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::Error;
use toml_edit::{Document, Item, TableLike, Value};

use super::keys::PARAMETERS;
use super::source::{DEFAULTS, Source};
use super::{CaseError, hint, keys};
use crate::formula::FormulaError;
use crate::formula::similar::nearest;

#[cfg(test)]
thread_local! {
    /// The dotted names that readers have asked for, for a test that compares them with the table of keys.
    pub(super) static ASKED: std::cell::RefCell<std::collections::BTreeSet<String>> = const {
        std::cell::RefCell::new(std::collections::BTreeSet::new())
    };
}

/// A value with its place. A table that is not given is an empty one in the place of the table around it.
#[derive(Clone)]
pub(super) struct Field<'t> {
    pub(super) source: &'t Source,
    /// Its dotted key.
    pub(super) path: String,
    /// The last part of its key.
    pub(super) key: String,
    item: Option<&'t Item>,
    table: Option<&'t dyn TableLike>,
    /// The places of the value and of the key.
    pub(super) span: Range<usize>,
    pub(super) key_span: Range<usize>,
}

impl<'t> Field<'t> {
    /// The table at the top.
    pub(super) fn root(source: &'t Source, root: &'t Item) -> Self {
        let (path, key, table) = (String::new(), String::new(), root.as_table_like());
        Self { source, path, key, item: None, table, span: 0..0, key_span: 0..0 }
    }

    /// The value of a key of this table.
    pub(super) fn get(&self, key: &str) -> Option<Self> {
        #[cfg(test)]
        ASKED.with_borrow_mut(|asked| asked.insert(self.dotted(key)));
        self.entry(key)
    }

    /// The same, of whatever key.
    fn entry(&self, key: &str) -> Option<Self> {
        let (written, item) = self.table?.get_key_value(key)?;
        let key_span = written.span().unwrap_or_else(|| self.span.clone());
        // A table that dotted keys make has no place of its own.
        let span = item.span().unwrap_or_else(|| key_span.clone());
        let (source, table) = (self.source, item.as_table_like());
        Some(Self { source, path: self.dotted(key), key: key.to_owned(), item: Some(item), table, span, key_span })
    }

    /// The value of a dotted key below this table, of which the table of keys may know nothing.
    pub(super) fn find(&self, dotted: &str) -> Option<Self> {
        dotted.split('.').try_fold(self.clone(), |table, key| table.entry(key))
    }

    /// The value of a key of this table, as `read` understands it.
    pub(super) fn read<T>(
        &self,
        key: &str,
        read: impl FnOnce(&Self) -> Result<T, CaseError>,
    ) -> Result<Option<T>, CaseError> {
        self.get(key).as_ref().map(read).transpose()
    }

    /// The value of a key of this table, or what the case has without it, as `read` understands it.
    pub(super) fn given<T>(&self, key: &str, read: impl FnOnce(&Self) -> Result<T, CaseError>) -> Result<T, CaseError> {
        read(&self.get(key).unwrap_or_else(|| default(&self.dotted(key))))
    }

    /// The table below a key; an empty one if there is none.
    pub(super) fn table(&self, key: &str) -> Self {
        let empty = || Self { path: self.dotted(key), key: key.to_owned(), item: None, table: None, ..self.clone() };
        self.get(key).unwrap_or_else(empty)
    }

    /// The value of a key of this table or, without it, the table: where a mistake about that key is.
    pub(super) fn at(&self, key: &str) -> Self {
        self.get(key).unwrap_or_else(|| self.clone())
    }

    /// All values of a table whose keys are names of the user.
    pub(super) fn fields(&self) -> Vec<Self> {
        let keys = self.table.iter().flat_map(|table| table.iter().map(|(key, _)| key));
        keys.filter_map(|key| self.entry(key)).collect()
    }

    /// Returns true if it is a table of the text.
    pub(super) fn is_table(&self) -> bool {
        self.table.is_some()
    }

    /// Refuses other keys than these.
    pub(super) fn finish(&self, known: &[impl AsRef<str>]) -> Result<(), CaseError> {
        self.unknown(known).into_iter().next().map_or(Ok(()), Err)
    }

    /// One mistake for each other key than these.
    pub(super) fn unknown(&self, known: &[impl AsRef<str>]) -> Vec<CaseError> {
        let known: Vec<&str> = known.iter().map(AsRef::as_ref).collect();
        let list = match known.as_slice() {
            [] => "this table has no keys".to_owned(),
            [one] => format!("the only key is `{one}`"),
            all => format!("expected one of `{}`", all.join("`, `")),
        };
        let mistake = |field: Self| {
            let is_parameter = || self.table(PARAMETERS).get(&field.key).is_some();
            let meant = if self.path.is_empty() && is_parameter() {
                Some(format!("{PARAMETERS}.{}", field.key))
            } else {
                hint::for_key(&field.key, &self.path, &known)
            };
            let error = field.key_error(format!("unknown field `{}`, {list}", field.key));
            error.with_hint(meant.map(|meant| format!("did you mean `{meant}`?")))
        };
        let is_known = |field: &Self| known.contains(&field.key.as_str()) || keys::is_former(&field.path);
        self.fields().into_iter().filter(|field| !is_known(field)).map(mistake).collect()
    }

    fn dotted(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// A mistake in the value.
    pub(super) fn error(&self, message: impl Into<String>) -> CaseError {
        self.error_at(self.span.clone(), message)
    }

    /// A mistake in the key.
    pub(super) fn key_error(&self, message: impl Into<String>) -> CaseError {
        self.error_at(self.key_span.clone(), message)
    }

    /// A mistake at a place inside the value.
    pub(super) fn error_at(&self, span: Range<usize>, message: impl Into<String>) -> CaseError {
        self.source.error(Some(span), message.into(), None)
    }

    /// A mistake in the formula that the value is, with what to do if the formula itself does not suggest it.
    pub(super) fn formula_error(&self, error: &FormulaError, help: String) -> CaseError {
        let length = error.expression[error.offset..].chars().next().map_or(0, char::len_utf8);
        let message = format!("{} (character {} of the expression)", error.message, error.character());
        let span = self.within(&error.expression, error.offset..error.offset + length);
        self.source.error(Some(span), message, error.hint.clone().or(Some(help)))
    }

    /// The place of a part of a string, if that is written without escapes.
    fn within(&self, string: &str, part: Range<usize>) -> Range<usize> {
        match self.literal().find(string).filter(|_| self.as_str() == Some(string)) {
            Some(offset) => self.span.start + offset + part.start..self.span.start + offset + part.end,
            None => self.span.clone(),
        }
    }

    fn literal(&self) -> &'t str {
        &self.source.text[self.span.clone()]
    }

    /// (line, column) of the key.
    pub(super) fn line_and_column(&self) -> (usize, usize) {
        self.key_error("").line_and_column().unwrap_or((1, 1))
    }

    fn expected(&self, what: &str) -> CaseError {
        let found = self.item.map_or("table", Item::type_name);
        self.error(format!("'{}' must be {what}, found {found}", self.path))
    }

    fn value(&self) -> Option<&'t Value> {
        self.item?.as_value()
    }

    /// The string that the value is, if it is one.
    pub(super) fn as_str(&self) -> Option<&'t str> {
        self.value()?.as_str()
    }

    /// The string that the value is.
    pub(super) fn string(&self) -> Result<&'t str, CaseError> {
        self.as_str().ok_or_else(|| self.expected("a string"))
    }

    /// Returns true if the value is an array.
    pub(super) fn is_array(&self) -> bool {
        self.value().is_some_and(Value::is_array)
    }

    /// The number or the formula that the value is, with all digits of a number.
    pub(super) fn formula(&self) -> Result<String, CaseError> {
        match self.as_str() {
            Some(text) => Ok(text.to_owned()),
            None => (self.value().and_then(|value| number(value, self.literal())))
                .ok_or_else(|| self.expected("a number or a formula"))?
                .map_err(|value| self.error(format!("'{}' must be a finite number, got {value}", self.path))),
        }
    }

    /// The number that the value is, with all its digits.
    pub(super) fn number(&self) -> Result<String, CaseError> {
        if self.as_str().is_some() { Err(self.expected("a number")) } else { self.formula() }
    }

    /// The elements of an array `of` something, as `read` understands a value and its literal, with their places.
    fn elements<T>(
        &self,
        of: &str,
        wrong: impl Fn(&Value) -> String,
        read: impl Fn(&'t Value, &str) -> Option<T>,
    ) -> Result<Vec<(T, Range<usize>)>, CaseError> {
        let array =
            self.value().and_then(Value::as_array).ok_or_else(|| self.expected(&format!("an array of {of}")))?;
        let element = |value: &'t Value| {
            let span = value.span().unwrap_or_else(|| self.span.clone());
            let wrong = || self.error_at(span.clone(), format!("'{}' must have {}", self.path, wrong(value)));
            Ok((read(value, &self.source.text[span.clone()]).ok_or_else(wrong)?, span.clone()))
        };
        array.iter().map(element).collect()
    }

    /// The numbers of an array.
    pub(super) fn numbers(&self) -> Result<Vec<String>, CaseError> {
        let wrong = |value: &Value| format!("finite numbers only, found {value}");
        let numbers = self.elements("numbers", wrong, |value, literal| number(value, literal)?.ok())?;
        Ok(numbers.into_iter().map(|(number, _)| number).collect())
    }

    /// The numbers and formulas of an array.
    pub(super) fn formulas(&self) -> Result<Vec<String>, CaseError> {
        let wrong = |value: &Value| format!("finite numbers or formulas, found {value}");
        let read =
            |value: &Value, literal: &str| value.as_str().map(str::to_owned).or_else(|| number(value, literal)?.ok());
        Ok(self.elements("numbers", wrong, read)?.into_iter().map(|(formula, _)| formula).collect())
    }

    /// The strings of an array with their places.
    pub(super) fn strings(&self) -> Result<Vec<(&'t str, Range<usize>)>, CaseError> {
        let wrong = |value: &Value| format!("strings only, found {}", value.type_name());
        self.elements("strings", wrong, |value, _| value.as_str())
    }

    /// The table that the value is, or the tables of an array.
    pub(super) fn tables(&self, is_array: bool) -> Result<Vec<Self>, CaseError> {
        if !is_array {
            return if self.is_table() { Ok(vec![self.clone()]) } else { Err(self.expected("a table")) };
        }
        let wrong = || self.expected("an array of tables");
        let tables: Vec<(&'t dyn TableLike, Option<Range<usize>>)> = match self.item {
            Some(Item::ArrayOfTables(tables)) => tables.iter().map(|table| (table as _, table.span())).collect(),
            _ => {
                let inline = |value: &'t Value| Some((value.as_inline_table()? as _, value.span()));
                let array = self.value().and_then(Value::as_array);
                array.and_then(|array| array.iter().map(inline).collect()).ok_or_else(wrong)?
            }
        };
        let table = |(k, (table, span)): (usize, (_, Option<Range<usize>>))| {
            let (path, span) = (format!("{}.{}", self.path, k + 1), span.unwrap_or_else(|| self.span.clone()));
            Self { path, item: None, table: Some(table), span, ..self.clone() }
        };
        Ok(tables.into_iter().enumerate().map(table).collect())
    }

    /// The truth value that the value is.
    pub(super) fn is_true(&self) -> Result<bool, CaseError> {
        self.value().and_then(Value::as_bool).ok_or_else(|| self.expected("true or false"))
    }

    /// The whole number that the value is.
    pub(super) fn whole(&self) -> Result<usize, CaseError> {
        let whole = self.value().and_then(Value::as_integer).and_then(|number| usize::try_from(number).ok());
        whole.ok_or_else(|| self.expected("a whole number, 0 or more"))
    }

    /// One of the words that `T` knows.
    pub(super) fn word<T: Deserialize<'t>>(&self) -> Result<T, CaseError> {
        let word = self.string()?.to_owned();
        T::deserialize(IntoDeserializer::<Error>::into_deserializer(word)).map_err(|error: Error| {
            let message = error.to_string();
            let help = hint::for_word(&message);
            self.error(message).with_hint(help)
        })
    }

    /// One of the `known` words, of which a message says that they are `expected`.
    pub(super) fn one_of<T: Copy>(&self, noun: &str, expected: &str, known: &[(&str, T)]) -> Result<T, CaseError> {
        let given = self.string()?;
        known.iter().find(|(name, _)| *name == given).map(|&(_, value)| value).ok_or_else(|| {
            let meant = nearest(given, known.iter().map(|&(name, _)| name));
            let error = self.error(format!("unknown {noun} \"{given}\", expected {expected}"));
            error.with_hint(meant.map(|meant| format!("did you mean \"{meant}\"?")))
        })
    }
}

/// The words that `T` knows, as the message about another one names them.
pub(super) fn words_of<T: Deserialize<'static>>() -> Vec<String> {
    let refused = T::deserialize(IntoDeserializer::<Error>::into_deserializer(String::new())).err();
    let message = refused.map_or(String::new(), |error| error.to_string());
    message.split('`').skip(3).step_by(2).map(str::to_owned).collect()
}

/// The value of the key of that dotted name in a case without it.
pub(super) fn default(dotted: &str) -> Field<'static> {
    static DOCUMENT: LazyLock<Document<&str>> = LazyLock::new(|| DEFAULTS.document().expect("the defaults are TOML"));
    let key = keys::of(dotted).expect("what is read is in the table of keys");
    let root = Field::root(&DEFAULTS, DOCUMENT.as_item());
    key.name.split('.').try_fold(root, |table, key| table.entry(key)).expect("what may be left out has a default")
}

/// A number as a decimal with all its digits, or as what it is if it is not finite; `None` if it is no number.
fn number(value: &Value, literal: &str) -> Option<Result<String, f64>> {
    match value {
        Value::Integer(number) => Some(Ok(number.value().to_string())),
        Value::Float(number) if !number.value().is_finite() => Some(Err(*number.value())),
        Value::Float(_) => Some(Ok(literal.trim_start_matches('+').replace('_', ""))),
        _ => None,
    }
}
