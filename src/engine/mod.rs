//! The engine of few nodes: Gauss–Lobatto collocation in windows, for any scene.
//!
//! ```text
//! D̄ x − h ẋ(x) = 0 on all nodes,    x = (q, p),    D̄ = D + H⁻¹E_0 with the initial data in it,    A = D̄⁻¹
//! first order    x = x₀ + h A ẋ(x), momenta first, then positions with the new momenta
//! second order   q = q₀ + h c q̇₀ + h² A² q̈(q),    q̇ = q̇₀ + h A q̈,     where g^ab of active ones is constant
//! ```
//!
//! This is the critical point of the weak action on spectral elements, which is Lobatto IIIC applied to Hamilton's
//! equations: of order 2n − 2 at the end of a window of n nodes. It is solved by repeated substitution (*sweeps*) from
//! a guess that continues the window before. Momenta of ignorable coordinates are constants, and these coordinates are
//! quadratures of their velocities.
//!
//! Ends are sums of two numbers, to which weights of twice the digits add: rounding errors of weights would be the same
//! in every window, and K would drift.
//!
//! ```text
//! rule         tables of the rule, and of windows of one length
//! kernel       all that is compiled for every instruction set and number of lanes
//! system       the equations of a scene: registers, and the steps that compute what is wanted when
//! sizes        the units of a motion, from the motion itself
//! window       one window
//! certificate  the gradient of the action at a window
//! march        window after window
//! enclosure    what formulas do between nodes
//! lobatto      the engines that this one is to replace
//! ```

mod certificate;
pub(crate) mod enclosure;
mod kernel;
pub mod lobatto;
mod march;
mod rule;
mod sizes;
mod system;
mod window;

use self::march::March;
use self::sizes::Sizes;
use self::window::Solver;
use crate::geometry::{Geometry, OutsideGeometry, Start};
use crate::number::Compensated;
use crate::number::vector::Twofold;

/// The most nodes of a window.
pub const MOST_POINTS: usize = 24;

/// The state at the start or the end of a window, in sums that lose nothing.
#[derive(Debug, Clone, Default)]
pub struct State {
    /// q^a of all coordinates.
    pub(crate) q: Vec<Compensated<f64>>,
    /// p_a of active coordinates.
    pub(crate) p: Vec<Compensated<f64>>,
}

impl State {
    /// Takes the numbers of another one, in the room that is there.
    fn copy_from(&mut self, other: &Self) {
        self.q.clone_from(&other.q);
        self.p.clone_from(&other.p);
    }

    /// q^a of all coordinates, rounded.
    pub fn positions(&self) -> Vec<f64> {
        self.q.iter().map(|q| q.high).collect()
    }

    /// p_a of active coordinates, rounded.
    pub fn momenta(&self) -> Vec<f64> {
        self.p.iter().map(|p| p.high).collect()
    }
}

/// Why there is no next window.
#[derive(Debug, Clone, Copy)]
pub enum Failure {
    /// A node is outside the domain.
    OutsideDomain(OutsideGeometry),
    /// Sweeps do not converge.
    NotConverged,
}

/// A window that was solved.
#[derive(Debug, Clone)]
pub struct Window {
    /// Number n of nodes.
    pub points: usize,
    /// The state at its start.
    pub start: State,
    /// The state at its end.
    pub end: State,
    /// The largest entry of the gradient of its action.
    pub gradient_norm: f64,
    /// The number of sweeps over it.
    pub sweeps: usize,
    /// q^a on the nodes, row by row: of active coordinates themselves, of ignorable ones from the start of the window.
    q: Vec<f64>,
    /// p_a of active coordinates on the nodes, row by row.
    p: Vec<f64>,
}

impl Window {
    fn new(geometry: &Geometry, points: usize) -> Self {
        let (q, p) = (vec![0.0; geometry.dimension() * points], vec![0.0; geometry.active().len() * points]);
        Self { points, start: State::default(), end: State::default(), gradient_norm: 0.0, sweeps: 0, q, p }
    }

    /// q^a on the nodes; of an ignorable coordinate from the start of the window.
    pub fn q(&self, a: usize) -> &[f64] {
        &self.q[a * self.points..][..self.points]
    }

    /// p_a on the nodes, by place among the active coordinates.
    pub fn p(&self, place: usize) -> &[f64] {
        &self.p[place * self.points..][..self.points]
    }

    /// The window that a solver has finished. Its last nodes are its end.
    fn take<const N: usize>(&mut self, solver: &Solver<'_, N>) {
        let points = self.points;
        self.start.copy_from(&solver.start);
        self.end.copy_from(&solver.end);
        for (a, elapsed) in solver.geometry.ignorable().zip(&solver.elapsed) {
            self.q[a * points..][..points].copy_from_slice(&elapsed.0[..points]);
        }
        for (place, &a) in solver.geometry.active().iter().enumerate() {
            let (q, p) = (&mut self.q[a * points..][..points], &mut self.p[place * points..][..points]);
            q.copy_from_slice(&solver.position(place).0[..points]);
            p.copy_from_slice(&solver.momenta[place].0[..points]);
            (q[points - 1], p[points - 1]) = (self.end.q[a].high, self.end.p[place].high);
        }
    }
}

/// Windows of one length from a start, pulled one by one.
pub struct Engine<'g>(Width<'g>);

/// Rules of up to so many nodes.
enum Width<'g> {
    Eight(Box<March<'g, 8>>),
    Sixteen(Box<March<'g, 16>>),
    TwentyFour(Box<March<'g, 24>>),
}

impl<'g> Engine<'g> {
    /// `windows` windows of `points` nodes each, over a run of this length.
    ///
    /// # Errors
    /// If the start is outside the domain.
    ///
    /// # Panics
    /// If there are fewer than two or more than [`MOST_POINTS`] nodes.
    pub fn equal(
        geometry: &'g Geometry,
        start: &Start,
        length: f64,
        windows: usize,
        points: usize,
    ) -> Result<Self, OutsideGeometry> {
        let h = Twofold::from(length) / Twofold::from(windows as f64);
        let sizes = Sizes::new(geometry, start, length)?;
        Ok(Self(match points {
            ..=8 => Width::Eight(Box::new(March::new(geometry, start, &sizes, h, points))),
            9..=16 => Width::Sixteen(Box::new(March::new(geometry, start, &sizes, h, points))),
            _ => Width::TwentyFour(Box::new(March::new(geometry, start, &sizes, h, points))),
        }))
    }

    /// Solves the next window.
    ///
    /// # Errors
    /// If its nodes leave the domain, or if sweeps do not converge.
    #[expect(clippy::should_implement_trait, reason = "the window is lent")]
    pub fn next(&mut self) -> Result<&Window, Failure> {
        match &mut self.0 {
            Width::Eight(march) => march.next(),
            Width::Sixteen(march) => march.next(),
            Width::TwentyFour(march) => march.next(),
        }
    }
}
