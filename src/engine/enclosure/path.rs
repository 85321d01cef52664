//! Where the polynomials of a window are between its nodes.

/// Rounding of what a polynomial passes through, relative to its value.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The variables of a program along a window.
#[derive(Debug, Default)]
pub(crate) struct Path {
    /// Number of nodes.
    pub(super) points: usize,
    /// The variables that vary.
    pub variables: Vec<usize>,
    /// Their values on the nodes, row by row.
    pub values: Vec<f64>,
    /// Their second derivatives in units of the distance of two neighbouring nodes, squared.
    bends: Vec<f64>,
}

impl Path {
    /// Forgets the last window.
    pub(crate) fn begin(&mut self, points: usize) {
        self.points = points;
        self.variables.clear();
        self.values.clear();
        self.bends.clear();
    }

    /// Adds a variable by its values on the nodes and its second derivative from every node to the next, times the
    /// square of their distance.
    pub(crate) fn push(&mut self, variable: usize, values: &[f64], bend: impl Fn(usize) -> f64) {
        self.variables.push(variable);
        self.values.extend(&values[..self.points]);
        self.bends.extend((0..self.points - 1).map(bend));
    }

    /// The value of a row on a node.
    pub(super) fn value(&self, row: usize, node: usize) -> f64 {
        self.values[row * self.points + node]
    }

    /// The interval of a row from node `pair` to the next.
    pub(super) fn interval(&self, row: usize, pair: usize) -> [f64; 2] {
        self.piece(row, pair, [0.0, 1.0])
    }

    /// The interval of a row on a part of the way from node `pair` to the next, by its ends as fractions of that way.
    ///
    /// Between two nodes the variable is taken for the parabola with the bend between them, which leaves a chord by at
    /// most an eighth of the bend. As bends change from pair to pair, twice that is allowed, with the largest bend of
    /// this pair and its neighbours.
    pub(super) fn piece(&self, row: usize, pair: usize, [from, to]: [f64; 2]) -> [f64; 2] {
        let values = [pair, pair + 1].map(|node| self.value(row, node));
        let bends = &self.bends[row * (self.points - 1)..][..self.points - 1];
        let around = &bends[pair.saturating_sub(1)..(pair + 2).min(bends.len())];
        let largest = around.iter().fold(0.0_f64, |most, bend| most.max(bend.abs()));
        let on_chord = |at: f64| (1.0 - at) * values[0] + at * values[1];
        let ends = [on_chord(from), on_chord(to)];
        // Where the parabola is furthest from the chord.
        let middle = 0.5_f64.clamp(from, to);
        let margin = middle * (1.0 - middle) * largest + ROUNDING * values[0].abs().max(values[1].abs());
        [ends[0].min(ends[1]) - margin, ends[0].max(ends[1]) + margin]
    }
}
