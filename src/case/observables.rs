//! `[invariants]`, `[events]` and `[plot]` of a case: formulas of what a run computes.

use super::names;
use super::reader::{Field, Section};
use super::scenery::known;
use super::{Case, CaseError};
use crate::formula::{Graph, Known, Names, parse};
use crate::geometry::{Direction, Geometry, GeometryText, observed};
use crate::number::Real;
use crate::solve::Quantity;

/// An entry of `[events]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Event {
    /// Its name.
    pub name: String,
    /// A formula of positions and velocities: an event is where it changes its sign.
    pub when: String,
    /// Which sign changes count.
    pub direction: Direction,
    /// True if the first one ends the run.
    pub until: bool,
    /// What it sets, with the formulas of that: the state is changed, and the run goes on from there.
    pub set: Vec<(Quantity, String)>,
}

/// The names that the events of this section set.
pub(super) fn set_names(events: &Section<'_>) -> Vec<String> {
    let sets = events.fields().into_iter().filter_map(|event| event.section().ok()?.take("set")?.section().ok());
    sets.flat_map(|set| set.fields().into_iter().map(|field| field.key)).collect()
}

/// `[plot]`: the axes of the picture of the orbit, as formulas of positions and velocities.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Axes {
    /// To the right.
    pub x: String,
    /// Upwards.
    pub y: String,
}

/// The names that formulas of a case may use: the coordinates, and what the scene defines.
pub(super) struct Formulas<'s> {
    pub(super) coordinates: &'s [String],
    pub(super) scene: &'s GeometryText,
}

impl Formulas<'_> {
    /// A formula of positions and velocities.
    pub(super) fn of_velocities(&self, field: &Field<'_>) -> Result<String, CaseError> {
        let mut variables = observed(self.coordinates);
        variables.truncate(2 * self.coordinates.len());
        self.check(field, variables)
    }

    /// A formula of positions, velocities, momenta and the norm.
    fn of_everything(&self, field: &Field<'_>) -> Result<String, CaseError> {
        self.check(field, observed(self.coordinates))
    }

    fn check(&self, field: &Field<'_>, variables: Vec<String>) -> Result<String, CaseError> {
        let text = field.formula()?;
        let named = self.scene.parameters().iter().chain(self.scene.definitions()).map(|(name, _)| name.clone());
        let all: Vec<String> = variables.into_iter().chain(named).collect();
        // A formula is readable or not independently of what its names stand for.
        let variables: Vec<&str> = all.iter().map(String::as_str).collect();
        let table = |(name, table): &(String, _)| (name.clone(), Known::Table(*table));
        let tables: Names<f64> = self.scene.tables().iter().map(table).collect();
        let parsed = parse(&text, &variables, &tables, &mut Graph::default());
        parsed.map_err(|error| field.formula_error(&error, known(all.clone())))?;
        Ok(text)
    }

    /// Reads `[invariants]`.
    pub(super) fn invariants(&self, section: &Section<'_>) -> Result<Vec<(String, String)>, CaseError> {
        let read = |field: Field<'_>| {
            names::check_invariant(&field)?;
            Ok((field.key.clone(), self.of_everything(&field)?))
        };
        section.fields().into_iter().map(read).collect()
    }

    /// Reads `[events]`.
    pub(super) fn events(&self, section: &Section<'_>) -> Result<Vec<Event>, CaseError> {
        section.fields().into_iter().map(|field| self.event(&field)).collect()
    }

    fn event(&self, field: &Field<'_>) -> Result<Event, CaseError> {
        names::check_event(field)?;
        let mut section = field.section()?;
        let [when, direction, until, set] = ["when", "direction", "until", "set"].map(|key| section.take(key));
        let when = when.ok_or_else(|| section.error(format!("the event '{}' has no `when`", field.key)))?;
        let until = until.map_or(Ok(false), |field| field.is_true())?;
        if let (true, Some(set)) = (until, &set) {
            let help = "leave one of them out: an event ends the run, or the run goes on from what it sets";
            let message = format!("the event '{}' has both until and set", field.key);
            return Err(set.key_error(message).with_help(help));
        }
        Ok(Event {
            name: field.key.clone(),
            when: self.of_velocities(&when)?,
            direction: direction.map_or(Ok(Direction::default()), |field| self::direction(&field))?,
            until,
            set: set.map_or(Ok(Vec::new()), |field| self.set(&field))?,
        })
    }

    /// What an event sets.
    fn set(&self, field: &Field<'_>) -> Result<Vec<(Quantity, String)>, CaseError> {
        let fields = field.section()?.fields();
        let set: Vec<(Quantity, String)> = (fields.iter())
            .map(|field| Ok((self.quantity(field)?, self.of_velocities(field)?)))
            .collect::<Result<_, CaseError>>()?;
        let has = |of: fn(&Quantity) -> bool| set.iter().any(|(quantity, _)| of(quantity));
        if has(|it| matches!(it, Quantity::Velocity(_))) && has(|it| matches!(it, Quantity::Momentum(_))) {
            let message = "an event sets velocities or momenta, not both";
            return Err(field.key_error(message).with_help("the others follow from the metric"));
        }
        if set.is_empty() {
            return Err(field.key_error("an event that acts sets something: set is empty"));
        }
        Ok(set)
    }

    /// The quantity that the key of a field names: q, q_dot or p_q of a coordinate q, or a parameter.
    fn quantity(&self, field: &Field<'_>) -> Result<Quantity, CaseError> {
        let key = field.key.as_str();
        if let Some(parameter) = self.scene.parameters().iter().position(|(name, _)| name == key) {
            return Ok(Quantity::Parameter(parameter));
        }
        let (name, quantity): (&str, fn(usize) -> Quantity) = match (key.strip_suffix("_dot"), key.strip_prefix("p_")) {
            (Some(name), _) => (name, Quantity::Velocity),
            (None, Some(name)) => (name, Quantity::Momentum),
            (None, None) => (key, Quantity::Position),
        };
        Ok(quantity(names::index_of(name, field, self.coordinates)?))
    }

    /// Reads `[plot]`.
    pub(super) fn axes(&self, mut section: Section<'_>) -> Result<Option<Axes>, CaseError> {
        let (x, y) = (section.take("x"), section.take("y"));
        match (x, y) {
            (Some(x), Some(y)) => Ok(Some(Axes { x: self.of_velocities(&x)?, y: self.of_velocities(&y)? })),
            (None, None) if !section.is_given() => Ok(None),
            (x, _) => {
                let missing = if x.is_none() { "x" } else { "y" };
                Err(section.error(format!("missing field `{missing}`: [plot] needs the formulas x and y")))
            }
        }
    }
}

impl Case {
    /// The axes of the pictures of the orbit, with what is drawn in them: every body in x and y, unless `[plot]` is
    /// given, or the one orbit, which has no name.
    pub fn orbits<S: Real>(&self, geometry: &Geometry<S>) -> Vec<(String, Axes)> {
        if self.bodies.is_empty() || self.axes.is_some() {
            return vec![(String::new(), self.axes_or_default(geometry))];
        }
        let axes = |name: &String| Axes { x: format!("x_{name}"), y: format!("y_{name}") };
        self.bodies.iter().map(|name| (name.clone(), axes(name))).collect()
    }

    /// The axes of `[plot]` or, without it, those that suit the coordinates: the Cartesian ones of coordinates that are
    /// called r, phi and perhaps theta; otherwise the first two coordinates besides t and a last one that the scene
    /// adds itself, active ones before others. A single one is drawn over t or, without that, against its velocity.
    fn axes_or_default<S: Real>(&self, geometry: &Geometry<S>) -> Axes {
        if let Some(axes) = &self.axes {
            return axes.clone();
        }
        let names = geometry.names();
        let has = |name: &str| names.iter().any(|other| other == name);
        let axes = |x: &str, y: &str| Axes { x: x.to_owned(), y: y.to_owned() };
        match (has("r") && has("phi"), has("theta")) {
            (true, true) => return axes("r*sin(theta)*cos(phi)", "r*sin(theta)*sin(phi)"),
            (true, false) => return axes("r*cos(phi)", "r*sin(phi)"),
            (false, _) => {}
        }
        let is_last_added = self.is_lifted() || self.geometry_text.tau().is_some();
        let is_place = |a: &usize| names[*a] != "t" && !(is_last_added && *a + 1 == names.len());
        let active = geometry.active().iter().copied().filter(is_place);
        let places: Vec<usize> = active.chain(geometry.ignorable().filter(is_place)).collect();
        match places.as_slice() {
            [] => axes(&names[0], &format!("{}_dot", names[0])),
            [one] if has("t") => axes("t", &names[*one]),
            [one] => axes(&names[*one], &format!("{}_dot", names[*one])),
            [x, y, ..] => axes(&names[*x], &names[*y]),
        }
    }
}

/// A direction of sign changes.
pub(super) fn direction(field: &Field<'_>) -> Result<Direction, CaseError> {
    let all = [Direction::Up, Direction::Down, Direction::Both];
    field.one_of("direction", "up, down or both", &all.map(|direction| (direction.as_str(), direction)))
}
