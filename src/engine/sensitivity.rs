//! The growth of small changes along a run.

/// The growth of small changes from the start to a joint of windows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Growth {
    /// γ from the start of the run.
    pub gamma: f64,
    /// The largest Lyapunov exponent, L/γ; 0 at the start.
    pub lyapunov: f64,
    /// The mean exponential growth factor; 0 at the start.
    pub megno: f64,
}

/// The derivative of positions and momenta at the joints of windows with respect to those at the start, and what
/// becomes of one tangent vector δ.
///
/// Growth is that of the motion alone: the coordinate t and its momentum count nowhere, unless nothing else is active.
/// Without friction that is no other exponent, but what a force takes from a motion it takes not from these two: they
/// stay as they are, and would hide that everything else comes to rest.
///
/// With every unknown that counts divided by its size at the start, δ begins with equal parts of all of them, and is
/// made as long as that again after every window. With L = ln |δ|/|δ₀| the mean exponential growth factor is
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
    /// True once a number of them has left the range of numbers.
    is_lost: bool,
    /// It begins with this behind an event.
    first: Option<Box<Self>>,
    /// δ/|δ|, and 1/size of each unknown, which is known from the first window on.
    pub(super) tangent: Vec<f64>,
    pub(super) inverse_sizes: Vec<f64>,
    /// The same of unknowns that count, and 0 for the others.
    pub(super) measures: Vec<f64>,
    /// The unknowns that what counts depends on.
    steers: Vec<bool>,
    /// Growth at the same joints.
    growths: Vec<Growth>,
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
        let [tangent, inverse_sizes, measures] = [const { Vec::new() }; 3];
        let (steers, growths) = (Vec::new(), vec![Growth::default()]);
        let joints = (0..unknowns * unknowns).map(|at| f64::from(u8::from(at % (unknowns + 1) == 0))).collect();
        let [gamma, growth, integral, mean] = [0.0; 4];
        Self {
            unknowns,
            joints,
            keeps_all,
            is_lost: false,
            first: None,
            tangent,
            inverse_sizes,
            measures,
            steers,
            growths,
            gamma,
            growth,
            integral,
            mean,
        }
    }

    /// Goes back to the start, or to the event behind which it began.
    pub(super) fn begin(&mut self) {
        let first = self.first.take();
        *self = first.as_deref().cloned().unwrap_or_else(|| Self::new(self.unknowns / 2, self.keeps_all));
        self.first = first;
    }

    /// Carries it behind an event with this matrix, by rows: positions, then momenta. The first joint of the new one is
    /// there.
    pub(crate) fn behind(&self, saltation: &[f64]) -> Self {
        let mut next = Self { first: None, ..self.clone() };
        if !next.is_empty() {
            next.append(saltation);
        }
        let of_one = if next.is_lost { 0 } else { self.unknowns.pow(2) };
        next.joints.drain(..next.joints.len() - of_one);
        next.growths.drain(..next.growths.len() - 1);
        Self { first: Some(Box::new(next.clone())), ..next }
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

    /// Growth at the start and at the ends of all windows, or at the last end alone.
    pub fn growths(&self) -> &[Growth] {
        &self.growths
    }

    /// Growth at the end of the last window.
    pub fn growth(&self) -> Growth {
        self.growths.last().copied().unwrap_or_default()
    }

    /// Begins δ, where sizes are known, in the unknowns that count. What they depend on is `steers`.
    pub(super) fn set_sizes(&mut self, inverse_sizes: Vec<f64>, counts: &[bool], steers: &[bool]) {
        let part = (counts.iter().filter(|counts| **counts).count() as f64).sqrt();
        let counted = || inverse_sizes.iter().zip(counts);
        self.tangent = counted().map(|(inverse, counts)| if *counts { 1.0 / (part * inverse) } else { 0.0 }).collect();
        self.measures = counted().map(|(&inverse, counts)| if *counts { inverse } else { 0.0 }).collect();
        self.steers = steers.to_vec();
        self.inverse_sizes = inverse_sizes;
    }

    /// Goes to the end of a window that carries changes by this matrix.
    pub(super) fn append(&mut self, window: &[f64]) {
        let n = self.unknowns;
        let carried = |row: &[f64]| row.iter().zip(&self.tangent).map(|(factor, part)| factor * part).sum();
        self.tangent = window.chunks_exact(n).map(carried).collect();
        let square = self.tangent.iter().zip(&self.measures).map(|(part, inverse)| (part * inverse).powi(2));
        let length = square.sum::<f64>().sqrt();
        self.growth += length.ln();
        // What nothing depends on may grow beside δ until it leaves the range of numbers.
        for (part, steers) in self.tangent.iter_mut().zip(&self.steers) {
            *part = if *steers { *part / length } else { 0.0 };
        }
        let [lyapunov, megno] =
            [self.growth, self.mean].map(|sum| if self.gamma > 0.0 { sum / self.gamma } else { 0.0 });
        self.growths.push(Growth { gamma: self.gamma, lyapunov, megno });
        if !self.keeps_all {
            self.growths.remove(0);
        }
        if self.is_lost {
            return;
        }
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
            self.is_lost = true;
        } else if !self.keeps_all {
            self.joints.drain(..n * n);
        }
    }
}
