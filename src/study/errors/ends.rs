//! Where a run ends. At a value of a coordinate, or at a zero of a formula of the state, a run that is off ends at
//! another γ, and what counts is by how much it is off there.

use std::cell::RefCell;
use std::sync::Arc;

use crate::geometry::{Geometry, Observable, Start};
use crate::number::Real;
use crate::number::norm::larger;
use crate::solve::{Limit, Off, Setup, Until, WorldLine};
use crate::trajectory::late_at_end;

/// Numbers of a state are changed by this part of their size to find derivatives.
const CHANGE: f64 = 1e-6;

/// The end of a run.
#[derive(Debug)]
pub(super) enum End {
    /// At a length in γ.
    Length,
    /// At a value of this coordinate.
    Value(usize),
    /// At a zero of a formula.
    Zero(Box<Zero>),
}

/// A zero of a formula at the end of a run.
#[derive(Debug)]
pub(super) struct Zero {
    geometry: Arc<Geometry>,
    formula: RefCell<Observable>,
    /// K at the start.
    norm: f64,
    /// The state at the end.
    state: Start,
    /// The sizes of its numbers, at the start or at the end.
    sizes: Off,
    /// The change of the formula with γ.
    rate: f64,
    /// By how much γ is open since the formula rounds.
    rounded: f64,
}

impl End {
    /// The end of the run of `setup` that is, or ends with, `line`.
    pub(super) fn new<S: Real>(setup: &Setup<S>, line: &WorldLine<S>) -> Self {
        let formula = line.ended_by.map(|place| setup.until.get(place));
        match (formula, setup.limit) {
            (Some(Some(until)), _) => Self::Zero(Box::new(Zero::new(setup, line, until))),
            // The setup says nothing of what ended it.
            (Some(None), _) => Self::Length,
            (None, Limit::Value { coordinate, .. }) => Self::Value(coordinate),
            (None, Limit::Length(_)) => Self::Length,
        }
    }

    /// The coordinate whose value it is, if it is one.
    pub(super) fn coordinate(&self) -> Option<usize> {
        if let Self::Value(coordinate) = self { Some(*coordinate) } else { None }
    }

    /// By how much γ of the end is late, to first order, where a state with the velocities `q_dot` is off by this.
    pub(super) fn late(&self, off: &Off, q_dot: &[f64]) -> f64 {
        match self {
            Self::Length => 0.0,
            Self::Value(coordinate) => off.q[*coordinate] / q_dot[*coordinate],
            Self::Zero(zero) => zero.late(off),
        }
    }

    /// Errors of the coordinates of the end of `line`, of which any may be off by so much either way at equal γ.
    pub(super) fn with_late<S: Real>(&self, mut errors: Vec<f64>, line: &WorldLine<S>) -> Vec<f64> {
        let end = line.end_inside().in_f64();
        let late = match self {
            Self::Length => return errors,
            // All of its error is in the others.
            Self::Value(coordinate) => std::mem::take(&mut errors[*coordinate]) / end.q_dot[*coordinate].abs(),
            Self::Zero(zero) => zero.late_at_most(&errors) + zero.rounded,
        };
        let others = errors.iter_mut().enumerate().filter(|(a, _)| Some(*a) != self.coordinate());
        others.for_each(|(a, error)| *error += late * end.q_dot[a].abs());
        errors
    }
}

impl Zero {
    fn new<S: Real>(setup: &Setup<S>, line: &WorldLine<S>, until: &Until<S>) -> Self {
        let (geometry, start) = (Arc::clone(&setup.rough.geometry), &*setup.rough.start);
        let (state, norm) = (line.end_inside().in_f64(), geometry.norm(&start.q, &start.q_dot));
        let size = |(one, two): (&f64, &f64)| larger(one.abs(), two.abs());
        let sizes = Off {
            q: start.q.iter().zip(&state.q).map(size).collect(),
            p: start.p.iter().zip(&state.p).map(size).collect(),
        };
        let (formula, rounded) = (RefCell::new(until.rough.clone()), late_at_end(line, &until.formula).to_f64());
        let mut zero = Self { geometry, formula, norm, state, sizes, rate: f64::NAN, rounded };
        let rates = Off { q: zero.state.q_dot.clone(), p: rates_of_momenta(&zero.geometry, &zero.state) };
        zero.rate = zero.along(&rates);
        zero
    }

    /// The formula where the state is moved so far; not a number where there is no such state.
    fn moved(&self, factor: f64, Off { q, p }: &Off) -> f64 {
        let add = |values: &[f64], off: &[f64]| -> Vec<f64> {
            values.iter().zip(off).map(|(value, off)| value + factor * off).collect()
        };
        let (q, p) = (add(&self.state.q, q), add(&self.state.p, p));
        let q_dot = self.geometry.velocities(&q, &p);
        q_dot.map_or(f64::NAN, |q_dot| self.formula.borrow_mut().at(&q, &q_dot, &p, self.norm))
    }

    /// The derivative of the formula in this direction.
    fn along(&self, direction: &Off) -> f64 {
        let share = |(off, size): (&f64, &f64)| if *size > 0.0 { (off / size).abs() } else { 0.0 };
        let pairs = |of: &[f64], sizes: &[f64]| of.iter().zip(sizes).map(share).fold(0.0, larger);
        let most = larger(pairs(&direction.q, &self.sizes.q), pairs(&direction.p, &self.sizes.p));
        // What has no size, as it is 0 at both ends, is changed by the direction itself.
        let factor = if most > 0.0 { CHANGE / most } else { 1.0 };
        (self.moved(factor, direction) - self.moved(-factor, direction)) / (2.0 * factor)
    }

    fn late(&self, off: &Off) -> f64 {
        let change = if off.is_none() { 0.0 } else { self.along(off) };
        if change == 0.0 { 0.0 } else { change / self.rate }
    }

    /// |late| at most, where any coordinate may be off by so much, and every momentum by the same share of its size.
    fn late_at_most(&self, errors: &[f64]) -> f64 {
        let n = errors.len();
        let share = errors.iter().zip(&self.sizes.q).filter(|(_, size)| **size > 0.0);
        let share = share.map(|(error, size)| error / size).fold(0.0, larger);
        let late = |place: usize| {
            let mut off = Off::none(n);
            if place < n {
                off.q[place] = errors[place];
            } else {
                off.p[place - n] = share * self.sizes.p[place - n];
            }
            self.late(&off).abs()
        };
        (0..2 * n).map(late).sum()
    }
}

/// ṗ_a, 0 for ignorable coordinates.
pub(super) fn rates_of_momenta(geometry: &Geometry, Start { q, q_dot, .. }: &Start) -> Vec<f64> {
    let mut rates = geometry.forces(q, q_dot);
    geometry.ignorable().for_each(|a| rates[a] = 0.0);
    rates
}
