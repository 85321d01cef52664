//! The one error of everything that can be wrong with a case.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// A mistake in a case, its place, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CaseError {
    /// Name of the source: a path, `<stdin>`, or either of them with overrides.
    pub source_name: Arc<str>,
    /// The text that `span` refers to.
    pub text: Arc<str>,
    /// Byte range of the mistake in `text`, if it has a place there.
    pub span: Option<Range<usize>>,
    /// The mistake in words.
    pub message: String,
    /// The remedy, if it is not obvious from the message.
    pub help: Option<String>,
    /// The mistakes that were found with this one, in the order of the text.
    pub further: Box<[CaseError]>,
}

impl CaseError {
    /// A mistake that has no place in the text, for example one that concerns the case as a whole.
    pub fn without_place(source_name: &str, message: String) -> Self {
        let source_name = source_name.into();
        Self { source_name, text: "".into(), span: None, message, help: None, further: Box::default() }
    }

    /// The same with what to do.
    pub(super) fn with_help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// The same with what to do, if that is known.
    pub(super) fn with_hint(self, help: Option<String>) -> Self {
        Self { help: help.or(self.help), ..self }
    }

    /// The first of some mistakes, with the others; `None` if there is none.
    pub(super) fn first_of(mistakes: Vec<Self>) -> Option<Self> {
        let mut mistakes = mistakes.into_iter();
        let first = mistakes.next()?;
        Some(Self { further: mistakes.collect(), ..first })
    }

    /// (line, column) of the mistake, both from 1; the column counts characters.
    pub fn line_and_column(&self) -> Option<(usize, usize)> {
        let before = &self.text[..self.span.as_ref()?.start];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Some((before.matches('\n').count() + 1, before[line_start..].chars().count() + 1))
    }
}

impl fmt::Display for CaseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.source_name)?;
        if let Some((line, column)) = self.line_and_column() {
            write!(f, ":{line}:{column}")?;
        }
        write!(f, ": {}", self.message)?;
        match self.further.len() {
            0 => Ok(()),
            1 => write!(f, " (and one more mistake)"),
            more => write!(f, " (and {more} more mistakes)"),
        }
    }
}

impl std::error::Error for CaseError {}
