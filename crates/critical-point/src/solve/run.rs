//! Windows laid end to end.

use std::sync::Arc;

use super::failure::NoSolution;
use super::operator::Operators;
use super::piece::Piece;
use super::problem::Problem;
use super::setup::Scene;
use super::solution::{Backward, EndState, Joint, Solution, Window};
use super::space::Space;
use super::status::{InitialGuess, Iterations, Status};
use crate::action::{Form, MULTIPLIERS};
use crate::geodesic::InitialData;
use crate::sbp::SbpName;
use crate::scalar::Real;

/// Sees a run window by window, each as a solution of its own.
pub(super) type Observer<'o, S> = &'o mut dyn FnMut(&Solution<S>);

/// Where a window lies in the run: γ − γ_i and t − t_i at its start and its end.
pub(super) struct Place<S> {
    pub(super) gamma: [S; 2],
    pub(super) time: [S; 2],
}

impl<S: Real> Place<S> {
    /// Whether the parts of the action are within the range of numbers: Q_t (t − t_i) from the start of the run, and
    /// (dx/dγ)² over the window, by what `x_dot` is at its end.
    pub(super) fn has_finite_action(&self, q_t: S, x_dot: S) -> bool {
        let length = self.gamma[1] - self.gamma[0];
        (q_t * self.time[1]).is_finite() && (x_dot * x_dot * length).is_finite()
    }
}

/// The windows so far: all of them or, where they are observed one by one, the last.
pub(super) struct Run<'o, S> {
    pub(super) solution: Solution<S>,
    capacity: usize,
    observer: Option<Observer<'o, S>>,
}

impl<'o, S: Real> Run<'o, S> {
    /// An empty run of `scene`, with this form and operator, which will have about so many nodes; where windows are
    /// observed, as many as one of them has.
    pub(super) fn new(
        scene: &Scene<S>,
        (form, sbp_name): (Form, SbpName),
        digits: u32,
        nodes: usize,
        observer: Option<Observer<'o, S>>,
    ) -> Self {
        let initial = InitialData { t: S::ZERO, ..scene.initial };
        let q_t = initial.invariants(&scene.metric).q_t;
        let solution = Solution {
            t_i: scene.initial.t,
            elapsed: Vec::new(),
            x: Vec::new(),
            backward: None,
            windows: Vec::new(),
            window_count: 0,
            gradient_norm: S::ZERO,
            end: EndState { t: S::ZERO, x: S::ZERO, x_dot: S::ZERO, q_t },
            iterations: Iterations::from(InitialGuess::None),
            gamma_i: scene.gamma_i,
            length: S::ZERO,
            digits,
            error_estimate: None,
            windows_unproved: None,
            accuracy: None,
            form,
            sbp_name,
            operators: Operators::none(),
            metric: Arc::clone(&scene.metric),
            initial,
        };
        Self { solution, capacity: nodes, observer }
    }

    /// Makes room for all nodes of so many `windows` at once.
    pub(super) fn reserve(&mut self, windows: usize) {
        self.solution.elapsed.reserve_exact(self.capacity);
        self.solution.x.reserve_exact(self.capacity);
        self.solution.windows.reserve_exact(windows);
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
    /// Numbers that are not finite are not a result: an overflow anywhere makes the gradient NaN or infinite, or
    /// the action.
    pub(super) fn append(&mut self, problem: &Problem<S>, place: Place<S>, piece: Piece<S>) -> Result<(), NoSolution> {
        let last = problem.sbp.points() - 1;
        // p_x = −dx/dγ.
        let (q_t, end) = (piece.end[0], [piece.q[1][last], -piece.end[1]]);
        if !(piece.gradient_norm.is_finite() && place.has_finite_action(q_t, end[1])) {
            return Err(overflow(problem, piece));
        }
        let ends = [[problem.initial.x, problem.initial.x_dot], end];
        let operator = self.solution.operators.place_of(&problem.sbp);
        self.begin_window(operator, &place, ends, piece.multipliers.try_into().ok());
        let run = &mut self.solution;
        run.end.q_t = q_t;
        run.gradient_norm = run.gradient_norm.max(piece.gradient_norm);
        run.iterations.add(piece.initial_guess, piece.history);
        for (all, row) in [&mut run.elapsed, &mut run.x].into_iter().zip(piece.q) {
            collect(all, row, self.capacity);
        }
        if !piece.backward.is_empty() {
            let backward = run.backward.get_or_insert(Backward { elapsed: Vec::new(), x: Vec::new() });
            for (all, row) in [&mut backward.elapsed, &mut backward.x].into_iter().zip(piece.backward) {
                collect(all, row, self.capacity);
            }
        }
        self.end_window();
        Ok(())
    }

    /// Begins a window at this place, with x and dx/dγ at its ends. Its rows are to be appended to the solution, and
    /// then [`Self::end_window`] is to be called.
    pub(super) fn begin_window(
        &mut self,
        operator: usize,
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
    let finite = |k: &usize| piece.q.iter().all(|row| row[*k].is_finite());
    let points = piece.q[0].len();
    let index = (0..points).find(|k| !finite(k)).unwrap_or(points - 1);
    let q: Vec<S> = piece.q.iter().map(|row| row[index]).collect();
    let at = problem.metric.place_of_overflow(problem.gamma(index).to_f64(), &q);
    NoSolution {
        residual: piece.gradient_norm.to_f64(),
        iterations: Box::new(Iterations::of(piece.initial_guess, piece.history)),
        ..NoSolution::new(Status::OutsideDomain, at)
    }
}

#[cfg(test)]
mod tests {
    use super::Place;

    /// t counts from the start of the run, and x over the window alone.
    #[test]
    fn an_action_is_one_of_numbers() {
        let place = |time: f64| Place { gamma: [9e5, 1e6], time: [0.0, time] };
        assert!(place(1e200).has_finite_action(1e100, 1e151));
        assert!(!place(1e210).has_finite_action(1e100, 1e151) && !place(1e200).has_finite_action(1e100, 1e152));
    }
}
