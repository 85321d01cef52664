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

#[cfg(test)]
mod tests {
    use super::first_knot;
    use crate::number::Extended;
    use crate::number::spline::{Kind, Outside, Table};

    const NODES: [f64; 6] =
        [0.0, 0.117_472_338_035_267_7, 0.357_384_241_759_677_4, 0.642_615_758_240_322_6, 0.882_527_661_964_732_3, 1.0];

    /// A parabola passes 0.5 at these places, and other knots at others.
    #[test]
    fn the_first_knot_on_the_way_is_found() {
        let points = [-1.0, 0.0, 0.5, 2.0].map(|x: f64| [x, x * x * x].map(Extended::from));
        let table = Table::new(&points, Kind::Natural, Outside::Linear).unwrap().derivative().unwrap();
        let found = |f: &dyn Fn(f64) -> f64| first_knot(table, &NODES, &NODES.map(f));
        let at = |f: &dyn Fn(f64) -> f64, place: f64| assert!((found(f).unwrap() - place).abs() < 1e-6, "{place}");
        at(&|s| s * s + 0.3, 0.2_f64.sqrt());
        at(&|s| 0.8 - s * s, 0.3_f64.sqrt());
        // 0.5 lies before 0 on the way down, and a knot at an end of the window is no knot in it.
        at(&|s| 0.6 - s, 0.1);
        at(&|s| 0.5 - s, 0.5);
        assert_eq!(found(&|s| 0.5 * s), None);
        assert_eq!(found(&|s| 0.6 + s), None);
        // The second derivative of the function jumps there.
        assert_eq!(first_knot(table.derivative().unwrap(), &NODES, &NODES.map(|s| 0.6 - s)), None);
    }
}
