//! One draw: a scene in a scheme is run and judged as a user's run is, and its verdict is compared with what is true.

use std::fmt;

use geodesic_ivp::case::Case;
use geodesic_ivp::diagnostics::verdict::{Grade, Verdict};
use geodesic_ivp::study::errors::RunError;
use geodesic_ivp::study::run::{NoRun, Wanted, run};

use super::random::Random;
use super::scene::Scene;
use super::truth::Truth;

/// A result without a promise may be off by so many times the error that it claims.
const MOST: f64 = 10.0;
/// A doubt about a result that is off by more than this share of its range is right, whatever it claims: it is what
/// docs/trust.md says of results without a promise.
const LARGE: f64 = 1e-2;
/// Nothing decides below this error, relative to the size of a coordinate: both references and the run are rounded.
const ROUNDING: f64 = 1e-12;
/// The two references may differ by this share of what decides.
const SHARE: f64 = 1.0 / 3.0;
/// An error that is so many times the doubt about it is one, though the doubt is larger than what decides.
const GROSS: f64 = 10.0;

/// A draw prints this when what follows is up to the references.
pub(crate) const JUDGED: &str = "judged";

/// An outcome says what a verdict was worth, or that there was none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Outcome {
    /// Trusted, and right.
    Right,
    /// Trusted, and wrong.
    Wrong,
    /// Doubtful, though its error is as small as was asked for, or as it claims.
    Careful,
    /// Doubtful, and rightly so.
    Warned,
    /// There is no result.
    Refused,
    /// The references do not know.
    Undecided,
}

/// The outcomes with their names.
pub(crate) const OUTCOMES: [(Outcome, &str); 6] = [
    (Outcome::Right, "right"),
    (Outcome::Wrong, "wrong"),
    (Outcome::Careful, "careful"),
    (Outcome::Warned, "warned"),
    (Outcome::Refused, "refused"),
    (Outcome::Undecided, "undecided"),
];

/// A judged draw.
pub(crate) struct Judged {
    pub(crate) outcome: Outcome,
    /// accuracy, tolerance or grid.
    pub(crate) scheme: &'static str,
    /// The first reason for a doubt or for a refusal.
    pub(crate) reason: String,
    /// True if a trusted error is too large for the own size of its coordinate, though not for that of its kind.
    pub(crate) is_coarse: bool,
    /// The case that was run, and the errors of its coordinates.
    pub(crate) what: String,
}

/// A scheme: its name, the settings that choose it, and the accuracy if it promises one.
struct Scheme {
    name: &'static str,
    settings: Vec<String>,
    accuracy: Option<f64>,
}

impl Scheme {
    fn drawn(random: &mut Random, length: f64) -> Self {
        match random.next() % 5 {
            0 => {
                let settings = vec![format!("solver.tolerance={:e}", random.scale(1e-13, 1e-6))];
                Self { name: "tolerance", settings, accuracy: None }
            }
            1 => {
                let windows = (length * random.scale(0.5, 5.0)).ceil();
                let settings = ["grid.n_gamma=16", "scheme.sbp=GLL16", "scheme.form=weak"].map(str::to_owned);
                let settings = [settings.to_vec(), vec![format!("grid.windows={windows}")]].concat();
                Self { name: "grid", settings, accuracy: None }
            }
            _ => {
                let accuracy = random.scale(1e-11, 1e-4);
                Self {
                    name: "accuracy",
                    settings: vec![format!("solver.accuracy={accuracy:e}")],
                    accuracy: Some(accuracy),
                }
            }
        }
    }
}

/// The error of a coordinate at the end, and what it is measured by.
struct Off {
    name: String,
    error: f64,
    doubt: f64,
    /// The error that decides whether trust is right, and the same by the own size of the coordinate alone.
    most: f64,
    most_by_own: f64,
    /// The error up to which a doubt is not right.
    good: f64,
}

impl Off {
    fn is_known(&self) -> bool {
        self.doubt <= SHARE * self.most
    }

    /// NaN is wrong, too.
    fn is_wrong(&self) -> bool {
        let is_within = self.error <= self.most + if self.is_known() { 0.0 } else { GROSS * self.doubt };
        !is_within
    }
}

impl fmt::Display for Off {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, error, doubt, most, .. } = self;
        write!(f, "{name} is off by {error:.1e} of at most {most:.1e}, known to {doubt:.1e}")
    }
}

impl Judged {
    /// Draws a scene of one of the templates and a scheme, runs and judges it.
    pub(crate) fn drawn(templates: &[&str], random: &mut Random) -> Self {
        let template = templates[random.next() as usize % templates.len()];
        let scene = Scene::drawn(template, random);
        let scheme = Scheme::drawn(random, scene.length);
        let settings = [scene.settings.as_slice(), &scheme.settings].concat();
        let what = format!("{}\nwith {}", scene.text, settings.join(" "));
        // Where a draw takes too long, this is all that is seen of it.
        eprintln!("{what}");
        let refused = |reason: String| Self {
            outcome: Outcome::Refused,
            scheme: scheme.name,
            reason,
            is_coarse: false,
            what: what.clone(),
        };
        let case = match Case::parse("draw", &scene.text, &settings) {
            Ok(case) => case,
            Err(error) => return refused(format!("the case: {error}")),
        };
        let setup = case.setup::<f64>();
        let run = match run(&case, &setup, Wanted { sums: true, ..Wanted::default() }).0 {
            Ok(run) => run,
            Err(NoRun::Unsolved(failure, _)) => {
                println!("{JUDGED}");
                // Where the references have no end either, there is none.
                let outcome = if Truth::of(&scene).is_none() { Outcome::Undecided } else { Outcome::Refused };
                return Self { outcome, ..refused(failure.status.to_string()) };
            }
            Err(NoRun::Unsampled(_)) => unreachable!("no samples are asked for"),
        };
        let judged = run.judged(&setup, false, false);
        println!("{JUDGED}");
        let end = run.line.end().q;
        let starts: Vec<f64> = setup.place.start.q.clone();
        let names = run.line.geometry().names();
        let Some(truth) = Truth::of(&scene) else {
            let outcome = Outcome::Undecided;
            return Self { outcome, ..refused("no reference".to_owned()) };
        };
        let offs = offs(&scene, &truth, (names, &starts, &end), (&scheme, judged.error.as_ref()));
        let (outcome, is_coarse) = outcome(&scene, &judged.verdict, &offs);
        let errors: Vec<String> = offs.iter().filter(|off| off.error > off.good).map(Off::to_string).collect();
        let reason = judged.verdict.reasons.first().map_or(String::new(), |reason| reason.reason.clone());
        let what = format!("{what}\n{}", errors.join("\n"));
        Self { outcome, scheme: scheme.name, reason, is_coarse, what }
    }
}

/// The errors of the coordinates that are results.
fn offs(
    scene: &Scene,
    truth: &Truth,
    (names, starts, end): (&[String], &[f64], &[f64]),
    (scheme, claim): (&Scheme, Option<&RunError>),
) -> Vec<Off> {
    let claims = claim.map(RunError::at_most);
    let is_result = |a: &usize| !(scene.is_newtonian && (names[*a] == "t" || names[*a] == "s"));
    let of = |a: usize| {
        let is_time = names[a] == "t";
        let found = if is_time { (end[a] - starts[a]).abs() } else { end[a] };
        let exact = if is_time { truth.end[a].abs() } else { truth.end[a] };
        // Times are printed whole.
        let rounding = if is_time { 2.0 * f64::EPSILON * starts[a].abs().max(end[a].abs()) } else { 0.0 };
        let (own, shared) = (truth.own[a], truth.shared[a]);
        let claimed = claims.as_ref().map_or(0.0, |claims| claims[a]);
        let [most, most_by_own, good] = match scheme.accuracy {
            Some(accuracy) => [accuracy * shared, accuracy * own, accuracy * shared],
            None => [MOST * claimed, MOST * claimed, claimed.min(LARGE * shared)],
        };
        let at_least = |most: f64| most.max(ROUNDING * shared) + rounding;
        Off {
            name: names[a].clone(),
            error: (found - exact).abs(),
            doubt: truth.doubt[a],
            most: at_least(most),
            most_by_own: most_by_own.max(ROUNDING * own) + rounding,
            good: at_least(good),
        }
    };
    (0..names.len()).filter(is_result).map(of).collect()
}

/// Returns the outcome of a draw, and true if an error is too large by the own size of a coordinate.
fn outcome(scene: &Scene, verdict: &Verdict, offs: &[Off]) -> (Outcome, bool) {
    let is_trusted = verdict.grade == Grade::Trusted;
    let is_wrong = offs.iter().any(Off::is_wrong);
    if scene.is_untrue {
        return (if is_trusted { Outcome::Wrong } else { Outcome::Warned }, false);
    }
    if !is_wrong && !offs.iter().all(Off::is_known) {
        return (Outcome::Undecided, false);
    }
    let is_coarse = is_trusted && !is_wrong && offs.iter().any(|off| off.error > off.most_by_own);
    let is_good = offs.iter().all(|off| off.error <= off.good);
    let outcome = match (is_trusted, is_wrong) {
        (true, true) => Outcome::Wrong,
        (true, false) => Outcome::Right,
        (false, _) if is_good => Outcome::Careful,
        (false, _) => Outcome::Warned,
    };
    (outcome, is_coarse)
}
