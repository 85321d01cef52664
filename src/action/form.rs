//! The two forms of the action.

use serde::{Deserialize, Serialize};

/// The form of the action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(try_from = "String", rename_all = "lowercase")]
pub enum Form {
    /// The paper's: initial and connecting conditions by Lagrange multipliers.
    #[default]
    Strong,
    /// Boundary terms in place of the multipliers: the weak formulation that the paper's outlook asks for. Q_t is exact
    /// at every node, the last one included.
    Weak,
}

impl Form {
    /// The name used in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Strong => "strong",
            Self::Weak => "weak",
        }
    }
}

impl TryFrom<String> for Form {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        match name.as_str() {
            "strong" => Ok(Self::Strong),
            "weak" => Ok(Self::Weak),
            _ => Err(format!("unknown form \"{name}\", expected strong or weak")),
        }
    }
}
