//! The world-line of a case of one coordinate. Its coordinates are t, counted from the start, and x.

use super::status::Sizes;
use super::track::Track;
use super::world::{Grid, Measured, Point, Range, Reference, Task, World};
use crate::case::{Case, Decimal, End, Form, Scheme, System};
use crate::diagnostics::Diagnostics;
use crate::geodesic::{InitialData, acceleration_slope};
use crate::methods::{Output, Peer, Problem, Setting, State, Trajectory};
use crate::metric::Metric;
use crate::reference::{ReferenceEnds, ReferenceTrajectory};
use crate::scalar::{Extended, Real};
use crate::solve::{Solution, solve};
use crate::study::work_precision::plain;

use super::arena::{DIGITS, amplitude, half_range, largest};

const X: usize = 1;

/// A case of one coordinate.
pub(super) struct One {
    /// The case without what belongs to one scheme only: its windows, its solver, its expectations and D in place of
    /// D̄.
    case: Case,
    metric: Metric,
    initial: InitialData,
    coordinates: [String; 2],
}

impl One {
    pub(super) fn new(case: &Case) -> Self {
        Self {
            case: plain(case),
            metric: case.metric(),
            initial: InitialData { t: 0.0, ..case.initial_data() },
            coordinates: ["t", "x"].map(str::to_owned),
        }
    }

    /// The case with another tangent.
    fn stretched(&self, tangent: f64) -> Case {
        let mut case = self.case.clone();
        if tangent != 1.0 {
            case.initial.t_dot = Decimal::from(self.initial.t_dot * tangent);
            (case.initial.x_dot, case.initial.velocity) = (Some(Decimal::from(self.initial.x_dot * tangent)), None);
        }
        case
    }

    /// The same world-line as a problem for [`crate::methods`].
    fn problem(&self, range: Range) -> Problem {
        let mut initial = self.initial;
        initial.t_dot *= range.tangent;
        initial.x_dot *= range.tangent;
        Problem { space: self.metric.clone().into(), start: initial, length: range.length }
    }
}

impl World for One {
    fn is_scene(&self) -> bool {
        false
    }

    fn has_energy(&self) -> bool {
        false
    }

    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn active(&self) -> &[usize] {
        &[X]
    }

    fn origin(&self) -> Vec<f64> {
        vec![0.0; 2]
    }

    fn own_length(&self) -> Result<f64, ReferenceEnds> {
        Ok(match self.case.end() {
            End::Length(length) => length,
            End::Duration(duration) => {
                ReferenceTrajectory::length_of(&self.metric, &self.initial, 0, duration, f64::MOST_DIGITS)?
            }
        })
    }

    fn reference(&self, length: f64, is_extended: bool) -> Result<Box<dyn Reference>, ReferenceEnds> {
        if !is_extended {
            let (metric, initial) = (&self.metric, self.initial);
            return Ok(Box::new(ReferenceTrajectory::new(metric, &initial, length, f64::MOST_DIGITS)?));
        }
        let (metric, initial) = (self.case.metric(), self.case.initial_data::<Extended>());
        let initial = InitialData { t: Extended::ZERO, ..initial };
        Ok(Box::new(ReferenceTrajectory::new(&metric, &initial, length.into(), DIGITS)?))
    }

    fn rates(&self, points: &[Point]) -> [f64; 2] {
        let q_t = self.initial.invariants(&self.metric).q_t;
        let slope = |point: &Point| {
            let jet = self.metric.at(point.q[X]);
            acceleration_slope(q_t, jet.g00, jet.first, jet.second)
        };
        let slopes: Vec<f64> = points.iter().map(slope).filter(|slope| slope.is_finite()).collect();
        // ω² = −dẍ/dx where that is positive.
        [-1.0, 1.0].map(|sign: f64| slopes.iter().fold(0.0_f64, |most, slope| most.max(sign * slope)).sqrt())
    }

    fn sizes(&self, points: &[Point], _: f64) -> Sizes {
        let far = largest(points, |p| p.q[X]);
        let x = amplitude(half_range(points, X), far);
        let (speed, x_dot) = (largest(points, |p| p.q_dot[X] / p.q_dot[0]), largest(points, |p| p.q_dot[X]));
        let duration = points.last().map_or(0.0, |end| end.q[0].abs());
        let t = if speed > 0.0 { duration.min(x / speed) } else { duration };
        let k = if x_dot > 0.0 { x_dot * x_dot } else { self.initial.invariants(&self.metric).k.abs() };
        Sizes { q: vec![t, x], k }
    }

    fn t_dot(&self) -> Option<f64> {
        Some(self.initial.t_dot)
    }

    fn scheme(&self, grid: &Grid, Range { length, tangent }: Range) -> Option<Task<'_>> {
        let mut case = self.stretched(tangent);
        let case = match *grid {
            Grid::Nodes { scheme, nodes, windows } => {
                case.grid.windows = windows;
                case.on_grid(scheme, nodes, length).ok()?
            }
            Grid::Unregularised(sbp, nodes) => {
                let mut case = case.on_grid((sbp, Form::Strong), nodes, length).ok()?;
                case.solver.system = System::Doubled;
                case.scheme.regularised = false;
                case
            }
            Grid::Accuracy(accuracy) => {
                let mut case = case.on_grid((Scheme::default().sbp, Form::Weak), 24, length).ok()?;
                case.scheme = Scheme::default();
                case.solver.accuracy = Some(Decimal::from(accuracy));
                case.grid.n_gamma = 0;
                case
            }
        };
        let intervals = case.grid.windows * case.grid.n_gamma.saturating_sub(1);
        let run = move || {
            let solution = solve::<f64, _>(&case)?;
            Ok(Box::new(move || track_of(&solution)) as Measured<'_>)
        };
        Some(Task { intervals, run: Box::new(run) })
    }

    fn other(&self, peer: &'static dyn Peer, range: Range, output: Output, setting: Setting) -> Task<'_> {
        let run = move || {
            let problem = self.problem(range);
            let Trajectory { states, steps, .. } = peer.run(&problem, &output, setting)?;
            Ok(Box::new(move || track_of_states(&problem, states, steps, setting.count > 0)) as Measured<'_>)
        };
        Task { intervals: setting.count, run: Box::new(run) }
    }
}

fn track_of(solution: &Solution) -> Track {
    let Diagnostics { charges, measures, .. } = Diagnostics::new(solution);
    let (gamma, t) = (solution.gamma_from_start().collect(), solution.from_origin(0, solution.elapsed()).collect());
    let rows = (vec![t, solution.x().to_vec()], charges.delta_k);
    let delta_k = (charges.delta_k_ends.as_slice(), measures.max_abs_delta_k);
    let corrected = charges.delta_q_t_corrected.last().copied();
    let single = solution.form == Form::Strong && solution.windows.len() == 1;
    Track {
        charges: Some(vec![measures.max_abs_delta_q_t_interior]),
        last_node: corrected.filter(|_| single).map(|corrected| vec![[measures.delta_q_t_last, corrected]]),
        iterations: Some(solution.iterations.count),
        ..Track::of_windows(solution.grids(), gamma, rows, delta_k)
    }
}

fn track_of_states(problem: &Problem, states: Vec<State>, steps: usize, is_equidistant: bool) -> Track {
    let invariants = problem.start.invariants(&problem.space);
    let begin = State { elapsed: 0.0, x: problem.start.x, w: problem.start.x_dot };
    let all: Vec<State> = std::iter::once(begin).chain(states).collect();
    let q_t = invariants.q_t;
    let k = |state: &State| q_t * (q_t / problem.space.g00(state.x)) - state.w * state.w - invariants.k;
    let q = [|state: &State| state.elapsed, |state: &State| state.x].map(|of| all.iter().map(of).collect());
    Track::of_steps(problem.length, (q.to_vec(), all.iter().map(k).collect()), steps, is_equidistant)
}
