//! A case of either kind.

use super::parse::Source;
use super::{Case, CaseError, SceneCase, scene};
use crate::solve::Settings;

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

    /// It as TOML, with every default filled in. Reading that text gives the same case.
    pub fn to_toml(&self) -> String {
        match self {
            Self::One(case) => case.to_toml(),
            Self::Scene(case) => case.to_toml(),
        }
    }

    /// The same without its `[expect]` table.
    pub fn without_expectations(self) -> Self {
        match self {
            Self::One(case) => Self::One(Box::new(Case { expect: None, ..*case })),
            Self::Scene(case) => Self::Scene(Box::new(case.without_expectations())),
        }
    }

    /// Whether it asks for more digits than `f64` has.
    pub fn is_extended(&self) -> bool {
        self.settings().is_extended()
    }

    /// How its world-line is computed.
    pub fn settings(&self) -> Settings {
        match self {
            Self::One(case) => case.settings(),
            Self::Scene(case) => case.settings(),
        }
    }

    /// Whether it has events.
    pub fn has_events(&self) -> bool {
        match self {
            Self::One(_) => false,
            Self::Scene(case) => !case.events().is_empty(),
        }
    }
}
