//! Tables of a case, read strictly: every key must be asked for, and every mistake has its place in the text.

use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::Error;
use toml_edit::{Item, Table, TableLike, Value};

use super::quantity::Quantity;
use super::source::{Source, readable};
use super::{CaseError, hint};
use crate::formula::FormulaError;

/// A table, with the keys that were asked for.
pub(super) struct Section<'t> {
    source: &'t Source,
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
    item: &'t Item,
    span: Range<usize>,
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

    /// Returns true if the case is that of a potential of x alone, as the paper has it.
    pub(super) fn is_of_x(&self) -> bool {
        self.source.is_of_x
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
            error.with_help(meant.map(|meant| format!("did you mean `{meant}`?")))
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

    pub(super) fn is_table(&self) -> bool {
        self.item.is_table_like()
    }

    pub(super) fn as_str(&self) -> Option<&'t str> {
        self.item.as_str()
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

    /// The same as a number of the scene.
    pub(super) fn quantity(&self) -> Result<Quantity, CaseError> {
        self.formula().map(Quantity::new)
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

    /// The numbers of an array.
    pub(super) fn numbers(&self) -> Result<Vec<String>, CaseError> {
        let array = self.item.as_array().ok_or_else(|| self.expected("an array of numbers"))?;
        let read = |value: &Value| {
            let span = value.span().unwrap_or_else(|| self.span.clone());
            let wrong = || format!("'{}' must have finite numbers only, found {value}", self.path);
            let decimal = number(value, &self.source.text[span.clone()]).and_then(Result::ok);
            decimal.ok_or_else(|| self.error_at(span, wrong()))
        };
        array.iter().map(read).collect()
    }

    /// The numbers and formulas of an array.
    pub(super) fn quantities(&self) -> Result<Vec<Quantity>, CaseError> {
        let array = self.item.as_array().ok_or_else(|| self.expected("an array of numbers"))?;
        let read = |value: &Value| {
            let span = value.span().unwrap_or_else(|| self.span.clone());
            let wrong = || format!("'{}' must have finite numbers or formulas, found {value}", self.path);
            let decimal = || number(value, &self.source.text[span.clone()]).and_then(Result::ok);
            let text = value.as_str().map(str::to_owned).or_else(decimal);
            text.map(Quantity::new).ok_or_else(|| self.error_at(span.clone(), wrong()))
        };
        array.iter().map(read).collect()
    }

    /// The number of elements of an array.
    pub(super) fn length(&self) -> Option<usize> {
        self.item.as_array().map(toml_edit::Array::len)
    }

    /// The place of the value.
    pub(super) fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// The tables of an array.
    pub(super) fn tables(&self) -> Result<Vec<Section<'t>>, CaseError> {
        let section = |(k, (table, span)): (usize, (&'t dyn TableLike, Option<Range<usize>>))| {
            let (path, span) = (format!("{}.{}", self.path, k + 1), span.unwrap_or_else(|| self.span.clone()));
            Section { source: self.source, path, table: Some(table), span, known: Vec::new() }
        };
        if let Some(tables) = self.item.as_array_of_tables() {
            let each = tables.iter().map(|table| (table as &'t dyn TableLike, table.span()));
            return Ok(each.enumerate().map(section).collect());
        }
        let array = self.item.as_array().ok_or_else(|| self.expected("an array of tables"))?;
        let each =
            array.iter().map(|value| value.as_inline_table().map(|table| (table as &'t dyn TableLike, value.span())));
        let each = each.collect::<Option<Vec<_>>>().ok_or_else(|| self.expected("an array of tables"))?;
        Ok(each.into_iter().enumerate().map(section).collect())
    }

    /// The strings of an array with their places.
    pub(super) fn strings(&self) -> Result<Vec<(String, Range<usize>)>, CaseError> {
        let array = self.item.as_array().ok_or_else(|| self.expected("an array of strings"))?;
        let read = |value: &Value| {
            let span = value.span().unwrap_or_else(|| self.span.clone());
            let wrong = || {
                let message = format!("'{}' must have strings only, found {}", self.path, value.type_name());
                self.source.error(Some(span.clone()), message, None)
            };
            Ok((value.as_str().ok_or_else(wrong)?.to_owned(), span.clone()))
        };
        array.iter().map(read).collect()
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
            let message = readable(&error.to_string());
            let help = hint::for_word(&message);
            self.error(message).with_help(help)
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

impl CaseError {
    /// The same with what to do.
    pub(super) fn with_help(mut self, help: impl Into<Option<String>>) -> Self {
        self.help = help.into().or(self.help);
        self
    }
}
