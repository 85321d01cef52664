//! The method of a step: Gauss collocation with three nodes, on a polynomial between two points.

use crate::engine::rule::Order;

/// Gauss nodes of a step.
pub(super) const STAGES: usize = 3;

/// Gauss collocation on [0, 1], and the polynomial between two points.
#[derive(Debug)]
pub(super) struct Method {
    pub(super) nodes: [f64; STAGES],
    pub(super) weights: [f64; STAGES],
    /// A, or A² for equations of second order.
    pub(super) integral: [[f64; STAGES]; STAGES],
    /// A.
    pub(super) single: [[f64; STAGES]; STAGES],
    /// The weights of (x, h ẋ, h² ẍ) at the start and at the end in x at a node.
    pub(super) hermite: [[[f64; 3]; 2]; STAGES],
}

impl Method {
    pub(super) fn new(order: Order) -> Self {
        let r = 15.0_f64.sqrt();
        let nodes = [0.5 - r / 10.0, 0.5, 0.5 + r / 10.0];
        let a = [
            [5.0 / 36.0, 2.0 / 9.0 - r / 15.0, 5.0 / 36.0 - r / 30.0],
            [5.0 / 36.0 + r / 24.0, 2.0 / 9.0, 5.0 / 36.0 - r / 24.0],
            [5.0 / 36.0 + r / 30.0, 2.0 / 9.0 + r / 15.0, 5.0 / 36.0],
        ];
        let square = |i: usize, j: usize| (0..STAGES).map(|k| a[i][k] * a[k][j]).sum();
        let integral = match order {
            Order::First => a,
            Order::Second => std::array::from_fn(|i| std::array::from_fn(|j| square(i, j))),
        };
        // The start's polynomials, whose mirror images are those of the end.
        let side = |c: f64| {
            let rest = (1.0 - c).powi(3);
            [rest * (1.0 + 3.0 * c + 6.0 * c * c), rest * c * (1.0 + 3.0 * c), 0.5 * rest * c * c]
        };
        let hermite = nodes.map(|c| {
            let [x, slope, second] = side(1.0 - c);
            [side(c), [x, -slope, second]]
        });
        Self { nodes, weights: [5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0], integral, single: a, hermite }
    }
}

#[cfg(test)]
mod tests {
    use super::{Method, Order};

    /// The polynomial of degree 5 is exact for c⁵.
    #[test]
    fn motion_between_points_is_a_polynomial() {
        let method = Method::new(Order::First);
        for (c, [_, end]) in method.nodes.iter().zip(method.hermite) {
            assert!((end[0] + 5.0 * end[1] + 20.0 * end[2] - c.powi(5)).abs() < 1e-15);
        }
    }
}
