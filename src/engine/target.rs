//! The value of a coordinate at which a run ends.

/// The value of a coordinate at which a run ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Target {
    pub(super) coordinate: usize,
    pub(super) value: f64,
    /// The coordinate at the start.
    pub(super) from: f64,
    /// The least distance so far, and the number of windows since.
    pub(super) nearest: f64,
    pub(super) idle: usize,
}

impl Target {
    pub(super) fn new(coordinate: usize, value: f64, from: f64) -> Self {
        Self { coordinate, value, from, nearest: f64::INFINITY, idle: 0 }
    }

    pub(super) fn begin(&mut self) {
        (self.nearest, self.idle) = (f64::INFINITY, 0);
    }

    /// The length of the run, if it is at `q` after a part of the length γ.
    pub(super) fn foreseen(&self, q: f64, gamma: f64) -> f64 {
        let done = (q - self.from) / (self.value - self.from);
        if done > 0.0 { gamma / done.min(1.0) } else { f64::INFINITY }
    }
}
