//! A world-line of a scene, window by window.

use std::ops::ControlFlow;

use super::FlowFailure;
use super::certificate::Certificate;
use super::control::{Controller, TUNING};
use super::course::Course;
use super::enclosed::{Look, Scales};
use super::growth::Growth;
use super::judge::{Judge, ROUNDING, WindowErrors};
use super::probe;
use super::request::{Request, Target};
use super::rule;
use super::state::FlowState;
use super::stop::{Stop, Watch};
use super::transport::Transport;
use super::view::FlowView;
use super::window::{FlowWindow, Outcome, Rule, Task};
use crate::geometry::{Geometry, Start};
use crate::lobatto::attempt::MOST_EVALUATIONS;
use crate::lobatto::{Statistics, Twofold};

/// Where a march ended.
#[derive(Debug, Clone)]
pub struct Followed {
    /// The last state.
    pub end: FlowState,
    /// γ − γ_i there.
    pub gamma: f64,
    /// Which of the stops ended it, if one did.
    pub stopped_by: Option<usize>,
    /// The work done, including rejected windows. An evaluation is a sweep.
    pub statistics: Statistics,
    /// An upper estimate of the error of every coordinate at all nodes, relative to max(1, largest |q^a|) for active
    /// coordinates and max(1, largest |q^a − q_i^a|) for ignorable ones.
    pub error_estimate: f64,
    /// How often the march was begun; every attempt but the last turned out not to be accurate enough.
    pub attempts: usize,
}

/// A march along a world-line of a scene that keeps to a requested accuracy.
#[derive(Debug, Clone, Copy)]
pub struct Flow<'g> {
    geometry: &'g Geometry,
    certify: bool,
    target: Option<Target>,
}

/// A lower accuracy would cost hardly less, and windows that resolve nothing do not show it.
const LOOSEST: f64 = 1e-4;

/// Above the first accuracy 16 nodes are cheapest, down to the second 20, and below that 24.
const COARSE: f64 = 5e-9;
const MEDIUM: f64 = 5e-11;

/// The first window to try, in radians of the motion at the start.
const FIRST: f64 = 1.0;

/// Windows shorter than this part of the first are taken for a singularity.
const SHORTEST: f64 = 1e-13;

/// After how many evaluations progress is checked again.
const PACE: usize = 10_000;

/// A march whose error at the end will miss the accuracy by more than this factor is begun again at once.
const MOST_PROJECTED: f64 = 1.2;

/// Not so if that error is no less than this part of that of the attempt before: what is left is rounding, which no
/// smaller share reduces.
const BETTER: f64 = 0.3;

/// The most excess of a window whose rates are a guess for a shorter one. Sweeps that diverge leave numbers that are not.
const SANE: f64 = 1e8;

/// A share that follows a failed attempt aims at this part of the accuracy, and is at least that part of the one before.
const RETRY: [f64; 2] = [0.2, 1e-4];

/// Why an attempt did not reach its goal.
enum Ended {
    Failed(FlowFailure),
    /// The march is to be begun again with windows that are allowed this factor less, as its error would be this.
    Inaccurate {
        factor: f64,
        expected: f64,
    },
}

impl<'g> Flow<'g> {
    /// In `geometry`, whose determinants have the signs of the start.
    pub fn new(geometry: &'g Geometry) -> Self {
        Self { geometry, certify: false, target: None }
    }

    /// Ends with this value of a coordinate, as a stop that stands before all others. Errors are those at equal values of
    /// this coordinate then, as well as those at equal γ.
    pub fn to_value(mut self, coordinate: usize, value: f64) -> Self {
        self.target = Some(Target { coordinate, value });
        self
    }

    /// Computes the certificate of every window too.
    pub fn certified(mut self) -> Self {
        self.certify = true;
        self
    }

    /// From `start` over `length` of γ, which may be infinite, or to the first change of sign of one of the `stops`.
    /// `observe` sees every window of the world-line and may end the march; if a march is begun again, it sees index 0
    /// again.
    ///
    /// # Errors
    /// [`FlowFailure`] where the world-line leaves the domain, and if the accuracy is not reached.
    pub fn run(
        &self,
        start: &Start,
        length: f64,
        stops: &mut [&mut dyn Stop],
        accuracy: f64,
        observe: &mut dyn FnMut(&FlowView<'_>) -> ControlFlow<()>,
    ) -> Result<Followed, FlowFailure> {
        let accuracy = accuracy.min(LOOSEST);
        let request = Request {
            start: FlowState::new(start, self.geometry.active()),
            q_dot: &start.q_dot,
            momenta: &start.p,
            length,
            target: self.target,
            accuracy,
            certify: self.certify,
        };
        let mut target = self.target;
        let target = target.iter_mut().map(|target| target as &mut dyn Stop);
        let stops = target.chain(stops.iter_mut().map(|stop| &mut **stop as &mut dyn Stop));
        let mut watches: Vec<Watch<'_>> = stops.map(|stop| Watch::new(stop, &start.p)).collect();
        if accuracy >= COARSE {
            self.with(rule::coarse(), &request, &mut watches, observe)
        } else if accuracy >= MEDIUM {
            self.with(rule::medium(), &request, &mut watches, observe)
        } else {
            self.with(rule::fine(), &request, &mut watches, observe)
        }
    }

    fn with<const P: usize>(
        &self,
        rule: Rule<P>,
        request: &Request<'_>,
        watches: &mut [Watch<'_>],
        observe: &mut dyn FnMut(&FlowView<'_>) -> ControlFlow<()>,
    ) -> Result<Followed, FlowFailure> {
        if request.accuracy < ROUNDING {
            let q = request.start.q.iter().map(|q| q.hi).collect();
            return Err(FlowFailure::AccuracyNotReached { gamma: 0.0, q, estimate: ROUNDING });
        }
        let mut walk = Walk {
            geometry: self.geometry,
            request,
            window: FlowWindow::new(self.geometry, rule),
            transport: Transport::new(self.geometry),
            look: Look::new(self.geometry),
            certificate: request.certify.then(|| Certificate::new(self.geometry, request.momenta)),
            statistics: Statistics::default(),
        };
        let (mut caution, mut missed) = (1.0, f64::INFINITY);
        for attempts in 1.. {
            match walk.attempt(caution, missed, watches, observe) {
                Err(Ended::Failed(failure)) => return Err(failure),
                Err(Ended::Inaccurate { factor, expected }) => {
                    caution *= factor;
                    missed = expected;
                }
                Ok(followed) => return Ok(Followed { attempts, ..followed }),
            }
        }
        unreachable!("the shares run out")
    }
}

struct Walk<'g, 'r, const P: usize> {
    geometry: &'g Geometry,
    request: &'r Request<'r>,
    window: FlowWindow<'g, P>,
    transport: Transport<'g>,
    look: Look,
    certificate: Option<Certificate<'g, P>>,
    statistics: Statistics,
}

/// A window that was solved.
#[derive(Clone, Copy)]
struct Solved {
    h: f64,
    sweeps: usize,
}

impl<const P: usize> Walk<'_, '_, P> {
    /// One march, each window allowed one share of the accuracy. An attempt before would have `missed` it by that error.
    fn attempt(
        &mut self,
        caution: f64,
        missed: f64,
        watches: &mut [Watch<'_>],
        observe: &mut dyn FnMut(&FlowView<'_>) -> ControlFlow<()>,
    ) -> Result<Followed, Ended> {
        let Request { length, target, accuracy, momenta, .. } = *self.request;
        self.window.begin(momenta);
        watches.iter_mut().for_each(Watch::begin);
        self.look.begin(momenta);
        (self.statistics.windows, self.statistics.unproved) = (0, 0);
        let mut state = self.request.start.clone();
        let mut start = state.clone();
        let mut judge = Judge::new(self.geometry, &state, momenta, target.map(|target| target.coordinate));
        self.transport.begin(momenta, &state);
        let mut rate = judge.look_at(&self.transport);
        let mut whole = self.request.whole(0.0, &state);
        let first = (FIRST / rate.max(1e-60)).min(whole).min(1e60);
        let points = self.window.rule.rule.points();
        let mut control = Controller::new(TUNING, points, caution * accuracy, first);
        // Without an end in sight nothing is foreseen but the first window.
        let foreseen = |whole: f64| if whole.is_finite() { whole } else { first };
        let mut growth = Growth::default();
        let mut longest = 0.0;
        let mut gamma = Twofold::ZERO;
        let mut pace = self.statistics.evaluations;
        loop {
            let rest = (Twofold::from(length) - gamma).hi;
            let is_last = rest <= control.h * 1.05;
            let h = if is_last { rest } else { control.h };
            if self.statistics.evaluations - pace > PACE {
                self.budget([gamma.hi, whole], &state).map_err(Ended::Failed)?;
                pace = self.statistics.evaluations;
            }
            let scale = h.max(gamma.hi / self.statistics.windows.max(1) as f64).max(first / 16.0);
            judge.set_scale(scale);
            let share = control.share(scale / foreseen(whole));
            let lasting = (scale / h).max(1.0);
            let tolerance = control.tolerance(share);
            let task = Task { start: &state, h, weights: &judge.weights, tolerance, is_new: h > longest };
            let excess_of =
                |errors: WindowErrors| (errors.end / share).max((TUNING.margin * errors.inside / accuracy).powi(2));
            // A tail is one of the solution where it is more than what sweeps still change.
            let is_hopeless = |window: &FlowWindow<'_, P>, change: f64| {
                let errors = judge.of_window(window, lasting);
                errors.inside > change && control.is_hopeless(excess_of(errors))
            };
            let outcome = self.window.solve(task, &is_hopeless);
            let mut errors = WindowErrors::NONE;
            if outcome != Outcome::Failed {
                errors = judge.of_window(&self.window, lasting);
            }
            let excess = excess_of(errors);
            let excess = if excess.is_nan() { f64::INFINITY } else { excess };
            let is_good = matches!(outcome, Outcome::Solved(_)) && control.accepts(excess);
            let scales = Scales { accuracy, length: whole, gamma: gamma.hi, first, time: scale };
            let [hides, is_short] = if is_good { self.look.at(&self.window, &judge, scales) } else { [false; 2] };
            self.statistics.unproved += usize::from(hides && is_short);
            let excess = if hides && !is_short { f64::INFINITY } else { excess };
            let mut solved = match outcome {
                Outcome::Solved(sweeps) if control.accepts(excess) => Some(Solved { h, sweeps }),
                _ => None,
            };
            let mut stopped_by = None;
            if let Some(solved) = &mut solved {
                stopped_by = self.stop(watches, task, solved, gamma.hi).map_err(Ended::Failed)?;
            }
            self.statistics.evaluations = self.window.sweeps;
            let Some(solved) = solved else {
                self.window.reject(h, excess <= SANE);
                control.h = h;
                control.refuse(excess);
                if control.h <= SHORTEST * first {
                    return Err(Ended::Failed(self.why(&state, first.min(rest), gamma.hi)));
                }
                continue;
            };
            self.window.accept(solved.h);
            watches.iter_mut().for_each(Watch::accept);
            std::mem::swap(&mut state, &mut start);
            state.clone_from(&self.window.end);
            longest = solved.h;
            let end = gamma + Twofold::from(solved.h);
            whole = self.request.whole(end.hi, &state);
            let windows = (self.statistics.windows as f64).max(foreseen(whole) / solved.h);
            self.transport.follow(&self.window, &judge.weights, windows);
            let (part, middle) = judge.look_back(&self.transport);
            self.transport.enlarge(|row| judge.local(&self.window, row));
            if lasting != 1.0 || stopped_by.is_some() {
                errors = judge.of_window(&self.window, 1.0);
            }
            judge.see(&self.window, errors.inside, &self.transport);
            let estimate = judge.so_far();
            let done = if whole.is_finite() { (end.hi / whole).min(1.0) } else { 1.0 };
            let projected = growth.project(end.hi, judge.at_ends(), done);
            let is_exhausted = control.is_exhausted(share);
            let is_missed = estimate.is_nan() || estimate > accuracy;
            let is_foreseen = projected > MOST_PROJECTED * accuracy && projected < BETTER * missed;
            if is_missed || is_foreseen && !is_exhausted {
                return Err(self.inaccurate(is_exhausted, projected.max(estimate), end.hi, &start));
            }
            let gradient_norm = self.certificate.as_mut().map(|room| room.of(&self.window, &start, solved.h));
            let view = FlowView {
                index: self.statistics.windows,
                gamma: gamma.hi,
                length: solved.h,
                points,
                start: &start,
                end: &state,
                gradient_norm,
                window: &self.window,
            };
            self.statistics.windows += 1;
            gamma = end;
            if observe(&view).is_break() || is_last && solved.h == h || stopped_by.is_some() {
                let statistics = self.statistics;
                let gamma = if stopped_by.is_none() && is_last { length } else { gamma.hi };
                return Ok(Followed {
                    end: state,
                    gamma,
                    stopped_by,
                    statistics,
                    error_estimate: estimate,
                    attempts: 0,
                });
            }
            let before = std::mem::replace(&mut rate, judge.look_at(&self.transport));
            let course = Course { part, rates: [before, middle, rate], fall: errors.fall };
            control.accept(solved.h, excess, solved.sweeps, course);
        }
    }

    /// A window to be shortened or taken, however it fares.
    fn solve(&mut self, task: Task<'_>) -> Option<Solved> {
        match self.window.solve(task, &|_, _| false) {
            Outcome::Solved(sweeps) => Some(Solved { h: task.h, sweeps }),
            Outcome::TooLong | Outcome::Failed => None,
        }
    }

    /// Shortens the window that was solved to the first change of sign of a stop; which one.
    fn stop(
        &mut self,
        watches: &mut [Watch<'_>],
        task: Task<'_>,
        solved: &mut Solved,
        gamma: f64,
    ) -> Result<Option<usize>, FlowFailure> {
        let (start, mut first) = (task.start, None);
        for (index, watch) in watches.iter_mut().enumerate() {
            let longest = solved.h;
            let Some(bracket) = watch.look(&self.window, start, longest) else { continue };
            self.window.reject(longest, true);
            let root = bracket.root(gamma, longest, |h| {
                self.solve(Task { h, ..task })?;
                Some(watch.at_end(&self.window, start, h))
            });
            let Some(h) = root else {
                return Err(self.why(start, longest, gamma));
            };
            *solved = self.solve(Task { h, ..task }).ok_or_else(|| self.why(start, h, gamma))?;
            first = Some(index);
        }
        Ok(first)
    }

    /// Why there is no window from here, however short.
    fn why(&self, start: &FlowState, ahead: f64, gamma: f64) -> FlowFailure {
        probe::why(self.geometry, start, self.request.momenta, ahead, gamma)
    }

    /// What follows from an `estimate` for the whole run that is above the accuracy, at `gamma`.
    fn inaccurate(&self, is_exhausted: bool, estimate: f64, gamma: f64, start: &FlowState) -> Ended {
        if is_exhausted {
            let q = start.q.iter().map(|q| q.hi).collect();
            return Ended::Failed(FlowFailure::AccuracyNotReached { gamma, q, estimate });
        }
        let factor = RETRY[0] * self.request.accuracy / estimate;
        let factor = if factor.is_nan() { RETRY[1] } else { factor.max(RETRY[1]) };
        Ended::Inaccurate { factor, expected: estimate }
    }

    /// Ends a march that at its pace would take more evaluations than anybody would wait for.
    fn budget(&self, [gamma, whole]: [f64; 2], state: &FlowState) -> Result<(), FlowFailure> {
        let evaluations = self.statistics.evaluations;
        let done = if whole.is_finite() { gamma / whole } else { 1.0 };
        let needed = evaluations as f64 / done;
        if needed > MOST_EVALUATIONS {
            let q = state.q.iter().map(|q| q.hi).collect();
            return Err(FlowFailure::EvaluationLimit { gamma, q, evaluations, needed });
        }
        Ok(())
    }
}
