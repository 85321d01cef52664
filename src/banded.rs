//! Banded matrices and their LU factorisation with partial pivoting.
//!
//! The physical limit is a banded system of 2(N − 1) unknowns. No maintained pure-Rust crate offers a banded LU, and
//! a general sparse LU costs several times more here, so this small one is ours. Rows are contiguous, so the
//! elimination is a vector update.

use std::fmt;

/// A square matrix with `lower` sub- and `upper` super-diagonals, plus room for the fill-in that pivoting makes.
#[derive(Clone)]
pub struct BandedMatrix {
    order: usize,
    lower: usize,
    upper: usize,
    /// Row i holds the columns i − lower … i + upper + lower.
    data: Vec<f64>,
}

/// Elimination met a column without a usable pivot: the matrix is singular to working precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the banded matrix is singular at column {column}")]
pub struct Singular {
    /// Column without a pivot, from 0.
    pub column: usize,
}

impl BandedMatrix {
    /// The zero matrix of the given order and bandwidths.
    pub fn zeros(order: usize, lower: usize, upper: usize) -> Self {
        Self { order, lower, upper, data: vec![0.0; order * (2 * lower + upper + 1)] }
    }

    /// Number of rows.
    pub fn order(&self) -> usize {
        self.order
    }

    /// (sub-diagonals, super-diagonals).
    pub fn bandwidths(&self) -> (usize, usize) {
        (self.lower, self.upper)
    }

    fn width(&self) -> usize {
        2 * self.lower + self.upper + 1
    }

    fn in_band(&self, row: usize, column: usize) -> bool {
        row < self.order && column < self.order && column + self.lower >= row && column <= row + self.upper
    }

    /// Sets every entry to zero, keeping the storage.
    pub fn clear(&mut self) {
        self.data.fill(0.0);
    }

    /// Adds `value` to an entry.
    ///
    /// # Panics
    /// If (row, column) lies outside the band.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        assert!(self.in_band(row, column), "entry ({row}, {column}) is outside the band");
        let index = row * self.width() + column + self.lower - row;
        self.data[index] += value;
    }

    /// The entry at (row, column); zero outside the band.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        if self.in_band(row, column) { self.data[row * self.width() + column + self.lower - row] } else { 0.0 }
    }

    /// `self` times `x`.
    pub fn multiply(&self, x: &[f64]) -> Vec<f64> {
        (0..self.order)
            .map(|row| {
                let first = row.saturating_sub(self.lower);
                let last = (row + self.upper).min(self.order - 1);
                (first..=last).map(|column| self.get(row, column) * x[column]).sum()
            })
            .collect()
    }

    /// Factors P·A = L·U in place with partial pivoting, in O(order · lower · (lower + upper)).
    ///
    /// # Errors
    /// [`Singular`] if a pivot column holds nothing but zeros or a non-finite number.
    pub fn factor(mut self) -> Result<BandedLu, Singular> {
        let (n, lower) = (self.order, self.lower);
        let width = self.width();
        let reach = self.lower + self.upper;
        let mut pivots = vec![0_u32; n];
        for k in 0..n {
            let rows = lower.min(n - 1 - k);
            let at = |row: usize| row * width + k + lower - row;
            let offset = (0..=rows)
                .max_by(|&a, &b| self.data[at(k + a)].abs().total_cmp(&self.data[at(k + b)].abs()))
                .unwrap_or(0);
            let pivot = self.data[at(k + offset)];
            if pivot == 0.0 || !pivot.is_finite() {
                return Err(Singular { column: k });
            }
            pivots[k] = offset as u32;
            // Columns k … k + reach of row k and of the rows below it, as far as the matrix goes.
            let columns = reach.min(n - 1 - k) + 1;
            let (head, tail) = self.data.split_at_mut((k + 1) * width);
            let pivot_row = &mut head[k * width + lower..][..columns];
            if offset > 0 {
                let other = &mut tail[(offset - 1) * width + lower - offset..][..columns];
                pivot_row.swap_with_slice(other);
            }
            for i in 1..=rows {
                let row = &mut tail[(i - 1) * width + lower - i..][..columns];
                let factor = row[0] / pivot;
                row[0] = factor;
                if factor != 0.0 {
                    for (entry, above) in row[1..].iter_mut().zip(&pivot_row[1..]) {
                        *entry -= factor * above;
                    }
                }
            }
        }
        Ok(BandedLu { matrix: self, pivots })
    }
}

impl fmt::Debug for BandedMatrix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "BandedMatrix(order {}, lower {}, upper {})", self.order, self.lower, self.upper)
    }
}

/// The factors of a [`BandedMatrix`].
#[derive(Debug, Clone)]
pub struct BandedLu {
    matrix: BandedMatrix,
    /// Row k was exchanged with row k + pivots\[k\].
    pivots: Vec<u32>,
}

impl BandedLu {
    /// Overwrites the right-hand side `b` with the solution of A·x = b.
    pub fn solve_in_place(&self, b: &mut [f64]) {
        let m = &self.matrix;
        let (n, lower, width) = (m.order, m.lower, m.width());
        let reach = m.lower + m.upper;
        assert_eq!(b.len(), n, "right-hand side of a system of order {n}");
        for k in 0..n {
            b.swap(k, k + self.pivots[k] as usize);
            let value = b[k];
            for i in 1..=lower.min(n - 1 - k) {
                b[k + i] -= m.data[(k + i) * width + lower - i] * value;
            }
        }
        for k in (0..n).rev() {
            let columns = reach.min(n - 1 - k);
            let row = &m.data[k * width + lower..][..=columns];
            let sum: f64 = row[1..].iter().zip(&b[k + 1..]).map(|(u, x)| u * x).sum();
            b[k] = (b[k] - sum) / row[0];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn solves_like_a_dense_lu(n in 1_usize..30, lower in 0_usize..5, upper in 0_usize..5, seed in proptest::collection::vec(-1.0..1.0_f64, 400)) {
            let mut values = seed.iter().cycle();
            let mut banded = BandedMatrix::zeros(n, lower, upper);
            let mut dense = DMatrix::zeros(n, n);
            for row in 0..n {
                for column in row.saturating_sub(lower)..=(row + upper).min(n - 1) {
                    // No diagonal dominance: pivoting must do the work.
                    let value = *values.next().unwrap();
                    banded.add(row, column, value);
                    dense[(row, column)] = value;
                }
            }
            let b: Vec<f64> = (0..n).map(|_| *values.next().unwrap()).collect();
            prop_assume!(dense.clone().svd(false, false).singular_values.min() > 1e-6);
            let mut x = b.clone();
            banded.clone().factor().unwrap().solve_in_place(&mut x);
            let expected = dense.lu().solve(&DVector::from_vec(b.clone())).unwrap();
            for (got, want) in x.iter().zip(expected.iter()) {
                prop_assert!((got - want).abs() <= 1e-9 * (1.0 + want.abs()));
            }
            for (got, want) in banded.multiply(&x).iter().zip(&b) {
                prop_assert!((got - want).abs() <= 1e-9);
            }
        }
    }

    #[test]
    fn a_singular_matrix_is_reported() {
        let mut matrix = BandedMatrix::zeros(3, 1, 1);
        matrix.add(0, 0, 1.0);
        matrix.add(2, 2, 1.0);
        assert_eq!(matrix.factor().unwrap_err(), Singular { column: 1 });
    }
}
