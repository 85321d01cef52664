//! A case solved: where its events act, in pieces; and the events that the judge of the run has met.

use super::acting::{Chains, Piece, Stopped, solve_acting};
use super::errors::events_of_chain;
use crate::case::Case;
use crate::number::{Kind, Real};
use crate::solve::{Setup, WorldLine, solve_observed};
use crate::trajectory::{Crossing, EventSearch, Watch};

/// Sees windows as they are solved, each as a world-line of its own.
pub(super) type EveryWindow<'o, S> = &'o mut dyn FnMut(&WorldLine<S>);

/// A run in pieces, and the events that its judge has met, if it has one.
pub(super) type Solved<S> = (Chains<S>, Option<Vec<Crossing<S>>>);

/// The chains of a run, or why it has not come to its end.
struct MaybeChains;

impl Kind for MaybeChains {
    type Of<S: Real> = Result<Chains<S>, Box<Stopped<S>>>;
}

/// Solves the setup of a case, whose judge looks for `watches`. The observer, if there is one, sees a run in which no
/// event acts window by window, and only the last window of it is kept.
pub(super) fn solved<S: Real>(
    case: &Case,
    setup: &Setup<S>,
    watches: &[Watch<S>],
    observer: Option<EveryWindow<'_, S>>,
) -> Result<Solved<S>, Box<Stopped<S>>> {
    if setup.has_acting_events() {
        // Events act in runs to an accuracy, which exclude further digits.
        let found = || solve_acting(case, &setup.in_f64());
        let chains = S::choose::<MaybeChains>(found, || unreachable!("events act in double precision"))?;
        let of_judge = (!chains.coarser.is_empty()).then(|| events_of_chain(case, &chains.coarser));
        return Ok((chains, of_judge));
    }
    let mut watches = watches.to_vec();
    let is_paired = !watches.is_empty() && setup.settings.is_judged_on_its_way();
    let mut search = EventSearch::new(&mut watches);
    let mut see = |part: &WorldLine<S>| search.see(part);
    let of_judge: Option<EveryWindow<'_, S>> = if is_paired { Some(&mut see) } else { None };
    let line = solve_observed(setup, observer, of_judge);
    let line = line.map_err(|unfinished| Stopped::at(*unfinished, setup.clone(), Vec::new()))?;
    let chains = Chains::alone(vec![Piece { line, setup: setup.clone(), acted: Vec::new() }]);
    Ok((chains, is_paired.then(|| search.found())))
}
