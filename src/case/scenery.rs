//! The geometry of a case, with the place of every formula, and its conformal factor Ω.
//!
//! The initial data are those of the metric without Ω. Momenta are the same with Ω and without, velocities are divided
//! by Ω. A particle with K ≠ 0 is one with K = 0 that has one more flat coordinate, tau. Without Ω its component is −1
//! for K > 0 and 1 for K < 0, and dtau/dγ = √|K|.

use std::sync::Arc;

use super::CaseError;
use super::compiled::Compiled;
use super::keys::{FORMER, PARAMETERS};
use super::names::{self, NameTable};
use super::reader::Field;
use super::start::{self, NoStart};
use super::start_data::{Given, StartData};
use crate::formula::functions;
use crate::geometry::{Geometry, GeometryError, GeometryText, Law, Observable, Place, Preset, Start, Tau, value_of};
use crate::number::Real;

/// Help lists no more names than this.
const MOST_NAMED: usize = 12;

/// The meaning of names of the case's own.
pub(super) struct Kind {
    /// In words.
    name: &'static str,
    /// As places of formulas.
    place: fn(String) -> Place,
    read: fn(&Field<'_>) -> Result<String, CaseError>,
}

const PARAMETER: Kind = Kind { name: "a parameter", place: Place::Parameter, read: |field| field.number_of_start() };
const FORMER_PARAMETER: Kind = Kind { read: |field| field.formula(), ..PARAMETER };
pub(super) const DEFINITION: Kind =
    Kind { name: "a definition", place: Place::Definition, read: |field| field.formula() };

/// Formulas with where they stand. Those of a preset stand nowhere.
#[derive(Default)]
pub(super) struct Places<'t>(pub(super) Vec<(Place, Field<'t>)>);

impl<'t> Places<'t> {
    /// The formula of a field.
    pub(super) fn keep(&mut self, place: Place, field: Field<'t>) -> Result<String, CaseError> {
        let formula = field.formula()?;
        self.0.push((place, field));
        Ok(formula)
    }

    /// The parameters of the case, in the table of all formulas and in the former ones: they replace those of these
    /// names, or are appended.
    pub(super) fn keep_parameters(
        &mut self,
        root: &Field<'t>,
        taken: &mut NameTable,
        formulas: &mut Vec<(String, String)>,
    ) -> Result<(), CaseError> {
        self.keep_named(&root.table(PARAMETERS), PARAMETER, taken, formulas)?;
        let mut former = FORMER.iter().filter_map(|place| root.find(place));
        former.try_for_each(|table| self.keep_named(&table, FORMER_PARAMETER, taken, formulas))
    }

    /// The formulas of a table below names of their own: they replace those of these names, or are appended.
    pub(super) fn keep_named(
        &mut self,
        section: &Field<'t>,
        Kind { name: kind, place, read }: Kind,
        taken: &mut NameTable,
        formulas: &mut Vec<(String, String)>,
    ) -> Result<(), CaseError> {
        for field in section.fields() {
            taken.take(&field, kind)?;
            let name = field.key.clone();
            let formula = read(&field)?;
            self.0.push((place(name.clone()), field));
            match formulas.iter_mut().find(|(other, _)| *other == name) {
                Some((_, old)) => *old = formula,
                None => formulas.push((name, formula)),
            }
        }
        Ok(())
    }

    /// The formulas of a table below the names of coordinates.
    pub(super) fn keep_by_coordinate(
        &mut self,
        section: &Field<'t>,
        coordinates: &[String],
        place: impl Fn(usize) -> Place,
    ) -> Result<Vec<(usize, String)>, CaseError> {
        let mut formulas = Vec::new();
        for field in section.fields() {
            let a = names::index(&field, coordinates)?;
            formulas.push((a, self.keep(place(a), field)?));
        }
        formulas.sort_by_key(|(a, _)| *a);
        Ok(formulas)
    }

    /// Where a formula stands.
    pub(super) fn of(&self, place: &Place) -> Option<&Field<'t>> {
        self.0.iter().find(|(other, _)| other == place).map(|(_, field)| field)
    }
}

/// The geometry of a case while it is read.
pub(super) struct Scenery<'t> {
    pub(super) text: GeometryText,
    pub(super) places: Places<'t>,
    /// `[metric]`, `[potential]` or `[pair]`.
    pub(super) section: Field<'t>,
    /// The coordinates, the components or the preset: what a mistake in the metric as a whole is about.
    pub(super) whole: Field<'t>,
    pub(super) preset: Option<&'static Preset>,
    /// The coefficients of a potential of one coordinate, lowest power first, if it is given by them.
    pub(super) coefficients: Option<Vec<String>>,
    /// The names of bodies, and where they start, if it is made of these.
    pub(super) bodies: Vec<String>,
    pub(super) start: Vec<Given<'t>>,
}

/// The geometry that the initial data belong to, if it is another one: that without Ω. With Newton's law they are those
/// of the geometry with Ω.
pub(super) fn bare(text: &GeometryText) -> Option<GeometryText> {
    let has_other = text.conformal.is_some() && text.law() != Some(Law::Newtonian);
    has_other.then(|| GeometryText { conformal: None, tau: None, ..text.clone() })
}

/// Ω at a point, if there is one.
fn factor<S: Real>(text: &GeometryText, q: &[S]) -> Option<S> {
    let omega = Observable::new(text.conformal.as_ref()?, text, Place::Conformal);
    let zeros = vec![S::ZERO; q.len()];
    Some(omega.expect("a geometry that compiles has such an Ω").at(q, &zeros, &zeros, S::ZERO))
}

/// The start that the data describe in the compiled geometry of `text`. `is_double` says whether the two roots for a
/// rate that follows from K are one, if that is known.
pub(super) fn start<S: Real>(
    text: &GeometryText,
    geometry: &Geometry<S>,
    data: &StartData,
    rounding: f64,
    is_double: Option<bool>,
) -> Result<Start<S>, NoStart> {
    let (bare, parameters) = (bare(text), &text.parameters);
    let Some(bare) = bare.map(|text| Geometry::new(&text).expect("a geometry with Ω compiles without it")) else {
        return start::solve(data, geometry, parameters, rounding, is_double).map(|(start, _)| start);
    };
    let (mut start, _) = start::solve(data, &bare, parameters, rounding, is_double)?;
    if let Some(tau) = text.tau {
        let given = data.norm.as_ref().map(|norm| value_of(norm, parameters).expect("K is a finite number"));
        let k: S = given.unwrap_or_else(|| bare.norm(&start.q, &start.q_dot));
        let rate = k.abs().sqrt();
        start.q.push(S::ZERO);
        start.q_dot.push(rate);
        start.p.push(tau.component::<S>() * rate);
    }
    let omega = factor(text, &start.q).unwrap_or(S::ONE);
    start.q_dot.iter_mut().for_each(|u| *u = *u / omega);
    Ok(start)
}

impl<'t> Scenery<'t> {
    /// A geometry without what only some have.
    pub(super) fn new(text: GeometryText, places: Places<'t>, section: Field<'t>, whole: Field<'t>) -> Self {
        let (bodies, start) = (Vec::new(), Vec::new());
        Self { text, places, section, whole, preset: None, coefficients: None, bodies, start }
    }

    /// The programs that the formulas compile to: `known`, if it has them.
    pub(super) fn compiled(&self, known: Option<&Arc<Compiled>>) -> Result<Arc<Compiled>, CaseError> {
        Compiled::new(&self.text, self.section.source.is_of_x, known).map_err(|error| self.error(&error))
    }

    /// The geometry that they make.
    pub(super) fn geometry<S: Real>(&self, compiled: &Compiled) -> Result<Geometry<S>, CaseError> {
        compiled.geometry().map_err(|error| self.error(&error))
    }

    /// The compiled geometry that the initial data belong to, if it is another one.
    pub(super) fn bare<S: Real>(&self) -> Result<Option<Geometry<S>>, CaseError> {
        bare(&self.text).map(|text| Geometry::new(&text).map_err(|error| self.error(&error))).transpose()
    }

    fn error(&self, error: &GeometryError) -> CaseError {
        let place = match error {
            GeometryError::Circular(circle) => {
                let of = |kind: fn(String) -> Place| self.places.of(&kind(circle[0].clone()));
                of(Place::Definition).or_else(|| of(Place::Parameter))
            }
            _ => error.place().and_then(|place| self.places.of(place)),
        };
        let whole = |message: String| place.unwrap_or(&self.whole).error(message);
        match (error, place) {
            (GeometryError::Formula(place, formula), Some(field)) => field.formula_error(formula, self.known(place)),
            (GeometryError::Formula(_, formula), None) => whole(formula.to_string()),
            (GeometryError::NotFinite(_), Some(field)) => whole(format!("'{}' is not a finite number", field.path)),
            (GeometryError::Metric(message, help), _) => whole(message.clone()).with_hint(help.clone()),
            _ => whole(error.to_string()),
        }
    }

    /// The names that a formula may use.
    fn known(&self, place: &Place) -> String {
        let parameters = self.text.parameters.iter().map(|(name, _)| name.clone());
        if matches!(place, Place::Parameter(_) | Place::Mass(_) | Place::SpeedOfLight) {
            return known(parameters.collect());
        }
        let positions = self.text.positions();
        let velocities = positions.iter().map(|name| format!("{name}_dot"));
        let velocities: Vec<String> = velocities.filter(|_| matches!(place, Place::Force(_))).collect();
        let definitions = self.text.definitions.iter().map(|(name, _)| name.clone());
        known(positions.into_iter().chain(velocities).chain(parameters).chain(definitions).collect())
    }

    /// The coordinate tau that a start with K = `k` ≠ 0 needs, if there is a factor Ω.
    pub(super) fn tau<S: Real>(&self, k: S, has_force: bool) -> Result<Option<Tau>, CaseError> {
        let Some(conformal) = self.places.of(&Place::Conformal) else { return Ok(None) };
        let found = format!("these data give K = {}", k.to_f64());
        if self.text.potential.is_some() {
            let help = "take law = \"newtonian\", or write the metric as [metric], where a particle with mass may have \
                        it";
            let message = format!("conformal needs a null start, K = 0, and {found}");
            return Err(conformal.error(message).with_help(help));
        }
        if has_force {
            let help = "a force may change K, and with conformal K is that of the start: leave out one of the two";
            let message = format!("conformal and a force need a null start, K = 0, and {found}");
            return Err(conformal.error(message).with_help(help));
        }
        self.check_names()?;
        Ok(Some(if k > S::ZERO { Tau::Timelike } else { Tau::Spacelike }))
    }

    /// Refuses what has the name of the coordinate tau, of its velocity or of its momentum.
    fn check_names(&self) -> Result<(), CaseError> {
        let own = self.places.0.iter().filter_map(|(place, field)| match place {
            Place::Parameter(_) => Some(("parameter", field.key.clone(), field.key_span.clone())),
            Place::Definition(_) => Some(("definition", field.key.clone(), field.key_span.clone())),
            _ => None,
        });
        let coordinates = self.section.read("coordinates", Field::strings)?.unwrap_or_default();
        let coordinates = coordinates.into_iter().map(|(name, span)| ("coordinate", name.to_owned(), span));
        let is_taken = |name: &str| name.strip_prefix("p_").or(name.strip_suffix("_dot")).unwrap_or(name) == Tau::NAME;
        let Some((kind, name, span)) = own.chain(coordinates).find(|(_, name, _)| is_taken(name)) else {
            return Ok(());
        };
        let message = format!(
            "the {kind} '{name}' has the name of what conformal adds, the coordinate tau of a start with K not 0"
        );
        Err(self.section.error_at(span, message).with_help("choose another name"))
    }

    /// Refuses an Ω at a point that is not positive: it would turn the direction of γ.
    pub(super) fn check_factor<S: Real>(&self, q: &[S]) -> Result<(), CaseError> {
        let omega = factor(&self.text, q).filter(|omega| bare(&self.text).is_some() && *omega <= S::ZERO);
        let Some(omega) = omega else { return Ok(()) };
        let message = format!("conformal must be positive at the start, and it is {}", omega.to_f64());
        let error = self.places.of(&Place::Conformal).unwrap_or(&self.whole).error(message);
        Err(error.with_help("take a factor that is positive along the whole orbit"))
    }
}

/// The names and functions that a formula may be made of, in words.
pub(super) fn known(mut names: Vec<String>) -> String {
    let more = names.len().saturating_sub(MOST_NAMED);
    if more > 0 {
        names.truncate(MOST_NAMED);
        names.push(format!("{more} more names"));
    }
    let names: String = names.iter().map(|name| format!("{name}, ")).collect();
    let functions = functions().collect::<Vec<_>>().join(" ");
    format!("known are {names}pi, numbers, + - * / ^, parentheses and {functions}")
}
