//! Events that act: where a formula changes its sign the state is changed, and another run goes on from there.
//!
//! A formula that is zero where a run goes on has no sign there. The motion tells it: a step along it, as short as the
//! formula resolves, so that the next zero of a flight however short is not passed. The step is one of fourth order, so
//! that the first derivative counts that is not zero.

use crate::geometry::{Geometry, Observable, Point, Start};

/// A formula is zero if it is no more than this multiple of what rounding of the state makes of it.
const NOWHERE: f64 = 4.0;
/// Rounding of the state, relative to each number.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Steps along the rates are at most so many powers of ten shorter than the run before.
const SHORTEST: i32 = 16;

/// A quantity of the state, by the index of its coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// q^a.
    Position(usize),
    /// dq^a/dγ.
    Velocity(usize),
    /// p_a.
    Momentum(usize),
    /// A parameter of the scene, by its place there.
    Parameter(usize),
}

/// The change of the state that an event makes. What is not set stays: positions and velocities or, where momenta are
/// set, the other momenta.
#[derive(Debug, Clone)]
pub struct Change {
    /// The name of the event.
    pub name: String,
    /// The quantities that are set, and their formulas in the state before.
    pub set: Vec<(Quantity, Observable)>,
    /// True in the lift of Newton's law, where the velocity of the last coordinate, s, keeps K at 0.
    pub is_lifted: bool,
}

impl Change {
    /// Evaluates what the event sets in this state, where K was `norm` at the start of the run.
    pub(crate) fn values(&mut self, before: &Start, norm: f64) -> Vec<(Quantity, f64)> {
        let Start { q, q_dot, p } = before;
        self.set.iter_mut().map(|(quantity, formula)| (*quantity, formula.at(q, q_dot, p, norm))).collect()
    }

    /// The state after the event, which sets these values, in the geometry that holds from there on; `None` outside of
    /// its domain.
    pub(crate) fn of(&self, geometry: &Geometry, before: &Start, values: &[(Quantity, f64)]) -> Option<Start> {
        let Start { mut q, mut q_dot, mut p } = before.clone();
        let has_momenta = values.iter().any(|(quantity, _)| matches!(quantity, Quantity::Momentum(_)));
        for &(quantity, value) in values {
            match quantity {
                Quantity::Position(a) => q[a] = value,
                Quantity::Velocity(a) => q_dot[a] = value,
                Quantity::Momentum(a) => p[a] = geometry.seen(a, value),
                Quantity::Parameter(_) => {}
            }
        }
        if has_momenta {
            q_dot = geometry.velocities(&q, &p).ok()?;
        }
        if self.is_lifted {
            let s = q.len() - 1;
            let mut k = |s_dot: f64| {
                q_dot[s] = s_dot;
                geometry.norm(&q, &q_dot)
            };
            let (at_zero, at_one) = (k(0.0), k(1.0));
            q_dot[s] = -at_zero / (at_one - at_zero);
        }
        if self.is_lifted || !has_momenta {
            p = geometry.momenta(&q, &q_dot);
        }
        let is_finite = q.iter().chain(&q_dot).chain(&p).all(|value| value.is_finite());
        (is_finite && geometry.point().evaluate(&q, &p).is_ok()).then_some(Start { q, q_dot, p })
    }
}

/// A formula at the beginning of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Beginning {
    /// The sign that it has right behind the start; 0 if neither its value nor what it becomes is above rounding.
    pub(crate) side: f64,
    /// True if it is zero at the start up to rounding.
    pub(crate) is_zero: bool,
    /// The part that rounding of the state has in its value.
    pub(crate) noise: f64,
}

impl Beginning {
    /// Looks at a formula at a start, which is known up to rounding of the length `before` of γ. A value of the size of
    /// `zero` counts as none.
    pub(crate) fn new(
        (geometry, start): (&Geometry, &Start),
        formula: &mut Observable,
        norm: f64,
        (before, zero): (f64, f64),
    ) -> Self {
        let (mut motion, mut q_dot) = (Motion::new(geometry), start.q_dot.clone());
        let mut at = |motion: &mut Motion<'_>, state: &[f64]| {
            let (q, p) = state.split_at(state.len() / 2);
            if motion.point.evaluate(q, p).is_err() {
                return f64::NAN;
            }
            q_dot.iter_mut().enumerate().for_each(|(a, q_dot)| *q_dot = motion.point.q_dot(a));
            formula.at(q, &q_dot, p, norm)
        };
        let mut state = [start.q.as_slice(), &start.p].concat();
        let (here, rates) = (at(&mut motion, &state), motion.rates(&state));
        // Rounding of the state makes this of the value, and of the rates.
        let (mut noise, mut of_rates) = (0.0, vec![0.0; state.len()]);
        for k in 0..state.len() {
            let value = state[k];
            state[k] *= 1.0 + ROUNDING;
            noise += (at(&mut motion, &state) - here).abs();
            if let (Some(rates), Some(others)) = (&rates, motion.rates(&state)) {
                let changes = others.iter().zip(rates).map(|(other, rate)| (other - rate).abs());
                of_rates.iter_mut().zip(changes).for_each(|(noise, change)| *noise += change);
            }
            state[k] = value;
        }
        let slope = (1..=SHORTEST).find_map(|power| {
            let step = before * 10.0_f64.powi(power - SHORTEST - 1);
            let mut next = motion.step(&state, step)?;
            let value = at(&mut motion, &next);
            next.iter_mut().zip(&of_rates).for_each(|(next, noise)| *next += step * noise);
            let noise = noise + (at(&mut motion, &next) - value).abs();
            ((value - here).abs() > NOWHERE * noise).then_some((value - here) / step)
        });
        let slope = slope.unwrap_or(0.0);
        let late = 4.0 * ROUNDING * before * slope.abs();
        let is_zero = here.abs() <= NOWHERE * (noise + zero) + late;
        let sign = |value: f64| if value == 0.0 { 0.0 } else { value.signum() };
        Self { side: if is_zero { sign(slope) } else { sign(here) }, is_zero, noise }
    }
}

/// A motion, by its Hamiltonian.
struct Motion<'g> {
    geometry: &'g Geometry,
    point: Point,
}

impl<'g> Motion<'g> {
    fn new(geometry: &'g Geometry) -> Self {
        Self { point: geometry.point(), geometry }
    }

    /// The rates of q and p in a state of both; `None` outside of the domain.
    fn rates(&mut self, state: &[f64]) -> Option<Vec<f64>> {
        let n = state.len() / 2;
        self.point.evaluate(&state[..n], &state[n..]).ok()?;
        let mut rates: Vec<f64> = (0..n).map(|a| self.point.q_dot(a)).collect();
        rates.resize(2 * n, 0.0);
        self.geometry.active().iter().enumerate().for_each(|(place, &a)| rates[n + a] = self.point.p_dot(place));
        Some(rates)
    }

    /// The state after a step, by the classical method of fourth order.
    fn step(&mut self, state: &[f64], h: f64) -> Option<Vec<f64>> {
        let along = |h: f64, rates: &[f64]| -> Vec<f64> { state.iter().zip(rates).map(|(y, f)| y + h * f).collect() };
        let one = self.rates(state)?;
        let two = self.rates(&along(0.5 * h, &one))?;
        let three = self.rates(&along(0.5 * h, &two))?;
        let four = self.rates(&along(h, &three))?;
        let sum = |k: usize| (one[k] + 2.0 * two[k] + 2.0 * three[k] + four[k]) / 6.0;
        Some(along(h, &(0..state.len()).map(sum).collect::<Vec<f64>>()))
    }
}
