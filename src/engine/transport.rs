//! Small errors δ carried over steps of a motion: δ(end) = Φ δ(start), for several steps at once, a lane for each.
//!
//! Between the ends of a step the motion is the polynomial of degree 5 with their x, ẋ and ẍ. On it the linearised
//! equations δ̇ = J δ (or δ̈ = J δ) are solved by Gauss collocation with three nodes, of order 6, whose linear system is
//! solved directly:
//!
//! ```text
//! k_i − h Σ_j A_ij J_i k_j = J_i δ,                   Φ δ = δ + h Σ_i b_i k_i
//! k_i − h² Σ_j (A²)_ij J_i k_j = J_i (δ + h c_i δ̇),   Φ (δ, δ̇) = (δ + h δ̇ + h² Σ_i b_i (1 − c_i) k_i, δ̇ + h Σ_i b_i k_i)
//! ```
//!
//! The method is symplectic. The exact Φ carries f = ẋ to the end of the step. The defect d = Φ f − f(end) tells how good
//! Φ is, and Φ ← Φ − d fᵀ/|f|² carries it exactly, |f| with unknowns relative to their sizes. Without this, errors of the
//! growth along f multiply, and steady growth becomes exponential, or ends.
//!
//! An ignorable coordinate with the rate r has a row of Φ too, ∫ ∇r·δ by the Gauss rule, which carries f to
//! r(end) − r(start).

use pulp::{Simd, WithSimd};

use super::kernel::Evaluate;
use super::linear::Linear;
use super::rule::Order;
use crate::geometry::{Geometry, Start};
use crate::number::vector::{Lanes, Level, Nodes};

/// Steps in a batch.
pub(super) const AT_ONCE: usize = 16;

/// Gauss nodes of a step.
const STAGES: usize = 3;

/// One number for each end of a step; the end of a step is the start of the next one.
type Points = [f64; AT_ONCE + 1];

/// The matrices Φ of a batch of steps.
pub(super) struct Transport<'g> {
    linear: Linear<'g, AT_ONCE>,
    /// Number m of active coordinates, and of rows that sweeps iterate.
    active: usize,
    rows: usize,
    /// x, ẋ and ẍ of each row.
    pub(super) points: Vec<[Points; 3]>,
    /// The rates of ignorable coordinates.
    pub(super) rates: Vec<Points>,
    /// 1/size of each unknown.
    pub(super) inverse_sizes: Vec<f64>,
    pub(super) lengths: Nodes<AT_ONCE>,
    pub(super) count: usize,
    method: Method,
    /// The linear system by rows, with its right-hand sides.
    matrix: Vec<Nodes<AT_ONCE>>,
    /// Derivatives of rates on the Gauss nodes, in the order of their terms.
    gradients: [Vec<Nodes<AT_ONCE>>; STAGES],
    /// ∫ |J||x| by rows.
    gains: Vec<Nodes<AT_ONCE>>,
    /// Φ by rows, those of ignorable coordinates last.
    entries: Vec<Nodes<AT_ONCE>>,
    /// ẋ of all unknowns at the starts.
    flow: Vec<Nodes<AT_ONCE>>,
}

impl<'g> Transport<'g> {
    /// No steps yet.
    pub(super) fn new(geometry: &'g Geometry, start: &Start) -> Self {
        let mut linear = Linear::new(geometry);
        linear.begin(start);
        let (active, ignorable) = (geometry.active().len(), geometry.ignorable().count());
        let rows = if linear.order == Order::First { 2 * active } else { active };
        let (unknowns, size, terms) = (2 * active, rows * STAGES, linear.rates.len());
        Self {
            method: Method::new(linear.order),
            linear,
            active,
            rows,
            points: vec![[[0.0; AT_ONCE + 1]; 3]; rows],
            rates: vec![[0.0; AT_ONCE + 1]; ignorable],
            inverse_sizes: vec![1.0; unknowns],
            lengths: Nodes::ZERO,
            count: 0,
            matrix: vec![Nodes::ZERO; size * (size + unknowns)],
            gradients: std::array::from_fn(|_| vec![Nodes::ZERO; terms]),
            gains: vec![Nodes::ZERO; rows],
            entries: vec![Nodes::ZERO; (unknowns + ignorable) * unknowns],
            flow: vec![Nodes::ZERO; unknowns],
        }
    }

    /// Adds the step to the next point.
    pub(super) fn add_step(&mut self, h: f64) {
        self.lengths.0[self.count] = h;
        self.count += 1;
    }

    /// Begins the next batch where this one ends.
    pub(super) fn restart(&mut self) {
        for points in self.points.iter_mut().flatten().chain(&mut self.rates) {
            points[0] = points[self.count];
        }
        self.count = 0;
    }

    /// The lengths of all steps together.
    pub(super) fn length(&self) -> f64 {
        self.lengths.0[..self.count].iter().sum()
    }

    /// ∫ |J||x| over a step: what relative errors of the values make of unknown k by way of the slopes.
    pub(super) fn gain(&self, k: usize, step: usize) -> f64 {
        match self.linear.order {
            Order::First => self.gains[k].0[step],
            Order::Second if k < self.active => self.lengths.0[step] * self.gains[k].0[step],
            Order::Second => self.gains[k - self.active].0[step],
        }
    }

    /// Φ_kj of a step; k = 2m … are ignorable coordinates.
    pub(super) fn entry(&self, k: usize, j: usize, step: usize) -> f64 {
        self.entries[k * self.flow.len() + j].0[step]
    }

    /// ∂H/∂(unknown k) = (−ṗ, q̇) at a point.
    pub(super) fn gradient(&self, k: usize, point: usize) -> f64 {
        let m = self.active;
        if k < m { -self.slopes(m + k)[point] } else { self.slopes(k - m)[point] }
    }

    /// ẋ of unknown k.
    #[inline(always)]
    fn slopes(&self, k: usize) -> &Points {
        if k < self.rows { &self.points[k][1] } else { &self.points[k - self.rows][2] }
    }

    /// Computes Φ of all steps. Returns the largest defect, relative to ẋ.
    pub(super) fn solve(&mut self) -> f64 {
        Level::Best.dispatch(Solve(self))
    }
}

/// Computes Φ of the steps of a batch.
struct Solve<'a, 'g>(&'a mut Transport<'g>);

impl WithSimd for Solve<'_, '_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, s: S) -> f64 {
        for stage in 0..STAGES {
            self.evaluate(s, stage);
            self.set_up(s, stage);
        }
        self.eliminate(s);
        self.carry_unit_vectors(s);
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

impl Solve<'_, '_> {
    /// The Jacobian on a Gauss node of each step.
    #[inline(always)]
    fn evaluate<S: Simd>(&mut self, s: S, stage: usize) {
        let Transport { linear, rows, points, lengths, method, gradients, .. } = &mut *self.0;
        let (h, [start, end]) = (Lanes::new(s, lengths), &method.hermite[stage]);
        for row in 0..*rows {
            let mut value = Lanes::splat(s, 0.0);
            for k in (0..3).rev() {
                let points = &points[row][k];
                value = value.mul_add(h, starts(s, points) * start[k] + ends(s, points) * end[k]);
            }
            linear.registers[linear.unknowns[row]] = value.nodes();
        }
        let Linear { registers, steps, .. } = linear;
        Evaluate { registers, steps }.with_simd(s);
        for (gradient, term) in gradients[stage].iter_mut().zip(&linear.rates) {
            *gradient = linear.registers[term.register];
        }
    }

    /// The rows of the linear system for the slopes on that node, with a right-hand side for each unit vector δ.
    #[inline(always)]
    fn set_up<S: Simd>(&mut self, s: S, stage: usize) {
        let Transport { linear, active, rows, lengths, method, matrix, gains, .. } = &mut *self.0;
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
            let x = Lanes::new(s, &linear.registers[linear.unknowns[term.column]]) * method.weights[stage];
            gains[term.row] = ((j * x * h).abs() + Lanes::new(s, &gains[term.row])).nodes();
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
        let Transport { rows, matrix, flow, .. } = &mut *self.0;
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
        let Transport { linear, active, rows, lengths, method, matrix, entries, flow, .. } = &mut *self.0;
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
        let n = self.0.flow.len();
        let h = Lanes::new(s, &self.0.lengths);
        for j in 0..self.0.rates.len() {
            for column in 0..n {
                let mut sum = Lanes::splat(s, 0.0);
                for stage in 0..STAGES {
                    for k in 0..self.0.gradients[stage].len() {
                        let term = self.0.linear.rates[k];
                        if term.row == j {
                            let delta = self.error_at(s, stage, term.column, column);
                            let weight = self.0.method.weights[stage] * term.factor;
                            sum = (Lanes::new(s, &self.0.gradients[stage][k]) * weight).mul_add(delta, sum);
                        }
                    }
                }
                self.0.entries[(n + j) * n + column] = (sum * h).nodes();
            }
        }
    }

    /// δ of unknown k on a Gauss node, for a unit vector δ at the start.
    #[inline(always)]
    fn error_at<S: Simd>(&self, s: S, stage: usize, k: usize, column: usize) -> Lanes<S, AT_ONCE> {
        let Transport { linear, active, rows, lengths, method, matrix, flow, .. } = &*self.0;
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
        let n = self.0.flow.len();
        // At rest there is nothing to correct.
        let tiny = Lanes::splat(s, f64::MIN_POSITIVE);
        let (mut square, mut end_square, mut defect_square) = (tiny, tiny, Lanes::splat(s, 0.0));
        for k in 0..n {
            let f = starts(s, self.0.slopes(k)) * self.0.inverse_sizes[k];
            self.0.flow[k] = f.nodes();
            square = f.mul_add(f, square);
        }
        let inverse = square.recip();
        for k in 0..n + self.0.rates.len() {
            let end = if k < n {
                ends(s, self.0.slopes(k))
            } else {
                ends(s, &self.0.rates[k - n]) - starts(s, &self.0.rates[k - n])
            };
            let Transport { entries, inverse_sizes, flow, .. } = &mut *self.0;
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
        for &square in &relative.0[..self.0.count] {
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

/// Gauss collocation on [0, 1], and the polynomial between two points.
#[derive(Debug)]
struct Method {
    nodes: [f64; STAGES],
    weights: [f64; STAGES],
    /// A, or A² for equations of second order.
    integral: [[f64; STAGES]; STAGES],
    /// A.
    single: [[f64; STAGES]; STAGES],
    /// What (x, h ẋ, h² ẍ) at the start and at the end add to x at a node.
    hermite: [[[f64; 3]; 2]; STAGES],
}

impl Method {
    fn new(order: Order) -> Self {
        let r = 15.0_f64.sqrt();
        let nodes = [0.5 - r / 10.0, 0.5, 0.5 + r / 10.0];
        let a = [
            [5.0 / 36.0, 2.0 / 9.0 - r / 15.0, 5.0 / 36.0 - r / 30.0],
            [5.0 / 36.0 + r / 24.0, 2.0 / 9.0, 5.0 / 36.0 - r / 24.0],
            [5.0 / 36.0 + r / 30.0, 2.0 / 9.0 + r / 15.0, 5.0 / 36.0],
        ];
        let square = |i: usize, j: usize| (0..STAGES).map(|k| a[i][k] * a[k][j]).sum();
        let integral = match order {
            Order::First => a,
            Order::Second => std::array::from_fn(|i| std::array::from_fn(|j| square(i, j))),
        };
        // The start's polynomials, whose mirror images are those of the end.
        let side = |c: f64| {
            let rest = (1.0 - c).powi(3);
            [rest * (1.0 + 3.0 * c + 6.0 * c * c), rest * c * (1.0 + 3.0 * c), 0.5 * rest * c * c]
        };
        let hermite = nodes.map(|c| {
            let [x, slope, second] = side(1.0 - c);
            [side(c), [x, -slope, second]]
        });
        Self { nodes, weights: [5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0], integral, single: a, hermite }
    }
}

#[cfg(test)]
mod tests {
    use super::{Level, Method, Order, STAGES, Simd, Solve, Transport, WithSimd};
    use crate::engine::tests::{lifted, metric};
    use crate::geometry::{Geometry, Start};

    /// Φ without its correction.
    struct Uncorrected<'a, 'g>(&'a mut Transport<'g>);

    impl WithSimd for Uncorrected<'_, '_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, s: S) {
            let mut solve = Solve(self.0);
            for stage in 0..STAGES {
                solve.evaluate(s, stage);
                solve.set_up(s, stage);
            }
            solve.eliminate(s);
            solve.carry_unit_vectors(s);
        }
    }

    /// The polynomial of degree 5 is exact for c⁵.
    #[test]
    fn motion_between_points_is_a_polynomial() {
        let method = Method::new(Order::First);
        for (c, [_, end]) in method.nodes.iter().zip(method.hermite) {
            assert!((end[0] + 5.0 * end[1] + 20.0 * end[2] - c.powi(5)).abs() < 1e-15);
        }
    }

    /// For an oscillator the matrix is a rotation, with an error of order h⁷, and its determinant is 1. The same in first
    /// order, which the mixed component of the metric needs.
    #[test]
    fn oscillators_are_carried_exactly() {
        let second = lifted("x^2/2", &["x"], &[0.5], &[0.1]);
        // H = p_t²/2 − p_x²/2 … with p_t = 1, in coordinates that turn with x.
        let first = metric(&["t", "x"], &[(0, 0, "1/(1 - x^2)"), (1, 1, "-1/(1 + x^2/9)")], &[0.0, 0.0], &[1.0, 0.0]);
        let rotation = |geometry: &Geometry, start: &Start, h: f64| {
            let mut transport = Transport::new(geometry, start);
            transport.add_step(h);
            Level::Best.dispatch(Uncorrected(&mut transport));
            let entry = |k, j| transport.entry(k, j, 0);
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
