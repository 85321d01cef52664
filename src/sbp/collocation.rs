//! Collocation on [0, 1], to 30 digits: the operators of a weak window on Gauss–Lobatto–Legendre nodes, and Gauss'
//! method.

use std::sync::OnceLock;

use super::gll::{LobattoRule, MOST_NODES};
use super::legendre::{Family, approximate_node};
use crate::number::Compensated;

/// The matrix A of a collocation on n nodes of [0, 1], which integrates slopes, in double-double.
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
    family: Family,
    /// 0 ≤ c_0 < c_1 < … ≤ 1, symmetric about ½.
    pub(crate) nodes: Vec<Compensated>,
    /// The quadrature weights b_j, exact to degree 2n − 3, or 2n − 1 of Gauss; their sum is 1.
    pub(crate) weights: Vec<Compensated>,
    /// P_k at node i (on [−1, 1]), k = 0 … n, at `[i (n + 1) + k]`.
    legendre: Vec<Compensated>,
    /// A, row by row. On Lobatto nodes it is (D + H⁻¹E_0)⁻¹: its first column is b_0, its last row is b.
    pub(crate) a: Vec<Compensated>,
    /// A², row by row. On Lobatto nodes its last row is b_j (1 − c_j).
    pub(crate) a_squared: Vec<Compensated>,
}

impl Collocation {
    /// Those of `n` nodes, made once in the life of the program; a tenth of a millisecond for 20 of them.
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

    /// A weight follows from its node on [−1, 1] and P_0 … P_n there; the nodes are mirrored, and so are the weights.
    fn new(family: Family, n: usize) -> Self {
        let (x, legendre) = nodes_with_legendre(family, n);
        let scale = Compensated::from((n * (n - 1)) as f64);
        let weight = |x: Compensated, p: &[Compensated]| match family {
            // b_i = 1/(n (n − 1) P_{n−1}(x_i)²) on [0, 1] (Abramowitz, Stegun 25.4.32).
            Family::Lobatto => Compensated::ONE / (scale * (p[n - 1] * p[n - 1])),
            // b_i = (1 − x_i²)/(n P_{n−1}(x_i))² on [0, 1] (Abramowitz, Stegun 25.4.29).
            Family::Gauss => {
                let root = p[n - 1] * n as f64;
                (Compensated::ONE - x * x) / (root * root)
            }
        };
        let mut weights = vec![Compensated::ZERO; n];
        for i in 0..n.div_ceil(2) {
            weights[i] = weight(x[i], &legendre[i * (n + 1)..][..=n]);
            weights[n - 1 - i] = weights[i];
        }
        let nodes = x.iter().map(|&x| (x + Compensated::ONE).half()).collect();
        let mut operators = Self { family, nodes, weights, legendre, a: Vec::new(), a_squared: Vec::new() };
        let integration = operators.integration();
        operators.a = if family == Family::Lobatto { operators.inverse(&integration) } else { integration };
        operators.a_squared = operators.square();
        operators
    }

    /// Returns true if the last node is the end of the window.
    pub(crate) fn has_end(&self) -> bool {
        self.family == Family::Lobatto
    }

    /// Number of nodes.
    pub(crate) fn points(&self) -> usize {
        self.nodes.len()
    }

    /// (bᵀA)_j = b_j (1 − c_j), the simplifying assumption D(1) of both families.
    pub(crate) fn position_weight(&self, j: usize) -> Compensated {
        self.weights[j] * (Compensated::ONE - self.nodes[j])
    }

    /// On Lobatto nodes, A⁻¹ = D + H⁻¹E_0 row by row, see [`crate::sbp::gll`] for D: as 1/b_0 = n (n − 1), its first
    /// entry is that of −D.
    pub(crate) fn derivative(&self) -> Vec<f64> {
        let rule: LobattoRule = LobattoRule::new(self.points());
        let mut derivative: Vec<f64> = rule.differentiation.iter().map(|d| 2.0 * d).collect();
        derivative[0] = -derivative[0];
        derivative
    }

    /// P_k at node `i`, on [−1, 1].
    pub(crate) fn legendre(&self, i: usize, k: usize) -> Compensated {
        self.legendre[i * (self.points() + 1) + k]
    }

    /// Row of the nodal values' weights in Legendre coefficient k: the coefficient is Σ_j row_j f_j.
    pub(crate) fn mode(&self, k: usize) -> impl Iterator<Item = f64> {
        let norm = self.norm(k);
        (0..self.points()).map(move |j| norm * self.weights[j].high * self.legendre(j, k).high)
    }

    /// γ_k = 2k + 1, or n − 1 for the last of Lobatto, whose rule does not integrate the square of P_{n−1}.
    fn norm(&self, k: usize) -> f64 {
        let last = self.points() - 1;
        if k == last && self.family == Family::Lobatto { last as f64 } else { (2 * k + 1) as f64 }
    }

    /// S_ij = ∫_0^{c_i} ℓ_j, row by row.
    fn integration(&self) -> Vec<Compensated> {
        let n = self.points();
        // ℓ_j = Σ_k b_j γ_k P_k(x_j) P_k, and
        // ∫_{−1}^x P_k = (P_{k+1}(x) − P_{k−1}(x))/(2k + 1), 1 + x for k = 0; halved for the length of [0, 1].
        let mut integral = vec![Compensated::ZERO; n * n];
        for i in 0..n {
            integral[i * n] = self.nodes[i];
            for k in 1..n {
                let value = (self.legendre(i, k + 1) - self.legendre(i, k - 1)).half();
                let exact = (2 * k + 1) as f64;
                let norm = self.norm(k);
                integral[i * n + k] = if norm == exact { value } else { value * norm / Compensated::from(exact) };
            }
        }
        // Sums side by side: one after the other, each would wait for its own last term.
        let by_degree: Vec<Compensated> = (0..n * n).map(|place| self.legendre(place % n, place / n)).collect();
        let mut s = vec![Compensated::ZERO; n * n];
        for (row, integral) in s.chunks_exact_mut(n).zip(integral.chunks_exact(n)) {
            for (&factor, values) in integral.iter().zip(by_degree.chunks_exact(n)) {
                row.iter_mut().zip(values).for_each(|(sum, &value)| *sum = *sum + factor * value);
            }
            row.iter_mut().zip(&self.weights).for_each(|(sum, &weight)| *sum = *sum * weight);
        }
        if self.has_end() {
            s[..n].fill(Compensated::ZERO);
            s[n * (n - 1)..].copy_from_slice(&self.weights);
        }
        s
    }

    /// (D + H⁻¹E_0)⁻¹ from S.
    fn inverse(&self, integration: &[Compensated]) -> Vec<Compensated> {
        let (n, last) = (self.points(), self.points() - 1);
        // Barycentric weights of the nodes are proportional to 1/P_{n−1}(x_j).
        let at_0: Vec<Compensated> =
            (0..n).map(|j| self.weights[0] * (self.legendre(0, last) / self.legendre(j, last))).collect();
        let mut a = vec![Compensated::ZERO; n * n];
        for i in 0..last {
            let factor = Compensated::ONE - integration[i * n] / self.weights[0];
            for j in 1..n {
                a[i * n + j] = integration[i * n + j] + factor * at_0[j];
            }
            a[i * n] = self.weights[0];
        }
        a[last * n..].copy_from_slice(&self.weights);
        a
    }

    fn square(&self) -> Vec<Compensated> {
        let n = self.points();
        let mut square = vec![Compensated::ZERO; n * n];
        for (row, factors) in square.chunks_exact_mut(n).zip(self.a.chunks_exact(n)) {
            for (&factor, a) in factors.iter().zip(self.a.chunks_exact(n)) {
                row.iter_mut().zip(a).for_each(|(sum, &a)| *sum = *sum + factor * a);
            }
        }
        if self.has_end() {
            (0..n).for_each(|j| square[n * (n - 1) + j] = self.position_weight(j));
        }
        square
    }
}

/// The nodes on [−1, 1], and P_0 … P_n at each of them.
fn nodes_with_legendre(family: Family, n: usize) -> (Vec<Compensated>, Vec<Compensated>) {
    let last = n - 1;
    let reciprocal: Vec<Compensated> = (0..=n).map(|k| Compensated::ONE / Compensated::from(k.max(1) as f64)).collect();
    let fill = |x: Compensated, p: &mut [Compensated]| {
        (p[0], p[1]) = (Compensated::ONE, x);
        for k in 1..n {
            p[k + 1] = (x * p[k] * (2 * k + 1) as f64 - p[k - 1] * k as f64) * reciprocal[k + 1];
        }
    };
    let mut x = vec![Compensated::ZERO; n];
    let mut legendre = vec![Compensated::ZERO; n * (n + 1)];
    for i in 0..n.div_ceil(2) {
        x[i] = if i == 0 && family == Family::Lobatto {
            -Compensated::ONE
        } else if 2 * i == last {
            Compensated::ZERO
        } else {
            let mut z = Compensated::from(approximate_node(family, n, i));
            let mut p = vec![Compensated::ZERO; n + 1];
            // Newton's method doubles the digits: 15 to 30, and once more for the last ones.
            for _ in 0..2 {
                fill(z, &mut p);
                let s = Compensated::ONE - z * z;
                let step = match family {
                    Family::Gauss => p[n] * s / ((p[last] - z * p[n]) * n as f64),
                    Family::Lobatto => {
                        let first = (p[last - 1] - z * p[last]) * last as f64;
                        let second = z * (first / s) * 2.0 - p[last] * (last * n) as f64;
                        first / second
                    }
                };
                z = z - step;
            }
            z
        };
        fill(x[i], &mut legendre[i * (n + 1)..(i + 1) * (n + 1)]);
    }
    // The rule is symmetric to the last bit: P_k(−x) = (−1)^k P_k(x).
    for i in n.div_ceil(2)..n {
        x[i] = -x[last - i];
        for k in 0..=n {
            let p = legendre[(last - i) * (n + 1) + k];
            legendre[i * (n + 1) + k] = if k % 2 == 0 { p } else { -p };
        }
    }
    (x, legendre)
}

#[cfg(test)]
mod tests {
    use super::{Collocation, Compensated, Family};

    /// B(2s): Σ b_j c_j^(k−1) = 1/k for k ≤ 2s. C(s): Σ_j a_ij c_j^(k−1) = c_i^k/k for k ≤ s, and the same once more.
    #[test]
    fn gauss_integrates_polynomials() {
        for s in [1, 2, 3, 6, 12, 16] {
            let gauss = Collocation::shared(Family::Gauss, s);
            let power = |c: Compensated, k: usize| (0..k).fold(Compensated::ONE, |power, _| power * c);
            let sum = |row: &[Compensated], k: usize| {
                let terms = row.iter().zip(&gauss.nodes).map(|(&a, &c)| a * power(c, k - 1));
                terms.fold(Compensated::ZERO, |sum, term| sum + term)
            };
            let check = |found: Compensated, expected: Compensated| {
                assert!((found - expected).high.abs() < 1e-29, "{s} stages: {found:?} {expected:?}");
            };
            (1..=2 * s).for_each(|k| check(sum(&gauss.weights, k), Compensated::ONE / Compensated::from(k as f64)));
            for (i, &c) in gauss.nodes.iter().enumerate() {
                for k in 1..=s {
                    check(
                        sum(&gauss.a[i * s..][..s], k),
                        power(c, k) * (Compensated::ONE / Compensated::from(k as f64)),
                    );
                }
                for k in 1..s {
                    let expected = power(c, k + 1) * (Compensated::ONE / Compensated::from((k * (k + 1)) as f64));
                    check(sum(&gauss.a_squared[i * s..][..s], k), expected);
                }
            }
        }
    }
}
