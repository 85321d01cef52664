//! Local errors say by how much a solved window is off, from the highest Legendre modes of its slopes.
//!
//! A integrates P_0 … P_{n−2} exactly, and A P_{n−1} − ∫P_{n−1} = (P_{n−1} − P_{n−2})/2(n − 1). So of slopes h ẋ with
//! the modes a_k
//!
//! * the largest error inside is that of the first node, |a_{n−1}|/(n − 1), which is also its distance from the start
//!   of the window; where it happens to be small, the mode that a_{n−2} and the decay of modes foretell stands for it;
//! * for equations of second order the same holds with the last mode of q̇, that is h² a_{n−2}/2(2n − 3);
//! * at the end this error counts only as far as the linearised equations have a mode like it: once more the
//!   truncation, relative.

use pulp::{Simd, WithSimd};

use super::kernel::On;
use super::rule::Order;
use super::system::System;
use super::tuning::{END, INSIDE_MARGIN, NOISE};
use super::window::{Row, Solver};
use crate::number::vector::{Lanes, Level, Nodes};

/// Modes that the nodes do not see are no larger than the highest four that they see, and fall by a tenth from one to
/// the next at least: that is a geometric series, each of them once on the nodes and once between them. Where modes are
/// rounding they do not fall, and four of them have the size of the others.
const SLOWEST_DECAY: f64 = 0.9;
const MOST_UNSEEN: f64 = 2.0 * SLOWEST_DECAY / (1.0 - SLOWEST_DECAY);
/// s of Newton's law is no result, and ṡ is a square of velocities: it oscillates twice as fast as the motion, so that
/// windows are shorter by half for it at most, and its errors, of orders n and 2n − 1, 2ⁿ and half of 4ⁿ times larger
/// than the others. V may be nothing but rounding, of which no window is short enough.
const TWICE_AS_FAST: f64 = (1_u64 << super::POINTS) as f64;
/// Slopes on the nodes are rounded in their last digit, and polynomials through them are up to three times as far off.
const ROUNDING_OF_SLOPES: f64 = 4.0 * f64::EPSILON;

impl<const N: usize> WithSimd for On<(&mut Solver<'_, N>, f64)> {
    type Output = LocalErrors;

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) -> LocalErrors {
        let On((solver, h)) = self;
        solver.measure(s, h)
    }
}

/// Bounds of the errors that a window makes, relative to sizes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LocalErrors {
    /// At its nodes, of positions and ignorable coordinates: of order n.
    pub(super) inside: f64,
    /// At its end, of all unknowns and ignorable coordinates: of order 2n − 1.
    pub(super) end: f64,
    /// By how much the highest modes of slopes change an unknown.
    pub(super) tail: f64,
    /// The highest modes of slopes relative to these. If it is not small, the bounds say nothing.
    pub(super) roughness: f64,
}

impl LocalErrors {
    /// The error at the end of the window, if modes that its nodes do not see are smaller by `decay` than the highest
    /// ones that they see: they make errors at the end, too.
    pub(super) fn with_unseen(self, decay: f64) -> f64 {
        let unseen = self.tail * decay;
        if unseen > self.end && unseen.is_finite() { unseen } else { self.end }
    }
}

impl<const N: usize> Solver<'_, N> {
    /// The errors of the solved window of this length, measured once more.
    #[cold]
    pub(super) fn measured(&mut self, h: f64) -> LocalErrors {
        Level::Best.dispatch(On((self, h)))
    }

    /// Measures a window of length `h`, if it is to be measured.
    #[inline(always)]
    pub(super) fn measure<S: Simd>(&mut self, s: S, h: f64) -> LocalErrors {
        let Self { system, rows, ways, highest_modes, is_shortest, .. } = self;
        let Some(highest) = highest_modes else { return LocalErrors::default() };
        let System { registers, passes, ignorable, order, .. } = system;
        let (n, is_second) = (self.rule.points() as f64, *order == Order::Second);
        let m = rows.len() / 2;
        let (mut inside, mut most, mut roughness) = (0.0_f64, 0.0_f64, 0.0_f64);
        for pass in &*passes {
            for k in 0..pass.slopes.len() {
                let Row { start, size, .. } = rows[pass.first + k];
                let inverse = size.counted(*is_shortest);
                let slope = Lanes::new(s, &registers[pass.slopes[k]]);
                let [a, tail, next, unseen] = modes(s, highest, slope);
                let [a, tail, next] = [a, tail, next].map(|mode| beyond(mode, size.noise));
                let largest = slope.abs().largest();
                rows[pass.first + k].foreseen = unseen + size.noise + ROUNDING_OF_SLOPES * largest;
                let weight = order.power_of(h) * inverse;
                if pass.first + k < m {
                    // A start is a sum of two doubles, of which the first one need not be the nearest to it: beside
                    // that alone a node would seem off by a rounding.
                    let first_node = (registers[pass.unknowns[k]].0[0] - (start.high + start.low)).abs();
                    let first_node = beyond(first_node, order.power_of(h) * size.noise) * inverse;
                    let expected = if is_second { tail / (2.0 * (2.0 * n - 3.0)) } else { next };
                    inside = larger(inside, larger(first_node, 0.5 * weight * expected / (n - 1.0)));
                }
                let driven = rows[if is_second { m } else { pass.first } + k].size.counted(*is_shortest);
                let weight = larger(weight, if is_second { h * driven } else { 0.0 });
                most = larger(most, weight * larger(a, next));
                if largest * weight > NOISE || largest.is_nan() {
                    roughness = larger(roughness, tail / largest);
                }
            }
        }
        // It is not 0, so that what is seen elsewhere can raise the errors.
        let factor = END[usize::from(is_second)] * larger(roughness, f64::EPSILON) * h;
        let mut end = factor / h * most;
        let of_s = if self.geometry.results() < self.geometry.dimension() {
            ignorable.len().wrapping_sub(1)
        } else {
            usize::MAX
        };
        for k in 0..ignorable.len() {
            let (rate, inverse) = (Lanes::new(s, &registers[ignorable[k]]), ways[k].counted(*is_shortest));
            let [a, tail, next, _] = modes(s, highest, rate).map(|mode| beyond(mode, ways[k].noise));
            let largest = rate.abs().largest();
            // Where nothing else is off, as in a potential of t alone, s is all that there is to see.
            let most_of =
                |factor: f64, error: f64| if k == of_s && error > 0.0 { factor * error } else { f64::INFINITY };
            let of_way = h * larger(a, 0.5 * next) / (n - 1.0) * inverse;
            inside = larger(inside, at_most(of_way, most_of(TWICE_AS_FAST, inside)));
            // It is integrated once, whatever the order of the others is.
            let roughness = if largest > 0.0 { tail / largest } else { 0.0 };
            let of_way = END[0] * roughness * h * larger(a, next) * inverse;
            end = larger(end, at_most(of_way, most_of(0.5 * TWICE_AS_FAST * TWICE_AS_FAST, end)));
        }
        LocalErrors { inside: INSIDE_MARGIN * inside, end, tail: most, roughness }
    }
}

/// The smaller number; NaN stays.
#[inline(always)]
fn at_most(value: f64, most: f64) -> f64 {
    if value > most { most } else { value }
}

/// The part of a number above the noise in it.
#[inline(always)]
fn beyond(value: f64, noise: f64) -> f64 {
    // NaN stays.
    if value <= noise { 0.0 } else { value - noise }
}

/// Measures the modes of a slope: the highest one, the larger one of the two highest, what the decay of modes foretells
/// of the highest where it happens to be small, and what it foretells of those that the nodes do not see.
#[inline(always)]
fn modes<S: Simd, const N: usize>(s: S, highest: &[Nodes<N>; 4], slope: Lanes<S, N>) -> [f64; 4] {
    let (a, b) = (mode_of(s, &highest[0], slope), mode_of(s, &highest[1], slope));
    let (c, d) = (mode_of(s, &highest[2], slope), mode_of(s, &highest[3], slope));
    let (tail, before) = (larger(a, b), larger(c, d));
    let next = if tail < before { tail * (tail / before).sqrt() } else { tail };
    let unseen = MOST_UNSEEN * larger(tail, before);
    [a, tail, next, unseen]
}

/// The size of one mode.
#[inline(always)]
fn mode_of<S: Simd, const N: usize>(s: S, weights: &Nodes<N>, slope: Lanes<S, N>) -> f64 {
    Lanes::new(s, weights).dot(slope).abs()
}

/// The larger number; NaN if one is NaN, unlike `f64::max`.
#[inline(always)]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}
