//! The geometry of a case, with the place of every formula.

use super::CaseError;
use super::bodies::Component;
use super::conformal;
use super::reader::{Field, Section};
use crate::formula::functions;
use crate::geometry::{Geometry, GeometryError, GeometryText, Place, Preset};
use crate::number::Real;

/// Help lists no more names than this.
const MOST_NAMED: usize = 12;

/// The geometry of a case while it is read.
pub(super) struct Scenery<'t> {
    pub(super) text: GeometryText,
    pub(super) preset: Option<&'static Preset>,
    /// Where the formulas stand. Those of a preset stand nowhere.
    pub(super) fields: Vec<(Place, Field<'t>)>,
    /// `[metric]` or `[potential]`.
    pub(super) section: Section<'t>,
    /// The coordinates, the components or the preset: what a mistake in the metric as a whole is about.
    pub(super) whole: Option<Field<'t>>,
    /// The coefficients of a potential of one coordinate, lowest power first, if it is given by them.
    pub(super) coefficients: Option<Vec<String>>,
    /// True if it is a potential of x alone, as the paper has it.
    pub(super) is_of_x: bool,
    /// The names of bodies, and where they start, if it is made of these.
    pub(super) bodies: Vec<String>,
    pub(super) start: Vec<Component<'t>>,
}

/// The compiled geometry of a case.
pub(super) fn compiled<S: Real>(text: &GeometryText, is_of_x: bool) -> Result<Geometry<S>, GeometryError> {
    match text {
        GeometryText::Potential(potential) if is_of_x => Geometry::of_x(potential.clone()),
        _ => Geometry::new(text),
    }
}

impl Scenery<'_> {
    /// The compiled geometry.
    pub(super) fn geometry<S: Real>(&self) -> Result<Geometry<S>, CaseError> {
        compiled(&self.text, self.is_of_x).map_err(|error| self.error(&error))
    }

    /// The compiled geometry that the initial data belong to, if it is another one.
    pub(super) fn bare<S: Real>(&self) -> Result<Option<Geometry<S>>, CaseError> {
        let compiled = |text| Geometry::new(&text).map_err(|error| self.error(&error));
        conformal::bare(&self.text).map(compiled).transpose()
    }

    fn error(&self, error: &GeometryError) -> CaseError {
        let field = |place: &Place| self.fields.iter().find(|(other, _)| other == place).map(|(_, field)| field);
        let whole = |message: String| match &self.whole {
            Some(field) => field.error(message),
            None => self.section.error(message),
        };
        let names = self.text.coordinates();
        let list = |block: &[usize]| block.iter().map(|&a| names[a].as_str()).collect::<Vec<_>>().join(", ");
        match error {
            GeometryError::Formula(place, formula) => match field(place) {
                Some(field) => field.formula_error(formula, self.known(place)),
                None => whole(format!("{formula}")),
            },
            GeometryError::NotFinite(place) => match field(place) {
                Some(field) => field.error(format!("'{}' is not a finite number", field.path)),
                None => whole(format!("{error}")),
            },
            GeometryError::Circular(circle) => {
                let place = |place: fn(String) -> Place| field(&place(circle[0].clone()));
                match place(Place::Definition).or_else(|| place(Place::Parameter)) {
                    Some(field) => field.error(format!("{error}")),
                    None => whole(format!("{error}")),
                }
            }
            GeometryError::WithoutComponent(a) => {
                let name = &names[*a];
                whole(format!("no component with '{name}' is given, so the metric has no inverse"))
                    .with_help(format!("give a component \"{name} {name}\", or leave out the coordinate"))
            }
            GeometryError::Degenerate(block) => {
                whole(format!("the determinant of the metric is zero everywhere (coordinates {})", list(block)))
            }
            GeometryError::BlockTooLarge { .. } => whole(format!("{error}")),
        }
    }

    /// The names that a formula may use.
    fn known(&self, place: &Place) -> String {
        let (positions, definitions) = (self.text.positions(), self.text.definitions());
        let constants = || self.text.parameters().iter().map(|(name, _)| name.clone());
        let names: Vec<String> = match place {
            Place::Parameter(_) | Place::Mass(_) | Place::SpeedOfLight => constants().collect(),
            _ => {
                let velocities = positions.iter().map(|name| format!("{name}_dot"));
                let velocities = velocities.filter(|_| matches!(place, Place::Force(_)));
                let defined = definitions.iter().map(|(name, _)| name.clone());
                positions.iter().cloned().chain(velocities).chain(constants()).chain(defined).collect()
            }
        };
        known(&names)
    }
}

/// The names and functions that a formula may be made of, in words.
pub(super) fn known(names: &[String]) -> String {
    let more = names.len().saturating_sub(MOST_NAMED);
    let first = &names[..names.len() - more];
    let mut names: String = first.iter().map(|name| format!("{name}, ")).collect();
    if more > 0 {
        names += &format!("{more} more names, ");
    }
    let functions = functions().collect::<Vec<_>>().join(" ");
    format!("known are {names}pi, numbers, + - * / ^, parentheses and {functions}")
}
