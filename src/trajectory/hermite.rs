//! Hermite interpolation: from two nodes with two derivatives, or from several with one.

use crate::number::Real;

/// A function and its first two derivatives with respect to γ.
pub(super) type Jet<S> = [S; 3];

/// The quintic Hermite polynomial on [0, `h`], evaluated at `s`. The arguments are the function at both ends.
pub(super) fn hermite<S: Real>([f0, d0, c0]: Jet<S>, [f1, d1, c1]: Jet<S>, h: S, s: S) -> S {
    let number = |n: f64| S::from(n);
    let (change, d0, d1, c0, c1) = (f1 - f0, h * d0, h * d1, h * h * c0.half(), h * h * c1.half());
    // The coefficients in powers of s/h. From here on, c0 and c1 are halves of the second derivatives.
    let cubic = number(10.0) * change - number(6.0) * d0 - number(4.0) * d1 - number(3.0) * c0 + c1;
    let quartic = number(-15.0) * change + number(8.0) * d0 + number(7.0) * d1 + number(3.0) * c0 - number(2.0) * c1;
    let quintic = number(6.0) * change - number(3.0) * (d0 + d1) - c0 + c1;
    let s = s / h;
    f0 + s * (d0 + s * (c0 + s * (cubic + s * (quartic + s * quintic))))
}

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

    #[test]
    fn quintics_are_interpolated_exactly() {
        let f = |x: f64| 1.0 - 2.0 * x + x.powi(2) / 3.0 + x.powi(3) - x.powi(4) / 7.0 + 0.3 * x.powi(5);
        let d = |x: f64| -2.0 + 2.0 * x / 3.0 + 3.0 * x.powi(2) - 4.0 * x.powi(3) / 7.0 + 1.5 * x.powi(4);
        let c = |x: f64| 2.0 / 3.0 + 6.0 * x - 12.0 * x.powi(2) / 7.0 + 6.0 * x.powi(3);
        let jet = |x: f64| [f(x), d(x), c(x)];
        let (a, h) = (0.4, 0.7);
        for k in 0..=10 {
            let s = h * f64::from(k) / 10.0;
            assert!((hermite(jet(a), jet(a + h), h, s) - f(a + s)).abs() < 1e-14, "at {s}");
        }
    }
}
