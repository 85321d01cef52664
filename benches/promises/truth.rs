//! The exact world-line, by integrators that are neither the run's nor the ones that its error is estimated with: a
//! Taylor method that begins anew on each of many short pieces, and DOP853 from piece to piece beside it. None of them
//! jumps over anything that is longer than a piece. What they are apart is what they may be off by.

use std::sync::Arc;

use geodesic_ivp::geometry::geodesic::InitialData;
use geodesic_ivp::geometry::metric::Metric;
use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::methods::{Dop853, Output, PeerIn, Problem, Setting};
use geodesic_ivp::reference::{ReferencePoint, ReferenceTrajectory};

/// Pieces on which the integrators begin anew.
const PIECES: usize = 96;
/// The exact world-line is computed a little beyond the end.
const BEYOND: f64 = 1.001;
/// What rounding may do in any case, relative to the size of a coordinate.
const ROUNDING: f64 = 2e-13;

/// The exact world-line.
pub(crate) struct Truth {
    pieces: Vec<Piece>,
    /// The length of each in γ.
    piece: f64,
    /// What every coordinate may be off by.
    pub(crate) uncertain: Vec<f64>,
    /// The most that the integrators are apart, relative to sizes.
    pub(crate) apart: f64,
}

enum Piece {
    One(f64, Box<ReferenceTrajectory>),
    Scene(Box<ReferenceTrajectory<f64, Geometry>>),
}

impl Truth {
    /// Of t − t_i and x; `None` where it leaves the domain.
    pub(crate) fn one(metric: &Metric, initial: InitialData, length: f64) -> Option<Self> {
        let piece = BEYOND * length / PIECES as f64;
        let q_t = initial.invariants(metric).q_t;
        let start = InitialData { t: 0.0, ..initial };
        let (mut here, mut other) = (start, start);
        let (mut pieces, mut apart) = (Vec::new(), Apart::new(2));
        for _ in 0..PIECES {
            let trajectory = ReferenceTrajectory::new(metric, &here, piece, 16).ok()?;
            let ReferencePoint { elapsed, x, t_dot, x_dot } = trajectory.at(piece);
            pieces.push(Piece::One(here.t, Box::new(trajectory)));
            here = InitialData { t: here.t + elapsed, x, t_dot, x_dot };
            let problem = Problem { space: metric.clone().into(), start: other, length: piece };
            let state = *Dop853.run(&problem, &Output::even(1), Setting::tolerance(1e-15)).ok()?.states.last()?;
            let t_dot = q_t / metric.at(state.x).g00;
            other = InitialData { t: other.t + state.elapsed, x: state.x, t_dot, x_dot: state.w };
            apart.see(&[here.t, here.x], &[other.t, other.x]);
        }
        Some(apart.truth(pieces, piece))
    }

    /// Of all coordinates of a scene.
    pub(crate) fn scene(geometry: &Arc<Geometry>, start: &Start, length: f64) -> Option<Self> {
        let piece = BEYOND * length / PIECES as f64;
        let (mut here, mut other) = (start.clone(), start.clone());
        let (mut pieces, mut apart) = (Vec::new(), Apart::new(start.q.len()));
        for _ in 0..PIECES {
            let trajectory = ReferenceTrajectory::new(&**geometry, &here, piece, 16).ok()?;
            let end = trajectory.at(piece);
            pieces.push(Piece::Scene(Box::new(trajectory)));
            here = Start { q: end.q, q_dot: end.q_dot, p: end.p };
            let problem = Problem { space: Arc::clone(geometry), start: other.clone(), length: piece };
            let found = Dop853.run(&problem, &Output::even(1), Setting::tolerance(1e-15)).ok()?;
            let state = found.states.last()?;
            let (q, p) = (state.q.clone(), state.p.clone());
            other = Start { q_dot: geometry.velocities(&q, &p).ok()?, q, p };
            apart.see(&here.q, &other.q);
        }
        Some(apart.truth(pieces, piece))
    }

    /// The coordinates at γ − γ_i.
    pub(crate) fn at(&self, gamma: f64) -> Vec<f64> {
        let index = ((gamma / self.piece) as usize).min(PIECES - 1);
        let inside = gamma - index as f64 * self.piece;
        match &self.pieces[index] {
            Piece::One(t, trajectory) => {
                let point = trajectory.at(inside);
                vec![t + point.elapsed, point.x]
            }
            Piece::Scene(trajectory) => trajectory.at(inside).q,
        }
    }
}

/// What two integrators are apart.
struct Apart {
    most: Vec<f64>,
    sizes: Vec<f64>,
}

impl Apart {
    fn new(coordinates: usize) -> Self {
        Self { most: vec![0.0; coordinates], sizes: vec![0.0; coordinates] }
    }

    fn see(&mut self, one: &[f64], other: &[f64]) {
        for (a, (one, other)) in one.iter().zip(other).enumerate() {
            let apart = (one - other).abs();
            self.most[a] = if apart <= self.most[a] { self.most[a] } else { apart };
            self.sizes[a] = self.sizes[a].max(one.abs());
        }
    }

    fn truth(self, pieces: Vec<Piece>, piece: f64) -> Truth {
        let of_each = || self.most.iter().zip(&self.sizes);
        Truth {
            pieces,
            piece,
            uncertain: of_each().map(|(most, size)| most + ROUNDING * size).collect(),
            apart: of_each().map(|(most, size)| most / size).fold(0.0, f64::max),
        }
    }
}
