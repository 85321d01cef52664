//! The look between the nodes of a run on a given grid.
//!
//! A *gap* is a pair of neighbouring nodes. The formulas are enclosed on the way from one node to the other. Where a
//! function or a quotient changes by more on it than nodes can follow, what hides there is bounded: a change of the
//! force for as long as the gap is, at most. Gaps are *explained*, from the least bound on, as long as all of them
//! together move no coordinate by more than a tenth of the error of the run.

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};

use super::origin;
use super::verdict::Reason;
use crate::engine::enclosure::{Enclosure, HIDDEN_SHARE, Path, tolerated_rates};
use crate::geometry::Geometry;
use crate::number::Real;
use crate::solve::{WindowNodes, WorldLine};

/// What hides is compared with the error of a run, but with no error outside of these: less than the first is near
/// rounding, and a run with an error above the second is not one that explains anything.
const ERRORS: [f64; 2] = [1e-12, 1e-3];

/// What hides in gaps that do less than this share together is not looked at more closely.
const SMALL: f64 = 0.01;

/// The error that is assumed for a run where it is not known.
const UNKNOWN: f64 = 1e-6;

/// The gaps of a run. Its keys in `summary.json` are `gaps`, `gaps_unproved`, `gaps_accuracy`, `gap_unproved`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gaps {
    /// The number of gaps.
    #[serde(rename = "gaps")]
    pub count: usize,
    /// The number of those that are not explained.
    #[serde(rename = "gaps_unproved")]
    pub unresolved: usize,
    /// All the others together move no coordinate by more than a tenth of this, relative to its size.
    #[serde(rename = "gaps_accuracy")]
    pub accuracy: f64,
    /// The first that is not explained.
    #[serde(rename = "gap_unproved", skip_serializing_if = "Option::is_none")]
    pub first: Option<Gap>,
}

/// A pair of neighbouring nodes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gap {
    /// γ at both nodes of the pair.
    pub gamma: [f64; 2],
    /// Every coordinate at both nodes, by its name.
    #[serde(flatten, serialize_with = "by_name")]
    pub coordinates: Vec<(String, [f64; 2])>,
}

/// Writes coordinates in the order of their names, as all objects of a summary are.
fn by_name<S: Serializer>(coordinates: &[(String, [f64; 2])], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(coordinates.iter().map(|(name, ends)| (name, ends)).collect::<BTreeMap<_, _>>())
}

impl Gap {
    fn new<S: Real>(line: &WorldLine<S>, hidden: &Hidden) -> Self {
        let (view, nodes) = (line.view(hidden.window), [hidden.node, hidden.node + 1]);
        let names = line.geometry().names().iter().cloned().enumerate();
        let ends = |a: usize| {
            let mut values = view.absolute(a, &line.q[a]).skip(hidden.node).map(S::to_f64);
            nodes.map(|_| values.next().expect("a gap has a node at both ends"))
        };
        Self {
            gamma: nodes.map(|k| line.gamma_at(view.window.gamma_at(k)).to_f64()),
            coordinates: names.map(|(a, name)| (name, ends(a))).collect(),
        }
    }
}

/// A gap in which something may hide: the window and its first node there, and by how much it moves the end, as a share
/// of what all gaps may do together.
struct Hidden {
    window: usize,
    node: usize,
    share: f64,
}

impl Gaps {
    /// Looks at the gaps of `line`, whose space-time is `rough` in `f64`. `error` is its estimated error relative to
    /// the sizes of its coordinates, as in [`Verdict`](crate::diagnostics::verdict::Verdict), if it is known.
    pub fn new<S: Real>(line: &WorldLine<S>, rough: &Geometry, error: Option<f64>) -> Self {
        let [least, most] = ERRORS;
        // NaN is no error that is known.
        let accuracy = error.filter(|error| !error.is_nan()).unwrap_or(UNKNOWN).clamp(least, most);
        let (count, length) = (line.nodes() - line.windows.len(), line.length.to_f64());
        let mut hidden = Vec::new();
        let momenta: Vec<f64> = line.place.start.p.iter().map(|p| p.to_f64()).collect();
        if let Some(mut enclosure) = Enclosure::of_geometry(rough, &momenta) {
            let weights = weights(line, rough);
            // A push at the start moves the end by twice what the same force does that grows with the way.
            let share = |change: f64, distance: f64| 2.0 * change * distance / length;
            for (window, view) in line.views().enumerate() {
                let (states, sbp) = (states(line, &view), view.window.sbp());
                let nodes: Vec<f64> = (0..sbp.points()).map(|k| sbp.node(k).to_f64()).collect();
                let distances: Vec<f64> = nodes.windows(2).map(|pair| pair[1] - pair[0]).collect();
                describe(&states, rough, &nodes, &mut enclosure.path);
                let tolerances = || {
                    let states = states.iter().map(Vec::as_slice);
                    tolerated_rates(rough, &weights, states, length, HIDDEN_SHARE * accuracy)
                };
                let longest = distances.iter().copied().fold(0.0, f64::max);
                let found = enclosure.hidden(tolerances, SMALL / (share(1.0, longest) * count as f64)).into_iter();
                hidden.extend(found.map(|found| Hidden {
                    window,
                    node: found.pair,
                    share: share(found.change, distances[found.pair]),
                }));
            }
        }
        hidden.sort_by(|one, other| one.share.total_cmp(&other.share));
        let mut sum = 0.0;
        let explained = hidden.iter().take_while(|hidden| {
            sum += hidden.share;
            sum <= 1.0
        });
        let unexplained = &hidden[explained.count()..];
        let first = unexplained.iter().min_by_key(|hidden| (hidden.window, hidden.node));
        Self { count, unresolved: unexplained.len(), accuracy, first: first.map(|first| Gap::new(line, first)) }
    }

    /// The reason to doubt a run with gaps that are not explained.
    pub fn reason(&self) -> Option<Reason> {
        let Gap { gamma: [from, to], coordinates } = self.first.as_ref()?;
        let places = coordinates.iter().map(|(name, [from, to])| format!("{name} from {from:.6} to {to:.6}"));
        let finding = format!(
            "in {} of {} gaps between nodes the formulas may do what the nodes do not see, first from gamma = \
             {from:.6} to {to:.6}, with {}",
            self.unresolved,
            self.count,
            places.collect::<Vec<_>>().join(", ")
        );
        Some(Reason::new(finding, "take more nodes (grid.n_gamma) or solver.accuracy"))
    }
}

/// One over the size of every coordinate, or over that of its kind where it rests: by how much an error of it counts.
/// It is 0 where nothing moves and nothing is known of a size.
fn weights<S: Real>(line: &WorldLine<S>, rough: &Geometry) -> Vec<f64> {
    let size = |a: usize| {
        let origin = origin(&line.place, a);
        line.q(a).fold(0.0, |most: f64, q| most.max((q - origin).to_f64().abs()))
    };
    let sizes: Vec<f64> = (0..rough.dimension()).map(size).collect();
    let shared = line.geometry().shared(&line.place.start.q, &sizes);
    let known = sizes.iter().zip(&shared).map(|(&size, &shared)| if size > 0.0 { size } else { shared });
    known.map(|size| if size > 0.0 { 1.0 / size } else { 0.0 }).collect()
}

/// q^a and then p_a of all coordinates at the nodes of a window in `f64`, node by node.
fn states<S: Real>(line: &WorldLine<S>, view: &WindowNodes<'_, S>) -> Vec<Vec<f64>> {
    let (geometry, n, increments) = (line.geometry(), line.geometry().dimension(), view.increments());
    let state = |k: usize| {
        let mut state: Vec<S> = view.start.q.iter().chain(view.start.p).copied().collect();
        let places = (0..n).chain(geometry.active().iter().map(|a| n + a));
        places.zip(&increments).for_each(|(place, row)| state[place] += row[k]);
        state.into_iter().map(S::to_f64).collect()
    };
    (0..view.window.points()).map(state).collect()
}

/// Describes the positions and momenta of active coordinates at these nodes as a path. They bend as their rates at the
/// nodes say. Positions are the variables 0 … n − 1 of the programs of rates, and momenta 2n … 3n − 1.
fn describe(states: &[Vec<f64>], geometry: &Geometry, nodes: &[f64], path: &mut Path) {
    let (n, mut point) = (geometry.dimension(), geometry.point());
    // Nothing is known of a path that leaves the domain.
    let mut rates = |state: &Vec<f64>| {
        let mut rates = vec![0.0; 2 * n];
        let inside = point.slopes(state, &mut rates);
        inside.map_or_else(|_| vec![f64::NAN; 2 * n], |()| rates)
    };
    let rates: Vec<Vec<f64>> = states.iter().map(&mut rates).collect();
    path.begin(nodes);
    for place in geometry.active().iter().flat_map(|&a| [a, n + a]) {
        let values: Vec<f64> = states.iter().map(|state| state[place]).collect();
        let variable = if place < n { place } else { place + n };
        path.push(variable, &values, |k| {
            let bend = (nodes[k + 1] - nodes[k]) * (rates[k + 1][place] - rates[k][place]);
            if bend.is_nan() { f64::INFINITY } else { bend }
        });
    }
}
