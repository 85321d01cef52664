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
//! ladder       the tables of all lengths that an adaptive run uses
//! kernel       sweeps, ends, local errors and gradients, compiled for every instruction set and number of lanes
//! system       the equations of a scene: registers, and the steps that compute what is wanted when
//! linear       the same for its linearised equations
//! sizes        the units of a motion, from the motion itself
//! solved       a solved window, as it is lent
//! window       one window
//! handed       what a run hands on to one that continues it, which `resume` begins from that
//! view         what is known of it when it is finished
//! dense        a window between its nodes
//! certificate  the gradient of the action at a window
//! tangents     how small changes at its start change its end, which `sensitivity` adds up
//! march        windows of one length
//! control      from the errors of a window to the length of the next one
//! accuracy     what is asked of a run
//! estimate     what the errors of windows add up to: `plane` for one active coordinate, `steps`, `transport` for more
//! adaptive     windows as long as an accuracy needs
//! tuning       the numbers that it was calibrated with
//! target       a value of a coordinate at which a run ends
//! stop         runs that end where something has a value
//! failure      why there is no next window
//! reason       where the motion leaves the domain, if that is why
//! between      a look for what may hide between the nodes of a window
//! enclosure    what formulas do between nodes
//! knots        where a window passes a knot of a table
//! ```
//!
//! Windows are pulled one by one, without a case and a file: [`Window`] has an example.

mod accuracy;
mod adaptive;
mod between;
mod certificate;
mod control;
mod dense;
pub(crate) mod enclosure;
mod estimate;
mod failure;
mod handed;
mod kernel;
mod knots;
mod ladder;
mod linear;
mod march;
mod plane;
mod reason;
mod resume;
mod rule;
mod sensitivity;
mod sizes;
mod solved;
mod steps;
mod stop;
mod system;
mod tangents;
mod target;
#[cfg(test)]
mod tests;
mod transport;
mod tuning;
mod view;
mod window;

pub use self::accuracy::Accuracy;
pub use self::dense::Dense;
pub use self::failure::Failure;
pub use self::handed::{Handed, Marched};
pub use self::sensitivity::Sensitivity;
pub use self::solved::{State, Window, WindowNodes};

use std::ops::ControlFlow;

use self::adaptive::Adaptive;
use self::march::March;
use self::rule::Rule;
use self::sizes::Sizes;
use self::target::Target;
use crate::geometry::{Geometry, OutsideGeometry, Start};
use crate::number::vector::Twofold;

/// The most nodes of a window.
pub const MOST_POINTS: usize = 24;

/// The nodes of a window whose length is chosen for an accuracy. With 8 of them runs take as long at best.
pub const POINTS: usize = 16;

/// It is known until where an error is below 10^−digits for these numbers of digits.
pub const GOOD_DIGITS: [i32; 3] = [3, 6, 9];

/// The most stages of a step of Gauss' method.
pub const MOST_STAGES: usize = 16;

/// Windows from a start, pulled one by one.
pub struct Engine<'g>(Box<dyn Windows + 'g>);

/// A run with rules of up to so many nodes.
trait Windows {
    /// As [`Engine::next`].
    fn next(&mut self) -> Result<Option<Window<'_>>, Failure>;

    /// As [`Engine::end_where`].
    fn end_where(
        &mut self,
        _between: [f64; 2],
        _side: f64,
        _value: &mut dyn FnMut(&State) -> f64,
    ) -> Result<bool, Failure> {
        Ok(false)
    }

    /// As [`Engine::set_floors`].
    fn set_floors(&mut self, _floors: &[(usize, f64)]) {}

    /// As [`Engine::window`].
    fn window(&mut self) -> Window<'_>;

    /// As [`Engine::sweeps`].
    fn sweeps(&self) -> usize;

    /// As [`Engine::begin_again`].
    fn begin_again(&mut self) {}

    /// As [`Engine::rewind`].
    fn rewind(&mut self);

    /// As [`Engine::resume`].
    fn resume(&mut self, handed: &Handed);

    /// As [`Engine::error_estimate`].
    fn error_estimate(&self) -> Option<f64> {
        None
    }

    /// As [`Engine::reachable`].
    fn reachable(&self) -> Option<f64> {
        None
    }

    /// As [`Engine::good_until`].
    fn good_until(&self) -> [f64; GOOD_DIGITS.len()] {
        [0.0; GOOD_DIGITS.len()]
    }

    /// As [`Engine::sizes`].
    fn sizes(&self) -> Vec<f64>;

    /// As [`Engine::place`].
    fn place(&self) -> (f64, Vec<f64>);

    /// As [`Engine::unproved`].
    fn unproved(&self) -> usize {
        0
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
        Self::lobatto(geometry, start, length, windows, points, 0.0)
    }

    /// `windows` windows of `points` nodes each, over a run of this length. Sweeps leave no more than `tolerance`,
    /// relative to sizes; 0 stands for rounding.
    ///
    /// # Errors
    /// If the start is outside the domain.
    ///
    /// # Panics
    /// If there are fewer than two or more than [`MOST_POINTS`] nodes.
    pub fn lobatto(
        geometry: &'g Geometry,
        start: &Start,
        length: f64,
        windows: usize,
        points: usize,
        tolerance: f64,
    ) -> Result<Self, OutsideGeometry> {
        let h = Twofold::from(length) / Twofold::from(windows as f64);
        let sizes = Sizes::new(geometry, start, length)?;
        let (at, grid) = ((start, sizes), (windows, h));
        Ok(Self(match points {
            ..=8 => Box::new(March::<8>::new(geometry, at, grid, Rule::lobatto(points), tolerance)),
            9..=16 => Box::new(March::<16>::new(geometry, at, grid, Rule::lobatto(points), tolerance)),
            _ => Box::new(March::<24>::new(geometry, at, grid, Rule::lobatto(points), tolerance)),
        }))
    }

    /// `steps` steps of Gauss' method over a run of this length. Sweeps leave no more than `tolerance`, relative to
    /// sizes; 0 stands for rounding.
    ///
    /// # Errors
    /// If the start is outside the domain.
    ///
    /// # Panics
    /// If there are no or more than [`MOST_STAGES`] stages.
    pub fn gauss(
        geometry: &'g Geometry,
        start: &Start,
        length: f64,
        steps: usize,
        stages: usize,
        tolerance: f64,
    ) -> Result<Self, OutsideGeometry> {
        let h = Twofold::from(length) / Twofold::from(steps as f64);
        let sizes = Sizes::new(geometry, start, length)?;
        let (at, grid) = ((start, sizes), (steps, h));
        Ok(Self(match stages {
            ..=8 => Box::new(March::<8>::new(geometry, at, grid, Rule::gauss(stages), tolerance)),
            _ => Box::new(March::<16>::new(geometry, at, grid, Rule::gauss(stages), tolerance)),
        }))
    }

    /// Windows as long as an accuracy needs, of 8 or 16 nodes each, over a run of this length.
    ///
    /// # Errors
    /// If the start is outside the domain.
    pub fn accurate(
        geometry: &'g Geometry,
        start: &Start,
        length: f64,
        accuracy: Accuracy,
        points: usize,
    ) -> Result<Self, OutsideGeometry> {
        let sizes = Sizes::new(geometry, start, length)?;
        Ok(Self(match points {
            ..=8 => Box::new(Adaptive::<8>::new(geometry, start, sizes, (length, None), accuracy)),
            _ => Box::new(Adaptive::<16>::new(geometry, start, sizes, (length, None), accuracy)),
        }))
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
        points: usize,
    ) -> Result<Self, OutsideGeometry> {
        let from = start.q[coordinate];
        let length = ((value - from) / start.q_dot[coordinate]).abs();
        let sizes = Sizes::new(geometry, start, length)?;
        let length = if length.is_finite() { length } else { sizes.time };
        let run = (length, Some(Target::new(coordinate, value, from)));
        Ok(Self(match points {
            ..=8 => Box::new(Adaptive::<8>::new(geometry, start, sizes, run, accuracy)),
            _ => Box::new(Adaptive::<16>::new(geometry, start, sizes, run, accuracy)),
        }))
    }

    /// Solves the next window; `None` after the last one.
    ///
    /// # Errors
    /// [`Failure`], of which [`Failure::BeginAgain`] is no end.
    #[expect(clippy::should_implement_trait, reason = "the window is lent")]
    pub fn next(&mut self) -> Result<Option<Window<'_>>, Failure> {
        self.0.next()
    }

    /// Ends the run in the last window of a run to an accuracy, where `value` of the state at its end changes its sign:
    /// the window is solved again with another length. `between` are two lengths of which the sign before the first one
    /// is `side`, and changes before the second one, or beside them by no more than their distance. Returns false if it
    /// does not: the window is as it was, and the run goes on.
    ///
    /// # Errors
    /// [`Failure`], if such a window has no solution.
    pub fn end_where(
        &mut self,
        between: [f64; 2],
        side: f64,
        value: &mut dyn FnMut(&State) -> f64,
    ) -> Result<bool, Failure> {
        self.0.end_where(between, side, value)
    }

    /// The last window once more.
    pub fn window(&mut self) -> Window<'_> {
        self.0.window()
    }

    /// Number of sweeps so far, those over refused windows too.
    pub fn sweeps(&self) -> usize {
        self.0.sweeps()
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

    /// Goes back to the start with smaller shares of the accuracy, after [`Failure::BeginAgain`].
    pub fn begin_again(&mut self) {
        self.0.begin_again();
    }

    /// Goes back to the start, as if nothing was known, with the tables that were made.
    pub fn rewind(&mut self) {
        self.0.rewind();
    }

    /// Takes coordinates of a run to an accuracy, by their index, to be at least so large. This comes before the first
    /// window, and before [`Self::resume`].
    pub fn set_floors(&mut self, floors: &[(usize, f64)]) {
        self.0.set_floors(floors);
    }

    /// Continues another run from its end, which is the start of this one. This comes before the first window.
    pub fn resume(&mut self, handed: &Handed) {
        self.0.resume(handed);
    }

    /// The largest error to expect at any node so far, relative to sizes, if the accuracy is promised.
    pub fn error_estimate(&self) -> Option<f64> {
        self.0.error_estimate()
    }

    /// The highest accuracy for which rounding leaves room so far, if errors are estimated.
    pub fn reachable(&self) -> Option<f64> {
        self.0.reachable()
    }

    /// γ from the start of the run until which the error estimate is below each of [`GOOD_DIGITS`]; 0 without one.
    pub fn good_until(&self) -> [f64; GOOD_DIGITS.len()] {
        self.0.good_until()
    }

    /// The sizes of all coordinates so far, which errors are relative to: their largest value, or way from the start if
    /// they are ignorable, but at least what the motion is about to make of them at the start. 0 for one that does not
    /// move at all.
    pub fn sizes(&self) -> Vec<f64> {
        self.0.sizes()
    }

    /// γ from the start of the run and q^a where windows have come to; after a failure, where the motion leaves the
    /// domain, if that is the reason.
    pub fn place(&self) -> (f64, Vec<f64>) {
        self.0.place()
    }

    /// Number of windows so far between whose nodes something may hide, however short they are. Windows of one length
    /// are not looked at.
    pub fn unproved(&self) -> usize {
        self.0.unproved()
    }
}
