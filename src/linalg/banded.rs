//! Banded linear systems in a single pass.
//!
//! The physical limit is a banded system of 2(N − 1) unknowns. No maintained pure-Rust crate offers a banded solver,
//! and a general sparse LU costs several times more here; hence this small one. Every system is solved only once, so
//! nothing is kept but the rows of U, each without its trailing zeros: at a million nodes, memory traffic dominates the
//! cost.
//!
//! ```
//! use geodesic_ivp::linalg::banded::solve_banded;
//!
//! let rows = [[0.0, 2.0, -1.0], [0.0, 2.0, 0.0], [-1.0, 2.0, 0.0]];
//! let mut b = [0.0, 4.0, 4.0];
//! solve_banded(1, 1, &mut b, |k, row| row.copy_from_slice(&rows[k]))?;
//! assert_eq!(b, [1.0, 2.0, 3.0]);
//! # Ok::<(), geodesic_ivp::linalg::Singular>(())
//! ```

use pulp::{Simd, WithSimd};

use super::Singular;
use crate::number::vector::Level;

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
                return Err(Singular);
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
            let mut dense = DMatrix::zeros(n, n);
            for row in 0..n {
                for column in row.saturating_sub(lower)..=(row + upper).min(n - 1) {
                    // The matrix is not diagonally dominant, so it cannot be solved without pivoting.
                    dense[(row, column)] = *values.next().unwrap();
                }
            }
            let b: Vec<f64> = (0..n).map(|_| *values.next().unwrap()).collect();
            prop_assume!(dense.clone().svd(false, false).singular_values.min() > 1e-6);
            let mut x = b.clone();
            let entry = |row: usize, place: usize| (row + place).checked_sub(lower).filter(|&column| column < n);
            let solved = solve_banded(lower, upper, &mut x, |row, out| {
                let entries = (0..out.len()).map(|place| entry(row, place).map_or(0.0, |column| dense[(row, column)]));
                out.iter_mut().zip(entries).for_each(|(out, entry)| *out = entry);
            });
            prop_assert_eq!(solved, Ok(()));
            let expected = dense.lu().solve(&DVector::from_vec(b)).unwrap();
            for (got, want) in x.iter().zip(expected.iter()) {
                prop_assert!((got - want).abs() <= 1e-9 * (1.0 + want.abs()));
            }
        }
    }

    #[test]
    fn a_singular_matrix_is_reported() {
        let rows = [[0.0, 1.0, 0.0], [0.0; 3], [0.0, 1.0, 0.0]];
        let solved = solve_banded(1, 1, &mut [1.0; 3], |k, row| row.copy_from_slice(&rows[k]));
        assert_eq!(solved, Err(Singular));
    }
}
