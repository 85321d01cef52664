//! Small errors δ carried over steps of a motion: δ(end) = Φ δ(start), for several steps at once, a lane for each.
//!
//! Between the ends of a step the motion is the polynomial of degree 5 with their x, ẋ and ẍ. On it the linearised
//! equations δ̇ = J δ (or δ̈ = J δ) are solved by Gauss collocation with three nodes, of order 6, whose linear system
//! is solved directly:
//!
//! ```text
//! k_i − h Σ_j A_ij J_i k_j = J_i δ,                   Φ δ = δ + h Σ_i b_i k_i
//! k_i − h² Σ_j (A²)_ij J_i k_j = J_i (δ + h c_i δ̇),
//!     Φ (δ, δ̇) = (δ + h δ̇ + h² Σ_i b_i (1 − c_i) k_i, δ̇ + h Σ_i b_i k_i)
//! ```
//!
//! The method is symplectic. The exact Φ carries f = ẋ to the end of the step. The defect d = Φ f − f(end) tells how
//! good Φ is, and Φ ← Φ − d fᵀ/|f|² carries it exactly, |f| with unknowns relative to their sizes. Without this, errors
//! of the growth along f multiply, and steady growth becomes exponential, or ends.
//!
//! An ignorable coordinate with the rate r has a row of Φ too, ∫ ∇r·δ by the Gauss rule, which carries f to
//! r(end) − r(start).

mod solve;

use super::rule::Order;
use super::system::Linear;
use crate::geometry::Geometry;
use crate::number::vector::{Level, Nodes};

/// Steps in a batch.
pub(super) const AT_ONCE: usize = 16;

/// One number for each end of a step; the end of a step is the start of the next one.
type Points = [f64; AT_ONCE + 1];

/// Gauss nodes of a step.
const STAGES: usize = 3;

/// Gauss collocation on [0, 1], and the polynomial between two points.
struct Method {
    nodes: [f64; STAGES],
    weights: [f64; STAGES],
    /// A, or A² for equations of second order.
    integral: [[f64; STAGES]; STAGES],
    /// A.
    single: [[f64; STAGES]; STAGES],
    /// The weights of (x, h ẋ, h² ẍ) at the start and at the end in x at a node.
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

/// The matrices Φ of a batch of steps.
pub(super) struct Transport<'g> {
    linear: Linear<'g, AT_ONCE>,
    /// True if values are to be mended.
    pub(super) is_mended: bool,
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
    /// h ∫ Σ (J x)², the sum over the terms of J, by rows.
    gains: Vec<Nodes<AT_ONCE>>,
    /// Φ by rows, those of ignorable coordinates last.
    entries: Vec<Nodes<AT_ONCE>>,
    /// ẋ of all unknowns at the starts.
    flow: Vec<Nodes<AT_ONCE>>,
}

impl<'g> Transport<'g> {
    /// No steps yet. `momenta` are those of all coordinates, of which ignorable ones stay.
    pub(super) fn new(geometry: &'g Geometry, momenta: &[f64]) -> Self {
        let linear = Linear::new(geometry, momenta);
        let (active, ignorable) = (geometry.active().len(), geometry.ignorable().count());
        let rows = if linear.order == Order::First { 2 * active } else { active };
        let (unknowns, size, terms) = (2 * active, rows * STAGES, linear.rates.len());
        Self {
            method: Method::new(linear.order),
            linear,
            is_mended: false,
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

    /// The change of unknown k that relative errors of the values, each with a sign of its own, make by way of the
    /// slopes, in a step of so many windows.
    #[inline(always)]
    pub(super) fn gain(&self, k: usize, step: usize, windows: f64) -> f64 {
        let gain = |row: usize| (self.gains[row].0[step] / windows).sqrt();
        match self.linear.order {
            Order::First => gain(k),
            Order::Second if k < self.active => self.lengths.0[step] * gain(k),
            Order::Second => gain(k - self.active),
        }
    }

    /// Row k of Φ, of all steps; rows 2m … are those of ignorable coordinates.
    #[inline(always)]
    pub(super) fn row(&self, k: usize) -> &[Nodes<AT_ONCE>] {
        let n = self.flow.len();
        &self.entries[k * n..][..n]
    }

    /// ∂H/∂(unknown k) = (−ṗ, q̇) at a point.
    #[inline(always)]
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
        Level::Best.dispatch(self)
    }
}
