//! `[potential]` and `[particle]`.

use super::CaseError;
use super::metric::by_coordinate;
use super::names::{self, Taken};
use super::reader::{Field, Section};
use super::scenery::Scenery;
use crate::formula::similar::nearest;
use crate::geometry::{GeometryText, Law, Place, PotentialText};

/// The keys that say what the potential is.
pub(super) const KINDS: [&str; 5] = ["free", "linear", "quartic", "polynomial", "formula"];
pub(super) const POTENTIALS: &str = "give formula = \"expression\" or { expression, parameters } or, with one \
                                     coordinate, one of free = {}, linear = { alpha }, quartic = { kappa }, \
                                     polynomial = { coefficients }";

/// The values of `[particle]`.
struct Particle<'t> {
    mass: Option<Field<'t>>,
    masses: Option<Field<'t>>,
    c: Option<Field<'t>>,
    law: Law,
}

/// Reads `[potential]` and `[particle]`, and `[force]`, which stands for `[potential]` with this force.
pub(super) fn read<'t>(
    mut section: Section<'t>,
    force: Option<Field<'t>>,
    particle: Section<'t>,
) -> Result<Scenery<'t>, CaseError> {
    let coordinates = section.take("coordinates");
    let kinds: Vec<Field<'t>> = KINDS.into_iter().filter_map(|kind| section.take(kind)).collect();
    let [one_form, definitions] = ["one_form", "definitions"].map(|key| section.section(key));
    let own = section.take("force");
    let (conformal, mut parameters) = (section.take("conformal"), vec![section.section("parameters")?]);
    let particle = read_particle(particle)?;
    let others: &[&str] = if particle.law == Law::Newtonian { &["t", "s"] } else { &["t"] };
    if let (Some(own), Some(_)) = (&own, &force) {
        let help = "keep one of them".to_owned();
        return Err(own.key_error("both [force] and potential.force are given").with_help(help));
    }
    let force = force.or(own);
    // Under Newton's law a force is enough.
    let alone = force.as_ref().filter(|_| kinds.is_empty() && particle.law == Law::Newtonian);
    let names = match (&coordinates, alone) {
        (Some(field), _) => names::coordinates(field, others)?,
        (None, Some(force)) => names::keys(force, others)?,
        (None, None) => vec!["x".to_owned()],
    };
    let kind = match kinds.as_slice() {
        [kind] => Some(kind.clone()),
        [] if alone.is_some() => None,
        [] => return Err(section.error("no potential is given").with_help(POTENTIALS.to_owned())),
        [first, second, ..] => {
            let message = format!("more than one potential is given: {} and {}", first.key, second.key);
            return Err(second.key_error(message).with_help(POTENTIALS.to_owned()));
        }
    };
    let mut places = Vec::new();
    let (expression, coefficients) = match &kind {
        Some(kind) => expression(kind, &names, &mut parameters, &mut places)?,
        None => ("0".to_owned(), None),
    };
    let mut taken = Taken::new(&[&["t".to_owned()], names.as_slice()].concat());
    let mut text = PotentialText { coordinates: names, expression, law: particle.law, ..PotentialText::default() };
    text.parameters = named(&parameters, ("a parameter", Place::Parameter), &mut taken, &mut places)?;
    text.parameters.sort();
    text.definitions = named(&[definitions?], ("a definition", Place::Definition), &mut taken, &mut places)?;
    text.one_form = by_coordinate(&one_form?, &text.coordinates, Place::OneForm, &mut places)?;
    if let Some(force) = &force {
        text.force = by_coordinate(&force.section()?, &text.coordinates, Place::Force, &mut places)?;
    }
    if let Some(field) = conformal {
        text.conformal = Some(field.formula()?);
        places.push((Place::Conformal, field));
    }
    add_particle(&mut text, particle, &mut places)?;
    let (is_of_x, text, whole) = (section.is_of_x(), GeometryText::Potential(text), kind);
    let (bodies, start) = (Vec::new(), Vec::new());
    Ok(Scenery { text, preset: None, fields: places, section, whole, coefficients, is_of_x, bodies, start })
}

/// The formulas of some tables below names of their own.
pub(super) fn named<'t>(
    sections: &[Section<'t>],
    (kind, place): (&'static str, fn(String) -> Place),
    taken: &mut Taken,
    places: &mut Vec<(Place, Field<'t>)>,
) -> Result<Vec<(String, String)>, CaseError> {
    let mut formulas = Vec::new();
    for field in sections.iter().flat_map(Section::fields) {
        taken.take(&field, kind)?;
        formulas.push((field.key.clone(), field.formula()?));
        places.push((place(field.key.clone()), field));
    }
    Ok(formulas)
}

fn read_particle(mut section: Section<'_>) -> Result<Particle<'_>, CaseError> {
    let (mass, masses, c) = (section.take("mass"), section.take("masses"), section.take("c"));
    let law = section.take("law").map_or(Ok(Law::Relativistic), |field| self::law(&field))?;
    if let Some(c) = c.as_ref().filter(|_| law == Law::Newtonian) {
        let help = "leave c out, or take law = \"relativistic\"".to_owned();
        return Err(c.key_error("Newton's law has no speed of light").with_help(help));
    }
    if let (Some(mass), Some(_), Law::Newtonian) = (&mass, &masses, law) {
        let message = "both mass and masses are given, and Newton's law needs one of them only";
        return Err(mass.key_error(message).with_help("keep masses, or one mass for all coordinates".to_owned()));
    }
    Ok(Particle { mass, masses, c, law })
}

/// A law of motion.
pub(super) fn law(field: &Field<'_>) -> Result<Law, CaseError> {
    match field.string()? {
        "relativistic" => Ok(Law::Relativistic),
        "newtonian" => Ok(Law::Newtonian),
        name => {
            let meant = nearest(name, ["relativistic", "newtonian"]).map(|meant| format!("did you mean \"{meant}\"?"));
            let message = format!("unknown law \"{name}\", expected \"relativistic\" or \"newtonian\"");
            Err(field.error(message).with_help(meant))
        }
    }
}

/// Fills in the masses and c.
fn add_particle<'t>(
    text: &mut PotentialText,
    particle: Particle<'t>,
    places: &mut Vec<(Place, Field<'t>)>,
) -> Result<(), CaseError> {
    let mut number = |field: Option<Field<'t>>, place: Place| match field {
        Some(field) => {
            let text = field.formula()?;
            places.push((place, field));
            Ok::<String, CaseError>(text)
        }
        None => Ok("1".to_owned()),
    };
    text.mass = number(particle.mass, Place::Mass(None))?;
    text.c = number(particle.c, Place::SpeedOfLight)?;
    let Some(masses) = particle.masses else {
        text.masses = vec![text.mass.clone(); text.coordinates.len()];
        return Ok(());
    };
    let given = by_coordinate(&masses.section()?, &text.coordinates, |a| Place::Mass(Some(a)), places)?;
    for (a, name) in text.coordinates.iter().enumerate() {
        match given.iter().find(|(b, _)| *b == a) {
            Some((_, mass)) => text.masses.push(mass.clone()),
            None => return Err(masses.error(format!("'particle.masses' has no mass for the coordinate '{name}'"))),
        }
    }
    Ok(())
}

/// V as a formula, whatever kind of potential it is, and its coefficients if it is given by them. Parameters of its own
/// are appended.
fn expression<'t>(
    kind: &Field<'t>,
    coordinates: &[String],
    parameters: &mut Vec<Section<'t>>,
    places: &mut Vec<(Place, Field<'t>)>,
) -> Result<(String, Option<Vec<String>>), CaseError> {
    if kind.key == "formula" && !kind.is_table() {
        let text = kind.string()?.to_owned();
        places.push((Place::Potential, kind.clone()));
        return Ok((text, None));
    }
    let mut section = kind.section()?;
    if kind.key == "formula" {
        let expression = section.take("expression");
        parameters.push(section.section("parameters")?);
        let expression = expression.ok_or_else(|| section.error("missing field `expression`"))?;
        let text = expression.string()?.to_owned();
        places.push((Place::Potential, expression));
        return Ok((text, None));
    }
    let [x] = coordinates else {
        let message = format!("'potential.{}' is for one coordinate, and there are {}", kind.key, coordinates.len());
        return Err(kind.key_error(message).with_help("write V as a formula".to_owned()));
    };
    let key = match kind.key.as_str() {
        "linear" => "alpha",
        "quartic" => "kappa",
        "polynomial" => "coefficients",
        _ => return Ok(("0".to_owned(), Some(Vec::new()))),
    };
    let factor = section.take(key);
    let factor = factor.ok_or_else(|| section.error(format!("missing field `{key}`")))?;
    let zeros = |count: usize| vec!["0".to_owned(); count];
    let (text, coefficients) = match key {
        "alpha" => (format!("({})*{x}", factor.number()?), [zeros(1), vec![factor.number()?]].concat()),
        "kappa" => (format!("({})*{x}*{x}*{x}*{x}", factor.number()?), [zeros(4), vec![factor.number()?]].concat()),
        _ => {
            let coefficients = factor.numbers()?;
            // By Horner's rule.
            let sum = |sum: String, c: &String| format!("({sum}*{x} + ({c}))");
            (coefficients.iter().rev().fold("0".to_owned(), sum), coefficients)
        }
    };
    places.push((Place::Potential, factor));
    Ok((text, Some(coefficients)))
}
