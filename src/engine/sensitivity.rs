//! The growth of small changes along a run.

/// The derivative of positions and momenta at the joints of windows with respect to those at the start, and what
/// becomes of one tangent vector δ.
///
/// With every active coordinate and momentum divided by its size at the start, δ begins with equal parts of all of
/// them. With L = ln |δ|/|δ₀| the mean exponential growth factor is
///
/// ```text
/// Y(γ) = 2/γ ∫ (d ln |δ|/dγ) γ dγ = 2 (L − 1/γ ∫ L dγ),        MEGNO = 1/γ ∫ Y dγ
/// ```
///
/// (P. M. Cincotta and C. Simó, Astron. Astrophys. Suppl. 147 (2000) 205): it tends to 2 where motion is regular, to 0
/// where nothing grows, and grows like γ/2 times the Lyapunov exponent where motion is chaotic.
#[derive(Debug, Clone)]
pub struct Sensitivity {
    /// The number of active coordinates and momenta.
    unknowns: usize,
    /// The matrices of all joints by rows, the unit matrix of the start first, or that of the last joint alone.
    joints: Vec<f64>,
    keeps_all: bool,
    /// δ/|δ|, and 1/size of each unknown, which is known from the first window on.
    pub(super) tangent: Vec<f64>,
    pub(super) inverse_sizes: Vec<f64>,
    /// γ from the start, L, ∫ L dγ and ∫ Y dγ.
    pub(super) gamma: f64,
    pub(super) growth: f64,
    pub(super) integral: f64,
    pub(super) mean: f64,
}

impl Sensitivity {
    /// The start of a run with so many active coordinates. The matrices of all joints are kept, or the last one alone.
    pub fn new(active: usize, keeps_all: bool) -> Self {
        let unknowns = 2 * active;
        let (tangent, inverse_sizes) = (Vec::new(), Vec::new());
        let joints = (0..unknowns * unknowns).map(|at| f64::from(u8::from(at % (unknowns + 1) == 0))).collect();
        let [gamma, growth, integral, mean] = [0.0; 4];
        Self { unknowns, joints, keeps_all, tangent, inverse_sizes, gamma, growth, integral, mean }
    }

    /// Goes back to the start.
    pub(super) fn begin(&mut self) {
        *self = Self::new(self.unknowns / 2, self.keeps_all);
    }

    /// The matrices at the start and at the ends of windows, by rows: positions, then momenta. They end before a number
    /// in them overflows.
    pub fn joints(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.joints.chunks_exact((self.unknowns * self.unknowns).max(1))
    }

    /// True if there is nothing to change but what nothing depends on.
    pub(super) fn is_empty(&self) -> bool {
        self.unknowns == 0
    }

    /// The largest Lyapunov exponent, L/γ; 0 at the start.
    pub fn lyapunov(&self) -> f64 {
        if self.gamma > 0.0 { self.growth / self.gamma } else { 0.0 }
    }

    /// The mean exponential growth factor; 0 at the start.
    pub fn megno(&self) -> f64 {
        if self.gamma > 0.0 { self.mean / self.gamma } else { 0.0 }
    }

    /// Begins δ, where sizes are known.
    pub(super) fn set_sizes(&mut self, inverse_sizes: Vec<f64>) {
        let part = (self.unknowns as f64).sqrt();
        self.tangent = inverse_sizes.iter().map(|inverse| 1.0 / (part * inverse)).collect();
        self.inverse_sizes = inverse_sizes;
    }

    /// Goes to the end of a window that carries changes by this matrix.
    pub(super) fn append(&mut self, window: &[f64]) {
        let n = self.unknowns;
        let carried = |row: &[f64]| row.iter().zip(&self.tangent).map(|(factor, part)| factor * part).sum();
        self.tangent = window.chunks_exact(n).map(carried).collect();
        let square = self.tangent.iter().zip(&self.inverse_sizes).map(|(part, inverse)| (part * inverse).powi(2));
        let length = square.sum::<f64>().sqrt();
        self.growth += length.ln();
        self.tangent.iter_mut().for_each(|part| *part /= length);
        let last = self.joints.len() - n * n;
        for row in window.chunks_exact(n) {
            for column in last..last + n {
                let values = self.joints[column..last + n * n].iter().step_by(n);
                let entry = row.iter().zip(values).map(|(factor, value)| factor * value).sum();
                self.joints.push(entry);
            }
        }
        if self.joints[last + n * n..].iter().any(|entry| !entry.is_finite()) {
            self.joints.truncate(last + n * n);
        } else if !self.keeps_all {
            self.joints.drain(..n * n);
        }
    }
}
