//! A world-line and its companion, window by window.

use std::collections::BTreeMap;

use super::force::Force;
use super::ladder;
use super::march::{Marched, Run};
use super::rule::WeakRule;
use super::simd::Level;
use super::tables::{Matrix, Nodes, Tables, evaluation_matrix};
use super::twofold::Twofold;
use super::window::{Guess, Precision, Solved, Window};
use super::{State, Statistics};
use std::ops::ControlFlow;

/// How many nodes fewer the companion has.
const FEWER: usize = 4;

/// The tables of one length, for both.
type Both<const P: usize> = [Box<Tables<P>>; 2];

/// Everything that a walk of two needs, to be used again for the next attempt.
pub(super) struct Pair<const P: usize, F> {
    pub(super) rules: [&'static WeakRule; 2],
    level: Level,
    force: F,
    /// By rung of the ladder.
    tables: BTreeMap<i32, Both<P>>,
    /// Of the odd length asked for last.
    odd: Option<Both<P>>,
    /// Extrapolations of a from one window to the next that is one rung shorter, as long, one rung longer.
    extrapolations: [Box<Matrix<P>>; 3],
    /// From the nodes of the one to those of the other.
    resample: Box<Matrix<P>>,
    windows: [Window<P>; 2],
    /// The forces of the window before, and its rung.
    previous: Option<(i32, Nodes<P>)>,
}

/// The length of a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Length {
    Rung(i32),
    Odd(Twofold),
}

impl<const P: usize, F: Force> Pair<P, F> {
    pub(super) fn new(n: usize, force: F, level: Level) -> Self {
        let rules = [WeakRule::shared(n), WeakRule::shared(n - FEWER)];
        let extrapolation =
            |ratio: f64| evaluation_matrix::<P>(rules[0], (n - 1) * 3 / 4, |i| 1.0 + ratio * rules[0].nodes()[i].hi, n);
        let root_2 = std::f64::consts::SQRT_2;
        Self {
            rules,
            level,
            force,
            tables: BTreeMap::new(),
            odd: None,
            extrapolations: [extrapolation(1.0 / root_2), extrapolation(1.0), extrapolation(root_2)],
            resample: evaluation_matrix::<P>(rules[0], n - 1, |i| rules[1].nodes()[i].hi, n - FEWER),
            windows: [Window::new(), Window::new()],
            previous: None,
        }
    }

    /// Forgets the window before: a new march begins.
    pub(super) fn forget(&mut self) {
        self.previous = None;
    }

    /// The length as a number; its tables are ready afterwards.
    pub(super) fn prepare(&mut self, length: Length) -> Twofold {
        let [main, companion] = self.rules;
        // The highest two modes that the companion has.
        let tail = companion.points() - 2;
        let both = |h| [Tables::new(main, h, tail), Tables::new(companion, h, tail)];
        match length {
            Length::Rung(rung) => {
                let h = ladder::length(rung);
                self.tables.entry(rung).or_insert_with(|| both(h));
                h
            }
            Length::Odd(h) => {
                if self.odd.as_ref().is_none_or(|odd| odd[0].length != h) {
                    self.odd = Some(both(h));
                }
                h
            }
        }
    }

    /// The window of the world-line itself from `start`. Lengths must be prepared.
    pub(super) fn main(
        &mut self,
        length: Length,
        start: &State,
        precision: Precision,
        statistics: &mut Statistics,
    ) -> Option<Solved> {
        let guess = match (&self.previous, length) {
            (Some((before, values)), Length::Rung(rung)) if (rung - before).abs() <= 1 => {
                Guess::Forces { matrix: &self.extrapolations[(rung - before + 1) as usize], values }
            }
            _ => Guess::Parabola,
        };
        let tables = tables_of(&self.tables, self.odd.as_ref(), length);
        let window = &mut self.windows[0];
        single(self.level, &tables[0], &mut self.force, window, start, guess, precision, statistics)
    }

    /// The companion's window, starting from the forces of [`Self::main`], which is accepted with this.
    pub(super) fn companion(
        &mut self,
        length: Length,
        start: &State,
        precision: Precision,
        statistics: &mut Statistics,
    ) -> Option<Solved> {
        let [main, companion] = &mut self.windows;
        self.previous = match length {
            Length::Rung(rung) => Some((rung, main.a.clone())),
            Length::Odd(_) => None,
        };
        let guess = Guess::Forces { matrix: &self.resample, values: &main.a };
        let tables = tables_of(&self.tables, self.odd.as_ref(), length);
        single(self.level, &tables[1], &mut self.force, companion, start, guess, precision, statistics)
    }

    /// X, u and a of the world-line on its nodes.
    pub(super) fn nodes(&self) -> [&[f64]; 3] {
        let (n, window) = (self.rules[0].points(), &self.windows[0]);
        [&window.x.0[..n], &window.u.0[..n], &window.a.0[..n]]
    }
}

fn tables_of<'t, const P: usize>(
    rungs: &'t BTreeMap<i32, Both<P>>,
    odd: Option<&'t Both<P>>,
    length: Length,
) -> &'t Both<P> {
    match length {
        Length::Rung(rung) => &rungs[&rung],
        Length::Odd(_) => odd.expect("the length was prepared"),
    }
}

/// One window.
#[allow(clippy::too_many_arguments)]
fn single<const P: usize, F: Force>(
    level: Level,
    tables: &Tables<P>,
    force: &mut F,
    window: &mut Window<P>,
    start: &State,
    guess: Guess<'_, P>,
    precision: Precision,
    statistics: &mut Statistics,
) -> Option<Solved> {
    let mut marched = Marched { end: *start, statistics: Statistics::default() };
    let mut result = None;
    let mut see = |_: &Window<P>, _: usize, _: &State, solved: &Solved| {
        result = Some(*solved);
        ControlFlow::Continue(())
    };
    level.dispatch(Run { tables, force, window, guess, precision, windows: 1, marched: &mut marched, see: &mut see });
    statistics.evaluations += marched.statistics.evaluations;
    result
}
