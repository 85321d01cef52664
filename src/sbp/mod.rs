//! Summation-by-parts operators: finite differences on an equidistant grid, and spectral elements on
//! Gauss–Lobatto–Legendre nodes. Nothing in this module depends on physics.
//!
//! D = H⁻¹Q approximates d/dγ, H is a diagonal quadrature rule, and Q + Qᵀ = E_N − E_0 is the discrete form of
//! integration by parts: `(u, Dv)_H = u_N v_N − u_1 v_1 − (Du, v)_H`.
//!
//! ```
//! use geodesic_ivp::sbp::SbpName;
//!
//! for name in ["SBP21", "SBP42", "SBP63", "SBP84", "GLL17"] {
//!     let name = SbpName::try_from(name.to_owned())?;
//!     let d = name.operator::<f64>(17, 0.1)?;
//!     let line: Vec<f64> = (0..17).map(|k| 3.0 * d.node(k) + 1.0).collect();
//!     assert!(d.derivative(&line).iter().all(|slope| (slope - 3.0).abs() < 1e-11));
//!     assert!((d.integrate(&d.derivative(&line)) - (line[16] - line[0])).abs() < 1e-12);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod coefficients;
pub(crate) mod collocation;
pub mod gll;
pub(crate) mod legendre;
mod name;
pub(crate) mod polynomial;
mod regularised;
pub mod symbol;

pub use coefficients::Coefficients;
pub use name::SbpName;
pub use regularised::RegularisedOperator;

use std::iter;

use pulp::{Arch, Simd, WithSimd};

use self::coefficients::quotient;
use self::gll::LobattoRule;
use crate::number::{Real, sum};

/// A grid has fewer points than the operator's two boundary closures need, or another number than the spectral element
/// has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{operator} needs at least {minimum} points, got {points}")]
pub struct TooFewPoints {
    /// Name of the operator.
    pub operator: String,
    /// Points asked for.
    pub points: usize,
    /// Points needed.
    pub minimum: usize,
}

/// A diagonal-norm SBP first-derivative operator on N nodes. Applying it allocates nothing.
#[derive(Debug, Clone)]
pub struct SbpOperator<S = f64> {
    /// Mean spacing of the nodes, in units of γ.
    spacing: S,
    /// The first rows of D in units of 1/γ, `closure_width` columns each; the last ones are their mirror image with the
    /// other sign. Those of a spectral element are all rows.
    closure: Vec<S>,
    closure_width: usize,
    /// d_m of the interior stencil.
    interior: Vec<S>,
    /// Of a spectral element, the positions of the nodes from the first one.
    nodes: Vec<S>,
    /// Of a spectral element, D column by column, which is the order in which its application vectorises.
    columns: Vec<S>,
    /// Diagonal of H, length N, in units of γ.
    weights: Vec<S>,
    /// See [`SbpOperator::row_sum`].
    row_sum: f64,
}

/// The estimates of rounding were calibrated on SBP21 and SBP42, whose rows of |hD| sum to less than this.
const LEAST_ROW_SUM: f64 = 4.0;

impl<S: Real> SbpOperator<S> {
    /// The finite-difference operator for `points` nodes with the given `spacing` = Δγ.
    ///
    /// # Errors
    /// [`TooFewPoints`] if the closures do not fit.
    pub fn new(coefficients: &Coefficients, points: usize, spacing: S) -> Result<Self, TooFewPoints> {
        if points < coefficients.minimum_points {
            let operator = coefficients.name.to_owned();
            return Err(TooFewPoints { operator, points, minimum: coefficients.minimum_points });
        }
        let mut weights = vec![spacing; points];
        for (k, weight) in coefficients.norm.iter().enumerate() {
            weights[k] = quotient::<S>(weight) * spacing;
            weights[points - 1 - k] = weights[k];
        }
        let row_sums = coefficients.closure.iter().map(|row| row.iter().map(|c| quotient::<f64>(c).abs()).sum());
        let width = coefficients.closure.iter().map(|row| row.len()).max().unwrap_or(0);
        let closure = coefficients.closure.iter().flat_map(|row| row.iter().chain(iter::repeat(&(0, 1))).take(width));
        Ok(Self {
            spacing,
            closure: closure.map(|c| quotient::<S>(c) / spacing).collect(),
            closure_width: width,
            interior: coefficients.interior.iter().map(|c| quotient::<S>(c) / spacing).collect(),
            nodes: Vec::new(),
            columns: Vec::new(),
            weights,
            row_sum: row_sums.fold(LEAST_ROW_SUM, f64::max),
        })
    }

    /// The spectral element of `points` Gauss–Lobatto–Legendre nodes over the given `length` of γ.
    pub fn gauss_lobatto(points: usize, length: S) -> Self {
        let rule = LobattoRule::new(points);
        let scale = (S::ONE + S::ONE) / length;
        let matrix: Vec<S> = rule.differentiation.iter().map(|&d| scale * d).collect();
        let spacing = length / S::from((points - 1) as f64);
        let row_sums = matrix.chunks_exact(points).map(|row| sum(row.iter().map(|d| d.abs())) * spacing);
        Self {
            spacing,
            weights: rule.weights.iter().map(|&w| length.half() * w).collect(),
            row_sum: row_sums.fold(LEAST_ROW_SUM, |largest, row| largest.max(row.to_f64())),
            closure: matrix[..points.div_ceil(2) * points].to_vec(),
            closure_width: points,
            interior: Vec::new(),
            nodes: rule.nodes.iter().map(|&x| length.half() * (x + S::ONE)).collect(),
            columns: (0..points * points).map(|k| matrix[k % points * points + k / points]).collect(),
        }
    }

    /// Number of nodes N.
    pub fn points(&self) -> usize {
        self.weights.len()
    }

    /// Node spacing h = Δγ; for a spectral element the mean spacing.
    pub fn spacing(&self) -> S {
        self.spacing
    }

    /// Returns true if all intervals between nodes are equal.
    pub fn is_equidistant(&self) -> bool {
        self.nodes.is_empty()
    }

    /// γ at node k minus γ at the first node.
    pub fn node(&self, k: usize) -> S {
        if self.is_equidistant() { S::from(k as f64) * self.spacing } else { self.nodes[k] }
    }

    /// The largest Σ_j |hD_kj| over the rows k, but at least 4. By this factor hDu amplifies the rounding of u.
    pub fn row_sum(&self) -> f64 {
        self.row_sum
    }

    /// [`Self::row_sum`] relative to that of the operators of low order: 1 for SBP21 and SBP42.
    pub fn stiffness(&self) -> f64 {
        self.row_sum / LEAST_ROW_SUM
    }

    /// Diagonal of the norm H: quadrature weights in units of γ, length N.
    pub fn weights(&self) -> &[S] {
        &self.weights
    }

    /// Number of rows at each end that may differ from the interior stencil.
    pub fn closure_rows(&self) -> usize {
        (self.closure.len() / self.closure_width).min(self.points() / 2)
    }

    /// Returns true if every row reaches only the neighbouring nodes, so that Du = f is an explicit two-step recursion
    /// (SBP21).
    pub fn is_two_step(&self) -> bool {
        self.closure_width == 2 && self.is_equidistant()
    }

    /// Number of rows at the end of D that have an entry for node N. A deviation at node N alone shows in these rows
    /// when D is applied again. They are 2, 4, 6 and 8 for SBP21, SBP42, SBP63 and SBP84, and all of them for a
    /// spectral element.
    pub fn rows_reaching_last_node(&self) -> usize {
        let n = self.points();
        let reaches = |k: &usize| self.row(*k).any(|(column, _)| column == n - 1);
        (0..n).rev().take_while(reaches).count()
    }

    /// The nonzero entries of row k of D as (column, coefficient), in units of 1/γ.
    ///
    /// # Panics
    /// If k ≥ N.
    pub fn row(&self, k: usize) -> impl Iterator<Item = (usize, S)> + '_ {
        let n = self.points();
        assert!(k < n, "row {k} of an operator on {n} points");
        // A row is part of the left closure, of the interior stencil or of the right closure. To have one type of
        // iterator for all of them, the parts that a row does not have are empty.
        let (width, s) = (self.closure_width, self.closure.len() / self.closure_width);
        let closure = |i: usize| &self.closure[i * width..][..width];
        let (left, middle, right): (&[S], &[S], &[S]) = match k {
            _ if k < s => (closure(k), &[], &[]),
            _ if k >= n - s => (&[], &[], closure(n - 1 - k)),
            _ => (&[], &self.interior, &[]),
        };
        let left = left.iter().enumerate().map(|(j, &c)| (j, c));
        let below = middle.iter().enumerate().rev().map(move |(m, &c)| (k - m - 1, -c));
        let above = middle.iter().enumerate().map(move |(m, &c)| (k + m + 1, c));
        let right = right.iter().enumerate().rev().map(move |(j, &c)| (n - 1 - j, -c));
        left.chain(below).chain(above).chain(right).filter(|&(_, c)| c != S::ZERO)
    }

    /// Writes D `u` into `out`; both have length N.
    pub fn apply(&self, u: &[S], out: &mut [S]) {
        let n = self.points();
        assert!(u.len() == n && out.len() == n, "vectors must have the operator's {n} points");
        if !self.is_equidistant() {
            // Uses the widest vector instructions of the machine.
            return Arch::new().dispatch(DenseProduct { columns: &self.columns, u, out });
        }
        for (k, row) in self.closure.chunks_exact(self.closure_width).enumerate() {
            out[k] = sum(row.iter().zip(u).map(|(&c, &v)| c * v));
            out[n - 1 - k] = -sum(row.iter().zip(u.iter().rev()).map(|(&c, &v)| c * v));
        }
        let s = self.closure_rows();
        let inner = &mut out[s..n - s];
        match *self.interior {
            [d1] => interior_stencil([d1], u, s, inner),
            [d1, d2] => interior_stencil([d1, d2], u, s, inner),
            [d1, d2, d3] => interior_stencil([d1, d2, d3], u, s, inner),
            [d1, d2, d3, d4] => interior_stencil([d1, d2, d3, d4], u, s, inner),
            _ => unreachable!("no interior stencil of half-width {}", self.interior.len()),
        }
    }

    /// D `u` in a new vector.
    pub fn derivative(&self, u: &[S]) -> Vec<S> {
        let mut out = vec![S::ZERO; u.len()];
        self.apply(u, &mut out);
        out
    }

    /// (D `u`)_k.
    ///
    /// # Panics
    /// If k ≥ N.
    pub fn derivative_at(&self, u: &[S], k: usize) -> S {
        sum(self.row(k).map(|(column, d)| d * u[column]))
    }

    /// Writes Dᵀ H `v` into `out`, by summation by parts: DᵀH = −HD + E_N − E_0.
    pub fn apply_transpose_weighted(&self, v: &[S], out: &mut [S]) {
        self.apply(v, out);
        for (o, &weight) in out.iter_mut().zip(&self.weights) {
            *o *= -weight;
        }
        let last = v.len() - 1;
        out[0] -= v[0];
        out[last] += v[last];
    }

    /// ∫ u dγ by the operator's own quadrature, 1ᵀ H u.
    pub fn integrate(&self, u: &[S]) -> S {
        sum(self.weights.iter().zip(u).map(|(&weight, &v)| weight * v))
    }
}

/// Writes D`u` into `out`, for D stored by columns.
///
/// A type and not a closure: pulp calls a closure that borrows through a function that is not inlined, and what is not
/// inlined is compiled without the instructions of the machine.
struct DenseProduct<'a, S> {
    columns: &'a [S],
    u: &'a [S],
    out: &'a mut [S],
}

impl<S: Real> WithSimd for DenseProduct<'_, S> {
    type Output = ();

    #[inline(always)]
    fn with_simd<A: Simd>(self, _: A) {
        let Self { columns, u, out } = self;
        let mut first = 0;
        let rest = blocks_of_rows::<S, 8>(columns, u, &mut first, out);
        let rest = blocks_of_rows::<S, 4>(columns, u, &mut first, rest);
        blocks_of_rows::<S, 1>(columns, u, &mut first, rest);
    }
}

/// Computes as many blocks of B rows as fit into `out`, beginning with row `first`. Returns the rest of `out`.
#[inline(always)]
fn blocks_of_rows<'o, S: Real, const B: usize>(
    columns: &[S],
    u: &[S],
    first: &mut usize,
    out: &'o mut [S],
) -> &'o mut [S] {
    let (blocks, rest) = out.as_chunks_mut::<B>();
    for block in blocks {
        *block = block_of_rows(columns, u, *first);
        *first += B;
    }
    rest
}

/// Rows `first` … `first` + B − 1 of D`u`. As the entries of a row of D sum to zero, they can be applied to differences
/// of u, which loses less to rounding than its values.
#[inline(always)]
fn block_of_rows<S: Real, const B: usize>(columns: &[S], u: &[S], first: usize) -> [S; B] {
    let here = &u[first..first + B];
    let mut sum = [S::ZERO; B];
    for (k, &v) in u.iter().enumerate() {
        let column = &columns[k * u.len() + first..][..B];
        for i in 0..B {
            sum[i] += column[i] * (v - here[i]);
        }
    }
    sum
}

/// Writes rows s, s + 1, … of the antisymmetric interior stencil. The half-width P is a constant so that the loop
/// vectorises.
fn interior_stencil<S: Real, const P: usize>(d: [S; P], u: &[S], s: usize, out: &mut [S]) {
    let count = out.len();
    let above: [&[S]; P] = std::array::from_fn(|m| &u[s + m + 1..][..count]);
    let below: [&[S]; P] = std::array::from_fn(|m| &u[s - m - 1..][..count]);
    for (k, o) in out.iter_mut().enumerate() {
        let mut sum = S::ZERO;
        for m in 0..P {
            sum += d[m] * (above[m][k] - below[m][k]);
        }
        *o = sum;
    }
}
