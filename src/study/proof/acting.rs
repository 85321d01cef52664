//! What events that act make of the set of states where they are met.
//!
//! It is enclosed by the mean value: for x in the set around x̂
//!
//! ```text
//! R(x) = R(x̂) + J (x − x̂),   J in the derivatives over the set,
//! ```
//!
//! so that columns are multiplied by the middles of J, and what these leave is added to the radius.

use crate::case::{Case, WatchedFormula};
use crate::geometry::{Jet, Jets, OfEnds, Reset};
use crate::number::Extended;
use crate::number::ball::{Ball, OFF};
use crate::proof::Spread;
use crate::solve::Setup;

/// More than the roundings of sums of few terms.
pub(super) const UP: f64 = 1.0 + 1e-12;

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
        if case.geometry_text.is_law_of(&case.geometry_text.unknown) {
            return Err("an event that sets the mass of the relativistic law, or c");
        }
        let resets = case.events.iter().map(|event| (!event.set.is_empty()).then(|| case.reset(event, norm)));
        let resets: Vec<Option<Reset>> = resets.collect();
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
        let of_momenta = |(a, is_momentum): &(usize, bool)| is_momentum.then_some(*a);
        self.resets.iter().flatten().flat_map(|reset| reset.changed.iter().filter_map(of_momenta)).collect()
    }

    /// What the event of a formula makes of momenta, if it acts.
    pub(super) fn of(&self, formula: &WatchedFormula<'_>) -> Option<&Reset> {
        self.resets.get(formula.event?)?.as_ref()
    }
}

/// Formulas over a set of states, which are positions, momenta, and then unknown parameters. `None` if one is not
/// known.
pub(super) fn spreads(jets: &Jets, state: &[Option<&Spread>]) -> Option<Vec<Spread>> {
    // The start of the motion, which has as many numbers as its end, stands in no formula.
    let of_end = 2 * jets.dimension();
    let at = |reach: fn(&Spread) -> f64| {
        let ball = |known: &&Spread| Ball::of(known.value, OFF).widened(reach(known));
        let all = state.iter().map(|known| known.as_ref().map_or(Ball::UNKNOWN, ball)).collect::<Vec<Ball>>();
        let (end, parameters) = all.split_at(of_end);
        jets.at(&[end, &vec![Ball::exact(0.0); of_end], parameters].concat())
    };
    let (values, mut slopes) = (at(|_| 0.0), at(Spread::reach));
    slopes.iter_mut().for_each(|jet| drop(jet.gradient.drain(of_end..2 * of_end)));
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
