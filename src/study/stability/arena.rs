//! The world-line by which all methods of an atlas are judged.

use std::f64::consts::TAU;

use super::chart::Chart;
use super::status::Sizes;
use super::task::Reference;
use crate::case::Case;
use crate::reference::{EndReason, ReferenceEnds};
use crate::study::line::Line;
use crate::study::space::Point;

/// Number of points on the reference at which sizes and frequencies are measured, per step of it, and the largest
/// number in all.
const SAMPLES_A_STEP: usize = 8;
const MOST_SAMPLES: usize = 200_000;

/// The largest acceptable error of the reference, relative to the sizes of [`super::status`]. It is a hundredth of what
/// the rules of the statuses distinguish. If the estimated error of an `f64` reference is larger, one in extended
/// precision takes its place. If that is not better, no cell is called accurate.
const GOOD_REFERENCE: f64 = 1e-4;
/// Digits of the reference in extended precision.
pub(super) const DIGITS: u32 = 40;
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

/// The world-line of a case or of a scene, with its reference.
pub struct Arena {
    pub(super) chart: Chart,
    reference: Option<Box<dyn Reference>>,
    /// γ − γ_i at the end of the reference.
    reached: f64,
    trusted: bool,
    ends: Option<ReferenceEnds>,
    pace: Pace,
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
        Self::of(Chart::new(Line::new(case)), lengths)
    }

    fn of(chart: Chart, lengths: &[f64]) -> Result<Self, ReferenceEnds> {
        let own_length = match chart.own_length() {
            Ok(length) => length,
            Err(end) if end.reason == EndReason::OutsideDomain => 2.0 * end.gamma,
            Err(end) => return Err(end),
        };
        let pace = Pace::Length(1.0);
        let mut arena = Self { chart, reference: None, reached: 0.0, trusted: false, ends: None, pace, own_length };
        arena.refer(own_length)?;
        let wanted = match lengths {
            [] => arena.default_lengths(),
            lengths => lengths.to_vec(),
        };
        let longest = wanted.into_iter().fold(0.0, f64::max);
        if longest > arena.reached {
            arena.refer(longest)?;
        }
        Ok(arena)
    }

    /// Computes a reference of the given `length`, or as long as the geodesic allows.
    fn refer(&mut self, length: f64) -> Result<(), ReferenceEnds> {
        let (reference, reached) = match self.chart.reference(length, false) {
            Ok(reference) => (reference, length),
            Err(end) if end.reason == EndReason::OutsideDomain => {
                let short = (SHORT_OF_THE_END * end.gamma).max(self.reached);
                self.ends = Some(end);
                (self.chart.reference(short, false)?, short)
            }
            Err(end) => return Err(end),
        };
        self.reached = reached;
        self.reference = Some(reference);
        let mut points = self.sampled(reached);
        if !self.is_good(&points) {
            self.reference = Some(self.chart.reference(reached, true)?);
            points = self.sampled(reached);
        }
        self.trusted = self.is_good(&points);
        let [omega, growth] = self.chart.rates(&points);
        self.pace = match TAU / self.own_length {
            _ if omega > 0.0 => Pace::Frequency(omega),
            _ if growth > 0.0 => Pace::Growth(growth),
            rate if rate > 0.0 => Pace::Length(rate),
            _ => Pace::Length(1.0),
        };
        Ok(())
    }

    /// Points of the reference over [0, `length`], which must not go beyond its end.
    fn sampled(&self, length: f64) -> Vec<Point> {
        let steps = self.reference.as_ref().map_or(0, |reference| reference.steps());
        let count = (steps * SAMPLES_A_STEP).clamp(400, MOST_SAMPLES);
        (0..=count).filter_map(|k| self.at(length * (k as f64 / count as f64))).collect()
    }

    /// The reference at γ − γ_i = `gamma`; `None` beyond its end.
    pub(super) fn at(&self, gamma: f64) -> Option<Point> {
        if gamma > self.reached * (1.0 + 1e-12) {
            return None;
        }
        Some(self.reference.as_ref()?.at(gamma.min(self.reached)))
    }

    /// Returns true if the reference is accurate enough over its whole length that a wrong trajectory cannot pass for
    /// an accurate one. `points` are on it.
    fn is_good(&self, points: &[Point]) -> bool {
        if points.len() < 2 {
            return false;
        }
        let (sizes, origin) = (self.chart.sizes(points, self.reached), self.chart.origin());
        // The estimated error is relative to the largest values, whereas the rules are relative to the sizes.
        let far = |a: usize| largest(points, |point| point.q[a] - origin[a]).max(f64::MIN_POSITIVE);
        let share = sizes.q.iter().enumerate().map(|(a, size)| size / far(a)).fold(1.0, f64::min);
        self.reference_error() <= GOOD_REFERENCE * share
    }

    /// The sizes by which trajectories over [0, `length`] are judged; `None` beyond the end of the reference, or if
    /// that is not accurate enough.
    pub(super) fn sizes(&self, length: f64) -> Option<Sizes> {
        self.at(length).filter(|_| self.trusted)?;
        Some(self.chart.sizes(&self.sampled(length), length))
    }

    /// Returns true if it is that of a scene.
    pub fn is_scene(&self) -> bool {
        self.chart.is_scene()
    }

    /// Returns true if it is that of a scene that is the lift of Newton's law, which has an energy.
    pub fn has_energy(&self) -> bool {
        self.chart.has_energy()
    }

    /// The names of the coordinates: t and x, or those of a scene.
    pub fn coordinates(&self) -> &[String] {
        self.chart.coordinates()
    }

    /// The coordinates whose momenta are charges, by their places.
    pub fn charges(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.coordinates().len()).filter(|a| !self.chart.active().contains(a))
    }

    /// The largest local frequency along the reference; 0 if nothing oscillates. In one coordinate ω² = −dẍ/dx where
    /// that is positive. In a scene ω is the largest |Im λ| of the eigenvalues λ of ∂(q̇, ṗ)/∂(q, p) of the active
    /// coordinates and their momenta.
    pub fn omega(&self) -> f64 {
        if let Pace::Frequency(omega) = self.pace { omega } else { 0.0 }
    }

    /// ω, or the rate that takes its place if nothing oscillates. Grids are made for it.
    pub fn pace(&self) -> Pace {
        self.pace
    }

    /// ṫ_i of the case; `None` in a scene without a coordinate t.
    pub fn t_dot(&self) -> Option<f64> {
        self.chart.t_dot()
    }

    /// Where and why the geodesic ends, if it does.
    pub fn ends(&self) -> Option<&ReferenceEnds> {
        self.ends.as_ref()
    }

    /// The reference's own estimate of its relative error.
    pub fn reference_error(&self) -> f64 {
        self.reference.as_ref().map_or(f64::INFINITY, |reference| reference.error_estimate())
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

/// The largest absolute value at these points.
pub(super) fn largest(points: &[Point], of: impl Fn(&Point) -> f64) -> f64 {
    points.iter().map(|point| of(point).abs()).fold(0.0, f64::max)
}

/// Half the range of a coordinate.
pub(super) fn half_range(points: &[Point], a: usize) -> f64 {
    let values = || points.iter().map(|point| point.q[a]);
    0.5 * (values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min))
}

/// The amplitude of a coordinate, from half its range and its largest absolute value. At rest there is no amplitude,
/// and the largest value takes its place.
pub(super) fn amplitude(half_range: f64, largest: f64) -> f64 {
    if half_range > 1e-12 * largest { half_range } else { largest.max(f64::MIN_POSITIVE) }
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
