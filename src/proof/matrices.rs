//! The adjoint matrix B, its defect E and its inverse A over a window.
//!
//! B = I + ∫W with a matrix polynomial W of exact coefficients. Matrices are lists of d × d entries, row by row. What
//! underflow takes from an entry, d 2^-1074 at most, is less than what is added to all that these bounds multiply.

use super::algebras::{Discs, LANES, Row};
use super::approximate::combined;
use super::ellipse::Bounds;
use super::equations::Equations;
use super::tables::{FewRow, HALF_GAP, LEBESGUE, TABLES, UP};
use crate::number::norm::larger;

/// Sums of so many terms, each a product of two rounded numbers, are off by less, relative to Σ |terms|.
fn rounding(terms: usize) -> f64 {
    (terms + 8) as f64 * f64::EPSILON
}

/// Rounds of the search for a bound of A.
const MOST_ROUNDS: usize = 60;

/// An inverse that misses by more has lost digits, and is computed once more with pivots.
const MOST_MISSED: f64 = 1e-10;

/// Bounds of matrices over a window.
pub(super) struct Matrices {
    pub(super) d: usize,
    /// B at the nodes, and a bound of what its entries are off by.
    pub(super) b: Vec<Row>,
    pub(super) slack: Vec<f64>,
    /// Bounds of |B|, |E| and |A| on the window, and of |B| on the ellipse.
    pub(super) b_most: Vec<f64>,
    pub(super) e_most: Vec<f64>,
    pub(super) a_most: Vec<f64>,
    pub(super) b_there: Vec<f64>,
    /// An approximate inverse of B at the end, and a bound of |I − A B|.
    pub(super) a_end: Vec<f64>,
    pub(super) miss: Vec<f64>,
}

/// B and W at the nodes, and their bounds.
struct Polynomials {
    b: Vec<Row>,
    w: Vec<Row>,
    slack: Vec<f64>,
    w_slack: Vec<f64>,
    b_most: Vec<f64>,
    w_most: Vec<f64>,
    b_there: Vec<f64>,
    w_there: Vec<f64>,
    b_end: Vec<f64>,
}

/// 1 on the diagonal.
fn one(at: usize, d: usize) -> f64 {
    f64::from(u8::from(at.is_multiple_of(d + 1)))
}

impl Polynomials {
    #[inline(always)]
    fn new(d: usize, h: f64, coefficients: &[FewRow]) -> Self {
        let half = 0.5 * h;
        let sized =
            |at: usize, most: &Row| coefficients[at].iter().zip(most).map(|(c, most)| c.abs() * most).sum::<f64>() * UP;
        let sizes = |most: &Row| (0..d * d).map(|at| sized(at, most)).collect::<Vec<f64>>();
        let with_one =
            |sizes: Vec<f64>| (0..d * d).map(|at| (one(at, d) + half * sizes[at]) * UP).collect::<Vec<f64>>();
        // Loops, and no closures: what is not inlined has a call for each fused multiplication.
        let few = coefficients[0].len();
        let (mut values, mut integrals) = (vec![[0.0; LANES]; few], vec![[0.0; LANES]; few]);
        for k in 0..few {
            (values[k], integrals[k]) = (TABLES.legendre[k].hi, TABLES.integral[k].hi);
        }
        let (mut b, mut w) = (vec![[0.0; LANES]; d * d], vec![[0.0; LANES]; d * d]);
        for at in 0..d * d {
            let way = combined(&integrals, coefficients[at].iter().map(|c| half * c));
            b[at] = way.map(|way| one(at, d) + way);
            w[at] = combined(&values, coefficients[at].iter().copied());
        }
        let b_most = with_one(sizes(&TABLES.most_integral_within));
        let w_most = sizes(&[1.0; LANES]);
        // P_0 alone has an integral over the window.
        let b_end = (0..d * d).map(|at| one(at, d) + h * coefficients[at][0]).collect();
        Self {
            b,
            w,
            slack: b_most.iter().map(|most| rounding(16) * most).collect(),
            w_slack: w_most.iter().map(|most| rounding(16) * most).collect(),
            b_there: with_one(sizes(&TABLES.most_integral)),
            w_there: sizes(&TABLES.most),
            b_most,
            w_most,
            b_end,
        }
    }
}

impl Matrices {
    /// For W with these coefficients, the entries of J at the nodes, and bounds on the ellipse. `None` if no bound of A
    /// is found.
    #[inline(always)]
    pub(super) fn new(
        equations: &Equations<'_>,
        h: f64,
        coefficients: &[FewRow],
        jacobian: &[Discs],
        bounds: &Bounds,
    ) -> Option<Self> {
        let d = equations.unknowns;
        let of = Polynomials::new(d, h, coefficients);
        let e_most = adjoint_defect(equations, &of, jacobian, bounds);
        let a_most = inverse_bound(d, h, &of)?;
        let a_end = inverse(&of.b_end, d)?;
        let miss = missed(&a_end, &of.b_end, &of.slack, d);
        Some(Self { d, e_most, a_most, a_end, miss, b: of.b, slack: of.slack, b_most: of.b_most, b_there: of.b_there })
    }
}

/// A bound of |E| = |W + B J| on the window: Λ times that at the nodes, and what interpolation leaves.
#[inline(always)]
fn adjoint_defect(equations: &Equations<'_>, of: &Polynomials, jacobian: &[Discs], bounds: &Bounds) -> Vec<f64> {
    let d = equations.unknowns;
    let mut columns: Vec<Vec<usize>> = vec![Vec::new(); equations.active];
    equations.entries.iter().enumerate().for_each(|(place, entry)| columns[entry.column].push(place));
    let mut e_most = vec![0.0; d * d];
    for i in 0..d {
        for (c, places) in columns.iter().enumerate() {
            let at = i * d + c;
            // A sum that begins with W rounds a part of |W|, too.
            let of_w = of.w_slack[at] + rounding(d) * of.w_most[at];
            let (mut sum, mut room, mut there) = (of.w[at], [of_w; LANES], of.w_there[at]);
            for &place in places {
                let (row, discs) = (i * d + equations.entries[place].row, &jacobian[place]);
                let (b, slack) = (&of.b[row], of.slack[row]);
                for k in 0..LANES {
                    sum[k] = b[k].mul_add(discs.re[k], sum[k]);
                    let size = discs.re[k].abs() + discs.rad[k];
                    room[k] += b[k].abs() * (discs.rad[k] + rounding(d) * size) + slack * size;
                }
                there += of.b_there[row] * bounds.jacobian[place];
            }
            let most = (0..LANES).fold(0.0, |most, k| larger(most, sum[k].abs() + room[k]));
            e_most[at] = (LEBESGUE * most + TABLES.interpolation * there) * UP;
        }
    }
    e_most
}

/// A bound of |A| = |B⁻¹| on the window. At distances of at most half a gap from a node B differs from that at the node
/// by |Δ| ≤ (h/2) (gap/2) |W|, and with any matrix A_i, from A_i B = I − (I − A_i B_i) + A_i Δ follows |A| ≤ |A_i| +
/// X |A| with X = |I − A_i B_i| + |A_i| |Δ|. Any bound with max |A_i| + X bound ≤ bound will do: it is above all
/// partial sums of Σ Xⁿ max |A_i|, and as no row of max |A_i| is zero, Xⁿ tends to zero (Collatz and Wielandt).
#[inline(always)]
fn inverse_bound(d: usize, h: f64, of: &Polynomials) -> Option<Vec<f64>> {
    let a = inverses(&of.b, d);
    let miss = misses(&a, &of.b, &of.slack, d);
    let (mut a_nodes, mut x) = (vec![0.0; d * d], vec![0.0; d * d]);
    for k in 0..LANES {
        // Elimination without pivots may have met a zero.
        let is_good = miss.iter().all(|miss| miss[k] < MOST_MISSED);
        let (a, miss) = if is_good {
            (a.iter().map(|row| row[k]).collect(), miss.iter().map(|row| row[k]).collect())
        } else {
            let b: Vec<f64> = of.b.iter().map(|row| row[k]).collect();
            let a = inverse(&b, d)?;
            let miss = missed(&a, &b, &of.slack, d);
            (a, miss)
        };
        for at in 0..d * d {
            a_nodes[at] = larger(a_nodes[at], f64::abs(a[at]));
            x[at] = larger(x[at], miss[at]);
        }
    }
    let near = product(&a_nodes, &of.w_most, d);
    x.iter_mut().zip(near).for_each(|(x, near)| *x = (*x + 0.5 * h * HALF_GAP * near * UP) * UP);
    let has_rows = (0..d).all(|i| a_nodes[i * d..][..d].iter().any(|a| *a > 0.0));
    let mut bound = a_nodes.clone();
    for _ in 0..MOST_ROUNDS {
        let next: Vec<f64> =
            product(&x, &bound, d).iter().zip(&a_nodes).map(|(more, a)| (a + more * UP) * UP).collect();
        if has_rows && next.iter().zip(&bound).all(|(next, bound)| next <= bound) {
            return Some(bound);
        }
        // A comparison that is false for NaN. A body without mass has entries beyond 1e90.
        let is_finite = next.iter().all(|next| *next < f64::MAX);
        if !is_finite {
            return None;
        }
        bound = next.iter().map(|next| next * 1.02).collect();
    }
    None
}

/// The inverses of matrices side by side, but for rounding, where elimination needs no pivots.
#[inline(always)]
fn inverses(b: &[Row], d: usize) -> Vec<Row> {
    let (mut left, mut a) = (b.to_vec(), vec![[0.0; LANES]; d * d]);
    for i in 0..d {
        a[i * (d + 1)] = [1.0; LANES];
    }
    for c in 0..d {
        let inverse = left[c * (d + 1)].map(|pivot| 1.0 / pivot);
        for rows in [&mut left, &mut a] {
            for k in 0..d {
                for lane in 0..LANES {
                    rows[c * d + k][lane] *= inverse[lane];
                }
            }
        }
        for i in 0..d {
            let factor = left[i * d + c];
            if i == c || factor == [0.0; LANES] {
                continue;
            }
            for rows in [&mut left, &mut a] {
                for k in 0..d {
                    let own = rows[c * d + k];
                    for lane in 0..LANES {
                        rows[i * d + k][lane] -= factor[lane] * own[lane];
                    }
                }
            }
        }
    }
    a
}

/// [`missed`] of matrices side by side.
#[inline(always)]
fn misses(a: &[Row], b: &[Row], slack: &[f64], d: usize) -> Vec<Row> {
    let mut misses = vec![[0.0; LANES]; d * d];
    for i in 0..d {
        for k in 0..d {
            let ideal = one(i * d + k, d);
            let (mut sum, mut room, mut of_slack) = ([ideal; LANES], [ideal; LANES], [0.0; LANES]);
            for l in 0..d {
                let (a, b, slack) = (&a[i * d + l], &b[l * d + k], slack[l * d + k]);
                for lane in 0..LANES {
                    let term = a[lane] * b[lane];
                    sum[lane] -= term;
                    room[lane] += term.abs();
                    of_slack[lane] += a[lane].abs() * slack;
                }
            }
            for lane in 0..LANES {
                misses[i * d + k][lane] = (sum[lane].abs() + rounding(d) * room[lane] + of_slack[lane]) * UP;
            }
        }
    }
    misses
}

/// |I − A B|, where B is off by `slack`.
fn missed(a: &[f64], b: &[f64], slack: &[f64], d: usize) -> Vec<f64> {
    let mut missed = vec![0.0; d * d];
    for i in 0..d {
        for k in 0..d {
            let (mut sum, mut room) = (one(i * d + k, d), one(i * d + k, d));
            let mut of_slack = 0.0;
            for l in 0..d {
                let term = a[i * d + l] * b[l * d + k];
                sum -= term;
                room += term.abs();
                of_slack += a[i * d + l].abs() * slack[l * d + k];
            }
            missed[i * d + k] = (sum.abs() + rounding(d) * room + of_slack) * UP;
        }
    }
    missed
}

/// A product of matrices.
#[inline(always)]
pub(super) fn product(a: &[f64], b: &[f64], d: usize) -> Vec<f64> {
    let mut c = vec![0.0; d * d];
    for i in 0..d {
        for l in 0..d {
            let factor = a[i * d + l];
            if factor != 0.0 {
                for k in 0..d {
                    c[i * d + k] += factor * b[l * d + k];
                }
            }
        }
    }
    c
}

/// The inverse, by elimination with pivots, but for rounding.
pub(super) fn inverse(matrix: &[f64], d: usize) -> Option<Vec<f64>> {
    let width = 2 * d;
    let mut rows = vec![0.0; d * width];
    for i in 0..d {
        rows[i * width..][..d].copy_from_slice(&matrix[i * d..][..d]);
        rows[i * width + d + i] = 1.0;
    }
    for c in 0..d {
        let pivot = (c..d).max_by(|a, b| rows[a * width + c].abs().total_cmp(&rows[b * width + c].abs()))?;
        let value = rows[pivot * width + c];
        if value == 0.0 || !value.is_finite() {
            return None;
        }
        (0..width).for_each(|k| rows.swap(c * width + k, pivot * width + k));
        rows[c * width..][..width].iter_mut().for_each(|entry| *entry /= value);
        let own = rows[c * width..][..width].to_vec();
        for i in (0..d).filter(|&i| i != c) {
            let factor = rows[i * width + c];
            if factor != 0.0 {
                rows[i * width..][..width].iter_mut().zip(&own).for_each(|(entry, own)| *entry -= factor * own);
            }
        }
    }
    Some((0..d * d).map(|at| rows[(at / d) * width + d + at % d]).collect())
}

/// Σ_k M_ik v_k, rounded up, for what is not negative.
pub(super) fn applied(matrix: &[f64], vector: &[f64]) -> Vec<f64> {
    let row = |row: &[f64]| row.iter().zip(vector).map(|(m, v)| m * v).sum::<f64>() * UP;
    matrix.chunks_exact(vector.len()).map(row).collect()
}

#[cfg(test)]
mod tests;
