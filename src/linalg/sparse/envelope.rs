//! Gaussian elimination inside the envelope of a matrix.

use pulp::{Simd, WithSimd};

use super::{Pattern, SparseMatrix};
use crate::linalg::banded::Singular;
use crate::number::vector::Level;

/// What an elimination with partial pivoting fills in at most, in a given order of rows and columns.
///
/// It is all that is between the first entry of a row or of a later one, and the last one that any row has that could
/// have come to its place: a band (G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., 4.3.3) that is as wide as
/// it must be at each place.
#[derive(Debug, Clone)]
pub struct Envelope {
    /// The row and column of the matrix at each place, and the place of each.
    order: Vec<u32>,
    places: Vec<u32>,
    rows: Vec<Extent>,
    /// Behind the last row that each column reaches.
    reaches: Vec<usize>,
    /// Where the numbers of each row begin, and their number.
    offsets: Vec<usize>,
}

/// Columns of a row.
#[derive(Debug, Clone, Copy)]
struct Extent {
    /// The first one that is kept.
    start: u32,
    /// Behind the last one of the matrix itself.
    end: u32,
}

impl Envelope {
    /// The envelope of matrices of this pattern, whose rows and columns are eliminated in this `order`.
    ///
    /// # Panics
    /// If `order` does not name every row once.
    pub fn new(pattern: &Pattern, order: &[u32]) -> Self {
        let n = pattern.order();
        let places = inverse(order, n);
        let place = |&column: &u32| places[column as usize];
        let mut rows: Vec<Extent> = (0_u32..)
            .zip(order)
            .map(|(k, &row)| {
                let columns = pattern.row(row as usize).iter().map(place);
                let start = columns.clone().fold(k, u32::min);
                Extent { start, end: columns.fold(k, u32::max) + 1 }
            })
            .collect();
        let mut start = n as u32;
        for row in rows.iter_mut().rev() {
            start = start.min(row.start);
            row.start = start;
        }
        let (mut offsets, mut reaches) = (Vec::with_capacity(n + 1), Vec::with_capacity(n));
        let (mut offset, mut end, mut reach) = (0, 0, 0);
        for (k, row) in rows.iter().enumerate() {
            while reach < n && rows[reach].start as usize <= k {
                end = end.max(rows[reach].end);
                reach += 1;
            }
            reaches.push(reach);
            offsets.push(offset);
            offset += (end - row.start) as usize;
        }
        offsets.push(offset);
        Self { order: order.to_vec(), places, rows, reaches, offsets }
    }

    /// How many numbers a factorisation keeps.
    pub fn size(&self) -> usize {
        self.offsets[self.order.len()]
    }

    /// L and U of a matrix of the pattern, by Gaussian elimination with partial pivoting.
    ///
    /// # Errors
    /// [`Singular`] if a pivot column holds nothing but zeros or a number that is not finite.
    pub fn factor(&self, matrix: &SparseMatrix<'_>) -> Result<Lu<'_>, Singular> {
        let mut numbers = vec![0.0; self.size()];
        for (k, &row) in self.order.iter().enumerate() {
            let start = self.rows[k].start as usize;
            let numbers = &mut numbers[self.offsets[k]..self.offsets[k + 1]];
            matrix.row(row as usize).for_each(|(column, value)| numbers[self.places[column] as usize - start] = value);
        }
        let ends = self.rows.iter().map(|row| row.end).collect();
        let mut lu = Lu { envelope: self, numbers, ends, pivots: Vec::with_capacity(self.order.len()) };
        Level::Best.dispatch(Elimination(&mut lu))?;
        Ok(lu)
    }

    /// Where the number in a column of the row at place `i` is.
    #[inline(always)]
    fn at(&self, i: usize, column: usize) -> usize {
        self.offsets[i] + (column - self.rows[i].start as usize)
    }
}

/// The place of each row.
fn inverse(order: &[u32], n: usize) -> Vec<u32> {
    let mut places = vec![u32::MAX; n];
    for (place, &row) in (0_u32..).zip(order) {
        places[row as usize] = place;
    }
    assert!(order.len() == n && !places.contains(&u32::MAX), "an order names every row once");
    places
}

/// A factorised matrix.
#[derive(Debug, Clone)]
pub struct Lu<'e> {
    envelope: &'e Envelope,
    /// Row by row: the factors that eliminated it, then its part of U.
    numbers: Vec<f64>,
    /// Behind the last column of each row.
    ends: Vec<u32>,
    /// The row that came to each place.
    pivots: Vec<u32>,
}

/// Eliminates one column after the other. A type and not a closure, so that it is compiled with the instructions of the
/// machine.
struct Elimination<'l, 'e>(&'l mut Lu<'e>);

impl WithSimd for Elimination<'_, '_> {
    type Output = Result<(), Singular>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Result<(), Singular> {
        let Self(Lu { envelope, numbers, ends, pivots }) = self;
        for (k, &reach) in envelope.reaches.iter().enumerate() {
            let (mut pivot_row, mut largest) = (k, numbers[envelope.at(k, k)].abs());
            for i in k + 1..reach {
                let size = numbers[envelope.at(i, k)].abs();
                // What is no number becomes a pivot, so that it is found.
                if size > largest || size.is_nan() {
                    (pivot_row, largest) = (i, size);
                }
            }
            if largest == 0.0 || !largest.is_finite() {
                return Err(Singular { column: envelope.order[k] as usize });
            }
            pivots.push(pivot_row as u32);
            let below = envelope.offsets[k + 1];
            if pivot_row > k {
                let width = ends[k].max(ends[pivot_row]) as usize - k;
                let (head, tail) = numbers.split_at_mut(below);
                let first = &mut head[envelope.at(k, k)..][..width];
                first.swap_with_slice(&mut tail[envelope.at(pivot_row, k) - below..][..width]);
                ends.swap(k, pivot_row);
            }
            let end = ends[k];
            let (head, tail) = numbers.split_at_mut(below);
            let above = &head[envelope.at(k, k)..][..end as usize - k];
            let (pivot, above) = (above[0], &above[1..]);
            for i in k + 1..reach {
                let row = &mut tail[envelope.at(i, k) - below..][..end as usize - k];
                if row[0] == 0.0 {
                    continue;
                }
                let factor = row[0] / pivot;
                row[0] = factor;
                for (entry, above) in row[1..].iter_mut().zip(above) {
                    *entry -= factor * above;
                }
                ends[i] = ends[i].max(end);
            }
        }
        Ok(())
    }
}

impl Lu<'_> {
    /// Overwrites `b`, which has one entry per row, with the solution of A·x = b.
    pub fn solve_in_place(&self, b: &mut [f64]) {
        let Self { envelope, numbers, ends, pivots } = self;
        let mut x: Vec<f64> = envelope.order.iter().map(|&row| b[row as usize]).collect();
        for (k, &reach) in envelope.reaches.iter().enumerate() {
            x.swap(k, pivots[k] as usize);
            let (above, below) = x[..reach].split_at_mut(k + 1);
            if above[k] != 0.0 {
                for (i, entry) in (k + 1..).zip(below) {
                    *entry -= numbers[envelope.at(i, k)] * above[k];
                }
            }
        }
        for k in (0..x.len()).rev() {
            let row = &numbers[envelope.at(k, k)..][..ends[k] as usize - k];
            let sum: f64 = row[1..].iter().zip(&x[k + 1..]).map(|(u, x)| u * x).sum();
            x[k] = (x[k] - sum) / row[0];
        }
        for (&row, &value) in envelope.order.iter().zip(&x) {
            b[row as usize] = value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Envelope, Singular};
    use crate::linalg::sparse::Pattern;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    proptest! {
        /// Entries anywhere, the diagonal included or not, in any order, some in several parts.
        #[test]
        fn solves_like_a_dense_lu(
            n in 1_usize..25,
            parts in proptest::collection::vec((0_u32..25, 0_u32..25, -1.0..1.0_f64), 1..120),
            keys in proptest::collection::vec(0_u32..1000, 25),
            b in proptest::collection::vec(-1.0..1.0_f64, 25),
        ) {
            // A random permutation besides keeps most matrices regular.
            let mut order: Vec<u32> = (0..n as u32).collect();
            order.sort_by_key(|&row| keys[row as usize]);
            let cycle = (0..n as u32).map(|row| (row, order[row as usize], 1.5));
            let random = parts.iter().copied().filter(|&(row, column, _)| row.max(column) < n as u32);
            let parts: Vec<(u32, u32, f64)> = random.chain(cycle).collect();
            let places: Vec<(u32, u32)> = parts.iter().map(|&(row, column, _)| (row, column)).collect();
            let pattern = Pattern::new(n, &places);
            let (mut sum, mut dense) = (pattern.sum(), DMatrix::<f64>::zeros(n, n));
            for &(row, column, value) in &parts {
                sum.add(value);
                dense[(row as usize, column as usize)] += value;
            }
            let matrix = sum.matrix();
            for row in 0..n {
                for column in 0..n {
                    prop_assert!((matrix.get(row, column) - dense[(row, column)]).abs() < 1e-14);
                }
            }
            prop_assume!(dense.clone().svd(false, false).singular_values.min() > 1e-6);
            let mut x = b[..n].to_vec();
            let envelope = Envelope::new(&pattern, &order);
            prop_assert!(envelope.size() <= n * n);
            envelope.factor(&matrix).unwrap().solve_in_place(&mut x);
            let expected = dense.lu().solve(&DVector::from_column_slice(&b[..n])).unwrap();
            for (got, want) in x.iter().zip(expected.iter()) {
                prop_assert!((got - want).abs() <= 1e-8 * (1.0 + expected.amax()), "{got} {want}");
            }
            for (got, want) in matrix.multiply(&x).iter().zip(&b) {
                prop_assert!((got - want).abs() <= 1e-9 * (1.0 + expected.amax()));
            }
        }
    }

    #[test]
    fn a_matrix_without_a_solution_is_singular() {
        let pattern = Pattern::new(3, &[(0, 0), (2, 2), (1, 0), (0, 1)]);
        for (values, column) in [([1.0, 1.0, 0.0, 0.0], 1), ([1.0, f64::NAN, 1.0, 1.0], 2), ([0.0; 4], 2)] {
            let mut sum = pattern.sum();
            values.into_iter().for_each(|value| sum.add(value));
            let found = Envelope::new(&pattern, &[2, 0, 1]).factor(&sum.matrix()).map(|_| ());
            assert_eq!(found.unwrap_err(), Singular { column });
        }
    }

    #[test]
    #[should_panic(expected = "every row once")]
    fn an_order_names_every_row() {
        let _ = Envelope::new(&Pattern::new(2, &[(0, 0), (1, 1)]), &[0, 0]);
    }
}
