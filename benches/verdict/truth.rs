//! The exact world-line, by integrators that are neither the run's nor the ones that its error is estimated with: a
//! Taylor method that begins anew on each of many short pieces, and DOP853 from piece to piece beside it. None of them
//! jumps over anything that is longer than a piece. What they are apart is what they may be off by.

use std::sync::Arc;

use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::methods::{Output, Peer, Problem, Setting, State};
use geodesic_ivp::reference::ReferenceTrajectory;

/// Pieces on which the integrators begin anew.
const PIECES: usize = 96;
/// The exact world-line is computed a little beyond the end.
const BEYOND: f64 = 1.001;
/// Rounding may do this in any case, relative to the size of a coordinate.
const ROUNDING: f64 = 2e-13;

/// The exact world-line.
pub(crate) struct Truth {
    pieces: Vec<ReferenceTrajectory>,
    /// The length of each in γ.
    piece: f64,
    /// Every coordinate may be off by this.
    pub(crate) uncertain: Vec<f64>,
}

impl Truth {
    /// It has all coordinates, and is `None` where it leaves the domain.
    pub(crate) fn new(geometry: &Arc<Geometry>, start: &Start, length: f64) -> Option<Self> {
        let piece = BEYOND * length / PIECES as f64;
        let (mut here, mut other) = (start.clone(), start.clone());
        let (mut pieces, mut most, mut sizes) =
            (Vec::new(), vec![0.0_f64; start.q.len()], vec![0.0_f64; start.q.len()]);
        for _ in 0..PIECES {
            let trajectory = ReferenceTrajectory::new(geometry, &here, piece, 16).ok()?;
            let end = trajectory.at(piece);
            pieces.push(trajectory);
            here = end;
            let problem = Problem { space: Arc::clone(geometry), start: other.clone(), length: piece, g00: None };
            let found = Peer::Dop853.run(&problem, &Output::even(1), Setting::tolerance(1e-15)).ok()?;
            let State { q, p } = found.states.last()?;
            other = Start { q_dot: geometry.velocities(q, p).ok()?, q: q.to_vec(), p: p.to_vec() };
            for (a, (one, other)) in here.q.iter().zip(&other.q).enumerate() {
                let apart = (one - other).abs();
                most[a] = if apart <= most[a] { most[a] } else { apart };
                sizes[a] = sizes[a].max(one.abs());
            }
        }
        let uncertain = most.iter().zip(&sizes).map(|(most, size)| most + ROUNDING * size).collect();
        Some(Self { pieces, piece, uncertain })
    }

    /// The coordinates at γ − γ_i.
    pub(crate) fn at(&self, gamma: f64) -> Vec<f64> {
        let index = ((gamma / self.piece) as usize).min(PIECES - 1);
        let inside = gamma - index as f64 * self.piece;
        self.pieces[index].at(inside).q
    }
}
