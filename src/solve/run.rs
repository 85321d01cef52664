//! Windows laid end to end.

use std::sync::Arc;

use super::failure::{At, NoSolution};
use super::operator::Operators;
use super::piece::{Pair, Piece};
use super::setup::{Settings, Setup, System};
use super::status::{InitialGuess, Iterations, Status};
use super::window::Window as Problem;
use super::world_line::{Joint, Place, Window, WorldLine};
use crate::engine::{GOOD_DIGITS, Handed, Sensitivity};
use crate::geometry::{Geometry, Start};
use crate::number::{Compensated, Extended, Real};
use crate::sbp::SbpOperator;

/// Sees a run window by window, each as a world-line of its own.
pub(super) type Observer<'o, S> = &'o mut dyn FnMut(&WorldLine<S>);

/// The windows so far: all of them or, where they are observed one by one, the last.
pub(super) struct Run<'o, S> {
    pub(super) line: WorldLine<S>,
    /// γ − γ_i where the next window starts.
    gamma: S,
    /// The state at that place, but in a march by the engine that of the start.
    here: Start<S>,
    /// The rounding errors of its q^a: ignorable coordinates are summed so that nothing is lost over a million windows.
    lows: Vec<S>,
    /// The nodes to make room for.
    capacity: usize,
    observer: Option<Observer<'o, S>>,
}

impl<'o, S: Real> Run<'o, S> {
    /// The run of `setup` without windows, with these settings.
    pub(super) fn new(setup: &Setup<S>, settings: &Settings, observer: Option<Observer<'o, S>>) -> Self {
        let Setup { place, origin, gamma_i, is_backward, .. } = setup;
        let (place, origin, gamma_i, is_backward) = (place.clone(), *origin, *gamma_i, *is_backward);
        let n = place.start.q.len();
        let (is_doubled, m) = (settings.system == System::Doubled, place.geometry.active().len());
        let is_sensitive = settings.accuracy.is_some() && settings.sensitivity;
        let line = WorldLine {
            joints: Vec::with_capacity(4 * n),
            place,
            origin,
            gamma_i,
            is_backward,
            length: S::ZERO,
            q: vec![Vec::new(); n],
            p: vec![Vec::new(); if is_doubled { 0 } else { m }],
            backward: vec![Vec::new(); if is_doubled { n } else { 0 }],
            windows: Vec::new(),
            window_count: 0,
            gradient_norm: S::ZERO,
            iterations: Iterations::from(InitialGuess::None),
            digits: settings.digits,
            error_estimate: None,
            sizes: Vec::new(),
            windows_unproved: None,
            sensitivity: is_sensitive.then(|| Sensitivity::new(m, observer.is_none())),
            accuracy: None,
            good_until: [0.0; GOOD_DIGITS.len()],
            ended_by: None,
            ended_at: None,
            form: settings.form,
            sbp_name: settings.sbp,
            sums: Vec::new(),
            handed: Handed::default(),
            operators: Operators::default(),
        };
        let here = (*line.place.start).clone();
        let mut lows = setup.carried.as_ref().map_or_else(Vec::new, |carried| carried.sums.clone());
        lows.resize(n, S::ZERO);
        let mut run = Self { line, gamma: S::ZERO, here, lows, capacity: 0, observer };
        run.begin();
        run
    }

    /// Expects so many windows of so many nodes: all of the run.
    pub(super) fn expect(&mut self, windows: usize, points: usize) {
        let kept = if self.observer.is_some() { 1 } else { windows };
        self.capacity = kept * points;
        self.line.windows.reserve_exact(kept);
        self.line.joints.reserve_exact(kept * self.line.joints.len());
    }

    /// Makes room for their nodes at once.
    pub(super) fn reserve(&mut self) {
        for row in self.line.q.iter_mut().chain(&mut self.line.p) {
            row.reserve_exact(self.capacity);
        }
    }

    /// Forgets the windows so far: the run begins again.
    pub(super) fn clear(&mut self) {
        let line = &mut self.line;
        line.q.iter_mut().chain(&mut line.p).chain(&mut line.backward).for_each(Vec::clear);
        line.windows.clear();
        line.joints.clear();
        line.operators = Operators::default();
        (line.window_count, line.gradient_norm) = (0, S::ZERO);
        self.gamma = S::ZERO;
        self.begin();
    }

    /// The first joint is the start.
    fn begin(&mut self) {
        let WorldLine { joints, place: Place { start, .. }, .. } = &mut self.line;
        joints.extend_from_slice(&start.q);
        joints.extend_from_slice(&start.p);
    }

    /// Solves the windows of `setup`, of one length, one after the other, on γ − γ_i ∈ [0, `length`].
    pub(super) fn solve(mut self, setup: &Setup<S>, length: S) -> Result<WorldLine<S>, NoSolution>
    where
        S: Arithmetic,
    {
        let settings = &setup.settings;
        let windows = settings.windows;
        let grid = Grid::new(settings, length / S::from(windows as f64));
        self.expect(windows, settings.n_gamma);
        self.line.length = length;
        for index in 1..=windows {
            let end = if index == windows { length } else { S::from(index as f64) * grid.length };
            let piece = self.next(setup, &grid)?;
            let operator = self.line.operators.place_of(&grid.sbp);
            self.append(piece, operator, end)?;
        }
        self.line.sums = self.lows;
        Ok(self.line)
    }

    /// The window that continues the run.
    fn next(&self, setup: &Setup<S>, grid: &Grid<S>) -> Result<Piece<S>, NoSolution> {
        let (Settings { form, system, max_iterations, .. }, is_regularised) = (setup.settings, setup.regularised);
        let geometry = &*self.line.place.geometry;
        let (start, digits) = (relative(geometry, &self.here), self.line.digits);
        let window = Problem { form, sbp: &*grid.sbp, geometry, start: &start, is_regularised, digits, max_iterations };
        let (start, geometry, digits) = (in_f64(&start), &*setup.rough.geometry, f64::MOST_DIGITS);
        let rough =
            Problem { form, sbp: &*grid.rough, geometry, start: &start, is_regularised, digits, max_iterations };
        let pair = Pair { window, rough, gamma: (self.line.gamma_i + self.gamma).to_f64() };
        match system {
            System::PhysicalLimit => pair.physical_limit(),
            System::Doubled => pair.doubled(),
        }
    }

    /// Adds the next window, which has that operator of the world-line and ends at γ − γ_i = `gamma`.
    ///
    /// # Errors
    /// Numbers that are not finite are not a result: an overflow anywhere makes the gradient NaN or infinite, or the
    /// action.
    pub(super) fn append(&mut self, piece: Piece<S>, operator: usize, gamma: S) -> Result<(), NoSolution> {
        if !piece.gradient_norm.is_finite() {
            return Err(self.overflow(piece, operator));
        }
        let (geometry, here) = (self.line.geometry(), &self.here);
        let sums: Vec<Compensated<S>> = (piece.q.iter().enumerate())
            .map(|(a, row)| match (row[row.len() - 1], geometry.active().contains(&a)) {
                (last, true) => Compensated::from(last),
                (last, false) => Compensated { high: here.q[a], low: self.lows[a] }.plus(last),
            })
            .collect();
        // The momenta of ignorable coordinates are constants.
        let (q, mut p): (Vec<S>, Vec<S>) = (sums.iter().map(|sum| sum.high).collect(), here.p.clone());
        geometry.active().iter().for_each(|&a| p[a] = piece.end[a]);
        let joint = Joint { q: &q, p: &p };
        let is_finite = has_finite_action(geometry, joint, gamma - self.gamma);
        let Some(q_dot) = geometry.velocities(&q, &p).ok().filter(|_| is_finite) else {
            return Err(self.overflow(piece, operator));
        };
        self.begin_window(operator, gamma, joint, piece.multipliers);
        let line = &mut self.line;
        line.gradient_norm = line.gradient_norm.max(piece.gradient_norm);
        line.iterations.add(piece.initial_guess, piece.history);
        let rows = line.q.iter_mut().zip(piece.q);
        let rows = rows.chain(line.p.iter_mut().zip(piece.p)).chain(line.backward.iter_mut().zip(piece.backward));
        rows.for_each(|(all, row)| collect(all, row, self.capacity));
        self.end_window();
        (self.here, self.lows) = (Start { q, q_dot, p }, sums.iter().map(|sum| sum.low).collect());
        Ok(())
    }

    /// A window with this operator in which a number is beyond the range of numbers.
    fn overflow(&self, piece: Piece<S>, operator: usize) -> NoSolution {
        let points = piece.q[0].len();
        let is_finite = |k: &usize| piece.q.iter().all(|row| row[*k].is_finite());
        let node = (0..points).find(|k| !is_finite(k)).unwrap_or(points - 1);
        let q: Vec<S> = piece.q.iter().map(|row| row[node]).collect();
        let gamma = self.line.gamma_i + self.gamma + self.line.operators.get(operator).node(node);
        NoSolution {
            residual: piece.gradient_norm.to_f64(),
            iterations: Box::new(Iterations::of(piece.initial_guess, piece.history)),
            ..NoSolution::new(Status::OutsideDomain, At::overflow(self.line.geometry(), gamma.to_f64(), &q))
        }
    }

    /// Begins a window that ends at γ − γ_i = `gamma` in a joint. Its rows are to be appended to the world-line, and
    /// then [`Self::end_window`] is to be called.
    pub(super) fn begin_window(&mut self, operator: usize, gamma: S, end: Joint<'_, S>, multipliers: Vec<S>) {
        let line = &mut self.line;
        if self.observer.is_some() {
            line.q.iter_mut().chain(&mut line.p).chain(&mut line.backward).for_each(Vec::clear);
            let begun = line.joints.len() - (end.q.len() + end.p.len());
            line.joints.drain(..begun);
            line.windows.clear();
        }
        let first_node = line.q[0].len();
        line.windows.push(Window { gamma: [self.gamma, gamma], multipliers, first_node, operator });
        line.joints.extend_from_slice(end.q);
        line.joints.extend_from_slice(end.p);
        line.window_count += 1;
        self.gamma = gamma;
    }

    /// Shows the window that was begun last to the observer.
    pub(super) fn end_window(&mut self) {
        if let Some(observer) = &mut self.observer {
            observer(&self.line);
        }
    }
}

/// True if the parts of the action are within the range of numbers, of a window of this `length` that ends there: the
/// action from the start, ∫ p_a dq^a, and that of the active coordinates over the window.
pub(super) fn has_finite_action<S: Real>(geometry: &Geometry<S>, Joint { q, p }: Joint<'_, S>, length: S) -> bool {
    let is_finite = q.iter().zip(p).all(|(&q, &p)| (p * q).is_finite());
    // Where x has g_xx = −1, its velocity is its momentum.
    is_finite && (geometry.c_squared().is_none() || (p[1] * p[1] * length).is_finite())
}

/// The numbers that [`solve`](crate::solve()) computes in: `f64` and [`Extended`].
pub trait Arithmetic: Real {
    /// `sbp` in `f64`: itself, or the one that `rounded` makes.
    fn rough_operator(sbp: &Arc<SbpOperator<Self>>, rounded: impl FnOnce() -> SbpOperator) -> Arc<SbpOperator>;
}

impl Arithmetic for f64 {
    fn rough_operator(sbp: &Arc<SbpOperator>, _: impl FnOnce() -> SbpOperator) -> Arc<SbpOperator> {
        Arc::clone(sbp)
    }
}

impl Arithmetic for Extended {
    fn rough_operator(_: &Arc<SbpOperator<Self>>, rounded: impl FnOnce() -> SbpOperator) -> Arc<SbpOperator> {
        Arc::new(rounded())
    }
}

/// The operator of windows of one length, and the same in `f64`.
struct Grid<S> {
    length: S,
    sbp: Arc<SbpOperator<S>>,
    rough: Arc<SbpOperator>,
}

impl<S: Arithmetic> Grid<S> {
    fn new(settings: &Settings, length: S) -> Self {
        let (name, points) = (settings.sbp, settings.n_gamma);
        let spacing = length / S::from((points - 1) as f64);
        let valid = "a valid setup has enough points";
        let sbp = Arc::new(name.operator(points, spacing).expect(valid));
        let rough = S::rough_operator(&sbp, || {
            let spacing = length.to_f64() / (points - 1) as f64;
            name.operator(points, spacing).expect(valid)
        });
        Self { length, sbp, rough }
    }
}

fn in_f64<S: Real>(start: &Start<S>) -> Start {
    let of = |values: &[S]| values.iter().map(|value| value.to_f64()).collect();
    Start { q: of(&start.q), q_dot: of(&start.q_dot), p: of(&start.p) }
}

/// The same start with ignorable coordinates counted from it.
fn relative<S: Real>(geometry: &Geometry<S>, start: &Start<S>) -> Start<S> {
    let mut start = start.clone();
    (0..start.q.len()).filter(|a| !geometry.active().contains(a)).for_each(|a| start.q[a] = S::ZERO);
    start
}

/// Appends `piece` to `all`; the only window of a run is moved, not copied.
fn collect<S: Real>(all: &mut Vec<S>, piece: Vec<S>, capacity: usize) {
    if piece.len() == capacity {
        *all = piece;
        return;
    }
    // Where the number of windows is not known, room doubles.
    if capacity > 0 {
        all.reserve_exact(capacity.saturating_sub(all.len()).max(piece.len()));
    }
    all.extend(piece);
}
