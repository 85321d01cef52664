//! One method on one grid: its run, the trajectory as the atlas judges it, and the measurements on it.

use std::ops::Range;

use super::arena::Arena;
use super::status::{Sizes, judge, rough_above};
use super::{Cell, CellStatus, Method, Numbers, WINDOW};
use crate::case::{Form, SbpName, on_grid};
use crate::diagnostics::{Diagnostics, energy_off, sawtooth};
use crate::engine::Accuracy;
use crate::engine::Handed;
use crate::geometry::Start;
use crate::methods::{Failure, Output, Peer, Problem, Setting, Trajectory};
use crate::number::norm::{larger, max_abs};
use crate::solve::{Limit, NoSolution, Setup, Status, System, WorldLine, bytes_needed, solve};
use crate::study::subject::{norm_and_first_rate, rows, timed};

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
        let status = judge(&errors, &sawtooth, drift_of(&track.delta_k), &sizes, active);
        numbers.errors = Some(errors);
        (status, numbers)
    }

    /// Runs the method; `None` if there is no such grid.
    fn ran(&self, arena: &Arena) -> Option<Ran> {
        let (subject, place) = (&arena.subject, arena.subject.stretched(self.tangent));
        let wanted = (self.length / self.setting).round().max(1.0) as usize;
        let is_of_x = arena.geometry().c_squared.is_some();
        let whole = |nodes: usize| (wanted as f64 / nodes as f64).round().max(1.0) as usize;
        let dropped = Handed::default();
        let mut setup = Setup { place: place.clone(), rough: place, dropped, ..subject.plain.clone() };
        let solved = |setup: Setup| {
            let is_affordable = is_of_x || bytes_needed(&setup, false, 0) <= MOST_BYTES;
            is_affordable.then(|| solved(&setup, subject.is_lifted))
        };
        let (scheme, nodes) = match self.method {
            Method::Peer(peer) => return Some(self.integrated(arena, peer, wanted)),
            Method::Tolerance => return Some(self.integrated(arena, Peer::Tolerance, wanted)),
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
            Method::Unregularised(sbp) if wanted < MOST_UNREGULARISED && is_of_x => ((sbp, Form::Strong), wanted + 1),
            Method::Unregularised(_) | Method::March(_) | Method::Other(_) => return None,
        };
        let mut setup = on_grid(&setup, scheme, nodes, self.length).ok()?;
        if matches!(self.method, Method::Unregularised(_)) {
            (setup.settings.system, setup.settings.regularised) = (System::Doubled, false);
        }
        let spacing = self.length / intervals(&setup) as f64;
        let ratio = (spacing / self.setting).max(self.setting / spacing);
        if ratio <= SAME_SPACING { solved(setup) } else { None }
    }

    /// Runs one of [`crate::methods`], and measures it at the ends of all constant steps, or in even distances.
    fn integrated(&self, arena: &Arena, peer: Peer, wanted: usize) -> Ran {
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

/// A trajectory on its nodes, window by window.
struct Track {
    /// γ − γ_i.
    gamma: Vec<f64>,
    /// The coordinates, a row for each.
    q: Vec<Vec<f64>>,
    delta_k: Vec<f64>,
    /// Equidistant stretches of nodes.
    stretches: Vec<Range<usize>>,
    intervals: usize,
    iterations: Option<usize>,
    /// The measures that need no reference.
    numbers: Numbers,
}

impl Track {
    /// The track of a run of this program, which is the lift of Newton's law if `is_lifted`.
    fn of_line(line: &WorldLine, is_lifted: bool) -> Self {
        let Diagnostics { charges, norm, energy, .. } = Diagnostics::of(line, &[], &mut [], is_lifted);
        let delta_energy_max = energy.map(|energy| {
            let inside = line.windows.iter().map(|grid| max_abs(&energy.delta[grid.exact()])).fold(0.0, larger);
            larger(inside, energy.max_ends)
        });
        let (mut delta_k, mut stretches, mut intervals) = (norm.delta, Vec::new(), 0);
        for (grid, &at_end) in line.windows.iter().zip(&norm.ends) {
            // In the strong form Dq is no velocity at the last node of a window.
            let nodes = grid.nodes();
            delta_k[nodes.end - 1] = at_end;
            intervals += nodes.len() - 1;
            if grid.is_equidistant() {
                stretches.push(grid.exact());
            }
        }
        let is_block = line.form == Form::Strong && line.windows.len() == 1;
        let last = |row: &[f64]| row.last().copied().unwrap_or(f64::NAN);
        let last_node = charges.iter().map(|charge| [last(&charge.delta), last(&charge.corrected)]);
        let numbers = Numbers {
            delta_k_max: norm.max_interior,
            delta_energy_max,
            charges: Some(charges.iter().map(|charge| charge.max_interior).collect()),
            last_node: is_block.then(|| last_node.collect()),
            ..Numbers::default()
        };
        let (gamma, iterations) = (line.gamma_from_start().collect(), Some(line.iterations.count));
        Self { gamma, q: rows(line), delta_k, stretches, intervals, iterations, numbers }
    }

    /// The track of another method, whose states are known at equal distances. Between the ends of its steps, which
    /// have equal lengths only if `is_equidistant` says so, there is nothing of a sawtooth.
    fn of_states(problem: &Problem, found: &Trajectory, is_equidistant: bool, is_lifted: bool) -> Self {
        let Problem { space, start, length, .. } = problem;
        let mut q: Vec<Vec<f64>> = start.q.iter().map(|&q| vec![q]).collect();
        let k = space.norm(&start.q, &start.q_dot);
        let (mut delta_k, mut energy) = (vec![0.0], 0.0);
        for state in found.states.iter() {
            let [k_here, first_rate] = norm_and_first_rate(problem, state);
            let delta = k_here - k;
            if is_lifted {
                energy = larger(energy, energy_off(start, k + delta, first_rate).abs());
            }
            delta_k.push(delta);
            q.iter_mut().zip(state.q).for_each(|(row, q)| row.push(*q));
        }
        let count = delta_k.len();
        let numbers = Numbers {
            delta_k_max: delta_k.iter().fold(0.0, |most: f64, value| most.max(value.abs())),
            delta_energy_max: is_lifted.then_some(energy),
            ..Numbers::default()
        };
        Self {
            gamma: (0..count).map(|step| length * (step as f64 / (count - 1) as f64)).collect(),
            q,
            delta_k,
            stretches: is_equidistant.then_some(0..count).into_iter().collect(),
            intervals: found.steps,
            iterations: None,
            numbers,
        }
    }

    /// The largest error of each coordinate over the nodes.
    fn errors(&self, reference: &[Start]) -> Vec<f64> {
        let largest = |(a, row): (usize, &Vec<f64>)| {
            row.iter().zip(reference).fold(0.0, |most, (here, exact)| larger(most, (here - exact.q[a]).abs()))
        };
        self.q.iter().enumerate().map(largest).collect()
    }

    /// The amplitude of the (−1)^k component of a row of values on the nodes.
    fn sawtooth(&self, row: &[f64]) -> Option<f64> {
        self.stretches.iter().filter_map(|nodes| sawtooth(&row[nodes.clone()])).reduce(f64::max)
    }

    /// γ − γ_i where that of coordinate `a` first exceeds `threshold`.
    fn sawtooth_from(&self, a: usize, threshold: f64) -> Option<f64> {
        let first = |nodes: &Range<usize>| {
            let rough = |w: &[f64]| sawtooth(w).is_some_and(|amplitude| amplitude > threshold);
            self.q[a][nodes.clone()].windows(5).position(rough).map(|k| self.gamma[nodes.start + k + 2])
        };
        self.stretches.iter().find_map(first)
    }
}

/// The mean over the last quarter of these values minus that over the first quarter.
fn drift_of(values: &[f64]) -> f64 {
    let quarter = (values.len() / 4).max(1).min(values.len());
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    mean(&values[values.len() - quarter..]) - mean(&values[..quarter])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drift_is_the_difference_of_the_quarters_at_the_ends() {
        assert_eq!(drift_of(&[1.0, 3.0, 9.0, 9.0, 9.0, 9.0, 5.0, 6.0]), 3.5);
        assert_eq!((drift_of(&[1.0, 4.0]), drift_of(&[7.0; 9])), (3.0, 0.0));
    }
}
