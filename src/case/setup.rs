//! From a case to what a solver is told.

use std::sync::Arc;

use super::compiled::Compiled;
use super::start_data::{Rate, StartData};
use super::{Case, Event};
use crate::engine::{Handed, Marched};
use crate::geometry::{
    self, Arguments, Beside, Direction, Geometry, GeometryText, Law, NewValue, Observable, OfEnds,
    Place as FormulaPlace, Reset, Saltation, Setting, Side,
};
use crate::number::{Extended, Kind, Real};
use crate::solve::{Change, Continuation, Limit, Place, Quantity, Setup, Until};
use crate::trajectory::Watch;

/// A formula that ends a run where it changes its sign, or that is looked for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WatchedFormula<'c> {
    /// As it is written.
    pub(crate) formula: &'c str,
    /// The changes that count.
    pub(crate) direction: Direction,
    /// True if it ends the run.
    pub(crate) ends: bool,
    /// The index of its event; `None` of `grid.until`.
    pub(crate) event: Option<usize>,
}

impl Case {
    fn place<S: Real>(&self) -> Place<S> {
        let geometry = self.geometry();
        let mut start = self.start_in(&geometry);
        let geometry = if self.is_backward() { self.reversed(geometry, &start.q) } else { geometry };
        if self.is_backward() {
            start = start.reversed();
        }
        Place { geometry: Arc::new(geometry), start: Arc::new(start) }
    }

    /// The geometry in which the motion goes the way back. Only one-forms and forces, by dγ, tell the two apart: what
    /// is by dt, as in Newton's law, does not.
    fn reversed<S: Real>(&self, geometry: Geometry<S>, q: &[S]) -> Geometry<S> {
        let GeometryText { one_form, force, potential, .. } = &self.geometry_text;
        let is_same = self.is_lifted() || force.is_empty() && (potential.is_some() || one_form.is_empty());
        if is_same {
            return geometry;
        }
        let reversed = Geometry::backward(&self.geometry_text).expect("a valid case has valid formulas");
        reversed.with_domain_of(q).expect("a valid case starts inside its domain")
    }

    /// True if γ falls: to γ_f below γ_i, or to a t_f on the other side of the start.
    pub fn is_backward(&self) -> bool {
        match self.limit::<f64>() {
            Limit::Value { coordinate, value } => {
                (value - self.value::<f64>(&self.initial.q[coordinate])) * self.t_dot < 0.0
            }
            Limit::Length(_) => self.grid.gamma_f.as_ref().is_some_and(|last| self.value::<f64>(last) < self.gamma_i()),
        }
    }

    /// Returns true if the space-time is the lift of Newton's law: its first coordinate is t, its last one s.
    pub fn is_lifted(&self) -> bool {
        self.geometry_text.law() == Some(Law::Newtonian)
    }

    /// The formulas of `[invariants]`, compiled for what the solver computes, with their names, in their order.
    pub fn observables<S: Real>(&self) -> Vec<(String, Observable<S>)> {
        let compiled = |(name, formula): &(String, String)| (name.clone(), self.observable(formula));
        self.invariants.iter().map(compiled).collect()
    }

    /// The formulas of `[events]`, compiled, with their directions, in their order.
    pub fn watches<S: Real>(&self) -> Vec<Watch<S>> {
        let watch =
            |event: &Event| Watch { formula: observable(&self.geometry_text, &event.when), direction: event.direction };
        self.events.iter().map(watch).collect()
    }

    /// The same, and behind them `grid.until`, if there is one.
    pub(crate) fn watches_with_until<S: Real>(&self) -> Vec<Watch<S>> {
        let until = self
            .grid
            .until
            .as_ref()
            .map(|formula| Watch { formula: observable(&self.geometry_text, formula), direction: Direction::Both });
        self.watches().into_iter().chain(until).collect()
    }

    /// The events that act, with their indices.
    fn acting(&self) -> impl Iterator<Item = (usize, &Event)> {
        self.events.iter().enumerate().filter(|(_, event)| !event.set.is_empty())
    }

    /// Returns true if an event changes the state.
    pub fn has_acting_events(&self) -> bool {
        self.acting().next().is_some()
    }

    /// The indices of events that act, by the places of the formulas that end runs.
    pub(crate) fn acting_watches(&self) -> Vec<Option<usize>> {
        let ending = self.events.iter().filter(|event| event.until).count() + usize::from(self.grid.until.is_some());
        std::iter::repeat_n(None, ending).chain(self.acting().map(|(watch, _)| Some(watch))).collect()
    }

    /// The names of the formulas that end runs or act, by their places.
    pub(crate) fn ending_names(&self) -> Vec<&str> {
        let until = self.grid.until.iter().map(|_| "grid.until");
        let ending = self.events.iter().filter(|event| event.until).map(|event| event.name.as_str());
        until.chain(ending).chain(self.acting().map(|(_, event)| event.name.as_str())).collect()
    }

    /// The change of the state that an event makes.
    fn change(&self, event: &Event) -> Change {
        Change {
            name: event.name.clone(),
            set: event.set.iter().map(|(quantity, formula)| (*quantity, self.observable(formula))).collect(),
            is_lifted: self.is_lifted(),
        }
    }

    /// This case with other values of parameters, by their places; `None` if formulas have none at `q` then.
    pub(crate) fn with_parameters(&self, values: &[(usize, f64)], q: &[f64]) -> Option<Self> {
        let mut case = self.clone();
        for (place, value) in values {
            case.geometry_text.parameters[*place].1 = format!("{value:e}");
        }
        case.compiled = Compiled::new(&case.geometry_text, self.is_of_x, Some(&self.compiled)).ok()?;
        case.rough = case.compiled.geometry().ok()?.with_domain_of(q).ok()?;
        Some(case)
    }

    /// The setup of a run that goes on at `q`, where an event sets parameters besides the state: that of the run
    /// before with the space-time and the formulas of the new numbers, if these have a value there.
    pub(crate) fn with_set(&self, before: &Setup, values: &[(Quantity, f64)], q: &[f64]) -> Option<Setup> {
        let mut set = before.set.clone();
        for &(quantity, value) in values {
            let Quantity::Parameter(parameter) = quantity else { continue };
            set.retain(|(other, _)| *other != parameter);
            set.push((parameter, value));
        }
        if set.iter().any(|(_, value)| !value.is_finite()) {
            return None;
        }
        let case = self.with_parameters(&set, q)?;
        let place = Place { geometry: Arc::new(case.rough.clone()), start: Arc::clone(&before.place.start) };
        Some(Setup { rough: place.clone(), place, until: case.ending(), set, ..before.clone() })
    }

    /// A formula of what the solver computes.
    pub(crate) fn observable<S: Real>(&self, formula: &str) -> Observable<S> {
        let observable = observable(&self.geometry_text, formula);
        if self.is_backward() { observable.of_reversed() } else { observable }
    }

    /// A formula of an axis of a picture, compiled.
    pub fn axis<S: Real>(&self, formula: &str) -> Observable<S> {
        observable(&self.geometry_text, formula)
    }

    /// The formulas at whose changes of sign a run ends, by their places, and then those of events that it looks for.
    pub(crate) fn watched_formulas(&self) -> impl Iterator<Item = WatchedFormula<'_>> {
        let of = |ends: bool| {
            let events = self.events.iter().enumerate();
            let of = events.filter(move |(_, event)| event.until == ends && event.set.is_empty());
            of.map(move |(k, Event { when, direction, .. })| WatchedFormula {
                formula: when,
                direction: *direction,
                ends,
                event: Some(k),
            })
        };
        let until = self.grid.until.as_deref();
        let until =
            until.map(|formula| WatchedFormula { formula, direction: Direction::Both, ends: true, event: None });
        until.into_iter().chain(of(true)).chain(of(false))
    }

    /// The space-time of a run of this case in which the last coordinates are the values of these formulas, where
    /// `norm` is K, the momenta of `also` are no constants, and abs, sign, step and tables are on these sides; see
    /// [`Beside`].
    pub(crate) fn watching(
        &self,
        formulas: &[WatchedFormula<'_>],
        (also, sides): (&[usize], &[Side]),
        norm: Extended,
    ) -> Geometry<Extended> {
        let formulas: Vec<&str> = formulas.iter().map(|of| of.formula).collect();
        let beside = Beside { formulas: &formulas, also, sides };
        let geometry = Geometry::watching(&self.geometry_text, beside, norm, self.is_backward());
        geometry.expect("a valid case has valid formulas")
    }

    /// True if the formulas of its scene are those of another case, whatever their parameters are.
    pub(crate) fn is_in_scene_of(&self, other: &Self) -> bool {
        let without =
            |of: &Self| GeometryText { parameters: Vec::new(), unknown: Vec::new(), ..of.geometry_text.clone() };
        without(self) == without(other)
    }

    /// The arguments of abs, sign, step and tables, if there are some, and if each of them can be followed by itself.
    pub(crate) fn arguments(&self) -> Option<Arguments> {
        geometry::arguments(&self.geometry_text, self.is_backward()).filter(|all| !all.tables.is_empty())
    }

    /// The formulas of events that act.
    pub(crate) fn acting_formulas(&self) -> impl Iterator<Item = WatchedFormula<'_>> {
        self.acting().map(|(k, event)| WatchedFormula {
            formula: &event.when,
            direction: event.direction,
            ends: true,
            event: Some(k),
        })
    }

    /// The state behind an event that acts, but for parameters that it sets if they are not unknown, as functions of
    /// the state before, where K is `norm` at the start.
    pub(crate) fn reset(&self, event: &Event, norm: Extended) -> Reset {
        let set = event.set.iter().filter_map(|(quantity, formula)| {
            let (coordinate, setting) = match quantity {
                Quantity::Position(a) => (*a, Setting::Position),
                Quantity::Velocity(a) => (*a, Setting::Velocity),
                Quantity::Momentum(a) => (*a, Setting::Momentum),
                Quantity::Parameter(place) => {
                    let GeometryText { parameters, unknown, .. } = &self.geometry_text;
                    let place = unknown.iter().position(|name| *name == parameters[*place].0)?;
                    (self.geometry_text.names().len() + place, Setting::Position)
                }
            };
            Some(NewValue { coordinate, setting, formula })
        });
        let left_out = self.is_lifted().then_some(0);
        let set: Vec<NewValue<'_>> = set.collect();
        Reset::new(&self.geometry_text, &set, (norm, left_out)).expect("a valid case has valid formulas")
    }

    /// The same case, in which the parameters that events set are unknown.
    pub(crate) fn with_unknown_parameters(&self) -> Self {
        let mut case = self.clone();
        let GeometryText { parameters, unknown, .. } = &mut case.geometry_text;
        for (_, (name, _)) in parameters.iter().enumerate().filter(|(place, _)| self.sets_parameter(*place)) {
            if !unknown.contains(name) {
                unknown.push(name.clone());
            }
        }
        case
    }

    /// True if an event sets the parameter in this place.
    fn sets_parameter(&self, place: usize) -> bool {
        self.events.iter().flat_map(|event| &event.set).any(|(quantity, _)| *quantity == Quantity::Parameter(place))
    }

    /// The derivatives of an event that acts, which carry small changes behind it, where K is `norm` at the start.
    ///
    /// # Errors
    /// The reason why that is not known.
    pub(crate) fn saltation(&self, event: &Event, norm: Extended) -> Result<Saltation, &'static str> {
        let of = |end: &'_ str| self.jets_of(&[OfEnds { end, starts: &[] }], norm);
        let parameters: Vec<OfEnds<'_>> = (event.set.iter())
            .filter(|(quantity, _)| matches!(quantity, Quantity::Parameter(_)))
            .map(|(_, end)| OfEnds { end, starts: &[] })
            .collect();
        let parameters = self.jets_of(&parameters, norm);
        let energy = self.geometry_text.energy().filter(|_| self.is_lifted());
        let energy = energy.as_deref().map(of);
        Saltation::new(&self.geometry(), (of(&event.when), energy), self.reset(event, norm), &parameters)
    }

    /// True if it is not seen that a formula of the state is continuous.
    pub(crate) fn may_jump(&self, formula: &str) -> bool {
        geometry::may_jump(&self.geometry_text, formula)
    }

    /// The formulas at whose changes of sign a run ends, or a state changes.
    fn ending<S: Real>(&self) -> Vec<Until<S>> {
        let ending = self.watched_formulas().filter(|of| of.ends).map(|of| (of.formula, of.direction, None));
        let acting = self.acting().map(|(_, event)| (event.when.as_str(), event.direction, Some(self.change(event))));
        // Where an event that acts meets one that ends the run, the run ends.
        let until = ending.chain(acting);
        let until = until.map(|(formula, direction, change)| Until {
            formula: self.observable(formula),
            rough: self.observable(formula),
            direction,
            change,
        });
        until.collect()
    }

    /// The part of the start that its doubles lack.
    fn dropped(&self, rough: &Place) -> Handed {
        let is_double = |number: &String| {
            let value = self.value::<Extended>(number);
            value == Extended::from(value.to_f64())
        };
        let StartData { q, rates, .. } = &self.initial;
        let is_rounded = |rate: &Rate| match rate {
            Rate::Velocity(number) | Rate::Momentum(number) => !is_double(number),
            Rate::VelocityFromNorm(_) | Rate::MomentumFromNorm(_) => true,
        };
        if q.iter().all(is_double) && !rates.iter().any(is_rounded) {
            return Handed::default();
        }
        let (start, exact) = (&rough.start, self.place::<Extended>().start);
        let low = |(double, exact): (&f64, &Extended)| (*exact - Extended::from(*double)).to_f64();
        let lows = |doubles: &[f64], exact: &[Extended]| doubles.iter().zip(exact).map(low).collect::<Vec<f64>>();
        let [q_low, p_low, q_dot_low] =
            [(&start.q, &exact.q), (&start.p, &exact.p), (&start.q_dot, &exact.q_dot)].map(|(a, b)| lows(a, b));
        let active = rough.geometry.active();
        let velocities = active.iter().map(|&a| [start.q_dot[a], q_dot_low[a]]).collect();
        let is_finite = q_low.iter().chain(&p_low).chain(&q_dot_low).all(|low| low.is_finite());
        let march = Some(Marched { velocities, ..Marched::default() });
        let p_low = active.iter().map(|&a| p_low[a]).collect();
        if is_finite { Handed { q_low, p_low, march } } else { Handed::default() }
    }

    /// Returns true if t counts from the start inside: in a case of x, unless formulas of the case's own see it.
    pub(super) fn counts_from_start(&self) -> bool {
        let sees_t = !self.events.is_empty() || !self.invariants.is_empty() || self.axes.is_some();
        self.is_of_x && !sees_t && self.grid.until.is_none()
    }

    /// The settings of a solver.
    pub fn setup<S: Real>(&self) -> Setup<S> {
        let place: Place<S> = self.place();
        let carried = self.carried(&place.geometry).map(|(_, carried)| carried);
        let origin = self.from.as_ref().and_then(Continuation::origin);
        // In f64 both are the same.
        let rough = S::in_f64::<OfPlace>(place.clone()).unwrap_or_else(|| self.place());
        Setup {
            place,
            // A shift of t changes no other digit. Formulas of the case see the coordinates themselves.
            origin: self.counts_from_start().then(|| (0, origin.unwrap_or_else(|| self.value(&self.initial.q[0])))),
            dropped: if carried.is_some() { Handed::default() } else { self.dropped(&rough) },
            carried,
            rough,
            gamma_i: self.gamma_i(),
            is_backward: self.is_backward(),
            limit: self.limit(),
            until: self.ending(),
            sides: Vec::new(),
            set: Vec::new(),
            floors: self.floors.iter().map(|(a, size)| (*a, self.value(size))).collect(),
            settings: self.settings.within::<S>(),
        }
    }
}

/// The place where a run starts.
struct OfPlace;

impl Kind for OfPlace {
    type Of<S: Real> = Place<S>;
}

impl<S: Real> From<&Case> for Setup<S> {
    fn from(case: &Case) -> Self {
        case.setup()
    }
}

/// A formula of positions, velocities, momenta and `norm` in a scene.
pub(super) fn observable<S: Real>(text: &GeometryText, formula: &str) -> Observable<S> {
    let place = FormulaPlace::Definition(String::new());
    Observable::new(formula, text, place).expect("a valid case has valid formulas")
}
