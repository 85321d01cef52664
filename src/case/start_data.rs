//! The initial data as a case gives them.

use super::reader::Field;

/// The root that is meant, of two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// The larger root.
    Plus,
    /// The smaller root.
    Minus,
}

/// The velocity or the momentum that is given along a coordinate: a decimal with all its digits, or a formula in the
/// parameters of the scene, such as `sqrt(19)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Rate {
    /// dq/dγ.
    Velocity(String),
    /// The momentum.
    Momentum(String),
    /// dq/dγ follows from K; without a sign the equation for it is linear.
    VelocityFromNorm(Option<Sign>),
    /// The momentum follows from K; without a sign the equation for it is linear.
    MomentumFromNorm(Option<Sign>),
}

impl Rate {
    /// Returns true if it is about the momentum.
    pub(super) fn is_momentum(&self) -> bool {
        matches!(self, Self::Momentum(_) | Self::MomentumFromNorm(_))
    }

    /// Returns true if it follows from K.
    pub(super) fn is_from_norm(&self) -> bool {
        matches!(self, Self::VelocityFromNorm(_) | Self::MomentumFromNorm(_))
    }
}

/// The initial data as the case gives them, without the coordinate tau that `conformal` may add.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StartData {
    /// The position of every coordinate.
    pub q: Vec<String>,
    /// The rate of every coordinate. At most one follows from the norm.
    pub rates: Vec<Rate>,
    /// K, if a rate follows from it.
    pub norm: Option<String>,
}

/// The position and the rate of a coordinate, as far as they are given, with their places in the text.
#[derive(Clone, Default)]
pub(super) struct Given<'t> {
    pub(super) position: Option<(String, Field<'t>)>,
    pub(super) rate: Option<(Rate, Field<'t>)>,
}
