//! What hides between the nodes of a run on a given grid.
//!
//! A *gap* is a pair of neighbouring nodes. The formulas are enclosed on the way from one node to the other: it is
//! *explained* if no function and no quotient changes by more on it than its ends show, or if what changes more is too
//! small to matter.
//!
//! ```
//! use geodesic_ivp::diagnostics::gaps::Gaps;
//! use geodesic_ivp::{Case, Solution, solve};
//!
//! let text = r#"
//!     potential.formula.expression = "5*exp(-((x - 2)/0.05)^2)"
//!     particle.c = 3.0
//!     initial = { t = 0.0, x = -0.6, t_dot = 1.0, x_dot = 0.6 }
//!     grid = { gamma_f = 64.0, n_gamma = 64 }
//! "#;
//! let case = Case::parse("barrier", text, &[])?;
//! let solution: Solution = solve(&case)?;
//! assert!(solution.end.x > 30.0, "it steps over the barrier, which reflects");
//! let gaps = Gaps::of_solution(&solution, &case.metric(), None);
//! assert_eq!((gaps.count, gaps.unproved), (63, 1));
//! let (name, [from, to]) = &gaps.first.unwrap().coordinates[1];
//! assert!(name == "x" && *from < 2.0 && *to > 2.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod one;
mod scene;

use std::collections::BTreeMap;

use serde::ser::{Serialize, SerializeMap, Serializer};

use super::verdict::Reason;

/// What hides is compared with the error of a run, but with no error outside of these: less than the first is near
/// rounding, and a run with an error above the second is not one that explains anything.
const ERRORS: [f64; 2] = [1e-12, 1e-3];

/// What is taken for the error of a run where it is not known.
const UNKNOWN: f64 = 1e-6;

/// The gaps of a run. Its keys in `summary.json` are `gaps`, `gaps_unproved`, `gaps_accuracy`, `gap_unproved`.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Gaps {
    /// How many there are.
    #[serde(rename = "gaps")]
    pub count: usize,
    /// How many are not explained.
    #[serde(rename = "gaps_unproved")]
    pub unproved: usize,
    /// What hides in an explained gap moves no coordinate by more than a tenth of this, relative to max(1, size) of the
    /// coordinate.
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

impl Gaps {
    /// None so far, of a run with this error relative to max(1, size) of its coordinates.
    fn none(error: Option<f64>) -> Self {
        let [least, most] = ERRORS;
        // NaN is no error that is known.
        let accuracy = error.filter(|error| !error.is_nan()).unwrap_or(UNKNOWN).clamp(least, most);
        Self { count: 0, unproved: 0, accuracy, first: None }
    }

    /// Takes a window into account: the number of its gaps, and those that are not explained, the first of which is
    /// `gap`.
    fn see(&mut self, count: usize, unexplained: &[usize], gap: impl FnOnce(usize) -> Gap) {
        self.count += count;
        self.unproved += unexplained.len();
        if let (None, Some(&first)) = (&self.first, unexplained.first()) {
            self.first = Some(gap(first));
        }
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
