//! The error of a run, coordinate by coordinate, and what found it.

/// The distance of a run from the world-line of the continuum.
#[derive(Debug, Clone, PartialEq)]
pub struct RunError {
    /// By how much each coordinate is off at the last node. If the value of a coordinate ended the run, points with
    /// that value are compared, and it has no error there.
    pub end: Vec<f64>,
    /// The largest of the same over the nodes, of which the last is compared as for `end`.
    pub largest: Vec<f64>,
    /// By how much the judge may be off itself, in the unit of each coordinate.
    pub own: Vec<f64>,
    /// The judge that the run was compared with.
    pub judge: Judge,
    /// The share of its way by which the motion may be off because the judge stepped over a feature. In scenes it is 0
    /// where a force acts, which changes K, and in extended precision.
    pub stepped_over: f64,
}

/// The judge that a run is compared with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Judge {
    /// A second solve with this estimated relative error.
    SecondSolve(f64),
    /// A Taylor trajectory with this estimated relative error.
    Taylor(f64),
    /// The estimate that every run to an accuracy makes on its way.
    OwnEstimate,
}

impl Judge {
    /// A phrase for display.
    pub fn describe(self) -> String {
        match self {
            // Its last digits depend on the order of sums.
            Self::SecondSolve(error) => format!("from a second solve to {:.0e}", 10.0_f64.powf(error.log10().ceil())),
            Self::Taylor(error) => format!("from a Taylor series good to {error:.0e}"),
            Self::OwnEstimate => "from the run's own estimate".to_owned(),
        }
    }

    /// Its relative error.
    pub fn relative_error(self) -> f64 {
        match self {
            Self::SecondSolve(error) | Self::Taylor(error) => error,
            Self::OwnEstimate => 0.0,
        }
    }
}

impl Judge {
    /// The judge that a Taylor trajectory is.
    pub fn reference_error(self) -> Option<f64> {
        if let Self::Taylor(error) = self { Some(error) } else { None }
    }
}

impl RunError {
    /// Upper estimates of the absolute errors of the coordinates at the last node.
    pub fn at_most_at_end(&self) -> Vec<f64> {
        self.with_own(&self.end)
    }

    /// Upper estimates of the largest absolute errors of the coordinates over the nodes.
    pub fn at_most(&self) -> Vec<f64> {
        self.with_own(&self.largest)
    }

    fn with_own(&self, found: &[f64]) -> Vec<f64> {
        found.iter().zip(&self.own).map(|(found, own)| found + own).collect()
    }
}

/// The errors found so far, node by node.
#[derive(Debug)]
pub(super) struct Found {
    largest: Vec<f64>,
    last: Vec<f64>,
}

impl Found {
    /// None yet, of so many coordinates.
    pub(super) fn none(coordinates: usize) -> Self {
        Self { largest: vec![0.0; coordinates], last: vec![0.0; coordinates] }
    }

    /// Takes the next node into account, which is off by this.
    pub(super) fn see(&mut self, off: impl IntoIterator<Item = f64>) {
        for ((largest, last), off) in self.largest.iter_mut().zip(&mut self.last).zip(off) {
            *last = off.abs();
            // A comparison that is false for NaN would drop it.
            *largest = if *last > *largest || last.is_nan() { *last } else { *largest };
        }
    }

    /// All nodes have been seen.
    pub(super) fn finish(self, own: Vec<f64>, judge: Judge, stepped_over: f64) -> RunError {
        RunError { end: self.last, largest: self.largest, own, judge, stepped_over }
    }
}
