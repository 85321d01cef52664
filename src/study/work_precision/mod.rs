//! Speed against accuracy: every scheme of this program beside other methods, on the world-line of one case or scene.
//!
//! Every method has to return t, x and w = dx/dγ, in a scene all coordinates and momenta, at [`OUTPUTS`] equally spaced
//! values of γ, the end included. If it has a dense output, it uses that; otherwise its steps or windows divide the
//! intervals between these values. The errors are the largest absolute differences of the coordinates from a Taylor
//! trajectory in extended precision, and the largest of them ranks a setting. Charges are *not* compared: they are
//! constants in the equations of the other methods, so that their drift would prove nothing.
//!
//! The schemes of this program are timed as [`crate::solve()`], with its certificate and everything that it stores.
//! `accuracy` keeps its promise: windows of [`crate::engine`] with their certificates and the estimate of their errors,
//! begun again where those are too large. `tolerance` and `march` are its windows alone, for a tolerance of each and of
//! one length. What these three find at the points of output is kept, and nothing else.
//!
//! One process and one thread are used. Each setting is tried once, which warms up the machine and shows the cost and
//! the accuracy. Then come rounds over all settings that succeeded. In each round they take turns, so that a
//! disturbance affects all methods alike. The minimum and the median over the rounds are reported; their difference
//! shows the noise. A setting that failed or is inaccurate keeps the time of its trial and is never part of the front.
//!
//! The settings of a method end when a setting costs more than [`Budget::longest`] or its errors have stopped falling.
//! Methods whose iteration has a tolerance of its own (`march` and Gauss) get the loosest one that hardly changes the
//! error of the same setting iterated to rounding: the best choice that a user could make, for both alike.

mod arena;
mod drift;
mod trial;

pub use super::method::Method;
pub use arena::Arena;
pub use drift::{DriftPoint, drift};

use self::trial::{time, try_method};
use crate::number::norm::larger;

/// Number of points at which every method reports its state.
pub const OUTPUTS: usize = 10;

/// The amount of what is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Budget {
    /// Seconds that a single run may take. After a longer one, no further setting of its method is tried.
    pub longest: f64,
    /// Number of rounds for runs below a millisecond. Runs below ten milliseconds have half of them and longer runs a
    /// fifth, but at least three.
    pub rounds: usize,
    /// Largest number of settings of a method.
    pub settings: usize,
}

impl Default for Budget {
    fn default() -> Self {
        Self { longest: 0.15, rounds: 15, settings: 40 }
    }
}

/// The outcome of a setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RowStatus {
    /// With a result.
    Converged,
    /// With errors as large as the result: above a tenth of the largest |x| or |t − t_i|, or of a coordinate of a
    /// scene.
    Inaccurate,
    /// Without a result. The word is that of [`crate::Status`] or of [`crate::methods::Failure`].
    Failed(&'static str),
}

impl RowStatus {
    /// The name used in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::Inaccurate => "inaccurate",
            Self::Failed(word) => word,
        }
    }
}

/// Largest errors at the points of output.
#[derive(Debug, Clone, PartialEq)]
pub struct RowErrors {
    /// The largest error of every coordinate: of t and x, or of those of a scene.
    pub q: Vec<f64>,
    /// max |K − K(start)|; where a force acts, the largest error of K.
    pub delta_k: f64,
}

impl RowErrors {
    /// The largest error of a coordinate, by which rows are ranked.
    pub fn largest(&self) -> f64 {
        self.q.iter().copied().fold(0.0, larger)
    }
}

/// One method in one setting.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The method.
    pub method: Method,
    /// Its setting, for display.
    pub setting: String,
    /// γ_f − γ_i.
    pub gamma_f: f64,
    /// The errors, if there is a result.
    pub errors: Option<RowErrors>,
    /// Least seconds of a run.
    pub seconds_min: f64,
    /// Median over the rounds.
    pub seconds_median: f64,
    /// Number of evaluations of the potential: one per node in each sweep or iteration of Newton's method, without
    /// those of the first guess and the certificate. For a series, the number of its coefficients.
    pub evaluations: usize,
    /// Number of nodes, or of steps.
    pub points: usize,
    /// Its outcome.
    pub status: RowStatus,
}

impl Row {
    /// The error by which it is ranked; `None` without a result.
    pub fn rank(&self) -> Option<f64> {
        self.errors.as_ref().filter(|_| self.status == RowStatus::Converged).map(RowErrors::largest)
    }
}

/// The measured rows, for one length or several.
#[derive(Debug, Clone, Default)]
pub struct WorkPrecision {
    /// All rows: methods in order, settings from cheap to expensive.
    pub rows: Vec<Row>,
    /// True if it is not complete.
    pub interrupted: bool,
}

/// Reports of what has been done. They contain all rows, so that a listener has them at any time.
#[derive(Debug, Clone, PartialEq)]
pub enum Progress {
    /// A setting was tried, which gives another row.
    Tried(Row),
    /// The row with this index has been timed again.
    Retimed(usize, Row),
    /// The number of rounds that are done, and the number of all rounds.
    Round(usize, usize),
}

/// Tries all settings of `methods` and times those that succeed.
pub fn measure(
    arena: &Arena,
    methods: &[Method],
    budget: &Budget,
    progress: &mut dyn FnMut(Progress),
) -> WorkPrecision {
    let mut trials = Vec::new();
    for method in methods {
        trials.extend(try_method(arena, method, budget, &mut |row| progress(Progress::Tried(row.clone()))));
    }
    time(&mut trials, budget, progress);
    WorkPrecision { rows: trials.into_iter().map(|trial| trial.row).collect(), interrupted: false }
}

/// The rows that no other row beats in both error and `cost`, from small errors to large ones.
pub fn front<'a>(rows: impl IntoIterator<Item = &'a Row>, cost: impl Fn(&Row) -> f64) -> Vec<&'a Row> {
    let mut ranked: Vec<(f64, &Row)> = rows.into_iter().filter_map(|row| Some((row.rank()?, row))).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(cost(a.1).total_cmp(&cost(b.1))));
    // After the first one, each row that is kept is cheaper than all more accurate ones.
    let mut cheapest = f64::INFINITY;
    let is_cheaper = |row: &&Row| {
        let before = cheapest;
        cheapest = before.min(cost(row));
        cost(row) < before
    };
    ranked.into_iter().map(|(_, row)| row).filter(is_cheaper).collect()
}

/// Compares this program with the others, at one error.
#[derive(Debug, Clone, PartialEq)]
pub struct Ratio<'r> {
    /// γ_f − γ_i.
    pub gamma_f: f64,
    /// The error of every coordinate that is allowed.
    pub error: f64,
    /// The fastest method of this program, its library included.
    pub own: Option<&'r Row>,
    /// The fastest certified method of this program.
    pub certified: Option<&'r Row>,
    /// The fastest of the other methods.
    pub other: Option<&'r Row>,
}

impl Ratio<'_> {
    /// Seconds of the others over seconds of this program, which leads if that is above 1.
    pub fn lead(&self) -> Option<f64> {
        Some(self.other?.seconds_min / self.own?.seconds_min)
    }

    /// The same ratio for certified solutions only.
    pub fn certified_lead(&self) -> Option<f64> {
        Some(self.other?.seconds_min / self.certified?.seconds_min)
    }
}

/// The comparison at the errors 1e-3, 1e-4, … 1e-12, for every length in `rows`.
pub fn ratios(rows: &[Row]) -> Vec<Ratio<'_>> {
    let mut lengths: Vec<f64> = rows.iter().map(|row| row.gamma_f).collect();
    lengths.sort_by(f64::total_cmp);
    lengths.dedup();
    let of = |gamma_f: f64, decade: i32| {
        let error = 10.0_f64.powi(-decade);
        let fastest = |wanted: &dyn Fn(&Row) -> bool| {
            let enough = |row: &&Row| row.gamma_f == gamma_f && row.rank().is_some_and(|rank| rank <= error);
            let rows = rows.iter().filter(enough).filter(|row| wanted(row));
            rows.min_by(|a, b| a.seconds_min.total_cmp(&b.seconds_min))
        };
        Ratio {
            gamma_f,
            error,
            own: fastest(&|row| row.method.is_own()),
            certified: fastest(&|row| row.method.is_certified()),
            other: fastest(&|row| !row.method.is_own()),
        }
    };
    lengths.into_iter().flat_map(|length| (3..=12).map(move |decade| of(length, decade))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::Peer;

    #[test]
    fn the_front_has_what_nothing_beats() {
        let row = |method: Method, error: f64, seconds: f64| Row {
            method,
            setting: String::new(),
            gamma_f: 1.0,
            errors: Some(RowErrors { q: vec![error, 0.5 * error], delta_k: 0.0 }),
            seconds_min: seconds,
            seconds_median: seconds,
            evaluations: 0,
            points: 0,
            status: if error < 1e-10 { RowStatus::Inaccurate } else { RowStatus::Converged },
        };
        let rows = [
            row(Method::Peer(Peer::Rk4), 1e-4, 1.0),
            row(Method::Peer(Peer::Rk4), 1e-8, 10.0),
            row(Method::March(8), 1e-8, 8.0),
            row(Method::March(8), 1e-6, 9.0),
            row(Method::Elements(8), 1e-8, 16.0),
            row(Method::Peer(Peer::Verlet), 1e-12, 0.1),
            row(Method::Peer(Peer::Verlet), 1e-3, 2.0),
        ];
        let found: Vec<f64> = front(&rows, |row| row.seconds_min).iter().map(|row| row.seconds_min).collect();
        assert_eq!(found, [8.0, 1.0]);
        let table = ratios(&rows);
        assert_eq!((table.len(), table[0].error), (10, 1e-3));
        assert_eq!((table[0].lead(), table[0].certified_lead()), (Some(1.0 / 8.0), Some(1.0 / 16.0)));
        assert_eq!(table[5].lead(), Some(10.0 / 8.0));
        assert!(table[6].own.is_none() && table[6].other.is_none() && table[6].lead().is_none());
    }
}
