//! Windows laid end to end.

use std::sync::Arc;

use super::failure::{NoSolution, Unfinished};
use super::grid::{SHOWN, Window, WindowOperator};
use super::pair::Pair;
use super::piece::{Piece, Problem};
use super::setup::{Settings, Setup, System};
use super::signs::Watched;
use super::status::{InitialGuess, Iterations};
use super::world_line::{Place, WorldLine};
use crate::engine::{GOOD_DIGITS, Handed, Sensitivity};
use crate::geometry::{Geometry, Start};
use crate::number::{Compensated, Kind, Real};

/// Sees a run part by part, each as a world-line of its own.
pub(super) type Observer<'o, S> = &'o mut dyn FnMut(&WorldLine<S>);

/// The windows so far: all of them or, where they are observed, the last few.
pub(super) struct Run<'o, S> {
    pub(super) line: WorldLine<S>,
    /// The state where the next window starts, but in a march by the engine with the velocities of the start.
    pub(super) here: Start<S>,
    /// The rounding errors of its q^a: ignorable coordinates are summed so that nothing is lost over a million windows.
    lows: Vec<S>,
    observer: Option<Observer<'o, S>>,
    /// True while the errors of the window that was begun last are not known.
    is_open: bool,
    /// True if the observer has seen the windows that are there.
    is_shown: bool,
}

impl<'o, S: Real> Run<'o, S> {
    /// The run of `setup` without windows, with these settings.
    pub(super) fn new(setup: &Setup<S>, settings: &Settings, observer: Option<Observer<'o, S>>) -> Self {
        let Setup { place, origin, gamma_i, is_backward, .. } = setup;
        let (n, m) = (place.start.q.len(), place.geometry.active().len());
        let is_doubled = settings.system == System::Doubled;
        let is_sensitive = settings.accuracy.is_some() && settings.sensitivity;
        let line = WorldLine {
            joints: Vec::with_capacity(4 * n),
            place: place.clone(),
            origin: *origin,
            gamma_i: *gamma_i,
            is_backward: *is_backward,
            length: S::ZERO,
            q: vec![Vec::new(); n],
            p: vec![Vec::new(); if is_doubled { 0 } else { m }],
            backward: vec![Vec::new(); if is_doubled { n } else { 0 }],
            windows: Vec::new(),
            window_count: 0,
            gradient_norm: S::ZERO,
            iterations: Iterations::of(InitialGuess::None, Vec::new()),
            digits: settings.digits,
            error_estimate: None,
            errors: Vec::new(),
            sizes: Vec::new(),
            windows_unproved: None,
            touched: None,
            sensitivity: is_sensitive.then(|| {
                let behind = setup.carried.as_ref().and_then(|carried| carried.sensitivity.as_deref().cloned());
                behind.unwrap_or_else(|| Sensitivity::new(m, observer.is_none()))
            }),
            accuracy: settings.accuracy,
            good_until: [0.0; GOOD_DIGITS.len()],
            ended_by: None,
            watched: Watched::default(),
            ended_at: None,
            form: settings.form,
            sbp_name: settings.sbp,
            sums: Vec::new(),
            handed: Handed::default(),
        };
        let mut lows = setup.carried.as_ref().map_or_else(Vec::new, |carried| carried.sums.clone());
        lows.resize(n, S::ZERO);
        let mut run = Self { here: (*place.start).clone(), line, lows, observer, is_open: false, is_shown: false };
        run.clear();
        run
    }

    /// Makes room for so many windows of so many nodes, all of the run. The rows of a single one are moved.
    pub(super) fn expect(&mut self, windows: usize, points: usize) {
        let WorldLine { q, p, backward, windows: all, joints, .. } = &mut self.line;
        if self.observer.is_none() && windows > 1 {
            all.reserve_exact(windows);
            joints.reserve_exact(windows * joints.len());
            q.iter_mut().chain(p).chain(backward).for_each(|row| row.reserve_exact(windows * points));
        }
    }

    /// Begins, or forgets the windows so far and begins again. The first joint is the start.
    pub(super) fn clear(&mut self) {
        let WorldLine { q, p, backward, windows, joints, place: Place { start, .. }, .. } = &mut self.line;
        q.iter_mut().chain(p).chain(backward).for_each(Vec::clear);
        windows.clear();
        joints.clear();
        joints.extend(start.q.iter().chain(&start.p));
        (self.line.window_count, self.line.gradient_norm) = (0, S::ZERO);
        (self.is_open, self.is_shown) = (false, false);
    }

    /// γ − γ_i where the next window starts.
    fn gamma(&self) -> S {
        self.line.windows.last().map_or(S::ZERO, |window| window.gamma[1])
    }

    /// Solves the windows of `setup`, of one length, one after the other, on γ − γ_i ∈ [0, `length`].
    pub(super) fn solve(mut self, setup: &Setup<S>, length: S) -> Result<WorldLine<S>, Box<Unfinished<S>>> {
        let windows = setup.settings.windows;
        let of_window = length / S::from(windows as f64);
        let (operator, rough) = operators(&setup.settings, of_window);
        self.expect(windows, setup.settings.n_gamma);
        self.line.length = length;
        for index in 1..=windows {
            let end = if index == windows { length } else { S::from(index as f64) * of_window };
            let next = self.next(setup, &operator, &rough);
            if let Err(failure) = next.and_then(|piece| self.append(piece, &operator, end)) {
                self.show();
                return Err(Unfinished::new(failure, self.line));
            }
        }
        self.show();
        self.line.sums = self.lows;
        Ok(self.line)
    }

    /// The window that continues the run.
    fn next(
        &self,
        setup: &Setup<S>,
        operator: &WindowOperator<S>,
        rough: &WindowOperator<f64>,
    ) -> Result<Piece<S>, NoSolution> {
        let (settings, mut start) = (&setup.settings, self.here.clone());
        let geometry = &*self.line.place.geometry;
        geometry.ignorable().for_each(|a| start.q[a] = S::ZERO);
        let rough_start = start.in_f64();
        let window = Problem { settings, sbp: operator.get(), geometry, start: &start };
        let (geometry, sbp) = (&*setup.rough.geometry, rough.get());
        let rough = Problem { settings, sbp, geometry, start: &rough_start };
        let pair = Pair { window, rough, gamma: (self.line.gamma_i + self.gamma()).to_f64() };
        match settings.system {
            System::PhysicalLimit => pair.physical_limit(),
            System::Doubled => pair.doubled(),
        }
    }

    /// Adds the next window, which ends at γ − γ_i = `gamma`.
    fn append(&mut self, piece: Piece<S>, operator: &Arc<WindowOperator<S>>, gamma: S) -> Result<(), NoSolution> {
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
        let Ok(q_dot) = geometry.velocities(&q, &p) else { return Err(self.overflow(&piece, operator)) };
        self.here = Start { q, q_dot, p };
        if !self.begin_window(operator, gamma, (piece.gradient_norm, &piece.multipliers)) {
            return Err(self.overflow(&piece, operator));
        }
        self.lows = sums.iter().map(|sum| sum.low).collect();
        let line = &mut self.line;
        line.iterations.add(piece.initial_guess, piece.history);
        let rows = line.q.iter_mut().zip(piece.q);
        let rows = rows.chain(line.p.iter_mut().zip(piece.p)).chain(line.backward.iter_mut().zip(piece.backward));
        rows.for_each(|(all, row)| if all.capacity() == 0 { *all = row } else { all.extend(row) });
        self.end_window();
        Ok(())
    }

    /// A window with this operator in which a number is beyond the range of numbers.
    fn overflow(&self, piece: &Piece<S>, operator: &WindowOperator<S>) -> NoSolution {
        let points = piece.q[0].len();
        let is_finite = |k: &usize| piece.q.iter().all(|row| row[*k].is_finite());
        let node = (0..points).find(|k| !is_finite(k)).unwrap_or(points - 1);
        let q: Vec<S> = piece.q.iter().map(|row| row[node]).collect();
        let gamma = self.line.gamma_i + self.gamma() + operator.get().node(node);
        let failure = NoSolution::overflow(self.line.geometry(), gamma.to_f64(), &q);
        let residual = piece.gradient_norm.to_f64();
        NoSolution { residual, ..failure.after(piece.initial_guess, piece.history.clone()) }
    }

    /// Begins a window that ends at γ − γ_i = `gamma` in `here`, if no number of it is beyond the range of numbers: an
    /// overflow anywhere makes the gradient NaN or infinite, or the action, and is no result. Its rows are to be
    /// appended to the world-line, and then [`Self::end_window`] is to be called.
    #[must_use]
    pub(super) fn begin_window(
        &mut self,
        operator: &Arc<WindowOperator<S>>,
        gamma: S,
        (gradient_norm, multipliers): (S, &[S]),
    ) -> bool {
        let (begin, line, Start { q, p, .. }) = (self.gamma(), &mut self.line, &self.here);
        if !(gradient_norm.is_finite() && has_finite_action(line.geometry(), [q, p], gamma - begin)) {
            return false;
        }
        if std::mem::take(&mut self.is_shown) {
            line.q.iter_mut().chain(&mut line.p).chain(&mut line.backward).for_each(Vec::clear);
            let begun = line.joints.len() - (q.len() + p.len());
            line.joints.drain(..begun);
            line.windows.clear();
        }
        let (first_node, operator) = (line.q[0].len(), Arc::clone(operator));
        let (multipliers, errors) = (multipliers.to_vec(), Vec::new());
        line.windows.push(Window { gamma: [begin, gamma], multipliers, errors, first_node, form: line.form, operator });
        line.joints.extend(q.iter().chain(p));
        line.window_count += 1;
        line.gradient_norm = line.gradient_norm.max(gradient_norm);
        self.is_open = true;
        true
    }

    /// Ends the window that was begun last. The observer sees it with others.
    pub(super) fn end_window(&mut self) {
        self.is_open = false;
        if self.line.q[0].len() >= SHOWN {
            self.show();
        }
    }

    /// Shows the windows to the observer that it has not seen.
    pub(super) fn show(&mut self) {
        let is_new = !self.is_shown && !self.line.windows.is_empty();
        if let Some(observer) = self.observer.as_mut().filter(|_| is_new) {
            observer(&self.line);
            self.is_shown = true;
        }
    }

    /// The same, where so much is known of the errors of coordinates up to its end.
    pub(super) fn judge_window(&mut self, errors: Vec<f64>) {
        if let Some(window) = self.line.windows.last_mut().filter(|_| self.is_open) {
            window.errors = errors;
        }
        self.end_window();
    }
}

/// True if the parts of the action are within the range of numbers, of a window of this `length` that ends at `q` with
/// `p`: the action from the start, ∫ p_a dq^a, and that of the active coordinates over the window.
fn has_finite_action<S: Real>(geometry: &Geometry<S>, [q, p]: [&[S]; 2], length: S) -> bool {
    let is_finite = q.iter().zip(p).all(|(&q, &p)| (p * q).is_finite());
    // Where x has g_xx = −1, its velocity is its momentum.
    is_finite && (geometry.c_squared.is_none() || (p[1] * p[1] * length).is_finite())
}

/// The operator of a window.
struct OfOperator;

impl Kind for OfOperator {
    type Of<S: Real> = Arc<WindowOperator<S>>;
}

/// The operator of windows of this length, and the same in `f64`.
fn operators<S: Real>(settings: &Settings, length: S) -> (Arc<WindowOperator<S>>, Arc<WindowOperator<f64>>) {
    fn made<S: Real>(settings: &Settings, length: S) -> Arc<WindowOperator<S>> {
        let Settings { sbp, n_gamma: points, .. } = *settings;
        let spacing = length / S::from((points - 1) as f64);
        WindowOperator::made(sbp.operator(points, spacing).expect("a valid setup has enough points"))
    }
    let operator = made(settings, length);
    let same = S::in_f64::<OfOperator>(Arc::clone(&operator));
    let rough = same.unwrap_or_else(|| made(settings, length.to_f64()));
    (operator, rough)
}
