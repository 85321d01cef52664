//! A run between its nodes.

use super::bend;
use crate::engine::enclosure::{Enclosure, Path, Weights, negligible_rates};
use crate::geometry::Geometry;
use crate::number::Real;
use crate::solve::{WindowNodes, WorldLine};

/// This looks at a run between its nodes.
#[derive(Debug)]
pub(super) struct BetweenNodes<'r, S> {
    line: &'r WorldLine<S>,
    geometry: &'r Geometry,
    weights: Vec<f64>,
    /// The window that was described last.
    nodes: Nodes,
}

impl<'r, S: Real> BetweenNodes<'r, S> {
    /// This looks between the nodes of `line`, in a space-time that is `geometry` in `f64`.
    pub(super) fn new(line: &'r WorldLine<S>, geometry: &'r Geometry) -> Self {
        let start = &line.place.start.q;
        let sizes: Vec<f64> = (0..geometry.dimension()).map(|a| size(geometry, a, start[a], line.q(a))).collect();
        let shared = line.geometry().shared(start, &sizes);
        let weight = |(&size, &shared): (&f64, &f64)| weight(if size > 0.0 { size } else { shared });
        let weights = sizes.iter().zip(&shared).map(weight).collect();
        Self { line, geometry, weights, nodes: Nodes { states: Vec::new() } }
    }

    /// This encloses the formulas, if any of them can hide something.
    pub(super) fn enclosure(&self) -> Option<Enclosure> {
        let mut enclosure = Enclosure::of_geometry(self.geometry)?;
        let momenta: Vec<f64> = self.line.place.start.p.iter().map(|p| p.to_f64()).collect();
        enclosure.fix_momenta(&momenta);
        Some(enclosure)
    }

    /// Describes a window as a path. `distances` are the lengths of its gaps.
    pub(super) fn describe(&mut self, view: &WindowNodes<'_, S>, distances: &[f64], path: &mut Path) {
        self.nodes = Nodes::new(self.line, view);
        self.nodes.describe(self.geometry, distances, path);
    }

    /// By how much each formula may change in the window that was described last without being seen, where the
    /// coordinates may be off by `error`, relative to their sizes.
    pub(super) fn tolerances(&self, error: f64) -> Vec<f64> {
        let weights = Weights { q: &self.weights, p: &self.nodes.couplings(self.geometry, &self.weights) };
        negligible_rates(self.geometry, &weights, self.line.length.to_f64(), error)
    }
}

/// The size of a coordinate with the values `q` at the nodes: the largest |q^a| or, if it is ignorable, |q^a − q_i^a|.
fn size<S: Real>(geometry: &Geometry, a: usize, start: S, q: impl Iterator<Item = S>) -> f64 {
    let origin = if geometry.active().contains(&a) { S::ZERO } else { start };
    q.fold(0.0, |most: f64, q| most.max((q - origin).to_f64().abs()))
}

/// One over the size; 0 where nothing moves, so that nothing is passed.
fn weight(size: f64) -> f64 {
    if size > 0.0 { 1.0 / size } else { 0.0 }
}

/// A window in `f64`.
#[derive(Debug)]
struct Nodes {
    /// q^a and then p_a of all coordinates, node by node.
    states: Vec<Vec<f64>>,
}

impl Nodes {
    fn new<S: Real>(line: &WorldLine<S>, view: &WindowNodes<'_, S>) -> Self {
        let (geometry, grid, n) = (line.geometry(), view.grid, line.geometry().dimension());
        let increments = line.increments(view);
        let state = |k: usize| {
            let mut state: Vec<S> = view.start.q.iter().chain(view.start.p).copied().collect();
            let places = (0..n).chain(geometry.active().iter().map(|a| n + a));
            places.zip(&increments).for_each(|(place, row)| state[place] += row[k]);
            state.into_iter().map(S::to_f64).collect()
        };
        Self { states: (0..grid.points()).map(state).collect() }
    }

    /// Describes the positions and momenta of active coordinates as a path. They bend as their rates at the nodes say.
    fn describe(&self, geometry: &Geometry, distances: &[f64], path: &mut Path) {
        let (n, mut point) = (geometry.dimension(), geometry.point());
        let mut rates = |state: &Vec<f64>| {
            let mut rates = vec![0.0; 2 * n];
            // Nothing is known of a path that leaves the domain.
            let inside = point.slopes(state, &mut rates);
            inside.map_or_else(|_| vec![f64::NAN; 2 * n], |()| rates)
        };
        let rates: Vec<Vec<f64>> = self.states.iter().map(&mut rates).collect();
        path.begin(self.states.len());
        for place in geometry.active().iter().flat_map(|&a| [a, n + a]) {
            let values: Vec<f64> = self.states.iter().map(|state| state[place]).collect();
            let variable = if place < n { place } else { place + n };
            path.push(variable, &values, |k| bend(distances[k] * (rates[k + 1][place] - rates[k][place])));
        }
    }

    /// By how much the momentum of each active coordinate changes velocities, times the `weights` of these: the most on
    /// the nodes.
    fn couplings(&self, geometry: &Geometry, weights: &[f64]) -> Vec<f64> {
        let (n, active) = (geometry.dimension(), geometry.active());
        let m = active.len();
        let (mut point, mut couplings) = (geometry.point(), vec![0.0; m]);
        for state in &self.states {
            point.jacobian(&state[..n], &state[n..], |row, column, value| {
                if row < m && column >= m {
                    let coupling: &mut f64 = &mut couplings[column - m];
                    *coupling = coupling.max(value.abs() * weights[active[row]]);
                }
            });
        }
        couplings
    }
}

#[cfg(test)]
mod tests {
    use super::{Nodes, Path, size, weight};
    use crate::geometry::{Geometry, GeometryText, MetricText};

    /// A metric of the coordinates `names` with these components.
    fn geometry(names: &[&str], components: &[([usize; 2], &str)]) -> Geometry {
        let text = MetricText {
            coordinates: names.iter().map(|&name| name.to_owned()).collect(),
            components: components.iter().map(|&(pair, text)| (pair, text.to_owned())).collect(),
            ..MetricText::default()
        };
        let inside = vec![0.5; names.len()];
        Geometry::new(&GeometryText::Metric(text)).unwrap().around(&inside).unwrap()
    }

    /// Two oscillators that are coupled.
    fn oscillators() -> Geometry {
        let g00 = "9 + x^2 + 2*y^2 + x*y";
        geometry(&["t", "x", "y"], &[([0, 0], g00), ([1, 1], "-1"), ([2, 2], "-2")])
    }

    #[test]
    fn weights_are_of_sizes_from_the_start_where_a_coordinate_is_ignorable() {
        let rows = [[1000.0, 1004.0, 1003.0], [4.0, -5.0, 3.0], [0.25, 0.125, -0.5], [0.0; 3]];
        let of = |a: usize| size(&oscillators(), a.min(2), rows[a][0], rows[a].into_iter());
        assert_eq!([0, 1, 2, 3].map(|a| weight(of(a))), [1.0 / 4.0, 1.0 / 5.0, 2.0, 0.0]);
    }

    /// Positions are the variables 0 … n − 1 of the programs of rates, and momenta 2n … 3n − 1.
    #[test]
    fn a_path_has_the_positions_and_momenta_of_active_coordinates() {
        let first = geometry(&["x", "t"], &[([0, 0], "-1"), ([1, 1], "9 + x^2")]);
        for (geometry, variables, places) in
            [(oscillators(), vec![1, 7, 2, 8], vec![1, 4, 2, 5]), (first, vec![0, 4], vec![0, 2])]
        {
            let m = 2 * geometry.dimension();
            let states: Vec<Vec<f64>> = (0..3).map(|k| (0..m).map(|i| 0.1 * (m * k + i) as f64).collect()).collect();
            let nodes = Nodes { states };
            let mut path = Path::default();
            nodes.describe(&geometry, &[0.5; 2], &mut path);
            assert_eq!(path.variables, variables);
            for (row, place) in places.into_iter().enumerate() {
                let values = &path.values[row * nodes.states.len()..][..nodes.states.len()];
                assert!(values.iter().zip(&nodes.states).all(|(value, state)| *value == state[place]));
            }
        }
    }
}
