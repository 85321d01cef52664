//! The collocation system of the active coordinates as a banded Newton iteration in (q, p*).

use super::guess::Guess;
use super::newton::{self, Equations, Failure, NewtonSystem, ROUNDING_UNITS, Root, gains, tolerance};
use super::piece::{Piece, Problem};
use super::setup::Settings;
use super::status::{InitialGuess, IterationRecord, Status};
use crate::geometry::{Motion, OnNodes, OutsideGeometry};
use crate::linalg::Singular;
use crate::linalg::banded::solve_banded;
use crate::number::Real;
use crate::number::norm::max_abs;

/// Solves the system of `window` from a guess, and integrates the ignorable coordinates; `rough` is the same in `f64`.
pub(super) fn solve<S: Real>(
    window: &Problem<'_, S>,
    rough: &Problem<'_, f64>,
    guess: &Guess,
) -> Result<Piece<S>, Failure> {
    let (Solved { mut q, p, steps, history }, kind) = if window.is_at_rest() {
        (System::new(window, Vec::new()).solved(&[], Vec::new())?, InitialGuess::None)
    } else {
        (of_active(window, rough, guess)?, guess.kind)
    };
    for (a, steps) in window.geometry.ignorable().zip(steps) {
        q[a] = integral(window, rough, |k| steps[k])?;
    }
    Ok(Piece::in_limit(window, [q, p], history, kind))
}

/// The solution in which ignorable coordinates are still what they are at the start, and h q̇^a of them.
struct Solved<S> {
    q: Vec<Vec<S>>,
    p: Vec<Vec<S>>,
    steps: Vec<Vec<S>>,
    history: Vec<IterationRecord>,
}

fn of_active<S: Real>(window: &Problem<'_, S>, rough: &Problem<'_, f64>, guess: &Guess) -> Result<Solved<S>, Failure> {
    let (mut linearised, &Settings { digits, max_iterations, .. }) = (System::new(rough, Vec::new()), window.settings);
    let guess = linearised.unknowns(guess);
    let root = newton::solve(&mut linearised, guess, max_iterations)?;
    if S::IS_EXTENDED {
        let mut system = System::new(window, linearised.scales.clone());
        // The Jacobian at the `f64` root is eliminated anew in every round: that is cheap beside an extended residual,
        // and keeps the elimination in one pass without a stored factor L.
        let solve = |right: &mut [f64]| linearised.solve_linearised(right);
        let Root { unknowns, history } = newton::refine(&mut system, solve, root, (digits, max_iterations))?;
        return system.solved(&unknowns, history);
    }
    // The system was evaluated last at its root.
    let in_s = |rows: Vec<Vec<f64>>| rows.into_iter().map(|row| row.into_iter().map(S::from).collect()).collect();
    let steps = in_s(linearised.steps());
    Ok(Solved { q: in_s(linearised.q), p: in_s(linearised.p), steps, history: root.history })
}

/// The integral over γ by the operator of `window`: u on the nodes with du/dγ = r and u = 0 at the start, where
/// `h_rate` is h r at a node, with iterative refinement: one round for `f64`, as many as the digits need otherwise.
/// `rough` is the window in `f64`.
fn integral<S: Real>(
    window: &Problem<'_, S>,
    rough: &Problem<'_, f64>,
    h_rate: impl Fn(usize) -> S,
) -> Result<Vec<S>, Failure> {
    let (derivative, rough) = (window.derivative(), rough.derivative());
    let (first, unknowns) = (derivative.first_unknown(), derivative.unknowns());
    let (h, h_rough, (lower, upper)) = (window.sbp.spacing(), rough.sbp.spacing(), rough.reach());
    let [mut u, mut slope] = [(); 2].map(|()| vec![S::ZERO; window.points()]);
    let (mut right, mut before) = (vec![0.0; unknowns], S::from(f64::INFINITY));
    let tolerance: S = tolerance(window.settings.digits);
    for round in 0.. {
        let missing = |k: usize| h_rate(k) - h * slope[k];
        // With more digits it is scaled, so that it fits into the range of f64.
        let largest = || (0..unknowns).fold(S::ZERO, |largest, k| largest.max(missing(k).abs()));
        let scale = if S::IS_EXTENDED { largest() } else { S::ONE };
        if scale == S::ZERO {
            break;
        }
        right.iter_mut().enumerate().for_each(|(k, right)| *right = (missing(k) / scale).to_f64());
        let solved = solve_banded(lower, upper, &mut right, |k, row| {
            row.fill(0.0);
            rough.row(k).for_each(|(column, d)| row[column + lower - k] += h_rough * d);
        });
        let (largest, size) = (max_abs(&right), max_abs(&u));
        if solved.is_err() || (S::IS_EXTENDED && !largest.is_finite()) {
            return Err(Failure::without_iterate(Status::Singular));
        }
        let change = scale * S::from(largest);
        let is_last = if S::IS_EXTENDED { change <= tolerance * size } else { round == 1 };
        let goes_on = (is_last || gains(change, before)) && round < window.settings.max_iterations;
        if S::IS_EXTENDED && !goes_on {
            let rounding = ROUNDING_UNITS * derivative.sbp.row_sum() * S::EPSILON.to_f64() * size.to_f64();
            let is_rounding = scale.to_f64() <= rounding;
            return if is_rounding { Ok(u) } else { Err(Failure::without_iterate(Status::PrecisionNotReached)) };
        }
        u[first..].iter_mut().zip(&right).for_each(|(u, &change)| *u += scale * S::from(change));
        if is_last {
            break;
        }
        before = change;
        derivative.apply(&u, S::ZERO, &mut slope);
    }
    Ok(u)
}

/// Entries of the Jacobian, divided by this, stay far from overflow.
const LEAST_SCALE: f64 = 1e-280;
/// A rate counts at least as this share of what it would be in units of ε, if nothing but the fields were rounded.
const OF_ROUNDING: f64 = 0.1;

/// Rows (h du/dγ − h u̇)/s in the unknowns (q_1 … q_m, p_1 … p_m) of one node after the other: at nodes 1 … N−1 for
/// nodes 2 … N in the strong form, at all nodes for all in the weak one.
struct System<'w, S> {
    window: Problem<'w, S>,
    /// Set at the first residual if they are not given.
    scales: Vec<f64>,
    // The fields on all N nodes, their rates and their slopes as evaluated last. They are kept, because at a million
    // nodes fresh memory costs more than the arithmetic.
    q: Vec<Vec<S>>,
    p: Vec<Vec<S>>,
    rates: Vec<Vec<S>>,
    slopes: Vec<Vec<S>>,
    motion: Motion<S>,
}

impl<'w, S: Real> System<'w, S> {
    fn new(window: &Problem<'w, S>, scales: Vec<f64>) -> Self {
        let (points, geometry) = (window.points(), window.geometry);
        let m = geometry.active().len();
        Self {
            window: *window,
            scales,
            q: window.start.q.iter().map(|&q| vec![q; points]).collect(),
            p: geometry.active().iter().map(|&a| vec![window.start.p[a]; points]).collect(),
            rates: vec![vec![S::ZERO; points]; 2 * m],
            slopes: vec![vec![S::ZERO; points]; 2 * m],
            motion: Motion::new(geometry),
        }
    }

    /// Number of fields at a node, 2m.
    fn fields(&self) -> usize {
        self.slopes.len()
    }

    /// The solution with these unknowns.
    fn solved(mut self, u: &[S], history: Vec<IterationRecord>) -> Result<Solved<S>, Failure> {
        self.evaluate(u).map_err(Failure::outside)?;
        let steps = self.steps();
        Ok(Solved { q: self.q, p: self.p, steps, history })
    }

    /// Updates the fields and their rates to the unknowns `u`.
    fn evaluate(&mut self, u: &[S]) -> Result<(), OutsideGeometry> {
        let (first, fields) = (self.window.derivative().first_unknown(), self.fields());
        for (place, &a) in self.window.geometry.active().iter().enumerate() {
            let (q, p) = (&mut self.q[a][first..], &mut self.p[place][first..]);
            for ((state, q), p) in u.chunks_exact(fields).zip(q).zip(p) {
                (*q, *p) = (state[place], state[fields / 2 + place]);
            }
        }
        let on = OnNodes { q: &self.q, p: &self.p, start: &self.window.start.p };
        self.motion.rates(on, self.q[0].len(), &mut self.rates)
    }

    /// Sets the divisor of each kind of row, so that one rounding level holds for all: the size of the field plus its
    /// change in a step, at what was evaluated last.
    fn set_scales(&mut self) {
        let h = self.window.sbp.spacing().to_f64();
        // At rest and on a circular orbit a force is what is left of terms that cancel, and rounds like these.
        let rounding = self.rates_of_rounding();
        let rows = self.window.geometry.active().iter().map(|&a| &self.q[a]).chain(&self.p);
        let scale = |((row, rates), rounding): ((&Vec<S>, &Vec<S>), f64)| {
            let rate = max_abs(rates).to_f64();
            match (max_abs(row).to_f64() + h * rate).max(OF_ROUNDING * h * rounding) {
                // At rest without any force there is no scale.
                0.0 => 1.0,
                scale => f64::max(scale, LEAST_SCALE),
            }
        };
        self.scales = rows.zip(&self.rates).zip(rounding).map(scale).collect();
    }

    /// Σ_b |∂u̇_a/∂u_b| |u_b| at the first unknown, for each field: the rounding of a rate in units of ε, if the fields
    /// are rounded.
    fn rates_of_rounding(&mut self) -> Vec<f64> {
        let (first, Self { window, q, p, motion, .. }) = (self.window.derivative().first_unknown(), self);
        let active = window.geometry.active();
        let sizes: Vec<f64> = active.iter().map(|&a| &q[a]).chain(&*p).map(|row| row[first].abs().to_f64()).collect();
        let mut rates = vec![0.0; sizes.len()];
        let on = OnNodes { q, p, start: &window.start.p };
        motion.jacobian(on, first, |row, column, value| rates[row] += value.abs().to_f64() * sizes[column]);
        rates
    }

    /// h q̇^a of the ignorable coordinates at what was evaluated last.
    fn steps(&self) -> Vec<Vec<S>> {
        let h = self.window.sbp.spacing();
        self.motion.ignorable.iter().map(|row| row.iter().map(|&rate| h * rate).collect()).collect()
    }
}

impl<S: Real> Equations<S> for System<'_, S> {
    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), OutsideGeometry> {
        self.evaluate(u)?;
        if self.scales.is_empty() {
            self.set_scales();
        }
        let (h, derivative, fields) = (self.window.sbp.spacing(), self.window.derivative(), self.fields());
        let start = self.window.start;
        for (place, &a) in self.window.geometry.active().iter().enumerate() {
            derivative.apply(&self.q[a], start.q[a], &mut self.slopes[place]);
            derivative.apply(&self.p[place], start.p[a], &mut self.slopes[fields / 2 + place]);
        }
        for (field, (slopes, rates)) in self.slopes.iter().zip(&self.rates).enumerate() {
            let scale = S::from(self.scales[field]);
            for ((rows, &slope), &rate) in out.chunks_exact_mut(fields).zip(slopes).zip(rates) {
                rows[field] = h * (slope - rate) / scale;
            }
        }
        Ok(())
    }

    /// The rows are scaled so that one level holds for all.
    fn rounding(&self, u: &[S]) -> Option<Vec<f64>> {
        Some(vec![self.window.sbp.row_sum() * S::EPSILON.to_f64(); u.len()])
    }

    fn sizes(&self, u: &[S]) -> Vec<S> {
        let mut sizes = vec![S::ZERO; self.fields()];
        for state in u.chunks_exact(self.fields()) {
            sizes.iter_mut().zip(state).for_each(|(size, value)| *size = size.max(value.abs()));
        }
        sizes
    }

    /// The sizes, or the divisor of the rows of a field where that is larger: at rest a momentum is rounding.
    fn scales(&self, u: &[S]) -> Vec<S> {
        self.sizes(u).into_iter().zip(&self.scales).map(|(size, &scale)| size.max(S::from(scale))).collect()
    }
}

impl System<'_, f64> {
    /// The unknowns of a world-line on the nodes.
    fn unknowns(&self, Guess { q, p, .. }: &Guess) -> Vec<f64> {
        let nodes = self.window.derivative().first_unknown()..self.window.points();
        let positions = |k: usize| self.window.geometry.active().iter().map(move |&a| q[a][k]);
        nodes.flat_map(|k| positions(k).chain(p.iter().map(move |row| row[k]))).collect()
    }

    /// Overwrites `right` with J⁻¹ `right` for the Jacobian J at what was evaluated last.
    fn solve_linearised(&mut self, right: &mut [f64]) -> Result<(), Singular> {
        let (h, derivative, fields) = (self.window.sbp.spacing(), self.window.derivative(), self.fields());
        let (first, (lower, upper)) = (derivative.first_unknown(), derivative.reach());
        // Rows of node k stand beside the unknowns of node k + first, so their coupling to the fields of node k reaches
        // (first + 1) nodes, less one field, below the diagonal, and above it only if first is 0.
        let lower = (fields * lower).max(fields * (first + 1) - 1);
        let upper = (fields * upper).max(if first == 0 { fields - 1 } else { 0 });
        let Self { window, scales, q, p, motion, .. } = self;
        let on = OnNodes { q, p, start: &window.start.p };
        let mut jacobian = vec![0.0; fields * fields];
        solve_banded(lower, upper, right, |index, row| {
            row.fill(0.0);
            let (k, field) = (index / fields, index % fields);
            if field == 0 && k >= first {
                jacobian.fill(0.0);
                motion.jacobian(on, k, |row, column, value| jacobian[row * fields + column] = value);
            }
            let inverse = 1.0 / scales[field];
            derivative.row(k).for_each(|(column, d)| row[fields * column + field + lower - index] += h * d * inverse);
            // In the strong form the first node is given: it has no unknowns to couple to.
            if k >= first {
                for (other, &coupling) in jacobian[field * fields..][..fields].iter().enumerate() {
                    if coupling != 0.0 {
                        row[fields * (k - first) + other + lower - index] -= h * coupling * inverse;
                    }
                }
            }
        })
    }
}

impl NewtonSystem for System<'_, f64> {
    /// `residual` was computed last, so that the fields are those of the unknowns.
    fn newton_step(&mut self, _: &[f64], residual: &[f64], step: &mut [f64]) -> Result<(), Singular> {
        for (step, r) in step.iter_mut().zip(residual) {
            *step = -r;
        }
        self.solve_linearised(step)
    }
}
