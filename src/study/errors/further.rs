//! The errors that a run does not make itself: what it inherits from the run that it continues, and what its formulas
//! lose to rounding. Both travel as errors of its start, see [`Along::carried`].

use std::cell::OnceCell;

use super::added_up::added_up;
use super::carried::{Along, Carried, Extent};
use super::conditioning::{FAR, Formulas, Lost};
use super::ends::{End, rates_of_momenta};
use super::evaluated::ORDINARY;
use super::finding::{Finding, of_coordinate};
use super::meetings::{at_start, met};
use super::sights::Sights;
use super::{Noise, RunError};
use crate::case::Case;
use crate::diagnostics::verdict::{CoordinateError, Reason};
use crate::engine::{Accuracy, GOOD_DIGITS, Rounds};
use crate::geometry::{Geometry, Start};
use crate::number::norm::larger;
use crate::number::{Extended, Real};
use crate::solve::{Off, Setup, WorldLine};

/// Findings where nothing is known, and remedies.
const NOT_HANDED_ON: &str = "the error of the run that it continues is not known, since its summary does not say";
const NO_END: &str = "it is not known what the error of the run that it continues grows to: a run from a start that is \
                      off by it does not reach the end";
const NO_VALUE: &str = "it is not known what rounding takes from the formulas: in 70 digits they have no value here";
const AGAIN: &str = "run that one again, or the whole from its start";
const SMALLER: &str = "run that one to a smaller error, or end this one earlier";
const WELL: &str = "write it so that nothing cancels";

/// A part of the error of a run that it does not make itself.
#[derive(Debug, Clone, PartialEq)]
enum Part {
    /// There is none.
    Nothing,
    /// It is known.
    Known(Carried),
    /// It is not known, for this reason.
    Unknown(Reason),
}

impl Part {
    /// What a start that is off by `off` makes of the run, or the reason why that is not known.
    fn new(carried: Option<Carried>, reason: impl FnOnce() -> Reason) -> Self {
        carried.map_or_else(|| Self::Unknown(reason()), Self::Known)
    }

    /// The same, if the end of the run is off by this, too.
    fn with(self, Off { q, p }: Off) -> Self {
        let add = |to: &mut [f64], off: &[f64]| to.iter_mut().zip(off).for_each(|(to, off)| *to += off.abs());
        match self {
            Self::Nothing => Self::Known(Carried { largest: q.clone(), end: q.clone(), off: Off { q, p } }),
            Self::Known(Carried { off: mut all, mut largest, mut end }) => {
                for to in [&mut largest, &mut end, &mut all.q] {
                    add(to, &q);
                }
                add(&mut all.p, &p);
                Self::Known(Carried { off: all, largest, end })
            }
            Self::Unknown(_) => self,
        }
    }

    fn known(&self) -> Option<&Carried> {
        if let Self::Known(carried) = self { Some(carried) } else { None }
    }

    fn unknown(&self) -> Option<&Reason> {
        if let Self::Unknown(reason) = self { Some(reason) } else { None }
    }

    /// The largest error of a coordinate.
    fn largest(&self, a: usize) -> f64 {
        self.known().map_or(0.0, |carried| carried.largest[a])
    }

    /// The coordinate in which it is largest beside the size, with its error.
    fn most<'e>(&self, errors: &'e [CoordinateError]) -> Option<(&'e CoordinateError, f64)> {
        let each = errors.iter().enumerate().map(|(a, error)| (error, self.largest(a)));
        each.max_by(|(one, here), (other, there)| one.share(*here).total_cmp(&other.share(*there)))
    }

    /// Returns true if an error is too large with all parts, but not by what the run makes itself, and this is the
    /// larger part; or if this part alone is too large. What is not a number is too large.
    fn is_to_blame(&self, other: &Self, own: &[CoordinateError], all: &[CoordinateError]) -> bool {
        let is_innocent = |(a, (own, all)): (usize, (&CoordinateError, &CoordinateError))| {
            let [here, there, allowed] = [self.largest(a), other.largest(a), own.allowed()];
            here <= allowed && (all.largest <= allowed || own.largest > allowed || here < there)
        };
        self.known().is_some() && !own.iter().zip(all).enumerate().all(is_innocent)
    }
}

/// The errors that a run does not make itself.
#[derive(Debug)]
pub(crate) struct Further {
    inherited: Part,
    lost: Part,
    /// The sentence about the formula that loses digits, and the remedy.
    of_formula: [String; 2],
    /// The sizes of momenta along the run.
    momenta: Vec<f64>,
    /// The share that rounding takes from slopes.
    share: f64,
    /// The largest losses of what it is certified with, at the places that were seen.
    certified: Vec<f64>,
    moves_events: bool,
}

impl Further {
    /// Those of a run of `case` that ends with `line`, of which this was seen.
    pub(crate) fn new<S: Real>(case: &Case, setup: &Setup<S>, line: &WorldLine<S>, sights: &Sights) -> Self {
        let length = line.signed(line.gamma_f() - setup.gamma_i).to_f64();
        let (formulas, certified) = Formulas::new(case, setup, sights);
        let share = if let Formulas::Lost(Lost { share, .. }) = &formulas { *share } else { 0.0 };
        let extent = Extent { length, end: End::new(setup, line), lost: share };
        let again = OnceCell::new();
        let again = || again.get_or_init(|| Along::new(case, setup, &extent)).as_ref();
        let along = |off: &Off| again()?.carried(case, setup, &extent, off);
        let inherited = match setup.carried.as_ref().map(|carried| &carried.error) {
            None => Part::Nothing,
            Some(None) => Part::Unknown(Reason::new(NOT_HANDED_ON, AGAIN).remaining()),
            Some(Some(off)) if off.is_none() => Part::Nothing,
            Some(Some(off)) => Part::new(along(off), || Reason::new(NO_END, AGAIN).remaining()),
        };
        let n = setup.place.start.q.len();
        let momenta = sights.places.sizes_of_momenta(n);
        let mut off = met(case, setup, &sights.places);
        off.iter_mut().zip(at_start(case, setup, length)).for_each(|(off, more)| *off += more);
        let rounded = rounded_along(&formulas, line, sights, &momenta);
        let is_rounded_alone = formulas == Formulas::Conditioned && off.iter().all(|off| *off == 0.0);
        let met = Met::new(&setup.rough.geometry, [&off, &rounded], &momenta);
        let (lost, of_formula) = match (formulas, met) {
            (Formulas::Unknown, _) => (Part::Unknown(Reason::new(NO_VALUE, WELL)), Default::default()),
            (Formulas::Conditioned, None) => (Part::Nothing, Default::default()),
            (formulas, met) => {
                let mut sizes =
                    Off { q: vec![0.0; n], p: met.as_ref().map_or_else(|| vec![0.0; n], |met| met.off.clone()) };
                let mut is_known = true;
                let mut of_formula = met.map(|Met { finding, remedy, .. }| [finding, remedy]);
                if let Formulas::Lost(lost) = formulas {
                    let nodes = line.window_count * line.windows.last().map_or(1, |window| window.points() - 1);
                    let sum = again().and_then(|again| added_up((case, setup), &lost, &again.sights, (length, nodes)));
                    is_known = sum.is_some();
                    let Off { q, p } = sum.unwrap_or_else(|| Off::none(n));
                    sizes.q.iter_mut().zip(q).chain(sizes.p.iter_mut().zip(p)).for_each(|(size, off)| *size += off);
                    of_formula = Some(told(case, lost.finding, setup.settings.accuracy));
                }
                let [finding, remedy] = of_formula.unwrap_or_default();
                let off = in_energy(&setup.rough.geometry, &setup.rough.start, sizes);
                let found = if is_known { along(&off) } else { None };
                let is_seen = is_rounded_alone && found.as_ref().is_some_and(|found| found.is_below(&line.errors));
                if is_seen {
                    (Part::Nothing, Default::default())
                } else {
                    (Part::new(found, || Reason::new(&finding, &remedy)), [finding, remedy])
                }
            }
        };
        let moves_events = [&inherited, &lost].into_iter().any(|part| *part != Part::Nothing);
        let further = Self { inherited, lost, of_formula, momenta, share, certified, moves_events };
        match of_end(case, setup, line) {
            None => further,
            Some((off, finding)) => further.with(off, told(case, finding, setup.settings.accuracy)),
        }
    }

    /// The same, if the end of the run is off by this, too.
    fn with(self, off: Off, of_end: [String; 2]) -> Self {
        let of_formula = if self.lost == Part::Nothing { of_end } else { self.of_formula };
        Self { lost: self.lost.with(off), of_formula, ..self }
    }

    /// True if events are off by them: that the end of a run is rounded moves none.
    pub(crate) fn moves_events(&self) -> bool {
        self.moves_events
    }

    /// Where they are larger than what is good to some digits, the run is nowhere known to be good to these.
    pub(crate) fn limit<S: Real>(&self, line: &mut WorldLine<S>) {
        let WorldLine { good_until, sizes, .. } = line;
        let share = |(a, size): (usize, &f64)| (self.inherited.largest(a) + self.lost.largest(a)) / size;
        let most = sizes.iter().enumerate().filter(|(_, size)| **size > 0.0).map(share).fold(0.0, larger);
        let is_unknown = [&self.inherited, &self.lost].into_iter().any(|part| part.unknown().is_some());
        for (until, digits) in good_until.iter_mut().zip(GOOD_DIGITS) {
            let is_good = !is_unknown && most <= 10.0_f64.powi(-digits);
            *until = if is_good { *until } else { 0.0 };
        }
    }

    /// The error of a run with what it does not make itself.
    pub(crate) fn added(&self, own: &RunError) -> RunError {
        let mut all = own.clone();
        for carried in [&self.inherited, &self.lost].into_iter().filter_map(Part::known) {
            all.end.iter_mut().zip(&carried.end).for_each(|(error, end)| *error += end);
            all.largest.iter_mut().zip(&carried.largest).for_each(|(error, largest)| *error += largest);
        }
        all
    }

    /// The losses of its formulas to rounding, where they are more than any formula has.
    pub(crate) fn noise(&self) -> Noise {
        Noise { share: self.share, norm: self.of_certificate().last().copied().unwrap_or(0.0) }
    }

    /// The losses that the forces and K may have, with which a run is certified. Rounding is bounded, so that some
    /// places have seen half of the most.
    pub(crate) fn of_certificate(&self) -> Vec<f64> {
        self.certified.iter().map(|off| 2.0 * off).collect()
    }

    /// The largest inherited errors of coordinates along the run, if it inherits any.
    pub(crate) fn inherited(&self) -> Option<Vec<f64>> {
        self.inherited.known().map(|carried| carried.largest.clone())
    }

    /// The reasons to doubt a run that lie in these errors, where `own` are those that it makes itself, and `all` are
    /// both together. It may be one to an `accuracy`.
    pub(crate) fn reasons(
        &self,
        own: &[CoordinateError],
        all: &[CoordinateError],
        accuracy: Option<Accuracy>,
    ) -> Vec<Reason> {
        let Self { inherited, lost, of_formula: [finding, remedy], .. } = self;
        let mut reasons: Vec<Reason> = [lost, inherited].into_iter().filter_map(Part::unknown).cloned().collect();
        // What is promised is promised of the motion that the formulas stand for.
        let promised = accuracy.filter(|accuracy| accuracy.is_promised()).map_or(f64::INFINITY, Accuracy::value);
        let is_kept = own.iter().enumerate().all(|(a, own)| own.share(lost.largest(a)) <= promised);
        // Where nothing is known of the error, the formula may be why.
        let is_all = own.is_empty() && lost.known().is_some();
        if is_all || !is_kept || lost.is_to_blame(inherited, own, all) {
            let of = lost.most(own).map(|(one, error)| format!(", and {} is uncertain by {error:.1e}", one.name));
            reasons.insert(0, Reason::new(format!("{finding}{}", of.unwrap_or_default()), remedy));
        }
        if inherited.is_to_blame(lost, own, all) {
            let of = inherited.most(own).map(|(one, error)| format!(" to {error:.1e} in {}", one.name));
            let finding = format!("the error of the run that it continues grows{}", of.unwrap_or_default());
            reasons.push(Reason::new(finding, SMALLER).remaining());
        }
        reasons
    }

    /// By how much the state at the end of `line` is off, whose own errors are these; `None` if a part of it is not
    /// known. Momenta have at least the share of their size that the coordinate has, as in an oscillation, and what a
    /// judge found them to be off by, if it did.
    pub(crate) fn left<S: Real>(
        &self,
        setup: &Setup<S>,
        line: &WorldLine<S>,
        own: &[CoordinateError],
        found: Option<&[f64]>,
    ) -> Option<Off> {
        let (geometry, n, end) = (&*setup.rough.geometry, self.momenta.len(), line.end_inside().in_f64());
        if [&self.inherited, &self.lost].into_iter().any(|part| part.unknown().is_some()) {
            return None;
        }
        let mut all = Off::none(n);
        for Carried { off, .. } in [&self.inherited, &self.lost].into_iter().filter_map(Part::known) {
            all.q.iter_mut().zip(&off.q).chain(all.p.iter_mut().zip(&off.p)).for_each(|(all, off)| *all += off);
        }
        let mut sizes = Off::none(n);
        for (a, error) in own.iter().enumerate() {
            sizes.q[a] = error.end;
            if geometry.active().contains(&a) {
                let share = error.share(error.end) * self.momenta[a];
                sizes.p[a] = found.map_or(share, |found| larger(share, found[a]));
            }
        }
        let own = in_energy(geometry, &end, sizes);
        // Errors add up.
        let energy =
            rates_of_momenta(geometry, &end).into_iter().zip(&all.q).map(|(rate, off)| -rate * off).sum::<f64>()
                + end.q_dot.iter().zip(&all.p).map(|(rate, off)| rate * off).sum::<f64>();
        let sign = if energy < 0.0 { -1.0 } else { 1.0 };
        all.q.iter_mut().zip(own.q).chain(all.p.iter_mut().zip(own.p)).for_each(|(all, own)| *all += sign * own);
        all.p.iter_mut().for_each(|p| *p = line.signed(S::from(*p)).to_f64());
        Some(all)
    }
}

/// By how much momenta are moved in all as coordinates are rounded, where nothing else knows of it. The rounding of a
/// coordinate that is far from 0 is part of what formulas lose. A march and its judge round alike where they have the
/// same nodes, and differ by more elsewhere.
fn rounded_along<S: Real>(formulas: &Formulas, line: &WorldLine<S>, sights: &Sights, momenta: &[f64]) -> Vec<f64> {
    let is_far = matches!(formulas, Formulas::Lost(lost) if lost.finding.far.is_some());
    let known = line.error_estimate.unwrap_or(0.0);
    let rounded: Vec<f64> = sights.loudest.moved_by_rounding().collect();
    let is_known = rounded.iter().zip(momenta).all(|(rounded, size)| *rounded <= known * size);
    if is_far || is_known { vec![0.0; momenta.len()] } else { rounded }
}

/// What is said of a formula that loses digits, and what to do about it.
fn told(case: &Case, Finding { sentence, is_all, far }: Finding, accuracy: Option<Accuracy>) -> [String; 2] {
    let well = far.map_or_else(|| WELL.to_owned(), |name| format!("count {name} from a value near its start"));
    let remedy = match accuracy {
        // Events act in runs to an accuracy, which have no further digits.
        _ if is_all || case.has_acting_events() => well,
        None => format!("{well}, or take solver.digits = 32"),
        Some(_) => format!("{well}, or take solver.digits = 32 with a scheme and a grid"),
    };
    [sentence, remedy]
}

/// By how much a run is off at the end if it ends at a time that is far from 0 beside the way there, or where motion is
/// fast: few decimals are doubles.
fn of_end<S: Real>(case: &Case, setup: &Setup<S>, line: &WorldLine<S>) -> Option<(Off, Finding)> {
    let (coordinate, value) = line.ended_at.filter(|_| !S::IS_EXTENDED)?;
    let start = setup.rough.start.q[coordinate] + setup.origin_of(coordinate).to_f64();
    let (value, state) = (value.to_f64(), line.end().in_f64());
    let rounding = (case.t_f::<Extended>()? - Extended::from(value)).to_f64().abs();
    let way = (value - start).abs();
    if way == 0.0 || rounding == 0.0 {
        return None;
    }
    let late = rounding / state.q_dot[coordinate].abs();
    let off = |rates: Vec<f64>| rates.into_iter().map(|rate| late * rate.abs()).collect::<Vec<f64>>();
    let mut q = off(state.q_dot.clone());
    // The least error that a run claims has room for a part of itself.
    let least = line.accuracy.map_or(f64::INFINITY, |accuracy| ROOM * Rounds::new(accuracy).error(0.0));
    let is_claimed = q.iter().zip(&line.sizes).all(|(off, size)| *off <= least * size);
    if value.abs() <= FAR * way && is_claimed {
        return None;
    }
    q[coordinate] = 0.0;
    let p = off(rates_of_momenta(&setup.rough.geometry, &state));
    Some((Off { q, p }, of_coordinate(&setup.rough.geometry.names()[coordinate], value, rounding / way)))
}

/// The least error that a run claims has room for so much of itself that comes from elsewhere.
const ROOM: f64 = 0.1;

/// What is uncertain since forces jump at places that are rounded.
struct Met {
    /// By how much each momentum is.
    off: Vec<f64>,
    finding: String,
    remedy: String,
}

impl Met {
    /// Adds up what is `met` and what the rounding of coordinates changes of forces that are steep. `None` if it is no
    /// more than any formula loses, beside the sizes of momenta.
    fn new(geometry: &Geometry, [met, rounded]: [&[f64]; 2], momenta: &[f64]) -> Option<Self> {
        let off: Vec<f64> = met.iter().zip(rounded).map(|(met, rounded)| met + rounded).collect();
        let most = off.iter().zip(momenta).enumerate().max_by(|(_, one), (_, other)| one.0.total_cmp(other.0));
        let (a, (most, _)) = most.filter(|(_, (met, size))| **met > ORDINARY * **size)?;
        let name = &geometry.names()[a];
        let what = if met[a] >= rounded[a] {
            "where a force jumps is known to rounding alone, which"
        } else {
            "a force is so steep that the rounding of what it depends on"
        };
        let finding = format!("{what} leaves {most:.1e} of p_{name} open");
        let remedy = "let it rise over some way, or count the coordinate from near that place".to_owned();
        Some(Self { off, finding, remedy })
    }
}

/// Errors of this size in all numbers, with the signs by which they change the energy of `state` most:
/// dH = q̇ dp − ṗ dq.
fn in_energy(geometry: &Geometry, state: &Start, Off { q, p }: Off) -> Off {
    let rates = rates_of_momenta(geometry, state);
    Off {
        q: q.into_iter().zip(rates).map(|(size, rate)| if rate > 0.0 { -size } else { size }).collect(),
        p: p.into_iter().zip(&state.q_dot).map(|(size, rate)| if *rate < 0.0 { -size } else { size }).collect(),
    }
}
