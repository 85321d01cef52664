//! The world-line by which all methods of an atlas are judged.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, Schur};

use super::status::Sizes;
use crate::case::Case;
use crate::geometry::{Geometry, Start};
use crate::number::Real;
use crate::reference::{EndReason, ReferenceEnds, ReferenceTrajectory};
use crate::solve::Place;
use crate::study::subject::{Subject, distance, length_of};

/// Number of points on the reference at which sizes and frequencies are measured, per step of it, and the largest
/// number in all.
const SAMPLES_A_STEP: usize = 8;
const MOST_SAMPLES: usize = 200_000;

/// The largest acceptable error of the reference, relative to the sizes of [`super::status`]. It is a hundredth of what
/// the rules of the statuses distinguish. If the estimated error of an `f64` reference is larger, one in extended
/// precision takes its place. If that is not better, no cell is called accurate.
const GOOD_REFERENCE: f64 = 1e-4;
/// Digits of the reference in extended precision.
const DIGITS: u32 = 40;
/// The largest number of points at which eigenvalues are computed.
const MOST_POINTS: usize = 5_000;
/// A part of an eigenvalue below this share of the largest eigenvalue is rounding: two equal eigenvalues are known to
/// the root of ε.
const ROUNDING: f64 = 1e-6;
/// Iterations allowed for the eigenvalues of a point. A point whose eigenvalues need more is left out.
const MOST_ITERATIONS: usize = 1_000;
/// If the world-line leaves the domain, the reference ends at this share of its length.
const SHORT_OF_THE_END: f64 = 0.9;

/// The scale of the steps of a chart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pace {
    /// The largest local frequency along the world-line.
    Frequency(f64),
    /// The largest rate of growth, if nothing oscillates.
    Growth(f64),
    /// 2π over the length of the run, if nothing grows either.
    Length(f64),
}

impl Pace {
    /// The rate.
    pub fn rate(self) -> f64 {
        match self {
            Self::Frequency(rate) | Self::Growth(rate) | Self::Length(rate) => rate,
        }
    }
}

/// The trajectory to compare with, in any precision.
struct Reference {
    /// The point at γ − γ_i, which must be in its range.
    at: Box<dyn Fn(f64) -> Start + Send + Sync>,
    /// The estimate of its own error, relative to the largest values of the coordinates.
    error: f64,
    /// Number of Taylor steps.
    steps: usize,
    /// γ − γ_i at its end.
    reached: f64,
}

impl Reference {
    fn new<S: Real>(place: &Place<S>, reached: f64, digits: u32) -> Result<Self, ReferenceEnds> {
        let reference = ReferenceTrajectory::new(&place.geometry, &place.start, reached.into(), digits)?;
        let (error, steps) = (reference.error_estimate(), reference.steps());
        Ok(Self { at: Box::new(move |gamma| reference.at(gamma.into()).in_f64()), error, steps, reached })
    }

    /// One in `f64` of this length, or one as long as the geodesic allows, but at least as long as `least`; with the
    /// end of the geodesic, if it has one.
    fn up_to(place: &Place, length: f64, least: f64) -> Result<(Self, Option<ReferenceEnds>), ReferenceEnds> {
        let of_length = |length| Self::new(place, length, f64::MOST_DIGITS);
        match of_length(length) {
            Ok(reference) => Ok((reference, None)),
            Err(end) if end.reason == EndReason::OutsideDomain => {
                Ok((of_length((SHORT_OF_THE_END * end.gamma).max(least))?, Some(end)))
            }
            Err(end) => Err(end),
        }
    }
}

/// The world-line of a case or of a scene, with its reference.
pub struct Arena {
    pub(super) subject: Subject,
    reference: Reference,
    /// True if a wrong trajectory cannot pass for an accurate one.
    trusted: bool,
    /// Where and why the geodesic ends, if it does.
    pub ends: Option<ReferenceEnds>,
    /// ω, or the rate that takes its place if nothing oscillates. Grids are made for it.
    pub pace: Pace,
    own_length: f64,
}

impl Arena {
    /// The world-line of `case`, with a reference as long as the longest of `lengths` or, if there are none, of the
    /// default ones.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if V has no Taylor series at some point of the geodesic, or the geodesic does not reach t_f of
    /// the case: then nothing could be judged. A geodesic that leaves the domain is not an error; the atlas shows it.
    pub fn new(case: &Case, lengths: &[f64]) -> Result<Self, ReferenceEnds> {
        let subject = Subject::new(case);
        let own_length = match length_of(&subject.own) {
            Ok(length) => length,
            Err(end) if end.reason == EndReason::OutsideDomain => 2.0 * end.gamma,
            Err(end) => return Err(end),
        };
        let (reference, ends) = Reference::up_to(&subject.plain.place, own_length, 0.0)?;
        let mut arena = Self { subject, reference, trusted: false, ends, pace: Pace::Length(1.0), own_length };
        arena.look()?;
        let wanted = if lengths.is_empty() { arena.default_lengths() } else { lengths.to_vec() };
        let (longest, reached) = (wanted.into_iter().fold(0.0, f64::max), arena.reference.reached);
        if longest > reached {
            let (reference, ends) = Reference::up_to(arena.place(), longest, reached)?;
            (arena.reference, arena.ends) = (reference, ends.or(arena.ends));
            arena.look()?;
        }
        Ok(arena)
    }

    /// Measures the rates along the reference, which is replaced by a better one if it is not good.
    fn look(&mut self) -> Result<(), ReferenceEnds> {
        let reached = self.reference.reached;
        let mut points = self.sampled(reached);
        if !self.is_good(&points) {
            self.reference = Reference::new(&self.subject.exact.place, reached, DIGITS)?;
            points = self.sampled(reached);
        }
        self.trusted = self.is_good(&points);
        let [omega, growth] = rates(self.geometry(), &points);
        self.pace = match TAU / self.own_length {
            _ if omega > 0.0 => Pace::Frequency(omega),
            _ if growth > 0.0 => Pace::Growth(growth),
            rate if rate > 0.0 => Pace::Length(rate),
            _ => Pace::Length(1.0),
        };
        Ok(())
    }

    fn place(&self) -> &Place {
        &self.subject.plain.place
    }

    /// The space-time: that of t and x, or of a scene.
    pub fn geometry(&self) -> &Geometry {
        &self.place().geometry
    }

    /// Points of the reference over [0, `length`], which must not go beyond its end.
    fn sampled(&self, length: f64) -> Vec<Start> {
        let count = (self.reference.steps * SAMPLES_A_STEP).clamp(400, MOST_SAMPLES);
        (0..=count).filter_map(|k| self.at(length * (k as f64 / count as f64))).collect()
    }

    /// The reference at γ − γ_i = `gamma`; `None` beyond its end. In one coordinate t is counted from the start.
    pub(super) fn at(&self, gamma: f64) -> Option<Start> {
        let Reference { at, reached, .. } = &self.reference;
        if gamma > reached * (1.0 + 1e-12) { None } else { Some(at(gamma.min(*reached))) }
    }

    /// Returns true if the reference is accurate enough over its whole length that a wrong trajectory cannot pass for
    /// an accurate one. `points` are on it.
    fn is_good(&self, points: &[Start]) -> bool {
        // The estimated error is relative to the largest values, whereas the rules are relative to the sizes.
        let far = |a: usize| largest(points, |point| distance(self.place(), a, point.q[a])).max(f64::MIN_POSITIVE);
        let sizes = self.sizes_of(points, self.reference.reached).q;
        let share = sizes.iter().enumerate().map(|(a, size)| size / far(a)).fold(1.0, f64::min);
        self.reference.error <= GOOD_REFERENCE * share
    }

    /// The sizes by which trajectories over [0, `length`] are judged; `None` beyond the end of the reference, or if
    /// that is not accurate enough.
    pub(super) fn sizes(&self, length: f64) -> Option<Sizes> {
        self.at(length).filter(|_| self.trusted)?;
        Some(self.sizes_of(&self.sampled(length), length))
    }

    /// The sizes by which trajectories with these points are judged. `points` are at least two, ends included.
    /// Coordinates of one unit share their size. The range of γ in which the motion is felt is the shortest in which an
    /// active coordinate moves by its amplitude.
    fn sizes_of(&self, points: &[Start], length: f64) -> Sizes {
        let (geometry, start) = (self.geometry(), &self.place().start);
        let is_active = |a: usize| geometry.active().contains(&a);
        let all = |of: &dyn Fn(usize) -> f64| (0..geometry.dimension()).map(of).collect::<Vec<f64>>();
        let half = geometry.shared(&start.q, &all(&|a| if is_active(a) { half_range(points, a) } else { 0.0 }));
        let speeds = geometry.shared(&start.q, &all(&|a| largest(points, |point| point.q_dot[a])));
        // At rest there is no amplitude, and the largest value takes its place.
        let amplitude = |a: usize| match largest(points, |point| point.q[a]) {
            largest if half[a] > 1e-12 * largest => half[a],
            largest => largest.max(f64::MIN_POSITIVE),
        };
        let motion = points.iter().map(|point| geometry.motion(&point.q, &point.q_dot)).fold(0.0, f64::max);
        let k = if motion > 0.0 { motion } else { geometry.norm(&start.q, &start.q_dot).abs() };
        if geometry.c_squared.is_some() {
            // In one coordinate t has the time in which x moves by its amplitude at its largest speed.
            let (x, speed) = (amplitude(1), largest(points, |point| point.q_dot[1] / point.q_dot[0]));
            let duration = points.last().map_or(0.0, |end| end.q[0].abs());
            return Sizes { q: vec![if speed > 0.0 { duration.min(x / speed) } else { duration }, x], k };
        }
        let moved = geometry.active().iter().filter(|&&a| speeds[a] > 0.0).map(|&a| amplitude(a) / speeds[a]);
        let felt = moved.fold(length, f64::min);
        let size = |a: usize| if is_active(a) { amplitude(a) } else { (speeds[a] * felt).max(f64::MIN_POSITIVE) };
        Sizes { q: all(&size), k }
    }

    /// Returns true if it is that of a scene that is the lift of Newton's law, which has an energy.
    pub fn has_energy(&self) -> bool {
        self.subject.is_lifted
    }

    /// The largest local frequency along the reference; 0 if nothing oscillates. In one coordinate ω² = −dẍ/dx where
    /// that is positive. In a scene ω is the largest |Im λ| of the eigenvalues λ of ∂(q̇, ṗ)/∂(q, p) of the active
    /// coordinates and their momenta.
    pub fn omega(&self) -> f64 {
        if let Pace::Frequency(omega) = self.pace { omega } else { 0.0 }
    }

    /// ṫ_i of the case; `None` in a scene without a coordinate t.
    pub fn t_dot(&self) -> Option<f64> {
        let t = self.geometry().names().iter().position(|name| name == "t")?;
        Some(self.place().start.q_dot[t])
    }

    /// The reference's own estimate of its relative error.
    pub fn reference_error(&self) -> f64 {
        self.reference.error
    }

    /// The case's own length, and 1, 2, 5, 10, … from two radians of the fastest oscillation to a thousand.
    pub fn default_lengths(&self) -> Vec<f64> {
        let rate = self.pace.rate();
        let mut lengths = round_numbers(2.0 / rate, 1100.0 / rate, &[1.0, 2.0, 5.0]);
        if lengths.iter().all(|length| (length / self.own_length - 1.0).abs() > 0.01) {
            lengths.push(self.own_length);
        }
        lengths.sort_by(f64::total_cmp);
        lengths
    }

    /// Spacings of round numbers with Δγω from about 0.02 to 2.
    pub fn default_spacings(&self) -> Vec<f64> {
        let rate = self.pace.rate();
        round_numbers(0.02 / rate, 2.2 / rate, &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0])
    }
}

/// The largest |Im λ| and the largest |Re λ| of the eigenvalues λ of ∂(q̇, ṗ)/∂(q, p) of the active coordinates and
/// their momenta, at these points; 0 where all are rounding. In one coordinate λ² = dẍ/dx.
fn rates(geometry: &Geometry, points: &[Start]) -> [f64; 2] {
    let every = points.len().div_ceil(MOST_POINTS).max(1);
    let (mut at, size) = (geometry.point(), 2 * geometry.active().len());
    let (mut largest, mut all) = ([0.0_f64; 2], 0.0_f64);
    for point in points.iter().step_by(every) {
        let mut jacobian = DMatrix::zeros(size, size);
        at.jacobian(&point.q, &point.p, |row, column, value| jacobian[(row, column)] = value);
        for [re, im] in eigenvalues(jacobian) {
            largest = [largest[0].max(im.abs()), largest[1].max(re.abs())];
            all = all.max(re.hypot(im));
        }
    }
    largest.map(|rate| if rate > ROUNDING * all { rate } else { 0.0 })
}

/// Real and imaginary parts of the eigenvalues of ((A, B), (C, D)); none if a number is not finite.
fn eigenvalues(mut matrix: DMatrix<f64>) -> Vec<[f64; 2]> {
    let half = matrix.nrows() / 2;
    let size = |row: usize, column: usize| matrix.view((row, column), (half, half)).amax();
    let [b, c] = [size(0, half), size(half, 0)];
    // B and C have units that are the inverse of each other, of any size. A similarity makes them equally large.
    if b > 0.0 && c > 0.0 {
        let (b, c) = (b.sqrt(), c.sqrt());
        let (to_b, to_c) = (c / b, b / c);
        matrix.view_mut((0, half), (half, half)).scale_mut(to_b);
        matrix.view_mut((half, 0), (half, half)).scale_mut(to_c);
    }
    let unit = matrix.amax();
    if unit == 0.0 || !matrix.iter().all(|value| value.is_finite()) {
        return Vec::new();
    }
    let Some(schur) = Schur::try_new(matrix / unit, f64::EPSILON, MOST_ITERATIONS) else { return Vec::new() };
    schur.complex_eigenvalues().iter().map(|value| [value.re * unit, value.im * unit]).collect()
}

/// The largest absolute value at these points.
fn largest(points: &[Start], of: impl Fn(&Start) -> f64) -> f64 {
    points.iter().map(|point| of(point).abs()).fold(0.0, f64::max)
}

/// Half the range of a coordinate.
fn half_range(points: &[Start], a: usize) -> f64 {
    let values = || points.iter().map(|point| point.q[a]);
    0.5 * (values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min))
}

/// The numbers between two others that are one of `digits` times a power of ten.
fn round_numbers(from: f64, to: f64, digits: &[f64]) -> Vec<f64> {
    let (first, last) = (from.log10().floor() as i32, to.log10().ceil() as i32);
    // They are parsed as decimals, so that they are correctly rounded.
    let read = |digit: f64, power: i32| format!("{digit}e{power}").parse().ok();
    let all = (first..=last).flat_map(|power| digits.iter().filter_map(move |&digit| read(digit, power)));
    // Rounding of the ends does not decide.
    let (from, to) = (from * (1.0 - 1e-12), to * (1.0 + 1e-12));
    all.filter(|number| (from..=to).contains(number)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_are_of_round_numbers() {
        assert_eq!(round_numbers(0.7, 30.0, &[1.0, 2.0, 5.0]), [1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(round_numbers(0.02, 0.1, &[1.0, 5.0]), [0.05, 0.1]);
        assert_eq!(round_numbers(1e-101, 2e-100, &[1.0]), [1e-101, 1e-100]);
    }
}
