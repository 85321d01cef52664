//! Legendre polynomials, and the nodes of the rules that are made of them.

use crate::number::Real;

/// A family of rules of n nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Family {
    /// The nodes of a weak window, Gauss–Lobatto–Legendre.
    Lobatto,
    /// The stages of Gauss' method.
    Gauss,
}

/// P_0 … P_degree at z.
pub(crate) fn legendre<S: Real>(degree: usize, z: S) -> Vec<S> {
    let mut p = vec![S::ONE; degree + 1];
    if degree > 0 {
        p[1] = z;
    }
    for k in 1..degree {
        let [k_, next, twice] = [k, k + 1, 2 * k + 1].map(|k| S::from(k as f64));
        p[k + 1] = (twice * z * p[k] - k_ * p[k - 1]) / next;
    }
    p
}

/// A root of P_n, or the `i`-th one of P′_{n−1} (i from 1), by Newton's method with (1 − x²)P′_m = m(P_{m−1} − xP_m)
/// and Legendre's equation for P″.
pub(crate) fn approximate_node(family: Family, n: usize, i: usize) -> f64 {
    let degree = if family == Family::Gauss { n } else { n - 1 };
    let m = degree as f64;
    let mut x = match family {
        Family::Gauss => -(std::f64::consts::PI * (i as f64 + 0.75) / (m + 0.5)).cos(),
        // Asymptotic value: Parter (1999), "On the Legendre–Gauss–Lobatto points and weights".
        Family::Lobatto => {
            let angle = std::f64::consts::PI * (i as f64 + 0.25) / m;
            -(angle - 3.0 / (8.0 * m * m * angle)).cos()
        }
    };
    for _ in 0..20 {
        let p = legendre(degree, x);
        let first = m * (p[degree - 1] - x * p[degree]) / (1.0 - x * x);
        let second = (2.0 * x * first - m * (m + 1.0) * p[degree]) / (1.0 - x * x);
        let step = if family == Family::Gauss { p[degree] / first } else { first / second };
        x -= step;
        if step.abs() < 1e-14 {
            break;
        }
    }
    x
}
