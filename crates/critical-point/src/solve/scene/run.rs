//! Windows laid end to end.

use std::sync::Arc;

use super::setup::{Place, SceneSetup};
use super::world_line::{SceneWindow, WorldLine, relative};
use crate::geometry::Start;
use crate::sbp::{SbpName, SbpOperator};
use crate::scalar::{Compensated, Real};
use crate::solve::System;
use crate::solve::failure::{At, NoSolution};
use crate::solve::operator::Operators;
use crate::solve::piece::{Pair, Piece};
use crate::solve::status::{InitialGuess, Iterations, Status};
use crate::solve::window::Window;

/// A world-line as far as it is solved.
pub(super) struct Run<S> {
    pub(super) line: WorldLine<S>,
    /// Where the next window starts.
    pub(super) here: Start<S>,
    /// Ignorable coordinates are summed so that nothing is lost over a million windows.
    sums: Vec<Compensated<S>>,
    /// γ − γ_i there.
    pub(super) gamma: S,
}

impl<S: Real> Run<S> {
    /// One without windows, which is to end after `length`.
    pub(super) fn new(setup: &SceneSetup<S>, length: S) -> Self {
        let here = setup.place.start.clone();
        let sums = here.q.iter().map(|&q| Compensated::from(q)).collect();
        Self { line: empty(setup, length), here, sums, gamma: S::ZERO }
    }

    /// Adds the next window, which has the operator at `operator` of the world-line and ends at γ − γ_i = `gamma`.
    ///
    /// # Errors
    /// Numbers that are not finite, or an end outside the domain, are not a result.
    pub(super) fn append(&mut self, piece: Piece<S>, operator: usize, gamma: S) -> Result<(), NoSolution> {
        let Place { geometry, start: first } = &self.line.place;
        let mut end = Start { q: Vec::with_capacity(first.q.len()), q_dot: Vec::new(), p: piece.end.clone() };
        for (a, (sum, row)) in self.sums.iter_mut().zip(&piece.q).enumerate() {
            let last = row[row.len() - 1];
            *sum = if geometry.active().contains(&a) { Compensated::from(last) } else { sum.plus(last) };
            end.q.push(sum.high);
        }
        let mut rates = geometry.field().room();
        let outside = geometry.field().evaluate(&end.q, &end.p, &mut rates).is_err();
        // The action from the start, ∫ p_a dq^a, may be beyond the range of numbers although every window is not.
        let is_finite = end.q.iter().zip(&end.p).all(|(&q, &p)| (p * q).is_finite());
        if outside || !piece.gradient_norm.is_finite() || !is_finite {
            let at = At::scene((self.line.gamma_i + gamma).to_f64(), Vec::new());
            return Err(NoSolution::new(Status::OutsideDomain, at));
        }
        end.q_dot = (0..end.q.len()).map(|a| geometry.field().q_dot(&rates, a)).collect();
        let start = std::mem::replace(&mut self.here, end.clone());
        append(&mut self.line, piece, operator, [self.gamma, gamma], [start, end]);
        self.gamma = gamma;
        Ok(())
    }
}

/// Solves a scene on γ − γ_i ∈ [0, `length`], window after window.
pub(super) fn solve_to<S: Real>(setup: &SceneSetup<S>, length: S) -> Result<WorldLine<S>, NoSolution> {
    let window_length = length / S::from(setup.settings.windows as f64);
    let operators = OnGrid::new(setup.settings.sbp, setup.settings.n_gamma, window_length);
    let mut run = Run::new(setup, length);
    for index in 1..=setup.settings.windows {
        let end = if index == setup.settings.windows { length } else { S::from(index as f64) * window_length };
        operators.solve(setup, &mut run, end)?;
    }
    Ok(run.line)
}

/// The operator of windows of one length, and the same in `f64`.
struct OnGrid<S> {
    sbp: Arc<SbpOperator<S>>,
    rough: SbpOperator,
}

impl<S: Real> OnGrid<S> {
    fn new(name: SbpName, points: usize, length: S) -> Self {
        let spacing = length / S::from((points - 1) as f64);
        let valid = "a valid setup has enough points";
        let rough = name.operator(points, spacing.to_f64()).expect(valid);
        Self { sbp: Arc::new(name.operator(points, spacing).expect(valid)), rough }
    }

    /// Solves the window that continues `run` and ends at γ − γ_i = `gamma`.
    fn solve(&self, setup: &SceneSetup<S>, run: &mut Run<S>, gamma: S) -> Result<(), NoSolution> {
        let (form, digits) = (setup.settings.form, setup.settings.digits);
        let (geometry, rough_geometry) = (&*setup.place.geometry, &*setup.rough.geometry);
        let is_first = run.line.windows.is_empty();
        let rough_here = if is_first { setup.rough.start.clone() } else { in_f64(&run.here) };
        let (start, rough_start) = (relative(geometry, &run.here), relative(rough_geometry, &rough_here));
        let is_regularised = true;
        let pair = Pair {
            window: Window { form, sbp: &*self.sbp, geometry, start: &start, is_regularised, digits },
            rough: Window {
                form,
                sbp: &self.rough,
                geometry: rough_geometry,
                start: &rough_start,
                is_regularised,
                digits: 16,
            },
            gamma: (setup.gamma_i + run.gamma).to_f64(),
            max_iterations: setup.settings.max_iterations,
        };
        let piece = match setup.settings.system {
            System::PhysicalLimit => pair.physical_limit(),
            System::Doubled => pair.doubled(),
        }?;
        let operator = run.line.operators.place_of(&self.sbp);
        run.append(piece, operator, gamma)
    }
}

fn in_f64<S: Real>(start: &Start<S>) -> Start {
    let of = |values: &[S]| values.iter().map(|value| value.to_f64()).collect();
    Start { q: of(&start.q), q_dot: of(&start.q_dot), p: of(&start.p) }
}

fn empty<S: Real>(setup: &SceneSetup<S>, length: S) -> WorldLine<S> {
    let (n, m) = (setup.place.start.q.len(), setup.place.geometry.active().len());
    let is_doubled = setup.settings.system == System::Doubled;
    WorldLine {
        place: setup.place.clone(),
        gamma_i: setup.gamma_i,
        length,
        q: vec![Vec::new(); n],
        p: vec![Vec::new(); if is_doubled { 0 } else { m }],
        backward: vec![Vec::new(); if is_doubled { n } else { 0 }],
        windows: Vec::with_capacity(setup.settings.windows),
        gradient_norm: S::ZERO,
        iterations: Iterations::from(InitialGuess::None),
        digits: setup.settings.digits,
        error_estimate: None,
        windows_unproved: None,
        accuracy: None,
        ended_by: None,
        ended_at: None,
        form: setup.settings.form,
        sbp_name: setup.settings.sbp,
        operators: Operators::none(),
    }
}

fn append<S: Real>(
    line: &mut WorldLine<S>,
    piece: Piece<S>,
    operator: usize,
    gamma: [S; 2],
    [start, end]: [Start<S>; 2],
) {
    let first_node = line.q[0].len();
    line.windows.push(SceneWindow { gamma, start, end, multipliers: piece.multipliers, first_node, operator });
    line.gradient_norm = line.gradient_norm.max(piece.gradient_norm);
    line.iterations.add(piece.initial_guess, piece.history);
    let rows = line.q.iter_mut().zip(piece.q);
    let rows = rows.chain(line.p.iter_mut().zip(piece.p)).chain(line.backward.iter_mut().zip(piece.backward));
    for (all, mut row) in rows {
        if all.is_empty() {
            *all = row;
        } else {
            all.append(&mut row);
        }
    }
}
