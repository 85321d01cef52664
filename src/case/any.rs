//! A case of either kind.

use super::parse::Source;
use super::{Case, CaseError, Form, SceneCase, scene};

/// A case of one coordinate in a potential, or a scene.
#[derive(Debug, Clone)]
pub enum AnyCase {
    /// One coordinate in a potential.
    One(Box<Case>),
    /// n coordinates.
    Scene(Box<SceneCase>),
}

impl AnyCase {
    /// Reads a case of either kind from TOML `text` after applying `overrides` of the form `dotted.key=value`.
    ///
    /// # Errors
    /// [`CaseError`] for anything that is not a complete, valid case.
    pub fn parse(source_name: &str, text: &str, overrides: &[String]) -> Result<Self, CaseError> {
        let source = Source::new(source_name, text, overrides)?;
        // A text that cannot be read is explained by the reader of cases of one coordinate.
        let is_scene = source.document().is_ok_and(|document| scene::is_scene_table(document.as_table()));
        match is_scene {
            true => SceneCase::from_source(&source).map(|case| Self::Scene(Box::new(case))),
            false => Case::from_source(&source).map(|case| Self::One(Box::new(case))),
        }
    }

    /// Its title.
    pub fn title(&self) -> Option<&str> {
        match self {
            Self::One(case) => case.title.as_deref(),
            Self::Scene(case) => case.title(),
        }
    }

    /// The names of its coordinates.
    pub fn coordinates(&self) -> Vec<String> {
        match self {
            Self::One(_) => ["t", "x"].map(str::to_owned).to_vec(),
            Self::Scene(case) => case.coordinates(),
        }
    }

    /// What one should know about it.
    pub fn warnings(&self) -> Vec<String> {
        match self {
            Self::One(case) => case.warnings(),
            Self::Scene(case) => case.warnings(),
        }
    }

    /// Whether it asks for more digits than `f64` has.
    pub fn is_extended(&self) -> bool {
        match self {
            Self::One(case) => case.is_extended(),
            Self::Scene(case) => case.is_extended(),
        }
    }

    /// The form of its action.
    pub fn form(&self) -> Form {
        match self {
            Self::One(case) => case.scheme.form,
            Self::Scene(case) => case.form(),
        }
    }

    /// Its number of windows.
    pub fn windows(&self) -> usize {
        match self {
            Self::One(case) => case.grid.windows,
            Self::Scene(case) => case.windows(),
        }
    }

    /// Whether it has events.
    pub fn has_events(&self) -> bool {
        match self {
            Self::One(_) => false,
            Self::Scene(case) => !case.events().is_empty(),
        }
    }

    /// Whether it asks for an accuracy.
    pub fn has_accuracy(&self) -> bool {
        match self {
            Self::One(case) => case.solver.accuracy.is_some(),
            Self::Scene(case) => case.accuracy().is_some(),
        }
    }
}
