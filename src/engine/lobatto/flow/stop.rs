//! Where a march is to end.

use super::state::FlowState;
use super::window::FlowWindow;
use crate::number::root::try_root;

/// A point of a world-line with its velocities and momenta, of all coordinates.
#[derive(Debug, Clone, Copy)]
pub struct PhasePoint<'p> {
    /// q^a.
    pub q: &'p [f64],
    /// dq^a/dγ.
    pub q_dot: &'p [f64],
    /// p_a.
    pub p: &'p [f64],
}

/// A function of the state at whose first change of sign a march ends.
pub trait Stop {
    /// Its value.
    fn value(&mut self, point: PhasePoint<'_>) -> f64;

    /// Whether a change to positive values, or to negative ones, ends the march.
    fn counts(&self, to_positive: bool) -> bool;
}

/// Sees the sign of a stop change.
pub(super) struct Watch<'s> {
    stop: &'s mut dyn Stop,
    /// The sign at the last joint and at the end of the window that was looked at; 0 as long as the value was 0.
    side: f64,
    side_at_end: f64,
    /// All coordinates at one node.
    q: Vec<f64>,
    q_dot: Vec<f64>,
    p: Vec<f64>,
}

/// A value at the start of a run counts as zero if it is this part of that at the next node.
const AT_START: f64 = 1e-6;

impl<'s> Watch<'s> {
    /// From the momenta of all coordinates at the start.
    pub(super) fn new(stop: &'s mut dyn Stop, momenta: &[f64]) -> Self {
        let n = momenta.len();
        Self { stop, side: 0.0, side_at_end: 0.0, q: vec![0.0; n], q_dot: vec![0.0; n], p: momenta.to_vec() }
    }

    /// A new march begins.
    pub(super) fn begin(&mut self) {
        self.side = 0.0;
    }

    /// The window that was looked at is accepted.
    pub(super) fn accept(&mut self) {
        self.side = self.side_at_end;
    }

    fn at<const P: usize>(&mut self, window: &FlowWindow<'_, P>, start: &FlowState, h: f64, node: usize) -> f64 {
        window.node(start, h, node, [&mut self.q, &mut self.q_dot, &mut self.p]);
        self.stop.value(PhasePoint { q: &self.q, q_dot: &self.q_dot, p: &self.p })
    }

    /// The interval of nodes of the solved window in which the sign first changes.
    pub(super) fn look<const P: usize>(
        &mut self,
        window: &FlowWindow<'_, P>,
        start: &FlowState,
        h: f64,
    ) -> Option<Bracket> {
        let nodes = window.rule.rule.nodes();
        let mut side = self.side;
        let mut before = (0.0, self.at(window, start, h, 0));
        if side == 0.0 {
            // The start of a run. A root there is none, and the first node is the start up to an error of the scheme.
            let next = self.at(window, start, h, 1);
            let first = if before.1.abs() < AT_START * next.abs() { next } else { before.1 };
            side = if first == 0.0 { 0.0 } else { first.signum() };
            before.1 = before.1.abs().copysign(side);
        }
        for (node, c) in nodes.iter().enumerate().skip(1) {
            let here = (c.hi * h, self.at(window, start, h, node));
            let is_change = here.1 * side < 0.0 || here.1 == 0.0 && side != 0.0;
            if is_change && self.stop.counts(side < 0.0) {
                return Some(Bracket { before, after: here });
            }
            if here.1 != 0.0 {
                side = here.1.signum();
            }
            before = here;
        }
        self.side_at_end = side;
        None
    }

    /// The value at the end of the solved window.
    pub(super) fn at_end<const P: usize>(&mut self, window: &FlowWindow<'_, P>, start: &FlowState, h: f64) -> f64 {
        self.at(window, start, h, window.rule.rule.points() - 1)
    }
}

/// Two lengths of a window between whose ends the sign changes, with the values there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bracket {
    before: (f64, f64),
    after: (f64, f64),
}

impl Bracket {
    /// The length at which `value` changes its sign, to rounding of `gamma`; `None` if there is no value on the way.
    ///
    /// Values inside a window are less accurate than those at its end: the bracket is tested and opened first.
    pub(super) fn root(self, gamma: f64, longest: f64, mut value: impl FnMut(f64) -> Option<f64>) -> Option<f64> {
        let Self { before: (low, _), after: (high, _) } = self;
        let side = if self.after.1 != 0.0 { -self.after.1.signum() } else { self.before.1.signum() };
        let (mut low, mut high) = (low, high);
        let width = high - low;
        let (mut at_low, mut at_high) = (if low > 0.0 { value(low)? } else { self.before.1 }, value(high)?);
        if low > 0.0 && at_low * side <= 0.0 {
            (high, at_high) = (low, at_low);
            low = (low - width).max(0.0);
            at_low = if low > 0.0 { value(low)? } else { side };
        } else if at_high * side > 0.0 {
            (low, at_low) = (high, at_high);
            high = (high + width).min(longest);
            at_high = value(high)?;
        }
        if low == 0.0 && at_low * side <= 0.0 {
            at_low = side * f64::MIN_POSITIVE;
        }
        if at_low * side <= 0.0 || at_high * side > 0.0 {
            return None;
        }
        let least = 2.0 * f64::EPSILON * (gamma + high).max(high);
        if at_high == 0.0 {
            return Some(high);
        }
        try_root([low, at_low], [high, at_high], least, value)
    }
}

#[cfg(test)]
mod tests {
    use super::Bracket;

    /// The root that is found from a bracket of nodes, of a function that changes its sign at `root`, in a window of
    /// length 1.
    fn found([low, high]: [f64; 2], side: f64, root: f64) -> Option<f64> {
        let value = |h: f64| side * (root - h) * (1.0 + h * h);
        // Inside the window values are less accurate: those of the bracket change their signs in any case.
        Bracket { before: (low, side), after: (high, -side) }.root(0.0, 1.0, |h| Some(value(h)))
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
        let bracket = Bracket { before: (0.25, 1.0), after: (0.5, -1.0) };
        let count = |gamma: f64| {
            let mut count = 0;
            let value = |h: f64| {
                count += 1;
                assert!((0.0..=1.0).contains(&h));
                Some((0.3 - h) * (1.0 + h))
            };
            let root = bracket.root(gamma, 1.0, value).unwrap();
            assert!((root - 0.3).abs() <= 4.0 * f64::EPSILON * (gamma + 0.5), "{root}");
            count
        };
        assert!(count(1e12) < count(0.0));
        assert_eq!(bracket.root(0.0, 1.0, |_| None), None);
        // A value that is zero at the end of the bracket is a root.
        let exact = Bracket { before: (0.25, 1.0), after: (0.5, 0.0) };
        assert_eq!(exact.root(0.0, 1.0, |h| Some(0.5 - h)), Some(0.5));
    }

    /// At the start of a run the value may be zero, up to rounding.
    #[test]
    fn a_start_that_is_nearly_a_root_has_the_side_of_its_bracket() {
        for size in [0.0, 1e-18] {
            for side in [1.0, -1.0] {
                let bracket = Bracket { before: (0.0, side * size), after: (0.1, -side) };
                let root = bracket.root(0.0, 1.0, |h| Some(side * h * (0.05 - h))).unwrap();
                assert!((root - 0.05).abs() < 1e-15, "{root}");
            }
        }
    }
}
