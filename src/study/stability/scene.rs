//! The world-line of a scene of n coordinates.

use super::arena::{DIGITS, amplitude, half_range, largest};
use super::frequency::Linearised;
use super::status::Sizes;
use super::track::Track;
use super::world::{Grid, Measured, Point, Range, Reference, Task, World};
use crate::action::Form;
use crate::case::scene::{SceneCase, on_grid};
use crate::diagnostics::scene::{SceneDiagnostics, energy_off};
use crate::geometry::Geometry;
use crate::methods::{Output, Peer, Problem, SceneState, Setting, Trajectory};
use crate::norm::{larger, max_abs};
use crate::reference::{ReferenceEnds, ReferenceTrajectory};
use crate::scalar::{Extended, Real};
use crate::solve::{Setup, System, WorldLine, bytes_needed, solve};
use crate::study::scene_length::length_of;

/// A grid whose linear systems need more bytes than this is left out: several cells are computed at once.
const MOST_BYTES: f64 = 1e9;

/// A scene.
pub(super) struct Scene {
    /// What a solver is told, without what belongs to one scheme or one end only.
    setup: Setup,
    /// The case, for its end and for more digits.
    case: SceneCase,
    coordinates: Vec<String>,
    is_lifted: bool,
}

impl Scene {
    pub(super) fn new(case: &SceneCase) -> Self {
        let mut setup: Setup = case.setup();
        (setup.settings.system, setup.settings.digits, setup.settings.accuracy) =
            (System::PhysicalLimit, f64::MOST_DIGITS, None);
        (setup.gamma_i, setup.settings.windows) = (0.0, 1);
        Self { coordinates: case.coordinates(), is_lifted: case.is_lifted(), case: case.clone(), setup }
    }

    fn geometry(&self) -> &Geometry {
        &self.setup.place.geometry
    }

    fn track_of(&self, line: &WorldLine) -> Track {
        let diagnostics = SceneDiagnostics::new(line, &[], &mut [], self.is_lifted);
        let energy = diagnostics.delta_energy.map(|delta| {
            let inside = line.grids().map(|grid| max_abs(&delta[grid.exact()])).fold(0.0, larger);
            diagnostics.energy.map_or(inside, |energy| larger(inside, energy.max_ends))
        });
        let single = line.form == Form::Strong && line.windows.len() == 1;
        let charges = &diagnostics.charges;
        let last = |row: &[f64]| row.last().copied().unwrap_or(f64::NAN);
        let last_node = || charges.iter().map(|charge| [last(&charge.delta), last(&charge.corrected)]).collect();
        let q = (0..self.coordinates.len()).map(|a| line.q(a).collect()).collect();
        let norm = diagnostics.norm;
        Track {
            delta_energy_max: energy,
            charges: Some(charges.iter().map(|charge| charge.max_interior).collect()),
            last_node: single.then(last_node),
            iterations: Some(line.iterations.count),
            ..Track::of_windows(line.grids(), line.gamma().collect(), (q, norm.delta), (&norm.ends, norm.max_interior))
        }
    }

    fn track_of_states(&self, length: f64, states: Vec<SceneState>, steps: usize, is_equidistant: bool) -> Track {
        let (geometry, start) = (self.geometry(), &self.setup.place.start);
        let k = geometry.norm(&start.q, &start.q_dot);
        let mut q: Vec<Vec<f64>> = start.q.iter().map(|&q| vec![q]).collect();
        let (mut delta_k, mut energy) = (vec![0.0], 0.0);
        for state in states {
            let velocities = geometry.velocities(&state.q, &state.p).ok();
            let delta = velocities.as_ref().map_or(f64::NAN, |q_dot| geometry.norm(&state.q, q_dot) - k);
            if self.is_lifted {
                let t_dot = velocities.map_or(f64::NAN, |q_dot| q_dot[0]);
                energy = larger(energy, energy_off(start, k + delta, t_dot).abs());
            }
            delta_k.push(delta);
            q.iter_mut().zip(state.q).for_each(|(row, q)| row.push(q));
        }
        Track {
            delta_energy_max: self.is_lifted.then_some(energy),
            ..Track::of_steps(length, (q, delta_k), steps, is_equidistant)
        }
    }
}

impl World for Scene {
    fn is_scene(&self) -> bool {
        true
    }

    fn has_energy(&self) -> bool {
        self.is_lifted
    }

    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn active(&self) -> &[usize] {
        self.geometry().active()
    }

    fn origin(&self) -> Vec<f64> {
        let mut origin = self.setup.place.start.q.clone();
        self.active().iter().for_each(|&a| origin[a] = 0.0);
        origin
    }

    fn own_length(&self) -> Result<f64, ReferenceEnds> {
        length_of::<f64>(&self.case.setup())
    }

    fn reference(&self, length: f64, is_extended: bool) -> Result<Box<dyn Reference>, ReferenceEnds> {
        if is_extended {
            let place = self.case.setup::<Extended>().place;
            return Ok(Box::new(ReferenceTrajectory::new(&*place.geometry, &place.start, length.into(), DIGITS)?));
        }
        let place = &self.setup.place;
        Ok(Box::new(ReferenceTrajectory::new(&*place.geometry, &place.start, length, f64::MOST_DIGITS)?))
    }

    fn rates(&self, points: &[Point]) -> [f64; 2] {
        Linearised::new(self.geometry()).rates(points)
    }

    /// Coordinates of one unit share their size; see [`Geometry::alike`]. The range of γ in which the motion is felt is
    /// the shortest in which an active coordinate moves by its amplitude.
    fn sizes(&self, points: &[Point], length: f64) -> Sizes {
        let (geometry, start) = (self.geometry(), &self.setup.place.start.q);
        let all = 0..self.coordinates.len();
        let is_active = |a: usize| geometry.active().contains(&a);
        let half = all.clone().map(|a| if is_active(a) { half_range(points, a) } else { 0.0 }).collect::<Vec<_>>();
        let speeds: Vec<f64> = all.clone().map(|a| largest(points, |point| point.q_dot[a])).collect();
        let [half, speeds] = [half, speeds].map(|row| geometry.shared(start, &row));
        let amplitude = |a: usize| amplitude(half[a], largest(points, |point| point.q[a]));
        let moved = geometry.active().iter().filter(|&&a| speeds[a] > 0.0).map(|&a| amplitude(a) / speeds[a]);
        let felt = moved.fold(length, f64::min);
        let size = |a: usize| if is_active(a) { amplitude(a) } else { (speeds[a] * felt).max(f64::MIN_POSITIVE) };
        let motion = points.iter().map(|point| geometry.motion(&point.q, &point.q_dot)).fold(0.0, f64::max);
        let k = || geometry.norm(start, &self.setup.place.start.q_dot).abs();
        Sizes { q: all.map(size).collect(), k: if motion > 0.0 { motion } else { k() } }
    }

    fn t_dot(&self) -> Option<f64> {
        let t = self.coordinates.iter().position(|name| name == "t")?;
        Some(self.setup.place.start.q_dot[t])
    }

    fn scheme(&self, grid: &Grid, range: Range) -> Option<Task<'_>> {
        let mut setup = self.setup.clone();
        let setup = match *grid {
            Grid::Nodes { scheme, nodes, windows } => {
                setup.settings.windows = windows;
                on_grid(&setup, scheme, nodes, range.length).ok()?
            }
            Grid::Unregularised(..) => return None,
            Grid::Accuracy(accuracy) => {
                let scheme = (self.setup.settings.sbp, self.setup.settings.form);
                setup = on_grid(&setup, scheme, 24, range.length).ok()?;
                setup.settings.accuracy = Some(accuracy);
                setup
            }
        };
        if bytes_needed(&setup, false, 0) > MOST_BYTES {
            return None;
        }
        let intervals = setup.settings.windows * (setup.settings.n_gamma - 1);
        let run = move || {
            let line = solve(&setup)?;
            Ok(Box::new(move || self.track_of(&line)) as Measured<'_>)
        };
        Some(Task { intervals, run: Box::new(run) })
    }

    fn other(&self, peer: &'static dyn Peer, range: Range, output: Output, setting: Setting) -> Task<'_> {
        let place = &self.setup.place;
        let problem = Problem { space: place.geometry.clone(), start: (*place.start).clone(), length: range.length };
        let run = move || {
            let Trajectory { states, steps, .. } = peer.run(&problem, &output, setting)?;
            Ok(Box::new(move || self.track_of_states(range.length, states, steps, setting.count > 0)) as Measured<'_>)
        };
        Task { intervals: setting.count, run: Box::new(run) }
    }
}
