//! Windows laid end to end.

use super::problem::Problem;
use super::solution::{Backward, Window};
use super::status::{InitialGuess, IterationRecord, NoSolution, Status};
use crate::action::MULTIPLIERS;
use crate::geodesic::InitialData;
use crate::scalar::{Compensated, Real};

/// The critical point of one window. Its time counts from its start.
pub(super) struct Piece<S> {
    pub(super) elapsed: Vec<S>,
    pub(super) x: Vec<S>,
    pub(super) backward: Option<Backward<S>>,
    pub(super) multipliers: Option<[S; MULTIPLIERS]>,
    pub(super) gradient_norm: S,
    /// x_N and w*_N.
    pub(super) end: [S; 2],
    pub(super) q_t: S,
    pub(super) initial_guess: InitialGuess,
    pub(super) history: Vec<IterationRecord>,
}

/// The windows so far.
pub(super) struct Run<S> {
    pub(super) elapsed: Vec<S>,
    pub(super) x: Vec<S>,
    pub(super) backward: Option<Backward<S>>,
    pub(super) windows: Vec<Window<S>>,
    pub(super) gradient_norm: S,
    pub(super) q_t: S,
    pub(super) initial_guess: InitialGuess,
    pub(super) iterations: usize,
    pub(super) history: Vec<IterationRecord>,
    pub(super) last_correction: f64,
    /// The time at the end, summed so that a million windows lose nothing.
    time: Compensated<S>,
    capacity: usize,
}

impl<S: Real> Run<S> {
    /// Nothing yet of a run of so many nodes.
    pub(super) fn new(capacity: usize) -> Self {
        Self {
            elapsed: Vec::new(),
            x: Vec::new(),
            backward: None,
            windows: Vec::new(),
            gradient_norm: S::ZERO,
            q_t: S::ZERO,
            initial_guess: InitialGuess::None,
            iterations: 0,
            history: Vec::new(),
            last_correction: 0.0,
            time: Compensated::default(),
            capacity,
        }
    }

    /// x and w* to continue with.
    pub(super) fn end(&self) -> [S; 2] {
        self.windows.last().map_or([S::ZERO; 2], |window| [window.end.0, window.end.1])
    }

    /// t_N − t_i.
    pub(super) fn elapsed(&self) -> S {
        self.time.high
    }

    /// Replaces the sum of the windows' times by one that was kept with more digits.
    pub(super) fn set_time(&mut self, elapsed: S) {
        self.time = Compensated::from(elapsed);
    }

    /// Adds the solution of `problem`.
    ///
    /// # Errors
    /// Numbers that are not finite are no result: an overflow anywhere makes the gradient NaN or infinite.
    pub(super) fn append(&mut self, problem: &Problem<S>, piece: Piece<S>) -> Result<(), NoSolution> {
        let duration = piece.elapsed.last().copied().unwrap_or(S::ZERO);
        if !(piece.gradient_norm.is_finite() && duration.is_finite()) {
            return Err(overflow(problem, piece));
        }
        let start = InitialData { t: self.time.high, ..problem.initial };
        self.windows.push(Window { start, end: (piece.end[0], piece.end[1]), multipliers: piece.multipliers });
        self.time = self.time.plus(duration);
        self.gradient_norm = self.gradient_norm.max(piece.gradient_norm);
        (self.q_t, self.initial_guess) = (piece.q_t, piece.initial_guess);
        self.last_correction = self.last_correction.max(piece.history.last().map_or(0.0, |last| last.relative_step));
        self.iterations += piece.history.len();
        if piece.history.len() > self.history.len() {
            self.history = piece.history;
        }
        collect(&mut self.elapsed, piece.elapsed, self.capacity);
        collect(&mut self.x, piece.x, self.capacity);
        if let Some(piece) = piece.backward {
            let backward = self.backward.get_or_insert(Backward { elapsed: Vec::new(), x: Vec::new() });
            collect(&mut backward.elapsed, piece.elapsed, self.capacity);
            collect(&mut backward.x, piece.x, self.capacity);
        }
        Ok(())
    }
}

/// Appends `piece` to `all`; the only window of a run is moved, not copied.
fn collect<S: Real>(all: &mut Vec<S>, piece: Vec<S>, capacity: usize) {
    if piece.len() == capacity {
        *all = piece;
    } else {
        all.reserve_exact(capacity - all.len());
        all.extend(piece);
    }
}

fn overflow<S: Real>(problem: &Problem<S>, piece: Piece<S>) -> NoSolution {
    let finite = |k: &usize| piece.x[*k].is_finite() && piece.elapsed[*k].is_finite();
    let index = (0..piece.x.len()).find(|k| !finite(k)).unwrap_or(piece.x.len() - 1);
    NoSolution {
        status: Status::OutsideDomain,
        gamma: problem.gamma(index).to_f64(),
        x: piece.x[index].to_f64(),
        g00: problem.metric.at(piece.x[index]).g00.to_f64(),
        iteration: piece.history.len(),
        residual: piece.gradient_norm.to_f64(),
        history: piece.history,
        initial_guess: piece.initial_guess,
    }
}
