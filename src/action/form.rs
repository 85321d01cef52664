//! The two forms of the action.

use serde::{Deserialize, Serialize};

/// The form of the action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(try_from = "String", rename_all = "lowercase")]
pub enum Form {
    /// The form of the paper: Lagrange multipliers impose the initial conditions and connect the branches.
    #[default]
    Strong,
    /// The weak form that the paper's outlook asks for, with boundary terms in place of the multipliers. Q_t is exact
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
