//! Legendre polynomials, and the rules of quadrature that are made of them.

use std::f64::consts::PI;

use crate::number::{Extended, Real};

/// A family of rules of n nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Family {
    /// The nodes of a weak window, Gauss–Lobatto–Legendre: ±1 and the zeros of P′_{n−1}.
    Lobatto,
    /// The stages of Gauss' method: the zeros of P_n.
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

/// A rule on [−1, 1], exactly symmetric about 0.
pub(super) struct Rule {
    pub(super) nodes: Vec<Extended>,
    pub(super) weights: Vec<Extended>,
    /// P_0 … P_n at every node.
    pub(super) legendre: Vec<Vec<Extended>>,
}

/// Number of Newton steps in extended precision. Each doubles the number of correct digits, beginning with those of
/// `f64`.
const REFINEMENTS: usize = 4;

impl Rule {
    /// The rule of `n` nodes. The weights are 2/(n (n − 1) P_{n−1}(x_i)²) (Abramowitz, Stegun 25.4.32) and
    /// 2 (1 − x_i²)/(n P_{n−1}(x_i))² (25.4.29).
    pub(super) fn new(family: Family, n: usize) -> Self {
        let number = |k: usize| Extended::from(k as f64);
        // The recursion P_{k+1} = xP_k + k/(k + 1) (xP_k − P_{k−1}) needs no divisions but these.
        let ratios: Vec<Extended> = (1..n).map(|k| number(k) / number(k + 1)).collect();
        let legendre = |x: Extended| {
            let mut p = vec![Extended::ONE, x];
            for (k, &ratio) in ratios.iter().enumerate() {
                let product = x * p[k + 1];
                p.push(product + ratio * (product - p[k]));
            }
            p
        };
        let mut nodes = vec![Extended::ZERO; n];
        for i in 0..n / 2 {
            let begin = || Extended::from(approximate_node(family, n, i));
            let refined = || (0..REFINEMENTS).fold(begin(), |x, _| x - newton_step(family, n, x, &legendre(x)));
            nodes[i] = if i == 0 && family == Family::Lobatto { -Extended::ONE } else { refined() };
            nodes[n - 1 - i] = -nodes[i];
        }
        let legendre: Vec<Vec<Extended>> = nodes.iter().map(|&x| legendre(x)).collect();
        let weight = |(&x, p): (&Extended, &Vec<Extended>)| match family {
            Family::Lobatto => number(2) / (number(n * (n - 1)) * p[n - 1] * p[n - 1]),
            Family::Gauss => {
                let root = number(n) * p[n - 1];
                number(2) * (Extended::ONE - x * x) / (root * root)
            }
        };
        Self { weights: nodes.iter().zip(&legendre).map(weight).collect(), nodes, legendre }
    }
}

/// A step of Newton's method, to be taken from x, where the polynomials are `p`: towards a root of P_m, m = n, or of
/// P′_m, m = n − 1, with (1 − x²)P′_m = m(P_{m−1} − xP_m) and (1 − x²)P″_m = 2xP′_m − m(m + 1)P_m.
fn newton_step<S: Real>(family: Family, n: usize, x: S, p: &[S]) -> S {
    let m = if family == Family::Gauss { n } else { n - 1 };
    let [degree, eigenvalue] = [m, m * (m + 1)].map(|k| S::from(k as f64));
    let first = degree * (p[m - 1] - x * p[m]) / (S::ONE - x * x);
    match family {
        Family::Gauss => p[m] / first,
        Family::Lobatto => first / (((x + x) * first - eigenvalue * p[m]) / (S::ONE - x * x)),
    }
}

/// The `i`-th root to the digits of `f64`.
fn approximate_node(family: Family, n: usize, i: usize) -> f64 {
    let mut x = match family {
        Family::Gauss => -(PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos(),
        // Asymptotic value: Parter (1999), "On the Legendre–Gauss–Lobatto points and weights".
        Family::Lobatto => {
            let m = (n - 1) as f64;
            let angle = PI * (i as f64 + 0.25) / m;
            -(angle - 3.0 / (8.0 * m * m * angle)).cos()
        }
    };
    for _ in 0..20 {
        let step = newton_step(family, n, x, &legendre(n, x));
        x -= step;
        if step.abs() < 1e-14 {
            break;
        }
    }
    x
}
