//! A world-line of any space-time, for methods to compute.

use super::arena::World;
use super::family::Family;
use super::run::{Job, Run, Timed, none, peer, solved};
use crate::case::{Form, SbpName};
use crate::engine::MOST_POINTS;
use crate::methods::{Output, Peer, PeerIn, Problem, Setting, Windows};
use crate::number::{Extended, Real};
use crate::reference::{ReferenceEnds, ReferenceTrajectory};
use crate::solve::{Limit, Setup};
use crate::study::line::{Line, Raced};
use crate::study::space::{Point, Studied, distance};

/// A world-line of one length, with its reference.
pub(super) struct Course<G: Raced> {
    pub(super) problem: Problem<G>,
    /// What a solver is told, without what belongs to one scheme only.
    pub(super) setup: Setup<f64, G>,
    reference: ReferenceTrajectory<Extended, G::Exact>,
}

/// Windows of one length, by their number of nodes.
static MARCHES: [Windows; MOST_POINTS + 1] = {
    let mut all = [Windows::Equal(0); MOST_POINTS + 1];
    let mut nodes = 0;
    while nodes <= MOST_POINTS {
        all[nodes] = Windows::Equal(nodes);
        nodes += 1;
    }
    all
};

/// Sixteen digits of the coordinates at the end, and four more to judge them. Errors of the phase grow with the square
/// of the length.
fn digits(length: f64) -> u32 {
    (20.0 + (2.0 * length.max(1.0).log10()).ceil()) as u32
}

impl<G: Raced> Course<G> {
    /// The world-line itself, or that of another length in γ.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if it does not go so far.
    pub(super) fn new(line: Line<G>, length: Option<f64>) -> Result<Self, ReferenceEnds> {
        let Line { mut exact, plain, .. } = line;
        // How long it takes to a time is not known, but about as long as the time.
        let extent = match (exact.limit, exact.origin) {
            (Limit::Value { value, .. }, Some((_, origin))) => (value - origin).to_f64(),
            _ => 1.0,
        };
        exact.settings.digits = digits(extent);
        let length = length.map_or_else(|| G::Exact::length_of(&exact).map(|length| length.to_f64()), Ok)?;
        let reference = G::Exact::reference(&exact.place, length.into(), digits(length))?;
        Ok(Self { problem: Line::problem(&plain.place, length), setup: plain, reference })
    }
}

impl<G: Raced> World for Course<G>
where
    Problem<G>: Send + Sync,
    Setup<f64, G>: Send + Sync,
    ReferenceTrajectory<Extended, G::Exact>: Send + Sync,
    dyn Peer: PeerIn<G>,
    Windows: PeerIn<G>,
{
    fn coordinates(&self) -> Vec<String> {
        self.problem.space.coordinates()
    }

    fn length(&self) -> f64 {
        self.problem.length
    }

    fn reference(&self) -> (f64, usize) {
        (self.reference.error_estimate(), self.reference.steps())
    }

    fn exact(&self, gamma: f64) -> (Vec<Extended>, f64) {
        let Point { q, q_dot, p } = G::Exact::at(&self.reference, gamma.into()).into();
        let in_f64 = |row: &[Extended]| row.iter().map(|value| value.to_f64()).collect();
        let rough = Point { q: in_f64(&q), q_dot: in_f64(&q_dot), p: in_f64(&p) };
        (q, G::k(&self.problem, &rough))
    }

    fn distance(&self, a: usize, q: f64) -> f64 {
        distance(&self.setup.place, a, q)
    }

    fn shared(&self, sizes: Vec<f64>) -> Vec<f64> {
        G::shared_sizes(&self.setup.place, sizes)
    }

    fn job<'w>(&'w self, family: &Family, setting: Setting, output: Output) -> Box<dyn Job + 'w> {
        let count = setting.count;
        let run: Run<'w, G> = match *family {
            Family::Block(sbp, form) => solved(self, (sbp, form), count + 1),
            Family::Elements(nodes) => solved(self, (SbpName::Gll(nodes as u8), Form::Weak), count * (nodes - 1) + 1),
            Family::Accuracy => peer(self, &Windows::Accuracy, setting, output),
            Family::Tolerance => peer(self, &Windows::Tolerance, setting, output),
            Family::March(nodes) => peer(self, &MARCHES[nodes], setting, output),
            Family::Peer(of) => peer(self, of, setting, output),
            Family::Other(_) => none("elsewhere"),
        };
        Box::new(Timed { course: self, run: run.into() })
    }
}
