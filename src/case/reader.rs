//! Tables of a case, read strictly: every key must be asked for, and every mistake has its place in the text.

use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::Error;
use toml_edit::{Item, Table, TableLike, Value};

use super::source::Source;
use super::{CaseError, hint};
use crate::formula::FormulaError;
use crate::formula::similar::nearest;

/// A table, with the keys that were asked for.
pub(super) struct Section<'t> {
    pub(super) source: &'t Source,
    path: String,
    table: Option<&'t dyn TableLike>,
    span: Range<usize>,
    known: Vec<String>,
}

/// A value with its place.
#[derive(Clone)]
pub(super) struct Field<'t> {
    source: &'t Source,
    /// Its dotted key.
    pub(super) path: String,
    /// The last part of its key.
    pub(super) key: String,
    pub(super) item: &'t Item,
    /// The places of the value and of the key.
    pub(super) span: Range<usize>,
    pub(super) key_span: Range<usize>,
}

impl<'t> Section<'t> {
    /// The table at the top.
    pub(super) fn root(source: &'t Source, table: &'t Table) -> Self {
        Self { source, path: String::new(), table: Some(table), span: 0..0, known: Vec::new() }
    }

    /// The value of a key, which is a known one from now on.
    pub(super) fn take(&mut self, key: &str) -> Option<Field<'t>> {
        if !self.knows(key) {
            self.known.push(key.to_owned());
        }
        self.field(key)
    }

    /// The table below a key; an empty one if there is none.
    pub(super) fn section(&mut self, key: &str) -> Result<Section<'t>, CaseError> {
        match self.take(key) {
            Some(field) => field.section(),
            None => {
                let path = self.dotted(key);
                Ok(Section { source: self.source, path, table: None, span: self.span.clone(), known: Vec::new() })
            }
        }
    }

    /// All values of a table whose keys are names of the user.
    pub(super) fn fields(&self) -> Vec<Field<'t>> {
        let keys = self.table.iter().flat_map(|table| table.iter().map(|(key, _)| key));
        keys.filter_map(|key| self.field(key)).collect()
    }

    /// Returns true if the table is in the text.
    pub(super) fn is_given(&self) -> bool {
        self.table.is_some()
    }

    /// Refuses keys that were not asked for.
    pub(super) fn finish(&self) -> Result<(), CaseError> {
        self.unknown().into_iter().next().map_or(Ok(()), Err)
    }

    /// Returns true if a key was asked for.
    pub(super) fn knows(&self, key: &str) -> bool {
        self.known.iter().any(|known| known == key)
    }

    /// One mistake for each key that was not asked for.
    pub(super) fn unknown(&self) -> Vec<CaseError> {
        let known = || self.known.iter().map(String::as_str);
        let list = match self.known.as_slice() {
            [] => "this table has no keys".to_owned(),
            [one] => format!("the only key is `{one}`"),
            all => format!("expected one of `{}`", all.join("`, `")),
        };
        let mistake = |field: Field<'t>| {
            let meant = hint::for_key(&field.key, &self.path, known());
            let error = field.key_error(format!("unknown field `{}`, {list}", field.key));
            error.with_hint(meant.map(|meant| format!("did you mean `{meant}`?")))
        };
        self.fields().into_iter().filter(|field| !self.knows(&field.key)).map(mistake).collect()
    }

    /// A mistake that concerns the table.
    pub(super) fn error(&self, message: impl Into<String>) -> CaseError {
        self.source.error(Some(self.span.clone()), message.into(), None)
    }

    fn dotted(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    fn field(&self, key: &str) -> Option<Field<'t>> {
        let (written, item) = self.table?.get_key_value(key)?;
        let key_span = written.span().unwrap_or_else(|| self.span.clone());
        // A table that dotted keys make has no place of its own.
        let span = item.span().unwrap_or_else(|| key_span.clone());
        Some(Field { source: self.source, path: self.dotted(key), key: key.to_owned(), item, span, key_span })
    }
}

impl<'t> Field<'t> {
    /// A mistake in the value.
    pub(super) fn error(&self, message: impl Into<String>) -> CaseError {
        self.source.error(Some(self.span.clone()), message.into(), None)
    }

    /// A mistake in the key.
    pub(super) fn key_error(&self, message: impl Into<String>) -> CaseError {
        self.source.error(Some(self.key_span.clone()), message.into(), None)
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
        match self.source.text[self.span.clone()].find(string).filter(|_| self.item.as_str() == Some(string)) {
            Some(offset) => self.span.start + offset + part.start..self.span.start + offset + part.end,
            None => self.span.clone(),
        }
    }

    /// (line, column) of the key.
    pub(super) fn line_and_column(&self) -> (usize, usize) {
        self.key_error("").line_and_column().unwrap_or((1, 1))
    }

    fn expected(&self, what: &str) -> CaseError {
        self.error(format!("'{}' must be {what}, found {}", self.path, self.item.type_name()))
    }

    /// The table that the value is.
    pub(super) fn section(&self) -> Result<Section<'t>, CaseError> {
        let table = self.item.as_table_like().ok_or_else(|| self.expected("a table"))?;
        let (path, span) = (self.path.clone(), self.span.clone());
        Ok(Section { source: self.source, path, table: Some(table), span, known: Vec::new() })
    }

    /// The string that the value is.
    pub(super) fn string(&self) -> Result<&'t str, CaseError> {
        self.item.as_str().ok_or_else(|| self.expected("a string"))
    }

    /// The number or the formula that the value is, with all digits of a number.
    pub(super) fn formula(&self) -> Result<String, CaseError> {
        match self.item.as_value() {
            Some(Value::String(string)) => Ok(string.value().clone()),
            Some(value) => number(value, &self.source.text[self.span.clone()])
                .ok_or_else(|| self.expected("a number or a formula"))?
                .map_err(|value| self.error(format!("'{}' must be a finite number, got {value}", self.path))),
            None => Err(self.expected("a number or a formula")),
        }
    }

    /// The number that the value is, with all its digits.
    pub(super) fn number(&self) -> Result<String, CaseError> {
        if self.item.is_str() { Err(self.expected("a number")) } else { self.formula() }
    }

    /// A path, counted from the folder of the case.
    pub(super) fn beside_the_case(&self, path: &Path) -> PathBuf {
        let beside = self.source.folder.join(path);
        std::path::absolute(&beside).unwrap_or(beside)
    }

    /// The elements of an array `of` something, as `read` understands a value and its literal, with their places.
    fn elements<T>(
        &self,
        of: &str,
        wrong: impl Fn(&Value) -> String,
        read: impl Fn(&'t Value, &str) -> Option<T>,
    ) -> Result<Vec<(T, Range<usize>)>, CaseError> {
        let array = self.item.as_array().ok_or_else(|| self.expected(&format!("an array of {of}")))?;
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

    /// The tables of an array.
    pub(super) fn tables(&self) -> Result<Vec<Section<'t>>, CaseError> {
        let wrong = || self.expected("an array of tables");
        let tables: Vec<(&'t dyn TableLike, Option<Range<usize>>)> = match self.item {
            Item::ArrayOfTables(tables) => tables.iter().map(|table| (table as _, table.span())).collect(),
            item => {
                let inline = |value: &'t Value| Some((value.as_inline_table()? as _, value.span()));
                item.as_array().and_then(|array| array.iter().map(inline).collect()).ok_or_else(wrong)?
            }
        };
        let section = |(k, (table, span)): (usize, (_, Option<Range<usize>>))| {
            let (path, span) = (format!("{}.{}", self.path, k + 1), span.unwrap_or_else(|| self.span.clone()));
            Section { source: self.source, path, table: Some(table), span, known: Vec::new() }
        };
        Ok(tables.into_iter().enumerate().map(section).collect())
    }

    /// A mistake at a place inside the value.
    pub(super) fn error_at(&self, span: Range<usize>, message: String) -> CaseError {
        self.source.error(Some(span), message, None)
    }

    /// The truth value that the value is.
    pub(super) fn is_true(&self) -> Result<bool, CaseError> {
        self.item.as_bool().ok_or_else(|| self.expected("true or false"))
    }

    /// The whole number that the value is.
    pub(super) fn whole(&self) -> Result<usize, CaseError> {
        let whole = self.item.as_integer().and_then(|number| usize::try_from(number).ok());
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

/// A number as a decimal with all its digits, or as what it is if it is not finite; `None` if it is no number.
fn number(value: &Value, literal: &str) -> Option<Result<String, f64>> {
    match value {
        Value::Integer(number) => Some(Ok(number.value().to_string())),
        Value::Float(number) if !number.value().is_finite() => Some(Err(*number.value())),
        Value::Float(_) => Some(Ok(literal.trim_start_matches('+').replace('_', ""))),
        _ => None,
    }
}
