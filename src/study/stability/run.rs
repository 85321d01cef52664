//! One method on one grid: its run, and the measurements on its result.

use std::time::Instant;

use super::arena::Arena;
use super::method::{Method, WINDOW};
use super::status::{Evidence, Sizes, judge, rough_above};
use super::task::{Failed, Grid, Range, Task};
use super::track::Track;
use super::{Cell, CellStatus, Numbers};
use crate::case::SbpName;
use crate::methods::{Output, Setting, Windows};
use crate::study::space::Point;

/// As the numbers of elements and windows are whole, the spacing can differ from the one that was asked for. If it does
/// by more than this factor, there is no cell.
const SAME_SPACING: f64 = 1.25;
/// The doubled action without the regularisation is tried on at most this many nodes.
const MOST_UNREGULARISED: usize = 200;
/// The distance of the points at which adaptive methods are measured, in radians of the fastest oscillation, and the
/// largest number of these points.
const OUTPUT_EVERY: f64 = 2.0;
const MOST_OUTPUTS: f64 = 10_000.0;

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
        let Task { intervals, run } = self.task(arena)?;
        let start = Instant::now();
        let result = run();
        let seconds = start.elapsed().as_secs_f64();
        let (status, numbers, intervals, iterations) = match result {
            Err(Failed { status, iterations }) => (status, None, intervals, iterations),
            Ok(measured) => {
                let track = measured();
                let (status, numbers) = self.judged(arena, &track, sizes);
                (status, Some(numbers), track.intervals, track.iterations)
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

    fn judged(&self, arena: &Arena, track: &Track, sizes: Option<&Sizes>) -> (CellStatus, Numbers) {
        let active = arena.chart.active();
        let reference: Option<Vec<Point>> = track.gamma.iter().map(|gamma| arena.at(gamma * self.tangent)).collect();
        let (mut evidence, mut from) = (Evidence { k_drift: track.k_drift(), ..Evidence::default() }, None);
        if let (Some(reference), Some(sizes)) = (&reference, sizes) {
            evidence.errors = Some(track.errors(reference));
            for &a in active {
                let smooth: Vec<f64> = reference.iter().map(|point| point.q[a]).collect();
                let Some(both) = track.sawtooth(&track.q[a]).zip(track.sawtooth(&smooth)) else { continue };
                evidence.sawtooth.push((a, both.into()));
                let here = track.sawtooth_from(a, rough_above(sizes.q[a], both.1));
                from = [from, here].into_iter().flatten().reduce(f64::min);
            }
        }
        let status = match sizes {
            Some(sizes) => {
                let sizes = Sizes { k: sizes.k * self.tangent * self.tangent, ..sizes.clone() };
                judge(&evidence, &sizes, active)
            }
            None => CellStatus::Inaccurate,
        };
        let numbers = Numbers {
            delta_k_max: track.delta_k_max,
            delta_energy_max: track.delta_energy_max,
            charges: track.charges.clone(),
            errors: evidence.errors,
            sawtooth: track.roughest(active, sizes).and_then(|a| track.sawtooth(&track.q[a])),
            sawtooth_from: from,
            last_node: track.last_node.clone(),
        };
        (status, numbers)
    }

    /// The task to be run; `None` if there is no such grid.
    fn task<'a>(&self, arena: &'a Arena) -> Option<Task<'a>> {
        let range = Range { length: self.length, tangent: self.tangent };
        let wanted = (self.length / self.setting).round().max(1.0) as usize;
        let whole = |nodes: usize| (wanted as f64 / nodes as f64).round().max(1.0) as usize;
        let grid = match self.method {
            Method::Peer(peer) => {
                let (output, setting) = self.output(arena, wanted);
                return Some(arena.chart.other(peer, range, output, setting));
            }
            Method::Tolerance => {
                let (output, setting) = self.output(arena, wanted);
                return Some(arena.chart.other(&Windows::Tolerance, range, output, setting));
            }
            Method::Accuracy => return arena.chart.scheme(&Grid::Accuracy(self.setting), range),
            Method::Block(sbp, form) => Grid::Nodes { scheme: (sbp, form), nodes: wanted + 1, windows: 1 },
            Method::Windows(sbp, form) => {
                Grid::Nodes { scheme: (sbp, form), nodes: WINDOW + 1, windows: whole(WINDOW) }
            }
            Method::Elements(nodes, form) => {
                let scheme = (SbpName::Gll(nodes as u8), form);
                Grid::Nodes { scheme, nodes: whole(nodes - 1) * (nodes - 1) + 1, windows: 1 }
            }
            Method::Unregularised(sbp) if wanted < MOST_UNREGULARISED => Grid::Unregularised(sbp, wanted + 1),
            Method::Unregularised(_) => return None,
        };
        let task = arena.chart.scheme(&grid, range)?;
        let spacing = self.length / task.intervals as f64;
        let ratio = (spacing / self.setting).max(self.setting / spacing);
        (ratio <= SAME_SPACING).then_some(task)
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
