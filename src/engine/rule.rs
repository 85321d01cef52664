//! Tables of a collocation for the lanes of a window.

use crate::number::Compensated;
use crate::number::vector::{Matrix, Nodes, Weights};
use crate::sbp::collocation::Collocation;
use crate::sbp::legendre::legendre;

/// The order of the equations, which says how often slopes are integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    /// q̇ = v(q, p), ṗ = f(q, p).
    First,
    /// q̈ = a(q).
    Second,
}

impl Order {
    /// h or h², by which integrals of slopes over a window of length h are longer than those over one of length 1.
    pub(super) fn power_of(self, h: f64) -> f64 {
        if self == Self::First { h } else { h * h }
    }
}

/// The tables of a rule of n ≤ N nodes.
///
/// Lanes beyond the last node repeat it: they are no points of the world-line, but nothing goes wrong in them that does
/// not at the last node.
pub(super) struct Rule<const N: usize> {
    operators: &'static Collocation,
    /// c, and what rounding took from it.
    pub(super) nodes: [Nodes<N>; 2],
    /// b, 0 beyond the last node.
    pub(super) weights: Nodes<N>,
    /// A.
    pub(super) integral: Box<Matrix<N>>,
    /// The weights of the value at each node in the Legendre coefficients.
    pub(super) modes: Box<Matrix<N>>,
    /// Masks: 1 in the first 2k lanes, and in all of them behind the last one.
    pub(super) first_pairs: Vec<Nodes<N>>,
}

impl<const N: usize> Rule<N> {
    /// The rule of these operators on up to N nodes.
    pub(super) fn new(operators: &'static Collocation) -> Self {
        let n = operators.points();
        let mut weights = Nodes::ZERO;
        weights.0[..n].iter_mut().zip(&operators.weights).for_each(|(to, weight)| *to = weight.high);
        let node = |i: usize| operators.nodes[i.min(n - 1)];
        let nodes = [Nodes(std::array::from_fn(|i| node(i).high)), Nodes(std::array::from_fn(|i| node(i).low))];
        let integral = matrix(n, |i, j| operators.a[i * n + j].high);
        let mut modes = vec![Nodes::ZERO; n.next_multiple_of(2)];
        for k in 0..n {
            modes.iter_mut().zip(operators.mode(k)).for_each(|(modes, weight)| modes.0[k] = weight);
        }
        let lane = |k: usize, i: usize| f64::from(u8::from(i < 2 * k || k == n / 2));
        let first_pairs = (0..=n / 2).map(|k| Nodes(std::array::from_fn(|i| lane(k, i)))).collect();
        Self { operators, nodes, weights, integral, modes: modes.into(), first_pairs }
    }

    /// Number n of nodes.
    pub(super) fn points(&self) -> usize {
        self.operators.points()
    }

    /// Returns true if the last node is the end of the window.
    pub(super) fn has_end(&self) -> bool {
        self.operators.has_end()
    }

    /// D̄ on Lobatto nodes.
    pub(super) fn derivative(&self) -> Box<Matrix<N>> {
        let (n, derivative) = (self.points(), self.operators.derivative());
        matrix(n, |i, j| derivative[i * n + j])
    }

    /// The tables of windows of length `h`. Exact ones keep what rounding takes from their entries.
    pub(super) fn tables(&self, order: Order, h: Compensated, is_exact: bool) -> Tables<N> {
        let n = self.points();
        let factor = if order == Order::First { h } else { h * h };
        let entries = self.entries(order);
        let end = |j: usize| match order {
            Order::First => self.operators.weights[j],
            Order::Second => self.operators.position_weight(j),
        };
        let (collocation, collocation_low) = if is_exact {
            let [high, low] = both_parts(n, |i, j| factor * entries[i * n + j]);
            (high, Some(low))
        } else {
            (matrix(n, |i, j| factor.high * entries[i * n + j].high), None)
        };
        Tables {
            length: h.high,
            collocation,
            collocation_low,
            weights: Weights::new(n, |j| h * self.operators.weights[j]),
            end_weights: Weights::new(n, |j| factor * end(j)),
        }
    }

    /// A or A² after the Legendre polynomials of a window on the nodes of the next one, which is `ratio` times as long,
    /// row by row, and behind them these polynomials in the middle of that window.
    pub(super) fn continued(&self, order: Order, ratio: f64) -> Vec<f64> {
        let at = |c: f64| legendre(self.points() - 1, 1.0 + 2.0 * ratio * c);
        let mut all = self.integrated(order, at);
        all.extend(at(0.5));
        all
    }

    /// The continuation of a window into one of this length that begins with it, and is `ratio` times as long.
    pub(super) fn within(&self, order: Order, length: f64, ratio: f64) -> Continuation<N> {
        let at = |c: f64| legendre(self.points() - 1, 2.0 * ratio * c - 1.0);
        let mut all = self.integrated(order, at);
        // Inside of the window no polynomial is larger than 1.
        all.extend(at(1.0).into_iter().map(|value| value.abs().max(1.0)));
        self.continuation(order.power_of(length), &all)
    }

    /// A or A² after Legendre polynomials, whose values at a node are given by this function, row by row.
    fn integrated(&self, order: Order, at: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
        let (n, entries) = (self.points(), self.entries(order));
        let values: Vec<Vec<f64>> = self.operators.nodes.iter().map(|c| at(c.high)).collect();
        let mut all = vec![0.0; n * n];
        for (row, entries) in all.chunks_exact_mut(n).zip(entries.chunks_exact(n)) {
            for (entry, values) in entries.iter().zip(&values) {
                row.iter_mut().zip(values).for_each(|(sum, value)| *sum += entry.high * value);
            }
        }
        all
    }

    /// The continuation by these numbers, see [`Self::continued`], for a window of which h or h² is `factor`.
    pub(super) fn continuation(&self, factor: f64, continued: &[f64]) -> Continuation<N> {
        let n = self.points();
        let mut growth = Nodes::ZERO;
        growth.0[..n].copy_from_slice(&continued[n * n..]);
        Continuation { increments: matrix(n, |i, k| factor * continued[i * n + k]), growth }
    }

    /// A or A², row by row.
    fn entries(&self, order: Order) -> &[Compensated] {
        if order == Order::First { &self.operators.a } else { &self.operators.a_squared }
    }

    /// The weights of the values on the nodes in the highest four Legendre modes, the highest one first.
    pub(super) fn highest_modes(&self) -> [Nodes<N>; 4] {
        let weight = |k: usize, i: usize| self.modes.get(i).map_or(0.0, |modes| modes.0[self.points() - 1 - k]);
        std::array::from_fn(|k| Nodes(std::array::from_fn(|i| weight(k, i))))
    }

    /// The Legendre coefficients of the polynomial with these values, 0 beyond the last one.
    pub(super) fn modes(&self, values: &Nodes<N>) -> [f64; N] {
        let mut modes = [0.0; N];
        for (weights, value) in self.modes.iter().zip(&values.0[..self.points()]) {
            modes.iter_mut().zip(&weights.0).for_each(|(mode, weight)| *mode += weight * value);
        }
        modes
    }
}

/// The tables by which the polynomials of the window before are continued into the next one.
pub(super) struct Continuation<const N: usize> {
    /// From Legendre modes of the slopes in the window before to increments on the nodes of the next one.
    pub(super) increments: Box<Matrix<N>>,
    /// Legendre polynomials in the middle of the next one, 0 beyond the last mode.
    pub(super) growth: Nodes<N>,
}

/// The tables of windows of one length.
pub(super) struct Tables<const N: usize> {
    /// h.
    pub(super) length: f64,
    /// h A for equations of first order, h² A² for those of second order.
    pub(super) collocation: Box<Matrix<N>>,
    /// The part that rounding took from its entries. Errors of rounded entries are the same in every window, and K
    /// would drift. It is left out where the accuracy allows for that.
    pub(super) collocation_low: Option<Box<Matrix<N>>>,
    /// h b, and what stands for it in positions: h b, or h² b (1 − c) for equations of second order.
    pub(super) weights: Weights<N>,
    pub(super) end_weights: Weights<N>,
}

/// A matrix of n rows and columns whose last row is repeated.
fn matrix<const N: usize>(n: usize, entry: impl Fn(usize, usize) -> f64) -> Box<Matrix<N>> {
    let column = |j: usize| Nodes(std::array::from_fn(|i| if j < n { entry(i.min(n - 1), j) } else { 0.0 }));
    (0..n.next_multiple_of(2)).map(column).collect()
}

/// Such matrices of the entries and of what rounding took from them. Windows at kinks have many lengths.
fn both_parts<const N: usize>(n: usize, entry: impl Fn(usize, usize) -> Compensated) -> [Box<Matrix<N>>; 2] {
    let mut columns = [(); 2].map(|()| vec![Nodes::ZERO; n.next_multiple_of(2)]);
    let [high, low] = &mut columns;
    for (j, (high, low)) in high.iter_mut().zip(low).take(n).enumerate() {
        for (i, (high, low)) in high.0.iter_mut().zip(&mut low.0).enumerate() {
            let entry = entry(i.min(n - 1), j);
            (*high, *low) = (entry.high, entry.low);
        }
    }
    columns.map(Into::into)
}
