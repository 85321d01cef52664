//! Proofs of motions in pieces: from one surface to the next, where an event acts, an argument of abs, sign or step
//! changes its sign, or that of a table passes a knot.
//!
//! A proof that ends where a formula is 0 has the set of states there, in which errors keep what they have in common.
//! The next piece begins with that set, or with what an event makes of it. γ at the surface is known up to a radius, by
//! which the rest of the way may be longer or shorter.
//!
//! On each side of its surfaces a scene is smooth. The scene of a side is taken as if it were the same everywhere: up
//! to the surface its motion is that of the scene, and behind it that of the other side is, if it leaves the surface
//! to its own side.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::acting::{Acting, UP, spreads};
use crate::case::{Case, WatchedFormula};
use crate::geometry::{Arguments, Geometry, Jets, OfEnds, Reset, Side, Start};
use crate::number::spline::Table;
use crate::number::{Extended, Real};
use crate::proof::{
    Coordinate, Event, Generator, Motion, Obstacle, Progress, Proof, Reason, Spread, Until, Watched, prove,
};
use crate::solve::Setup;

/// To make the scene of other sides takes about so many operations.
const OF_SCENE: f64 = 1e5;

/// A motion through surfaces.
pub(super) struct Through<'a> {
    pub(super) case: &'a Case,
    pub(super) acting: &'a Acting,
    /// The coordinates whose momenta are no constants.
    also: &'a [usize],
    /// The formulas that end pieces or are looked for, before what is 0 where sides end.
    pub(super) formulas: &'a [WatchedFormula<'a>],
    /// The values of the formulas, and their derivatives.
    watched: Jets,
    /// The arguments of abs, sign, step and tables, if they are followed.
    arguments: Option<&'a Arguments>,
    norm: Extended,
}

/// The state behind a surface.
struct Behind {
    start: Start<Extended>,
    state: Vec<Option<Spread>>,
    /// The sides of all arguments.
    sides: Vec<Side>,
    /// The formula that is 0 there, and the side to which it has to leave.
    leaves: Option<(usize, f64)>,
}

impl<'a> Through<'a> {
    pub(super) fn new(
        (case, setup): (&'a Case, &Setup<Extended>),
        (acting, also, arguments): (&'a Acting, &'a [usize], Option<&'a Arguments>),
        formulas: &'a [WatchedFormula<'a>],
    ) -> Self {
        let start = &setup.place.start;
        let norm = setup.place.geometry.norm(&start.q, &start.q_dot);
        let of: Vec<OfEnds<'_>> = formulas.iter().map(|of| OfEnds { end: of.formula, starts: &[] }).collect();
        Self { watched: case.jets_of(&of, norm), case, acting, also, formulas, arguments, norm }
    }

    /// True if another piece follows where this formula is 0.
    fn goes_on(&self, place: usize) -> bool {
        self.formulas.get(place).is_none_or(|formula| self.acting.of(formula).is_some())
    }

    /// Proves where a motion ends that begins on these sides.
    pub(super) fn prove(
        &self,
        motion: &Motion<'_>,
        sides: &[Side],
        goes_on: &mut dyn FnMut(Progress) -> bool,
    ) -> Proof {
        let watched: Vec<Watched> = motion.watched.iter().map(|watched| Watched { off: 0.0, ..*watched }).collect();
        let mut scenes: BTreeMap<Vec<Side>, Arc<Geometry<Extended>>> = BTreeMap::new();
        let (mut behind, mut whole): (Option<Behind>, Option<Proof>) = (None, None);
        let (mut passed, mut late, mut spent) = (Extended::ZERO, 0.0, 0.0);
        let mut samples: Vec<Vec<Coordinate>> = Vec::new();
        loop {
            let places: Vec<Extended> = motion.samples[samples.len()..].iter().map(|&place| place - passed).collect();
            let until = match motion.until {
                Until::Length(length) => Until::Length(length - passed),
                value @ Until::Value(..) => value,
            };
            let before = whole.as_ref().map_or(0.0, |whole| whole.reached);
            let (mut last, known) = (0.0, scenes.len());
            let tell = &mut |progress: Progress| {
                last = progress.operations;
                goes_on(Progress { reached: before + progress.reached, operations: spent + progress.operations })
            };
            let piece = match &behind {
                None => prove(motion, tell),
                Some(Behind { start, state, sides: own, leaves }) => {
                    let other = (own != sides).then(|| self.scene(&mut scenes, own));
                    let geometry = other.as_deref().unwrap_or(motion.geometry);
                    let (watched, samples, leaves) = (&watched[..], &places[..], *leaves);
                    let next =
                        Motion { geometry, start, until, watched, samples, behind: state, late, leaves, ..*motion };
                    prove(&next, tell)
                }
            };
            spent += last + OF_SCENE * (scenes.len() - known) as f64;
            let here = piece.events.last().map(|event| event.gamma);
            let met = piece.ended_by.filter(|&place| self.goes_on(place));
            let state = piece.state.clone();
            samples.extend(before_event(&piece.samples, &places, met.and(here), late));
            let proof = self.added(whole.take(), piece, (passed, late));
            let (Some(place), Some((gamma, radius)), Ok(_)) = (met, here, &proof.end) else {
                return Proof { samples, ..proof };
            };
            (passed, late) = (passed + gamma, (late + radius) * UP);
            let own = behind.as_ref().map_or(sides, |behind| &behind.sides).to_vec();
            match self.behind(motion, (place, own), state) {
                Ok(next) => behind = Some(next),
                Err(reason) => return Proof { end: Err(reason), ended_by: None, samples, ..proof },
            }
            whole = Some(Proof { ended_by: None, ..proof });
        }
    }

    /// The states at the start of a motion, if these are the directions in which starts are spread around it: all
    /// coordinates and momenta, and what is watched. `None` if it is not known on which side of it all of them are.
    pub(super) fn spread(
        &self,
        motion: &Motion<'_>,
        directions: &[Generator],
        sides: &[Side],
    ) -> Option<Vec<Option<Spread>>> {
        let all = motion.geometry.dimension();
        let n = all - motion.watched.len();
        let own = n - self.case.geometry_text.unknown.len();
        let of = |value: Extended, columns: Vec<f64>| {
            let rounded = f64::EPSILON * columns.iter().map(|column| column.abs()).sum::<f64>();
            let is_known = rounded.is_finite();
            is_known.then_some(Spread { value, columns, radius: rounded * UP, slack: f64::INFINITY })
        };
        // Parameters that events set are the same in all of them.
        let of_place = |a: usize| directions.iter().map(|of| of.q.get(a).copied().unwrap_or(0.0)).collect();
        let of_momentum = |a: usize| directions.iter().map(|of| of.p[a]).collect();
        let mut state: Vec<Option<Spread>> = (0..n).map(|a| of(motion.start.q[a], of_place(a))).collect();
        state.resize(all, None);
        state.extend((0..own).map(|a| of(motion.start.p[a], of_momentum(a))));
        state.resize(2 * all, None);
        let is_known = |value: &Spread| value.value.abs().to_f64() > value.reach() * UP;
        let mut values = spreads(&self.watched, &of_scene(&state, [own, n, all]))?;
        if let Some(Arguments { jets, tables }) = self.arguments {
            let arguments = spreads(jets, &of_scene(&state, [own, n, all]))?;
            for (k, argument) in arguments.iter().enumerate() {
                let (side, ends) = side_of(argument, tables[k])?;
                values.extend((side == sides[k]).then_some(ends)?);
            }
        }
        values.iter().all(is_known).then_some(())?;
        values.into_iter().enumerate().for_each(|(k, value)| state[n + k] = Some(value));
        Some(state)
    }

    /// The scene of other sides.
    fn scene(
        &self,
        scenes: &mut BTreeMap<Vec<Side>, Arc<Geometry<Extended>>>,
        sides: &[Side],
    ) -> Arc<Geometry<Extended>> {
        let make = || Arc::new(self.case.watching(self.formulas, (self.also, sides), self.norm));
        Arc::clone(scenes.entry(sides.to_vec()).or_insert_with(make))
    }

    /// The state behind the surface of a formula, which is met in this one on these sides.
    fn behind(
        &self,
        motion: &Motion<'_>,
        (place, mut sides): (usize, Vec<Side>),
        mut state: Vec<Option<Spread>>,
    ) -> Result<Behind, Reason> {
        let (all, first) = (motion.geometry.dimension(), self.formulas.len());
        // Unknown parameters are before what is watched.
        let n = all - motion.watched.len();
        let reset = self.formulas.get(place).and_then(|formula| self.acting.of(formula));
        let leaves = match reset {
            Some(reset) => {
                self.act(reset, (place, &mut sides), &mut state, [n, all])?;
                None
            }
            None => Some(self.pass(place, &mut sides, &mut state[n + first..all])?),
        };
        let is_kept = reset.map(|reset| reset.keeps(&self.watched));
        let is_at_zero = |k: usize| match leaves {
            Some((at, _)) => k == at,
            None => k == place && is_kept.as_ref().is_some_and(|is_kept| is_kept[k]),
        };
        let is_known = |value: &Spread| value.value.abs().to_f64() > value.reach() * UP;
        if !(0..all - n).all(|k| is_at_zero(k) || state[n + k].as_ref().is_some_and(is_known)) {
            return Err(if reset.is_some() { Reason::Left } else { Reason::Together });
        }
        let values = |known: &[Option<Spread>], before: &[Extended]| -> Vec<Extended> {
            known.iter().zip(before).map(|(known, &before)| known.as_ref().map_or(before, |it| it.value)).collect()
        };
        let (q, p) = (values(&state[..all], &motion.start.q), values(&state[all..], &motion.start.p));
        Ok(Behind { start: Start { q_dot: vec![Extended::ZERO; all], q, p }, state, sides, leaves })
    }

    /// Lets an event act where the formula `place` is met: it changes positions and momenta, and with them formulas and
    /// sides. What depends on positions alone is what it was if these are.
    fn act(
        &self,
        reset: &Reset,
        (place, sides): (usize, &mut [Side]),
        state: &mut [Option<Spread>],
        [n, all]: [usize; 2],
    ) -> Result<(), Reason> {
        let own = n - self.case.geometry_text.unknown.len();
        let changed = spreads(&reset.jets, &of_scene(state, [own, n, all])).ok_or(Reason::Rough)?;
        for ((a, is_momentum), value) in reset.changed.iter().zip(changed) {
            state[if *is_momentum { all + a } else { *a }] = Some(value);
        }
        let values = spreads(&self.watched, &of_scene(state, [own, n, all])).ok_or(Reason::Rough)?;
        let changed = values.into_iter().zip(reset.keeps(&self.watched)).enumerate();
        for (k, (value, _)) in changed.filter(|(_, (_, is_kept))| !is_kept) {
            state[n + k] = Some(value);
        }
        let Some(Arguments { jets, tables }) = self.arguments else { return Ok(()) };
        let values = spreads(jets, &of_scene(state, [own, n, all])).ok_or(Reason::Rough)?;
        let mut at = n + self.formulas.len();
        for (k, (value, is_kept)) in values.iter().zip(reset.keeps(jets)).enumerate() {
            let ends = if let Side::Piece(_) = sides[k] { 2 } else { 1 };
            if !is_kept {
                let (side, values) = side_of(value, tables[k]).ok_or(Reason::Left)?;
                sides[k] = side;
                values.into_iter().enumerate().for_each(|(end, value)| state[at + end] = Some(value));
            }
            at += ends;
        }
        debug_assert!(place < self.formulas.len() && at == all);
        Ok(())
    }

    /// Goes to the other side of a surface of the scene. Returns the formula that is 0 there, and where it leaves to.
    fn pass(&self, place: usize, sides: &mut [Side], ends: &mut [Option<Spread>]) -> Result<(usize, f64), Reason> {
        let tables = self.arguments.map_or(&[][..], |arguments| &arguments.tables);
        let mut at = place - self.formulas.len();
        for (side, table) in sides.iter_mut().zip(tables) {
            match side {
                Side::Piece(_) if at >= 2 => at -= 2,
                Side::Negative | Side::Positive if at >= 1 => at -= 1,
                Side::Negative => {
                    *side = Side::Positive;
                    return Ok((place, 1.0));
                }
                Side::Positive => {
                    *side = Side::Negative;
                    return Ok((place, -1.0));
                }
                Side::Piece(piece) => {
                    let knots =
                        |piece: usize| table.and_then(|table| table.polynomial::<Extended>(piece)).map(|of| of.0);
                    let (next, first) = if at == 1 { (*piece + 1, place - 1) } else { (*piece - 1, place) };
                    let beyond = Reason::Obstacle(Obstacle::OffTable);
                    let [low, high] = knots(next).ok_or(beyond)?;
                    let here = ends[place - self.formulas.len()].clone().ok_or(Reason::Lost)?;
                    // The argument is at a knot, which one piece ends and the other one begins with.
                    let (zero, other) = if at == 1 { (0, low - high) } else { (1, high - low) };
                    let moved = Some(Spread { value: here.value + other, ..here.clone() });
                    let of_piece = first - self.formulas.len();
                    ends[of_piece + zero] = Some(here);
                    ends[of_piece + 1 - zero] = moved;
                    *side = Side::Piece(next);
                    return Ok((first + zero, if zero == 0 { 1.0 } else { -1.0 }));
                }
            }
        }
        Err(Reason::Grazed)
    }

    /// A proof with that of the next piece of the motion, which begins after a length of γ that may be off.
    fn added(&self, whole: Option<Proof>, mut piece: Proof, (passed, late): (Extended, f64)) -> Proof {
        // Surfaces of the scene are no events.
        piece.events.retain(|event| event.watch < self.formulas.len());
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
}

/// The side on which an argument is, and what is 0 where that ends. `None` if it is not known.
pub(super) fn side_of(argument: &Spread, table: Option<Table>) -> Option<(Side, Vec<Spread>)> {
    let room = Extended::from(argument.reach() * UP);
    let Some(table) = table else {
        let side = if argument.value > Extended::ZERO { Side::Positive } else { Side::Negative };
        return (argument.value.abs() > room).then(|| (side, vec![argument.clone()]));
    };
    let piece = table.piece(argument.value)?;
    let (knots, _) = table.polynomial::<Extended>(piece)?;
    let ends = knots.map(|knot| Spread { value: argument.value - knot, ..argument.clone() });
    ends.iter().all(|end| end.value.abs() > room).then(|| (Side::Piece(piece), ends.to_vec()))
}

/// q and p of a scene with n coordinates, and the parameters behind these, without what stands for formulas.
fn of_scene(state: &[Option<Spread>], [n, watched, all]: [usize; 3]) -> Vec<Option<&Spread>> {
    state[..n].iter().chain(&state[all..all + n]).chain(&state[n..watched]).map(Option::as_ref).collect()
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
