//! The world-line of a case in any space-time.

use super::arena::DIGITS;
use super::status::Sizes;
use super::track::Track;
use super::world::{Grid, Measured, Range, Reference, Task, World};
use crate::action::Form;
use crate::case::on_grid;
use crate::diagnostics::scene::energy_off;
use crate::engine::Accuracy;
use crate::methods::{Output, Peer, PeerIn, Problem, Setting, Trajectory};
use crate::number::norm::larger;
use crate::number::{Extended, Real};
use crate::reference::{ReferenceEnds, ReferenceTrajectory};
use crate::solve::{Limit, Place, Setup, System, WorldLine, bytes_needed};
use crate::study::line::{Judged, Line, Raced};
use crate::study::space::{Point, Studied};

/// A grid whose linear systems need more bytes than this is left out: several cells are computed at once.
const MOST_BYTES: f64 = 1e9;

/// A space-time whose world-lines are charted.
pub(super) trait Charted: Raced {
    /// Whether it is that of a scene.
    const IS_SCENE: bool;

    /// The largest frequency of the linearised equations at these points, and their largest rate of growth.
    fn frequencies(place: &Place<f64, Self>, points: &[Point]) -> [f64; 2];

    /// The sizes by which trajectories with these points are judged. `points` are at least two, ends included.
    fn sizes(place: &Place<f64, Self>, points: &[Point], length: f64) -> Sizes;

    /// The place with another tangent, in units of its own.
    fn stretched(place: &Place<f64, Self>, tangent: f64) -> Place<f64, Self>;
}

/// A world-line to be charted.
pub(super) struct Chart<G: Raced> {
    line: Line<G>,
    coordinates: Vec<String>,
}

impl<G: Charted> Chart<G> {
    pub(super) fn new(line: Line<G>) -> Self {
        Self { coordinates: line.own.place.geometry.coordinates(), line }
    }

    fn place(&self) -> &Place<f64, G> {
        &self.line.plain.place
    }

    fn track_of(&self, line: &WorldLine<f64, G>) -> Track {
        let found = G::deviations(line, self.line.is_lifted);
        let single = line.form == Form::Strong && line.windows.len() == 1;
        let gamma = line.gamma_from_start().collect();
        let rows = (G::rows(line), found.delta_k);
        Track {
            delta_energy_max: found.energy_max,
            charges: Some(found.charges),
            last_node: single.then_some(found.last_node),
            iterations: Some(line.iterations.count),
            ..Track::of_windows(line.grids(), gamma, rows, (&found.delta_k_ends, found.delta_k_max))
        }
    }

    fn track_of_states(
        &self,
        problem: &Problem<G>,
        states: Vec<G::State>,
        steps: usize,
        is_equidistant: bool,
    ) -> Track {
        let start = &self.place().start;
        let begin = self.start();
        let mut q: Vec<Vec<f64>> = begin.q.iter().map(|&q| vec![q]).collect();
        let k = G::k(problem, &begin);
        let (mut delta_k, mut energy) = (vec![0.0], 0.0);
        for state in states {
            let Judged { q: here, k: k_here, q0_dot } = G::judged(problem, state);
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

    /// The start as a point.
    fn start(&self) -> Point {
        let start = &self.place().start;
        Point { q: start.q.clone(), q_dot: start.q_dot.clone(), p: start.p.clone() }
    }

    /// What a solver is told for a grid; `None` if there is no such grid.
    fn on(&self, grid: &Grid, Range { length, tangent }: Range) -> Option<Setup<f64, G>> {
        let place = if tangent == 1.0 { self.place().clone() } else { G::stretched(self.place(), tangent) };
        let mut setup = Setup { place: place.clone(), rough: place, ..self.line.plain.clone() };
        match *grid {
            Grid::Nodes { scheme, nodes, windows } => {
                setup.settings.windows = windows;
                on_grid(&setup, scheme, nodes, length).ok()
            }
            Grid::Unregularised(..) if G::IS_SCENE => None,
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
}

impl<G: Charted> World for Chart<G>
where
    Line<G>: Send + Sync,
    ReferenceTrajectory<f64, G>: Send + Sync,
    ReferenceTrajectory<Extended, G::Exact>: Send + Sync,
    dyn Peer: PeerIn<G>,
{
    fn is_scene(&self) -> bool {
        G::IS_SCENE
    }

    fn has_energy(&self) -> bool {
        self.line.is_lifted
    }

    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn active(&self) -> &[usize] {
        self.place().geometry.active()
    }

    fn origin(&self) -> Vec<f64> {
        let mut origin = self.place().start.q.clone();
        self.active().iter().for_each(|&a| origin[a] = 0.0);
        origin
    }

    fn own_length(&self) -> Result<f64, ReferenceEnds> {
        G::length_of(&self.line.own)
    }

    fn reference(&self, length: f64, is_extended: bool) -> Result<Box<dyn Reference>, ReferenceEnds> {
        if is_extended {
            return Ok(Box::new(G::Exact::reference(&self.line.exact.place, length.into(), DIGITS)?));
        }
        Ok(Box::new(<G as Studied<f64>>::reference(self.place(), length, f64::MOST_DIGITS)?))
    }

    fn rates(&self, points: &[Point]) -> [f64; 2] {
        G::frequencies(self.place(), points)
    }

    fn sizes(&self, points: &[Point], length: f64) -> Sizes {
        G::sizes(self.place(), points, length)
    }

    fn t_dot(&self) -> Option<f64> {
        let t = self.coordinates.iter().position(|name| name == "t")?;
        Some(self.place().start.q_dot[t])
    }

    fn scheme(&self, grid: &Grid, range: Range) -> Option<Task<'_>> {
        let setup = self.on(grid, range)?;
        if G::IS_SCENE && bytes_needed(&setup, false, 0) > MOST_BYTES {
            return None;
        }
        let settings = setup.settings;
        let intervals = if settings.accuracy.is_some() { 0 } else { settings.windows * (settings.n_gamma - 1) };
        let run = move || {
            let line = G::solve(&setup)?;
            Ok(Box::new(move || self.track_of(&line)) as Measured<'_>)
        };
        Some(Task { intervals, run: Box::new(run) })
    }

    fn other(&self, peer: &'static dyn Peer, range: Range, output: Output, setting: Setting) -> Task<'_> {
        let run = move || {
            let Range { length, tangent } = range;
            let place = if tangent == 1.0 { self.place().clone() } else { G::stretched(self.place(), tangent) };
            let problem = Line::problem(&place, length);
            let Trajectory { states, steps, .. } = peer.run(&problem, &output, setting)?;
            let track = move || self.track_of_states(&problem, states, steps, setting.count > 0);
            Ok(Box::new(track) as Measured<'_>)
        };
        Task { intervals: setting.count, run: Box::new(run) }
    }
}
