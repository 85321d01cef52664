//! A world-line that is looked at one window at a time.

use super::scene::Curve;
use super::{OutsideRun, partition, slack, within};
use crate::number::Real;
use crate::solve::WorldLine;

/// A world-line, and what was made of the window that was asked for last. It is kept until another one is.
#[derive(Debug)]
pub(super) struct Cursor<'l, S> {
    pub(super) line: &'l WorldLine<S>,
    current: Option<(usize, Curve<S>)>,
}

/// Where a coordinate has a value.
pub(super) struct Reached<S> {
    pub(super) window: usize,
    /// The value as joints count it, inside the run.
    pub(super) value: S,
}

impl<'l, S: Real> Cursor<'l, S> {
    pub(super) fn new(line: &'l WorldLine<S>) -> Self {
        Self { line, current: None }
    }

    /// The value that was made of a window, or the one that `make` makes of it.
    pub(super) fn of_window(&mut self, window: usize, make: impl FnOnce(&'l WorldLine<S>) -> Curve<S>) -> &Curve<S> {
        if self.current.as_ref().is_some_and(|(current, _)| *current != window) {
            self.current = None;
        }
        let Self { line, current } = self;
        &current.get_or_insert_with(|| (window, make(line))).1
    }

    /// The window in which γ has this value, and γ from its start.
    ///
    /// # Errors
    /// [`OutsideRun`] beyond the ends by more than rounding.
    pub(super) fn at_gamma(&self, gamma: S) -> Result<(usize, S), OutsideRun<S>> {
        let (line, WorldLine { gamma_i, windows, digits, .. }) = (self.line, self.line);
        let ends = windows.first().zip(windows.last()).map(|(first, last)| [first.gamma[0], last.gamma[1]]);
        let ends = ends.ok_or(OutsideRun { range: (*gamma_i, *gamma_i) })?;
        let from_start = within(line.signed(gamma - *gamma_i), ends, slack(*digits)).ok_or_else(|| {
            let [first, last] = [line.gamma_at(ends[0]), line.gamma_at(ends[1])];
            OutsideRun { range: if line.is_backward { (last, first) } else { (first, last) } }
        })?;
        let window = self.window_at(from_start);
        Ok((window, from_start - windows[window].gamma[0]))
    }

    /// The window with this γ − γ_i.
    pub(super) fn window_at(&self, from_start: S) -> usize {
        let windows = &self.line.windows;
        partition(windows.len(), |window| windows[window].gamma[0] <= from_start)
    }

    /// Where coordinate `a`, which grows or falls all the way, has this value.
    ///
    /// # Errors
    /// [`OutsideRun`] with the range of the coordinate, beyond it by more than rounding.
    pub(super) fn at_value(&self, a: usize, value: S) -> Result<Reached<S>, OutsideRun<S>> {
        let (line, origin) = (self.line, self.line.origin_of(a));
        if line.windows.is_empty() {
            return Err(OutsideRun { range: (origin, origin) });
        }
        let [first, last] = [0, line.windows.len()].map(|joint| line.joint(joint).q[a]);
        let falls = last < first;
        let [low, high] = if falls { [last, first] } else { [first, last] };
        let value = within(value - origin, [low, high], slack(line.digits))
            .ok_or(OutsideRun { range: (origin + low, origin + high) })?;
        let reached = |here: S| if falls { here >= value } else { here <= value };
        let window = partition(line.windows.len(), |window| reached(line.joint(window).q[a]));
        Ok(Reached { window, value })
    }
}
