//! The operators by name: `SBP21`, `SBP42`, `SBP63`, `SBP84`, `GLL<n>`.

use std::fmt;

use serde::Deserialize;

use super::coefficients::{Coefficients, SBP21, SBP42, SBP63, SBP84};
use super::gll::{LEAST_NODES, MOST_NODES};
use super::{SbpOperator, TooFewPoints};
use crate::number::Real;

/// The name of an operator. Spacing and, for finite differences, the number of nodes are still to be chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
#[serde(try_from = "String")]
pub enum SbpName {
    /// Second order inside, first at the boundary.
    Sbp21,
    /// Fourth order inside, second at the boundary.
    Sbp42,
    /// Sixth order inside, third at the boundary.
    Sbp63,
    /// Eighth order inside, fourth at the boundary.
    Sbp84,
    /// The spectral element of that many Gauss–Lobatto–Legendre nodes.
    Gll(u8),
}

impl SbpName {
    /// The finite-difference operators.
    pub const STENCILS: [Self; 4] = [Self::Sbp21, Self::Sbp42, Self::Sbp63, Self::Sbp84];

    /// All operators.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::STENCILS.into_iter().chain((LEAST_NODES..=MOST_NODES).map(|nodes| Self::Gll(nodes as u8)))
    }

    /// The names of the finite-difference operators, for messages.
    pub(crate) fn stencils() -> String {
        Self::STENCILS.map(|name| name.to_string()).join(", ")
    }

    /// The coefficients of a finite-difference operator; `None` for a spectral element.
    pub fn coefficients(self) -> Option<&'static Coefficients> {
        match self {
            Self::Sbp21 => Some(&SBP21),
            Self::Sbp42 => Some(&SBP42),
            Self::Sbp63 => Some(&SBP63),
            Self::Sbp84 => Some(&SBP84),
            Self::Gll(_) => None,
        }
    }

    /// The number of nodes of a spectral element; `None` for a finite-difference operator, which has any number of
    /// nodes from its minimum on.
    pub fn fixed_points(self) -> Option<usize> {
        match self {
            Self::Gll(nodes) => Some(usize::from(nodes)),
            _ => None,
        }
    }

    /// Smallest number of nodes.
    pub fn minimum_points(self) -> usize {
        self.coefficients().map_or_else(|| self.fixed_points().unwrap_or(LEAST_NODES), |table| table.minimum_points)
    }

    /// Degree up to which the rows at the ends differentiate polynomials exactly.
    pub fn boundary_order(self) -> usize {
        match self {
            Self::Gll(nodes) => usize::from(nodes) - 1,
            _ => self.coefficients().map_or(0, |table| table.interior_order / 2),
        }
    }

    /// The operator on `points` nodes with the (mean) `spacing` Δγ.
    ///
    /// # Errors
    /// [`TooFewPoints`] if the closures do not fit, or a spectral element has another number of nodes.
    pub fn operator<S: Real>(self, points: usize, spacing: S) -> Result<SbpOperator<S>, TooFewPoints> {
        match self {
            Self::Gll(nodes) if points == usize::from(nodes) => {
                Ok(SbpOperator::gauss_lobatto(points, spacing * S::from((points - 1) as f64)))
            }
            Self::Gll(nodes) => Err(TooFewPoints { operator: self.to_string(), points, minimum: usize::from(nodes) }),
            _ => SbpOperator::new(self.coefficients().expect("not a spectral element"), points, spacing),
        }
    }
}

impl fmt::Display for SbpName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gll(nodes) => write!(f, "GLL{nodes}"),
            _ => f.write_str(self.coefficients().map_or("", |table| table.name)),
        }
    }
}

impl TryFrom<String> for SbpName {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        if let Some(known) = Self::STENCILS.into_iter().find(|known| known.to_string() == name) {
            return Ok(known);
        }
        let digits =
            name.strip_prefix("GLL").filter(|digits| !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()));
        match digits.map(|digits| digits.parse::<usize>().unwrap_or(usize::MAX)) {
            Some(nodes) if (LEAST_NODES..=MOST_NODES).contains(&nodes) => Ok(Self::Gll(nodes as u8)),
            Some(_) => Err(format!("GLL<n> has from {LEAST_NODES} to {MOST_NODES} nodes, got {name}")),
            None => {
                let upper = name.to_uppercase();
                let is_known = upper != name && Self::try_from(upper.clone()).is_ok();
                let meant = if is_known { format!("; did you mean \"{upper}\"?") } else { String::new() };
                let known = Self::stencils();
                Err(format!("unknown operator \"{name}\", expected {known} or GLL<n>, for example GLL16{meant}"))
            }
        }
    }
}
