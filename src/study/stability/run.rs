//! One method on one grid: its run, and the measurements on its result.

use super::arena::Arena;
use super::method::{Method, WINDOW};
use super::status::{Sizes, judge, rough_above};
use super::track::Track;
use super::{Cell, CellStatus, Numbers};
use crate::case::{Form, SbpName, on_grid};
use crate::engine::Accuracy;
use crate::geometry::Start;
use crate::methods::{Output, Peer, Problem, Setting, Windows};
use crate::solve::{Limit, NoSolution, Setup, System, bytes_needed, solve};
use crate::study::subject::timed;

/// As the numbers of elements and windows are whole, the spacing can differ from the one that was asked for. If it does
/// by more than this factor, there is no cell.
const SAME_SPACING: f64 = 1.25;
/// A grid whose linear systems need more bytes than this is left out: several cells are computed at once.
const MOST_BYTES: f64 = 1e9;
/// The doubled action without the regularisation is tried on at most this many nodes.
const MOST_UNREGULARISED: usize = 200;
/// The distance of the points at which adaptive methods are measured, in radians of the fastest oscillation, and the
/// largest number of these points.
const OUTPUT_EVERY: f64 = 2.0;
const MOST_OUTPUTS: f64 = 10_000.0;

/// A run, ready to be timed.
enum Ready {
    /// A scheme of this program.
    Scheme(Box<Setup>),
    Other(&'static dyn Peer, Problem, Output, Setting),
}

/// A method, and the grid that is asked for.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Job {
    pub(super) method: Method,
    /// γ_f − γ_i, and the tangent at the start in units of the case's.
    pub(super) length: f64,
    pub(super) tangent: f64,
    /// Δγ, or for adaptive methods the tolerance.
    pub(super) setting: f64,
}

impl Job {
    /// Length of the world-line in the case's own parameter.
    pub(super) fn stretched(&self) -> f64 {
        self.length * self.tangent
    }

    /// Runs and measures the cell of this grid; `None` if the method has no such grid.
    pub(super) fn measure(&self, arena: &Arena, sizes: Option<&Sizes>) -> Option<Cell> {
        let is_lifted = arena.subject.is_lifted;
        let (track, grid, seconds) = match self.ready(arena)? {
            Ready::Scheme(setup) => {
                let (line, seconds) = timed(|| solve(&*setup));
                let failed = |failure: NoSolution| {
                    (CellStatus::of_solve(failure.status), Some(failure.iterations.history.len()))
                };
                (line.map(|line| Track::of_line(&line, is_lifted)).map_err(failed), intervals(&setup), seconds)
            }
            Ready::Other(peer, problem, output, setting) => {
                let (found, seconds) = timed(|| peer.run(&problem, &output, setting));
                let track = found.map(|found| Track::of_states(&problem, &found, setting.count > 0, is_lifted));
                (track.map_err(|failure| (CellStatus::of_method(failure), None)), setting.count, seconds)
            }
        };
        let (status, numbers, intervals, iterations) = match track {
            Err((status, iterations)) => (status, None, grid, iterations),
            Ok(track) => {
                let (intervals, iterations) = (track.intervals, track.iterations);
                let (status, numbers) = self.judged(arena, track, sizes);
                (status, Some(numbers), intervals, iterations)
            }
        };
        let delta_gamma = (intervals > 0).then(|| self.length / intervals as f64);
        Some(Cell {
            method: self.method.clone(),
            setting: self.setting,
            n_gamma: (intervals > 0).then_some(intervals + 1),
            gamma_f: self.length,
            t_dot: arena.t_dot().map(|t_dot| t_dot * self.tangent),
            tangent: self.tangent,
            delta_gamma_omega: delta_gamma.map(|delta_gamma| delta_gamma * (arena.omega() * self.tangent)),
            status,
            numbers,
            iterations,
            seconds,
        })
    }

    /// The status of a track, and all that is measured on it.
    fn judged(&self, arena: &Arena, mut track: Track, sizes: Option<&Sizes>) -> (CellStatus, Numbers) {
        let active = arena.geometry().active();
        let (mut status, mut numbers) = (CellStatus::Inaccurate, std::mem::take(&mut track.numbers));
        numbers.sawtooth = track.roughest(active, sizes).and_then(|a| track.sawtooth(&track.q[a]));
        let reference: Option<Vec<Start>> = track.gamma.iter().map(|gamma| arena.at(gamma * self.tangent)).collect();
        if let (Some(reference), Some(sizes)) = (reference, sizes) {
            let (errors, mut sawtooth) = (track.errors(&reference), Vec::new());
            for &a in active {
                let smooth: Vec<f64> = reference.iter().map(|point| point.q[a]).collect();
                let Some(both) = track.sawtooth(&track.q[a]).zip(track.sawtooth(&smooth)) else { continue };
                sawtooth.push((a, both.into()));
                let here = track.sawtooth_from(a, rough_above(sizes.q[a], both.1));
                numbers.sawtooth_from = [numbers.sawtooth_from, here].into_iter().flatten().reduce(f64::min);
            }
            let sizes = Sizes { k: sizes.k * self.tangent * self.tangent, ..sizes.clone() };
            status = judge(&errors, &sawtooth, track.k_drift(), &sizes, active);
            numbers.errors = Some(errors);
        }
        (status, numbers)
    }

    /// The run; `None` if there is no such grid.
    fn ready(&self, arena: &Arena) -> Option<Ready> {
        let (subject, place) = (&arena.subject, arena.subject.stretched(self.tangent));
        let wanted = (self.length / self.setting).round().max(1.0) as usize;
        let whole = |nodes: usize| (wanted as f64 / nodes as f64).round().max(1.0) as usize;
        let other = |peer: &'static dyn Peer| {
            let (output, setting) = self.output(arena, wanted);
            Some(Ready::Other(peer, subject.problem(&place, self.length), output, setting))
        };
        let mut setup = Setup { place: place.clone(), rough: place.clone(), ..subject.plain.clone() };
        let is_affordable = |setup: &Setup| !subject.is_scene || bytes_needed(setup, false, 0) <= MOST_BYTES;
        let (scheme, nodes) = match self.method {
            Method::Peer(peer) => return other(peer),
            Method::Tolerance => return other(&Windows::Tolerance),
            Method::Accuracy => {
                (setup.limit, setup.until) = (Limit::Length(self.length), Vec::new());
                setup.settings.accuracy = Some(Accuracy::Promised(self.setting));
                return is_affordable(&setup).then(|| Ready::Scheme(setup.into()));
            }
            Method::Block(sbp, form) => ((sbp, form), wanted + 1),
            Method::Windows(sbp, form) => {
                setup.settings.windows = whole(WINDOW);
                ((sbp, form), WINDOW + 1)
            }
            Method::Elements(nodes, form) => ((SbpName::Gll(nodes as u8), form), whole(nodes - 1) * (nodes - 1) + 1),
            Method::Unregularised(sbp) if wanted < MOST_UNREGULARISED && !subject.is_scene => {
                ((sbp, Form::Strong), wanted + 1)
            }
            Method::Unregularised(_) => return None,
        };
        let mut setup = on_grid(&setup, scheme, nodes, self.length).ok()?;
        if matches!(self.method, Method::Unregularised(_)) {
            (setup.settings.system, setup.regularised) = (System::Doubled, false);
        }
        let spacing = self.length / intervals(&setup) as f64;
        let ratio = (spacing / self.setting).max(self.setting / spacing);
        (is_affordable(&setup) && ratio <= SAME_SPACING).then(|| Ready::Scheme(setup.into()))
    }

    /// Where one of [`crate::methods`] is measured, and its setting: constant steps at the ends of all of them.
    fn output(&self, arena: &Arena, wanted: usize) -> (Output, Setting) {
        if !self.method.is_adaptive() {
            return (Output::even(wanted), Setting::steps(wanted));
        }
        let every = OUTPUT_EVERY / (arena.pace().rate() * self.tangent);
        let output = Output::even((self.length / every).ceil().clamp(8.0, MOST_OUTPUTS) as usize);
        (output, Setting::tolerance(self.setting))
    }
}

/// The intervals of a grid; 0 where it is chosen for an accuracy.
fn intervals(setup: &Setup) -> usize {
    let settings = &setup.settings;
    if settings.accuracy.is_some() { 0 } else { settings.windows * (settings.n_gamma - 1) }
}
