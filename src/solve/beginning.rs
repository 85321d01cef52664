//! The sign of a formula where a run begins or goes on, and what rounding makes of its values.
//!
//! A formula that is zero there has no sign. The motion tells it: two steps along it, as short as the formula resolves,
//! so that the next zero of a flight however short is not passed. They are of fourth order, so that the first
//! derivative counts that is not zero, and tell which one it is. If that is none of the first three, the motion is on
//! the surface where the formula is zero, until it leaves it.

use crate::geometry::{Geometry, Point, Start};
use crate::number::Real;

/// A formula is zero if it is no more than this multiple of what rounding of the state makes of it: it is evaluated
/// twice for each, and rounds by itself.
const NOWHERE: f64 = 4.0;
/// Rounding of each number of a state, in units of its last place: a state is a sum of some terms.
const ROUNDING: f64 = 4.0;
/// Steps along the rates are at most so many powers of ten shorter than the run before, as digits go.
const SHORTEST: i32 = 16;
/// Half a step makes an eighth of a change of third order, and a sixteenth of one of the fourth, which tells nothing.
const LARGEST_RATIO: f64 = 12.0;

/// A formula of a state: of q^a, dq^a/dγ and p_a.
pub(crate) type OfState<'f, S> = &'f mut dyn FnMut(&[S], &[S], &[S]) -> S;

/// What counts as none at a start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slack<S> {
    /// The length of γ that the run is looked at with, below 0 to look back.
    pub(crate) before: S,
    /// A root that is as near as this length of γ is at the start.
    pub(crate) late: S,
    /// A value of this size is none.
    pub(crate) zero: S,
}

impl<S: Real> Slack<S> {
    /// That of a run of this length, to rounding.
    pub(crate) fn of_run(before: S) -> Self {
        Self { before, late: S::from(4.0 * ROUNDING) * S::EPSILON * before, zero: S::ZERO }
    }
}

/// A formula at the beginning of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Beginning {
    /// The sign that it has right behind the start; 0 if neither its value nor what it becomes is above rounding.
    pub(crate) side: f64,
    /// True if it is zero at the start up to rounding.
    pub(crate) is_zero: bool,
    /// The order of the first derivative that is not zero, as far as two steps tell it; 0 if its value is the sign.
    pub(crate) order: i32,
    /// The part that rounding of the state has in its value.
    pub(crate) noise: f64,
    /// Values up to this are no more than that at the start, if it is zero there.
    none: f64,
}

impl Beginning {
    /// Looks at a formula at a start, in the geometry, where the rounding error of 1 is `epsilon`.
    pub(crate) fn new<S: Real>(
        (geometry, start, epsilon): (&Geometry<S>, &Start<S>, S),
        formula: OfState<'_, S>,
        Slack { before, late, zero }: Slack<S>,
    ) -> Self {
        let mut at = At::new(geometry);
        let mut state = [start.q.as_slice(), &start.p].concat();
        let (rounding, mut rates) = (S::from(ROUNDING) * epsilon, vec![S::ZERO; state.len()]);
        let (here, has_rates) = (at.value(formula, &state), at.rates(&state, &mut rates));
        // Rounding of the state makes this of the value, and of the rates.
        let (mut noise, mut of_rates, mut others) = (S::ZERO, vec![S::ZERO; state.len()], rates.clone());
        for k in 0..state.len() {
            let value = state[k];
            state[k] += rounding * value;
            noise += (at.value(formula, &state) - here).abs();
            if has_rates && at.rates(&state, &mut others) {
                let changes = others.iter().zip(&rates).map(|(&other, &rate)| (other - rate).abs());
                of_rates.iter_mut().zip(changes).for_each(|(noise, change)| *noise += change);
            }
            state[k] = value;
        }
        let mut change = |step: S| {
            let mut next = at.step(&state, step)?;
            let value = at.value(formula, &next);
            next.iter_mut().zip(&of_rates).for_each(|(next, &noise)| *next += step * noise);
            Some((value - here, S::from(NOWHERE) * (noise + (at.value(formula, &next) - value).abs())))
        };
        let step = |power: i32| before * S::from(10.0_f64.powi(power - SHORTEST - 1));
        let first = (1..SHORTEST).find_map(|power| {
            let (change, noise) = change(step(power))?;
            (change.abs() > noise).then_some((power, change, noise))
        });
        let is_told = first.is_some_and(|(power, first, noise)| {
            let half = change(step(power).half()).map_or(S::ZERO, |(half, _)| half);
            first.abs() <= S::from(LARGEST_RATIO) * half.abs() + noise + noise
        });
        let second = first.and_then(|(power, first, _)| Some((change(step(power + 1))?.0 / first).to_f64()));
        let order = second.filter(|ratio| *ratio > 0.0).map_or(0.0, f64::log10);
        let slope = first.map_or(S::ZERO, |(power, change, _)| change / step(power));
        let is_zero = here.abs() <= S::from(NOWHERE) * (noise + zero) + late * slope.abs();
        let (side, order) = match is_zero {
            true if is_told => (slope.sign(), order.round() as i32),
            true => (S::ZERO, 0),
            false => (here.sign(), 0),
        };
        Self {
            side: side.to_f64(),
            is_zero,
            order,
            noise: noise.to_f64(),
            none: (noise + zero).max(here.abs()).to_f64(),
        }
    }

    /// The sign, and what values have to exceed before they have one of their own.
    pub(crate) fn known(&self) -> [f64; 2] {
        [self.side, if self.is_zero { self.none } else { 0.0 }]
    }
}

/// By how much a formula of a state may be off where every number of the state may be off by so much: q^a of all
/// coordinates, and then p_a of all. A number that it does not read is best off by nothing, which costs nothing.
pub(crate) fn noise<S: Real>(
    at: &mut At<'_, S>,
    formula: OfState<'_, S>,
    state: &mut [S],
    off: impl Fn(usize, S) -> S,
) -> S {
    let (here, mut noise) = (at.value(formula, state), S::ZERO);
    for k in 0..state.len() {
        let value = state[k];
        let off = off(k, value);
        if off > S::ZERO {
            let mut change = |moved: S| {
                state[k] = moved;
                (at.value(formula, state) - here).abs()
            };
            noise += change(value + off).max(change(value - off));
            state[k] = value;
        }
    }
    noise
}

/// What rounding takes from a number of a state that is `value`, where it changes by this much in its window. Where
/// numbers are next to none, their sums are not rounded relative to them.
pub(crate) fn rounding<S: Real>(value: S, change: S, epsilon: S) -> S {
    S::from(ROUNDING) * (epsilon * (value.abs() + change) + S::MIN_POSITIVE)
}

/// Evaluates formulas and rates at states.
#[derive(Debug)]
pub(crate) struct At<'g, S> {
    geometry: &'g Geometry<S>,
    point: Point<S>,
    q_dot: Vec<S>,
}

impl<'g, S: Real> At<'g, S> {
    /// In a geometry.
    pub(crate) fn new(geometry: &'g Geometry<S>) -> Self {
        Self { point: geometry.point(), q_dot: vec![S::ZERO; geometry.dimension()], geometry }
    }

    /// The value of a formula at q^a and p_a of all coordinates, which is none outside of the domain.
    pub(crate) fn value(&mut self, formula: OfState<'_, S>, state: &[S]) -> S {
        let is_inside = self.go(state);
        self.here(is_inside, state, formula)
    }

    /// Goes to a state. Returns false outside of the domain.
    pub(crate) fn go(&mut self, state: &[S]) -> bool {
        let (q, p) = state.split_at(state.len() / 2);
        let is_inside = self.point.evaluate(q, p).is_ok();
        self.q_dot.iter_mut().enumerate().for_each(|(a, q_dot)| *q_dot = self.point.q_dot(a));
        is_inside
    }

    /// The value of a formula at the state that this has gone to.
    pub(crate) fn here(&self, is_inside: bool, state: &[S], formula: OfState<'_, S>) -> S {
        let (q, p) = state.split_at(state.len() / 2);
        if is_inside { formula(q, &self.q_dot, p) } else { S::from(f64::NAN) }
    }

    /// Writes the rates of q and p in a state of both. Returns false outside of the domain.
    fn rates(&mut self, state: &[S], rates: &mut [S]) -> bool {
        let n = state.len() / 2;
        if self.point.evaluate(&state[..n], &state[n..]).is_err() {
            return false;
        }
        rates.fill(S::ZERO);
        (0..n).for_each(|a| rates[a] = self.point.q_dot(a));
        self.geometry.active().iter().enumerate().for_each(|(place, &a)| rates[n + a] = self.point.p_dot(place));
        true
    }

    /// The state after a step, by the classical method of fourth order.
    fn step(&mut self, state: &[S], h: S) -> Option<Vec<S>> {
        let (mut sum, mut next, mut rates) = (vec![S::ZERO; state.len()], state.to_vec(), vec![S::ZERO; state.len()]);
        for (weight, ahead) in [(1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0)] {
            if !self.rates(&next, &mut rates) {
                return None;
            }
            sum.iter_mut().zip(&rates).for_each(|(sum, &rate)| *sum += S::from(weight) * rate);
            let along = state.iter().zip(&rates).map(|(&y, &rate)| y + S::from(ahead) * h * rate);
            next.iter_mut().zip(along).for_each(|(next, y)| *next = y);
        }
        let sixth = h / S::from(6.0);
        Some(state.iter().zip(sum).map(|(&y, sum)| y + sixth * sum).collect())
    }
}
