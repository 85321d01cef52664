//! The command `run` judges a result by the estimates that every run has, and on demand by further means.

use std::time::{Duration, Instant};

use clap::Args;
use geodesic_ivp::Case;
use geodesic_ivp::number::Real;
use geodesic_ivp::number::norm::larger;
use geodesic_ivp::solve::Setup;
use geodesic_ivp::study::proof::{FREE, Hull, ProofOfRun, ProvedEnd, hull, is_proved_unasked, prove_run};
use geodesic_ivp::study::run::{Judged, Run};

use super::lines::{listed, short};
use super::{interrupt, report, study};

/// A proof that takes longer shows how far it is.
const SHOWN: Duration = Duration::from_secs(1);
/// The steps of its bar.
const STEPS: f64 = 1000.0;

const HEADING: &str = "How to judge the result";

#[derive(Debug, Clone, Args)]
pub(super) struct JudgeArgs {
    /// Prove where the motion ends, and how far the run is from it
    ///
    /// A computation of its own encloses the end of the motion, of the decimals of the case, in 15 digits and more. It
    /// is the same as solver.proof=true. What cannot be proved is told with its reason, and changes nothing else. A
    /// run with solver.accuracy does so by itself if that takes some 0.2 seconds or less.
    #[arg(long, help_heading = HEADING)]
    pub(super) prove: bool,

    /// Do not prove where the motion ends, however little that takes
    ///
    /// It is the same as solver.proof=false.
    #[arg(long, conflicts_with = "prove", help_heading = HEADING)]
    pub(super) no_prove: bool,

    /// Do not judge the run: half as much is computed, and its error is not known
    ///
    /// It is the same as solver.error=false. The run is that which would have been judged, if one round was enough.
    #[arg(long, conflicts_with = "reference", help_heading = HEADING)]
    pub(super) no_error: bool,

    /// Look between the nodes, too; --prove says more [goes in the next version]
    ///
    /// The formulas are enclosed on the way from each node to the next, and the result is doubted where they may do
    /// what the nodes do not see. With solver.accuracy every run does so. --prove takes its place.
    #[arg(long, conflicts_with = "vary", help_heading = HEADING)]
    pub(super) enclose: bool,

    /// Compare with the Taylor method
    ///
    /// It takes the place of a second solve by the engine of solver.accuracy.
    #[arg(long, conflicts_with = "vary", help_heading = HEADING)]
    pub(super) reference: bool,
}

/// The override that `--prove` stands for.
pub(super) const PROOF: &str = "solver.proof=true";
/// The override that `--no-prove` stands for.
pub(super) const NO_PROOF: &str = "solver.proof=false";
/// The override that `--no-error` stands for.
pub(super) const NO_ERROR: &str = "solver.error=false";

impl JudgeArgs {
    /// Judges a run, with a proof if its case asks for one or if that takes little. An interrupt ends the proof, and
    /// not the run.
    pub(super) fn judged<S: Real>(&self, case: &Case, setup: &Setup<S>, run: &Run<S>, is_quiet: bool) -> Judged {
        if self.enclose && !is_quiet {
            report::note("--enclose goes in the next version: --prove proves where the run ends");
        }
        let mut judged = run.judged(setup, self.reference, self.enclose);
        if case.proof == Some(true) || is_proved_unasked(case) {
            let most = if case.proof.is_some() { f64::INFINITY } else { FREE };
            let (begun, mut bar) = (Instant::now(), None);
            interrupt::watched(|is_stopped| {
                prove_run(case, run, &mut judged, most, &mut |share| {
                    if begun.elapsed() > SHOWN {
                        let new = || study::bar(is_quiet, STEPS as usize, "proof {bar:30} {eta} left");
                        bar.get_or_insert_with(new).set_position((STEPS * share) as u64);
                    }
                    !is_stopped()
                });
            });
            bar.into_iter().for_each(|bar| bar.finish_and_clear());
        }
        if case.has_hull() {
            interrupt::watched(|is_stopped| judged.hull = Some(hull(case, &mut |_| !is_stopped())));
        }
        judged
    }

    /// Warns of what speaks against a run whose table goes to standard output, and notes what is proved of it.
    pub(super) fn warn<S: Real>(&self, case: &Case, setup: &Setup<S>, run: &Run<S>, is_quiet: bool) {
        if !self.enclose && case.proof != Some(true) && !is_proved_unasked(case) {
            run.warnings().iter().for_each(|warning| report::warn(warning));
            return;
        }
        let judged = self.judged(case, setup, run, is_quiet);
        judged.suspicions.iter().for_each(|warning| report::warn(warning));
        if let Some(proof) = judged.proof.as_ref().filter(|_| case.proof == Some(true)) {
            let head = if proof.reason.is_some() { "there is no proof: " } else { "proof: " };
            report::note(&format!("{head}{}", told(proof, case)).replace('\u{a0}', " "));
        }
    }
}

/// The end that is proved, or why it is not.
pub(super) fn told(proof: &ProofOfRun, case: &Case) -> String {
    if let Some(reason) = &proof.reason {
        return match proof.windows {
            0 => reason.clone(),
            _ => format!("{reason} at gamma = {}", short(proof.reached)),
        };
    }
    let place = match case.t_f::<f64>().filter(|_| proof.ended_by.is_none()) {
        // Six digits of t_f may be another time than the one that is proved, so its name stands for it.
        Some(t_f) if short(t_f).parse() != Ok(t_f) => "t_f".to_owned(),
        t_f => short(t_f.unwrap_or(proof.reached)),
    };
    let told = |end: &&ProvedEnd| !end.is_plain;
    let one = |end: &ProvedEnd| format!("{}({place}) = {} ± {}", end.name, end.end, above(end.radius));
    let ends = listed(proof.ends.iter().filter(told).map(one));
    let off = proof.ends.iter().map(|end| end.run_off_by).fold(0.0, larger);
    let ends = if ends.is_empty() { "nothing varies".to_owned() } else { ends };
    format!("{ends}; this run is off by {}", above(off))
}

/// Where the motions from intervals end, or why that is not known.
pub(super) fn told_hull(hull: &Hull, case: &Case) -> String {
    let ends = match &hull.ends {
        Ok(ends) => ends,
        Err(reason) => return format!("the ends from the intervals are not proved: {reason}"),
    };
    // Where a run ends at a time, this is known.
    let told = |(name, _): &&(String, [f64; 2])| name != "t" || case.t_f::<f64>().is_none();
    let one = |(name, ends): &(String, [f64; 2])| format!("{name} in {}", within(*ends));
    format!("from all of the intervals {}", listed(ends.iter().filter(told).map(one)))
}

/// An end of an interval is written with at most so many digits behind the point.
const MOST_PLACES: usize = 30;

/// An interval in few digits, rounded outwards.
fn within([low, high]: [f64; 2]) -> String {
    let width = (high - low).max(1e-15 * larger(low.abs(), high.abs()));
    let places = if width > 0.0 { (2.0 - width.log10().floor()).clamp(0.0, 300.0) as usize } else { 0 };
    if places > MOST_PLACES {
        // Two digits are off by half of the last one, which is 5 % at most.
        let [low, high] = [low - 0.06 * low.abs(), high + 0.06 * high.abs()];
        return format!("[{low:.1e}, {high:.1e}]");
    }
    let unit = 10.0_f64.powi(places as i32);
    // A hundredth of a unit is more than products are rounded by.
    let [low, high] = [(low * unit - 0.01).floor() / unit, (high * unit + 0.01).ceil() / unit];
    format!("[{low:.places$}, {high:.places$}]")
}

/// A number that is not negative in two digits, rounded up.
fn above(number: f64) -> String {
    if number.is_nan() || number <= 0.0 {
        return format!("{number}");
    }
    let read = |text: &str| text.parse::<f64>().unwrap_or(f64::INFINITY);
    let unit = 10.0_f64.powi(number.log10().floor() as i32 - 1);
    let texts = [0.0, 1.0, 2.0].map(|more| format!("{:.1e}", number + more * 0.5 * unit));
    let above = texts.iter().find(|text| read(text) >= number);
    above.unwrap_or(&texts[2]).clone()
}

#[cfg(test)]
mod tests {
    use super::{above, within};

    #[test]
    fn intervals_are_rounded_outwards() {
        assert_eq!(within([0.123_456, 0.123_999]), "[0.123455, 0.124000]");
        assert_eq!(within([-2.5, 31.0]), "[-2.6, 31.1]");
        assert_eq!(within([-1.04e-200, 1.0e-200]), "[-1.1e-200, 1.1e-200]");
    }

    #[test]
    fn radii_are_rounded_up() {
        for (number, text) in
            [(1.01e-17, "1.1e-17"), (9.95e-5, "1.0e-4"), (2e-9, "2.0e-9"), (0.0, "0"), (9.91, "1.0e1")]
        {
            assert_eq!(above(number), text);
        }
    }
}
