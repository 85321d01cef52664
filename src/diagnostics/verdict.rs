//! One verdict on a run, from what was measured on it and how far it is from a second solve.
//!
//! A run is *trusted* if there is an estimate of its error, if that is at most a hundredth of the motion of every
//! coordinate, and if nothing else speaks against it. Otherwise it is *doubtful*, and every reason has a remedy. It is
//! *proved* if a proof of where the motion ends has shown that the error there is as small as was asked for. The
//! program *refuses* where it has no result at all.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::engine::{Accuracy, GOOD_DIGITS};
use crate::number::norm::larger;

/// An error is large above this share of the range of its coordinate.
const LARGE_ERROR: f64 = 1e-2;
/// An error below this share of the size of its coordinate is never large: what hardly moves has hardly a range.
const NEGLIGIBLE_ERROR: f64 = 1e-9;
/// The rounding error, relative to the size of a coordinate, that an estimate may lack before a reference, or a proof,
/// contradicts it.
pub(crate) const ROUNDING: f64 = 1e-12;
/// A share of the way below which nothing was stepped over, and the share of an estimate that contradicts it.
const SEEN: f64 = 1e-8;
const CONTRADICTED: f64 = 0.1;
/// The remedies where the user chose the grid, and where the program chose it.
pub(super) const FINER_GRID: &str = "raise n_gamma or windows, or ask for solver.accuracy";
pub(super) const SMALLER_ACCURACY: &str = "ask for a smaller solver.accuracy";

/// The verdict on a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Grade {
    /// It is proved that the error of the end is small.
    Proved,
    /// The error is known and small, and nothing speaks against it.
    Trusted,
    /// There is a reason not to believe the result.
    Doubtful,
    /// There is no result.
    Refused,
}

impl Grade {
    /// The name used in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Proved => "proved",
            Self::Trusted => "trusted",
            Self::Doubtful => "doubtful",
            Self::Refused => "refused",
        }
    }
}

/// A reason not to believe a result, and what to do about it. Displayed, it is one sentence.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Reason {
    /// The finding, with its number and its threshold.
    pub reason: String,
    /// The remedy.
    pub remedy: String,
    /// The words between both in a sentence.
    #[serde(skip)]
    pub(super) link: &'static str,
    /// True if it is only a sign that a grid is too coarse, which a known small error outweighs.
    #[serde(skip)]
    pub(super) is_sign: bool,
    /// True if it is not about the error of the motion that was computed, so that no proof of its end answers it.
    #[serde(skip)]
    pub(super) remains: bool,
}

impl Reason {
    /// A reason with its remedy.
    pub fn new(reason: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { reason: reason.into(), remedy: remedy.into(), link: "; ", is_sign: false, remains: false }
    }

    /// The same reason, which a proof of the end does not answer.
    pub(crate) fn remaining(self) -> Self {
        Self { remains: true, ..self }
    }

    /// A sign that a grid is too coarse.
    pub(super) fn sign(reason: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { is_sign: true, ..Self::new(reason, remedy) }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}{}", self.reason, self.link, self.remedy)
    }
}

/// The estimated error of a coordinate, and how large its motion is, in its unit.
#[derive(Debug, Clone, PartialEq)]
pub struct CoordinateError {
    /// Its name.
    pub name: String,
    /// The error at the end of the run.
    pub end: f64,
    /// The largest error over the nodes.
    pub largest: f64,
    /// Its largest absolute value; that of the distance from the start for t and other ignorable coordinates.
    pub size: f64,
    /// Its largest value minus its least.
    pub range: f64,
    /// The largest size of coordinates that share its unit.
    pub shared: f64,
    /// The largest range of these.
    pub shared_range: f64,
}

impl CoordinateError {
    /// An error relative to the size of the kind of the coordinate, as a `solver.accuracy` is: z of an orbit in the
    /// plane z = 0 has the size of the orbit. Where all of a kind stay 0, every error is a whole one.
    pub(crate) fn share(&self, error: f64) -> f64 {
        let size = self.shared;
        if size != 0.0 || error.is_nan() { error / size } else { f64::from(u8::from(error > 0.0)) }
    }

    /// The largest error that is not a reason to doubt the result.
    pub fn allowed(&self) -> f64 {
        larger(LARGE_ERROR * self.shared_range, NEGLIGIBLE_ERROR * self.shared)
    }

    /// Returns true if the error is no reason to doubt the result. What is not finite is no small error, and nothing is
    /// small beside it.
    pub fn is_small(&self) -> bool {
        self.largest <= self.allowed() && self.allowed().is_finite()
    }

    fn reason(&self, remedy: &str) -> Option<Reason> {
        let (Self { name, largest, .. }, allowed) = (self, self.allowed());
        let finding = || {
            format!("the error of {name} is up to about {largest:.1e}, above {allowed:.1e}, {LARGE_ERROR} of its range")
        };
        (!self.is_small()).then(|| Reason::new(finding(), remedy))
    }
}

/// The facts that a verdict is made of.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VerdictInput {
    /// The errors of all coordinates; `None` if there was nothing to compare with.
    pub errors: Option<Vec<CoordinateError>>,
    /// The accuracy that windows were chosen for, if they were.
    pub accuracy: Option<Accuracy>,
    /// γ until which the estimate is below each of [`GOOD_DIGITS`], if they were.
    pub good_until: [f64; GOOD_DIGITS.len()],
    /// With an accuracy: the relative error that a reference finds besides, and what the reference may be off by.
    pub reference: Option<[f64; 2]>,
    /// The share of its way by which the motion may be off because the judge of its error stepped over a feature.
    pub stepped_over: f64,
    /// Significant digits of the arithmetic; 0 is 16.
    pub digits: u32,
    /// Other suspicions, the most important first.
    pub suspicions: Vec<Reason>,
    /// True if the run was compared with nothing, because nobody wanted it.
    pub is_unjudged: bool,
}

impl VerdictInput {
    /// The reasons that speak of errors, of which `largest` is the largest one relative to the size of its coordinate.
    fn reasons(&self, errors: &[CoordinateError], largest: f64) -> Vec<Reason> {
        let remedy = if self.accuracy.is_some() { SMALLER_ACCURACY } else { FINER_GRID };
        let mut reasons: Vec<Reason> = errors.iter().filter_map(|error| error.reason(remedy)).collect();
        if self.accuracy.is_some_and(|accuracy| !accuracy.is_promised()) && !reasons.is_empty() {
            let [three, six, nine] = self.good_until.map(|gamma| format!("{gamma:.4}"));
            let until = format!("3 digits until gamma = {three}, to 6 until {six}, to 9 until {nine}");
            let finding = format!("errors have grown: positions are good to {until}");
            let remedy = "end the run there, or take what follows for one of many motions that begin alike";
            reasons = vec![Reason::new(finding, remedy)];
        }
        // Comparisons that are false for NaN.
        let is_contradicted = |&[found, own]: &[f64; 2]| {
            let is_within = found <= largest + own + ROUNDING;
            !is_within
        };
        reasons.extend(self.reference.filter(is_contradicted).map(|[found, _]| {
            let finding =
                format!("a reference finds an error of {found:.1e}, above the estimate of the run, {largest:.1e}");
            Reason::new(finding, SMALLER_ACCURACY)
        }));
        let share = self.stepped_over;
        let is_within = |error: &CoordinateError| share * error.range <= CONTRADICTED * error.largest;
        let is_known = share <= SEEN || errors.iter().all(is_within);
        if !is_known {
            let finding = format!(
                "the solve that the error is estimated with may be off by {share:.1e} of the way: between its nodes K \
                 is not what it was, so V or the metric has a feature that is narrower than its steps"
            );
            reasons.push(Reason::new(finding, "end a run before the feature and continue it from there"));
        }
        reasons
    }
}

/// The verdict on a run. Its keys in `summary.json` are `verdict`, `verdict_error`, `good_digits`, `verdict_reasons`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict {
    /// The verdict on the run.
    #[serde(rename = "verdict")]
    pub grade: Grade,
    /// The largest estimated error of a coordinate over the nodes, relative to the size of the coordinate.
    #[serde(rename = "verdict_error", skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// The digits of the position at the end that mean something: of the coordinate that has the fewest, relative to
    /// its size.
    #[serde(rename = "good_digits", skip_serializing_if = "Option::is_none")]
    pub digits: Option<u32>,
    /// Why the run is doubtful.
    #[serde(rename = "verdict_reasons", skip_serializing_if = "Vec::is_empty")]
    pub reasons: Vec<Reason>,
}

impl Verdict {
    /// The verdict where there is no result: the message of the failure says why.
    pub fn refused() -> Self {
        Self { grade: Grade::Refused, error: None, digits: None, reasons: Vec::new() }
    }

    /// The verdict on a result.
    pub fn new(facts: &VerdictInput) -> Self {
        let digits = if facts.digits == 0 { 16 } else { facts.digits };
        let errors = facts.errors.as_deref();
        let error = errors.map(|errors| errors.iter().map(|error| error.share(error.largest)).fold(0.0, larger));
        let mut reasons = match errors.zip(error) {
            Some((errors, largest)) => facts.reasons(errors, largest),
            None if facts.is_unjudged => vec![Reason::new(
                "it was not judged: nothing was compared with it",
                "leave --no-error and solver.error out",
            )],
            None => vec![Reason::new(
                "the error is not known, because no second solve reaches the end in the same way",
                "ask for solver.accuracy, or end the run earlier",
            )],
        };
        // Where a second solve finds small errors, signs of a coarse grid say nothing more (bench `verdict`).
        let is_outweighed = facts.accuracy.is_none() && reasons.is_empty();
        reasons.extend(facts.suspicions.iter().filter(|sign| !(sign.is_sign && is_outweighed)).cloned());
        Self {
            grade: if reasons.is_empty() { Grade::Trusted } else { Grade::Doubtful },
            error: error.map(|error| larger(error, 10.0_f64.powi(-(digits as i32)))),
            digits: errors.map(|errors| good_digits(errors, digits)),
            reasons,
        }
    }

    /// Adds reasons before all others.
    pub(crate) fn doubt_first(&mut self, reasons: Vec<Reason>) {
        if !reasons.is_empty() {
            self.grade = Grade::Doubtful;
            self.reasons.splice(0..0, reasons);
        }
    }

    /// Takes in that the errors at the end are proved to be at most these, and small enough: reasons that are about the
    /// error fall. Returns the reasons that have fallen.
    pub(crate) fn prove(&mut self, errors: &[CoordinateError], digits: u32) -> Vec<Reason> {
        let (left, fallen) = std::mem::take(&mut self.reasons).into_iter().partition(|reason| reason.remains);
        self.reasons = left;
        self.grade = if self.reasons.is_empty() { Grade::Proved } else { Grade::Doubtful };
        self.digits = Some(good_digits(errors, digits));
        fallen
    }

    /// Adds a reason to doubt the result.
    pub fn doubt(&mut self, reason: Reason) {
        self.grade = Grade::Doubtful;
        self.reasons.push(reason);
    }
}

/// The digits of the coordinates at the end that their errors leave, at most `digits`.
fn good_digits(errors: &[CoordinateError], digits: u32) -> u32 {
    let digits_left = (-errors.iter().map(|error| error.share(error.end)).fold(0.0, larger).log10()).floor();
    // The minimum of NaN and a number is the number, and NaN leaves no digit; nor does a negative number.
    if digits_left.is_nan() { 0 } else { digits_left.min(f64::from(digits)) as u32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(end: f64, size: f64) -> CoordinateError {
        CoordinateError { name: "x".to_owned(), end, largest: end, size, range: size, shared: size, shared_range: size }
    }

    fn is_trusted(error: CoordinateError, further: VerdictInput) -> bool {
        Verdict::new(&VerdictInput { errors: Some(vec![error]), ..further }).grade == Grade::Trusted
    }

    #[test]
    fn a_number_of_size_zero_is_as_good_as_its_error() {
        let beside = CoordinateError { shared: 2.0, ..error(2e-4, 0.0) };
        for (one, other, digits) in [
            (error(1e-4, 2.0), error(3e-7, 0.5), 4),
            // A run that ends at a given time, and one that stays where it is.
            (error(0.0, 2.0), error(3e-7, 0.5), 6),
            (error(0.0, 2.0), error(0.0, 0.0), 16),
            // x is 0 at every node, and the true motion leaves it.
            (error(0.0, 2.0), error(2e-4, 0.0), 0),
            (error(0.0, 2.0), beside, 4),
            (error(1e-9, 2.0), error(0.5, 0.0), 0),
            (error(f64::NAN, 2.0), error(0.1, 1.0), 0),
        ] {
            assert_eq!(good_digits(&[one.clone(), other.clone()], 16), digits, "{one:?} {other:?}");
        }
    }

    #[test]
    fn an_error_counts_relative_to_the_motion_and_not_to_the_place() {
        let beside = |largest: f64| CoordinateError { shared: 1e3, shared_range: 0.0, ..error(largest, 1e-16) };
        for (error, is_small) in [
            (error(1e-3, 1.0), true),
            (error(2e-2, 1.0), false),
            (error(f64::NAN, 1.0), false),
            // A small oscillation around a distant place.
            (CoordinateError { shared_range: 1e-2, ..error(1e-3, 1e3) }, false),
            // A coordinate that rests but for rounding, and one whose kind is large.
            (CoordinateError { shared: 1.0, ..error(1e-15, 1e-16) }, true),
            // z of an orbit in the plane z = 0, whose error is of the size of the accuracy.
            (CoordinateError { shared: 1.0, shared_range: 2.0, ..error(1e-6, 0.0) }, true),
            (CoordinateError { shared: 1.0, shared_range: 2.0, ..error(0.1, 0.0) }, false),
            (CoordinateError { shared_range: f64::INFINITY, ..error(1e-6, 1.0) }, false),
            (CoordinateError { shared_range: f64::NAN, ..error(1e-6, 1.0) }, false),
            (beside(5e-7), true),
            (beside(5e-6), false),
        ] {
            assert_eq!(is_trusted(error.clone(), VerdictInput::default()), is_small, "{error:?}");
        }
    }

    #[test]
    fn what_is_not_known_and_what_is_contradicted_is_doubtful() {
        let unknown = Verdict::new(&VerdictInput::default());
        assert_eq!((unknown.grade, unknown.error, unknown.digits), (Grade::Doubtful, None, None));
        for (estimate, found, own, trusted) in [
            (1e-9, 0.9e-9, 1e-15, true),
            // The reference is no better than the run, or finds rounding where the estimate is zero.
            (1e-9, 1e-7, 1e-6, true),
            (1e-9, 1e-7, 1e-15, false),
            (0.0, 0.5 * ROUNDING, 0.0, true),
            (0.0, 1e3 * ROUNDING, 0.0, false),
        ] {
            let accuracy = Some(Accuracy::Promised(1e-8));
            let facts = VerdictInput { accuracy, reference: Some([found, own]), ..VerdictInput::default() };
            assert_eq!(is_trusted(error(estimate, 1.0), facts), trusted, "{estimate} {found} {own}");
        }
        for (stepped_over, range, largest, trusted) in [
            (0.0, 1.0, 1e-9, true),
            // Half of the way may be wrong, and of the error nothing is said.
            (0.5, 1.0, 1e-9, false),
            (f64::NAN, 1.0, 1e-9, false),
            // An error ten times as large hides it, also that of a short way; a coordinate that rests has no way.
            (5e-4, 1.0, 5.1e-3, true),
            (5e-4, 1.0, 1e-6, false),
            (5e-4, 1e-2, 5.1e-5, true),
            (0.5, 0.0, 1e-9, true),
            // What the steps of a march leave between them is always more than rounding.
            (1e-9, 1.0, 1e-15, true),
        ] {
            let error = CoordinateError { range, ..error(largest, 1.0) };
            let found = is_trusted(error, VerdictInput { stepped_over, ..VerdictInput::default() });
            assert_eq!(found, trusted, "{stepped_over} {range} {largest}");
        }
    }
}
