//! The engine of few nodes: Gauss–Lobatto collocation in windows, for any scene, and Gauss' method on the same path.
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
//! ladder       the tables of all lengths that an adaptive run uses, and from the errors of a window to the next length
//! kernel       steps of programs on all nodes, compiled for every instruction set and number of lanes
//! system       the equations of a scene, and the linearised ones: registers, and the steps that compute what is wanted
//! sizes        the sizes of unknowns, from the motion itself, and its time scale
//! solved       a solved window, as it is lent, and what a run hands on to one that continues it
//! window       the unknowns of windows, what these start from, and where their solutions are kept
//! sweeps       the solution of a window
//! moves        by how much unknowns move in a window, and how far that is rounding
//! local        the errors that a window makes, from its highest modes
//! view         what is known of a window when it is finished
//! dense        a window between its nodes
//! certificate  the gradient of the action at a window
//! tangents     how small changes at its start change its end, which `sensitivity` adds up
//! march        windows of one length
//! adaptive     windows as long as a tolerance allows
//! companion    two such marches side by side, of which the finer one judges the other
//! tuning       the numbers that it was calibrated with
//! stop         runs that end where something has a value
//! failure      why there is no next window, and where the motion leaves the domain, if that is why
//! defect       by how much a window misses the equations between its nodes
//! rates        the rates of a motion at one place, as windows compute them
//! between      a look for what may hide between the nodes of a window, and where it passes a knot of a table
//! enclosure    what formulas do between nodes
//! ```
//!
//! Windows are pulled one by one, without a case and a file: [`Window`] has an example.

mod adaptive;
mod between;
mod certificate;
mod companion;
mod defect;
mod dense;
pub(crate) mod enclosure;
mod failure;
mod kernel;
mod ladder;
mod local;
mod march;
mod moves;
mod rates;
mod rounds;
mod rule;
mod sensitivity;
mod shaken;
mod sizes;
mod solved;
mod stop;
mod sweeps;
mod system;
mod tangents;
#[cfg(test)]
mod tests;
mod touch;
mod tuning;
mod view;
mod window;

pub use self::dense::Dense;
pub use self::failure::Failure;
pub(crate) use self::rates::Rates;
pub use self::rounds::Rounds;
pub use self::sensitivity::{Growth, Sensitivity};
pub use self::solved::{Handed, Marched, OfState, Solved, State, Window, WindowNodes};
pub(crate) use self::touch::Touched;

use std::ops::{ControlFlow, Deref, DerefMut};

use self::adaptive::{Adaptive, Target};
use self::companion::Companion;
use self::march::March;
use crate::geometry::{Geometry, OutsideGeometry, Start};
use crate::sbp::collocation::Collocation;
use crate::sbp::legendre::Family;

/// The most nodes of a window.
pub const MOST_POINTS: usize = 24;

/// The nodes of a window whose length is chosen for an accuracy. With 8 of them runs take as long at best.
pub const POINTS: usize = 16;

/// It is known until where an error is below 10^−digits for these numbers of digits.
pub const GOOD_DIGITS: [i32; 3] = [3, 6, 9];

/// The accuracy of a run: the largest error of a coordinate at any node, relative to its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Accuracy {
    /// The accuracy of the run: two marches, of which the second is the run, do not differ by more.
    Promised(f64),
    /// The tolerance of a march beside the run. Their distance tells what windows add up to.
    Estimated(f64),
    /// The tolerance of every window by itself. Nothing is known of what they add up to.
    Local(f64),
    /// The same where windows serve an accuracy: no more than a part of that may hide between their nodes.
    Alone {
        /// The tolerance.
        tolerance: f64,
        /// The accuracy.
        accuracy: f64,
    },
}

impl Accuracy {
    /// The number itself, which is a tolerance where windows are by themselves.
    pub fn value(self) -> f64 {
        let (Self::Promised(value)
        | Self::Estimated(value)
        | Self::Local(value)
        | Self::Alone { tolerance: value, .. }) = self;
        value
    }

    /// Windows as those of the run that this asks for, if one round is enough for it, and nothing beside them.
    pub fn alone(self) -> Self {
        match self {
            Self::Promised(_) | Self::Estimated(_) => Rounds::new(self).marches()[1],
            Self::Local(_) | Self::Alone { .. } => self,
        }
    }

    /// True if windows may not add up to more.
    pub fn is_promised(self) -> bool {
        matches!(self, Self::Promised(_))
    }
}

/// Windows from a start, pulled one by one by [`Windows::next`].
pub struct Engine<'g>(Box<dyn Windows + 'g>);

impl<'g> Deref for Engine<'g> {
    type Target = dyn Windows + 'g;

    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

impl DerefMut for Engine<'_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut *self.0
    }
}

/// The windows of a run, of rules of any number of nodes.
pub trait Windows {
    /// Solves the next window; `None` after the last one.
    ///
    /// # Errors
    /// [`Failure`], of which [`Failure::BeginAgain`] is no end.
    fn next(&mut self) -> Result<Option<Window<'_>>, Failure>;

    /// The next window of the march that judges this run, as far as it is needed beside the last window; `None` if it
    /// is not, or if there is no such march. [`Self::next`] goes on with those that were not asked for. It is another
    /// solution, and its windows end elsewhere.
    ///
    /// # Errors
    /// As [`Self::next`].
    fn next_of_judge(&mut self) -> Result<Option<Window<'_>>, Failure> {
        Ok(None)
    }

    /// Ends the run in the last window of a run to an accuracy, where `value` of the state at its end changes its sign:
    /// the window is solved again with another length. `between` are two lengths of which the sign before the first one
    /// is `side`, and changes before the second one, or beside them by no more than their distance. Returns false if it
    /// does not: the window is as it was, and the run goes on.
    ///
    /// # Errors
    /// [`Failure`], if such a window has no solution.
    fn end_where(&mut self, _between: [f64; 2], _side: f64, _value: OfState<'_>) -> Result<bool, Failure> {
        Ok(false)
    }

    /// Takes coordinates of a run to an accuracy, by their index, to be at least so large. This comes before the first
    /// window, and before [`Self::resume`].
    fn set_floors(&mut self, _floors: &[(usize, f64)]) {}

    /// The last window once more.
    fn window(&mut self) -> Window<'_>;

    /// Number of sweeps so far, those over refused windows too.
    fn sweeps(&self) -> usize;

    /// Goes back to the start with smaller tolerances, after [`Failure::BeginAgain`].
    fn begin_again(&mut self) {}

    /// Goes back to the start, as if nothing was known, with the tables that were made.
    fn rewind(&mut self);

    /// Continues another run from its end, which is the start of this one. This comes before the first window.
    fn resume(&mut self, handed: &Handed);

    /// The largest error to expect at any node so far, relative to sizes, if the accuracy is promised.
    fn error_estimate(&self) -> Option<f64> {
        None
    }

    /// The same for every coordinate by itself, in its unit; empty where nothing is known.
    fn errors(&self) -> Vec<f64> {
        Vec::new()
    }

    /// The highest accuracy for which rounding leaves room so far, if errors are estimated.
    fn reachable(&self) -> Option<f64> {
        None
    }

    /// γ from the start of the run until which the error estimate is below each of [`GOOD_DIGITS`]; 0 without one.
    fn good_until(&self) -> [f64; GOOD_DIGITS.len()] {
        [0.0; GOOD_DIGITS.len()]
    }

    /// The sizes of all coordinates so far, which errors are relative to: their largest value, or way from the start if
    /// they are ignorable or a clock, or the largest distance from the start of a window on its nodes. Coordinates with
    /// one metric coefficient share it. 0 for one that has not moved at all.
    fn sizes(&self) -> Vec<f64>;

    /// γ from the start of the run and q^a where windows have come to; after a failure, where the motion leaves the
    /// domain, if that is the reason.
    fn place(&self) -> (f64, Vec<f64>);

    /// The coordinates whose motion is nothing but rounding where windows have come to, by their index: a tenth of
    /// their rates at least, or of those of their momenta.
    fn moved_by_rounding(&mut self) -> Vec<usize> {
        Vec::new()
    }

    /// Number of windows so far between whose nodes something may hide, however short they are. Windows of one length
    /// are not looked at.
    fn unresolved(&self) -> usize {
        0
    }

    /// γ at the first place where the motion touches a place where a force jumps, nearer than the accuracy tells.
    /// Windows of one length are not looked at.
    fn touched(&self) -> Option<f64> {
        None
    }
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
        Self::march(geometry, start, (length, windows), Collocation::shared(Family::Lobatto, points), 0.0)
    }

    /// `steps` steps of Gauss' method over a run of this length. Sweeps leave no more than `tolerance`, relative to
    /// sizes; 0 stands for rounding.
    ///
    /// # Errors
    /// If the start is outside the domain.
    ///
    /// # Panics
    /// If there are no or more than [`MOST_POINTS`] stages.
    pub fn gauss(
        geometry: &'g Geometry,
        start: &Start,
        length: f64,
        steps: usize,
        stages: usize,
        tolerance: f64,
    ) -> Result<Self, OutsideGeometry> {
        Self::march(geometry, start, (length, steps), Collocation::shared(Family::Gauss, stages), tolerance)
    }

    /// Windows of one length, whose sweeps leave no more than `tolerance`, relative to sizes; 0 stands for rounding.
    pub(crate) fn march(
        geometry: &'g Geometry,
        start: &Start,
        grid: (f64, usize),
        operators: &'static Collocation,
        tolerance: f64,
    ) -> Result<Self, OutsideGeometry> {
        Ok(Self(match operators.points() {
            ..=8 => Box::new(March::<8>::new(geometry, start, grid, operators, tolerance)?),
            9..=16 => Box::new(March::<16>::new(geometry, start, grid, operators, tolerance)?),
            _ => Box::new(March::<24>::new(geometry, start, grid, operators, tolerance)?),
        }))
    }

    /// Windows of [`POINTS`] nodes, as long as an accuracy needs, over a run of this length.
    ///
    /// # Errors
    /// If the start is outside the domain.
    pub fn accurate(
        geometry: &'g Geometry,
        start: &Start,
        length: f64,
        accuracy: Accuracy,
    ) -> Result<Self, OutsideGeometry> {
        Self::adaptive(geometry, start, (length, None), accuracy)
    }

    /// As [`Self::accurate`], to the place where a coordinate has a value, to the last bit.
    ///
    /// # Errors
    /// If the start is outside the domain.
    pub fn accurate_to_value(
        geometry: &'g Geometry,
        start: &Start,
        (coordinate, value): (usize, f64),
        accuracy: Accuracy,
    ) -> Result<Self, OutsideGeometry> {
        let from = start.q[coordinate];
        let length = ((value - from) / start.q_dot[coordinate]).abs();
        let target = Some(Target::new(coordinate, value, from));
        Self::adaptive(geometry, start, (length, target), accuracy)
    }

    fn adaptive(
        geometry: &'g Geometry,
        start: &Start,
        end: (f64, Option<Target>),
        accuracy: Accuracy,
    ) -> Result<Self, OutsideGeometry> {
        Ok(Self(match accuracy {
            Accuracy::Promised(_) | Accuracy::Estimated(_) => Box::new(Companion::new(geometry, start, end, accuracy)?),
            Accuracy::Local(_) | Accuracy::Alone { .. } => Box::new(Adaptive::new(geometry, start, end, accuracy)?),
        }))
    }

    /// Solves all windows. `see` gets each of them, and may end the run; if the run is begun again, it sees index 0
    /// again.
    ///
    /// # Errors
    /// [`Failure`], but not [`Failure::BeginAgain`].
    pub fn run(&mut self, mut see: impl FnMut(Window<'_>) -> ControlFlow<()>) -> Result<(), Failure> {
        loop {
            match self.next() {
                Ok(Some(window)) => {
                    if see(window).is_break() {
                        return Ok(());
                    }
                }
                Ok(None) => return Ok(()),
                Err(Failure::BeginAgain) => self.begin_again(),
                Err(failure) => return Err(failure),
            }
        }
    }
}
