//! Sparse linear systems, by the LU factorisation of [faer](https://docs.rs/faer).
//!
//! A [`Pattern`] holds what does not depend on the values: where the entries are, and an order of the columns that
//! keeps the factors sparse. It is found once, and every matrix of that pattern is factorised with it.
//!
//! ```
//! use geodesic_ivp::linalg::sparse::Pattern;
//!
//! // The rows (0, 1) and (1, 2). The last entry is a sum of two parts.
//! let pattern = Pattern::new(2, &[(0, 1), (1, 0), (1, 1), (1, 1)]);
//! let lu = pattern.factor(&[1.0, 1.0, 1.5, 0.5], [&[1.0, 1.0], &[1.0, 1e-20]])?;
//! let mut b = [3.0, 8.0];
//! lu.solve_in_place(&mut b);
//! assert!((b[0] - 2.0).abs() < 1e-15 && (b[1] - 3.0).abs() < 1e-15);
//! assert_eq!(lu.multiply(&[2.0, 3.0]), [3.0, 8.0]);
//! # Ok::<(), geodesic_ivp::linalg::Singular>(())
//! ```

use faer::linalg::solvers::SolveCore;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{Argsort, Pair, SparseColMat, SymbolicSparseColMat};
use faer::{ColRef, Conj, MatMut};

use super::Singular;

/// The places of the entries of square matrices that are sums of parts, and their order of elimination.
///
/// faer runs on one thread here, so the digits of a solution do not depend on the number of cores.
pub struct Pattern {
    entries: SymbolicSparseColMat<u32>,
    /// Tells which entry each part belongs to.
    parts: Argsort<u32>,
    symbolic: SymbolicLu<u32>,
}

impl Pattern {
    /// The pattern of a matrix of `order` rows that is a sum of parts at these (row, column), in any order.
    ///
    /// # Panics
    /// If a part is outside the matrix, or if there are more than 4·10⁹ of them.
    pub fn new(order: usize, parts: &[(u32, u32)]) -> Self {
        let places: Vec<Pair<u32, u32>> = parts.iter().map(|&(row, col)| Pair { row, col }).collect();
        let (entries, parts) = SymbolicSparseColMat::try_new_from_indices(order, order, &places)
            .expect("every part lies inside the matrix, and 32 bits count the parts");
        let symbolic = SymbolicLu::try_new(entries.as_ref()).expect("32 bits count the entries of the factors");
        Self { entries, parts, symbolic }
    }

    /// The LU factorisation with partial pivoting of the matrix with these values of its parts, which come in the order
    /// of [`Self::new`]. Pivots are chosen where rows and columns are divided by these units, rounded to powers of two.
    ///
    /// # Errors
    /// [`Singular`] if a pivot column is empty. A column of zeros, or one with a number that is not finite, shows in
    /// solutions, which are then not finite.
    ///
    /// # Panics
    /// If there are not as many values as parts, or not a unit for each row and column.
    pub fn factor(&self, values: &[f64], units: [&[f64]; 2]) -> Result<SparseLu, Singular> {
        let mut matrix = SparseColMat::new_from_argsort(self.entries.clone(), &self.parts, values)
            .expect("there are as many values as parts");
        let units = units.map(|units| units.iter().map(|&unit| power_of_two(unit)).collect::<Vec<f64>>());
        for (column, unit) in units[1].iter().enumerate() {
            let rows: Vec<u32> = matrix.symbolic().row_idx_of_col_raw(column).to_vec();
            let entries = matrix.val_of_col_mut(column).iter_mut();
            entries.zip(rows).for_each(|(entry, row)| *entry /= units[0][row as usize] * unit);
        }
        let lu = Lu::try_new_with_symbolic(self.symbolic.clone(), matrix.as_ref()).map_err(|_| Singular)?;
        Ok(SparseLu { matrix, lu, units })
    }
}

/// The power of two below a positive number; 1 for what is not one. Division by it does not round.
fn power_of_two(unit: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff0_0000_0000_0000;
    if unit.is_normal() && unit > 0.0 { f64::from_bits(unit.to_bits() & EXPONENT) } else { 1.0 }
}

/// A square sparse matrix with its factors.
#[derive(Debug)]
pub struct SparseLu {
    /// The entries divided by the units of their rows and columns.
    matrix: SparseColMat<u32, f64>,
    lu: Lu<u32, f64>,
    units: [Vec<f64>; 2],
}

impl SparseLu {
    /// Overwrites `b`, which has one entry per row, with the solution of A·x = b.
    pub fn solve_in_place(&self, b: &mut [f64]) {
        let (rows, [of_rows, of_columns]) = (b.len(), &self.units);
        b.iter_mut().zip(of_rows).for_each(|(b, unit)| *b /= unit);
        self.lu.solve_in_place_with_conj(Conj::No, MatMut::from_column_major_slice_mut(b, rows, 1));
        b.iter_mut().zip(of_columns).for_each(|(b, unit)| *b /= unit);
    }

    /// A right-hand side in the units of the rows.
    pub fn in_units(&self, b: &[f64]) -> Vec<f64> {
        b.iter().zip(&self.units[0]).map(|(b, unit)| b / unit).collect()
    }

    /// The product of the matrix and `x`, which has one entry per row.
    pub fn multiply(&self, x: &[f64]) -> Vec<f64> {
        let [of_rows, of_columns] = &self.units;
        let x: Vec<f64> = x.iter().zip(of_columns).map(|(x, unit)| x * unit).collect();
        (&self.matrix * ColRef::from_slice(&x)).iter().zip(of_rows).map(|(product, unit)| product * unit).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Pattern;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    proptest! {
        /// Entries anywhere, the diagonal included or not, some of them sums of several parts.
        #[test]
        fn solves_like_a_dense_lu(
            n in 1_usize..25,
            parts in proptest::collection::vec((0_u32..25, 0_u32..25, -1.0..1.0_f64), 1..120),
            keys in proptest::collection::vec(0_u32..1000, 25),
            b in proptest::collection::vec(-1.0..1.0_f64, 25),
            units in proptest::collection::vec(0.1..10.0_f64, 50),
        ) {
            // A random permutation besides keeps most matrices regular.
            let mut order: Vec<u32> = (0..n as u32).collect();
            order.sort_by_key(|&row| keys[row as usize]);
            let cycle = (0..n as u32).map(|row| (row, order[row as usize], 1.5));
            let random = parts.iter().copied().filter(|&(row, column, _)| row.max(column) < n as u32);
            let parts: Vec<(u32, u32, f64)> = random.chain(cycle).collect();
            let places: Vec<(u32, u32)> = parts.iter().map(|&(row, column, _)| (row, column)).collect();
            let values: Vec<f64> = parts.iter().map(|&(_, _, value)| value).collect();
            let mut dense = DMatrix::<f64>::zeros(n, n);
            parts.iter().for_each(|&(row, column, value)| dense[(row as usize, column as usize)] += value);
            prop_assume!(dense.clone().svd(false, false).singular_values.min() > 1e-6);
            let lu = Pattern::new(n, &places).factor(&values, [&units[..n], &units[n..2 * n]]).unwrap();
            let mut x = b[..n].to_vec();
            lu.solve_in_place(&mut x);
            let expected = dense.clone().lu().solve(&DVector::from_column_slice(&b[..n])).unwrap();
            for (got, want) in x.iter().zip(expected.iter()) {
                prop_assert!((got - want).abs() <= 1e-8 * (1.0 + expected.amax()), "{got} {want}");
            }
            let product = dense * DVector::from_column_slice(&x);
            for (got, want) in lu.multiply(&x).iter().zip(product.iter()) {
                prop_assert!((got - want).abs() <= 1e-14 * (1.0 + expected.amax()) * n as f64, "{got} {want}");
            }
        }
    }

    /// In units of their own, rows and columns of any size are solved like those of size one, to the last bit.
    #[test]
    fn units_of_rows_and_columns_change_no_digit() {
        let places: Vec<(u32, u32)> = (0..4).flat_map(|row| (0..4).map(move |column| (row, column))).collect();
        let entries = [3.0, 1.0, -2.0, 0.5, 1.0, -4.0, 0.25, 2.0, 0.0, 1.5, 5.0, -1.0, 2.0, 0.75, 1.0, -3.0];
        let (of_rows, of_columns) = ([-300, 0, 250, 7], [200, -280, 3, 0]);
        let scaled = |b: &[f64], powers: &[i32]| -> Vec<f64> {
            b.iter().zip(powers).map(|(b, &power)| b * 2.0_f64.powi(power)).collect()
        };
        let of_places: Vec<i32> = places.iter().map(|&(i, j)| of_rows[i as usize] + of_columns[j as usize]).collect();
        let solved = |entries: &[f64], units: [&[f64]; 2], b: &[f64]| {
            let lu = Pattern::new(4, &places).factor(entries, units).unwrap();
            let mut x = b.to_vec();
            lu.solve_in_place(&mut x);
            x
        };
        let b = [1.0, -2.0, 0.3, 4.0];
        let in_ones = solved(&entries, [&[1.0; 4]; 2], &b);
        let units = [scaled(&[1.9; 4], &of_rows), scaled(&[1.1; 4], &of_columns)];
        let in_units = solved(&scaled(&entries, &of_places), [&units[0], &units[1]], &scaled(&b, &of_rows));
        assert_eq!(scaled(&in_units, &of_columns), in_ones);
    }

    #[test]
    fn a_matrix_without_a_solution_is_seen() {
        let pattern = Pattern::new(3, &[(0, 0), (2, 2), (1, 0), (0, 1)]);
        for values in [[1.0, 1.0, 0.0, 0.0], [1.0, f64::NAN, 1.0, 1.0], [0.0; 4]] {
            let Ok(lu) = pattern.factor(&values, [&[1.0; 3]; 2]) else { continue };
            let mut b = [1.0, 1.0, 1.0];
            lu.solve_in_place(&mut b);
            assert!(b.iter().any(|x| !x.is_finite()), "{values:?}: {b:?}");
        }
    }
}
