//! Whether something steep may hide between the nodes of a window of a scene.

use super::judge::Judge;
use super::window::FlowWindow;
use crate::enclosure::{Enclosure, Found, UNSEEN, Weights, negligible_rates};
use crate::geometry::Geometry;

/// Windows shorter than this part of the first are not cut any more.
const LEAST: f64 = 1e-9;

/// The length of a run to a value of a coordinate, in first windows.
const LONG: f64 = 1e3;

/// What looks between nodes, where something could hide there.
pub(super) struct Look {
    enclosure: Option<Enclosure>,
}

/// What is asked for, and the time scales of a window.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scales {
    pub(super) accuracy: f64,
    /// The length of the run, which may be infinite, and how far it has come.
    pub(super) length: f64,
    pub(super) gamma: f64,
    /// The first window.
    pub(super) first: f64,
    /// What the weights of momenta are made with.
    pub(super) time: f64,
}

impl Look {
    pub(super) fn new(geometry: &Geometry) -> Self {
        Self { enclosure: Enclosure::of_geometry(geometry) }
    }

    /// A march begins, with these momenta of ignorable coordinates.
    pub(super) fn begin(&mut self, momenta: &[f64]) {
        self.enclosure.iter_mut().for_each(|enclosure| enclosure.fix_momenta(momenta));
    }

    /// Whether something may hide between the nodes of the solved window, and whether it is too short to be cut.
    pub(super) fn at<const P: usize>(
        &mut self,
        window: &FlowWindow<'_, P>,
        judge: &Judge<'_>,
        scales: Scales,
    ) -> [bool; 2] {
        let Some(enclosure) = &mut self.enclosure else { return [false; 2] };
        let (geometry, m, n) = (window.geometry, window.m, window.geometry.dimension());
        let nodes = window.rule.rule.nodes();
        enclosure.path.begin(window.points());
        let rows = window.fields.iter().zip(window.unknowns.rates());
        for (row, (values, rate)) in rows.enumerate() {
            let (values, rate) = (&values.0, &rate.0);
            let variable = geometry.active()[row % m] + if row < m { 0 } else { 2 * n };
            let is_acceleration = row < m && geometry.is_separable();
            enclosure.path.push(variable, values, |k| {
                let distance = nodes[k + 1].hi - nodes[k].hi;
                match is_acceleration {
                    true => 0.5 * distance * distance * (rate[k] + rate[k + 1]),
                    false => distance * (rate[k + 1] - rate[k]),
                }
            });
        }
        let is_hidden = enclosure.look(|| negligible(geometry, judge, scales)) == Found::Hidden;
        [is_hidden, window.length <= LEAST * scales.first]
    }
}

/// By how much rates may change on all of the way without an effect.
fn negligible(geometry: &Geometry, judge: &Judge<'_>, scales: Scales) -> Vec<f64> {
    let Scales { accuracy, length, gamma, first, time } = scales;
    let whole = if length.is_finite() { length } else { gamma.max(LONG * first) };
    let p: Vec<f64> = judge.weights.p.iter().map(|weight| weight / time).collect();
    negligible_rates(geometry, &Weights { q: &judge.weights.q, p: &p }, whole, UNSEEN * accuracy)
}
