//! Proofs of motions with events that act: from event to event, each from what the one before has made of the set.
//!
//! A proof that ends where a formula is 0 has the set of states there, in which errors keep what they have in common.
//! What the event makes of it is enclosed by the mean value: for x in the set around x̂
//!
//! ```text
//! R(x) = R(x̂) + J (x − x̂),   J in the derivatives over the set,
//! ```
//!
//! so that columns are multiplied by the middles of J, and what these leave is added to the radius. γ at the event is
//! known up to a radius, by which the rest of the way may be longer or shorter.

use crate::case::{Case, WatchedFormula};
use crate::geometry::{Jet, Jets, OfEnds, Reset, Start};
use crate::number::ball::{Ball, OFF};
use crate::number::{Extended, Real};
use crate::proof::{Coordinate, Event, Motion, Progress, Proof, Reason, Spread, Until, Watched, prove};
use crate::solve::Setup;

/// More than the roundings of sums of few terms.
const UP: f64 = 1.0 + 1e-12;

/// What the events of a case make of states.
pub(super) struct Acting {
    /// For every event of the case that acts.
    resets: Vec<Option<Reset>>,
}

impl Acting {
    /// Those of a case.
    ///
    /// # Errors
    /// The reason why there is no proof behind one of them.
    pub(super) fn new(case: &Case, setup: &Setup<Extended>) -> Result<Self, &'static str> {
        if !case.has_acting_events() {
            return Ok(Self { resets: Vec::new() });
        }
        let start = &setup.place.start;
        let norm = setup.place.geometry.norm(&start.q, &start.q_dot);
        let reset = |event| case.reset(event, norm);
        let resets = case.events.iter().map(|event| (!event.set.is_empty()).then(|| reset(event)).transpose());
        let resets: Vec<Option<Reset>> = resets.collect::<Result<_, _>>()?;
        let formulas: Vec<&str> = case.watched_formulas().chain(case.acting_formulas()).map(|of| of.formula).collect();
        let of: Vec<OfEnds<'_>> = formulas.iter().map(|end| OfEnds { end, starts: &[] }).collect();
        // By Newton's law that is the energy, which is not followed through an event.
        let mut jets = resets.iter().flatten().map(|reset| &reset.jets);
        let of_energy = |jets: &Jets| case.is_lifted() && jets.look_at_momentum(0);
        if of_energy(&case.jets_of(&of, norm)) || jets.any(of_energy) {
            return Err("an event that acts, beside a formula of the energy p_t");
        }
        Ok(Self { resets })
    }

    /// The coordinates whose momenta they change.
    pub(super) fn changed(&self) -> Vec<usize> {
        self.resets.iter().flatten().flat_map(|reset| reset.changed.iter().copied()).collect()
    }

    fn of(&self, formula: &WatchedFormula<'_>) -> Option<&Reset> {
        self.resets.get(formula.event?)?.as_ref()
    }
}

/// A motion through events that act.
pub(super) struct Through<'a> {
    pub(super) acting: &'a Acting,
    pub(super) formulas: &'a [WatchedFormula<'a>],
    /// The values of the formulas, and their derivatives.
    watched: Jets,
}

/// The state behind an event.
struct Behind {
    start: Start<Extended>,
    state: Vec<Option<Spread>>,
}

impl<'a> Through<'a> {
    pub(super) fn new(
        case: &Case,
        setup: &Setup<Extended>,
        acting: &'a Acting,
        formulas: &'a [WatchedFormula<'a>],
    ) -> Self {
        let start = &setup.place.start;
        let norm = setup.place.geometry.norm(&start.q, &start.q_dot);
        let of: Vec<OfEnds<'_>> = formulas.iter().map(|of| OfEnds { end: of.formula, starts: &[] }).collect();
        Self { watched: case.jets_of(&of, norm), acting, formulas }
    }

    /// Proves where a motion ends, through all events that act.
    pub(super) fn prove(&self, motion: &Motion<'_>, goes_on: &mut dyn FnMut(Progress) -> bool) -> Proof {
        let known: Vec<Watched> = motion.watched.iter().map(|watched| Watched { off: 0.0, ..*watched }).collect();
        let mut behind: Option<Behind> = None;
        let mut whole: Option<Proof> = None;
        let (mut passed, mut late, mut spent) = (Extended::ZERO, 0.0, 0.0);
        let mut samples: Vec<Vec<Coordinate>> = Vec::new();
        loop {
            let places: Vec<Extended> = motion.samples[samples.len()..].iter().map(|&place| place - passed).collect();
            let until = match motion.until {
                Until::Length(length) => Until::Length(length - passed),
                value @ Until::Value(..) => value,
            };
            let before = whole.as_ref().map_or(0.0, |whole| whole.reached);
            let mut last = 0.0;
            let tell = &mut |progress: Progress| {
                last = progress.operations;
                goes_on(Progress { reached: before + progress.reached, operations: spent + progress.operations })
            };
            let piece = match &behind {
                None => prove(motion, tell),
                Some(Behind { start, state }) => {
                    let watched = &known;
                    prove(&Motion { start, until, watched, samples: &places, behind: state, late, ..*motion }, tell)
                }
            };
            spent += last;
            let here = piece.events.last().map(|event| event.gamma);
            let met = piece.ended_by.filter(|&place| self.acting.of(&self.formulas[place]).is_some());
            let state = piece.state.clone();
            samples.extend(before_event(&piece.samples, &places, met.and(here), late));
            let proof = added(whole.take(), piece, (passed, late));
            let (Some(place), Some((gamma, radius)), Ok(_)) = (met, here, &proof.end) else {
                return Proof { samples, ..proof };
            };
            (passed, late) = (passed + gamma, (late + radius) * UP);
            match self.behind(motion, place, state) {
                Ok(next) => behind = Some(next),
                Err(reason) => return Proof { end: Err(reason), ended_by: None, samples, ..proof },
            }
            whole = Some(Proof { ended_by: None, ..proof });
        }
    }

    /// The state behind the event of a formula that is met in this one.
    fn behind(&self, motion: &Motion<'_>, place: usize, mut state: Vec<Option<Spread>>) -> Result<Behind, Reason> {
        let all = motion.geometry.dimension();
        let n = all - self.formulas.len();
        let reset = self.acting.of(&self.formulas[place]).ok_or(Reason::Grazed)?;
        let momenta = spreads(&reset.jets, &of_scene(&state, n, all)).ok_or(Reason::Lost)?;
        reset.changed.iter().zip(momenta).for_each(|(&a, momentum)| state[all + a] = Some(momentum));
        let of_positions = self.watched.are_of_positions();
        let values = spreads(&self.watched, &of_scene(&state, n, all)).ok_or(Reason::Lost)?;
        for (k, value) in values.into_iter().enumerate() {
            // What depends on positions alone is what it was, and 0 where it has just been met.
            if !of_positions[k] {
                state[n + k] = Some(value);
            }
            let is_known = |value: &Spread| value.value.abs().to_f64() > value.reach() * UP;
            let is_met = k == place && of_positions[k];
            if !is_met && !state[n + k].as_ref().is_some_and(is_known) {
                return Err(Reason::Together);
            }
        }
        let value = |known: &Option<Spread>, before: Extended| known.as_ref().map_or(before, |known| known.value);
        let values = |known: &[Option<Spread>], before: &[Extended]| -> Vec<Extended> {
            known.iter().zip(before).map(|(known, &before)| value(known, before)).collect()
        };
        let (q, p) = (values(&state[..all], &motion.start.q), values(&state[all..], &motion.start.p));
        let q_dot = motion.geometry.velocities(&q, &p).map_err(|_| Reason::Lost)?;
        Ok(Behind { start: Start { q, q_dot, p }, state })
    }
}

/// q and p of a scene with n coordinates, without those that stand for formulas.
fn of_scene(state: &[Option<Spread>], n: usize, all: usize) -> Vec<Option<&Spread>> {
    state[..n].iter().chain(&state[all..all + n]).map(Option::as_ref).collect()
}

/// Formulas over a set of states. `None` if one is not known.
fn spreads(jets: &Jets, state: &[Option<&Spread>]) -> Option<Vec<Spread>> {
    // The start of the motion stands in no formula.
    let of_start = vec![Ball::exact(0.0); state.len()];
    let at = |reach: fn(&Spread) -> f64| {
        let ball = |known: &&Spread| Ball::of(known.value, OFF).widened(reach(known));
        let end = state.iter().map(|known| known.as_ref().map_or(Ball::UNKNOWN, ball));
        jets.at(&end.chain(of_start.iter().copied()).collect::<Vec<Ball>>())
    };
    let (values, slopes) = (at(|_| 0.0), at(Spread::reach));
    values.iter().zip(&slopes).map(|(value, slopes)| spread(value.value, slopes, state)).collect()
}

/// A formula with this value in the middle of a set, and with derivatives over all of it.
fn spread(value: Ball, slopes: &Jet, state: &[Option<&Spread>]) -> Option<Spread> {
    let most = state.iter().flatten().map(|known| known.columns.len()).max().unwrap_or(0);
    let (mut columns, mut radius, mut terms) = (vec![0.0; most], value.rad, 0.0);
    for (slope, known) in slopes.gradient.iter().zip(state) {
        if slope.size() == 0.0 {
            continue;
        }
        let known = (*known)?;
        for (column, of) in columns.iter_mut().zip(&known.columns) {
            *column += slope.hi * of;
        }
        let (reach, off) = (known.reach(), slope.rad + slope.lo.abs());
        radius += slope.hi.abs() * known.radius + off * reach;
        terms += slope.hi.abs() * reach;
    }
    // Each column is a sum of so many products at most.
    let rounded = 2.0 * state.len() as f64 * f64::EPSILON * terms;
    let radius = (radius + rounded) * UP;
    let value = Extended::from(value.hi) + Extended::from(value.lo);
    (value.is_finite() && radius.is_finite()).then_some(Spread { value, columns, radius, slack: f64::INFINITY })
}

/// What is known at the places of a piece, or before the event in whose place it ends; nothing is where it is not known
/// whether they are before it.
fn before_event<'p>(
    found: &'p [Vec<Coordinate>],
    places: &'p [Extended],
    event: Option<(Extended, f64)>,
    late: f64,
) -> impl Iterator<Item = Vec<Coordinate>> + use<'p> {
    let room = |radius: f64| Extended::from((radius + late) * UP);
    let [before, near] = event.map_or([None, None], |(at, radius)| [Some(at - room(radius)), Some(at + room(radius))]);
    let is_here = move |place: &Extended| near.is_none_or(|near| *place <= near);
    let is_before = move |place: &Extended| before.is_none_or(|before| *place < before);
    let here = found.iter().zip(places).take_while(move |(_, place)| is_here(place));
    here.map(move |(found, place)| if is_before(place) { found.clone() } else { Vec::new() })
}

/// A proof with that of the next piece of the motion, which begins after a length of γ that may be off.
fn added(whole: Option<Proof>, piece: Proof, (passed, late): (Extended, f64)) -> Proof {
    let Some(mut whole) = whole else { return piece };
    let events = piece
        .events
        .into_iter()
        .map(|event| Event { gamma: (event.gamma.0 + passed, (event.gamma.1 + late) * UP), ..event });
    whole.events.extend(events);
    Proof {
        reached: passed.to_f64() + piece.reached,
        windows: whole.windows + piece.windows,
        seconds: whole.seconds + piece.seconds,
        events: whole.events,
        ..piece
    }
}
