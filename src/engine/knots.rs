//! The places in a window where the argument of a table passes a knot.
//!
//! The nodes of a window that passes a knot follow no polynomial, and its error falls only like a low power of its
//! length. So the window is solved again to end there, and the next one begins with the polynomial behind the knot.

use crate::number::root::root;
use crate::number::spline::Table;

/// A knot in this first or last part of a window is at its end. What the force is off by there grows with the square
/// of the time behind the knot at least, so that the error is this part to the third power.
const AT_END: f64 = 1e-6;

/// The part of the window before the first knot that the argument passes, by its values on the nodes; `None` where it
/// passes none, but for those at the ends of the window.
pub(super) fn first_knot(table: Table, nodes: &[f64], values: &[f64]) -> Option<f64> {
    // A function that is less smooth would have to be met to the last digit.
    if table.smoothness() == 0 {
        return None;
    }
    (1..values.len()).find_map(|k| {
        let [before, after] = [values[k - 1], values[k]];
        let mut knots = table.between(before, after).map(|knot| {
            let ahead = |at: f64| interpolated(nodes, values, at) - knot;
            let on_nodes = [k - 1, k].into_iter().find(|&k| values[k] == knot).map(|k| nodes[k]);
            on_nodes
                .unwrap_or_else(|| root([nodes[k - 1], before - knot], [nodes[k], after - knot], 0.1 * AT_END, ahead))
        });
        knots.find(|at| (AT_END..1.0 - AT_END).contains(at))
    })
}

/// The polynomial through values on nodes, by Lagrange's formula.
fn interpolated(nodes: &[f64], values: &[f64], at: f64) -> f64 {
    let weight = |k: usize| {
        let others = nodes.iter().enumerate().filter(|(j, _)| *j != k);
        others.fold(1.0, |product, (_, node)| product * (at - node) / (nodes[k] - node))
    };
    values.iter().enumerate().map(|(k, value)| value * weight(k)).sum()
}
