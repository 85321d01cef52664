//! The space-time as studies see it.

use std::cell::RefCell;

use crate::diagnostics::Diagnostics;
use crate::geometry::{Geometry, Start};
use crate::number::Real;
use crate::number::norm::{larger, max_abs};
use crate::reference::{ReferenceEnds, ReferenceTrajectory};
use crate::solve::{Limit, Place, Setup, WorldLine};

/// A point of a world-line; in one coordinate t is counted from the start.
pub type Point<S = f64> = Start<S>;

/// The deviations that studies measure on a world-line.
pub struct Deviations {
    /// The largest deviation of every charge where it is exact.
    pub charges: Vec<f64>,
    /// The deviation of every charge at the end of windows: in one coordinate at the last node of the run, and in a
    /// scene the largest of all windows.
    pub charges_last: Vec<f64>,
    /// The deviation of every charge at the last node, and the same with its multiplier.
    pub last_node: Vec<[f64; 2]>,
    /// ΔK on the nodes.
    pub delta_k: Vec<f64>,
    /// ΔK at the ends of windows, for what the next one starts with.
    pub delta_k_ends: Vec<f64>,
    /// The largest |ΔK| where charges are exact.
    pub delta_k_max: f64,
    /// With Newton's law: the largest deviation of the energy.
    pub energy_max: Option<f64>,
}

/// The run is searched for the end that a formula gives in so many stages, each twice as long as all before it: what
/// comes after that end need not exist.
const STAGES: i32 = 6;

/// The distance of a coordinate from where its size is counted from: 0, or the start if it is ignorable.
pub(super) fn distance<S: Real>(place: &Place<S>, a: usize, q: S) -> f64 {
    let is_active = place.geometry.active().contains(&a);
    (if is_active { q } else { q - place.start.q[a] }).to_f64().abs()
}

/// The last number of a row.
fn last(row: &[impl Real]) -> f64 {
    row.last().map_or(f64::NAN, |value| value.to_f64())
}

/// The reference from the start of a place, of this length in γ.
///
/// # Errors
/// [`ReferenceEnds`] if it ends before.
pub(super) fn reference<S: Real>(
    place: &Place<S>,
    length: S,
    digits: u32,
) -> Result<ReferenceTrajectory<S>, ReferenceEnds> {
    ReferenceTrajectory::new(&place.geometry, &place.start, length, digits)
}

/// γ_f − γ_i of the run that is set up, wherever it ends.
///
/// # Errors
/// [`ReferenceEnds`] if the world-line does not get there.
pub(super) fn length_of<S: Real>(setup: &Setup<S>) -> Result<S, ReferenceEnds> {
    let (geometry, start, digits) = (&*setup.place.geometry, &*setup.place.start, setup.settings.digits);
    let whole = match setup.limit {
        Limit::Length(length) => length,
        Limit::Value { coordinate, value } => {
            let value = value - setup.origin_of(coordinate);
            ReferenceTrajectory::length_of(geometry, start, coordinate, value, digits)?
        }
    };
    if setup.until.is_empty() {
        return Ok(whole);
    }
    let norm = geometry.norm(&start.q, &start.q_dot);
    for stage in (0..=STAGES).rev() {
        let length = whole * S::from(0.5_f64.powi(stage));
        let reference = reference(&setup.place, length, digits)?;
        let firsts = setup.until.iter().filter_map(|until| {
            let formula = RefCell::new(until.formula.clone());
            let value = |point: &Start<S>| formula.borrow_mut().at(&point.q, &point.q_dot, &point.p, norm);
            let changes = reference.directed_sign_changes(value).into_iter();
            changes.filter(|(_, to_positive)| until.direction.counts(*to_positive)).map(|(gamma, _)| gamma).next()
        });
        if let Some(first) = firsts.reduce(|a, b| if a < b { a } else { b }) {
            return Ok(first);
        }
    }
    Ok(whole)
}

/// Measures a run. `is_lifted` says whether it is one of Newton's law, which has an energy.
pub(super) fn deviations<S: Real>(line: &WorldLine<S>, is_lifted: bool) -> Deviations {
    let found = Diagnostics::of(line, &[], &mut [], is_lifted);
    let Diagnostics { charges, norm, energy, .. } = found;
    let energy_max = energy.map(|energy| {
        let inside = line.grids().map(|grid| max_abs(&energy.delta[grid.exact()]).to_f64()).fold(0.0, larger);
        larger(inside, energy.max_ends.to_f64())
    });
    // In one coordinate it is that of the run's last node, as the paper has it.
    let is_of_x = line.geometry().c_squared().is_some();
    let in_f64 = |row: &[S]| row.iter().map(|value| value.to_f64()).collect();
    Deviations {
        charges: charges.iter().map(|charge| charge.max_interior.to_f64()).collect(),
        charges_last: charges
            .iter()
            .map(|charge| (if is_of_x { charge.last } else { charge.max_last }).to_f64())
            .collect(),
        last_node: charges.iter().map(|charge| [last(&charge.delta), last(&charge.corrected)]).collect(),
        delta_k: in_f64(&norm.delta),
        delta_k_ends: in_f64(&norm.ends),
        delta_k_max: norm.max_interior.to_f64(),
        energy_max,
    }
}

/// The rows of a run, counted as the points of the reference are.
pub(super) fn rows<S: Real>(line: &WorldLine<S>) -> Vec<Vec<S>> {
    let of = |a: usize| match line.origin {
        Some(_) => line.counted_from_origin(a, &line.q[a]).collect(),
        None => line.q(a).collect(),
    };
    (0..line.geometry().dimension()).map(of).collect()
}

/// The names of the coordinates whose momenta are charges.
pub(super) fn charges<S: Real>(geometry: &Geometry<S>) -> Vec<String> {
    geometry.ignorable().map(|a| geometry.names()[a].clone()).collect()
}
