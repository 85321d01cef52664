//! Legendre polynomials on the nodes of a window, and on an ellipse around it.
//!
//! A window is [−1, 1] here, and its ellipse the Bernstein ellipse E of ρ = 3, with the foci ±1 and half axes
//! a = (ρ + 1/ρ)/2 and b = (ρ − 1/ρ)/2. Tables are computed in 71 digits. Their recurrences take some hundred
//! operations and multiply rounding by less than 1e20 (the growth of P_32 on the ellipse), so that each entry is exact
//! to its last digit but for the rounding to doubles or pairs.

use std::f64::consts::PI;
use std::sync::LazyLock;

use super::algebras::{LANES, Row};
use crate::number::{Extended, Real};
use crate::sbp::collocation::Collocation;
use crate::sbp::legendre::Family;

/// The polynomials of slopes and of the adjoint matrix have degrees below these.
pub(super) const MODES: usize = LANES;
pub(super) const FEW: usize = 16;

/// A number for each of the few nodes.
pub(super) type FewRow = [f64; FEW];

/// The sum ρ of the half axes. Bounds fall like ρ^-64, and formulas must be analytic on the ellipse: a larger one makes
/// windows shorter, and a smaller one needs windows on which the motion is smoother. Any above 1 is valid.
const RHO: f64 = 3.0;

/// The Lebesgue constant of 32 Gauss nodes is below this (test).
pub(super) const LEBESGUE: f64 = 11.0;

/// Half of the largest distance between neighbours among the nodes and ±1 is below this (test).
pub(super) const HALF_GAP: f64 = 0.0485;

/// Products and sums of numbers that are rounded up: no chain has more than eight thousand of them, each of which takes
/// away at most 2^-53. Sums over columns of the set, which may be more, count their own.
pub(super) const UP: f64 = 1.0 + 1e-12;

/// Rows of numbers in twice the digits: off by at most 2^-106 of the numbers.
#[derive(Clone, Copy)]
pub(super) struct Pairs {
    pub(super) hi: Row,
    pub(super) lo: Row,
}

/// The tables.
pub(super) struct Tables {
    /// Row j has ∫_{−1}^{x_i} ℓ_j/2 for all i: the integrals of a window of length 1, for what needs no proof.
    pub(super) integrals: Vec<Row>,
    pub(super) few_integrals: Vec<FewRow>,
    /// Row j has what a value at node j adds to the coefficients of all P_k.
    pub(super) modes: Vec<Row>,
    pub(super) few_modes: Vec<FewRow>,
    /// P_k and ∫_{−1} P_k at the nodes, and these integrals at the few nodes.
    pub(super) legendre: Vec<Pairs>,
    pub(super) integral: Vec<Pairs>,
    pub(super) few_integral: Vec<FewRow>,
    /// Gauss' weights, whose sum is 2.
    pub(super) weights: Row,
    /// P_k and ∫_{−1} P_k, real and imaginary parts, at the middles of discs on the upper half of E.
    pub(super) legendre_there: [Vec<Row>; 2],
    pub(super) integral_there: [Vec<Row>; 2],
    /// The nodes.
    nodes: Row,
    /// The radius of the discs, which cover it: the distance from a middle along E is at most a π/64.
    pub(super) disc: f64,
    /// Bounds on E of |P_k|, |P_k′| and |∫_{−1} P_k|, and of the latter on [−1, 1].
    pub(super) most: Row,
    pub(super) most_slope: Row,
    pub(super) most_integral: Row,
    pub(super) most_integral_within: Row,
    /// What interpolation leaves, in units of a bound on E: with the best polynomial of degree 31, which is off by at
    /// most 2 ρ^-31/(ρ − 1) (L. N. Trefethen, "Approximation Theory and Approximation Practice", theorem 8.2), it is at
    /// most 1 + Λ times that.
    pub(super) interpolation: f64,
    /// What Gauss' rule leaves of an integral over [−1, 1]. It is exact to degree 63 and for odd functions, and the
    /// coefficient of T_k is at most 2 ρ^-k (theorem 8.1 there), of which the rule and the integral take at most
    /// 2 + 2/(k² − 1) each: 4.001 ρ^-64/(1 − ρ^-2) altogether.
    pub(super) quadrature: f64,
}

/// The tables, made once.
pub(super) static TABLES: LazyLock<Tables> = LazyLock::new(Tables::new);

/// A complex number.
type Complex = (Extended, Extended);

/// P_0 … P_n at a complex place, by (k + 1) P_{k+1} = (2k + 1) z P_k − k P_{k−1}.
fn legendre((x, y): Complex, n: usize) -> Vec<Complex> {
    let mut p = vec![(Extended::ONE, Extended::ZERO), (x, y)];
    for k in 1..n {
        let [twice, own, next] = [2 * k + 1, k, k + 1].map(|number| Extended::from(number as f64));
        let ((a, b), before) = (p[k], p[k - 1]);
        let product = (x * a - y * b, x * b + y * a);
        p.push(((twice * product.0 - own * before.0) / next, (twice * product.1 - own * before.1) / next));
    }
    p
}

/// ∫_{−1}^z P_k = (P_{k+1} − P_{k−1})/(2k + 1), and 1 + z for k = 0.
fn integral(p: &[Complex], k: usize) -> Complex {
    if k == 0 {
        return (Extended::ONE + p[1].0, p[1].1);
    }
    let by = Extended::from((2 * k + 1) as f64);
    ((p[k + 1].0 - p[k - 1].0) / by, (p[k + 1].1 - p[k - 1].1) / by)
}

/// Gauss' nodes from those to 30 digits, by Newton's method, which doubles the digits: P′ (1 − x²) = n (P_{n−1} − x
/// P_n).
fn gauss_nodes(rule: &Collocation) -> Vec<Extended> {
    let n = rule.points();
    let sharpened = |mut x: Extended| {
        for _ in 0..2 {
            let p = legendre((x, Extended::ZERO), n);
            let slope = Extended::from(n as f64) * (p[n - 1].0 - x * p[n].0) / (Extended::ONE - x * x);
            x -= p[n].0 / slope;
        }
        x
    };
    let nodes = rule.nodes.iter();
    nodes.map(|node| sharpened((Extended::from(node.high) + Extended::from(node.low)).mul2() - Extended::ONE)).collect()
}

/// Weights 2 (1 − x²)/(n P_{n−1}(x))².
fn gauss_weight(x: Extended, p: &[Complex], n: usize) -> Extended {
    let root = Extended::from(n as f64) * p[n - 1].0;
    Extended::from(2.0) * (Extended::ONE - x * x) / (root * root)
}

fn pairs(values: &[Extended]) -> Pairs {
    let hi: Row = std::array::from_fn(|i| values[i].to_f64());
    Pairs { hi, lo: std::array::from_fn(|i| (values[i] - Extended::from(hi[i])).to_f64()) }
}

/// Rows by node of a row by mode.
fn transposed<const N: usize>(rows: &[Vec<f64>]) -> Vec<[f64; N]> {
    (0..N).map(|j| std::array::from_fn(|k| rows[k][j])).collect()
}

impl Tables {
    fn new() -> Self {
        let [rule, few] = [LANES, FEW].map(|n| Collocation::shared(Family::Gauss, n));
        let nodes = gauss_nodes(rule);
        let at_nodes: Vec<_> = nodes.iter().map(|&x| legendre((x, Extended::ZERO), MODES)).collect();
        let at_few: Vec<_> = gauss_nodes(few).iter().map(|&x| legendre((x, Extended::ZERO), MODES)).collect();
        let column = |k: usize, of: &dyn Fn(&[Complex], usize) -> Complex| {
            pairs(&at_nodes.iter().map(|p| of(p, k).0).collect::<Vec<_>>())
        };
        let half_axes = [0.5 * (RHO + 1.0 / RHO), 0.5 * (RHO - 1.0 / RHO)];
        let at_discs: Vec<_> = (0..LANES)
            .map(|i| {
                let angle = PI * (i as f64 + 0.5) / LANES as f64;
                legendre(
                    (Extended::from(half_axes[0] * angle.cos()), Extended::from(half_axes[1] * angle.sin())),
                    MODES,
                )
            })
            .collect();
        let there = |of: &dyn Fn(&[Complex], usize) -> Complex, part: &dyn Fn(Complex) -> Extended| -> Vec<Row> {
            (0..MODES).map(|k| std::array::from_fn(|i| part(of(&at_discs[i], k)).to_f64())).collect()
        };
        let value = |p: &[Complex], k: usize| p[k];
        let of_modes =
            |rule: &Collocation| (0..rule.points()).map(|k| rule.mode(k).collect()).collect::<Vec<Vec<f64>>>();
        let most = |k: usize| 0.5 * (RHO.powi(k as i32) + RHO.powi(-(k as i32))) * UP;
        let slopes =
            |k: usize| (0..k).filter(|j| (k - j) % 2 == 1).map(|j| (2 * j + 1) as f64 * most(j)).sum::<f64>() * UP;
        let integral_of = |k: usize| match k {
            0 => (1.0 + half_axes[0]) * UP,
            _ => (most(k + 1) + most(k - 1)) / (2 * k + 1) as f64 * UP,
        };
        Self {
            integrals: (0..LANES).map(|j| std::array::from_fn(|i| rule.a[i * LANES + j].high)).collect(),
            few_integrals: (0..FEW).map(|j| std::array::from_fn(|i| few.a[i * FEW + j].high)).collect(),
            modes: transposed(&of_modes(rule)),
            few_modes: transposed(&of_modes(few)),
            legendre: (0..MODES).map(|k| column(k, &value)).collect(),
            integral: (0..MODES).map(|k| column(k, &integral)).collect(),
            few_integral: (0..MODES).map(|k| std::array::from_fn(|i| integral(&at_few[i], k).0.to_f64())).collect(),
            weights: std::array::from_fn(|i| gauss_weight(nodes[i], &at_nodes[i], LANES).to_f64()),
            legendre_there: [there(&value, &|z| z.0), there(&value, &|z| z.1)],
            integral_there: [there(&integral, &|z| z.0), there(&integral, &|z| z.1)],
            nodes: std::array::from_fn(|i| nodes[i].to_f64()),
            disc: half_axes[0] * PI / (2 * LANES) as f64 * UP,
            most: std::array::from_fn(most),
            most_slope: std::array::from_fn(slopes),
            most_integral: std::array::from_fn(integral_of),
            most_integral_within: std::array::from_fn(|k| 2.0 / (2 * k + 1) as f64 * UP),
            interpolation: (1.0 + LEBESGUE) * 2.0 * RHO.powi(1 - LANES as i32) / (RHO - 1.0) * UP,
            quadrature: 4.001 * RHO.powi(-2 * LANES as i32) / (1.0 - RHO.powi(-2)) * UP,
        }
    }

    /// The coefficients of P_k in the polynomial with these values at the nodes, but for rounding.
    #[inline(always)]
    pub(super) fn modes_of(&self, values: &Row) -> Row {
        let mut modes = [0.0; MODES];
        for (row, &value) in self.modes.iter().zip(values) {
            for k in 0..MODES {
                modes[k] += row[k] * value;
            }
        }
        modes
    }

    /// The same for the few nodes.
    #[inline(always)]
    pub(super) fn few_modes_of(&self, values: &FewRow) -> FewRow {
        let mut modes = [0.0; FEW];
        for (row, &value) in self.few_modes.iter().zip(values) {
            for k in 0..FEW {
                modes[k] += row[k] * value;
            }
        }
        modes
    }

    /// P_k for k < 20 on the nodes of the next window, which is `ratio` times as long.
    pub(super) fn continued(&self, ratio: f64) -> Vec<Row> {
        let place: Row = std::array::from_fn(|i| 1.0 + ratio * (1.0 + self.nodes[i]));
        let mut rows = vec![[1.0; LANES], place];
        for k in 1..19 {
            let [up, down] = [(2 * k + 1) as f64 / (k + 1) as f64, k as f64 / (k + 1) as f64];
            rows.push(std::array::from_fn(|i| up * place[i] * rows[k][i] - down * rows[k - 1][i]));
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64) -> Vec<Complex> {
        legendre((Extended::from(x), Extended::ZERO), MODES)
    }

    /// For every choice of signs p = Σ ±ℓ_j is at most Λ, so that |p′| ≤ 31² Λ (Markov). At most r away from a sample
    /// Σ |ℓ_j| is therefore at most that of the sample and 961 r Λ, and Λ ≤ (the largest sample)/(1 − 961 r).
    #[test]
    fn the_lebesgue_constant_is_bounded() {
        let (t, samples) = (&*TABLES, 10_000);
        let r = 0.5 / f64::from(samples);
        let mut largest = 0.0_f64;
        // Σ |ℓ_j| is even.
        for sample in 0..samples {
            let p = at(-1.0 + (2.0 * f64::from(sample) + 1.0) * r);
            let value = |j: usize| {
                let terms = (0..MODES).map(|k| (2 * k + 1) as f64 * t.legendre[k].hi[j] * p[k].0.to_f64());
                0.5 * t.weights[j] * terms.sum::<f64>()
            };
            largest = largest.max((0..LANES).map(|j| value(j).abs()).sum());
        }
        let bound = largest / (1.0 - 961.0 * r);
        assert!(bound < LEBESGUE && bound > 0.9 * LEBESGUE, "{bound}");
    }

    #[test]
    fn no_place_is_further_from_a_node() {
        let nodes = TABLES.nodes;
        let inner = nodes.windows(2).map(|pair| 0.5 * (pair[1] - pair[0]));
        let largest = inner.chain([1.0 + nodes[0], 1.0 - nodes[LANES - 1]]).fold(0.0, f64::max);
        assert!(largest < HALF_GAP && largest > 0.99 * HALF_GAP, "{largest}");
    }

    /// Gauss' rule integrates P_0 … P_63, and none of degree 64: nodes and weights are right to the last digit.
    #[test]
    fn nodes_and_weights_are_those_of_gauss() {
        let nodes = gauss_nodes(Collocation::shared(Family::Gauss, LANES));
        let p: Vec<_> = nodes.iter().map(|&x| legendre((x, Extended::ZERO), 2 * LANES)).collect();
        let integral_of = |k: usize| {
            let terms = (0..LANES).map(|i| gauss_weight(nodes[i], &p[i], LANES) * p[i][k].0);
            terms.fold(Extended::ZERO, |sum, term| sum + term).to_f64()
        };
        assert!((integral_of(0) - 2.0).abs() < 1e-15);
        assert!((1..2 * LANES).all(|k| integral_of(k).abs() < 1e-66) && integral_of(2 * LANES).abs() > 1e-3);
    }

    /// The bounds hold at each place on the ellipse, and are hardly larger than what they bound where it meets the real
    /// axis.
    #[test]
    fn polynomials_on_the_ellipse_are_bounded() {
        let t = &*TABLES;
        let end = at(0.5 * (RHO + 1.0 / RHO));
        for k in 0..MODES {
            let size = |[re, im]: &[Vec<Row>; 2], i: usize| re[k][i].hypot(im[k][i]);
            for i in 0..LANES {
                assert!(size(&t.legendre_there, i) <= t.most[k] && size(&t.integral_there, i) <= t.most_integral[k]);
            }
            assert!(end[k].0.to_f64() <= t.most[k] && end[k].0.to_f64() > 0.1 * t.most[k], "{k}");
            // P_k′(1) = k(k + 1)/2, and P_k′ grows outside.
            let slope =
                (0..k).filter(|j| (k - j) % 2 == 1).map(|j| (2 * j + 1) as f64 * end[j].0.to_f64()).sum::<f64>();
            assert!(slope >= (k * (k + 1) / 2) as f64 * (1.0 - 1e-12) && slope <= t.most_slope[k], "{k}");
        }
    }

    /// T_64 is the first of which the rule leaves anything, and 1/(x − a) with its pole on E the worst to interpolate.
    #[test]
    fn interpolation_and_quadrature_leave_less_than_their_bounds() {
        let t = &*TABLES;
        let [a, b] = [0.5 * (RHO + 1.0 / RHO), 1.001];
        // With the pole a little outside of E the function is at most 1/(pole − a) on it.
        let (pole, most) = (a * b, 1.0 / (a * b - a));
        let pole = Extended::from(pole);
        let nodes = gauss_nodes(Collocation::shared(Family::Gauss, LANES));
        let terms = nodes.iter().map(|&x| gauss_weight(x, &legendre((x, Extended::ZERO), LANES), LANES) / (pole - x));
        let sum = terms.fold(Extended::ZERO, |sum, term| sum + term);
        let exact = Real::ln((pole + Extended::ONE) / (pole - Extended::ONE));
        let left = (sum - exact).abs().to_f64();
        assert!(left <= t.quadrature * most && left > 1e-4 * t.quadrature * most, "{left} {}", t.quadrature * most);
        // 1 − Π (x − x_i)/Π (pole − x_i) interpolates (pole − x)·0 + …: what is left of 1/(pole − x) at x is
        // Π (x − x_i)/((pole − x) Π (pole − x_i)).
        let ratio =
            |x: Extended| nodes.iter().fold(Extended::ONE, |all, &node| all * (x - node) / (pole - node)) / (pole - x);
        let left = ratio(Extended::ONE).abs().to_f64();
        assert!(left <= t.interpolation * most && left > 1e-4 * t.interpolation * most, "{left}");
    }
}
