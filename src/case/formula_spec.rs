//! A potential given as a formula, in the syntax of a case file.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{self, Deserializer, MapAccess, Visitor};
use serde::{Deserialize, Serialize};

use super::Decimal;
use crate::formula::{self, FormulaError, Graph, Names};

/// `formula = { expression = "…", parameters = { … } }`, or `formula = "…"` where there are no parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FormulaSpec {
    /// An expression in x and the parameters.
    pub expression: String,
    /// The values of the parameters, by their names.
    pub parameters: BTreeMap<String, Decimal>,
}

impl FormulaSpec {
    /// Looks for a mistake in the expression.
    ///
    /// # Errors
    /// [`FormulaError`] with its place.
    pub(super) fn check(&self) -> Result<(), FormulaError> {
        self.without(None)
    }

    /// Parameters that the expression does not use.
    pub(super) fn unused_parameters(&self) -> Vec<&str> {
        let unused = |name: &&str| self.without(Some(name)).is_ok();
        self.parameters.keys().map(String::as_str).filter(unused).collect()
    }

    fn without(&self, missing: Option<&str>) -> Result<(), FormulaError> {
        let kept = self.parameters.iter().filter(|(name, _)| Some(name.as_str()) != missing);
        let parameters: BTreeMap<String, f64> = kept.map(|(name, value)| (name.clone(), value.value())).collect();
        let names = Names { variables: &["x"], parameters: &parameters, definitions: &BTreeMap::new() };
        formula::parse(&self.expression, names, &mut Graph::default()).map(|_| ())
    }
}

impl<'de> Deserialize<'de> for FormulaSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        /// The form with a table.
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Table {
            expression: String,
            #[serde(default)]
            parameters: BTreeMap<String, Decimal>,
        }

        struct Either;

        impl<'de> Visitor<'de> for Either {
            type Value = FormulaSpec;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an expression, or a table with expression and parameters")
            }

            fn visit_str<E: de::Error>(self, expression: &str) -> Result<FormulaSpec, E> {
                Ok(FormulaSpec { expression: expression.to_owned(), parameters: BTreeMap::new() })
            }

            fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<FormulaSpec, M::Error> {
                let Table { expression, parameters } = Table::deserialize(MapAccessDeserializer::new(map))?;
                Ok(FormulaSpec { expression, parameters })
            }
        }

        deserializer.deserialize_any(Either)
    }
}
