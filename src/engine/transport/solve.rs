//! Φ of all steps of a batch: the linear system, its solution, and the correction.

use pulp::{Simd, WithSimd};

use super::{AT_ONCE, Points, STAGES, Transport};
use crate::engine::rule::Order;
use crate::number::vector::{Lanes, Nodes};

/// Computes Φ of the steps of a batch.
impl WithSimd for &mut Transport<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) -> f64 {
        self.carry_unknowns(s);
        self.carry_ignorable(s);
        self.correct(s)
    }
}

#[inline(always)]
fn starts<S: Simd>(s: S, points: &Points) -> Lanes<S, AT_ONCE> {
    Lanes::new(s, &Nodes(*points.first_chunk().expect("there is one point more")))
}

#[inline(always)]
fn ends<S: Simd>(s: S, points: &Points) -> Lanes<S, AT_ONCE> {
    Lanes::new(s, &Nodes(*points.last_chunk().expect("there is one point more")))
}

impl Transport<'_> {
    /// The rows of all unknowns, without the correction.
    #[inline(always)]
    fn carry_unknowns<S: Simd>(&mut self, s: S) {
        for stage in 0..STAGES {
            self.evaluate(s, stage);
            self.set_up(s, stage);
        }
        self.eliminate(s);
        self.carry_unit_vectors(s);
    }

    /// The Jacobian on a Gauss node of each step.
    #[inline(always)]
    fn evaluate<S: Simd>(&mut self, s: S, stage: usize) {
        let Transport { linear, rows, points, lengths, method, gradients, .. } = self;
        let (h, [start, end]) = (Lanes::new(s, lengths), &method.hermite[stage]);
        for row in 0..*rows {
            let mut value = Lanes::splat(s, 0.0);
            for k in (0..3).rev() {
                let points = &points[row][k];
                value = value.mul_add(h, starts(s, points) * start[k] + ends(s, points) * end[k]);
            }
            linear.registers[linear.unknowns[row]] = value.nodes();
        }
        linear.evaluate(s, self.is_mended);
        for (gradient, term) in gradients[stage].iter_mut().zip(&linear.rates) {
            *gradient = linear.registers[term.register];
        }
    }

    /// The rows of the linear system for the slopes on that node, with a right-hand side for each unit vector δ.
    #[inline(always)]
    fn set_up<S: Simd>(&mut self, s: S, stage: usize) {
        let Transport { linear, active, rows, lengths, method, matrix, gains, .. } = self;
        let (m, rows) = (*active, *rows);
        let (size, is_second) = (rows * STAGES, linear.order == Order::Second);
        let width = size + 2 * m;
        let h = Lanes::new(s, lengths);
        let factor = if is_second { (h * h).neg() } else { h.neg() };
        let reach = h * method.nodes[stage];
        let lines = &mut matrix[stage * rows * width..][..rows * width];
        lines.fill(Nodes::ZERO);
        if stage == 0 {
            gains.fill(Nodes::ZERO);
        }
        for term in &linear.rows {
            let line = &mut lines[term.row * width..][..width];
            let j = Lanes::new(s, &linear.registers[term.register]) * term.factor;
            let change = j * Lanes::new(s, &linear.registers[linear.unknowns[term.column]]) * h;
            let square = change * change;
            gains[term.row] = square.scale_add(method.weights[stage], Lanes::new(s, &gains[term.row])).nodes();
            let scaled = j * factor;
            for other in 0..STAGES {
                let to = &mut line[other * rows + term.column];
                *to = scaled.scale_add(method.integral[stage][other], Lanes::new(s, to)).nodes();
            }
            let to = &mut line[size + term.column];
            *to = (j + Lanes::new(s, to)).nodes();
            if is_second {
                let to = &mut line[size + m + term.column];
                *to = j.mul_add(reach, Lanes::new(s, to)).nodes();
            }
        }
        for row in 0..rows {
            let diagonal = &mut lines[row * width + stage * rows + row];
            *diagonal = (Lanes::new(s, diagonal) + 1.0).nodes();
        }
    }

    /// Gauss–Jordan elimination. Steps are short, so that the diagonal is near 1 and rows need not be exchanged; where
    /// that is wrong, the defect is large.
    #[inline(always)]
    fn eliminate<S: Simd>(&mut self, s: S) {
        let Transport { rows, matrix, flow, .. } = self;
        let size = *rows * STAGES;
        let width = size + flow.len();
        for k in 0..size {
            let (above, below) = matrix.split_at_mut((k + 1) * width);
            let line = &mut above[k * width..];
            let inverse = Lanes::new(s, &line[k]).recip();
            for entry in &mut line[k + 1..] {
                *entry = (Lanes::new(s, entry) * inverse).nodes();
            }
            for other in below.chunks_exact_mut(width) {
                subtract(s, &line[k + 1..], &mut other[k..]);
            }
        }
        for k in (1..size).rev() {
            let (above, below) = matrix.split_at_mut(k * width);
            for other in above.chunks_exact_mut(width) {
                let factor = Lanes::new(s, &other[k]).neg();
                for j in size..width {
                    other[j] = factor.mul_add(Lanes::new(s, &below[j]), Lanes::new(s, &other[j])).nodes();
                }
            }
        }
    }

    /// Φ from the slopes on the Gauss nodes.
    #[inline(always)]
    fn carry_unit_vectors<S: Simd>(&mut self, s: S) {
        let Transport { linear, active, rows, lengths, method, matrix, entries, flow, .. } = self;
        let (m, rows, n) = (*active, *rows, flow.len());
        let size = rows * STAGES;
        let h = Lanes::new(s, lengths);
        for row in 0..rows {
            for j in 0..n {
                let (mut sum, mut moment) = (Lanes::splat(s, 0.0), Lanes::splat(s, 0.0));
                for stage in 0..STAGES {
                    let slope = Lanes::new(s, &matrix[(stage * rows + row) * (size + n) + size + j]);
                    let term = slope * method.weights[stage];
                    sum = sum + term;
                    moment = term.scale_add(1.0 - method.nodes[stage], moment);
                }
                match linear.order {
                    Order::First => entries[row * n + j] = sum.mul_add(h, unit(s, row, j)).nodes(),
                    Order::Second => {
                        let drift = if j == m + row { h } else { unit(s, row, j) };
                        entries[row * n + j] = moment.mul_add(h * h, drift).nodes();
                        entries[(m + row) * n + j] = sum.mul_add(h, unit(s, m + row, j)).nodes();
                    }
                }
            }
        }
    }

    /// The rows of ignorable coordinates, ∫ ∇r·δ: h Σ_i b_i ∇r_i·δ_i for each unit vector δ at the start.
    #[inline(always)]
    fn carry_ignorable<S: Simd>(&mut self, s: S) {
        let n = self.flow.len();
        let h = Lanes::new(s, &self.lengths);
        for j in 0..self.rates.len() {
            for column in 0..n {
                let mut sum = Lanes::splat(s, 0.0);
                for stage in 0..STAGES {
                    for k in 0..self.gradients[stage].len() {
                        let term = self.linear.rates[k];
                        if term.row == j {
                            let delta = self.error_at(s, stage, term.column, column);
                            let weight = self.method.weights[stage] * term.factor;
                            sum = (Lanes::new(s, &self.gradients[stage][k]) * weight).mul_add(delta, sum);
                        }
                    }
                }
                self.entries[(n + j) * n + column] = (sum * h).nodes();
            }
        }
    }

    /// δ of unknown k on a Gauss node, for a unit vector δ at the start.
    #[inline(always)]
    fn error_at<S: Simd>(&self, s: S, stage: usize, k: usize, column: usize) -> Lanes<S, AT_ONCE> {
        let Transport { linear, active, rows, lengths, method, matrix, flow, .. } = self;
        let (size, is_second, h) = (rows * STAGES, linear.order == Order::Second, Lanes::new(s, lengths));
        let (row, integral) = if k < *rows { (k, &method.integral[stage]) } else { (k - rows, &method.single[stage]) };
        let mut delta = Lanes::splat(s, 0.0);
        for other in 0..STAGES {
            let slope = Lanes::new(s, &matrix[(other * rows + row) * (size + flow.len()) + size + column]);
            delta = slope.scale_add(integral[other], delta);
        }
        delta = delta * h;
        if is_second && k < *active {
            delta = delta * h;
        }
        if is_second && column == active + k {
            delta = h.scale_add(method.nodes[stage], delta);
        }
        if column == k { delta + 1.0 } else { delta }
    }

    /// Makes Φ carry ẋ to the ends.
    #[inline(always)]
    fn correct<S: Simd>(&mut self, s: S) -> f64 {
        let n = self.flow.len();
        // At rest there is nothing to correct.
        let tiny = Lanes::splat(s, f64::MIN_POSITIVE);
        let (mut square, mut end_square, mut defect_square) = (tiny, tiny, Lanes::splat(s, 0.0));
        for k in 0..n {
            let f = starts(s, self.slopes(k)) * self.inverse_sizes[k];
            self.flow[k] = f.nodes();
            square = f.mul_add(f, square);
        }
        let inverse = square.recip();
        for k in 0..n + self.rates.len() {
            let end = if k < n {
                ends(s, self.slopes(k))
            } else {
                ends(s, &self.rates[k - n]) - starts(s, &self.rates[k - n])
            };
            let Transport { entries, inverse_sizes, flow, .. } = &mut *self;
            let row = &mut entries[k * n..][..n];
            let mut defect = end.neg();
            for j in 0..n {
                if inverse_sizes[j] > 0.0 {
                    let entry = Lanes::new(s, &row[j]) * (1.0 / inverse_sizes[j]);
                    defect = entry.mul_add(Lanes::new(s, &flow[j]), defect);
                }
            }
            let share = (defect * inverse).neg();
            for j in 0..n {
                let part = share * inverse_sizes[j];
                row[j] = part.mul_add(Lanes::new(s, &flow[j]), Lanes::new(s, &row[j])).nodes();
            }
            if k < n {
                let (end, defect) = (end * inverse_sizes[k], defect * inverse_sizes[k]);
                end_square = end.mul_add(end, end_square);
                defect_square = defect.mul_add(defect, defect_square);
            }
        }
        let relative = (defect_square * end_square.recip()).nodes();
        let mut largest = 0.0_f64;
        for &square in &relative.0[..self.count] {
            largest = if square.is_nan() { f64::INFINITY } else { largest.max(square) };
        }
        largest.sqrt()
    }
}

/// other −= other_0 line, but for its first entry.
#[inline(always)]
fn subtract<S: Simd>(s: S, line: &[Nodes<AT_ONCE>], other: &mut [Nodes<AT_ONCE>]) {
    let factor = Lanes::new(s, &other[0]).neg();
    for (to, by) in other[1..].iter_mut().zip(line) {
        *to = factor.mul_add(Lanes::new(s, by), Lanes::new(s, to)).nodes();
    }
}

#[inline(always)]
fn unit<S: Simd>(s: S, k: usize, j: usize) -> Lanes<S, AT_ONCE> {
    Lanes::splat(s, if k == j { 1.0 } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::{Order, Transport};
    use crate::engine::tests::{lifted, metric};
    use crate::geometry::{Geometry, Start};

    /// For an oscillator the matrix is a rotation, with an error of order h⁷, and its determinant is 1. The same in
    /// first order, which the mixed component of the metric needs.
    #[test]
    fn oscillators_are_carried_exactly() {
        let second = lifted("x^2/2", &["x"], &[0.5], &[0.1]);
        // H = p_t²/2 − p_x²/2 … with p_t = 1, in coordinates that turn with x.
        let first = metric(&["t", "x"], &[(0, 0, "1/(1 - x^2)"), (1, 1, "-1/(1 + x^2/9)")], &[0.0, 0.0], &[1.0, 0.0]);
        let rotation = |geometry: &Geometry, start: &Start, h: f64| {
            let mut transport = Transport::new(geometry, &start.p);
            transport.add_step(h);
            // Its points are at rest, where nothing is corrected.
            transport.solve();
            let entry = |k: usize, j: usize| transport.row(k)[j].0[0];
            assert!((entry(0, 0) * entry(1, 1) - entry(0, 1) * entry(1, 0) - 1.0).abs() < 1e-14);
            (0.5 * (entry(0, 0) + entry(1, 1)) - h.cos()).abs()
        };
        for (order, (geometry, start)) in [(Order::Second, second), (Order::First, first)] {
            assert_eq!(geometry.is_separable(), order == Order::Second);
            let rate = (rotation(&geometry, &start, 0.8) / rotation(&geometry, &start, 0.4)).log2();
            assert!((7.5..8.5).contains(&rate), "{rate}");
        }
    }
}
