//! Linear systems with any numbers of equations and unknowns: the shortest of the vectors that come nearest to solving
//! them.

use nalgebra::DMatrix;

/// The pseudo-inverse of a matrix in scaled unknowns, without the directions that are not determined.
#[derive(Debug, Clone)]
pub(super) struct PseudoInverse {
    /// The pseudo-inverse, in the units of the unknowns.
    pub(super) matrix: DMatrix<f64>,
    /// The number of directions that are determined.
    pub(super) rank: usize,
    /// The largest stretching over the smallest one of a direction that is determined.
    pub(super) condition: f64,
}

impl PseudoInverse {
    /// That of `jacobian`, where lengths are counted with every unknown divided by its scale. A direction is not
    /// determined if it is stretched by less than `share` of the largest stretching. Unless there are more equations
    /// than unknowns, whose sum of squares is then least, the units of the equations do not matter.
    pub(super) fn new(jacobian: &DMatrix<f64>, scales: &[f64], share: f64) -> Self {
        let (rows, columns) = jacobian.shape();
        let mut scaled = DMatrix::from_fn(rows, columns, |i, j| jacobian[(i, j)] * scales[j]);
        let mut weights = vec![1.0; rows];
        if rows <= columns {
            for (i, weight) in weights.iter_mut().enumerate() {
                let length = scaled.row(i).norm();
                *weight = if length > 0.0 { 1.0 / length } else { 1.0 };
                scaled.row_mut(i).scale_mut(*weight);
            }
        }
        let svd = scaled.svd(true, true);
        let (u, v_t) = (svd.u.expect("it was asked for"), svd.v_t.expect("it was asked for"));
        let stretchings = &svd.singular_values;
        let most = stretchings.iter().copied().fold(0.0, f64::max);
        let is_kept = |stretching: f64| stretching > share * most;
        let least = stretchings.iter().copied().filter(|&stretching| is_kept(stretching)).fold(most, f64::min);
        let mut matrix = DMatrix::zeros(columns, rows);
        for (k, &stretching) in stretchings.iter().enumerate().filter(|(_, stretching)| is_kept(**stretching)) {
            matrix += v_t.row(k).transpose() * u.column(k).transpose() / stretching;
        }
        for j in 0..columns {
            for i in 0..rows {
                matrix[(j, i)] *= scales[j] * weights[i];
            }
        }
        let rank = stretchings.iter().filter(|&&stretching| is_kept(stretching)).count();
        Self { matrix, rank, condition: if least > 0.0 { most / least } else { f64::INFINITY } }
    }

    /// The vector for this right-hand side.
    pub(super) fn times(&self, right: &[f64]) -> Vec<f64> {
        let row = |j: usize| self.matrix.row(j).iter().zip(right).map(|(entry, value)| entry * value).sum();
        (0..self.matrix.nrows()).map(row).collect()
    }

    /// Bounds of the entries of that vector for right-hand sides of at most this size.
    pub(super) fn at_most(&self, right: &[f64]) -> Vec<f64> {
        let row = |j: usize| self.matrix.row(j).iter().zip(right).map(|(entry, value)| (entry * value).abs()).sum();
        (0..self.matrix.nrows()).map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solved(rows: usize, entries: &[f64], right: &[f64]) -> (Vec<f64>, usize) {
        let columns = entries.len() / rows;
        let matrix = DMatrix::from_row_slice(rows, columns, entries);
        let inverse = PseudoInverse::new(&matrix, &vec![1.0; columns], 1e-10);
        (inverse.times(right), inverse.rank)
    }

    /// One equation: the nearest point of a line. Three: the mean. Two that say the same: the shortest solution.
    #[test]
    fn systems_of_any_shape_are_solved() {
        for (rows, entries, right, expected, rank) in [
            (1, &[3.0, 4.0][..], &[25.0][..], &[3.0, 4.0][..], 1),
            (3, &[1.0, 1.0, 1.0], &[1.0, 2.0, 6.0], &[3.0], 1),
            (2, &[1.0, 1.0, 2.0, 2.0], &[2.0, 4.0], &[1.0, 1.0], 1),
            (2, &[2.0, 1.0, 0.0, 1e-3], &[4.0, 2e-3], &[1.0, 2.0], 2),
        ] {
            let (found, found_rank) = solved(rows, entries, right);
            assert_eq!(found_rank, rank);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}, {expected:?}");
        }
    }
}
