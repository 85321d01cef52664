//! Collocation on [0, 1], to 30 digits: the operators of a weak window on Gauss–Lobatto–Legendre nodes, and Gauss'
//! method.

use std::sync::OnceLock;

use super::gll::{LobattoRule, MOST_NODES};
use super::legendre::{Family, Rule};
use crate::number::{Compensated, Extended, Real, sum};

/// The matrix A of a collocation on n nodes of [0, 1], which integrates slopes. Everything is computed in extended
/// precision and rounded once.
///
/// In Gauss' method it is the integration matrix S_ij = ∫_0^{c_i} ℓ_j.
///
/// On Gauss–Lobatto–Legendre nodes A is the inverse of D̄ = D + H⁻¹E_0, the matrix of the Lobatto IIIC Runge–Kutta
/// method (Chipman 1971; Hairer, Wanner, "Solving Ordinary Differential Equations II", IV.5). Nothing is inverted
/// numerically: with S (Lobatto IIIA), A f = u solves u′ + u(0) r = f, where r has the nodal values e_1/b_1;
/// u′ has degree n − 2, so the leading coefficients of f and of u(0) r agree, which gives u(0), and then
/// u = u(0) (1 − S e_1/b_1) + S f.
#[derive(Debug, Clone)]
pub(crate) struct Collocation {
    /// True if the last node is the end of the window.
    pub(crate) has_end: bool,
    /// 0 ≤ c_0 < c_1 < … ≤ 1, symmetric about ½.
    pub(crate) nodes: Vec<Compensated>,
    /// The quadrature weights b_j, exact to degree 2n − 3, or 2n − 1 of Gauss; their sum is 1.
    pub(crate) weights: Vec<Compensated>,
    /// (bᵀA)_j = b_j (1 − c_j), the simplifying assumption D(1) of both families.
    pub(crate) position_weights: Vec<Compensated>,
    /// A, row by row. On Lobatto nodes its first column is b_0, its last row is b.
    pub(crate) a: Vec<Compensated>,
    /// A², row by row. On Lobatto nodes its last row is b_j (1 − c_j).
    pub(crate) a_squared: Vec<Compensated>,
    /// For each node the weights of the value there in the Legendre coefficients.
    pub(crate) modes: Vec<f64>,
}

impl Collocation {
    /// Those of `n` nodes, made once in the life of the program; a tenth of a millisecond for 8 of them.
    ///
    /// # Panics
    /// Without 2 to 64 nodes of a window, or 1 to 64 stages of Gauss' method.
    pub(crate) fn shared(family: Family, n: usize) -> &'static Self {
        static OPERATORS: [[OnceLock<Collocation>; MOST_NODES + 1]; 2] =
            [const { [const { OnceLock::new() }; MOST_NODES + 1] }; 2];
        let fewest = if family == Family::Lobatto { 2 } else { 1 };
        assert!((fewest..=MOST_NODES).contains(&n), "there are {fewest} to {MOST_NODES} nodes, not {n}");
        OPERATORS[family as usize][n].get_or_init(|| Self::new(family, n))
    }

    fn new(family: Family, n: usize) -> Self {
        let (Rule { nodes, weights, legendre }, last) = (Rule::new(family, n), n - 1);
        let nodes: Vec<Extended> = nodes.iter().map(|&x| (x + Extended::ONE).half()).collect();
        let weights: Vec<Extended> = weights.iter().map(|weight| weight.half()).collect();
        // ℓ_j = Σ_k b_j γ_k P_k(x_j) P_k with γ_k = 2k + 1, or n − 1 for the last of Lobatto, whose rule does not
        // integrate the square of P_{n−1}.
        let norm = |k: usize| if k == last && family == Family::Lobatto { last as f64 } else { (2 * k + 1) as f64 };
        // ∫_{−1}^x P_k = (P_{k+1}(x) − P_{k−1}(x))/(2k + 1), 1 + x for k = 0; halved for the length of [0, 1].
        let integral = |i: usize, k: usize| match k {
            0 => nodes[i],
            _ => (legendre[i][k + 1] - legendre[i][k - 1]).half() / Extended::from((2 * k + 1) as f64),
        };
        let integrals = matrix(n, |i, k| Extended::from(norm(k)) * integral(i, k));
        let mut a = product(n, &integrals, &matrix(n, |k, j| weights[j] * legendre[j][k]));
        for row in a.chunks_exact_mut(n).filter(|_| family == Family::Lobatto) {
            // The barycentric weights of the nodes are proportional to 1/P_{n−1}(x_j).
            let at_0 = (weights[0] - row[0]) * legendre[0][last];
            row.iter_mut().zip(&legendre).for_each(|(entry, p)| *entry += at_0 / p[last]);
        }
        let rounded = |exact: &[Extended]| exact.iter().map(|&number| Compensated::nearest(number)).collect();
        let positions: Vec<Extended> = weights.iter().zip(&nodes).map(|(&b, &c)| b * (Extended::ONE - c)).collect();
        let mode = |j: usize, k: usize| norm(k) * weights[j].to_f64() * legendre[j][k].to_f64();
        Self {
            has_end: family == Family::Lobatto,
            nodes: rounded(&nodes),
            weights: rounded(&weights),
            position_weights: rounded(&positions),
            a_squared: rounded(&product(n, &a, &a)),
            a: rounded(&a),
            modes: (0..n * n).map(|place| mode(place / n, place % n)).collect(),
        }
    }

    /// Number of nodes.
    pub(crate) fn points(&self) -> usize {
        self.nodes.len()
    }

    /// On Lobatto nodes, A⁻¹ = D + H⁻¹E_0 row by row, see [`crate::sbp::gll`] for D: as 1/b_0 = n (n − 1), its first
    /// entry is that of −D.
    pub(crate) fn derivative(&self) -> Vec<f64> {
        let rule: LobattoRule = LobattoRule::new(self.points());
        let mut derivative: Vec<f64> = rule.differentiation.iter().map(|d| 2.0 * d).collect();
        derivative[0] = -derivative[0];
        derivative
    }
}

/// The n × n matrix of these entries, row by row.
fn matrix(n: usize, entry: impl Fn(usize, usize) -> Extended) -> Vec<Extended> {
    (0..n * n).map(|place| entry(place / n, place % n)).collect()
}

fn product(n: usize, left: &[Extended], right: &[Extended]) -> Vec<Extended> {
    matrix(n, |i, j| sum((0..n).map(|k| left[i * n + k] * right[k * n + j])))
}

#[cfg(test)]
mod tests {
    use super::{Collocation, Compensated, Extended, Family, Real, sum};

    /// B(2s): Σ b_j c_j^(k−1) = 1/k for k ≤ 2s. C(s): Σ_j a_ij c_j^(k−1) = c_i^k/k for k ≤ s, and the same once more.
    #[test]
    fn gauss_integrates_polynomials() {
        for s in [1, 2, 3, 6, 12, 16] {
            let gauss = Collocation::shared(Family::Gauss, s);
            let exact = |number: &Compensated| Extended::from(number.high) + Extended::from(number.low);
            let nodes: Vec<Extended> = gauss.nodes.iter().map(exact).collect();
            let power = |c: Extended, k: usize| (0..k).fold(Extended::ONE, |power, _| power * c);
            let check = |row: &[Compensated], k: usize, expected: Extended, divisor: usize| {
                let found = sum(row.iter().zip(&nodes).map(|(a, &c)| exact(a) * power(c, k - 1)));
                let error = (found - expected / Extended::from(divisor as f64)).abs().to_f64();
                assert!(error < 1e-29, "{s} stages: {error:e}");
            };
            (1..=2 * s).for_each(|k| check(&gauss.weights, k, Extended::ONE, k));
            for (i, &c) in nodes.iter().enumerate() {
                (1..=s).for_each(|k| check(&gauss.a[i * s..][..s], k, power(c, k), k));
                (1..s).for_each(|k| check(&gauss.a_squared[i * s..][..s], k, power(c, k + 1), k * (k + 1)));
            }
        }
    }
}
