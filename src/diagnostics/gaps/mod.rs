//! The look between the nodes of a run on a given grid.
//!
//! A *gap* is a pair of neighbouring nodes. The formulas are enclosed on the way from one node to the other. Where a
//! function or a quotient changes by more on it than nodes can follow, what hides there is bounded: a change of the
//! force for as long as the gap is, at most. Gaps are *explained*, from the least bound on, as long as all of them
//! together move no coordinate by more than a tenth of the error of the run.
//!
//! ```
//! use geodesic_ivp::diagnostics::gaps::Gaps;
//! use geodesic_ivp::{Case, Solution, solve};
//!
//! let text = r#"
//!     potential.formula.expression = "5*exp(-((x - 2)/0.01)^2)"
//!     particle.c = 3.0
//!     initial = { t = 0.0, x = -0.6, t_dot = 1.0, x_dot = 0.6 }
//!     grid = { gamma_f = 64.0, n_gamma = 65 }
//!     scheme.sbp = "SBP42"
//! "#;
//! let case = Case::parse("barrier", text, &[])?;
//! let solution: Solution = solve(&case)?;
//! assert!(solution.end_state().x > 30.0, "it steps over the barrier, which reflects");
//! let gaps = Gaps::new(&solution, &case.geometry(), None);
//! assert_eq!((gaps.count, gaps.unproved), (64, 1));
//! let (name, [from, to]) = &gaps.first.unwrap().coordinates[1];
//! assert!(name == "x" && *from < 2.0 && *to > 2.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod between;

use std::collections::BTreeMap;

use serde::ser::{Serialize, SerializeMap, Serializer};

use self::between::BetweenNodes;
use super::verdict::Reason;
use crate::engine::enclosure::{Enclosure, UNSEEN};
use crate::geometry::Geometry;
use crate::number::Real;
use crate::solve::WorldLine;

/// What hides is compared with the error of a run, but with no error outside of these: less than the first is near
/// rounding, and a run with an error above the second is not one that explains anything.
const ERRORS: [f64; 2] = [1e-12, 1e-3];

/// What hides in gaps that do less than this share together is not looked at more closely.
const SMALL: f64 = 0.01;

/// The error that is assumed for a run where it is not known.
const UNKNOWN: f64 = 1e-6;

/// The gaps of a run. Its keys in `summary.json` are `gaps`, `gaps_unproved`, `gaps_accuracy`, `gap_unproved`.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Gaps {
    /// The number of gaps.
    #[serde(rename = "gaps")]
    pub count: usize,
    /// The number of those that are not explained.
    #[serde(rename = "gaps_unproved")]
    pub unproved: usize,
    /// All the others together move no coordinate by more than a tenth of this, relative to its size.
    #[serde(rename = "gaps_accuracy")]
    pub accuracy: f64,
    /// The first that is not explained.
    #[serde(rename = "gap_unproved", skip_serializing_if = "Option::is_none")]
    pub first: Option<Gap>,
}

/// A pair of neighbouring nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    /// γ at both.
    pub gamma: [f64; 2],
    /// Every coordinate at both.
    pub coordinates: Vec<(String, [f64; 2])>,
}

impl Gap {
    fn new<S: Real>(line: &WorldLine<S>, hidden: &Hidden) -> Self {
        let (view, nodes) = (line.view(hidden.window), [hidden.node, hidden.node + 1]);
        let names = line.geometry().names().iter().cloned().enumerate();
        let ends = |a: usize| {
            let mut values = line.absolute_in(view, a, &line.q[a]).skip(hidden.node).map(S::to_f64);
            nodes.map(|_| values.next().expect("a gap has a node at both ends"))
        };
        Self {
            gamma: nodes.map(|k| line.gamma_at(view.grid.gamma_at(k)).to_f64()),
            coordinates: names.map(|(a, name)| (name, ends(a))).collect(),
        }
    }
}

/// Number of pairs of neighbouring nodes.
fn count<S: Real>(line: &WorldLine<S>) -> usize {
    line.nodes() - line.windows.len()
}

impl Serialize for Gap {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(1 + self.coordinates.len()))?;
        map.serialize_entry("gamma", &self.gamma)?;
        // In the order of names, as all objects of a summary.
        let coordinates: BTreeMap<_, _> = self.coordinates.iter().map(|(name, ends)| (name, ends)).collect();
        coordinates.into_iter().try_for_each(|(name, ends)| map.serialize_entry(name, ends))?;
        map.end()
    }
}

/// A gap in which something may hide: the window and its first node there, and by how much it moves the end, as a share
/// of what all gaps may do together.
struct Hidden {
    window: usize,
    node: usize,
    share: f64,
}

/// The accuracy with which gaps of a run are explained, from its error relative to the sizes of its coordinates.
fn accuracy(error: Option<f64>) -> f64 {
    let [least, most] = ERRORS;
    // NaN is no error that is known.
    error.filter(|error| !error.is_nan()).unwrap_or(UNKNOWN).clamp(least, most)
}

/// A bend of the path; nothing is known of a path that leaves the domain.
fn bend(bend: f64) -> f64 {
    if bend.is_nan() { f64::INFINITY } else { bend }
}

/// Looks at the gaps of the window with this number, of `count` gaps of a run of this `length`. `distances` are the
/// lengths of the gaps.
fn look(
    enclosure: &mut Enclosure,
    window: usize,
    distances: &[f64],
    (length, count): (f64, usize),
    tolerances: impl FnOnce() -> Vec<f64>,
) -> impl Iterator<Item = Hidden> {
    let longest = distances.iter().fold(0.0_f64, |most, &distance| most.max(distance));
    // A push at the start moves the end by twice what the same force does that grows with the way.
    let share = move |change: f64, distance: f64| 2.0 * change * distance / length;
    let least = SMALL / (share(1.0, longest) * count as f64);
    let hidden = enclosure.hidden(tolerances, least).into_iter();
    hidden.map(move |(node, change)| Hidden { window, node, share: share(change, distances[node]) })
}

impl Gaps {
    /// Looks at the gaps of `line`, whose space-time is `rough` in `f64`. `error` is its estimated error relative to
    /// the sizes of its coordinates, as in [`Verdict`](crate::diagnostics::verdict::Verdict), if it is known.
    pub fn new<S: Real>(line: &WorldLine<S>, rough: &Geometry, error: Option<f64>) -> Self {
        let (accuracy, length) = (accuracy(error), line.length.to_f64());
        let mut between = BetweenNodes::new(line, rough);
        let mut hidden = Vec::new();
        if let Some(mut enclosure) = between.enclosure() {
            for (window, view) in line.views().enumerate() {
                let distances = view.grid.distances();
                between.describe(&view, &distances, &mut enclosure.path);
                let tolerances = || between.tolerances(UNSEEN * accuracy);
                hidden.extend(look(&mut enclosure, window, &distances, (length, count(line)), tolerances));
            }
        }
        Self::of(line, accuracy, hidden)
    }

    /// Finds the gaps of `line` that may hide something.
    fn of<S: Real>(line: &WorldLine<S>, accuracy: f64, mut hidden: Vec<Hidden>) -> Self {
        hidden.sort_by(|one, other| one.share.total_cmp(&other.share));
        let mut sum = 0.0;
        let explained = hidden.iter().take_while(|hidden| {
            sum += hidden.share;
            sum <= 1.0
        });
        let unexplained = &hidden[explained.count()..];
        let first =
            unexplained.iter().min_by_key(|hidden| (hidden.window, hidden.node)).map(|first| Gap::new(line, first));
        Self { count: count(line), unproved: unexplained.len(), accuracy, first }
    }

    /// The reason to doubt a run with gaps that are not explained.
    pub fn reason(&self) -> Option<Reason> {
        let Gap { gamma: [from, to], coordinates } = self.first.as_ref()?;
        let places = coordinates.iter().map(|(name, [from, to])| format!("{name} from {from:.6} to {to:.6}"));
        let finding = format!(
            "in {} of {} gaps between nodes the formulas may do what the nodes do not see, first from gamma = \
             {from:.6} to {to:.6}, with {}",
            self.unproved,
            self.count,
            places.collect::<Vec<_>>().join(", ")
        );
        Some(Reason::new(finding, "take more nodes (grid.n_gamma) or solver.accuracy"))
    }
}
