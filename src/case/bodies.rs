//! `[[body]]` and `[pair]`: bodies that move by Newton's law, with one formula for the energy of each pair.
//!
//! They are a potential in the coordinates x_NAME, y_NAME and perhaps z_NAME of all bodies, with a definition for each
//! distance.

use std::ops::Range;

use super::CaseError;
use super::names::{self, NameTable};
use super::potential::added;
use super::reader::Field;
use super::scenery::{Places, Scenery};
use super::start_data::{Given, Rate};
use crate::geometry::{GeometryText, Law, Place, Potential, value_of};

/// The mass of a body without mass, in units of the largest one: it moves nothing, and no digit shows it.
const MASSLESS: &str = "1e-90";
const AXES: [&str; 3] = ["x", "y", "z"];

struct Body<'t> {
    name: &'t str,
    /// Where its name stands.
    place: Range<usize>,
    mass: Field<'t>,
    position: Field<'t>,
    velocity: Field<'t>,
}

/// Reads the bodies, which are `field`, and their potential.
pub(super) fn read<'t>(root: &Field<'t>, field: &Field<'t>) -> Result<Scenery<'t>, CaseError> {
    let pair = root.table("pair");
    let bodies = field.tables(true)?.into_iter().map(body).collect::<Result<Vec<_>, _>>()?;
    let formula = pair.get("formula").ok_or_else(|| {
        let help = "give the energy of a pair, for example [pair] formula = \"-m_1*m_2/r\"";
        pair.error("missing field `formula` of [pair]").with_help(help)
    })?;
    let (mut start, mut coordinates) = (Vec::new(), Vec::new());
    for Body { name, place, position, velocity, .. } in &bodies {
        let [places, speeds] = [position.formulas()?, velocity.formulas()?];
        if !(2..=3).contains(&places.len()) || speeds.len() != places.len() {
            let message = format!("position and velocity must have two or three numbers each, found {}", speeds.len());
            return Err(if speeds.len() == places.len() { position } else { velocity }.error(message));
        }
        let axes = AXES.iter().take(places.len());
        coordinates.extend(axes.map(|axis| (format!("{axis}_{name}"), place.clone())));
        start.extend(places.into_iter().zip(speeds).map(|(place, speed)| Given {
            position: Some((place, position.clone())),
            rate: Some((Rate::Velocity(speed), velocity.clone())),
        }));
    }
    let coordinates = names::checked(field, coordinates, added(Law::Newtonian))?;
    let dimension = coordinates.len() / bodies.len().max(1);
    if let Some(Body { position, .. }) =
        bodies.iter().find(|body| body.position.formulas().map_or(0, |q| q.len()) != dimension)
    {
        let message = format!("'{}' must have {dimension} numbers, as those of the first body", position.path);
        return Err(position.error(message));
    }
    let mut taken = NameTable::of_potential(&coordinates, added(Law::Newtonian));
    let (mut places, mut parameters) = (Places::default(), Vec::new());
    places.keep_parameters(root, &mut taken, &mut parameters)?;
    if let Some((_, own)) = places.0.iter().find(|(_, field)| ["r", "m_1", "m_2"].contains(&field.key.as_str())) {
        let message = format!("'{}' has a meaning in the formula of a pair: its distance, or a mass", own.key);
        return Err(own.key_error(message).with_help("choose another name"));
    }
    let masses = masses(field, &bodies, &parameters)?;
    let (expression, definitions) = energy(&formula, &bodies, &masses, &parameters, dimension)?;
    places.0.push((Place::Potential, formula.clone()));
    let masses = masses.iter().flat_map(|mass| vec![mass.clone(); dimension]).collect();
    let [mass, c] = [(); 2].map(|()| "1".to_owned());
    let potential = Some(Potential { expression, mass, masses, c, law: Law::Newtonian });
    let text = GeometryText { coordinates, definitions, parameters, potential, ..GeometryText::default() };
    let bodies = bodies.iter().map(|body| body.name.to_owned()).collect();
    Ok(Scenery { bodies, start, ..Scenery::new(text, places, pair, formula) })
}

/// A body as it is given.
fn body(field: Field<'_>) -> Result<Body<'_>, CaseError> {
    let get = |key: &str| {
        let help = "a body is { name = \"sun\", mass = 1.0, position = [0.0, 0.0], velocity = [0.0, 0.0] }";
        field.get(key).ok_or_else(|| field.error(format!("missing field `{key}`")).with_help(help))
    };
    let (name, mass, position, velocity) = (get("name")?, get("mass")?, get("position")?, get("velocity")?);
    Ok(Body { name: name.string()?, place: name.span, mass, position, velocity })
}

/// The masses as formulas.
fn masses(field: &Field<'_>, bodies: &[Body<'_>], parameters: &[(String, String)]) -> Result<Vec<String>, CaseError> {
    let mut masses = Vec::new();
    for Body { mass, .. } in bodies {
        let text = mass.formula()?;
        let value: f64 = value_of(&text, parameters).map_err(|error| mass.error(format!("{error}")))?;
        if value < 0.0 {
            return Err(mass.error(format!("a mass must not be negative, got {value}")));
        }
        masses.push((text, value));
    }
    let largest = masses.iter().filter(|(_, value)| *value > 0.0).max_by(|a, b| a.1.total_cmp(&b.1));
    let (largest, _) = largest.ok_or_else(|| field.error("at least one body must have a mass"))?;
    let massless = format!("{MASSLESS}*({largest})");
    Ok(masses.into_iter().map(|(text, value)| if value == 0.0 { massless.clone() } else { text }).collect())
}

/// The energy of all pairs, and their distances as definitions. Two bodies without mass do not see each other.
fn energy(
    formula: &Field<'_>,
    bodies: &[Body<'_>],
    masses: &[String],
    parameters: &[(String, String)],
    dimension: usize,
) -> Result<(String, Vec<(String, String)>), CaseError> {
    let text = formula.string()?;
    let is_massless: Vec<bool> = masses.iter().map(|mass| mass.starts_with(MASSLESS)).collect();
    if is_massless.contains(&true) {
        let of_one = substituted(text, &[("r", "1"), ("m_1", "0"), ("m_2", "1")]);
        if value_of::<f64>(&of_one, parameters).is_ok_and(|energy| energy != 0.0) {
            let help = "give every body a mass, or a formula that both masses are factors of";
            return Err(formula.error("a body without mass needs an energy that is 0 for m_1 = 0").with_help(help));
        }
    }
    let (mut terms, mut distances) = (Vec::new(), Vec::new());
    for (j, second) in bodies.iter().enumerate() {
        for (i, first) in bodies[..j].iter().enumerate().filter(|(i, _)| !(is_massless[*i] && is_massless[j])) {
            let (one, two) = (first.name, second.name);
            let squares: Vec<String> =
                AXES.iter().take(dimension).map(|axis| format!("({axis}_{one} - {axis}_{two})^2")).collect();
            let distance = format!("r_{one}_{two}");
            if parameters.iter().any(|(name, _)| *name == distance) {
                return Err(formula.error(format!("the parameter '{distance}' has the name of a distance")));
            }
            let [mass, other] = [&masses[i], &masses[j]].map(|mass| format!("({mass})"));
            terms.push(format!("({})", substituted(text, &[("r", &distance), ("m_1", &mass), ("m_2", &other)])));
            distances.push((distance, format!("sqrt({})", squares.join(" + "))));
        }
    }
    Ok((if terms.is_empty() { "0".to_owned() } else { terms.join(" + ") }, distances))
}

/// A formula in which names stand for others.
fn substituted(text: &str, names: &[(&str, &str)]) -> String {
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let (mut out, mut rest) = (String::new(), text);
    while let Some(first) = rest.chars().next() {
        let length = rest.find(|c: char| is_name(c) != is_name(first)).unwrap_or(rest.len());
        let (word, after) = rest.split_at(length);
        out += names.iter().find(|(name, _)| *name == word).map_or(word, |(_, other)| other);
        rest = after;
    }
    out
}
