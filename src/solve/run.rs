//! Windows laid end to end.

use std::sync::Arc;

use super::problem::Problem;
use super::setup::Setup;
use super::solution::{Backward, EndState, Joint, Solution, Window};
use super::status::{InitialGuess, IterationRecord, NoSolution, Status};
use crate::action::MULTIPLIERS;
use crate::sbp::SbpOperator;
use crate::scalar::Real;

/// Sees a run window by window, each as a solution of its own.
pub(super) type Observer<'o, S> = &'o mut dyn FnMut(&Solution<S>);

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

/// Where a window lies in the run: γ − γ_i and t − t_i at its start and its end.
pub(super) struct Place<S> {
    pub(super) gamma: [S; 2],
    pub(super) time: [S; 2],
}

/// The windows so far: all of them or, where they are observed one by one, the last.
pub(super) struct Run<'o, S> {
    pub(super) solution: Solution<S>,
    capacity: usize,
    observer: Option<Observer<'o, S>>,
}

impl<'o, S: Real> Run<'o, S> {
    /// An empty run of `case` over `length` that starts with `problem` and has this many nodes.
    pub(super) fn new(
        problem: &Problem<S>,
        setup: &Setup<S>,
        length: S,
        capacity: usize,
        observer: Option<Observer<'o, S>>,
    ) -> Self {
        let end = EndState { t: S::ZERO, x: S::ZERO, x_dot: S::ZERO, q_t: S::ZERO };
        let solution = Solution {
            t_i: setup.scene.initial.t,
            elapsed: Vec::new(),
            x: Vec::new(),
            backward: None,
            windows: Vec::new(),
            window_count: 0,
            gradient_norm: S::ZERO,
            end,
            initial_guess: InitialGuess::None,
            iterations: 0,
            history: Vec::new(),
            last_correction: 0.0,
            gamma_i: problem.gamma_i,
            length,
            digits: problem.digits,
            error_estimate: None,
            accuracy: None,
            form: problem.form,
            sbp_name: problem.sbp_name,
            operators: Vec::new(),
            metric: Arc::clone(&problem.metric),
            initial: problem.initial,
        };
        let capacity = if observer.is_some() { problem.sbp.points() } else { capacity };
        Self { solution, capacity, observer }
    }

    /// Makes room for all nodes of so many `windows` at once.
    pub(super) fn reserve(&mut self, windows: usize) {
        self.solution.elapsed.reserve_exact(self.capacity);
        self.solution.x.reserve_exact(self.capacity);
        self.solution.windows.reserve_exact(if self.observer.is_some() { 1 } else { windows });
    }

    /// Forgets the windows so far: the run begins again.
    pub(super) fn clear(&mut self) {
        let run = &mut self.solution;
        run.elapsed.clear();
        run.x.clear();
        run.windows.clear();
        (run.window_count, run.gradient_norm) = (0, 0.0.into());
    }

    /// Adds the solution of `problem`.
    ///
    /// # Errors
    /// Numbers that are not finite are not a result: an overflow anywhere makes the gradient NaN or infinite.
    pub(super) fn append(&mut self, problem: &Problem<S>, place: Place<S>, piece: Piece<S>) -> Result<(), NoSolution> {
        if !(piece.gradient_norm.is_finite() && place.time[1].is_finite()) {
            return Err(overflow(problem, piece));
        }
        let ends = [[problem.initial.x, problem.initial.x_dot], piece.end];
        self.begin_window(&problem.sbp, &place, ends, piece.multipliers);
        let run = &mut self.solution;
        (run.form, run.sbp_name) = (problem.form, problem.sbp_name);
        run.end.q_t = piece.q_t;
        run.gradient_norm = run.gradient_norm.max(piece.gradient_norm);
        run.initial_guess = piece.initial_guess;
        run.last_correction = run.last_correction.max(piece.history.last().map_or(0.0, |last| last.relative_step));
        run.iterations += piece.history.len();
        if piece.history.len() > run.history.len() {
            run.history = piece.history;
        }
        collect(&mut run.elapsed, piece.elapsed, self.capacity);
        collect(&mut run.x, piece.x, self.capacity);
        if let Some(piece) = piece.backward {
            let backward = run.backward.get_or_insert(Backward { elapsed: Vec::new(), x: Vec::new() });
            collect(&mut backward.elapsed, piece.elapsed, self.capacity);
            collect(&mut backward.x, piece.x, self.capacity);
        }
        self.end_window();
        Ok(())
    }

    /// Begins a window at this place, with x and dx/dγ at its ends. Its rows are to be appended to the solution, and
    /// then [`Self::end_window`] is to be called.
    pub(super) fn begin_window(
        &mut self,
        sbp: &Arc<SbpOperator<S>>,
        &Place { gamma, time }: &Place<S>,
        [from, to]: [[S; 2]; 2],
        multipliers: Option<[S; MULTIPLIERS]>,
    ) {
        let run = &mut self.solution;
        if self.observer.is_some() {
            run.elapsed.clear();
            run.x.clear();
            run.backward = None;
            run.windows.clear();
        }
        let known = run.operators.iter().rposition(|operator| Arc::ptr_eq(operator, sbp));
        let operator = known.unwrap_or_else(|| {
            run.operators.push(Arc::clone(sbp));
            run.operators.len() - 1
        });
        let joint = |t: S, [x, x_dot]: [S; 2]| Joint { t, x, x_dot };
        let (start, end, first_node) = (joint(time[0], from), joint(time[1], to), run.x.len());
        run.windows.push(Window { gamma, start, end, multipliers: multipliers.map(Box::new), first_node, operator });
        run.window_count += 1;
        run.end = EndState { t: run.t_i + end.t, x: end.x, x_dot: end.x_dot, ..run.end };
    }

    /// Shows the window that was begun last to the observer.
    pub(super) fn end_window(&mut self) {
        if let Some(observer) = &mut self.observer {
            observer(&self.solution);
        }
    }
}

/// Appends `piece` to `all`; the only window of a run is moved, not copied.
fn collect<S: Real>(all: &mut Vec<S>, piece: Vec<S>, capacity: usize) {
    if piece.len() == capacity {
        *all = piece;
    } else {
        all.reserve_exact(capacity.saturating_sub(all.len()).max(piece.len()));
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
        needed: 0.0,
        adaptive: false,
    }
}
