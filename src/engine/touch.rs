//! Values along a motion that touch zero, or hardly pass it.
//!
//! Where the argument of sign or step has an extremum that is nearer to 0 than the run is accurate, the error decides
//! whether the force jumps, and for how long: by the root of the error, which no claim knows. So it is with an event
//! whose formula turns there.

/// Thirds are left out of the way between two nodes so many times: a place is known to a millionth of it, and a value
/// at an extremum to the square of that.
const THIRDS: usize = 40;
/// An extremum is looked for where the values on nodes come so near to 0, as a part of what they differ by: between
/// nodes there is no more of a polynomial that they follow.
const NEAR: f64 = 0.5;
/// The least part of what a value differs by that tells on which side of 0 it turns.
const ROUNDED: f64 = 16.0 * f64::EPSILON;

/// In a window in which a value differs by no more than this part rounding may turn it: between the first two nodes it
/// differs by a hundredth of that.
const TOLD: f64 = 4096.0 * f64::EPSILON;

/// The most that a value has differed by in a window so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct Touched {
    widest: f64,
}

impl Touched {
    /// The part of a window at which a value, which is this on the nodes, turns nearer to 0 than this share of what it
    /// differs by in a window. In the first window of a run it may leave 0 and come back, as a ball does that bounces
    /// low.
    pub(crate) fn look(&mut self, nodes: &[f64], values: &[f64], share: f64, is_first: bool) -> Option<f64> {
        let [least, most] = [f64::min, f64::max].map(|of| values.iter().copied().fold(values[0], of));
        self.widest = self.widest.max(most - least);
        let (last, near) = (nodes.len() - 1, share.max(ROUNDED) * self.widest);
        let looked_at = near.max(NEAR * (most - least));
        let is_far = values.iter().all(|value| value.abs() > looked_at);
        if is_far || most - least <= TOLD * self.widest {
            return None;
        }
        // It may turn in the first gap or in the last one, and a point behind these shows that.
        let [before, behind] = [2.0 * nodes[0] - nodes[1], 2.0 * nodes[last] - nodes[last - 1]];
        let mut all: Vec<[f64; 2]> = nodes.iter().zip(values).map(|(node, value)| [*node, *value]).collect();
        all.push([behind, interpolated(nodes, values, behind)]);
        if !is_first {
            all.insert(0, [before, interpolated(nodes, values, before)]);
        }
        let k = turning_point(&all).filter(|&k| all[k][1].abs() <= looked_at)?;
        let is_maximum = all[k][1] > all[k - 1][1];
        // A value that begins on a side comes back to zero, and does not go on from it.
        let has_side = values[0].abs() > near;
        if if has_side { is_maximum != (values[0] < 0.0) } else { is_first } {
            return None;
        }
        let at = extremum(nodes, values, [all[k - 1][0], all[k + 1][0]], is_maximum);
        // The run may end between the place where it passes zero and the one where it turns.
        (interpolated(nodes, values, at).abs() <= near && at >= nodes[0]).then_some(at)
    }
}

/// The point next to which values turn, if they do so once: rounding turns more often.
fn turning_point(all: &[[f64; 2]]) -> Option<usize> {
    let turns = |k: &usize| (all[*k][1] - all[k - 1][1]) * (all[k + 1][1] - all[*k][1]) < 0.0;
    let mut found = (1..all.len() - 1).filter(turns);
    found.next().filter(|_| found.next().is_none())
}

/// The place of the one extremum of a polynomial between two places: it is a maximum, or a minimum.
fn extremum(nodes: &[f64], values: &[f64], [mut from, mut to]: [f64; 2], is_maximum: bool) -> f64 {
    for _ in 0..THIRDS {
        let [one, other] = [from + (to - from) / 3.0, to - (to - from) / 3.0];
        let grows = interpolated(nodes, values, one) < interpolated(nodes, values, other);
        *(if grows == is_maximum { &mut from } else { &mut to }) = if grows == is_maximum { one } else { other };
    }
    0.5 * (from + to)
}

/// The polynomial through values on nodes, by Lagrange's formula.
pub(super) fn interpolated(nodes: &[f64], values: &[f64], at: f64) -> f64 {
    let weight = |k: usize| {
        let others = nodes.iter().enumerate().filter(|(j, _)| *j != k);
        others.fold(1.0, |product, (_, node)| product * (at - node) / (nodes[k] - node))
    };
    values.iter().enumerate().map(|(k, value)| value * weight(k)).sum()
}

#[cfg(test)]
mod tests {
    use super::Touched;
    use crate::sbp::collocation::Collocation;
    use crate::sbp::legendre::Family;

    /// A parabola whose top is so high touches 0 where that is less than the share of its height, from both sides, and
    /// not if it begins on the other side.
    #[test]
    fn a_top_next_to_zero_is_found_where_it_is() {
        let operators = Collocation::shared(Family::Lobatto, 16);
        let nodes: Vec<f64> = operators.nodes.iter().map(|node| node.high).collect();
        let look = |values: &[f64], is_first: bool| Touched::default().look(&nodes, values, 1e-5, is_first);
        for place in [0.61, 1e-3, 0.999] {
            let values: Vec<f64> = nodes.iter().map(|at| -(at - place).powi(2)).collect();
            assert!(look(&values, false).is_some_and(|at| (at - place).abs() < 1e-6), "{place}");
        }
        for (top, is_near) in [(0.0, true), (1e-7, true), (-1e-7, true), (-1e-4, false), (1e-4, false), (-0.6, false)] {
            for sign in [1.0, -1.0] {
                let values: Vec<f64> = nodes.iter().map(|at| sign * (top - (at - 0.61).powi(2))).collect();
                assert_eq!([true, false].map(|is_first| look(&values, is_first).is_some()), [is_near; 2], "{top}");
                assert!(look(&values, true).is_none_or(|at| (at - 0.61).abs() < 1e-3));
            }
        }
        let line: Vec<f64> = nodes.iter().map(|at| at - 0.5).collect();
        assert_eq!(look(&line, false), None);
        let bounce: Vec<f64> = nodes.iter().map(|at| at * (1.0 - at)).collect();
        let low = || Touched { widest: 1e6 };
        assert!(low().look(&nodes, &bounce, 1e-5, false).is_some());
        assert_eq!(low().look(&nodes, &bounce, 1e-5, true), None);
    }
}
