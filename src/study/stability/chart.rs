//! The world-line of a case in any space-time.

use std::sync::Arc;

use super::arena::DIGITS;
use super::frequency::Linearised;
use super::sizes::sizes;
use super::status::Sizes;
use super::task::{Grid, Measured, Range, Reference, Task};
use super::track::Track;
use crate::action::Form;
use crate::case::on_grid;
use crate::diagnostics::energy_off;
use crate::engine::Accuracy;
use crate::geometry::Start;
use crate::methods::{Output, Peer, Problem, Setting, States, Trajectory};
use crate::number::Real;
use crate::number::norm::larger;
use crate::reference::ReferenceEnds;
use crate::solve::{Limit, Place, Setup, System, WorldLine, bytes_needed, solve};
use crate::study::line::{Judged, Line, judged};
use crate::study::space::{self, Point};

/// A grid whose linear systems need more bytes than this is left out: several cells are computed at once.
const MOST_BYTES: f64 = 1e9;

/// A world-line to be charted.
pub(super) struct Chart {
    line: Line,
    coordinates: Vec<String>,
}

impl Chart {
    pub(super) fn new(line: Line) -> Self {
        Self { coordinates: line.own.place.geometry.names().to_vec(), line }
    }

    fn place(&self) -> &Place {
        &self.line.plain.place
    }

    fn track_of(&self, line: &WorldLine) -> Track {
        let found = space::deviations(line, self.line.is_lifted);
        let single = line.form == Form::Strong && line.windows.len() == 1;
        let gamma = line.gamma_from_start().collect();
        let rows = (space::rows(line), found.delta_k);
        Track {
            delta_energy_max: found.energy_max,
            charges: Some(found.charges),
            last_node: single.then_some(found.last_node),
            iterations: Some(line.iterations.count),
            ..Track::of_windows(line.grids(), gamma, rows, (&found.delta_k_ends, found.delta_k_max))
        }
    }

    fn track_of_states(&self, problem: &Problem, states: &States, steps: usize, is_equidistant: bool) -> Track {
        let start = &problem.start;
        let mut q: Vec<Vec<f64>> = start.q.iter().map(|&q| vec![q]).collect();
        let k = problem.space.norm(&start.q, &start.q_dot);
        let (mut delta_k, mut energy) = (vec![0.0], 0.0);
        for state in states.iter() {
            let Judged { q: here, k: k_here, q0_dot } = judged(problem, state);
            let delta = k_here - k;
            if self.line.is_lifted {
                energy = larger(energy, energy_off(start, k + delta, q0_dot).abs());
            }
            delta_k.push(delta);
            q.iter_mut().zip(here).for_each(|(row, q)| row.push(q));
        }
        Track {
            delta_energy_max: self.line.is_lifted.then_some(energy),
            ..Track::of_steps(problem.length, (q, delta_k), steps, is_equidistant)
        }
    }

    /// The place with another tangent, in units of its own.
    fn stretched(&self, tangent: f64) -> Place {
        let Place { geometry, start } = self.place();
        if tangent == 1.0 {
            return self.place().clone();
        }
        let q_dot: Vec<f64> = start.q_dot.iter().map(|rate| rate * tangent).collect();
        let p = geometry.momenta(&start.q, &q_dot);
        Place { geometry: Arc::clone(geometry), start: Arc::new(Start { q: start.q.clone(), q_dot, p }) }
    }

    /// The settings of a solver for a grid; `None` if there is no such grid.
    fn on(&self, grid: &Grid, Range { length, tangent }: Range) -> Option<Setup> {
        let place = self.stretched(tangent);
        let mut setup = Setup { place: place.clone(), rough: place, ..self.line.plain.clone() };
        match *grid {
            Grid::Nodes { scheme, nodes, windows } => {
                setup.settings.windows = windows;
                on_grid(&setup, scheme, nodes, length).ok()
            }
            Grid::Unregularised(..) if self.line.is_scene => None,
            Grid::Unregularised(sbp, nodes) => {
                let mut setup = on_grid(&setup, (sbp, Form::Strong), nodes, length).ok()?;
                (setup.settings.system, setup.regularised) = (System::Doubled, false);
                Some(setup)
            }
            Grid::Accuracy(accuracy) => {
                (setup.limit, setup.until) = (Limit::Length(length), Vec::new());
                setup.settings.accuracy = Some(Accuracy::Promised(accuracy));
                Some(setup)
            }
        }
    }
    /// Returns true if it is that of a scene.
    pub(super) fn is_scene(&self) -> bool {
        self.line.is_scene
    }

    /// Returns true if it is the lift of Newton's law, which has an energy.
    pub(super) fn has_energy(&self) -> bool {
        self.line.is_lifted
    }

    /// The names of the coordinates.
    pub(super) fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    /// The coordinates that the equations depend on.
    pub(super) fn active(&self) -> &[usize] {
        self.place().geometry.active()
    }

    /// The origin of the coordinates of a [`Point`] when the reference estimates its error.
    pub(super) fn origin(&self) -> Vec<f64> {
        let mut origin = self.place().start.q.clone();
        self.active().iter().for_each(|&a| origin[a] = 0.0);
        origin
    }

    /// γ_f − γ_i of the case.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if the world-line does not get to its end.
    pub(super) fn own_length(&self) -> Result<f64, ReferenceEnds> {
        space::length_of(&self.line.own)
    }

    /// The trajectory to compare with, in `f64` or in extended precision.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if the world-line ends before.
    pub(super) fn reference(&self, length: f64, is_extended: bool) -> Result<Box<dyn Reference>, ReferenceEnds> {
        if is_extended {
            return Ok(Box::new(space::reference(&self.line.exact.place, length.into(), DIGITS)?));
        }
        Ok(Box::new(space::reference(self.place(), length, f64::MOST_DIGITS)?))
    }

    /// The largest frequency of the linearised equations at these points, and their largest rate of growth.
    pub(super) fn rates(&self, points: &[Point]) -> [f64; 2] {
        Linearised::new(&self.place().geometry).rates(points)
    }

    /// The sizes by which trajectories with these points are judged. `points` are at least two, ends included.
    pub(super) fn sizes(&self, points: &[Point], length: f64) -> Sizes {
        sizes(self.place(), points, length)
    }

    /// ṫ_i, if there is a coordinate t.
    pub(super) fn t_dot(&self) -> Option<f64> {
        let t = self.coordinates.iter().position(|name| name == "t")?;
        Some(self.place().start.q_dot[t])
    }

    /// The run of a scheme of this program; `None` if there is no such grid.
    pub(super) fn scheme(&self, grid: &Grid, range: Range) -> Option<Task<'_>> {
        let setup = self.on(grid, range)?;
        if self.line.is_scene && bytes_needed(&setup, false, 0) > MOST_BYTES {
            return None;
        }
        let settings = setup.settings;
        let intervals = if settings.accuracy.is_some() { 0 } else { settings.windows * (settings.n_gamma - 1) };
        let run = move || {
            let line = solve(&setup)?;
            Ok(Box::new(move || self.track_of(&line)) as Measured<'_>)
        };
        Some(Task { intervals, run: Box::new(run) })
    }

    /// The run of another method.
    pub(super) fn other(&self, peer: &'static dyn Peer, range: Range, output: Output, setting: Setting) -> Task<'_> {
        let run = move || {
            let Range { length, tangent } = range;
            let place = self.stretched(tangent);
            let problem = self.line.problem(&place, length);
            let Trajectory { states, steps, .. } = peer.run(&problem, &output, setting)?;
            let track = move || self.track_of_states(&problem, &states, steps, setting.count > 0);
            Ok(Box::new(track) as Measured<'_>)
        };
        Task { intervals: setting.count, run: Box::new(run) }
    }
}
