//! Whether something steep may hide between the nodes of a window of a scene.

use super::judge::Judge;
use super::window::FlowWindow;
use crate::engine::enclosure::{Enclosure, Found, UNSEEN, Weights, negligible_rates};
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
        enclosure.path.begin(window.points());
        for (row, values) in window.fields.iter().enumerate() {
            let variable = geometry.active()[row % m] + if row < m { 0 } else { 2 * n };
            enclosure.path.push(variable, &values.0, |k| bend(window, row, k));
        }
        let is_hidden = enclosure.look(|| negligible(geometry, judge, scales)) == Found::Hidden;
        [is_hidden, window.length <= LEAST * scales.first]
    }
}

/// The second derivative of a field of the solved window from node `k` to the next, times the square of their distance.
fn bend<const P: usize>(window: &FlowWindow<'_, P>, row: usize, k: usize) -> f64 {
    let [here, next] = [k, k + 1].map(|k| window.rule.rule.nodes()[k].hi);
    let rate = &window.unknowns.rates()[row].0;
    let (distance, is_acceleration) = (next - here, row < window.m && window.geometry.is_separable());
    match is_acceleration {
        true => 0.5 * distance * distance * (rate[k] + rate[k + 1]),
        false => distance * (rate[k + 1] - rate[k]),
    }
}

/// By how much rates may change on all of the way without an effect.
fn negligible(geometry: &Geometry, judge: &Judge<'_>, scales: Scales) -> Vec<f64> {
    let Scales { accuracy, length, gamma, first, time } = scales;
    let whole = if length.is_finite() { length } else { gamma.max(LONG * first) };
    let p: Vec<f64> = judge.weights.p.iter().map(|weight| weight / time).collect();
    negligible_rates(geometry, &Weights { q: &judge.weights.q, p: &p }, whole, UNSEEN * accuracy)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{geometries, geometry, solved, start};
    use super::super::transport::Transport;
    use super::{Judge, LONG, Look, Scales, bend, negligible};

    /// From the tangent at a node the next one is away by half the bend.
    #[test]
    fn bends_lead_from_node_to_node() {
        for geometry in geometries() {
            let (start, h) = (start(&geometry), 0.3);
            let (state, window) = solved(&geometry, &start, h);
            let [mut q, mut q_dot, mut p] = [start.q.clone(), vec![0.0; 3], start.p.clone()];
            let mut point = geometry.point();
            for k in 0..window.points() - 1 {
                window.node(&state, h, k, [&mut q, &mut q_dot, &mut p]);
                point.evaluate(&q, &p).unwrap();
                let nodes = window.rule.rule.nodes();
                let step = h * (nodes[k + 1].hi - nodes[k].hi);
                for row in 0..2 * window.m {
                    let place = row % window.m;
                    let slope = if row < window.m { q_dot[geometry.active()[place]] } else { point.p_dot(place) };
                    let values = &window.fields[row].0;
                    let away = 2.0 * (values[k + 1] - values[k] - step * slope);
                    let bend = bend(&window, row, k);
                    // To the next order in a step, the shortest of which are a few thousandths.
                    assert!((bend - away).abs() < 10.0 * step.powi(3), "{row} {k}: {bend:e}, {away:e}");
                    assert!(away.abs() > 0.01 * step * step, "{row} {k}: {away:e} says something");
                }
            }
        }
    }

    #[test]
    fn a_window_is_short_beside_the_first() {
        let geometry = geometry(&[([1, 1], "-exp(x)"), ([2, 2], "-1")], &[]);
        let (start, h) = (start(&geometry), 1e-3);
        let (state, window) = solved(&geometry, &start, h);
        let judge = Judge::new(&geometry, &state, &start.p, None);
        let mut look = Look::new(&geometry);
        look.begin(&start.p);
        for (first, is_short) in [(1e5, false), (1e7, true)] {
            let scales = Scales { accuracy: 1e-6, length: 1.0, gamma: 0.0, first, time: 1.0 };
            assert_eq!(look.at(&window, &judge, scales), [false, is_short]);
        }
    }

    /// What is negligible is a matter of the length of the run, and not of the time scale of a window.
    #[test]
    fn what_is_negligible_is_so_on_all_of_the_way() {
        for geometry in geometries() {
            let start = start(&geometry);
            let (state, _) = solved(&geometry, &start, 0.3);
            let rates = |length: f64, gamma: f64, time: f64| {
                let mut judge = Judge::new(&geometry, &state, &start.p, None);
                let mut transport = Transport::new(&geometry);
                transport.begin(&start.p, &state);
                judge.look_at(&transport);
                judge.set_scale(time);
                negligible(&geometry, &judge, Scales { accuracy: 1e-6, length, gamma, first: 2.0, time })
            };
            assert!(rates(4.0, 0.0, 1.0).iter().all(|rate| *rate > 0.0 && *rate < 1e-3));
            assert_eq!(rates(4.0, 0.0, 1.0), rates(4.0, 0.0, 8.0));
            // A run without an end is taken for a thousand first windows, and for as long as it is already.
            assert_eq!(rates(f64::INFINITY, 0.0, 1.0), rates(2.0 * LONG, 0.0, 1.0));
            assert_eq!(rates(f64::INFINITY, 1e6, 1.0), rates(1e6, 0.0, 1.0));
        }
    }
}
