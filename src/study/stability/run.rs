//! One method on one grid: its run, and the measurements on its result.

use super::arena::Arena;
use super::status::{Sizes, judge, rough_above};
use super::track::Track;
use super::{Cell, CellStatus, Method, Numbers, WINDOW};
use crate::case::{Form, SbpName, on_grid};
use crate::engine::Accuracy;
use crate::geometry::Start;
use crate::methods::{Failure, Output, Peer, Setting, Windows};
use crate::solve::{Limit, NoSolution, Setup, Status, System, bytes_needed, solve};
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

/// The result of a run, or its status with the iterations; the intervals of its grid, and its seconds.
type Ran = (Result<Track, (CellStatus, Option<usize>)>, usize, f64);

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
        let (track, grid, seconds) = self.ran(arena)?;
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
    fn judged(&self, arena: &Arena, track: Track, sizes: Option<&Sizes>) -> (CellStatus, Numbers) {
        let active = arena.geometry().active();
        let rough: Vec<(usize, f64)> = active.iter().filter_map(|&a| Some((a, track.sawtooth(&track.q[a])?))).collect();
        let share = |&(a, amplitude): &(usize, f64)| amplitude / sizes.map_or(1.0, |sizes| sizes.q[a]);
        let roughest = rough.iter().max_by(|one, other| share(one).total_cmp(&share(other)));
        let mut numbers = Numbers { sawtooth: roughest.map(|(_, amplitude)| *amplitude), ..track.numbers.clone() };
        let reference: Option<Vec<Start>> = track.gamma.iter().map(|gamma| arena.at(gamma * self.tangent)).collect();
        let (Some(reference), Some(sizes)) = (reference, sizes) else { return (CellStatus::Inaccurate, numbers) };
        let (errors, mut sawtooth) = (track.errors(&reference), Vec::new());
        for (a, amplitude) in rough {
            let smooth: Vec<f64> = reference.iter().map(|point| point.q[a]).collect();
            let Some(smooth) = track.sawtooth(&smooth) else { continue };
            sawtooth.push((a, [amplitude, smooth]));
            let here = track.sawtooth_from(a, rough_above(sizes.q[a], smooth));
            numbers.sawtooth_from = [numbers.sawtooth_from, here].into_iter().flatten().reduce(f64::min);
        }
        let sizes = Sizes { k: sizes.k * self.tangent * self.tangent, ..sizes.clone() };
        let status = judge(&errors, &sawtooth, track.k_drift(), &sizes, active);
        numbers.errors = Some(errors);
        (status, numbers)
    }

    /// Runs the method; `None` if there is no such grid.
    fn ran(&self, arena: &Arena) -> Option<Ran> {
        let (subject, place) = (&arena.subject, arena.subject.stretched(self.tangent));
        let wanted = (self.length / self.setting).round().max(1.0) as usize;
        let whole = |nodes: usize| (wanted as f64 / nodes as f64).round().max(1.0) as usize;
        let mut setup = Setup { place: place.clone(), rough: place, ..subject.plain.clone() };
        let solved = |setup: Setup| {
            let is_affordable = !subject.is_scene || bytes_needed(&setup, false, 0) <= MOST_BYTES;
            is_affordable.then(|| solved(&setup, subject.is_lifted))
        };
        let (scheme, nodes) = match self.method {
            Method::Peer(peer) => return Some(self.integrated(arena, peer, wanted)),
            Method::Tolerance => return Some(self.integrated(arena, &Windows::Tolerance, wanted)),
            Method::Accuracy => {
                (setup.limit, setup.until) = (Limit::Length(self.length), Vec::new());
                setup.settings.accuracy = Some(Accuracy::Promised(self.setting));
                return solved(setup);
            }
            Method::Block(sbp, form) => ((sbp, form), wanted + 1),
            Method::Windows(sbp, form) => {
                setup.settings.windows = whole(WINDOW);
                ((sbp, form), WINDOW + 1)
            }
            Method::Elements(nodes) => ((SbpName::Gll(nodes as u8), Form::Weak), whole(nodes - 1) * (nodes - 1) + 1),
            Method::Unregularised(sbp) if wanted < MOST_UNREGULARISED && !subject.is_scene => {
                ((sbp, Form::Strong), wanted + 1)
            }
            Method::Unregularised(_) | Method::March(_) | Method::Other(_) => return None,
        };
        let mut setup = on_grid(&setup, scheme, nodes, self.length).ok()?;
        if matches!(self.method, Method::Unregularised(_)) {
            (setup.settings.system, setup.regularised) = (System::Doubled, false);
        }
        let spacing = self.length / intervals(&setup) as f64;
        let ratio = (spacing / self.setting).max(self.setting / spacing);
        if ratio <= SAME_SPACING { solved(setup) } else { None }
    }

    /// Runs one of [`crate::methods`], and measures it at the ends of all constant steps, or in even distances.
    fn integrated(&self, arena: &Arena, peer: &dyn Peer, wanted: usize) -> Ran {
        let subject = &arena.subject;
        let (intervals, setting) = if self.method.is_adaptive() {
            let every = OUTPUT_EVERY / (arena.pace.rate() * self.tangent);
            ((self.length / every).ceil().clamp(8.0, MOST_OUTPUTS) as usize, Setting::tolerance(self.setting))
        } else {
            (wanted, Setting::steps(wanted))
        };
        let problem = subject.problem(&subject.stretched(self.tangent), self.length);
        let (found, seconds) = timed(|| peer.run(&problem, &Output::even(intervals), setting));
        let status = |failure: Failure| match failure {
            Failure::OutsideDomain => CellStatus::OutsideDomain,
            Failure::Diverged => CellStatus::Diverged,
            _ => CellStatus::NoCriticalPoint,
        };
        let track = found.map(|found| Track::of_states(&problem, &found, setting.count > 0, subject.is_lifted));
        (track.map_err(|failure| (status(failure), None)), setting.count, seconds)
    }
}

/// Solves a scheme of this program.
fn solved(setup: &Setup, is_lifted: bool) -> Ran {
    let (line, seconds) = timed(|| solve(setup));
    let failed = |NoSolution { status, iterations, .. }: NoSolution| match status {
        Status::OutsideDomain => (CellStatus::OutsideDomain, Some(iterations.history.len())),
        _ => (CellStatus::NoCriticalPoint, Some(iterations.history.len())),
    };
    (line.map(|line| Track::of_line(&line, is_lifted)).map_err(failed), intervals(setup), seconds)
}

/// The intervals of a grid; 0 where it is chosen for an accuracy.
fn intervals(setup: &Setup) -> usize {
    let settings = &setup.settings;
    if settings.accuracy.is_some() { 0 } else { settings.windows * (settings.n_gamma - 1) }
}
