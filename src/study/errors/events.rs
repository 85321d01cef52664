//! The errors of events: the march or the chain that judges a run meets them by itself, and they are paired.
//!
//! The first, second … event of a name in one are the first, second … in the other. What they differ by in γ and in
//! every coordinate is what they are off by, as what the two runs differ by anywhere is. Two runs may agree at a place
//! by chance, so that no event is said to be better than those before; and in a window that both have they agree on
//! anything, so that none is better than the tolerance of the finer run, as no other place is.

use super::conditioning::FAR;
use crate::case::Case;
use crate::engine::Rounds;
use crate::number::Real;
use crate::number::norm::larger;
use crate::solve::{Setup, WorldLine};
use crate::study::acting::{MARGIN, Piece};
use crate::trajectory::{Crossing, EventSearch, Sample, Sampler, late_at_end};

/// The last digits of a run, relative to γ, which two runs may round alike.
const ROUNDED: f64 = 16.0 * f64::EPSILON;
/// A run that is known until this share of it is known as a whole.
const WHOLE: f64 = 1.0 - 1e-9;

/// The facts about a run whose events are paired.
#[derive(Debug, Clone)]
pub(crate) struct OfRun {
    /// γ at its start and at its end.
    pub(crate) ends: [f64; 2],
    /// γ from the start until which something is known of it.
    pub(crate) until: f64,
    /// Its error, relative to sizes, the least that it may be, and these.
    pub(crate) error: f64,
    pub(crate) least: f64,
    pub(crate) sizes: Vec<f64>,
    /// The factor by which differences count.
    pub(crate) margin: f64,
}

impl OfRun {
    /// Takes them from the first piece of a judged run and its last one, which are one where no event acts.
    pub(crate) fn new<S: Real>(first: &WorldLine<S>, last: &WorldLine<S>) -> Self {
        let (begin, before) = (first.gamma_i.to_f64(), (last.gamma_i - first.gamma_i).to_f64().abs());
        Self {
            ends: [begin, last.gamma_f().to_f64()],
            until: before + last.good_until[0],
            error: last.error_estimate.unwrap_or(f64::INFINITY),
            least: last.accuracy.map_or(0.0, |accuracy| Rounds::new(accuracy).error(0.0)),
            sizes: last.sizes.clone(),
            margin: if before > 0.0 { MARGIN } else { 1.0 },
        }
    }
}

/// The events of a run, and what the march or the chain that judges it has met.
pub(crate) struct Paired<S> {
    /// The events, with errors where they are known.
    pub(crate) events: Vec<Crossing<S>>,
    /// The name of the first event that only one of both has met, if there is one.
    pub(crate) unpaired: Option<String>,
    /// The errors of the coordinates at the end, if the zero of a formula ended the run and the judge has met that.
    pub(crate) at_end: Option<Vec<f64>>,
}

/// Pairs the events of a run that ends with `line` with those of its judge, if it has one.
pub(crate) fn paired<S: Real>(
    case: &Case,
    (line, setup): (&WorldLine<S>, &Setup<S>),
    found: Vec<Crossing<S>>,
    of_judge: Option<&[Crossing<S>]>,
    run: &OfRun,
) -> Paired<S> {
    let (ending, until) = (ending_watch(case, line), case.events.len());
    let late = |place: usize| late_at_end(line, &setup.until[place].formula);
    let ending = line.ended_by.zip(ending);
    let mut events = ended_once(found, line, ending.map(|(place, watch)| (watch, late(place))));
    let unpaired = of_judge.and_then(|of_judge| pair(&mut events, of_judge, run));
    let end = events
        .iter()
        .rfind(|event| ending.is_some_and(|(_, watch)| event.watch == watch) && event.sample.gamma == line.gamma_f());
    let at_end = end.and_then(|event| event.off.as_ref()).map(|off| off[1..].to_vec());
    events.retain(|event| event.watch != until);
    let name = |watch: usize| case.events.get(watch).map_or("grid.until", |event| &event.name).to_owned();
    Paired { events, unpaired: unpaired.map(name), at_end }
}

/// The events of a chain, with those that have acted in it.
pub(crate) fn events_of_chain<S: Real>(case: &Case, pieces: &[Piece<S>]) -> Vec<Crossing<S>> {
    let (mut watches, acting) = (case.watches_with_until(), case.acting_watches());
    let (mut search, mut set) = (EventSearch::new(&mut watches), &Vec::new());
    for Piece { line, setup, acted } in pieces {
        if setup.set != *set {
            set = &setup.set;
            let case = case.with_parameters(set, &setup.rough.start.q).expect("it was solved with these numbers");
            search.replace(&case.watches_with_until());
        }
        search.see(line);
        let acted: Vec<usize> = acted.iter().filter_map(|&place| acting[place]).collect();
        search.act(line, &acted, &acting);
    }
    search.found()
}

/// The number of events before the end of a run of which the first should have ended it, as `ends` says of their watch.
pub(crate) fn passed<S: Real>(events: &[Crossing<S>], run: &OfRun, ends: impl Fn(usize) -> bool) -> usize {
    let [begin, end] = run.ends;
    let near = (1.0 - WHOLE) * (end - begin).abs();
    events.iter().filter(|event| ends(event.watch) && (end - event.sample.gamma.to_f64()).abs() > near).count()
}

/// The first place where an event may have been passed unseen, in the table of events or among those that end pieces of
/// the run.
pub(crate) fn first_unseen<'l, S: Real>(
    case: &Case,
    found: Option<(usize, S)>,
    pieces: impl Iterator<Item = &'l WorldLine<S>>,
) -> Option<(String, f64)> {
    let found = found.map(|(watch, gamma)| (case.events[watch].name.clone(), gamma.to_f64()));
    let of_piece = |line: &WorldLine<S>| named(case, line, line.watched.unseen);
    found.or_else(|| pieces.into_iter().find_map(of_piece))
}

/// The first place where a formula that ends pieces of the run turns so near to zero that errors decide whether it
/// changes its sign.
pub(crate) fn first_touched<'l, S: Real>(
    case: &Case,
    mut pieces: impl Iterator<Item = &'l WorldLine<S>>,
) -> Option<(String, f64)> {
    pieces.find_map(|line| named(case, line, line.watched.touched))
}

/// The name of a formula that ends pieces, and γ, of its place and γ from the start of a piece.
fn named<S: Real>(case: &Case, line: &WorldLine<S>, found: Option<(usize, f64)>) -> Option<(String, f64)> {
    let (place, gamma) = found?;
    Some((case.ending_names()[place].to_owned(), line.gamma_at(S::from(gamma)).to_f64()))
}

/// The watch whose event ended a run, if one did. `grid.until` is watched behind all events.
fn ending_watch<S: Real>(case: &Case, line: &WorldLine<S>) -> Option<usize> {
    let formula = line.ended_by.and_then(|place| case.watched_formulas().nth(place))?;
    Some(formula.event.unwrap_or(case.events.len()))
}

/// The events of a run, in which the one that ended it stands once, and last. Where a force that jumps holds the motion
/// at its surface, rounding sends it to and fro, and the event would be met several times just before the end.
fn ended_once<S: Real>(
    mut events: Vec<Crossing<S>>,
    line: &WorldLine<S>,
    ending: Option<(usize, S)>,
) -> Vec<Crossing<S>> {
    let Some((watch, late)) = ending else { return events };
    let Ok(sample) = Sampler::new(line).at_gamma(line.gamma_f()) else { return events };
    let end = sample.gamma.to_f64();
    let near = (1.0 - WHOLE) * (end - line.gamma_i.to_f64()).abs();
    events.retain(|event| event.watch != watch || (end - event.sample.gamma.to_f64()).abs() > near);
    let behind = events.iter().rev().take_while(|event| event.sample.gamma == sample.gamma && event.watch > watch);
    let place = events.len() - behind.count();
    events.insert(place, Crossing { watch, sample, late, off: None });
    events
}

/// By how much γ of an event is off as coordinates that are far from 0 beside their sizes are rounded, such as a time
/// in seconds of a calendar.
fn rounding<S: Real>(Sample { q, q_dot, .. }: &Sample<S>, sizes: &[f64]) -> f64 {
    let late = |((q, rate), size): ((&S, &S), &f64)| {
        let (q, rate) = (q.to_f64().abs(), rate.to_f64().abs());
        if q > FAR * size && rate > 0.0 { 2.0 * f64::EPSILON * q / rate } else { 0.0 }
    };
    q.iter().zip(q_dot).zip(sizes).map(late).fold(0.0, larger)
}

/// Says of every event of a run by how much it is off, as those of its judge tell. Returns the first that only one of
/// the two has met, if there is one: its watch.
fn pair<S: Real>(events: &mut [Crossing<S>], of_judge: &[Crossing<S>], run: &OfRun) -> Option<usize> {
    let [begin, end] = run.ends;
    let length = (end - begin).abs();
    let until = if run.until >= WHOLE * length { f64::INFINITY } else { run.until };
    let from_start = |event: &Crossing<S>| (event.sample.gamma.to_f64() - begin).abs();
    let of_sizes = run.sizes.iter().map(|size| run.least * size);
    let mut most: Vec<f64> = std::iter::once(ROUNDED * begin.abs().max(end.abs())).chain(of_sizes).collect();
    let watches = 1 + events.iter().chain(of_judge).map(|event| event.watch).max().unwrap_or(0);
    // Those that have no partner yet, by their watch.
    let of = |watch: usize| of_judge.iter().filter(move |event| event.watch == watch);
    let mut others: Vec<_> = (0..watches).map(of).collect();
    let mut alone: Vec<(f64, usize)> = Vec::new();
    for event in events.iter_mut().filter(|event| from_start(event) <= until) {
        let Some(other) = others[event.watch].next() else {
            alone.push((from_start(event), event.watch));
            continue;
        };
        let q = event.sample.q.iter().zip(&other.sample.q).map(|(&one, &other)| one - other);
        let differences = std::iter::once(event.sample.gamma - other.sample.gamma).chain(q);
        for (most, difference) in most.iter_mut().zip(differences) {
            *most = larger(*most, run.margin * difference.to_f64().abs());
        }
        // γ has the size of what of it is behind.
        most[0] = larger(most[0], run.least * from_start(event));
        let late = larger(rounding(&event.sample, &run.sizes), larger(event.late, other.late).to_f64());
        let rates = std::iter::once(1.0).chain(event.sample.q_dot.iter().map(|rate| rate.to_f64().abs()));
        most.iter_mut().zip(rates).for_each(|(most, rate)| *most = larger(*most, rate * late));
        event.off = Some(most.clone());
    }
    alone.extend(others.into_iter().flatten().map(|event| (from_start(event), event.watch)));
    // The last event of a run may be behind the end of the other. In units of γ that is known as well as coordinates
    // that go the way of their size in the run.
    let near = length.min(until) - 2.0 * run.error * length;
    let first = alone.into_iter().filter(|(gamma, _)| *gamma < near).min_by(|one, other| one.0.total_cmp(&other.0));
    first.map(|(_, watch)| watch)
}

#[cfg(test)]
mod tests {
    use super::{OfRun, pair};
    use crate::trajectory::{Crossing, Sample};

    fn events(met: &[(usize, f64)]) -> Vec<Crossing> {
        let sample = |gamma: f64| Sample { gamma, q: vec![2.0 * gamma], q_dot: vec![2.0], p: vec![2.0] };
        met.iter().map(|&(watch, gamma)| Crossing { watch, sample: sample(gamma), late: 0.0, off: None }).collect()
    }

    fn run(until: f64) -> OfRun {
        OfRun { ends: [0.0, 10.0], until, error: 1e-6, least: 1e-9, sizes: vec![20.0], margin: 1.0 }
    }

    /// Errors are differences of pairs, and no event is better than those before.
    #[test]
    fn events_of_a_name_are_paired_in_their_order() {
        let mut own = events(&[(0, 1.0), (1, 2.0), (0, 3.0), (0, 9.0)]);
        let found = pair(&mut own, &events(&[(0, 1.25), (0, 3.125), (1, 2.5), (0, 9.0)]), &run(10.0));
        assert_eq!(found, None);
        let errors: Vec<f64> = own.iter().map(|event| event.off.as_ref().unwrap()[0]).collect();
        assert_eq!(errors, [0.25, 0.5, 0.5, 0.5]);
        assert_eq!(own[1].off.as_ref().unwrap()[1], 1.0);
    }

    /// An event that only one of both meets has no error, and is named; but behind what is known nobody looks, and at
    /// the end of a run the other one may not have come to it.
    #[test]
    fn an_event_that_one_run_meets_alone_is_named() {
        let (more, less) = (&[(0, 1.0), (1, 4.0), (0, 5.0)], &[(0, 1.0), (0, 5.0)]);
        let mut own = events(more);
        assert_eq!(pair(&mut own, &events(less), &run(10.0)), Some(1));
        assert!(own[1].off.is_none() && own[2].off.is_some());
        assert_eq!(pair(&mut events(less), &events(more), &run(10.0)), Some(1));
        assert_eq!(pair(&mut events(less), &events(more), &run(3.0)), None);
        let late = [(0, 1.0), (0, 5.0), (1, 9.999_999)];
        assert_eq!(pair(&mut events(&late), &events(less), &run(10.0)), None);
        assert_eq!(pair(&mut events(less), &events(&late), &run(10.0)), None);
    }
}
