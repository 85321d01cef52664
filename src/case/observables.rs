//! `[invariants]`, `[events]` and `[plot]` of a case: formulas of what a run computes.

use super::initial::check_number;
use super::names;
use super::reader::Field;
use super::scenery::known;
use super::{Case, CaseError};
use crate::formula::{FormulaError, Graph, Known, Names, parse};
use crate::geometry::{Direction, Geometry, GeometryText, observed, value_of};
use crate::number::Real;
use crate::solve::Quantity;

/// All directions.
pub(super) const DIRECTIONS: [Direction; 3] = [Direction::Up, Direction::Down, Direction::Both];

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
    /// The quantities that it sets, with their formulas: the state is changed, and the run goes on from there.
    pub set: Vec<(Quantity, String)>,
}

/// The names that the events of this section set.
pub(super) fn set_names(events: &Field<'_>) -> Vec<String> {
    let set = events.fields().into_iter().flat_map(|event| event.table("set").fields());
    set.map(|field| field.key).collect()
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

    fn check(&self, field: &Field<'_>, variables: Vec<String>) -> Result<String, CaseError> {
        let text = field.formula()?;
        let understood = self.understand(&text, variables);
        understood.map_err(|(error, names)| field.formula_error(&error, known(names)))?;
        Ok(text)
    }

    /// Checks a formula in these variables, in parameters and definitions.
    ///
    /// # Errors
    /// The mistake, and the names that it may have.
    pub(super) fn understand(&self, text: &str, variables: Vec<String>) -> Result<(), (FormulaError, Vec<String>)> {
        let named = self.scene.parameters.iter().chain(&self.scene.definitions).map(|(name, _)| name.clone());
        let all: Vec<String> = variables.into_iter().chain(named).collect();
        // A formula is readable or not independently of what its names stand for.
        let variables: Vec<&str> = all.iter().map(String::as_str).collect();
        let table = |(name, table): &(String, _)| (name.clone(), Known::Table(*table));
        let tables: Names<f64> = self.scene.tables.iter().map(table).collect();
        let parsed = parse(text, &variables, &tables, &mut Graph::default()).map(drop);
        parsed.map_err(|error| (error, all.clone()))
    }

    /// A number, checked, as it is written and as it is.
    pub(super) fn number(&self, field: &Field<'_>) -> Result<(String, f64), CaseError> {
        let (text, parameters) = (field.formula()?, &self.scene.parameters);
        check_number(&text, field, parameters)?;
        let value = value_of(&text, parameters).unwrap_or(f64::NAN);
        Ok((text, value))
    }

    /// A positive number; `name` is the one of messages.
    pub(super) fn positive(&self, name: &str, field: &Field<'_>) -> Result<String, CaseError> {
        match self.number(field)? {
            (_, value) if value <= 0.0 => Err(field.error(format!("{name} must be positive, got {value}"))),
            (text, _) => Ok(text),
        }
    }

    /// Reads an entry of `[invariants]`.
    pub(super) fn invariant(&self, field: &Field<'_>) -> Result<(String, String), CaseError> {
        names::check_invariant(field)?;
        Ok((field.key.clone(), self.check(field, observed(self.coordinates))?))
    }

    /// Reads an entry of `[events]`.
    pub(super) fn event(&self, event: &Field<'_>) -> Result<Event, CaseError> {
        names::check_event(event)?;
        let name = event.key.clone();
        let when = event.read("when", |field| self.of_velocities(field))?;
        let when = when.ok_or_else(|| event.error(format!("the event '{name}' has no `when`")))?;
        let direction = event.given("direction", direction)?;
        let until = event.given("until", Field::is_true)?;
        if let Some(set) = event.get("set").filter(|_| until) {
            let help = "leave one of them out: an event ends the run, or the run goes on from what it sets";
            return Err(set.key_error(format!("the event '{name}' has both until and set")).with_help(help));
        }
        let set = event.read("set", |field| self.set(field))?.unwrap_or_default();
        Ok(Event { name, when, direction, until, set })
    }

    /// The quantities that an event sets, with their formulas.
    fn set(&self, field: &Field<'_>) -> Result<Vec<(Quantity, String)>, CaseError> {
        let fields = field.fields();
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
        if let Some(parameter) = self.scene.parameters.iter().position(|(name, _)| name == key) {
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
    pub(super) fn axes(&self, plot: &Field<'_>) -> Result<Option<Axes>, CaseError> {
        let axis = |key| plot.read(key, |field| self.of_velocities(field));
        match (axis("x")?, axis("y")?) {
            (Some(x), Some(y)) => Ok(Some(Axes { x, y })),
            (None, None) if !plot.is_table() => Ok(None),
            (x, _) => {
                let missing = if x.is_none() { "x" } else { "y" };
                Err(plot.error(format!("missing field `{missing}`: [plot] needs the formulas x and y")))
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
        let is_last_added = self.is_lifted() || self.geometry_text.tau.is_some();
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
    field.one_of("direction", "up, down or both", &DIRECTIONS.map(|direction| (direction.as_str(), direction)))
}
