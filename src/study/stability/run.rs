//! One method on one grid: its run, and the measurements on its result.

use std::time::Instant;

use super::method::{Method, WINDOW};
use super::scene::Scene;
use super::status::{CellStatus, Evidence, ROUGHER, SAWTOOTH, Sizes, judge};
use super::{Cell, Numbers};
use crate::case::{Case, Decimal, Form, Scheme, System};
use crate::diagnostics::{Diagnostics, sawtooth};
use crate::geodesic::Invariants;
use crate::methods::{Failure, Output, Problem, Setting, State, Trajectory};
use crate::norm::larger;
use crate::solve::{NoSolution, Solution, Status, solve};

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
    /// γ_f − γ_i, and ṫ_i in units of the case's.
    pub(super) length: f64,
    pub(super) tangent: f64,
    /// Δγ, or for adaptive methods the tolerance.
    pub(super) setting: f64,
}

/// A trajectory on its nodes, window by window.
struct Track {
    gamma: Vec<f64>,
    t: Vec<f64>,
    x: Vec<f64>,
    delta_k: Vec<f64>,
    /// Equidistant stretches of nodes.
    stretches: Vec<std::ops::Range<usize>>,
    intervals: usize,
    delta_k_max: f64,
    delta_q_t_max: Option<f64>,
    last_node: Option<[f64; 2]>,
    iterations: Option<usize>,
}

/// Why there is no trajectory.
struct Failed {
    status: CellStatus,
    iterations: Option<usize>,
}

impl Job {
    /// Runs and measures the cell of this grid; `None` if the method has no such grid.
    pub(super) fn measure(&self, scene: &Scene) -> Option<Cell> {
        let wanted = (self.length / self.setting).round().max(1.0) as usize;
        let case = if self.method.is_own() { Some(self.case(scene, wanted)?) } else { None };
        let start = Instant::now();
        let result = match (&self.method, &case) {
            (Method::Peer(peer), _) => {
                let (output, setting) = self.output(scene, wanted);
                let result = peer.run(&self.problem(scene), &output, setting);
                self.steps(scene, result)
            }
            (_, Some(case)) => match solve::<f64>(case) {
                Ok(solution) => Ok(Solved::Own(Box::new(solution))),
                Err(failure) => Err(failed(&failure)),
            },
            (_, None) => return None,
        };
        let seconds = start.elapsed().as_secs_f64();
        let planned = case.as_ref().map_or(wanted, |case| case.grid.windows * case.grid.n_gamma.saturating_sub(1));
        let planned = if self.method.is_adaptive() { 0 } else { planned };
        let track = result.map(|solved| match solved {
            Solved::Own(solution) => Track::of_solution(&solution),
            Solved::Other(track) => track,
        });
        let sizes = scene.sizes(self.length * self.tangent);
        Some(self.cell(scene, track, sizes, planned, seconds))
    }

    fn cell(
        &self,
        scene: &Scene,
        track: Result<Track, Failed>,
        sizes: Option<Sizes>,
        planned: usize,
        seconds: f64,
    ) -> Cell {
        let (status, numbers, intervals, iterations) = match track {
            Err(Failed { status, iterations }) => (status, None, planned, iterations),
            Ok(track) => {
                let (status, numbers) = self.judged(scene, &track, sizes);
                (status, Some(numbers), track.intervals, track.iterations)
            }
        };
        let delta_gamma = (intervals > 0).then(|| self.length / intervals as f64);
        Cell {
            method: self.method.clone(),
            setting: self.setting,
            n_gamma: (intervals > 0).then_some(intervals + 1),
            gamma_f: self.length,
            t_dot: scene.initial.t_dot * self.tangent,
            delta_gamma_omega: delta_gamma.map(|delta_gamma| delta_gamma * (scene.omega() * self.tangent)),
            status,
            numbers,
            iterations,
            seconds,
        }
    }

    fn judged(&self, scene: &Scene, track: &Track, sizes: Option<Sizes>) -> (CellStatus, Numbers) {
        let reference: Option<Vec<_>> = track.gamma.iter().map(|gamma| scene.at(gamma * self.tangent)).collect();
        let (mut evidence, mut from) = (Evidence { k_drift: k_drift(&track.delta_k), ..Evidence::default() }, None);
        if let (Some(reference), Some(sizes)) = (&reference, &sizes) {
            let errors = reference.iter().zip(track.t.iter().zip(&track.x));
            let largest = |[x, t]: [f64; 2], (exact, (&t_here, &x_here)): (&_, (&f64, &f64))| {
                let exact: &crate::reference::ReferencePoint = exact;
                [larger(x, (x_here - exact.x).abs()), larger(t, (t_here - exact.elapsed).abs())]
            };
            evidence.errors = Some(errors.fold([0.0; 2], largest));
            let smooth: Vec<f64> = reference.iter().map(|point| point.x).collect();
            let most =
                |x: &[f64]| track.stretches.iter().filter_map(|nodes| sawtooth(&x[nodes.clone()])).reduce(f64::max);
            evidence.sawtooth = most(&track.x).zip(most(&smooth)).map(|(here, there)| [here, there]);
            if let Some([_, smooth]) = evidence.sawtooth {
                from = track.sawtooth_from((SAWTOOTH * sizes.x).max(ROUGHER * smooth));
            }
        }
        let status = match sizes {
            Some(Sizes { x, t, k }) => judge(&evidence, &Sizes { x, t, k: k * self.tangent * self.tangent }),
            None => CellStatus::Inaccurate,
        };
        let amplitude =
            || track.stretches.iter().filter_map(|nodes| sawtooth(&track.x[nodes.clone()])).reduce(f64::max);
        let numbers = Numbers {
            delta_k_max: track.delta_k_max,
            delta_q_t_max: track.delta_q_t_max,
            error_x_max: evidence.errors.map(|[x, _]| x),
            error_t_max: evidence.errors.map(|[_, t]| t),
            sawtooth: evidence.sawtooth.map_or_else(amplitude, |[here, _]| Some(here)),
            sawtooth_from: from,
            last_node: track.last_node,
        };
        (status, numbers)
    }

    /// The case of this grid, for a scheme of this program; `None` if there is no such grid.
    fn case(&self, scene: &Scene, wanted: usize) -> Option<Case> {
        let mut case = scene.case.clone();
        if self.tangent != 1.0 {
            let initial = scene.initial;
            case.initial.t_dot = Decimal::from(initial.t_dot * self.tangent);
            (case.initial.x_dot, case.initial.velocity) = (Some(Decimal::from(initial.x_dot * self.tangent)), None);
        }
        let on_grid = |case: &Case, sbp, form, nodes| case.on_grid((sbp, form), nodes, self.length).ok();
        let case = match self.method {
            Method::Block(sbp, form) => on_grid(&case, sbp, form, wanted + 1)?,
            Method::Windows(sbp, form) => {
                case.grid.windows = (wanted as f64 / WINDOW as f64).round().max(1.0) as usize;
                on_grid(&case, sbp, form, WINDOW + 1)?
            }
            Method::Elements(nodes, form) => {
                let windows = (wanted as f64 / (nodes - 1) as f64).round().max(1.0) as usize;
                on_grid(&case, crate::case::SbpName::Gll(nodes as u8), form, windows * (nodes - 1) + 1)?
            }
            Method::Unregularised(sbp) if wanted < MOST_UNREGULARISED => {
                let mut case = on_grid(&case, sbp, Form::Strong, wanted + 1)?;
                case.solver.system = System::Doubled;
                case.scheme.regularised = false;
                case
            }
            Method::Accuracy => {
                let mut case = on_grid(&case, Scheme::default().sbp, Form::Weak, 24)?;
                case.scheme = Scheme::default();
                case.solver.accuracy = Some(Decimal::from(self.setting));
                case.grid.n_gamma = 0;
                return Some(case);
            }
            _ => return None,
        };
        let spacing = self.length / (case.grid.windows * (case.grid.n_gamma - 1)) as f64;
        let ratio = (spacing / self.setting).max(self.setting / spacing);
        (ratio <= SAME_SPACING).then_some(case)
    }

    /// Where one of [`crate::methods`] is measured, and its setting: constant steps at the ends of all of them.
    fn output(&self, scene: &Scene, wanted: usize) -> (Output, Setting) {
        if !self.method.is_adaptive() {
            return (Output::even(wanted), Setting::steps(wanted));
        }
        let every = OUTPUT_EVERY / (scene.pace() * self.tangent);
        let output = Output::even((self.length / every).ceil().clamp(8.0, MOST_OUTPUTS) as usize);
        (output, Setting::tolerance(self.setting))
    }

    /// The same world-line as a problem for [`crate::methods`].
    fn problem(&self, scene: &Scene) -> Problem {
        let mut initial = scene.initial;
        initial.t_dot *= self.tangent;
        initial.x_dot *= self.tangent;
        Problem { metric: scene.metric.clone(), initial, length: self.length }
    }

    /// The result of one of [`crate::methods`].
    fn steps(&self, scene: &Scene, result: Result<Trajectory, Failure>) -> Result<Solved, Failed> {
        let problem = self.problem(scene);
        let (states, intervals) = match result {
            Ok(Trajectory { states, steps, .. }) => (states, steps),
            Err(failure) => {
                let status = match failure {
                    Failure::OutsideDomain => CellStatus::OutsideDomain,
                    Failure::Diverged => CellStatus::Diverged,
                    Failure::TooManySteps | Failure::NotConverged | Failure::NotSeparable => {
                        CellStatus::NoCriticalPoint
                    }
                };
                return Err(Failed { status, iterations: None });
            }
        };
        let Invariants { q_t, k } = problem.initial.invariants(&problem.metric);
        let begin = State { elapsed: 0.0, x: problem.initial.x, w: problem.initial.x_dot };
        let all: Vec<State> = std::iter::once(begin).chain(states).collect();
        let delta_k = |state: &State| q_t * (q_t / problem.metric.at(state.x).g00) - state.w * state.w - k;
        let delta_k: Vec<f64> = all.iter().map(delta_k).collect();
        let count = all.len();
        let equidistant = !self.method.is_adaptive();
        Ok(Solved::Other(Track {
            gamma: (0..count).map(|step| self.length * (step as f64 / (count - 1) as f64)).collect(),
            t: all.iter().map(|state| state.elapsed).collect(),
            x: all.iter().map(|state| state.x).collect(),
            delta_k_max: delta_k.iter().fold(0.0, |most: f64, value| most.max(value.abs())),
            delta_k,
            stretches: equidistant.then_some(0..count).into_iter().collect(),
            intervals,
            delta_q_t_max: None,
            last_node: None,
            iterations: None,
        }))
    }
}

/// A result as the timed run returns it.
enum Solved {
    Own(Box<Solution>),
    Other(Track),
}

fn failed(failure: &NoSolution) -> Failed {
    let status = match failure.status {
        Status::OutsideDomain => CellStatus::OutsideDomain,
        _ => CellStatus::NoCriticalPoint,
    };
    Failed { status, iterations: Some(failure.history.len()) }
}

impl Track {
    fn of_solution(solution: &Solution) -> Self {
        let Diagnostics { charges, measures, .. } = Diagnostics::new(solution);
        let mut delta_k = charges.delta_k;
        let (mut stretches, mut intervals) = (Vec::new(), 0);
        for (view, &at_end) in solution.views().zip(&charges.delta_k_ends) {
            // In the strong form, Dt and Dx are not velocities at the last node of a window. There ΔK is that of the
            // values with which the next window starts.
            let nodes = view.grid.nodes();
            delta_k[nodes.end - 1] = at_end;
            intervals += nodes.len() - 1;
            if view.grid.is_equidistant() {
                stretches.push(view.grid.exact());
            }
        }
        let corrected = charges.delta_q_t_corrected.last().copied();
        let single = solution.form == Form::Strong && solution.windows.len() == 1;
        Self {
            gamma: solution.gamma_from_start().collect(),
            t: solution.time_from_start(&solution.elapsed).collect(),
            x: solution.x.clone(),
            delta_k,
            stretches,
            intervals,
            delta_k_max: measures.max_abs_delta_k,
            delta_q_t_max: Some(measures.max_abs_delta_q_t_interior),
            last_node: corrected.filter(|_| single).map(|corrected| [measures.delta_q_t_last, corrected]),
            iterations: Some(solution.iterations),
        }
    }

    /// γ − γ_i where the amplitude of the (−1)^k component of x first exceeds `threshold`.
    fn sawtooth_from(&self, threshold: f64) -> Option<f64> {
        let first = |nodes: &std::ops::Range<usize>| {
            let rough = |w: &[f64]| sawtooth(w).is_some_and(|amplitude| amplitude > threshold);
            self.x[nodes.clone()].windows(5).position(rough).map(|k| self.gamma[nodes.start + k + 2])
        };
        self.stretches.iter().find_map(first)
    }
}

/// The mean of ΔK over the last quarter of the nodes minus that over the first quarter.
fn k_drift(delta_k: &[f64]) -> f64 {
    let quarter = (delta_k.len() / 4).max(1).min(delta_k.len());
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    mean(&delta_k[delta_k.len() - quarter..]) - mean(&delta_k[..quarter])
}
