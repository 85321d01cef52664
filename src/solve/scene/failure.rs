//! Why there is no world-line.

use std::fmt;

use super::window::Window;
use crate::geometry::{Geometry, OutsideGeometry};
use crate::solve::newton::Failure;
use crate::solve::status::{Compact, InitialGuess, IterationRecord, MOST_NODES, Status};

/// The reason why a scene has no critical point, and where the solve stood.
#[derive(Debug, Clone, PartialEq)]
pub struct NoWorldLine {
    /// Any status but [`Status::Converged`].
    pub status: Status,
    /// γ of the node where it failed: of the point outside the domain, otherwise of the largest residual entry.
    pub gamma: f64,
    /// The names of the coordinates with their values there, where they are known.
    pub point: Vec<(String, f64)>,
    /// The names of the coordinates in the block of the metric whose determinant has the wrong sign, and that
    /// determinant. No names where another number is not finite.
    pub block: Option<(Vec<String>, f64)>,
    /// Iterations done.
    pub iteration: usize,
    /// Largest residual entry at the last accepted iterate (infinite if none was accepted).
    pub residual: f64,
    /// Whether an accuracy was asked for, so that windows and operator were not the user's to choose.
    pub adaptive: bool,
    /// The iterations.
    pub history: Vec<IterationRecord>,
    /// Where they started.
    pub initial_guess: InitialGuess,
}

impl NoWorldLine {
    /// A failed iteration in terms of the scene. `gamma` is γ of a node from the start of the run, and `locate` maps an
    /// index of the residual to its node and, if they are known, the active coordinates there.
    pub(super) fn new(
        window: &Window<'_, f64, Geometry>,
        failure: Failure<OutsideGeometry>,
        initial_guess: InitialGuess,
        gamma: impl Fn(usize) -> f64,
        locate: impl Fn(usize, &[f64]) -> (usize, Vec<f64>),
    ) -> Self {
        let Failure { status, unknowns, residual, outside, history } = failure;
        let worst = (0..residual.len()).max_by(|&a, &b| residual[a].abs().total_cmp(&residual[b].abs()));
        let outside = outside.filter(|_| status == Status::OutsideDomain);
        let (index, values) = match outside {
            Some(point) => (point.index, Vec::new()),
            None => worst.filter(|_| !unknowns.is_empty()).map_or((0, Vec::new()), |row| locate(row, &unknowns)),
        };
        let names = window.geometry.names();
        let active = window.geometry.active().iter().map(|&a| names[a].clone());
        let block = outside.map(|point| {
            let coordinates = point.block.map_or([].as_slice(), |block| &window.geometry.blocks()[block]);
            (coordinates.iter().map(|&a| names[a].clone()).collect(), point.determinant)
        });
        Self {
            status,
            gamma: gamma(index),
            point: active.zip(values).collect(),
            block,
            iteration: history.len(),
            residual: worst.map_or(f64::INFINITY, |index| residual[index].abs()),
            adaptive: false,
            history,
            initial_guess,
        }
    }

    /// A failure that has nothing but a status and a place.
    pub(super) fn at(status: Status, gamma: f64) -> Self {
        Self {
            status,
            gamma,
            point: Vec::new(),
            block: None,
            iteration: 0,
            residual: f64::INFINITY,
            adaptive: false,
            history: Vec::new(),
            initial_guess: InitialGuess::None,
        }
    }

    /// The same of a solve to an accuracy.
    pub(super) fn adaptive(status: Status, gamma: f64) -> Self {
        Self { adaptive: true, initial_guess: InitialGuess::Extrapolation, ..Self::at(status, gamma) }
    }

    /// What to try next.
    pub fn advice(&self) -> &'static str {
        if self.adaptive {
            return self.advice_to_an_accuracy();
        }
        match self.status {
            Status::Converged => "",
            Status::OutsideDomain => {
                "end the run before this gamma, choose initial data that stay away from the place, or coordinates in \
                 which the metric is regular there; if the geometry is harmless there, the step is too coarse: raise \
                 n_gamma or windows"
            }
            Status::EndTimeNotReached => "give gamma_f or an end that is reached earlier, or raise n_gamma or windows",
            Status::MaxIterations => {
                "raise solver.max_iterations, or n_gamma or windows so that every turn of the motion is resolved"
            }
            Status::PrecisionNotReached => {
                "ask for fewer solver.digits; if f64 is in difficulties too (solver.digits = 16), raise n_gamma or \
                 windows so that every turn of the motion is resolved"
            }
            _ => {
                "raise n_gamma or windows (or shorten gamma_f) so that every turn of the motion is resolved, or try \
                 another operator"
            }
        }
    }
}

impl NoWorldLine {
    /// What to try next where the program chooses the windows.
    fn advice_to_an_accuracy(&self) -> &'static str {
        match self.status {
            Status::Converged => "",
            Status::OutsideDomain => {
                "end the run before this gamma, choose initial data that stay away from the place, or coordinates in \
                 which the metric is regular there"
            }
            Status::EndTimeNotReached => "give gamma_f or an end that is reached earlier",
            Status::TooManyNodes => "end the run earlier, or ask for a larger solver.accuracy",
            Status::AccuracyNotReached => {
                "ask for a larger solver.accuracy, or a shorter run; with scheme and grid given, solver.digits goes further"
            }
            _ => {
                "end the run before this gamma, or look at the scene there: it is not smooth enough for an accuracy; far \
                 from 1, choose units nearer to it"
            }
        }
    }
}

impl fmt::Display for NoWorldLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { status, gamma, point, block, iteration, residual, .. } = self;
        let gamma = Compact(*gamma);
        let mut place = String::new();
        for (name, value) in point {
            place += &format!(", {name} = {}", Compact(*value));
        }
        match (status, block) {
            (Status::OutsideDomain, Some((names, determinant))) if !names.is_empty() => write!(
                f,
                "the geodesic leaves the domain at gamma = {gamma}{place}: the determinant of the metric in ({}) is \
                 {determinant:.3e}",
                names.join(", ")
            ),
            (Status::OutsideDomain, _) => {
                write!(f, "the geodesic leaves the domain at gamma = {gamma}{place}: a number is not finite")
            }
            (Status::EndTimeNotReached, _) => {
                write!(f, "the end is not reached: the search ended at gamma = {gamma}{place}")
            }
            (Status::AccuracyNotReached, _) => {
                write!(
                    f,
                    "the accuracy is not reached: the estimated error is {residual:.1e} at gamma = {gamma}{place}"
                )
            }
            (Status::TooManyNodes, _) => {
                write!(
                    f,
                    "stopped at gamma = {gamma}{place}: the run has more nodes than the {MOST_NODES:.0e} that are kept in memory"
                )
            }
            (Status::EvaluationLimit, _) => {
                write!(f, "stopped after {iteration} evaluations at gamma = {gamma}{place}: the run makes no progress")
            }
            _ if self.adaptive => write!(
                f,
                "no critical point found ({status}): no window, however short, converges at gamma = {gamma}{place}"
            ),
            _ => write!(
                f,
                "no critical point found ({status}) after {iteration} iterations: largest residual {residual:.2e} at \
                 gamma = {gamma}{place}"
            ),
        }
    }
}

impl std::error::Error for NoWorldLine {}
