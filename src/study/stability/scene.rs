//! The world-line by which all methods of an atlas are judged.

use crate::case::{Case, End, Solver};
use crate::geodesic::{InitialData, Invariants, acceleration_slope};
use crate::metric::Metric;
use crate::reference::{EndReason, ReferenceEnds, ReferencePoint, ReferenceTrajectory};
use crate::scalar::{Extended, Real};

use super::status::Sizes;

/// Number of points on the reference at which sizes and frequencies are measured, per step of it, and the largest
/// number in all.
const SAMPLES_A_STEP: usize = 8;
const MOST_SAMPLES: usize = 200_000;

/// The largest acceptable error of the reference, relative to the sizes A and T of [`super::status`]. It is a hundredth
/// of what the rules of the statuses distinguish. If the estimated error of an `f64` reference is larger, one in
/// extended precision takes its place. If that is not better, no cell is called accurate.
const GOOD_REFERENCE: f64 = 1e-4;
/// Digits of the reference in extended precision.
const DIGITS: u32 = 40;
/// If the world-line leaves the domain, the reference ends at this share of its length.
const SHORT_OF_THE_END: f64 = 0.9;

/// The reference, in the precision that it needs.
enum Reference {
    Double(ReferenceTrajectory),
    Extended(ReferenceTrajectory<Extended>),
}

/// The geodesic of a case.
pub struct Scene {
    /// The case without what belongs to one scheme only: its windows, its solver, its expectations and D in place of
    /// D̄.
    pub(super) case: Case,
    pub(super) metric: Metric,
    pub(super) initial: InitialData,
    reference: Option<Reference>,
    /// γ − γ_i at the end of the reference.
    reached: f64,
    trusted: bool,
    ends: Option<ReferenceEnds>,
    /// Largest local frequency along the reference; 0 if the motion never oscillates.
    omega: f64,
    /// The rate for which grids are made: ω or, if nothing oscillates, the largest rate of growth or, if there is none
    /// either, 2π over the length of the run.
    pace: f64,
    own_length: f64,
}

impl Scene {
    /// The scene of `case`, with a reference as long as the longest of `lengths` or, if there are none, of the default
    /// ones.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if V has no Taylor series at some point of the geodesic, or the geodesic does not reach t_f of
    /// the case: then nothing could be judged. A geodesic that leaves the domain is not an error; the atlas shows it.
    pub fn new(case: &Case, lengths: &[f64]) -> Result<Self, ReferenceEnds> {
        let mut plain = case.clone();
        plain.grid.windows = 1;
        plain.scheme.regularised = true;
        plain.solver = Solver::default();
        plain.expect = None;
        let (metric, initial) = (case.metric::<f64>(), InitialData { t: 0.0, ..case.initial_data() });
        let own_length = match case.end() {
            End::Length(length) => length,
            End::Duration(duration) => {
                match ReferenceTrajectory::length_of(&metric, initial, duration, f64::MOST_DIGITS) {
                    Ok(length) => length,
                    Err(end) if end.reason == EndReason::OutsideDomain => 2.0 * end.gamma,
                    Err(end) => return Err(end),
                }
            }
        };
        let mut scene = Self {
            case: plain,
            metric,
            initial,
            reference: None,
            reached: 0.0,
            trusted: false,
            ends: None,
            omega: 0.0,
            pace: 0.0,
            own_length,
        };
        scene.refer(own_length)?;
        let wanted = match lengths {
            [] => scene.default_lengths(),
            lengths => lengths.to_vec(),
        };
        let longest = wanted.into_iter().fold(0.0, f64::max);
        if longest > scene.reached {
            scene.refer(longest)?;
        }
        Ok(scene)
    }

    /// Computes a reference of the given `length`, or as long as the geodesic allows.
    fn refer(&mut self, length: f64) -> Result<(), ReferenceEnds> {
        let double = |length: f64| ReferenceTrajectory::new(&self.metric, self.initial, length, f64::MOST_DIGITS);
        let (reference, reached) = match double(length) {
            Ok(reference) => (reference, length),
            Err(end) if end.reason == EndReason::OutsideDomain => {
                self.ends = Some(end);
                let short = (SHORT_OF_THE_END * end.gamma).max(self.reached);
                (double(short)?, short)
            }
            Err(end) => return Err(end),
        };
        self.reached = reached;
        self.reference = Some(Reference::Double(reference));
        if !self.is_good() {
            let (metric, initial) = (self.case.metric(), self.case.initial_data::<Extended>());
            let initial = InitialData { t: Extended::ZERO, ..initial };
            let extended = ReferenceTrajectory::new(&metric, initial, reached.into(), DIGITS)?;
            self.reference = Some(Reference::Extended(extended));
        }
        self.trusted = self.is_good();
        let q_t = self.invariants().q_t;
        let slope = |point: &ReferencePoint| {
            let jet = self.metric.at(point.x);
            acceleration_slope(q_t, jet.g00, jet.first, jet.second)
        };
        let slopes: Vec<f64> = self.sampled(reached).iter().map(slope).filter(|slope| slope.is_finite()).collect();
        let largest = |sign: f64| slopes.iter().fold(0.0_f64, |most, slope| most.max(sign * slope)).sqrt();
        self.omega = largest(-1.0);
        let rates = [self.omega, largest(1.0), std::f64::consts::TAU / self.own_length];
        self.pace = rates.into_iter().find(|&rate| rate > 0.0).unwrap_or(1.0);
        Ok(())
    }

    /// Points of the reference over [0, `length`], which must not go beyond its end.
    fn sampled(&self, length: f64) -> Vec<ReferencePoint> {
        let steps = match &self.reference {
            Some(Reference::Double(reference)) => reference.steps(),
            Some(Reference::Extended(reference)) => reference.steps(),
            None => return Vec::new(),
        };
        let count = (steps * SAMPLES_A_STEP).clamp(400, MOST_SAMPLES);
        (0..=count).filter_map(|k| self.at(length * (k as f64 / count as f64))).collect()
    }

    /// The reference at γ − γ_i = `gamma`; `None` beyond its end.
    pub(super) fn at(&self, gamma: f64) -> Option<ReferencePoint> {
        if gamma > self.reached * (1.0 + 1e-12) {
            return None;
        }
        let gamma = gamma.min(self.reached);
        match self.reference.as_ref()? {
            Reference::Double(reference) => Some(reference.at(gamma)),
            Reference::Extended(reference) => {
                let ReferencePoint { elapsed, x, t_dot, x_dot } = reference.at(gamma.into());
                let [elapsed, x, t_dot, x_dot] = [elapsed, x, t_dot, x_dot].map(|value| value.to_f64());
                Some(ReferencePoint { elapsed, x, t_dot, x_dot })
            }
        }
    }

    /// Whether the reference is accurate enough over its whole length that a wrong trajectory cannot pass for an
    /// accurate one.
    fn is_good(&self) -> bool {
        let (Some(sizes), Some(end)) = (self.measured_sizes(self.reached), self.at(self.reached)) else { return false };
        // The estimated error is relative to the largest t and x, whereas the rules are relative to T and A.
        let far = self.sampled(self.reached).iter().fold(f64::MIN_POSITIVE, |far, point| far.max(point.x.abs()));
        let duration = end.elapsed.abs().max(f64::MIN_POSITIVE);
        self.reference_error() <= GOOD_REFERENCE * (sizes.t / duration).min(sizes.x / far).min(1.0)
    }

    /// The sizes by which trajectories over [0, `length`] are judged; `None` beyond the end of the reference, or if
    /// that is not accurate enough.
    pub(super) fn sizes(&self, length: f64) -> Option<Sizes> {
        self.measured_sizes(length).filter(|_| self.trusted)
    }

    fn measured_sizes(&self, length: f64) -> Option<Sizes> {
        self.at(length)?;
        let points = self.sampled(length);
        let range =
            points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| [low.min(p.x), high.max(p.x)]);
        let largest = |of: &dyn Fn(&ReferencePoint) -> f64| points.iter().map(of).fold(0.0, f64::max);
        let far = largest(&|p| p.x.abs());
        let amplitude = 0.5 * (range[1] - range[0]);
        // A particle at rest has no amplitude.
        let x = if amplitude > 1e-12 * far { amplitude } else { far.max(f64::MIN_POSITIVE) };
        let (speed, x_dot) = (largest(&|p| (p.x_dot / p.t_dot).abs()), largest(&|p| p.x_dot.abs()));
        let duration = points.last()?.elapsed.abs();
        let t = if speed > 0.0 { duration.min(x / speed) } else { duration };
        let k = if x_dot > 0.0 { x_dot * x_dot } else { self.invariants().k.abs() };
        Some(Sizes { x, t, k })
    }

    /// Q_t and K.
    pub(super) fn invariants(&self) -> Invariants {
        self.initial.invariants(&self.metric)
    }

    /// The largest local frequency along the reference, ω² = −dẍ/dx where that is positive; 0 if it nowhere is.
    pub fn omega(&self) -> f64 {
        self.omega
    }

    /// ω, or the rate that takes its place if nothing oscillates.
    pub fn pace(&self) -> f64 {
        self.pace
    }

    /// ṫ_i of the case.
    pub fn t_dot(&self) -> f64 {
        self.initial.t_dot
    }

    /// Where and why the geodesic ends, if it does.
    pub fn ends(&self) -> Option<&ReferenceEnds> {
        self.ends.as_ref()
    }

    /// The reference's own estimate of its relative error.
    pub fn reference_error(&self) -> f64 {
        match &self.reference {
            Some(Reference::Double(reference)) => reference.error_estimate(),
            Some(Reference::Extended(reference)) => reference.error_estimate(),
            None => f64::INFINITY,
        }
    }

    /// The case's own length, and 1, 2, 5, 10, … from two radians of the fastest oscillation to a thousand.
    pub fn default_lengths(&self) -> Vec<f64> {
        let mut lengths = round_numbers(2.0 / self.pace, 1100.0 / self.pace, &[1.0, 2.0, 5.0]);
        if lengths.iter().all(|length| (length / self.own_length - 1.0).abs() > 0.01) {
            lengths.push(self.own_length);
        }
        lengths.sort_by(f64::total_cmp);
        lengths
    }

    /// Spacings of round numbers with Δγω from about 0.02 to 2.
    pub fn default_spacings(&self) -> Vec<f64> {
        round_numbers(0.02 / self.pace, 2.2 / self.pace, &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0])
    }
}

/// The numbers between two others that are one of `digits` times a power of ten.
fn round_numbers(from: f64, to: f64, digits: &[f64]) -> Vec<f64> {
    let (first, last) = (from.log10().floor() as i32, to.log10().ceil() as i32);
    // They are parsed as decimals, so that they are correctly rounded.
    let read = |digit: f64, power: i32| format!("{digit}e{power}").parse().ok();
    let all = (first..=last).flat_map(|power| digits.iter().filter_map(move |&digit| read(digit, power)));
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
