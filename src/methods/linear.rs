//! Small dense systems of linear equations, solved in place.

/// A square matrix, and its factors once it was factored.
#[derive(Debug, Clone, Default)]
pub(super) struct Dense {
    size: usize,
    /// Row by row.
    entries: Vec<f64>,
    /// The row that each step of the elimination took.
    pivots: Vec<usize>,
}

impl Dense {
    /// Room for a matrix of that many rows.
    pub(super) fn new(size: usize) -> Self {
        Self { size, entries: vec![0.0; size * size], pivots: vec![0; size] }
    }

    /// Sets every entry, and factors the matrix by elimination with row pivots. A singular matrix makes solutions that
    /// are not finite.
    pub(super) fn factor(&mut self, entry: impl Fn(usize, usize) -> f64) {
        let Self { size: n, entries, pivots } = self;
        let n = *n;
        for (k, place) in entries.iter_mut().enumerate() {
            *place = entry(k / n, k % n);
        }
        for k in 0..n {
            let magnitude = |row: usize| entries[row * n + k].abs();
            let pivot = (k + 1..n).fold(k, |best, row| if magnitude(row) > magnitude(best) { row } else { best });
            pivots[k] = pivot;
            for column in 0..n {
                entries.swap(k * n + column, pivot * n + column);
            }
            let (above, below) = entries.split_at_mut((k + 1) * n);
            let row = &above[k * n..];
            for other in below.chunks_exact_mut(n) {
                let factor = other[k] / row[k];
                other[k] = factor;
                for column in k + 1..n {
                    other[column] -= factor * row[column];
                }
            }
        }
    }

    /// Replaces the right-hand side by the solution.
    pub(super) fn solve(&self, right: &mut [f64]) {
        let n = self.size;
        for (k, &pivot) in self.pivots.iter().enumerate() {
            right.swap(k, pivot);
        }
        for row in 0..n {
            let sum: f64 = (0..row).map(|k| self.entries[row * n + k] * right[k]).sum();
            right[row] -= sum;
        }
        for row in (0..n).rev() {
            let sum: f64 = (row + 1..n).map(|k| self.entries[row * n + k] * right[k]).sum();
            right[row] = (right[row] - sum) / self.entries[row * n + row];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Dense;

    #[test]
    fn a_matrix_that_needs_pivots_is_solved() {
        let rows = [[0.0, 2.0, 1.0], [1.0, -1.0, 0.5], [3.0, 0.25, -2.0]];
        let solution = [1.5, -2.0, 0.75];
        let mut right: Vec<f64> = rows.iter().map(|row| row.iter().zip(solution).map(|(a, x)| a * x).sum()).collect();
        let mut dense = Dense::new(3);
        dense.factor(|i, j| rows[i][j]);
        dense.solve(&mut right);
        assert!(right.iter().zip(solution).all(|(found, x)| (found - x).abs() < 1e-15), "{right:?}");
    }
}
