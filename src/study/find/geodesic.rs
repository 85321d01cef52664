//! A geodesic from one place to another: its length, and the points on it that are conjugate to its start.
//!
//! Neighbouring geodesics from the same place are ∂q/∂q̇_0, one for each direction. Where a linear combination of them
//! vanishes, so that their determinant does, they meet again: up to the first such point a geodesic between two
//! places is shorter than its neighbours, or in a space-time longer, and behind it no more. The columns are central
//! differences of runs; a determinant that touches 0 without a change of its sign is not seen.

use std::sync::Arc;

use nalgebra::DMatrix;

use crate::case::Case;
use crate::engine::Handed;
use crate::geometry::Start;
use crate::solve::{Place, Setup, WorldLine, solve};
use crate::study::run::Run;
use crate::trajectory::Sampler;

/// The determinant is looked at on so many places of a window.
const PLACES: usize = 8;
/// A place is found by so many halvings.
const HALVINGS: usize = 40;

/// A geodesic that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Geodesic {
    /// √|K| (γ_f − γ_i).
    pub length: f64,
    /// γ of the conjugate points before its end, if neighbouring runs have solutions.
    pub conjugate: Option<Vec<f64>>,
}

impl Geodesic {
    /// The length and the conjugate points of a run. `None` if the motion is no geodesic of the metric of its case, as
    /// where a force, a potential, a one-form or an event acts.
    pub(super) fn new(case: &Case, run: &Run) -> Option<Self> {
        let scene = &case.geometry_text;
        let is_geodesic = scene.potential.is_none() && scene.one_form.is_empty() && scene.force.is_empty();
        let line = &run.line;
        if !is_geodesic || case.has_acting_events() || !run.before.is_empty() || line.is_backward {
            return None;
        }
        let norm = line.geometry().norm(&line.place.start.q, &line.place.start.q_dot);
        let length = norm.abs().sqrt() * (line.gamma_f() - line.gamma_i);
        Some(Self { length, conjugate: Field::new(case, line).map(|mut field| field.conjugate(line)) })
    }
}

/// The neighbours of a run, two for each direction, with the change of velocity between them.
struct Field {
    lines: Vec<[WorldLine; 2]>,
    changes: Vec<f64>,
}

impl Field {
    fn new(case: &Case, line: &WorldLine) -> Option<Self> {
        let mut setup: Setup = case.setup();
        // What the start of the case has beyond its doubles is not that of others.
        (setup.until, setup.settings.sensitivity, setup.dropped) = (Vec::new(), false, Handed::default());
        let Place { geometry, start } = setup.place.clone();
        let size = start.q_dot.iter().fold(0.0, |size: f64, q_dot| size.max(q_dot.abs()));
        let step = line.error_estimate.unwrap_or(f64::EPSILON).max(f64::EPSILON).cbrt() * size;
        let beside = |b: usize, change: f64| {
            let Start { q, mut q_dot, .. } = (*start).clone();
            q_dot[b] += change;
            let p = geometry.momenta(&q, &q_dot);
            let place = Place { start: Arc::new(Start { q, q_dot, p }), geometry: geometry.clone() };
            solve(Setup { rough: place.clone(), place, ..setup.clone() }).ok()
        };
        let pair = |b: usize| Some([beside(b, step)?, beside(b, -step)?]);
        let lines = (0..start.q.len()).map(pair).collect::<Option<Vec<_>>>()?;
        Some(Self { changes: vec![2.0 * step; lines.len()], lines })
    }

    /// The determinant of ∂q/∂q̇_0 over γ − γ_i, which is 1 at the start. `None` behind the end of a neighbour.
    fn determinants(&self, line: &WorldLine, places: &[f64]) -> Option<Vec<f64>> {
        let n = self.lines.len();
        let mut columns: Vec<Vec<Vec<f64>>> = Vec::with_capacity(n);
        for (pair, change) in self.lines.iter().zip(&self.changes) {
            let [mut one, mut other] = [&pair[0], &pair[1]].map(Sampler::new);
            let column = |&gamma: &f64| {
                let (one, other) = (one.at_gamma(gamma).ok()?.q, other.at_gamma(gamma).ok()?.q);
                let way = (gamma - line.gamma_i) * change;
                Some(one.iter().zip(&other).map(|(one, other)| (one - other) / way).collect::<Vec<f64>>())
            };
            columns.push(places.iter().map(column).collect::<Option<_>>()?);
        }
        let at = |k: usize| DMatrix::from_fn(n, n, |a, b| columns[b][k][a]).determinant();
        Some((0..places.len()).map(at).collect())
    }

    /// γ of its changes of sign before the end.
    fn conjugate(&mut self, line: &WorldLine) -> Vec<f64> {
        let ends: Vec<f64> = line.windows.iter().map(|window| line.gamma_i + window.gamma[1]).collect();
        let mut places = Vec::new();
        let mut before = line.gamma_i;
        for end in ends {
            let part = |k: usize| before + (end - before) * (k as f64 / PLACES as f64);
            places.extend((1..=PLACES).map(part));
            before = end;
        }
        // The end itself is none of them.
        places.pop();
        let Some(values) = self.determinants(line, &places) else { return Vec::new() };
        let mut found = Vec::new();
        let mut last = (line.gamma_i, 1.0_f64);
        for (place, value) in places.into_iter().zip(values) {
            if value * last.1 < 0.0 {
                let (mut low, mut high) = (last.0, place);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (low + high);
                    let here = self.determinants(line, &[middle]).map_or(f64::NAN, |values| values[0]);
                    if here * last.1 > 0.0 { low = middle } else { high = middle }
                }
                found.push(0.5 * (low + high));
            }
            last = (place, value);
        }
        found
    }
}
