//! One run of a case: solved, measured and judged. A row of many runs is the same.

use std::time::Instant;

use crate::case::Case;
use crate::diagnostics::gaps::Gaps;
use crate::diagnostics::verdict::{Reason, Verdict, VerdictInput};
use crate::diagnostics::{Diagnostics, OfX};
use crate::geometry::{ConservedSum, Geometry, Observable, Start};
use crate::number::Real;
use crate::solve::{Off, Setup, WorldLine};
use crate::study::acting::{Chains, Piece, Stopped, begins_beyond};
use crate::study::errors::{
    Further, OfRun, Paired, RunError, Sights, first_touched, first_unseen, lost_to, own_error, paired, passed,
    reference_error, several_motions,
};
use crate::study::facts::{coordinate_errors, facts_of_errors, suspicions};
use crate::study::proof::{Hull, ProofOfRun};
use crate::study::solved::{EveryWindow, solved};
use crate::study::some_nodes::SomeNodes;
use crate::study::subject::timed;
use crate::trajectory::{Crossing, EventSearch, NoSamples, Sample, SampleStream};

pub use super::failed::{Before, NoRun, Part};

/// Conserved sums are looked at on so many nodes of a run.
const PLACES_ALONG: usize = 64;

/// An observer, which sees a run part by part, with what is measured on each part alone. A part that contains the first
/// window begins the run again.
pub type Observer<'o, S> = &'o mut dyn FnMut(&WorldLine<S>, &Diagnostics<S>);

/// Sees the samples that are found in a part of a run. If the part contains the first window, the run begins again.
pub type SampleObserver<'o, S> = &'o mut dyn FnMut(&[Sample<S>], bool);

/// Things that are wanted of a run besides its table, each of which costs something.
#[derive(Default)]
pub struct Wanted<'o, S: Real = f64> {
    /// Samples.
    pub samples: Option<SampleStream<S>>,
    /// True if samples beyond the run may be missing, and are no reason to have no run.
    pub takes_part: bool,
    /// True if nothing but the last windows are to be kept.
    pub is_streamed: bool,
    /// True if conserved sums of momenta are looked for.
    pub sums: bool,
    /// The observer of the run.
    pub observer: Option<Observer<'o, S>>,
    /// An observer of the samples, of which the run keeps those in its last part only.
    pub of_samples: Option<SampleObserver<'o, S>>,
}

/// A run with what was measured on it.
#[derive(Debug)]
pub struct Run<S: Real = f64> {
    /// The world-line, or its last windows if no more was to be kept; where events have acted, its piece behind the
    /// last of them.
    pub line: WorldLine<S>,
    /// The pieces before that, each up to an event that acted.
    pub before: Vec<Part<S>>,
    /// True if it is the whole.
    pub is_whole: bool,
    /// Conserved sums of momenta.
    pub sums: Vec<ConservedSum>,
    /// The measures. If only the last windows are kept, rows are those of these.
    pub diagnostics: Diagnostics<S>,
    /// The samples.
    pub samples: Vec<Sample<S>>,
    /// Why others are missing, if some are.
    pub unsampled: Option<NoSamples<S>>,
    /// The events of the case, in the order of γ.
    pub events: Vec<Crossing<S>>,
    /// The name of the first event that the run has met and its judge has not, or the other way round.
    pub unpaired: Option<String>,
    /// The name of the first event that may have happened unseen, as its formula changes too narrowly, and γ there.
    pub unseen: Option<(String, f64)>,
    /// The name of the first event that acts or ends the run of which its error decides whether it happens, and γ
    /// there.
    pub touched: Option<(String, f64)>,
    /// The name of an event that acts, and beyond which the run begins: at its place, on the way to the other side.
    pub beyond: Option<String>,
    /// γ at a place where a force jumps and leads away: the motion may stay there, and it may leave.
    pub undecided: Option<f64>,
    /// The number of events that have acted.
    pub acting_events: usize,
    /// The number of changes of sign at which an event should have acted or ended the run, and has not.
    pub missed: usize,
    /// The error of a run in which events have acted.
    pub error: Option<RunError>,
    /// The errors of coordinates at an event that ended it, as the end of its judge tells.
    at_end: Option<Vec<f64>>,
    /// The errors that it does not make itself.
    further: Further,
    /// Nodes before the last windows, if only these are kept.
    nodes: Vec<Sample<S>>,
    /// Seconds spent in measuring.
    pub seconds: f64,
}

/// The quality of a run.
#[derive(Debug)]
pub struct Judged {
    /// Its distance from what it was compared with, and the errors that it does not make itself.
    pub error: Option<RunError>,
    /// The largest errors of coordinates that it inherits from the run that it continues, if it inherits any.
    pub inherited: Option<Vec<f64>>,
    /// By how much the state at its end may be off, if that is known.
    pub left: Option<Off>,
    /// The findings between the nodes, if the run looked there.
    pub gaps: Option<Gaps>,
    /// The proof of its end, if one was asked for.
    pub proof: Option<ProofOfRun>,
    /// The ends of all motions from the intervals of the case, or why they are not known, if it has some.
    pub hull: Option<Hull>,
    /// The verdict.
    pub verdict: Verdict,
    /// The warnings.
    pub suspicions: Vec<String>,
}

/// The measures of a run, part by part.
struct Measures<'m, 'o, S: Real> {
    case: &'m Case,
    /// The setup that it makes.
    setup: &'m Setup<S>,
    /// The conserved sums, and whether each has held so far.
    sums: Vec<(ConservedSum, bool)>,
    /// Their terms.
    terms: Vec<Vec<(usize, S)>>,
    observables: Vec<(String, Observable<S>)>,
    events: EventSearch<'m, S>,
    samples: Option<SampleStream<S>>,
    of_samples: Option<SampleObserver<'o, S>>,
    observer: Option<Observer<'o, S>>,
    measured: Option<Diagnostics<S>>,
    sights: Sights,
    /// Nodes of a run on a given grid that keeps no windows.
    nodes: Option<SomeNodes<S>>,
    /// The parameters that events have set before what is seen next.
    set: Vec<(usize, f64)>,
}

impl<'m, 'o, S: Real> Measures<'m, 'o, S> {
    /// No measures yet of what is wanted of a run.
    fn new(
        (case, setup): (&'m Case, &'m Setup<S>),
        sums: Vec<ConservedSum>,
        wanted: Wanted<'o, S>,
        events: EventSearch<'m, S>,
    ) -> Self {
        Self {
            case,
            setup,
            terms: sums.iter().map(|sum| sum.terms.iter().map(|&(a, c)| (a, S::from(c))).collect()).collect(),
            sums: sums.into_iter().map(|sum| (sum, true)).collect(),
            observables: case.observables(),
            events,
            samples: wanted.samples,
            of_samples: wanted.of_samples,
            observer: wanted.observer,
            measured: None,
            sights: Sights::default(),
            nodes: (wanted.is_streamed && setup.settings.accuracy.is_none()).then(SomeNodes::default),
            set: Vec::new(),
        }
    }

    /// Goes on with the formulas of a setup, whose parameters events may have set.
    fn of(&mut self, setup: &Setup<S>) {
        if setup.set == self.set {
            return;
        }
        let case =
            self.case.with_parameters(&setup.set, &setup.rough.start.q).expect("it was solved with these numbers");
        self.observables = case.observables();
        self.events.replace(&case.watches());
        self.set.clone_from(&setup.set);
    }

    fn see(&mut self, part: &WorldLine<S>) {
        let here = Diagnostics::of(part, &self.terms, &mut self.observables, self.case.is_lifted());
        if let Some(observer) = &mut self.observer {
            observer(part, &here);
        }
        let before = self.measured.take().filter(|_| part.window_count > part.windows.len());
        self.measured = Some(if let Some(before) = before { before.followed_by(here) } else { here });
        self.events.see(part);
        self.sights.see((self.case, self.setup), part, &self.set);
        self.samples.iter_mut().for_each(|samples| samples.see(part));
        self.nodes.iter_mut().for_each(|nodes| nodes.see(part));
        if let (Some(observer), Some(samples)) = (&mut self.of_samples, &mut self.samples) {
            observer(samples.take().as_slice(), part.window_count == part.windows.len());
        }
    }

    /// Looks whether the sums are conserved where a piece has come to, too: a formula may be another one there.
    fn check_sums(&mut self, line: &WorldLine<S>, geometry: &Geometry) {
        let every = line.nodes().div_ceil(PLACES_ALONG);
        let q_dot: Vec<f64> = line.end().q_dot.iter().map(|u| u.to_f64()).collect();
        let place = |node: usize| line.q.iter().map(|row| row[node].to_f64()).collect::<Vec<f64>>();
        for (sum, holds) in &mut self.sums {
            *holds &= (0..line.nodes()).step_by(every).all(|node| geometry.conserves(sum, &place(node), &q_dot));
        }
    }

    /// Sees the pieces of a run, unless they were seen, and returns them with their rows.
    fn see_pieces(&mut self, pieces: Vec<Piece<S>>, is_seen: bool) -> Vec<Part<S>> {
        let (watches, mut parts) = (self.case.acting_watches(), Vec::with_capacity(pieces.len()));
        let last = pieces.len().saturating_sub(1);
        for (place, Piece { line, setup, acted }) in pieces.into_iter().enumerate() {
            self.of(&setup);
            if !is_seen {
                self.see(&line);
            }
            if setup.has_acting_events() {
                let acted: Vec<usize> = acted.into_iter().filter_map(|place| watches[place]).collect();
                self.events.act(&line, &acted, &watches);
            }
            self.check_sums(&line, &setup.rough.geometry);
            // The rows of joined measures are those of the last part.
            let rows = if place == last { self.measured.take() } else { self.measured.clone() };
            let rows = rows.unwrap_or_else(|| Diagnostics::new(&line));
            parts.push((line, rows));
        }
        for (_, rows) in &mut parts {
            let mut sums = self.sums.iter();
            rows.sums.retain(|_| sums.next().is_some_and(|(_, holds)| *holds));
        }
        parts
    }

    /// Expresses a failure, with what there is before it. What `is_seen` was measured on the way.
    fn unsolved(mut self, setup: &Setup<S>, stopped: Stopped<S>, is_seen: bool) -> NoRun<S> {
        let Stopped { mut failure, pieces } = stopped;
        let parts = self.see_pieces(pieces, is_seen);
        if setup.is_backward {
            failure.gamma = 2.0 * setup.gamma_i.to_f64() - failure.gamma;
        }
        failure.reasons.lost = lost_to(self.case, setup, std::mem::take(&mut self.sights), &failure);
        let samples = self.samples.map_or_else(Vec::new, SampleStream::so_far);
        NoRun::Unsolved(failure, Before { parts, events: self.events.found(), samples })
    }
}

/// The sums of momenta that may be conserved, if they are `wanted`.
fn conserved_sums<S: Real>(case: &Case, setup: &Setup<S>, wanted: bool) -> Vec<ConservedSum> {
    if !wanted || case.is_of_x {
        return Vec::new();
    }
    setup.rough.geometry.conserved_sums(&setup.rough.start, || case.geometry())
}

/// γ and the state at the start of a piece, with the parameters that events have set.
fn started<S: Real>(Piece { line, setup, .. }: &Piece<S>) -> (f64, Start, Vec<(usize, f64)>) {
    (line.gamma_i.to_f64(), (*setup.rough.start).clone(), setup.set.clone())
}

/// Solves a case, which makes `setup`, and measures the result. Returns also the seconds in the solver; of a run that
/// is streamed they contain those of measuring.
pub fn run<S: Real>(case: &Case, setup: &Setup<S>, wanted: Wanted<'_, S>) -> (Result<Run<S>, NoRun<S>>, f64) {
    let watched = case.watches_with_until();
    let mut watches = watched[..case.events.len()].to_vec();
    let Wanted { takes_part, is_streamed, sums, .. } = wanted;
    let sums = conserved_sums(case, setup, sums);
    let mut measures = Measures::new((case, setup), sums, wanted, EventSearch::new(&mut watches));
    let mut see = |part: &WorldLine<S>| measures.see(part);
    let observer: Option<EveryWindow<'_, S>> = if is_streamed { Some(&mut see) } else { None };
    let is_seen = is_streamed && !setup.has_acting_events();
    let (found, solve_seconds) = timed(|| solved(case, setup, &watched, observer));
    let (Chains { pieces, error, .. }, of_judge) = match found {
        Ok(found) => found,
        Err(stopped) => return (Err(measures.unsolved(setup, *stopped, is_seen)), solve_seconds),
    };
    let starts: Vec<_> = pieces.iter().skip(1).map(started).collect();
    let windows: usize = pieces.iter().map(|piece| piece.line.window_count).sum();
    let (acting_events, start) = (pieces.iter().map(|piece| piece.acted.len()).sum(), Instant::now());
    let mut before = measures.see_pieces(pieces, is_seen);
    let (mut line, diagnostics) = before.pop().expect("a run has a piece");
    let (samples, unsampled) = measures.samples.map_or_else(Default::default, |samples| samples.finish_inside(&line));
    if let Some(none) = unsampled.filter(|_| !takes_part) {
        return (Err(NoRun::Unsampled(none)), solve_seconds);
    }
    let ended = (line.gamma_f().to_f64(), line.end_inside().in_f64(), measures.set.clone());
    let window = (line.gamma_f() - setup.gamma_i).to_f64().abs() / windows as f64;
    let undecided = several_motions((case, setup), &measures.sights, starts.into_iter().chain([ended]), window);
    let further = Further::new(case, setup, &line, &measures.sights);
    further.limit(&mut line);
    let (missed, unseen) = (measures.events.missed(), measures.events.unseen());
    let of_run = OfRun::new(before.first().map_or(&line, |(first, _)| first), &line);
    let Paired { mut events, unpaired, at_end } =
        paired(case, (&line, setup), measures.events.finish(&line), of_judge.as_deref(), &of_run);
    // What the run does not make itself moves events, too.
    events.iter_mut().filter(|_| further.moves_events()).for_each(|event| event.off = None);
    let run = Run {
        is_whole: !is_streamed,
        nodes: measures.nodes.map_or_else(Vec::new, |nodes| nodes.seen),
        further,
        sums: measures.sums.into_iter().filter_map(|(sum, holds)| holds.then_some(sum)).collect(),
        diagnostics,
        samples,
        unsampled,
        acting_events,
        missed: missed + passed(&events, &of_run, |watch| case.events[watch].until),
        events,
        unpaired,
        at_end,
        unseen: first_unseen(case, unseen, before.iter().map(|(line, _)| line).chain([&line])),
        touched: first_touched(case, before.iter().map(|(line, _)| line).chain([&line])),
        beyond: begins_beyond(setup).map(|place| case.ending_names()[place].to_owned()),
        undecided,
        error,
        seconds: start.elapsed().as_secs_f64(),
        before,
        line,
    };
    (Ok(run), solve_seconds)
}

impl<S: Real> Run<S> {
    /// The pieces of the run in order, one if no event acted, with the rows that were measured on them.
    pub fn parts(&self) -> Vec<(&WorldLine<S>, &Diagnostics<S>)> {
        let before = self.before.iter().map(|(line, rows)| (line, rows));
        before.chain([(&self.line, &self.diagnostics)]).collect()
    }

    /// The warnings without those of a look between the nodes.
    pub fn warnings(&self) -> Vec<String> {
        let newtonian = self.diagnostics.of_x.as_ref().and_then(OfX::newtonian_warning);
        let suspicions = self.diagnostics.suspicions(&self.line, self.further.noise().norm);
        suspicions.iter().map(Reason::to_string).chain(newtonian).collect()
    }

    /// Judges the run of `setup`: its error comes from the engine beside it, or with `reference` from the Taylor
    /// method; with `enclose` what may hide between its nodes is looked at.
    pub fn judged(&self, setup: &Setup<S>, reference: bool, enclose: bool) -> Judged {
        let Self { line, diagnostics, .. } = self;
        // The nodes before the last windows may be gone; some of them are compared all the same.
        let samples = if self.is_whole { &[] } else { self.nodes.as_slice() };
        let reference = if reference { reference_error(setup, line, samples) } else { None };
        let is_estimated = line.error_estimate.is_some() || (reference.is_none() && setup.settings.is_judged);
        let (at_end, noise) = (self.at_end.as_deref(), self.further.noise());
        let of_line = || own_error(setup, (line, at_end), samples, noise);
        let of_chain = || self.at_end.iter().fold(self.error.clone(), |error, end| Some(error?.with_end(end)));
        let estimate = of_chain().or_else(|| if is_estimated { of_line() } else { None });
        let contradiction = reference.as_ref().filter(|_| estimate.is_some());
        let known = estimate.as_ref().or(reference.as_ref());
        let facts = facts_of_errors(line, diagnostics, known, contradiction);
        // What the run does not make itself may explain what its witnesses see.
        let all = known.map(|error| self.further.added(error));
        let suspicions = suspicions(line, diagnostics, all.as_ref(), &self.further.of_certificate());
        let facts = VerdictInput { suspicions, is_unjudged: !setup.settings.is_judged, ..facts };
        let mut verdict = Verdict::new(&facts);
        let newtonian = diagnostics.of_x.as_ref().and_then(OfX::newtonian_warning);
        let told = facts.suspicions.iter().filter(|reason| verdict.reasons.contains(reason)).map(Reason::to_string);
        let mut suspicions: Vec<String> = told.chain(newtonian).collect();
        // With an accuracy the solver has looked between the nodes.
        let gaps = (enclose && line.accuracy.is_none()).then(|| Gaps::new(line, &setup.rough.geometry, verdict.error));
        if let Some(reason) = gaps.as_ref().and_then(Gaps::reason) {
            suspicions.push(reason.to_string());
            verdict.doubt(reason);
        }
        self.doubts(setup).into_iter().for_each(|reason| verdict.doubt(reason));
        let error = reference.or(estimate);
        let mut judged =
            Judged { error, inherited: None, left: None, gaps, proof: None, hull: None, verdict, suspicions };
        self.add_further(setup, &facts, &mut judged);
        judged
    }

    /// Adds the errors that the run does not make itself to what is said of it, where its own are those of `facts`.
    fn add_further(&self, setup: &Setup<S>, facts: &VerdictInput, judged: &mut Judged) {
        let Self { line, diagnostics, further, .. } = self;
        let (Some(own), Some(error)) = (&facts.errors, &judged.error) else {
            // Nothing is known of the error, and the run is doubtful in any case.
            judged.verdict.doubt_first(further.reasons(&[], &[], None));
            return;
        };
        let all = Some(coordinate_errors(line, diagnostics, &further.added(error)));
        let reasons = further.reasons(own, all.as_deref().unwrap_or_default(), line.accuracy);
        let told = Verdict::new(&VerdictInput { errors: all, digits: line.digits, ..VerdictInput::default() });
        (judged.verdict.error, judged.verdict.digits) = (told.error, told.digits);
        judged.suspicions.extend(reasons.iter().map(Reason::to_string));
        judged.verdict.doubt_first(reasons);
        judged.left = further.left(setup, line, own, error.end_p.as_deref());
        judged.inherited = further.inherited();
        judged.error = Some(further.added(error));
    }
}
