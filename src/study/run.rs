//! One run of a case: solved, measured and judged. A row of many runs is the same.

use std::time::Instant;

use crate::case::Case;
use crate::diagnostics::gaps::Gaps;
use crate::diagnostics::verdict::Verdict;
use crate::diagnostics::{Diagnostics, OfX};
use crate::geometry::{ConservedSum, Geometry};
use crate::number::Real;
use crate::solve::{Arithmetic, NoSolution, Setup, WorldLine, solve, solve_window_by_window};
use crate::study::errors::{RunError, reference_error, run_error};
use crate::study::verdict::of_run;
use crate::trajectory::{Crossing, EventSearch, NoSamples, Sample, SampleStream};

/// Conserved sums are looked at on so many nodes of a run.
const PLACES_ALONG: usize = 64;

/// An observer, which sees a run part by part, with what is measured on each part alone. A part that contains the first
/// window begins the run again.
pub type Observer<'o, S> = &'o mut dyn FnMut(&WorldLine<S>, &Diagnostics<S>);

/// The wishes besides the run.
#[derive(Default)]
pub struct Wanted<'o, S: Real = f64> {
    /// Samples.
    pub samples: Option<SampleStream<S>>,
    /// True if nothing but the last window is to be kept.
    pub is_streamed: bool,
    /// True if conserved sums of momenta are looked for.
    pub sums: bool,
    /// The observer of the run.
    pub observer: Option<Observer<'o, S>>,
}

/// Why there is no run.
#[derive(Debug)]
pub enum NoRun<S> {
    /// It was not solved. If it was streamed, these events lie before the failure.
    Unsolved(NoSolution, Vec<Crossing<S>>),
    /// It has no such samples.
    Unsampled(NoSamples<S>),
}

/// A run with what was measured on it.
#[derive(Debug)]
pub struct Run<S: Real = f64> {
    /// The world-line, or its last window if no more was to be kept.
    pub line: WorldLine<S>,
    /// True if it is the whole.
    pub is_whole: bool,
    /// Conserved sums of momenta.
    pub sums: Vec<ConservedSum>,
    /// The measures. If only the last window is kept, rows are those of that window.
    pub diagnostics: Diagnostics<S>,
    /// The samples.
    pub samples: Vec<Sample<S>>,
    /// The events of the case, in the order of γ.
    pub events: Vec<Crossing<S>>,
    /// Seconds spent in measuring.
    pub seconds: f64,
}

/// The quality of a run.
#[derive(Debug)]
pub struct Judged {
    /// Its distance from what it was compared with.
    pub error: Option<RunError>,
    /// The findings between the nodes, if the run looked there.
    pub gaps: Option<Gaps>,
    /// The verdict.
    pub verdict: Verdict,
    /// The warnings.
    pub suspicions: Vec<String>,
}

/// Solves a case, which makes `setup`, and measures the result. Returns also the seconds in the solver; of a run that
/// is streamed they contain those of measuring.
pub fn run<S: Arithmetic>(case: &Case, setup: &Setup<S>, wanted: Wanted<'_, S>) -> (Result<Run<S>, NoRun<S>>, f64) {
    let rough = &setup.rough;
    let sums = if wanted.sums && !case.is_of_x() {
        rough.geometry.conserved_sums(&rough.start, || case.geometry())
    } else {
        Vec::new()
    };
    let terms: Vec<Vec<(usize, S)>> =
        sums.iter().map(|sum| sum.terms.iter().map(|&(a, c)| (a, S::from(c))).collect()).collect();
    let (mut observables, is_lifted) = (case.observables(), case.is_lifted());
    let mut watches = case.watches();
    let (mut events, mut samples) = (EventSearch::new(&mut watches), wanted.samples);
    let mut observer = wanted.observer;
    let mut measured: Option<Diagnostics<S>> = None;
    let mut see = |part: &WorldLine<S>| {
        let here = Diagnostics::of(part, &terms, &mut observables, is_lifted);
        if let Some(observer) = &mut observer {
            observer(part, &here);
        }
        let before = measured.take().filter(|_| part.window_count > part.windows.len());
        measured = Some(match before {
            Some(before) => before.followed_by(here),
            None => here,
        });
        events.see(part);
        samples.iter_mut().for_each(|samples| samples.see(part));
    };
    let start = Instant::now();
    let solved = if wanted.is_streamed { solve_window_by_window(setup, &mut see) } else { solve(setup) };
    let solve_seconds = start.elapsed().as_secs_f64();
    let line = match solved {
        Ok(line) => line,
        Err(mut failure) => {
            if setup.is_backward {
                let gamma_i = setup.gamma_i.to_f64();
                failure.gamma = gamma_i - (failure.gamma - gamma_i);
            }
            return (Err(NoRun::Unsolved(failure, events.found())), solve_seconds);
        }
    };
    let start = Instant::now();
    if !wanted.is_streamed {
        see(&line);
    }
    let events = events.finish(&line);
    let mut diagnostics = measured.unwrap_or_else(|| Diagnostics::new(&line));
    let measured = sums.into_iter().zip(std::mem::take(&mut diagnostics.sums));
    let (sums, of_sums) = measured.filter(|(sum, _)| holds_along(&line, &rough.geometry, sum)).unzip();
    diagnostics.sums = of_sums;
    let samples = match samples.map_or(Ok(Vec::new()), |samples| samples.finish(&line)) {
        Ok(samples) => samples,
        Err(none) => return (Err(NoRun::Unsampled(none)), solve_seconds),
    };
    let is_whole = !wanted.is_streamed;
    let seconds = start.elapsed().as_secs_f64();
    (Ok(Run { line, is_whole, sums, diagnostics, samples, events, seconds }), solve_seconds)
}

/// Returns true if a sum is conserved where the run has come to, too: a formula may be another one there.
fn holds_along<S: Real>(line: &WorldLine<S>, geometry: &Geometry, sum: &ConservedSum) -> bool {
    let every = line.nodes().div_ceil(PLACES_ALONG);
    let q_dot: Vec<f64> = line.end().q_dot.iter().map(|u| u.to_f64()).collect();
    let place = |node: usize| line.q.iter().map(|row| row[node].to_f64()).collect::<Vec<f64>>();
    (0..line.nodes()).step_by(every).all(|node| geometry.conserves(sum, &place(node), &q_dot))
}

impl<S: Real> Run<S> {
    /// The warnings without those of a look between the nodes.
    pub fn warnings(&self) -> Vec<String> {
        let newtonian = self.diagnostics.of_x.as_ref().and_then(OfX::newtonian_warning);
        self.diagnostics.warnings(&self.line).into_iter().chain(newtonian).collect()
    }

    /// Judges the run of `setup`: its error comes from the engine beside it, or with `reference` from the Taylor
    /// method; with `enclose` what may hide between its nodes is looked at.
    pub fn judged(&self, setup: &Setup<S>, reference: bool, enclose: bool) -> Judged {
        let Self { line, diagnostics, .. } = self;
        // The nodes before the last window may be gone; what is written is compared all the same.
        let samples = if self.is_whole { &[] } else { self.samples.as_slice() };
        let reference = if reference { reference_error(setup, line, samples) } else { None };
        let has_estimate = line.error_estimate.is_some();
        let estimate = if has_estimate || reference.is_none() { run_error(setup, line, samples) } else { None };
        let contradiction = reference.as_ref().filter(|_| estimate.is_some());
        let mut verdict = of_run(line, diagnostics, estimate.as_ref().or(reference.as_ref()), contradiction);
        let is_reason = |warning: &String| verdict.reasons.iter().any(|reason| reason.to_string() == *warning);
        let newtonian = diagnostics.of_x.as_ref().and_then(OfX::newtonian_warning);
        let mut suspicions: Vec<String> =
            diagnostics.warnings(line).into_iter().filter(is_reason).chain(newtonian).collect();
        // With an accuracy the solver has looked between the nodes.
        let gaps = (enclose && line.accuracy.is_none()).then(|| Gaps::new(line, &setup.rough.geometry, verdict.error));
        if let Some(reason) = gaps.as_ref().and_then(Gaps::reason) {
            suspicions.push(reason.to_string());
            verdict.doubt(reason);
        }
        Judged { error: reference.or(estimate), gaps, verdict, suspicions }
    }
}
