//! What is to be solved in a scene of n coordinates, and how.

use crate::geometry::{Direction, Observable};
use crate::scalar::Real;
use crate::solve::Settings;
use crate::solve::world_line::Place;

/// The largest extent of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SceneLimit<S = f64> {
    /// After this length of γ.
    Length(S),
    /// Where a coordinate reaches a value.
    Value {
        /// The coordinate.
        coordinate: usize,
        /// Its value at the end.
        value: S,
    },
}

/// A formula at whose first change of sign in a direction a run ends.
#[derive(Debug, Clone)]
pub struct Until<S = f64> {
    /// The formula.
    pub formula: Observable<S>,
    /// The same in `f64`.
    pub rough: Observable,
    /// Which changes count.
    pub direction: Direction,
}

/// Everything that the solver of scenes is told.
#[derive(Debug, Clone)]
pub struct SceneSetup<S = f64> {
    /// The geometry and the start.
    pub place: Place<S>,
    /// The same in `f64`, where first guesses and linear algebra work.
    pub rough: Place,
    /// The first value of γ.
    pub gamma_i: S,
    /// Where the run ends at the latest.
    pub limit: SceneLimit<S>,
    /// Formulas at whose first change of sign it ends before that.
    pub until: Vec<Until<S>>,
    /// How it is computed.
    pub settings: Settings,
}

impl<S> Until<S> {
    /// The same in `f64`.
    fn in_f64(&self) -> Until {
        Until { formula: self.rough.clone(), rough: self.rough.clone(), direction: self.direction }
    }
}

impl<S: Real> SceneSetup<S> {
    /// The same in `f64`.
    pub(super) fn in_f64(&self) -> SceneSetup {
        SceneSetup {
            place: self.rough.clone(),
            rough: self.rough.clone(),
            gamma_i: self.gamma_i.to_f64(),
            limit: match self.limit {
                SceneLimit::Length(length) => SceneLimit::Length(length.to_f64()),
                SceneLimit::Value { coordinate, value } => SceneLimit::Value { coordinate, value: value.to_f64() },
            },
            until: self.until.iter().map(Until::in_f64).collect(),
            settings: self.settings.within::<f64>(),
        }
    }
}
