//! A run in a few lines: first how good it is, then where it ends, what is exact, and what was written.

use std::path::Path;

use geodesic_ivp::Case;
use geodesic_ivp::action::Form;
use geodesic_ivp::diagnostics::verdict::Reason;
use geodesic_ivp::diagnostics::{ChargeDeviation, Diagnostics, NEGLIGIBLE};
use geodesic_ivp::number::Real;
use geodesic_ivp::number::norm::larger;
use geodesic_ivp::solve::{InitialGuess, Iterations, WorldLine};
use geodesic_ivp::study::errors::{Judge, RunError};
use geodesic_ivp::study::proof::{ProofOfRun, Status};
use geodesic_ivp::study::run::{Judged, Run};

use super::judge;
use super::lines::{is_readable, listed, row, short, unbroken, wrapped};

/// A number with more digits that are right needs no error beside it.
const SURE_DIGITS: i32 = 7;
/// A motion is not Newton's above this relative difference of accelerations.
const NOT_NEWTONIAN: f64 = 1e-2;

/// A run with what is said of it.
pub(super) struct Told<'r, S: Real> {
    pub(super) title: &'r str,
    pub(super) case: &'r Case,
    pub(super) run: &'r Run<S>,
    pub(super) judged: &'r Judged,
    pub(super) solve_seconds: f64,
}

impl<S: Real> Told<'_, S> {
    /// The lines, the last of which names the files in `folder`.
    pub(super) fn lines(&self, folder: &Path) -> String {
        let is_newtonian = self.run.diagnostics.energy.is_some();
        let solved = scheme(&self.run.line, is_newtonian, self.solve_seconds);
        let written = format!("{} ({solved})", folder.display());
        let rows = [
            ("end", Some(self.end())),
            ("error", Some(self.error())),
            ("exact", self.exact()),
            ("drift", Some(self.drift())),
            ("motion", self.motion()),
            ("growth", self.growth()),
            ("events", self.events()),
            ("between", self.between()),
            (if self.is_unproved() { "no proof" } else { "proved" }, self.proved()),
            ("hull", self.judged.hull.as_ref().map(|hull| judge::told_hull(hull, self.case))),
            ("written", Some(written)),
        ];
        self.verdict() + &rows.into_iter().filter_map(|(name, text)| Some(row(name, &text?))).collect::<String>()
    }

    /// The title with the verdict, and the first reason to doubt it; `--verbose` has the others.
    fn verdict(&self) -> String {
        let verdict = &self.judged.verdict;
        let good = match verdict.digits {
            None => String::new(),
            Some(0) => ", no digit is good".to_owned(),
            Some(1) => ", good to one digit".to_owned(),
            Some(digits) => format!(", good to {digits} digits"),
        };
        let grade = verdict.grade.as_str();
        let count = match verdict.reasons.len() {
            count @ 2.. => format!(" for {count} reasons"),
            _ => String::new(),
        };
        let head = wrapped(&format!("{}: {grade}{count}{good}", self.title), 2);
        head + &verdict.reasons.first().map_or(String::new(), doubt)
    }

    /// The indices of the coordinates that the case is about: not s of Newton's law, which was added.
    fn coordinates(&self) -> std::ops::Range<usize> {
        0..self.run.line.geometry().dimension() - usize::from(self.case.is_lifted())
    }

    /// The coordinates at the end, with the digits that are right.
    fn end(&self) -> String {
        let line = &self.run.line;
        let (position, errors) = (line.end().q, self.judged.error.as_ref().map(RunError::at_most_at_end));
        let names = line.geometry().names();
        let one =
            |a: usize| format!("{} = {}", names[a], number(position[a], errors.as_ref().map(|e| e[a]), line.digits));
        listed(self.coordinates().map(one))
    }

    /// The largest error on the way, and how it is known.
    fn error(&self) -> String {
        let Some(error) = &self.judged.error else {
            let is_judged = self.case.settings.is_judged;
            return if is_judged { "unknown: no second solve reaches the end in the same way" } else { "not judged" }
                .to_owned();
        };
        let most = error.at_most();
        let judge = error.judge.describe();
        let inherited = self.inherited();
        if self.case.is_of_x && error.judge != Judge::Companion {
            return format!("at most {:.1e} in t and {:.1e} in x anywhere ({judge}{inherited})", most[0], most[1]);
        }
        let share = self.judged.verdict.error.map_or("unknown".to_owned(), |error| format!("at most {error:.0e}"));
        format!("{share}, relative to the size of each coordinate ({judge}{inherited})")
    }

    /// The part of the error that comes from the run that this one continues, in the coordinate where it is largest.
    fn inherited(&self) -> String {
        let Some(inherited) = &self.judged.inherited else { return String::new() };
        let names = self.run.line.geometry().names();
        let most = self.coordinates().max_by(|&a, &b| inherited[a].total_cmp(&inherited[b]));
        most.map_or_else(String::new, |a| {
            format!("; of it {:.1e} in {}, which is absolute, inherited", inherited[a], names[a])
        })
    }

    /// The charges and the conserved sums, and how exact they are.
    fn exact(&self) -> Option<String> {
        let Run { line, diagnostics, sums, .. } = self.run;
        let names = line.geometry().names();
        let last = names.len() - 1;
        let mut told: Vec<String> = Vec::new();
        let mut at_last = 0.0_f64;
        for charge in &diagnostics.charges {
            let a = charge.terms[0].0;
            if diagnostics.energy.is_some() && a == last {
                continue;
            }
            if charge.max_last != S::ZERO {
                at_last = larger(at_last, charge.max_last.to_f64() / charge.heard.terms());
            }
            match (diagnostics.energy.as_ref(), a) {
                (Some(energy), 0) => told.push(format!("energy = {}", short(energy.value.to_f64()))),
                _ if self.case.is_of_x => told.push(format!("Q_t = {}", short(charge.value.to_f64()))),
                _ => told.push(format!("p_{} = {}", names[a], short(charge.value.to_f64()))),
            }
        }
        for (sum, charge) in sums.iter().zip(&diagnostics.sums) {
            told.push(format!("{} = {}", shortened(&sum.formula(names)), short(charge.value.to_f64())));
        }
        let most = diagnostics.exactness();
        let at_last = match line.form {
            Form::Strong if at_last > most => format!(" ({at_last:.1e} at the last node of the strong form)"),
            _ => String::new(),
        };
        let pieces = match self.run.acting_events {
            0 => String::new(),
            1 => ", before an event and after it".to_owned(),
            count => format!(", in pieces between {count} events"),
        };
        (!told.is_empty()).then(|| format!("{}, to {most:.1e} of the terms{at_last}{pieces}", listed(told.into_iter())))
    }

    /// The quantities that are not built in and so measure the error: K or the energy, invariants, and the work of
    /// forces.
    fn drift(&self) -> String {
        let Run { line, diagnostics, .. } = self.run;
        let mut told = vec![drift_of_motion(diagnostics)];
        for (name, invariant) in &diagnostics.invariants {
            told.push(format!("{name} by {:.1e}", invariant.drift()));
        }
        for work in &diagnostics.work {
            let name = &line.geometry().names()[work.coordinate];
            told.push(format!("p_{name} is the work of the force to {:.1e}", work.defect.to_f64().abs()));
        }
        listed(told.into_iter())
    }

    /// The deviation of the motion from Newton's, if there is one. Other doubts come first.
    fn motion(&self) -> Option<String> {
        let of_x = self.run.diagnostics.of_x.as_ref()?;
        let deviation = of_x.deviation;
        let remedy = match of_x.c() {
            Some(c) => format!("; particle.c = {c} would make that {NEGLIGIBLE:e}"),
            None => String::new(),
        };
        let is_told = deviation > NOT_NEWTONIAN && self.judged.verdict.reasons.is_empty();
        is_told.then(|| format!("relativistic: up to {} off Newton's{remedy}", percent(deviation)))
    }

    /// The growth of small changes, if they were carried along.
    fn growth(&self) -> Option<String> {
        let growth = self.run.line.sensitivity.as_ref()?.growth();
        let [lyapunov, megno] = [growth.lyapunov, growth.megno].map(short);
        Some(format!("largest Lyapunov exponent {lyapunov}, MEGNO {megno} (2: regular)"))
    }

    /// The number of times that each event was met.
    fn events(&self) -> Option<String> {
        let names = self.case.event_names();
        let count = |watch: usize| self.run.events.iter().filter(|crossing| crossing.watch == watch).count();
        let told = names.iter().enumerate().map(|(watch, name)| format!("{name} {}", count(watch)));
        (!names.is_empty()).then(|| listed(told))
    }

    /// The end that is proved, or why it is not, if a proof was asked for.
    fn proved(&self) -> Option<String> {
        let is_told = |proof: &&ProofOfRun| self.case.proof.is_some() || proof.status == Status::Proved;
        self.judged.proof.as_ref().filter(is_told).map(|proof| judge::told(proof, self.case))
    }

    fn is_unproved(&self) -> bool {
        self.judged.proof.as_ref().is_some_and(|proof| proof.reason.is_some())
    }

    /// The findings between the nodes, if the run looked there.
    fn between(&self) -> Option<String> {
        let gaps = self.judged.gaps.as_ref()?;
        let (count, unresolved) = (gaps.count, gaps.unresolved);
        let found = match unresolved {
            0 => format!("nothing hides in the {count} gaps between nodes"),
            _ => format!("{unresolved} of {count} gaps between nodes are not explained"),
        };
        Some(format!("{found}, beside an accuracy of {:.0e}", gaps.accuracy))
    }

    /// The lines of `--verbose`: every reason for doubt, every charge, the critical point, and the bounds of the paper.
    pub(super) fn details(&self) -> String {
        let Run { line, diagnostics, sums, .. } = self.run;
        let (names, of) = (line.geometry().names(), |value: S| value.to_f64());
        let mut rows: Vec<(&str, String)> = Vec::new();
        for charge in &diagnostics.charges {
            rows.push(("charge", deviation(&format!("p_{}", names[charge.terms[0].0]), charge, line)));
        }
        for (sum, charge) in sums.iter().zip(&diagnostics.sums) {
            rows.push(("sum", deviation(&sum.formula(names), charge, line)));
        }
        let norm = &diagnostics.norm;
        let [value, most, ends] = [norm.value, norm.max_interior, norm.max_ends].map(of);
        let text = format!("{value:.6}; changes by at most {most:.2e} at nodes, {ends:.2e} at ends of windows");
        rows.push(("K", text));
        for (name, invariant) in &diagnostics.invariants {
            let [value, most, ends] = [invariant.value, invariant.max_interior, invariant.max_ends].map(of);
            rows.push(("drift", format!("{name} = {value:.6}, by {most:.1e} at nodes, {ends:.1e} at ends of windows")));
        }
        for work in &diagnostics.work {
            let (name, work, defect) = (&names[work.coordinate], of(work.work), of(work.defect).abs());
            rows.push(("work", format!("p_{name} changes by the work of the force, {work:.6}, to {defect:.1e}")));
        }
        if let Some(of_x) = &diagnostics.of_x {
            let relation = if of_x.is_kept() { "<=" } else { ">" };
            let [h_bvp, most] = [of_x.h_bvp, of_x.h_bvp_bound].map(of);
            rows.push(("motion", format!("the acceleration differs from Newton's by {:.1e}", of_x.deviation)));
            rows.push(("bound", format!("H_BVP = {h_bvp:.6} {relation} {most:.6} = Q_t (t_f - t_i)")));
        }
        for (a, sawtooth) in &diagnostics.sawtooth {
            let size = sawtooth.amplitude.map_or("not measurable".to_owned(), |size| format!("{:.1e}", of(size)));
            rows.push(("sawtooth", format!("in {}: {size}", names[*a])));
        }
        let action = if line.form == Form::Weak { "E_weak" } else { "E_IVP" };
        let how = iterations(&line.iterations).unwrap_or("an explicit recursion".to_owned());
        let system = if line.is_doubled() { "doubled action" } else { "physical limit" };
        rows.push(("critical", format!("|grad {action}| = {:.1e}, {system}, {how}", of(line.gradient_norm))));
        let doubts = self.judged.verdict.reasons.iter().skip(1).map(doubt);
        doubts.chain(rows.iter().map(|(name, text)| row(name, text))).collect()
    }
}

/// A reason for doubt, with its remedy.
fn doubt(Reason { reason, remedy, .. }: &Reason) -> String {
    row("doubt", &format!("{reason}: {remedy}"))
}

/// A sum of many terms by its first and its last one.
fn shortened(formula: &str) -> String {
    let terms: Vec<&str> = formula.split(" + ").collect();
    match terms[..] {
        [first, _, _, .., last] => format!("{first} + … + {last}"),
        _ => formula.to_owned(),
    }
}

/// A drift by this share of the terms would alarm anyone; where it is rounding that is said.
const ALARMING: f64 = 1e-3;

/// By how much K drifts, or the energy of positions and velocities with Newton's law.
fn drift_of_motion<S: Real>(diagnostics: &Diagnostics<S>) -> String {
    if let Some(energy) = &diagnostics.energy {
        let (drift, ends) = (energy.drift(), energy.max_ends.to_f64());
        return match energy.is_rounding() && drift > ALARMING * energy.heard.terms() {
            true => format!(
                "the energy of positions and velocities by {ends:.1e} at the ends of steps, inside of \
                             which rounding hides it"
            ),
            false => format!("the energy of positions and velocities by {drift:.1e}"),
        };
    }
    let (drift, k) = (diagnostics.norm.drift(), diagnostics.norm.value.to_f64());
    match diagnostics.of_x.as_ref().map(|of_x| of_x.x_dot * of_x.x_dot).filter(|square| *square > 0.0) {
        Some(square) => format!("K by {} of the largest x_dot^2", percent(drift / square)),
        // With 1 γ is proper time, and with 0 the motion is that of light.
        None if k.abs().min((k - 1.0).abs()) < 1e-9 => format!("K by {drift:.1e}"),
        None => format!("K = {k:.6} by {drift:.1e}"),
    }
}

/// The operator, the windows and the time that the solve took. Of Newton's law, where the program has chosen them, they
/// are the steps that a user knows from other programs.
fn scheme<S: Real>(line: &WorldLine<S>, is_newtonian: bool, solve_seconds: f64) -> String {
    let time = unbroken(&format!("{:.2} ms", 1e3 * solve_seconds));
    if is_newtonian && line.accuracy.is_some() {
        let plural = if line.window_count == 1 { "" } else { "s" };
        return format!("{} step{plural}, {time}", line.window_count);
    }
    let nodes = match (line.window_count, line.sbp().points()) {
        (1, points) => format!("{points} nodes"),
        (windows, points) => format!("{windows} windows of {points} nodes"),
    };
    let (name, form, gamma) = (line.sbp_name, line.form.as_str(), short(line.gamma_f().to_f64()));
    format!("{name} {form} form, {nodes} to gamma = {gamma}, {time}")
}

/// A number rounded at the first decimal that is affected by its error, with the error beside it where few digits are
/// right.
pub(super) fn number<S: Real>(number: S, error: Option<f64>, digits: u32) -> String {
    let size = number.to_f64().abs();
    let Some(error) = error.filter(|error| *error > 0.0 && size > 0.0 && size.is_finite()) else {
        return number.to_decimal(digits);
    };
    let significant = (size.log10().floor() - error.log10().floor()) as i32 + 1;
    if significant > digits as i32 {
        return number.to_decimal(digits);
    }
    let (decimals, few) = ((-error.log10().floor()).max(0.0) as usize, significant.max(1));
    let text = match (S::IS_EXTENDED, number.to_f64()) {
        (true, _) => number.to_decimal(few as u32),
        (false, number) if is_readable(number) => format!("{number:.decimals$}"),
        (false, number) => format!("{number:.*e}", few as usize - 1),
    };
    // In chaos an estimate may have thirty digits.
    let is_plain = is_readable(size) && (1e-7..1e6).contains(&error);
    match significant < SURE_DIGITS {
        false => text,
        true if is_plain => format!("{text} ± {:.decimals$}", error.max(10.0_f64.powi(-(decimals as i32)))),
        true => format!("{text} ± {error:.0e}"),
    }
}

fn percent(share: f64) -> String {
    match share {
        100.0.. => format!("{share:.0e} times"),
        0.1.. => format!("{:.0} %", 100.0 * share),
        1e-4.. => format!("{:.2} %", 100.0 * share),
        _ => format!("{share:.1e}"),
    }
}

/// The value of a charge, and by how much it changes at the nodes.
fn deviation<S: Real>(name: &str, charge: &ChargeDeviation<S>, line: &WorldLine<S>) -> String {
    let of = |value: S| value.to_f64();
    let at_last = match line.form {
        Form::Strong => {
            let [last, corrected] = [charge.max_last, charge.max_corrected].map(of);
            format!(", at the last node of a window by {last:.2e}, or {corrected:.1e} with its multiplier")
        }
        Form::Weak => String::new(),
    };
    let [value, interior, ends] = [charge.value, charge.max_interior, charge.max_ends].map(of);
    format!("{name} = {value:.6}; changes by {interior:.1e} at nodes{at_last}; {ends:.1e} between windows")
}

/// The number of iterations that a run took, with their kind, if it took any.
fn iterations(&Iterations { count, initial_guess, .. }: &Iterations) -> Option<String> {
    match count {
        0 => None,
        count if initial_guess == InitialGuess::Extrapolation => Some(format!("{count} evaluations of the force")),
        1 => Some("1 Newton iteration".to_owned()),
        count => Some(format!("{count} Newton iterations")),
    }
}
