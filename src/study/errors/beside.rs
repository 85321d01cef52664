//! Motions from beside a state.
//!
//! Where the equations jump, motions that begin beside a state on either side of it may part at once, however near they
//! begin: on the top of V = −|x|, as on that of V = −max(x, 0), where one of them stays. So the state and some that are
//! off by very little are followed for a moment, by Picard's iteration on a few nodes. A motion that is pushed back
//! across a jump from both sides does not settle there, and it slides.

use super::evaluated::{PATTERNS, side};
use crate::number::Real;
use crate::number::norm::larger;

/// The nodes of a moment, in parts of it, are 1/3, 2/3 and 1. The integrals from 0 to each of them of the polynomial
/// through values on all are these sums of values, in 36ths.
const NODES: usize = 3;
const INTEGRALS: [[f64; NODES]; NODES] = [[23.0, -16.0, 5.0], [28.0, -8.0, 4.0], [27.0, 0.0, 9.0]];
/// Iterations: each is nearer to a root that leads away from 0 by a factor, and to what is smooth by many digits.
const ITERATIONS: usize = 12;
/// Motions are the same if they part by no more than so many times what they are off by at first: no smooth motion
/// grows so much in a moment.
const SAME: f64 = 1e4;
/// Multiples of the golden ratio are spread evenly over 0 to 1.
const GOLDEN: f64 = 1.618_033_988_749_895;
/// First guesses have the rates of states that are off by so much more: the moment does not show on which side of a
/// jump a motion turns that comes so near to it.
const GUESSED: f64 = 64.0;
/// A motion has settled if an iteration moves it by less than this part of its distance from another one.
const SETTLED: f64 = 0.1;

/// A motion over a moment: where it begins, its states on the nodes, q^a and then p_a, and their rates.
struct Path<S> {
    from: Vec<S>,
    nodes: [Vec<S>; NODES],
    rates: [Vec<S>; NODES],
    /// By how much the last iteration has changed its end, in units of what starts are off by.
    change: f64,
}

impl<S: Real> Path<S> {
    /// A motion from a state, with the rates of another one as a first guess.
    fn new<E>(equations: &mut E, [from, guess]: [Vec<S>; 2]) -> Option<Self>
    where
        E: FnMut(&[S], &[S]) -> Option<Vec<S>>,
    {
        let (q, p) = guess.split_at(from.len() / 2);
        let rates = equations(q, p)?;
        let [nodes, rates] = [&from, &rates].map(|values| std::array::from_fn(|_| values.clone()));
        Some(Self { from, nodes, rates, change: f64::INFINITY })
    }

    fn end(&self) -> &[S] {
        &self.nodes[NODES - 1]
    }

    /// Iterates once: momenta are those of the forces before, positions those of the momenta.
    fn iterate<E>(&mut self, equations: &mut E, moment: f64, off: &[f64]) -> Option<()>
    where
        E: FnMut(&[S], &[S]) -> Option<Vec<S>>,
    {
        let (before, n) = (self.end().to_vec(), self.from.len() / 2);
        for part in [n..2 * n, 0..n] {
            for (node, weights) in self.nodes.iter_mut().zip(INTEGRALS) {
                for k in part.clone() {
                    let rates = self.rates.iter().zip(weights);
                    let sum = rates.fold(S::ZERO, |sum, (rates, weight)| sum + S::from(weight) * rates[k]);
                    node[k] = self.from[k] + S::from(moment / 36.0) * sum;
                }
            }
            for (node, rates) in self.nodes.iter().zip(&mut self.rates) {
                *rates = equations(&node[..n], &node[n..])?;
            }
        }
        self.change = distance(&before, self.end(), off);
        self.change.is_finite().then_some(())
    }
}

/// The distance of two states in units of what starts are off by.
fn distance<S: Real>(one: &[S], other: &[S], off: &[f64]) -> f64 {
    let each = one.iter().zip(other).zip(off).map(|((one, other), off)| (*one - *other).to_f64().abs() / off);
    each.fold(0.0, larger)
}

/// True if motions part at once that begin in a state, q^a and then p_a, or beside it, each number off by so much at
/// most: in this moment, in which all that is smooth hardly changes. The equations give q̇^a and then ṗ_a at a state,
/// and nothing outside of their domain.
pub(super) fn part_at_once<S: Real>(
    mut equations: impl FnMut(&[S], &[S]) -> Option<Vec<S>>,
    state: &[S],
    off: &[f64],
    moment: f64,
) -> bool {
    // Numbers are off by different shares, so that no sum of a few of them stays as it is.
    let share = |k: usize| 0.5 + 0.5 * ((k + 1) as f64 * GOLDEN).fract();
    let beside = |pattern: u32, way: f64| {
        let number = |(k, (value, off)): (usize, (&S, &f64))| *value + S::from(way * side(k, pattern) * share(k) * off);
        state.iter().zip(off).enumerate().map(number).collect::<Vec<S>>()
    };
    let starts = (0..PATTERNS)
        .flat_map(|pattern| [1.0, -1.0].map(|way| [way, GUESSED * way].map(|way| beside(pattern, way))))
        .chain([[state.to_vec(), state.to_vec()]]);
    let starts: Vec<[Vec<S>; 2]> = starts.collect();
    let mut paths: Vec<Path<S>> = starts.into_iter().filter_map(|from| Path::new(&mut equations, from)).collect();
    for iteration in 0..ITERATIONS {
        paths.retain_mut(|path| path.iterate(&mut equations, moment, off).is_some());
        let Some((first, others)) = paths.split_first() else { return false };
        if iteration > 0 && others.iter().all(|path| distance(first.end(), path.end(), off) <= SAME) {
            return false;
        }
    }
    let part = |one: &Path<S>, other: &Path<S>| {
        let far = distance(one.end(), other.end(), off);
        far > SAME && one.change.max(other.change) <= SETTLED * far
    };
    paths.iter().enumerate().any(|(k, one)| paths[..k].iter().any(|other| part(one, other)))
}
