//! Runs that end where something has a value.
//!
//! Values inside a window are not as accurate as that at its end, so that the place is found by windows that end there.

use super::adaptive::{Adaptive, Target};
use super::solved::{Solved, WindowNodes};
use super::window::Solver;
use super::{Failure, State, Windows};
use crate::number::Compensated;
use crate::number::root::{root, try_root};

/// A run to a value of a coordinate ends without success after so many windows in turn that come no nearer to it.
const IDLE: usize = 100;
/// The place that the polynomial of a window tells is looked at first with so much room, relative to the distance of
/// two nodes.
const ROOM: f64 = 1e-4;
/// A root is looked for again if it is nearer to the start of the run than this share of where it was looked for.
const NEARER: f64 = 0.25;
/// A run has come to its value if it is off by no more than so many units in the last place: the length of its last
/// window, and the sum with that, are rounded once each.
const ARRIVED: f64 = 2.0;

impl Adaptive<'_> {
    /// Ends the run in the window that was accepted, if it gets to the target there.
    ///
    /// # Errors
    /// If the run comes no nearer to it, or if there is no window that ends there.
    pub(super) fn land(&mut self) -> Result<(), Failure> {
        let Some(mut target) = self.target else { return Ok(()) };
        let (a, h) = (target.coordinate, self.attempt.accepted.length);
        let side = (target.value - target.from).signum();
        let ahead = |q: f64| (q - target.value) * side;
        if ahead(self.lent.solver.end.q[a].high).abs() <= ARRIVED * f64::EPSILON * target.value.abs() {
            self.lent.solver.end.q[a] = Compensated::from(target.value);
            self.attempt.accepted.is_last = true;
            return Ok(());
        }
        let passed = self.may_pass(a, target.value, side).then(|| self.lent.dense()).and_then(|dense| {
            let nodes = self.lent.solver.fractions();
            let node = (1..nodes.len()).find(|&node| ahead(dense.position(a, nodes[node])) >= 0.0)?;
            Some((dense, [nodes[node - 1], nodes[node]]))
        });
        let Some((dense, [low, high])) = passed else {
            let q = self.lent.solver.end.q[a].high;
            let distance = (target.value - q).abs();
            target.idle = if distance < target.nearest { 0 } else { target.idle + 1 };
            target.nearest = target.nearest.min(distance);
            self.target = Some(target);
            let end = self.gamma_at_end();
            let length = target.foreseen(q, end);
            // If nothing is known, it is as long as it was so far.
            self.length = if length.is_finite() { length } else { self.length.max(end) };
            return if target.idle < IDLE { Ok(()) } else { Err(Failure::ValueNotReached) };
        };
        let at = |fraction: f64| ahead(dense.position(a, fraction));
        let place = root([low, at(low).min(-f64::MIN_POSITIVE)], [high, at(high)], f64::EPSILON, at);
        let room = ROOM * (high - low);
        let tries = [[(place - room).max(0.0), (place + room).min(1.0)], [low, high]];
        let mut value = |state: &State| ahead(state.q[a].high) + state.q[a].low * side;
        for fractions in tries {
            if let Ok(true) = self.end_where(fractions.map(|fraction| fraction * h), -1.0, &mut value) {
                self.lent.solver.end.q[a] = Compensated::from(target.value);
                return Ok(());
            }
        }
        Err(self.reason(Failure::NotConverged))
    }
}

impl Adaptive<'_> {
    /// The length in which the coordinate comes to the target at the rate that it has at the start of the window.
    pub(super) fn rest_to_target(&self) -> Option<f64> {
        let Target { coordinate: a, value, .. } = self.target?;
        let Solver { initial, start, .. } = &self.lent.solver;
        let rate = if self.attempt.windows == 0 { initial.q_dot[a] } else { self.attempt.rate };
        let rest = ((value - start.q[a].high) - start.q[a].low) / rate;
        (rest > 0.0 && rest.is_finite()).then_some(rest)
    }
}

/// The length, between two lengths, at which `value` changes its sign from `side`, to rounding of `gamma`; `None` if it
/// does not, or if there is no value on the way. Lengths are at most `longest`.
///
/// A change beside the two lengths, by no more than their distance, is found too.
pub(super) fn root_between(
    [mut low, mut high]: [f64; 2],
    side: f64,
    gamma: f64,
    longest: f64,
    mut value: impl FnMut(f64) -> Option<f64>,
) -> Option<f64> {
    let width = high - low;
    let mut at_high = value(high)?;
    let at_start = |at_high: f64| side * at_high.abs().max(f64::MIN_POSITIVE);
    let mut at_low = if low > 0.0 { value(low)? } else { at_start(at_high) };
    if at_low * side <= 0.0 {
        (high, at_high) = (low, at_low);
        low = (low - width).max(0.0);
        at_low = if low > 0.0 { value(low)? } else { at_start(at_high) };
    } else if at_high * side > 0.0 {
        (low, at_low) = (high, at_high);
        high = (high + width).min(longest);
        at_high = value(high)?;
    }
    if at_low * side <= 0.0 || at_high * side > 0.0 {
        return None;
    }
    loop {
        if at_high == 0.0 {
            return Some(high);
        }
        let least = 2.0 * f64::EPSILON * (gamma + high);
        let root = try_root([low, at_low], [high, at_high], least, &mut value)?;
        if root <= least {
            return Some(least);
        }
        // A root near the start of a run has digits of its own.
        let near = 2.0 * root;
        if gamma + near > NEARER * (gamma + high) {
            return Some(root);
        }
        let at_near = value(near)?;
        if at_near * side > 0.0 {
            return Some(root);
        }
        (high, at_high) = (near, at_near);
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::super::tests::{kerr, lifted, schwarzschild, well};
    use super::super::{Accuracy, Engine, Failure};
    use super::root_between;

    const ACCURACY: Accuracy = Accuracy::Promised(1e-9);

    /// The end of a run: γ and q^a.
    fn end(mut engine: Engine<'_>) -> Result<(f64, Vec<f64>), Failure> {
        engine.run(|_| ControlFlow::Continue(()))?;
        assert!(engine.error_estimate().unwrap() <= 1e-9);
        Ok(engine.place())
    }

    /// A run ends at a value of an ignorable or of an active coordinate to the last bit, and there it is where a run of
    /// that length comes to.
    #[test]
    fn runs_end_at_values() {
        let pendulum = lifted("1 - cos(x)", &["x"], &[1.0], &[0.3]);
        let scenes = [(well(), 0, 11.3), (well(), 1, 0.2), (schwarzschild(), 0, 711.0), (schwarzschild(), 1, 13.0)];
        for ((geometry, start), a, value) in scenes.into_iter().chain([(kerr(), 3, 7.0), (pendulum, 0, 1e-3)]) {
            let engine = Engine::accurate_to_value(&geometry, &start, (a, value), ACCURACY).unwrap();
            let (length, q) = end(engine).unwrap();
            assert_eq!(q[a].to_bits(), value.to_bits());
            let (_, same) = end(Engine::accurate(&geometry, &start, length, ACCURACY).unwrap()).unwrap();
            for (one, other) in q.iter().zip(same) {
                assert!((one - other).abs() < 3e-9 * other.abs().max(1.0), "{a}: {one} {other}");
            }
        }
        // The well has |x| < 1.01.
        let (geometry, start) = well();
        let engine = Engine::accurate_to_value(&geometry, &start, (1, 2.0), ACCURACY).unwrap();
        assert_eq!(end(engine), Err(Failure::ValueNotReached));
    }

    /// The root that is found from a bracket of nodes, of a function that changes its sign at `root`, in a window of
    /// length 1.
    fn found(between: [f64; 2], side: f64, root: f64) -> Option<f64> {
        root_between(between, side, 0.0, 1.0, |h| Some(side * (root - h) * (1.0 + h * h)))
    }

    #[test]
    fn a_root_in_a_bracket_or_right_beside_it_is_found() {
        for side in [1.0, -1.0] {
            for root in [0.3001, 0.35, 0.3999, 0.4, 0.4001, 0.45, 0.4999, 0.5, 0.5001, 0.55, 0.5999] {
                let at = found([0.4, 0.5], side, root).unwrap_or_else(|| panic!("{side} {root}"));
                assert!((at - root).abs() < 1e-15, "{side} {root}: {at}");
            }
            for root in [0.1, 0.29, 0.61, 0.9] {
                assert_eq!(found([0.4, 0.5], side, root), None, "{side} {root}");
            }
            // At the ends of the window there is no more room than it has.
            for (bracket, root) in [([0.02, 0.1], 0.001), ([0.0, 0.1], 0.03), ([0.0, 0.1], 0.15), ([0.95, 0.99], 0.995)]
            {
                let at = found(bracket, side, root).unwrap_or_else(|| panic!("{side} {root}"));
                assert!((at - root).abs() < 1e-15, "{side} {root}: {at}");
            }
            assert_eq!(found([0.9, 0.98], side, 1.02), None);
        }
    }

    /// To the digits that γ has at the end, and nothing is asked for beyond the window or where there is no value.
    #[test]
    fn a_root_is_as_accurate_as_gamma() {
        let count = |gamma: f64| {
            let mut count = 0;
            let value = |h: f64| {
                count += 1;
                assert!((0.0..=1.0).contains(&h));
                Some((0.3 - h) * (1.0 + h))
            };
            let root = root_between([0.25, 0.5], 1.0, gamma, 1.0, value).unwrap();
            assert!((root - 0.3).abs() <= 4.0 * f64::EPSILON * (gamma + 0.5), "{root}");
            count
        };
        assert!(count(1e12) < count(0.0));
        assert_eq!(root_between([0.25, 0.5], 1.0, 0.0, 1.0, |_| None), None);
        // A value that is zero at the end of the bracket is a root.
        assert_eq!(root_between([0.25, 0.5], 1.0, 0.0, 1.0, |h| Some(0.5 - h)), Some(0.5));
    }
}
