//! Matrices in compressed rows, as sums of parts.

/// Where the entries of a square matrix are, and to which of them each of its parts belongs. Matrices of one pattern
/// are summed from their parts in the order of this one, in O(parts).
#[derive(Debug, Clone)]
pub struct Pattern {
    /// Where each row begins among the entries, and their number.
    starts: Vec<u32>,
    /// Columns of the entries, ascending in each row.
    columns: Vec<u32>,
    /// The entry that each part is added to.
    entries: Vec<u32>,
}

impl Pattern {
    /// The pattern of a matrix of `order` rows that is a sum of `parts` at these (row, column), in any order.
    ///
    /// # Panics
    /// If a part is outside the matrix, or if there are more than 4·10⁹ of them.
    pub fn new(order: usize, parts: &[(u32, u32)]) -> Self {
        assert!(u32::try_from(parts.len()).is_ok(), "{} parts do not fit", parts.len());
        // Sorted by rows in one pass, as all rows are short.
        let mut ends = vec![0_u32; order + 1];
        parts.iter().for_each(|&(row, _)| ends[row as usize + 1] += 1);
        for row in 0..order {
            ends[row + 1] += ends[row];
        }
        let mut sorted = vec![0_u32; parts.len()];
        for (part, &(row, _)) in parts.iter().enumerate() {
            sorted[ends[row as usize] as usize] = part as u32;
            ends[row as usize] += 1;
        }
        let (mut starts, mut columns, mut entries) = (vec![0], Vec::new(), vec![0; parts.len()]);
        let mut first = 0;
        for &end in &ends[..order] {
            let row = &mut sorted[first..end as usize];
            row.sort_unstable_by_key(|&part| parts[part as usize].1);
            let begin = columns.len();
            for &part in &*row {
                let column = parts[part as usize].1;
                assert!((column as usize) < order, "column {column} is outside the matrix");
                if columns.len() == begin || columns.last() != Some(&column) {
                    columns.push(column);
                }
                entries[part as usize] = columns.len() as u32 - 1;
            }
            starts.push(columns.len() as u32);
            first = end as usize;
        }
        Self { starts, columns, entries }
    }

    /// Number of rows.
    pub fn order(&self) -> usize {
        self.starts.len() - 1
    }

    /// Columns of the entries of a row, ascending.
    pub fn row(&self, row: usize) -> &[u32] {
        &self.columns[self.range(row)]
    }

    fn range(&self, row: usize) -> std::ops::Range<usize> {
        self.starts[row] as usize..self.starts[row + 1] as usize
    }

    /// A matrix of this pattern, before its first part.
    pub fn sum(&self) -> Sum<'_> {
        let matrix = SparseMatrix { pattern: self, values: vec![0.0; self.columns.len()] };
        Sum { matrix, parts: self.entries.iter() }
    }
}

/// A matrix to which its parts are being added.
#[derive(Debug)]
pub struct Sum<'p> {
    matrix: SparseMatrix<'p>,
    parts: std::slice::Iter<'p, u32>,
}

impl<'p> Sum<'p> {
    /// Adds the next part.
    ///
    /// # Panics
    /// If the pattern has no more parts.
    pub fn add(&mut self, part: f64) {
        let entry = *self.parts.next().expect("the pattern has as many parts as the matrix");
        self.matrix.values[entry as usize] += part;
    }

    /// The matrix.
    pub fn matrix(self) -> SparseMatrix<'p> {
        debug_assert_eq!(self.parts.len(), 0);
        self.matrix
    }
}

/// A square matrix of a [`Pattern`].
#[derive(Debug, Clone)]
pub struct SparseMatrix<'p> {
    pattern: &'p Pattern,
    values: Vec<f64>,
}

impl SparseMatrix<'_> {
    /// Number of rows.
    pub fn order(&self) -> usize {
        self.pattern.order()
    }

    /// The entries of a row with their columns, ascending.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = self.pattern.range(row);
        let columns = self.pattern.columns[range.clone()].iter();
        columns.zip(&self.values[range]).map(|(&column, &value)| (column as usize, value))
    }

    /// The entry at (row, column); zero outside the pattern.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        let found = self.pattern.row(row).binary_search_by(|&other| (other as usize).cmp(&column));
        found.map_or(0.0, |place| self.values[self.pattern.range(row)][place])
    }

    /// The product of the matrix and `x`, which has one entry per row.
    pub fn multiply(&self, x: &[f64]) -> Vec<f64> {
        (0..self.order()).map(|row| self.row(row).map(|(column, value)| value * x[column]).sum()).collect()
    }
}
