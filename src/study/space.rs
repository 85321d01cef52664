//! What studies ask of a space-time.

use std::cell::RefCell;

use crate::diagnostics::Diagnostics;
use crate::geometry::geodesic::InitialData;
use crate::geometry::metric::Metric;
use crate::geometry::{Geometry, Start};
use crate::number::Real;
use crate::number::norm::{larger, max_abs};
use crate::reference::{Analytic, ReferenceEnds, ReferencePoint, ReferenceTrajectory, ScenePoint};
use crate::solve::Arithmetic;
use crate::solve::{Limit, NoSolution, Place, Setup, Space, WorldLine, solve};

/// A point of a world-line.
#[derive(Debug, Clone)]
pub struct Point<S = f64> {
    /// The coordinates; in one coordinate t is counted from the start.
    pub q: Vec<S>,
    /// Their derivatives by γ.
    pub q_dot: Vec<S>,
    /// The momenta, in scenes only.
    pub p: Vec<S>,
}

/// What studies measure on a world-line.
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

/// A space-time whose world-lines are solved, measured and compared with their reference.
pub trait Studied<S: Arithmetic>: Space<S> + Analytic<S, Point: Into<Point<S>>> + Send + Sync + 'static {
    /// The world-line of a setup.
    ///
    /// # Errors
    /// As [`solve`].
    fn solve(setup: &Setup<S, Self>) -> Result<WorldLine<S, Self>, NoSolution>;

    /// The reference from the start, of this length in γ.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if it ends before.
    fn reference(place: &Place<S, Self>, length: S, digits: u32)
    -> Result<ReferenceTrajectory<S, Self>, ReferenceEnds>;

    /// A point of the reference.
    fn at(reference: &ReferenceTrajectory<S, Self>, gamma: S) -> Self::Point;

    /// A coordinate of a point of the reference. A sweep asks for it at every node, without room of its own.
    fn coordinate(point: &Self::Point, a: usize) -> S;

    /// γ_f − γ_i of the run that is set up, wherever it ends.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if the world-line does not get there.
    fn length_of(setup: &Setup<S, Self>) -> Result<S, ReferenceEnds>;

    /// The start of a place, as the reference begins with it.
    fn start(place: &Place<S, Self>) -> Self::Start;

    /// What is measured on a run. `is_lifted` says whether it is one of Newton's law, which has an energy.
    fn deviations(line: &WorldLine<S, Self>, is_lifted: bool) -> Deviations;

    /// The rows of a run, counted as the points of the reference are.
    fn rows(line: &WorldLine<S, Self>) -> Vec<Vec<S>>;

    /// The `sizes` of coordinates, each the largest of all that have its unit.
    fn shared_sizes(place: &Place<S, Self>, sizes: Vec<f64>) -> Vec<f64>;

    /// The names of the coordinates whose momenta are charges.
    fn charges(&self) -> Vec<String> {
        let (names, active) = (self.coordinates(), self.active());
        names.into_iter().enumerate().filter(|(a, _)| !active.contains(a)).map(|(_, name)| name).collect()
    }
}

/// How far a coordinate is from where its size is counted from: 0, or the start if it is ignorable.
pub(super) fn distance<S: Arithmetic, G: Studied<S>>(place: &Place<S, G>, a: usize, q: S) -> f64 {
    let is_active = place.geometry.active().contains(&a);
    (if is_active { q } else { q - place.start.q[a] }).to_f64().abs()
}

impl<S: Real> From<ReferencePoint<S>> for Point<S> {
    fn from(ReferencePoint { elapsed, x, t_dot, x_dot }: ReferencePoint<S>) -> Self {
        Self { q: vec![elapsed, x], q_dot: vec![t_dot, x_dot], p: Vec::new() }
    }
}

impl<S: Real> From<ScenePoint<S>> for Point<S> {
    fn from(ScenePoint { q, q_dot, p }: ScenePoint<S>) -> Self {
        Self { q, q_dot, p }
    }
}

/// A row in `f64`.
fn in_f64<S: Real>(row: &[S]) -> Vec<f64> {
    row.iter().map(|value| value.to_f64()).collect()
}

/// The last number of a row.
fn last(row: &[impl Real]) -> f64 {
    row.last().map_or(f64::NAN, |value| value.to_f64())
}

impl<S: Arithmetic> Studied<S> for Metric<S> {
    fn solve(setup: &Setup<S, Self>) -> Result<WorldLine<S, Self>, NoSolution> {
        solve(setup)
    }

    fn reference(
        place: &Place<S, Self>,
        length: S,
        digits: u32,
    ) -> Result<ReferenceTrajectory<S, Self>, ReferenceEnds> {
        ReferenceTrajectory::new(&*place.geometry, &Self::start(place), length, digits)
    }

    fn at(reference: &ReferenceTrajectory<S, Self>, gamma: S) -> ReferencePoint<S> {
        reference.at(gamma)
    }

    fn coordinate(point: &ReferencePoint<S>, a: usize) -> S {
        if a == 0 { point.elapsed } else { point.x }
    }

    fn length_of(setup: &Setup<S, Self>) -> Result<S, ReferenceEnds> {
        match setup.limit {
            Limit::Length(length) => Ok(length),
            Limit::Value { coordinate, value } => {
                let origin = setup.origin.filter(|(a, _)| *a == coordinate).map_or(S::ZERO, |(_, origin)| origin);
                let (place, digits) = (&setup.place, setup.settings.digits);
                let start = Self::start(place);
                ReferenceTrajectory::length_of(&*place.geometry, &start, coordinate, value - origin, digits)
            }
        }
    }

    /// Time is counted from there.
    fn start(place: &Place<S, Self>) -> InitialData<S> {
        let start = &place.start;
        InitialData { t: start.q[0], x: start.q[1], t_dot: start.q_dot[0], x_dot: start.q_dot[1] }
    }

    fn deviations(line: &WorldLine<S, Self>, _: bool) -> Deviations {
        let Diagnostics { charges, norm, measures, .. } = Diagnostics::new(line);
        let at_last = measures.delta_q_t_last.to_f64();
        Deviations {
            charges: vec![measures.max_abs_delta_q_t_interior.to_f64()],
            charges_last: vec![at_last],
            last_node: vec![[at_last, last(&charges[0].corrected)]],
            delta_k: in_f64(&norm.delta),
            delta_k_ends: in_f64(&norm.ends),
            delta_k_max: measures.max_abs_delta_k.to_f64(),
            energy_max: None,
        }
    }

    fn rows(line: &WorldLine<S, Self>) -> Vec<Vec<S>> {
        let rows = [line.elapsed(), line.x()];
        rows.into_iter().enumerate().map(|(a, row)| line.counted_from_origin(a, row).collect()).collect()
    }

    /// t and x have units of their own.
    fn shared_sizes(_: &Place<S, Self>, sizes: Vec<f64>) -> Vec<f64> {
        sizes
    }
}

/// The run is searched for the end that a formula gives in so many stages, each twice as long as all before it: what
/// comes after that end need not exist.
const STAGES: i32 = 6;

impl<S: Arithmetic> Studied<S> for Geometry<S> {
    fn solve(setup: &Setup<S, Self>) -> Result<WorldLine<S, Self>, NoSolution> {
        solve(setup)
    }

    fn reference(
        place: &Place<S, Self>,
        length: S,
        digits: u32,
    ) -> Result<ReferenceTrajectory<S, Self>, ReferenceEnds> {
        ReferenceTrajectory::new(&*place.geometry, &place.start, length, digits)
    }

    fn at(reference: &ReferenceTrajectory<S, Self>, gamma: S) -> ScenePoint<S> {
        reference.at(gamma)
    }

    fn coordinate(point: &ScenePoint<S>, a: usize) -> S {
        point.q[a]
    }

    fn length_of(setup: &Setup<S, Self>) -> Result<S, ReferenceEnds> {
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
            let reference = Self::reference(&setup.place, length, digits)?;
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

    fn start(place: &Place<S, Self>) -> Start<S> {
        (*place.start).clone()
    }

    fn deviations(line: &WorldLine<S, Self>, is_lifted: bool) -> Deviations {
        let Diagnostics { charges, norm, measures, .. } = Diagnostics::of_scene(line, &[], &mut [], is_lifted);
        let energy_max = measures.delta_energy.map(|delta| {
            let inside = line.grids().map(|grid| max_abs(&delta[grid.exact()]).to_f64()).fold(0.0, larger);
            measures.energy.map_or(inside, |energy| larger(inside, energy.max_ends.to_f64()))
        });
        Deviations {
            charges: charges.iter().map(|charge| charge.max_interior.to_f64()).collect(),
            charges_last: charges.iter().map(|charge| charge.max_last.to_f64()).collect(),
            last_node: charges.iter().map(|charge| [last(&charge.delta), last(&charge.corrected)]).collect(),
            delta_k: in_f64(&norm.delta),
            delta_k_ends: in_f64(&norm.ends),
            delta_k_max: norm.max_interior.to_f64(),
            energy_max,
        }
    }

    fn rows(line: &WorldLine<S, Self>) -> Vec<Vec<S>> {
        (0..line.geometry().dimension()).map(|a| line.q(a).collect()).collect()
    }

    fn shared_sizes(place: &Place<S, Self>, sizes: Vec<f64>) -> Vec<f64> {
        place.geometry.shared(&place.start.q, &sizes)
    }
}
