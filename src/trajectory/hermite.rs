//! Hermite interpolation through values and slopes on several nodes.

use crate::number::Real;

/// The polynomial of degree 2m − 1 through `values` with `slopes` on m `nodes`, at a place: divided differences with
/// every node twice, in Newton's form.
pub(super) fn through<S: Real>(nodes: &[S], values: &[S], slopes: &[S], at: S) -> S {
    let place = |i: usize| nodes[i / 2];
    let mut differences: Vec<S> = (0..2 * nodes.len()).map(|i| values[i / 2]).collect();
    for order in 1..differences.len() {
        for i in (order..differences.len()).rev() {
            differences[i] = if order == 1 && i % 2 == 1 {
                slopes[i / 2]
            } else {
                (differences[i] - differences[i - 1]) / (place(i) - place(i - order))
            };
        }
    }
    (0..differences.len()).rev().fold(S::ZERO, |sum, i| sum * (at - place(i)) + differences[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_is_found_from_its_values_and_slopes() {
        let nodes = [-0.3, 0.2, 0.5, 1.1];
        for m in 1..=4 {
            let degree = 2 * m as i32 - 1;
            let f = |x: f64| 0.7 - 1.3 * (x - 0.1).powi(degree);
            let d = |x: f64| -1.3 * f64::from(degree) * (x - 0.1).powi(degree - 1);
            let nodes = &nodes[..m];
            let [values, slopes] =
                [&f as &dyn Fn(f64) -> f64, &d].map(|f| nodes.iter().map(|&x| f(x)).collect::<Vec<_>>());
            for k in 0..=10 {
                let x = -0.3 + 0.14 * f64::from(k);
                assert!((through(nodes, &values, &slopes, x) - f(x)).abs() < 1e-13, "{m} nodes at {x}");
            }
        }
    }
}
