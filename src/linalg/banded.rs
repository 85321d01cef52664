//! Banded matrices, and banded linear systems in a single pass.
//!
//! The physical limit is a banded system of 2(N − 1) unknowns. No maintained pure-Rust crate offers a banded solver,
//! and a general sparse LU costs several times more here; hence this small one. Every system is solved only once, so
//! nothing is kept but the rows of U, each without its trailing zeros: at a million nodes, memory traffic dominates the
//! cost.
//!
//! ```
//! use geodesic_ivp::linalg::banded::BandedMatrix;
//!
//! let mut matrix = BandedMatrix::zeros(3, 1, 1);
//! for k in 0..3 {
//!     matrix.add(k, k, 2.0);
//! }
//! matrix.add(0, 1, -1.0);
//! matrix.add(2, 1, -1.0);
//! let mut b = matrix.multiply(&[1.0, 2.0, 3.0]);
//! matrix.solve_in_place(&mut b)?;
//! assert_eq!(b, [1.0, 2.0, 3.0]);
//! # Ok::<(), geodesic_ivp::linalg::banded::Singular>(())
//! ```

use pulp::{Simd, WithSimd};

use crate::number::vector::Level;

/// A square matrix with `lower` sub-diagonals and `upper` super-diagonals.
#[derive(Debug, Clone, PartialEq)]
pub struct BandedMatrix {
    order: usize,
    lower: usize,
    upper: usize,
    /// Row i holds the columns i − lower … i + upper.
    data: Vec<f64>,
}

/// Elimination met a column without a usable pivot: the matrix is singular to working precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the matrix is singular at column {column}")]
pub struct Singular {
    /// Column without a pivot, from 0.
    pub column: usize,
}

impl BandedMatrix {
    /// The zero matrix of the given order and bandwidths.
    pub fn zeros(order: usize, lower: usize, upper: usize) -> Self {
        Self { order, lower, upper, data: vec![0.0; order * (lower + upper + 1)] }
    }

    /// Number of rows.
    pub fn order(&self) -> usize {
        self.order
    }

    /// The numbers of sub-diagonals and of super-diagonals.
    pub fn bandwidths(&self) -> (usize, usize) {
        (self.lower, self.upper)
    }

    fn index(&self, row: usize, column: usize) -> Option<usize> {
        let inside =
            row < self.order && column < self.order && column + self.lower >= row && column <= row + self.upper;
        inside.then(|| row * (self.lower + self.upper + 1) + column + self.lower - row)
    }

    /// Adds `value` to an entry.
    ///
    /// # Panics
    /// If (row, column) lies outside the band.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        let index = self.index(row, column).unwrap_or_else(|| panic!("entry ({row}, {column}) is outside the band"));
        self.data[index] += value;
    }

    /// The entry at (row, column); zero outside the band.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        self.index(row, column).map_or(0.0, |index| self.data[index])
    }

    /// The product of the matrix and `x`, which has one entry per row.
    pub fn multiply(&self, x: &[f64]) -> Vec<f64> {
        (0..self.order)
            .map(|row| {
                let first = row.saturating_sub(self.lower);
                let last = (row + self.upper).min(self.order - 1);
                (first..=last).map(|column| self.get(row, column) * x[column]).sum()
            })
            .collect()
    }

    /// Overwrites `b` with the solution of A·x = b.
    ///
    /// # Errors
    /// [`Singular`] if the matrix is singular to working precision.
    pub fn solve_in_place(&self, b: &mut [f64]) -> Result<(), Singular> {
        let width = self.lower + self.upper + 1;
        solve_banded(self.lower, self.upper, b, |row, out| out.copy_from_slice(&self.data[row * width..][..width]))
    }
}

/// Overwrites `b` with the solution of A·x = b by Gaussian elimination with partial pivoting, in O(n · lower · (lower +
/// upper)) operations.
///
/// `row(i, out)` writes row i of A, that is columns i − lower … i + upper, into `out`; it must write zero for columns
/// outside the matrix. Each row is requested once, in order, so A need not exist as a whole.
///
/// # Errors
/// [`Singular`] if a pivot column holds nothing but zeros or a number that is not finite.
pub fn solve_banded(
    lower: usize,
    upper: usize,
    b: &mut [f64],
    row: impl FnMut(usize, &mut [f64]),
) -> Result<(), Singular> {
    Level::Best.dispatch(Elimination { lower, upper, b, row })
}

/// The elimination, compiled for every level of instructions.
struct Elimination<'b, R> {
    lower: usize,
    upper: usize,
    b: &'b mut [f64],
    row: R,
}

impl<R: FnMut(usize, &mut [f64])> WithSimd for Elimination<'_, R> {
    type Output = Result<(), Singular>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Result<(), Singular> {
        let Self { lower, upper, b, mut row } = self;
        let n = b.len();
        let width = lower + upper + 1;
        // The rows from which column k still has to be eliminated, each from column k on: `active[r]` is row k + r.
        let mut active = vec![0.0; (lower + 1) * width];
        let mut next = active.clone();
        let mut fresh = vec![0.0; width];
        for i in 0..n.min(lower + 1) {
            row(i, &mut fresh);
            // The band of row i starts lower − i columns to the left of the matrix.
            active[i * width..][..width - (lower - i)].copy_from_slice(&fresh[lower - i..]);
        }
        let mut u = Vec::with_capacity(n * (upper + 2));
        let mut lengths = Vec::with_capacity(n);
        for k in 0..n {
            let rows = (lower + 1).min(n - k);
            let pivot_row = (0..rows)
                .max_by(|&a, &c| active[a * width].abs().total_cmp(&active[c * width].abs()))
                .expect("there is at least one row");
            let pivot = active[pivot_row * width];
            if pivot == 0.0 || !pivot.is_finite() {
                return Err(Singular { column: k });
            }
            if pivot_row > 0 {
                let (first, rest) = active.split_at_mut(width);
                first.swap_with_slice(&mut rest[(pivot_row - 1) * width..][..width]);
                b.swap(k, k + pivot_row);
            }
            let (pivots, rest) = active.split_at(width);
            for r in 1..rows {
                let from = &rest[(r - 1) * width..][..width];
                let to = &mut next[(r - 1) * width..][..width];
                let factor = from[0] / pivot;
                for ((to, from), above) in to.iter_mut().zip(&from[1..]).zip(&pivots[1..]) {
                    *to = from - factor * above;
                }
                to[width - 1] = 0.0;
                b[k + r] -= factor * b[k];
            }
            if k + rows < n {
                row(k + rows, &mut next[(rows - 1) * width..][..width]);
            }
            let length = width - pivots.iter().rev().take_while(|&&value| value == 0.0).count();
            u.extend_from_slice(&pivots[..length]);
            lengths.push(length as u32);
            std::mem::swap(&mut active, &mut next);
        }
        substitute(&u, &lengths, b);
        Ok(())
    }
}

/// Solves with the upper triangle, of which `u` holds the rows, each from its diagonal on, of these lengths.
#[inline(always)]
fn substitute(u: &[f64], lengths: &[u32], b: &mut [f64]) {
    let mut end = u.len();
    for (k, &length) in lengths.iter().enumerate().rev() {
        let start = end - length as usize;
        let (diagonal, rest) = (u[start], &u[start + 1..end]);
        let sum: f64 = rest.iter().zip(&b[k + 1..]).map(|(u, x)| u * x).sum();
        b[k] = (b[k] - sum) / diagonal;
        end = start;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn solves_like_a_dense_lu(
            n in 1_usize..30,
            lower in 0_usize..5,
            upper in 0_usize..5,
            seed in proptest::collection::vec(-1.0..1.0_f64, 400),
        ) {
            let mut values = seed.iter().cycle();
            let mut banded = BandedMatrix::zeros(n, lower, upper);
            let mut dense = DMatrix::zeros(n, n);
            for row in 0..n {
                for column in row.saturating_sub(lower)..=(row + upper).min(n - 1) {
                    // The matrix is not diagonally dominant, so it cannot be solved without pivoting.
                    let value = *values.next().unwrap();
                    banded.add(row, column, value);
                    dense[(row, column)] = value;
                }
            }
            let b: Vec<f64> = (0..n).map(|_| *values.next().unwrap()).collect();
            prop_assume!(dense.clone().svd(false, false).singular_values.min() > 1e-6);
            let mut x = b.clone();
            banded.solve_in_place(&mut x).unwrap();
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
        assert_eq!(matrix.solve_in_place(&mut [1.0; 3]).unwrap_err(), Singular { column: 1 });
    }
}
