//! `[potential]` and `[particle]`.

use super::CaseError;
use super::keys;
use super::names::{self, NameTable};
use super::reader::Field;
use super::scenery::{DEFINITION, Places, Scenery};
use crate::geometry::{GeometryText, Law, Place, Potential};

/// The words for a law of motion.
pub(super) const LAWS: [(&str, Law); 2] = [("relativistic", Law::Relativistic), ("newtonian", Law::Newtonian)];
pub(super) const POTENTIALS: &str = "give formula = \"expression\" or, with one coordinate, one of free = {}, \
                                     linear = { alpha }, quartic = { kappa }, polynomial = { coefficients }";

/// Reads `[potential]` and `[particle]`, and `[force]`, which stands for `[potential]` with this force.
pub(super) fn read<'t>(root: &Field<'t>) -> Result<Scenery<'t>, CaseError> {
    let (section, particle) = (root.table("potential"), root.table("particle"));
    let mut kinds: Vec<Field<'t>> = keys::potentials().filter_map(|kind| section.get(kind)).collect();
    let law = particle.given("law", law)?;
    check_particle(&particle, law)?;
    let names = coordinates(root, law)?.unwrap_or_else(|| vec!["x".to_owned()]);
    if let [first, second, ..] = kinds.as_slice() {
        let message = format!("more than one potential is given: {} and {}", first.key, second.key);
        return Err(second.key_error(message).with_help(POTENTIALS));
    }
    let (kind, mut places) = (kinds.pop(), Places::default());
    let (expression, coefficients) = match &kind {
        Some(kind) => expression(kind, &names, &mut places)?,
        // Under Newton's law a force is enough.
        None if law == Law::Newtonian && force(root).is_some() => ("0".to_owned(), None),
        None => return Err(section.error("no potential is given").with_help(POTENTIALS)),
    };
    let mut taken = NameTable::of_potential(&names, added(law));
    let mut text = GeometryText { coordinates: names, ..GeometryText::default() };
    places.keep_parameters(root, &mut taken, &mut text.parameters)?;
    text.parameters.sort();
    places.keep_named(&section.table("definitions"), DEFINITION, &mut taken, &mut text.definitions)?;
    text.one_form = places.keep_by_coordinate(&section.table("one_form"), &text.coordinates, Place::OneForm)?;
    if let Some(force) = force(root) {
        text.force = places.keep_by_coordinate(&force, &text.coordinates, Place::Force)?;
    }
    text.conformal = section.get("conformal").map(|field| places.keep(Place::Conformal, field)).transpose()?;
    text.potential = Some(potential(expression, law, &text.coordinates, &particle, &mut places)?);
    let whole = kind.unwrap_or_else(|| section.clone());
    Ok(Scenery { coefficients, ..Scenery::new(text, places, section, whole) })
}

/// The force, which has a table of its own or stands in `[potential]`.
fn force<'t>(root: &Field<'t>) -> Option<Field<'t>> {
    root.get("force").or_else(|| root.table("potential").get("force"))
}

/// The coordinates that a potential has besides its own.
pub(super) fn added(law: Law) -> &'static [&'static str] {
    if law == Law::Newtonian { &["t", "s"] } else { &["t"] }
}

/// The coordinates of V or, without V, those of the force; `None` if there is neither.
pub(super) fn coordinates(root: &Field<'_>, law: Law) -> Result<Option<Vec<String>>, CaseError> {
    let section = root.table("potential");
    let is_given = keys::potentials().any(|kind| section.get(kind).is_some());
    let named = section.get("coordinates").or_else(|| force(root).filter(|_| !is_given));
    match named {
        Some(named) => names::coordinates(&named, added(law)).map(Some),
        None => Ok(is_given.then(|| vec!["x".to_owned()])),
    }
}

/// Refuses what Newton's law has no use for.
fn check_particle(particle: &Field<'_>, law: Law) -> Result<(), CaseError> {
    let [mass, masses, c] = ["mass", "masses", "c"].map(|key| particle.get(key).filter(|_| law == Law::Newtonian));
    if let Some(c) = c {
        let help = "leave c out, or take law = \"relativistic\"";
        return Err(c.key_error("Newton's law has no speed of light").with_help(help));
    }
    if let (Some(mass), Some(_)) = (mass, masses) {
        let message = "both mass and masses are given, and Newton's law needs one of them only";
        return Err(mass.key_error(message).with_help("keep masses, or one mass for all coordinates"));
    }
    Ok(())
}

/// A law of motion.
pub(super) fn law(field: &Field<'_>) -> Result<Law, CaseError> {
    field.one_of("law", "\"relativistic\" or \"newtonian\"", &LAWS)
}

/// The potential with its masses and c.
fn potential<'t>(
    expression: String,
    law: Law,
    coordinates: &[String],
    particle: &Field<'t>,
    places: &mut Places<'t>,
) -> Result<Potential, CaseError> {
    let mut number = |key: &str, place| particle.given(key, |field| places.keep(place, field.clone()));
    let (mass, c) = (number("mass", Place::Mass(None))?, number("c", Place::SpeedOfLight)?);
    let Some(field) = particle.get("masses") else {
        return Ok(Potential { expression, masses: vec![mass.clone(); coordinates.len()], mass, c, law });
    };
    let given = places.keep_by_coordinate(&field, coordinates, |a| Place::Mass(Some(a)))?;
    let masses = coordinates.iter().enumerate().map(|(a, name)| {
        let mass = given.iter().find(|(b, _)| *b == a).map(|(_, mass)| mass.clone());
        mass.ok_or_else(|| field.error(format!("'particle.masses' has no mass for the coordinate '{name}'")))
    });
    Ok(Potential { expression, mass, masses: masses.collect::<Result<_, _>>()?, c, law })
}

/// V as a formula, whatever kind of potential it is, and its coefficients if it is given by them.
fn expression<'t>(
    kind: &Field<'t>,
    coordinates: &[String],
    places: &mut Places<'t>,
) -> Result<(String, Option<Vec<String>>), CaseError> {
    let key = keys::of_potential(&kind.key).unwrap_or_default();
    if key == "expression" && !kind.is_table() {
        return Ok((places.keep(Place::Potential, kind.clone())?, None));
    }
    let factor = || kind.get(key).ok_or_else(|| kind.error(format!("missing field `{key}`")));
    if key == "expression" {
        return Ok((places.keep(Place::Potential, factor()?)?, None));
    }
    let [x] = coordinates else {
        let message = format!("'potential.{}' is for one coordinate, and there are {}", kind.key, coordinates.len());
        return Err(kind.key_error(message).with_help("write V as a formula"));
    };
    if key.is_empty() {
        return Ok(("0".to_owned(), Some(Vec::new())));
    }
    let factor = factor()?;
    let monomial = |power: usize| -> Result<_, CaseError> {
        let number = factor.number()?;
        let zeros = vec!["0".to_owned(); power];
        Ok((format!("({number}){}", format!("*{x}").repeat(power)), [zeros, vec![number]].concat()))
    };
    let (text, coefficients) = match key {
        "alpha" => monomial(1)?,
        "kappa" => monomial(4)?,
        _ => {
            let coefficients = factor.numbers()?;
            // By Horner's rule.
            let sum = |sum: String, c: &String| format!("({sum}*{x} + ({c}))");
            (coefficients.iter().rev().fold("0".to_owned(), sum), coefficients)
        }
    };
    places.0.push((Place::Potential, factor));
    Ok((text, Some(coefficients)))
}
