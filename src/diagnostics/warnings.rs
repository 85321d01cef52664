//! Warnings that the trajectory of a run should not be believed, judged by its numbers. Each is one sentence with the
//! number, its threshold and the remedy.

use std::f64::consts::FRAC_PI_2;

use super::verdict::{Reason, SMALLER_ACCURACY};
use super::{Diagnostics, Extent, NEGLIGIBLE, OfX, Sawtooth};
use crate::engine::Accuracy;
use crate::number::Real;
use crate::number::norm::{larger, max_abs};
use crate::sbp::symbol::{largest_symbol, symbol};
use crate::solve::WorldLine;

/// A drift of K by more than this share of the largest ẋ² means that x is not resolved. K = g00 ṫ² − ẋ² determines the
/// orbit; K itself may be as large as c², and relative to that a change of speed would not be seen.
const LARGE_DRIFT: f64 = 0.1;
/// Where the space-time is not that of x alone, a drift of K is judged by what motion contributes to it.
const DOUBTFUL_DRIFT: f64 = 1e-2;
/// A sawtooth is large above this share of the amplitude of x: the study `stability` calls such errors inaccurate.
const LARGE_SAWTOOTH: f64 = 1e-2;
/// A grid function is rough if its sixth difference (over 64) is above this share of its fourth (over 16). For a
/// sawtooth they are equal; for a smooth motion the share is (Δγω)²/4.
const ROUGH: f64 = 0.5;
/// A drift of K below this share of K can be rounding.
const ROUNDING: f64 = 1e4 * f64::EPSILON;
/// Steps above this share of the operator's largest symbol are too long. Beyond that symbol the grid has no oscillation
/// of such a frequency; half of it means seven (SBP84) to thirteen (SBP21) nodes per oscillation, and for SBP21 a phase
/// error of 0.3 rad per oscillation.
const NEAR_THE_LIMIT: f64 = 0.5;
/// Share of the acceleration by which a motion may differ from Newton's without a warning. That warning concerns the
/// model: the motion is a geodesic all the same.
const NOT_NEWTONIAN: f64 = 1e-2;
/// Below this g00/c² the particle is near a horizon.
const NEAR_A_HORIZON: f64 = 1e-2;
/// In `f64`, Newton's method normally ends with a relative correction below this. As it converges quadratically, that
/// leaves no error above rounding. After a larger last correction, it was rounding that ended the iteration.
const SMALL_CORRECTION: f64 = 1e-8;
/// The digits in which rounding may show.
const SPARE_DIGITS: i32 = 3;

impl<S: Real> Sawtooth<S> {
    /// The warning that the motion in the coordinate `name`, in this range and with so many digits, has a sawtooth.
    fn warning(&self, name: &str, reach: Extent, digits: u32) -> Option<Reason> {
        let (sawtooth, sixth) = (self.amplitude?.to_f64(), self.sixth_difference?);
        let allowed = LARGE_SAWTOOTH * 0.5 * reach.range();
        // At rest there is nothing but rounding.
        let rounding = 10.0_f64.powi(SPARE_DIGITS - digits as i32) * reach.size();
        // What is no number is no small sawtooth.
        let is_small = sawtooth <= allowed.max(rounding) || sixth <= ROUGH * sawtooth;
        (!is_small).then(|| {
            let finding = format!(
                "even and odd nodes are apart: the sawtooth in {name} is {sawtooth:.1e}, above {allowed:.1e}, \
                 {LARGE_SAWTOOTH} of the amplitude"
            );
            let remedy = "use an operator of higher order or a weak form in windows, or raise n_gamma";
            Reason::sign(finding, remedy)
        })
    }
}

impl<S: Real> Diagnostics<S> {
    /// The warnings that the trajectory of `line`, which was measured, should not be believed, one sentence each.
    pub fn warnings(&self, line: &WorldLine<S>) -> Vec<String> {
        self.suspicions(line, 0.0).iter().map(Reason::to_string).collect()
    }

    /// The reasons to doubt the trajectory of `line`, which was measured, where rounding takes so much from K at most.
    pub fn suspicions(&self, line: &WorldLine<S>, lost: f64) -> Vec<Reason> {
        let names = line.geometry().names();
        let of = |(a, sawtooth): &(usize, Sawtooth<S>)| sawtooth.warning(&names[*a], self.reaches[*a], line.digits);
        let mut found: Vec<Reason> = self.sawtooth.iter().filter_map(of).collect();
        let drift = self.norm.drift();
        match &self.of_x {
            None => found.extend(self.drift_of_motion(drift, lost, line)),
            Some(of_x) => {
                let all = [of_x.drift_warning(drift, line), of_x.step_warning(line), of_x.horizon_warning(line)];
                found.extend(all.into_iter().flatten());
            }
        }
        found.extend(line.windows_unproved.filter(|&windows| windows > 0).map(|windows| {
            let finding = format!(
                "in {windows} of the steps, too short to be cut again, the formulas are so steep that what they do \
                 between the nodes is not proved"
            );
            let remedy = "write the formula without the kink or pole at that place, or compare with a fixed grid";
            Reason::new(finding, remedy)
        }));
        found.extend(rounding_warning(line));
        found.extend(self.lost(line));
        if let Some(of_x) = &self.of_x {
            found.extend(of_x.bound_warning(line));
            found.extend(of_x.printed_warnings(line));
        }
        found
    }

    /// The warning that a number of the run is beyond the range of numbers: nothing that is compared with it says
    /// anything.
    fn lost(&self, line: &WorldLine<S>) -> Option<Reason> {
        let growth =
            line.sensitivity.as_ref().map(|growth| growth.growth()).map(|growth| [growth.lyapunov, growth.megno]);
        let of_x = self.of_x.as_ref().map(|of_x| {
            let ends = [of_x.h_bvp, of_x.h_bvp_bound, of_x.distance].map(S::to_f64);
            larger(max_abs(&ends), max_abs(&[of_x.x_dot, of_x.spacing, of_x.g00]))
        });
        let numbers = [
            ("the certificate", Some(line.gradient_norm.to_f64())),
            ("the residual of the equations", Some(self.max_delta_g.to_f64())),
            ("the distance of the branches", self.branch_distance.map(S::to_f64)),
            ("the growth of small changes", growth.map(|growth| max_abs(&growth))),
            ("the contribution of motion to K", Some(self.motion)),
            ("a measure of x", of_x),
            ("the defect between the nodes", self.defect.as_ref().map(|defect| defect.most)),
        ];
        let (name, _) = numbers.into_iter().find(|(_, number)| number.is_some_and(|number| !number.is_finite()))?;
        Some(Reason::new(format!("{name} is beyond the range of numbers"), "end the run before that"))
    }

    /// The warning that K drifts by more than formulas lose, where motion is what it contributes to K.
    fn drift_of_motion(&self, drift: f64, lost: f64, line: &WorldLine<S>) -> Option<Reason> {
        let drift = if self.norm.is_rounding() { self.norm.max_ends.to_f64() } else { drift };
        let is_small = drift - lost <= DOUBTFUL_DRIFT * self.motion;
        // D makes noise of a motion that is no larger than the rounding of its place.
        let mut reaches = line.geometry().active().iter().map(|&a| self.reaches[a]);
        let is_noise = reaches.all(|reach| reach.range() <= ROUNDING * reach.size());
        // A force changes K.
        if is_small || is_noise || self.motion == 0.0 || !line.geometry().structure().force.is_empty() {
            return None;
        }
        let share = drift / self.motion;
        let finding = format!(
            "K drifts by {drift:.1e}, {share:.1e} of what motion contributes to it: the charges are exact, and the \
             world-line is not to be trusted"
        );
        Some(Reason::sign(finding, "raise n_gamma or windows"))
    }
}

impl<S: Real> OfX<S> {
    fn drift_warning(&self, drift: f64, line: &WorldLine<S>) -> Option<Reason> {
        let (x_dot, k) = (self.x_dot, line.norm().to_f64().abs());
        let (size, name) = if x_dot > 0.0 { (x_dot * x_dot, "the largest x_dot^2") } else { (k, "K") };
        let is_small = drift <= LARGE_DRIFT * size || drift <= ROUNDING * k;
        (!is_small).then(|| {
            let finding = format!(
                "K drifts by {drift:.2e}, above {:.2e}, {LARGE_DRIFT} of {name}: x is not resolved, however exact Q_t \
                 is",
                LARGE_DRIFT * size
            );
            let finer = "raise n_gamma or windows, or use an operator of higher order";
            Reason::sign(finding, if line.accuracy.is_some() { SMALLER_ACCURACY } else { finer })
        })
    }

    fn step_warning(&self, line: &WorldLine<S>) -> Option<Reason> {
        let (step, sbp) = (self.step(), line.sbp_name);
        // With an accuracy the program has chosen the windows by the error, so this warning is not needed. And a value
        // of the symbol, which is no more than the largest one, is known at less cost.
        let is_short = |table| step <= NEAR_THE_LIMIT * symbol(table, FRAC_PI_2);
        if line.error_estimate.is_some() || sbp.coefficients().is_some_and(is_short) {
            return None;
        }
        let (allowed, what) = match sbp.coefficients() {
            Some(table) => (NEAR_THE_LIMIT * largest_symbol(table), format!("half the limit of {sbp}")),
            None => (FRAC_PI_2, "fewer than four nodes a turn".to_owned()),
        };
        (step > allowed).then(|| {
            let finding =
                format!("delta_gamma times the largest local frequency is {step:.2}, above {allowed:.2}, {what}");
            let remedy = format!("raise n_gamma or windows by a factor of {:.1} or more", step / allowed);
            Reason { link: ": ", ..Reason::sign(finding, remedy) }
        })
    }

    /// The warning that the motion is not Newton's, with the c that would make it so.
    pub fn newtonian_warning(&self) -> Option<String> {
        let deviation = self.deviation;
        (deviation > NOT_NEWTONIAN).then(|| {
            let percent = 100.0 * deviation;
            let share = if deviation < 10.0 { format!("{percent:.2} %") } else { format!("{deviation:.1e}") };
            let with_c = |c| format!("; particle.c = {c} would make that about {NEGLIGIBLE:e}");
            let remedy = self.c().map_or(String::new(), with_c);
            format!(
                "x(t) is a geodesic and not the motion of Newton's mechanics: the acceleration differs by up to \
                 {share} (2 v^2/g00), above {} %{remedy}",
                100.0 * NOT_NEWTONIAN
            )
        })
    }

    fn horizon_warning(&self, line: &WorldLine<S>) -> Option<Reason> {
        let g00 = self.g00;
        (g00 < NEAR_A_HORIZON).then(|| {
            let remedies =
                ["end the run earlier, raise c, or ask for solver.accuracy", "end the run earlier or raise c"];
            let finding = format!(
                "g00 falls to {g00:.1e} c^2, below {NEAR_A_HORIZON}: near a horizon x changes ever faster in gamma"
            );
            Reason::new(finding, remedies[usize::from(line.accuracy.is_some())])
        })
    }

    /// The warnings that numbers as printed are not as good as the accuracy. The solver counts time from t_i, so that a
    /// large t_i costs no accuracy, but t itself is rounded. Between two neighbouring values of γ the particle moves,
    /// and x at a printed γ is off by that distance.
    fn printed_warnings(&self, line: &WorldLine<S>) -> Vec<Reason> {
        let Some(accuracy) = line.accuracy.map(Accuracy::value) else { return Vec::new() };
        let t = format!("as printed it cannot be good to the accuracy {accuracy:e} of t - t_i");
        let x = format!("x at gamma as printed cannot be good to the accuracy {accuracy:e}");
        let numbers = [
            ("t", [line.t_i(), line.end_state().t], 1.0, t, "initial.t"),
            ("gamma", [line.gamma_i, line.gamma_f()], self.x_dot, x, "grid.gamma_i"),
        ];
        let told = |((name, ends, rate, what, key), size): (_, &f64)| {
            let [first, last]: [f64; 2] = <[S; 2]>::map(ends, |end| end.to_f64().abs());
            let place = first.max(last);
            let spacing = place.next_up() - place;
            (spacing * rate > accuracy * size).then(|| {
                let finding = format!("{name} is near {place:.1e}, where numbers are {spacing:.1e} apart: {what}");
                Reason::new(finding, format!("choose {key} nearer to 0")).remaining()
            })
        };
        numbers.into_iter().zip(&line.sizes).filter_map(told).collect()
    }

    /// In the continuum the bound on H_BVP holds where K ≥ 0.
    fn bound_warning(&self, line: &WorldLine<S>) -> Option<Reason> {
        let k = line.norm().to_f64();
        (k >= 0.0 && !self.is_kept()).then(|| {
            let [h_bvp, h_bvp_bound] = [self.h_bvp, self.h_bvp_bound].map(S::to_f64);
            let finding = format!(
                "H_BVP = {h_bvp:.3e} exceeds its bound Q_t (t_f - t_i) = {h_bvp_bound:.3e} though K = {k:.2e} >= 0: \
                 the grid is too coarse"
            );
            let remedy = if line.accuracy.is_some() { SMALLER_ACCURACY } else { "raise n_gamma or windows" };
            Reason::new(finding, remedy)
        })
    }
}

/// The warning that fewer digits are certain than were asked for: those that the last correction left unchanged.
fn rounding_warning<S: Real>(line: &WorldLine<S>) -> Option<Reason> {
    let (last_correction, digits) = (line.iterations.last_correction, line.digits);
    let reached = -last_correction.log10();
    let wanted = if S::IS_EXTENDED { f64::from(digits) } else { -SMALL_CORRECTION.log10() };
    (last_correction > 0.0 && reached < wanted).then(|| {
        let finding = format!(
            "the iteration ends at the rounding of the arithmetic: about {} of {digits} digits are certain",
            reached.max(0.0) as u32
        );
        Reason::new(finding, "the physical limit, or more digits, have more")
    })
}
