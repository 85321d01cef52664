//! The proof of where the motion of a run ends, and what it makes of the verdict.
//!
//! A proof is about the decimals of the case: the geometry, the start and the end are those of the case in 71 digits,
//! whatever the run was computed in. Of the run it takes nothing but the numbers at its end, to compare with.

mod acting;
mod decimal;
mod events;
mod hull;
mod pieces;
mod starts;

pub use decimal::decimal;
pub use hull::{Hull, OnWay, hull};
pub(crate) use starts::Starts;

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};

use crate::case::{Case, WatchedFormula};
use crate::diagnostics::verdict::{CoordinateError, Grade, ROUNDING, Reason};
use crate::number::norm::larger;
use crate::number::{Extended, Real};
use crate::proof::{Coordinate, Motion, Progress, Proof, Reason as Unproved, Until, prove};
use crate::solve::{Limit, Setup};
use crate::study::errors::{Judge, RunError};
use crate::study::facts::coordinate_errors;
use crate::study::run::{Judged, Run};
use acting::Acting;
use events::Watching;
use pieces::Through;

/// More than a sum of extended numbers is off by, relative to it.
const OF_SUM: f64 = 1e-70;
/// So many doubles hold all digits of a number of any precision.
const PARTS: usize = 6;

/// A run with an accuracy is proved without being asked if it takes no more operations than this, which is some 0.2
/// seconds: nobody waits for them. It is a count and no clock, so that a run says the same on every machine.
pub const FREE: f64 = 4e6;
/// After this share of them it is known whether they will do.
const KNOWN: f64 = 0.125;
/// A bound that is smaller than this is nothing but what underflow may take from zero.
const UNDERFLOW: f64 = 1e-100;
const REPORT: &str = "report this run: one of both is wrong";
const COSTLY: &str = "a proof that takes longer than a run may without --prove";

/// The words for how a proof ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// The end is proved.
    Proved,
    /// Something is in the way.
    Unproved,
    /// It was asked to stop.
    Interrupted,
}

impl Status {
    /// The name used in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Proved => "proved",
            Self::Unproved => "unproved",
            Self::Interrupted => "interrupted",
        }
    }
}

/// A coordinate at the end.
#[derive(Debug, Clone, PartialEq)]
pub struct ProvedEnd {
    /// Its name.
    pub name: String,
    /// A decimal with all digits that are proved, and one or two more.
    pub end: String,
    /// A bound of the distance of the true end from this decimal.
    pub radius: f64,
    /// The distance of the run's number from this decimal.
    pub run_off_by: f64,
    /// True if its end needs no proof: it moves at a constant velocity, or its value is where the motion ends.
    pub is_plain: bool,
}

/// What is proved of a run. Its key in `summary.json` is `proof`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ProofOfRun {
    /// How it ended.
    pub status: Status,
    /// Why it ended before the motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// The event that ends the motion, or `grid.until`, if one does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ended_by: Option<String>,
    /// The coordinates at the end, none if it is not reached.
    #[serde(flatten, serialize_with = "by_name")]
    pub ends: Vec<ProvedEnd>,
    /// For each event of the run by how much its γ and coordinates may be off, as far as that is proved.
    #[serde(skip)]
    pub events: Vec<Option<Vec<f64>>>,
    /// For each sample by how much its coordinates may be off, as far as that is proved.
    #[serde(skip)]
    pub samples: Vec<Option<Vec<f64>>>,
    /// γ until where windows are proved.
    pub reached: f64,
    /// The number of windows.
    pub windows: usize,
    /// The seconds that it took.
    pub seconds: f64,
    /// The largest radius relative to the size of its coordinate, or of its kind.
    #[serde(skip)]
    pub radius: Option<f64>,
}

/// Three objects with a member for each coordinate.
fn by_name<S: Serializer>(ends: &[ProvedEnd], serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct ByName<'p> {
        end: BTreeMap<&'p str, &'p str>,
        radius: BTreeMap<&'p str, f64>,
        run_off_by: BTreeMap<&'p str, f64>,
    }
    let numbers = |of: fn(&ProvedEnd) -> f64| ends.iter().map(|one| (one.name.as_str(), of(one))).collect();
    let by_name = (!ends.is_empty()).then(|| ByName {
        end: ends.iter().map(|one| (one.name.as_str(), one.end.as_str())).collect(),
        radius: numbers(|one| one.radius),
        run_off_by: numbers(|one| one.run_off_by),
    });
    by_name.serialize(serializer)
}

/// All digits of a number.
fn extended<S: Real>(number: S) -> Extended {
    let (mut sum, mut left) = (Extended::ZERO, number);
    for _ in 0..PARTS {
        let part = left.to_f64();
        sum += Extended::from(part);
        left -= S::from(part);
    }
    sum
}

/// The limit of the run for a proof, which counts coordinates from their origins; or why there is none.
fn until(case: &Case, setup: &Setup<Extended>) -> Result<Until, &'static str> {
    if !case.is_determined() {
        return Err("a rate at the start whose two values agree to 16 digits, and no further");
    }
    Ok(match setup.limit {
        Limit::Length(length) => Until::Length(length),
        Limit::Value { coordinate, value } => Until::Value(coordinate, value - setup.origin_of(coordinate)),
    })
}

/// Proves where the run of `case` ends, and takes that into what was judged of it. No more than `most` operations are
/// spent on it. `goes_on` hears after every window which part of the motion is done, and may stop the proof.
pub fn prove_run<S: Real>(
    case: &Case,
    run: &Run<S>,
    judged: &mut Judged,
    most: f64,
    goes_on: &mut dyn FnMut(f64) -> bool,
) {
    let setup: Setup<Extended> = case.setup();
    let length = run.line.signed(run.line.gamma_f() - S::from(setup.gamma_i.to_f64())).to_f64();
    let samples = events::places(&setup, run);
    let found = until(case, &setup).and_then(|until| {
        // What events set is a coordinate of the proof, which stays where it is between them.
        let scene = case.with_unknown_parameters();
        let (acting, arguments) = (Acting::new(&scene, &setup)?, scene.arguments());
        let also = acting.changed();
        let mut attempt = |finds: bool| -> Result<Attempt<'_>, &'static str> {
            let of = (&also[..], arguments.as_ref());
            let Watching { sides, geometry, start, watched, formulas, leaves } =
                Watching::new((case, &scene), &setup, finds, of)?;
            let unused = case.is_lifted().then(|| setup.place.start.q.len() - 1);
            let motion = Motion::new(&geometry, &start, until);
            let motion = Motion { unused, watched: &watched, samples: &samples, leaves, ..motion };
            let mut is_costly = false;
            let goes_on = &mut |progress| {
                is_costly = is_too_costly(progress, length, most);
                !is_costly && goes_on(progress.reached / length)
            };
            let through = || Through::new((&scene, &setup), (&acting, &also, arguments.as_ref()), &formulas);
            let proof = match case.has_acting_events() || arguments.is_some() {
                true => through().prove(&motion, &sides, goes_on),
                false => prove(&motion, goes_on),
            };
            Ok(Attempt { formulas, proof, is_costly })
        };
        let first = attempt(true).or_else(|_| attempt(false))?;
        // An event that is only looked for is no reason to know nothing of the end.
        let is_interrupted = first.proof.end == Err(Unproved::Stopped) && !first.is_costly;
        let is_all = first.formulas.iter().all(|formula| formula.ends);
        Ok(if first.proof.end.is_ok() || is_interrupted || is_all { first } else { attempt(false)? })
    });
    let (of_run, contradiction) = match &found {
        Ok(attempt) => of_run(case, &setup, run, attempt),
        Err(reason) => (ProofOfRun::without((*reason).to_owned(), setup.gamma_i.to_f64()), None),
    };
    judged.proof = Some(of_run);
    judge(run, contradiction, judged);
}

/// A proof, with the formulas that it watches.
struct Attempt<'c> {
    formulas: Vec<WatchedFormula<'c>>,
    proof: Proof,
    /// True if it was ended as it takes too long.
    is_costly: bool,
}

impl ProofOfRun {
    /// None, for a reason.
    fn without(reason: String, gamma_i: f64) -> Self {
        Self {
            status: Status::Unproved,
            reason: Some(reason),
            ended_by: None,
            ends: Vec::new(),
            events: Vec::new(),
            samples: Vec::new(),
            reached: gamma_i,
            windows: 0,
            seconds: 0.0,
            radius: None,
        }
    }
}

/// True if a run with this case is proved without being asked, as far as `FREE` operations go: one by itself that has
/// the whole of its motion, and promises an accuracy of which a proof says whether it is kept.
pub fn is_proved_unasked(case: &Case) -> bool {
    let is_promised = case.settings.accuracy.is_some_and(|accuracy| accuracy.is_promised());
    case.proof.is_none() && is_promised && case.settings.is_judged && case.continues.is_none()
}

/// True if a proof has taken more than it may, or will have at the end if it goes on as it did.
fn is_too_costly(Progress { reached, operations }: Progress, length: f64, most: f64) -> bool {
    operations > most || operations > KNOWN * most && operations * length > 2.0 * most * reached
}

/// What is proved, in the words of the case, and what of the run contradicts it besides its numbers at the end.
fn of_run<S: Real>(
    case: &Case,
    setup: &Setup<Extended>,
    run: &Run<S>,
    Attempt { formulas, proof, is_costly }: &Attempt<'_>,
) -> (ProofOfRun, Option<Reason>) {
    let geometry = &setup.place.geometry;
    let sign = if setup.is_backward { -1.0 } else { 1.0 };
    let position = run.line.end().q;
    let ends_at = |a: usize| matches!(setup.limit, Limit::Value { coordinate, .. } if coordinate == a);
    let of = |found: &Coordinate| {
        let a = found.coordinate;
        let value = found.value + setup.origin_of(a);
        // The sum of both is rounded in the digits of extended numbers.
        let (end, radius) = decimal(value, found.radius + OF_SUM * value.abs().to_f64());
        let read = Extended::from_decimal(&end).unwrap_or(value);
        let run_off_by = (extended(position[a]) - read).abs().to_f64();
        ProvedEnd {
            name: geometry.names()[a].clone(),
            end,
            radius,
            run_off_by,
            is_plain: proof.ended_by.is_none() && (found.is_steady || ends_at(a)),
        }
    };
    let (status, reason) = match &proof.end {
        Ok(_) => (Status::Proved, None),
        Err(Unproved::Stopped) if *is_costly => (Status::Unproved, Some(COSTLY.to_owned())),
        Err(Unproved::Stopped) => (Status::Interrupted, Some(Unproved::Stopped.to_string())),
        Err(reason) => (Status::Unproved, Some(reason.to_string())),
    };
    let name = |event: Option<usize>| event.map_or("grid.until", |event| &case.events[event].name).to_owned();
    let ended_by = proof.ended_by.map(|place| name(formulas[place].event));
    let own = run.line.ended_by.map(|place| case.ending_names()[place].to_owned());
    let events = match status {
        Status::Proved => events::radii(case, setup, run, (formulas, &proof.events)),
        _ => Ok(Vec::new()),
    };
    let other_end = (status == Status::Proved && ended_by != own).then(|| {
        let told = |name: &Option<String>| name.as_ref().map_or("by none".to_owned(), |name| format!("by '{name}'"));
        let [proved, own] = [&ended_by, &own].map(told);
        Reason::new(format!("of the formulas that may end it the motion is ended {proved}, and the run {own}"), REPORT)
    });
    let (events, other_events) = events.map_or_else(|reason| (Vec::new(), Some(reason)), |radii| (radii, None));
    let of_run = ProofOfRun {
        status,
        reason,
        ended_by,
        ends: proof.end.iter().flatten().filter(|found| found.coordinate < position.len()).map(of).collect(),
        events,
        samples: events::of_samples(setup, run, &proof.samples),
        reached: setup.gamma_i.to_f64() + sign * proof.reached,
        windows: proof.windows,
        seconds: proof.seconds,
        radius: None,
    };
    (of_run, other_end.or(other_events))
}

/// Errors at the end, one for each coordinate that has a proof, as the verdict sees them.
fn errors<S: Real>(run: &Run<S>, ends: &[ProvedEnd], of: impl Fn(&ProvedEnd) -> f64) -> Vec<CoordinateError> {
    let names = run.line.geometry().names();
    let error = |name: &String| {
        let error = ends.iter().find(|end| end.name == *name).map_or(0.0, &of);
        if error.abs() < UNDERFLOW { 0.0 } else { error }
    };
    let end: Vec<f64> = names.iter().map(error).collect();
    let own = vec![0.0; end.len()];
    let error = RunError { largest: end.clone(), end, own, end_p: None, judge: Judge::Companion, stepped_over: 0.0 };
    coordinate_errors(&run.line, &run.diagnostics, &error)
}

/// The verdict with the proof: proved where the end is as near to the proved one as was asked for, doubtful where it is
/// further away than the run says.
fn judge<S: Real>(run: &Run<S>, other: Option<Reason>, judged: &mut Judged) {
    let Some(proof) = judged.proof.as_mut().filter(|proof| proof.status == Status::Proved) else { return };
    let line = &run.line;
    let most = errors(run, &proof.ends, |end| end.run_off_by + end.radius);
    let radii = errors(run, &proof.ends, |end| end.radius);
    proof.radius = Some(radii.iter().map(|error| error.share(error.end)).fold(0.0, larger));
    // A number is printed to its last digit.
    let position = line.end().q;
    let printed = |name: &String| {
        let a = line.geometry().names().iter().position(|other| other == name);
        a.map_or(0.0, |a| if S::IS_EXTENDED { 0.0 } else { f64::EPSILON * position[a].to_f64().abs() })
    };
    let least = errors(run, &proof.ends, |end| end.run_off_by - end.radius - printed(&end.name));
    let contradicted = || contradiction(&least, &judged.error.as_ref()?.at_most_at_end());
    if let Some(reason) = other.or_else(contradicted) {
        judged.suspicions.push(reason.to_string());
        judged.verdict.doubt_first(vec![reason]);
        return;
    }
    let is_small = |error: &CoordinateError| match line.accuracy.filter(|accuracy| accuracy.is_promised()) {
        Some(accuracy) => error.share(error.end) <= accuracy.value(),
        None => error.is_small(),
    };
    // The proof is about the motion from the start of this run, and not from that of the run before it.
    if judged.inherited.is_none() && most.iter().all(is_small) {
        let told = |reason: &Reason| reason.to_string();
        let fallen: Vec<String> = judged.verdict.prove(&most, line.digits).iter().map(told).collect();
        judged.suspicions.retain(|told| !fallen.contains(told));
    } else if judged.verdict.grade == Grade::Trusted && !least.iter().all(is_small) {
        let finding = "the proved end is further away than is asked for";
        judged.verdict.doubt(Reason::new(finding, "ask for a smaller accuracy, or take more nodes"));
    }
}

/// The reason for doubt if a coordinate is further from the proved end than the run says it may be.
fn contradiction(least: &[CoordinateError], estimate: &[f64]) -> Option<Reason> {
    let is_within =
        |(error, estimate): &(&CoordinateError, &f64)| error.share(error.end) <= error.share(**estimate) + ROUNDING;
    let (error, estimate) = least.iter().zip(estimate).find(|pair| !is_within(pair))?;
    let finding = format!(
        "the proved end is {:.1e} away in {}, more than the estimate of the run, {estimate:.1e}",
        error.end, error.name
    );
    Some(Reason::new(finding, REPORT))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_keep_what_is_proved_and_radii_hold_what_they_drop() {
        let third = Extended::ONE / Extended::from(3.0);
        for radius in [1e-3, 2.5e-17, 9.9e-30, 1e-60] {
            let (text, more) = decimal(third, radius);
            let off = (Extended::from_decimal(&text).unwrap() - third).abs().to_f64();
            assert!(radius + off <= more && more <= 1.11 * radius.max(1e-40), "{text} {more}");
        }
        assert_eq!(decimal(third, 3e-5).0, "0.333333");
        assert_eq!(decimal(Extended::ZERO, 3e-5).0, Extended::ZERO.to_decimal(1));
        assert_eq!(decimal(third, 1.0).0, "0.3");
    }

    #[test]
    fn all_digits_of_a_number_are_compared() {
        let third = Extended::ONE / Extended::from(3.0);
        assert_eq!(extended(third), third);
        assert_eq!(extended(1.0_f64 / 3.0), Extended::from(1.0 / 3.0));
    }
}
