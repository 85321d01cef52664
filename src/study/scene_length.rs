//! Where the run of a scene ends, found by the reference.

use std::cell::RefCell;

use crate::Numeric;
use crate::reference::{ReferenceEnds, ReferenceTrajectory, ScenePoint};
use crate::solve::{Limit, Setup};

/// The run is searched for the end that a formula gives in so many stages, each twice as long as all before it: what
/// comes after that end need not exist.
const STAGES: i32 = 6;

/// γ_f − γ_i of the run that is set up, wherever it ends.
///
/// # Errors
/// [`ReferenceEnds`] if the world-line does not get there.
pub fn length_of<S: Numeric>(setup: &Setup<S>) -> Result<S, ReferenceEnds> {
    let (geometry, start, digits) = (&*setup.place.geometry, &*setup.place.start, setup.settings.digits);
    let whole = match setup.limit {
        Limit::Length(length) => length,
        Limit::Value { coordinate, value } => {
            ReferenceTrajectory::length_of(geometry, start, coordinate, value, digits)?
        }
    };
    if setup.until.is_empty() {
        return Ok(whole);
    }
    let norm = geometry.norm(&start.q, &start.q_dot);
    for stage in (0..=STAGES).rev() {
        let length = whole * S::from(0.5_f64.powi(stage));
        let reference = ReferenceTrajectory::new(geometry, start, length, digits)?;
        let firsts = setup.until.iter().filter_map(|until| {
            let formula = RefCell::new(until.formula.clone());
            let value = |point: &ScenePoint<S>| formula.borrow_mut().at(&point.q, &point.q_dot, &point.p, norm);
            let changes = reference.directed_sign_changes(value).into_iter();
            changes.filter(|(_, to_positive)| until.direction.counts(*to_positive)).map(|(gamma, _)| gamma).next()
        });
        if let Some(first) = firsts.reduce(|a, b| if a < b { a } else { b }) {
            return Ok(first);
        }
    }
    Ok(whole)
}
