//! Windows laid end to end.

use std::sync::Arc;

use super::failure::NoWorldLine;
use super::setup::{Place, SceneSetup};
use super::window::Window;
use super::world_line::{SceneWindow, WorldLine, relative};
use super::{doubled, limit};
use crate::action::Form;
use crate::geometry::{Geometry, Start};
use crate::sbp::SbpOperator;
use crate::scalar::{Compensated, Real};
use crate::solve::System;
use crate::solve::status::{InitialGuess, IterationRecord, Status};

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

/// Solves a scene on γ − γ_i ∈ [0, `length`], window after window.
pub(super) fn solve_to<S: Real>(setup: &SceneSetup<S>, length: S) -> Result<WorldLine<S>, NoWorldLine> {
    let windows = setup.windows;
    let window_length = length / S::from(windows as f64);
    let spacing = window_length / S::from((setup.n_gamma - 1) as f64);
    let sbp = Arc::new(setup.sbp.operator(setup.n_gamma, spacing).expect("a valid setup has enough points"));
    let rough_sbp: SbpOperator =
        setup.sbp.operator(setup.n_gamma, spacing.to_f64()).expect("a valid setup has enough points");
    let Place { geometry, start } = &setup.place;
    let mut line = empty(setup, length, Arc::clone(&sbp));
    // Ignorable coordinates are summed so that nothing is lost over a million windows.
    let mut sums: Vec<Compensated<S>> = start.q.iter().map(|&q| Compensated::from(q)).collect();
    let (mut here, mut rough_here) = (start.clone(), setup.rough.start.clone());
    for index in 0..windows {
        let gamma = S::from(index as f64) * window_length;
        let (window_start, rough_start) = (relative(geometry, &here), relative(&setup.rough.geometry, &rough_here));
        let (form, digits) = (setup.form, setup.digits);
        let window = Window { form, sbp: &*sbp, geometry: &**geometry, start: &window_start, digits };
        let rough = Window { form, sbp: &rough_sbp, geometry: &*setup.rough.geometry, start: &rough_start, digits: 16 };
        let offset = (setup.gamma_i + gamma).to_f64();
        let piece = match setup.system {
            System::PhysicalLimit => solve_limit(&window, &rough, setup.max_iterations, offset),
            System::Doubled => doubled::solve(&window, &rough, setup, offset),
        }?;
        let last = setup.n_gamma - 1;
        let mut end = Start { q: Vec::new(), q_dot: Vec::new(), p: piece.end.clone() };
        for (a, sum) in sums.iter_mut().enumerate() {
            *sum = if geometry.active().contains(&a) {
                Compensated::from(piece.q[a][last])
            } else {
                sum.plus(piece.q[a][last])
            };
            end.q.push(sum.high);
        }
        let mut rates = geometry.field().room();
        let outside = geometry.field().evaluate(&end.q, &end.p, &mut rates).is_err();
        if outside || !piece.gradient_norm.is_finite() {
            return Err(NoWorldLine::at(Status::OutsideDomain, offset + window_length.to_f64()));
        }
        end.q_dot = (0..end.q.len()).map(|a| geometry.field().q_dot(&rates, a)).collect();
        let gamma_end = if index + 1 == windows { length } else { S::from((index + 1) as f64) * window_length };
        append(&mut line, piece, [gamma, gamma_end], here, end.clone());
        here = end;
        rough_here = in_f64(&here);
    }
    Ok(line)
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
) -> Result<Piece<S>, NoWorldLine> {
    let fields = 2 * window.geometry.active().len();
    let limit = limit::solve(window, rough, max_iterations).map_err(|failure| {
        let first = rough.derivative().first_unknown();
        let locate = |row: usize, u: &[f64]| {
            let node = row / fields;
            let state = node.checked_sub(first).and_then(|unknown| u.get(unknown * fields..)?.get(..fields / 2));
            (node, state.map_or(Vec::new(), <[f64]>::to_vec))
        };
        let is_explicit = window.form == Form::Strong && window.sbp.is_two_step();
        let guess = match (is_explicit, window.geometry.is_separable()) {
            (true, _) => InitialGuess::None,
            (false, true) => InitialGuess::Nystrom4,
            (false, false) => InitialGuess::RungeKutta4,
        };
        NoWorldLine::new(rough, failure, guess, |node| gamma + rough.sbp.node(node), locate)
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

fn empty<S: Real>(setup: &SceneSetup<S>, length: S, sbp: Arc<SbpOperator<S>>) -> WorldLine<S> {
    let (n, m) = (setup.place.start.q.len(), setup.place.geometry.active().len());
    let is_doubled = setup.system == System::Doubled;
    WorldLine {
        place: setup.place.clone(),
        gamma_i: setup.gamma_i,
        length,
        q: vec![Vec::new(); n],
        p: vec![Vec::new(); if is_doubled { 0 } else { m }],
        backward: vec![Vec::new(); if is_doubled { n } else { 0 }],
        windows: Vec::with_capacity(setup.windows),
        gradient_norm: S::ZERO,
        initial_guess: InitialGuess::None,
        iterations: 0,
        history: Vec::new(),
        digits: setup.digits,
        form: setup.form,
        sbp_name: setup.sbp,
        sbp,
    }
}

fn append<S: Real>(line: &mut WorldLine<S>, piece: Piece<S>, gamma: [S; 2], start: Start<S>, end: Start<S>) {
    let first_node = line.q[0].len();
    line.windows.push(SceneWindow { gamma, start, end, multipliers: piece.multipliers, first_node });
    line.gradient_norm = line.gradient_norm.max(piece.gradient_norm);
    line.initial_guess = piece.initial_guess;
    line.iterations += piece.history.len();
    if piece.history.len() > line.history.len() {
        line.history = piece.history;
    }
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
