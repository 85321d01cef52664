//! Where a function of the state changes its sign along a trajectory.

use super::trajectory::ReferenceTrajectory;
use crate::geometry::Start;
use crate::number::Real;

/// Values that a function is looked at in each step, to find where it changes its sign.
const PROBES: usize = 16;

impl<S: Real> ReferenceTrajectory<S> {
    /// Every γ − γ_i, in order, at which `f` changes its sign. Two changes that are closer together than a sixteenth of
    /// a Taylor step may be missed.
    pub fn sign_changes(&self, f: impl Fn(&Start<S>) -> S) -> Vec<S> {
        self.directed_sign_changes(f).into_iter().map(|(gamma, _)| gamma).collect()
    }

    /// The same, with whether `f` is positive after the change.
    pub fn directed_sign_changes(&self, f: impl Fn(&Start<S>) -> S) -> Vec<(S, bool)> {
        let value = |gamma: S| f(&self.at(gamma * self.unit));
        let ends: Vec<S> = self.steps.ends().collect();
        let mut found = Vec::new();
        let (mut before, mut sign) = (ends[0], value(ends[0]));
        for pair in ends.windows(2) {
            for probe in 1..=PROBES {
                let gamma = pair[0] + (pair[1] - pair[0]) * S::from(probe as f64 / PROBES as f64);
                let next = value(gamma);
                if next != S::ZERO {
                    if sign != S::ZERO && next.signum() != sign.signum() {
                        let change = bisected(before, gamma, |gamma| value(gamma) * sign > S::ZERO) * self.unit;
                        found.push((change, next > S::ZERO));
                    }
                    (before, sign) = (gamma, next);
                }
            }
        }
        found
    }
}

/// Where `is_before` becomes false between the two numbers.
fn bisected<S: Real>(from: S, to: S, is_before: impl Fn(S) -> bool) -> S {
    let (mut from, mut to) = (from, to);
    loop {
        let middle = (from + to).half();
        if middle <= from || middle >= to {
            return to;
        }
        if is_before(middle) { from = middle } else { to = middle }
    }
}
