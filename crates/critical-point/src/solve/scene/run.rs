//! Windows laid end to end.

use std::sync::Arc;

use super::failure;
use super::setup::{Place, SceneSetup};
use super::window::Window;
use super::world_line::{SceneWindow, WorldLine, relative};
use super::{doubled, explicit, leap, limit};
use crate::action::Form;
use crate::geometry::{Geometry, Start};
use crate::sbp::{SbpName, SbpOperator};
use crate::scalar::{Compensated, Real};
use crate::solve::System;
use crate::solve::failure::{At, NoSolution};
use crate::solve::operator::Operators;
use crate::solve::status::{InitialGuess, IterationRecord, Iterations, Status};

/// The critical point of one window, in which ignorable coordinates are counted from its start.
pub(super) struct Piece<S> {
    pub(super) q: Vec<Vec<S>>,
    /// p* of the active coordinates; nothing in the doubled system.
    pub(super) p: Vec<Vec<S>>,
    /// p*_a of all coordinates at the end.
    pub(super) end: Vec<S>,
    pub(super) backward: Vec<Vec<S>>,
    pub(super) multipliers: Vec<S>,
    pub(super) gradient_norm: S,
    pub(super) initial_guess: InitialGuess,
    pub(super) history: Vec<IterationRecord>,
}

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
        let window = Window { form, sbp: &*self.sbp, geometry, start: &start, digits };
        let rough = Window { form, sbp: &self.rough, geometry: rough_geometry, start: &rough_start, digits: 16 };
        let offset = (setup.gamma_i + run.gamma).to_f64();
        let piece = match setup.settings.system {
            System::PhysicalLimit => solve_limit(&window, &rough, setup.settings.max_iterations, offset),
            System::Doubled => doubled::solve(&window, &rough, setup, offset),
        }?;
        let operator = run.line.operators.place_of(&self.sbp);
        run.append(piece, operator, gamma)
    }
}

fn in_f64<S: Real>(start: &Start<S>) -> Start {
    let of = |values: &[S]| values.iter().map(|value| value.to_f64()).collect();
    Start { q: of(&start.q), q_dot: of(&start.q_dot), p: of(&start.p) }
}

fn solve_limit<S: Real>(
    window: &Window<'_, S, Geometry<S>>,
    rough: &Window<'_, f64, Geometry>,
    max_iterations: usize,
    gamma: f64,
) -> Result<Piece<S>, NoSolution> {
    let fields = 2 * window.geometry.active().len();
    let is_explicit = window.form == Form::Strong && window.sbp.is_two_step();
    let solved = limit::solve(window, rough, max_iterations).and_then(|limit| {
        // Other rules begin with a guess that follows the geodesic in ever finer steps.
        let leap = if is_explicit { leap::outside(window.geometry, &limit.q) } else { None };
        leap.map_or(Ok(limit), |point| Err(explicit::outside(point)))
    });
    let limit = solved.map_err(|failure| {
        let first = rough.derivative().first_unknown();
        let locate = |row: usize, u: &[f64]| {
            let node = row / fields;
            let state = node.checked_sub(first).and_then(|unknown| u.get(unknown * fields..)?.get(..fields / 2));
            (node, state.map_or(Vec::new(), <[f64]>::to_vec))
        };
        let guess = match (is_explicit, window.geometry.is_separable()) {
            (true, _) => InitialGuess::None,
            (false, true) => InitialGuess::Nystrom4,
            (false, false) => InitialGuess::RungeKutta4,
        };
        failure::iterated(rough, failure, guess, |node| gamma + rough.sbp.node(node), locate)
    })?;
    let multipliers = limit.multipliers(window);
    let action = window.action();
    let rows: Vec<&[S]> = limit.q.iter().map(Vec::as_slice).collect();
    let unknowns = action.layout().physical_limit(&rows, &multipliers);
    Ok(Piece {
        gradient_norm: action.gradient_norm(&unknowns),
        end: limit.last_momenta(window),
        q: limit.q,
        p: limit.p,
        backward: Vec::new(),
        multipliers,
        initial_guess: limit.initial_guess,
        history: limit.history,
    })
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
