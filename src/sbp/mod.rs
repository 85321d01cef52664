//! Summation-by-parts operators on an equidistant grid. They know nodes and weights, and no physics.
//!
//! D = H⁻¹Q approximates d/dγ, H is a diagonal quadrature rule, and Q + Qᵀ = E_N − E_0 is the discrete form of
//! integration by parts: `(u, Dv)_H = u_N v_N − u_1 v_1 − (Du, v)_H`.

pub mod coefficients;
mod regularised;

pub use coefficients::Coefficients;
pub use regularised::RegularisedOperator;

use crate::banded::BandedMatrix;
use crate::scalar::{Real, sum};

/// A grid has fewer points than the operator's two boundary closures need.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{operator} needs at least {minimum} points, got {points}")]
pub struct TooFewPoints {
    /// Name of the operator.
    pub operator: &'static str,
    /// Points asked for.
    pub points: usize,
    /// Points needed.
    pub minimum: usize,
}

/// A diagonal-norm SBP first-derivative operator on N nodes of spacing h. Applying it allocates nothing.
#[derive(Debug, Clone)]
pub struct SbpOperator<S = f64> {
    spacing: S,
    /// Closure rows divided by h, row-major, `closure_width` columns each.
    closure: Vec<S>,
    closure_width: usize,
    /// d_m / h of the interior stencil.
    interior: Vec<S>,
    /// Diagonal of H, length N, in units of γ.
    weights: Vec<S>,
}

impl<S: Real> SbpOperator<S> {
    /// Builds the operator for `points` nodes with the given `spacing` = Δγ.
    ///
    /// # Errors
    /// [`TooFewPoints`] if the closures do not fit.
    pub fn new(coefficients: &Coefficients, points: usize, spacing: S) -> Result<Self, TooFewPoints> {
        if points < coefficients.minimum_points {
            return Err(TooFewPoints { operator: coefficients.name, points, minimum: coefficients.minimum_points });
        }
        let mut weights = vec![spacing; points];
        for (k, weight) in coefficients.norm.iter().enumerate() {
            weights[k] = weight.to_real::<S>() * spacing;
            weights[points - 1 - k] = weights[k];
        }
        Ok(Self {
            spacing,
            closure: coefficients
                .closure
                .iter()
                .flat_map(|row| row.iter())
                .map(|c| c.to_real::<S>() / spacing)
                .collect(),
            closure_width: coefficients.closure[0].len(),
            interior: coefficients.interior.iter().map(|c| c.to_real::<S>() / spacing).collect(),
            weights,
        })
    }

    /// Number of nodes N.
    pub fn points(&self) -> usize {
        self.weights.len()
    }

    /// Node spacing h = Δγ.
    pub fn spacing(&self) -> S {
        self.spacing
    }

    /// Diagonal of the norm H: quadrature weights in units of γ, length N.
    pub fn weights(&self) -> &[S] {
        &self.weights
    }

    /// Number of boundary rows that differ from the interior stencil, at each end.
    pub fn closure_rows(&self) -> usize {
        self.closure.len() / self.closure_width
    }

    /// Whether every row couples at most its two neighbours, so that Du = f is an explicit two-step recursion (SBP21).
    pub fn is_two_step(&self) -> bool {
        self.closure_width == 2 && self.interior.len() == 1
    }

    /// Number of last rows of D from the first one that reaches node N: where a deviation confined to node N shows
    /// after another application of D (2 for SBP21, 4 for SBP42).
    pub fn rows_reaching_last_node(&self) -> usize {
        let n = self.points();
        let reaches = |k: &usize| self.row(*k).any(|(column, _)| column == n - 1);
        (0..n).rev().take_while(reaches).count()
    }

    /// (column, coefficient) of row k of D, in units of 1/γ.
    ///
    /// # Panics
    /// If k ≥ N.
    pub fn row(&self, k: usize) -> impl Iterator<Item = (usize, S)> + '_ {
        let n = self.points();
        assert!(k < n, "row {k} of an operator on {n} points");
        let s = self.closure_rows();
        let width = self.closure_width;
        let closure = |i: usize| &self.closure[i * width..(i + 1) * width];
        // Three kinds of row, one iterator type: (slice, first column, step, sign) describes each.
        let (left, middle, right) = match k {
            _ if k < s => (closure(k), [].as_slice(), [].as_slice()),
            _ if k >= n - s => ([].as_slice(), [].as_slice(), closure(n - 1 - k)),
            _ => ([].as_slice(), self.interior.as_slice(), [].as_slice()),
        };
        let left = left.iter().enumerate().map(|(j, &c)| (j, c));
        let below = middle.iter().enumerate().rev().map(move |(m, &c)| (k - m - 1, -c));
        let above = middle.iter().enumerate().map(move |(m, &c)| (k + m + 1, c));
        let right = right.iter().enumerate().rev().map(move |(j, &c)| (n - 1 - j, -c));
        left.chain(below).chain(above).chain(right).filter(|&(_, c)| c != S::ZERO)
    }

    /// `out` = D `u`; both of length N.
    pub fn apply(&self, u: &[S], out: &mut [S]) {
        let n = self.points();
        assert!(u.len() == n && out.len() == n, "vectors must have the operator's {n} points");
        let s = self.closure_rows();
        for (k, row) in self.closure.chunks_exact(self.closure_width).enumerate() {
            out[k] = sum(row.iter().zip(u).map(|(&c, &v)| c * v));
            out[n - 1 - k] = -sum(row.iter().zip(u.iter().rev()).map(|(&c, &v)| c * v));
        }
        let inner = &mut out[s..n - s];
        match self.interior.as_slice() {
            &[d1] => interior_stencil([d1], u, s, inner),
            &[d1, d2] => interior_stencil([d1, d2], u, s, inner),
            other => unreachable!("no interior stencil of half-width {}", other.len()),
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

    /// `out` = Dᵀ H `v`, by summation by parts: DᵀH = −HD + E_N − E_0.
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

impl SbpOperator {
    /// D as a banded N × N matrix.
    pub fn to_banded(&self) -> BandedMatrix {
        let n = self.points();
        let reach = self.closure_width.saturating_sub(1).max(self.interior.len());
        let mut matrix = BandedMatrix::zeros(n, reach, reach);
        for k in 0..n {
            for (column, value) in self.row(k) {
                matrix.add(k, column, value);
            }
        }
        matrix
    }
}

/// Rows s, s+1, … of the antisymmetric interior stencil; the half-width is a constant so that the loop vectorises.
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
