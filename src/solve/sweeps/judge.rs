//! Windows of the march that judges a run, for whoever watches them beside it.

use std::sync::Arc;

use super::append;
use crate::engine::{Engine, Failure, POINTS, Window};
use crate::number::Real;
use crate::solve::grid::WindowOperator;
use crate::solve::run::Run;

/// The latest operators that are searched for one to share. Most runs have a dozen at most; where every window has a
/// length of its own, a search among all of them would take time quadratic in their number.
const SEARCHED: usize = 64;

/// The latest operators of windows.
pub(super) struct Operators<S>(Vec<Arc<WindowOperator<S>>>);

impl<S> Default for Operators<S> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<S: Real> Operators<S> {
    /// The operator of windows of this length, which is made again only if the last ones had others.
    pub(super) fn of_length(&mut self, length: S) -> Arc<WindowOperator<S>> {
        let known = self.0.iter().rev().find(|operator| operator.length == length).map(Arc::clone);
        known.unwrap_or_else(|| {
            self.0.drain(..usize::from(self.0.len() == SEARCHED));
            self.0.push(WindowOperator::element(POINTS, length));
            Arc::clone(&self.0[self.0.len() - 1])
        })
    }
}

/// The march that judges a run, for whoever watches it.
pub(super) struct Judge<'o, S: Real> {
    run: Run<'o, S>,
    operators: Operators<S>,
    /// False from a window on that is no solution: nothing is shown behind it.
    is_shown: bool,
}

impl<'o, S: Real> Judge<'o, S> {
    pub(super) fn new(run: Run<'o, S>) -> Self {
        Self { run, operators: Operators::default(), is_shown: true }
    }

    /// Shows what is left of it.
    pub(super) fn show(&mut self) {
        self.run.show();
    }

    /// Shows its next window, with others.
    fn see(&mut self, window: &mut Window<'_>) {
        if window.index == 0 {
            self.run.clear();
            self.is_shown = true;
        }
        if self.is_shown {
            let (operator, end) = (self.operators.of_length(S::from(window.length)), window.gamma + window.length);
            self.is_shown = append(&mut self.run, window, &operator, S::from(end)).is_ok();
            self.run.end_window();
        }
    }
}

/// The next window of a run. Those of its judge up to there are shown before.
pub(super) fn next<'e, S: Real>(
    engine: &'e mut Engine<'_>,
    judge: Option<&mut Judge<'_, S>>,
) -> Result<Option<Window<'e>>, Failure> {
    if let Some(judge) = judge {
        while let Some(mut window) = engine.next_of_judge()? {
            judge.see(&mut window);
        }
    }
    engine.next()
}
