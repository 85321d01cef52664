//! `[[body]]` and `[pair]`: bodies that move by Newton's law, with one formula for the energy of each pair.
//!
//! They are a potential in the coordinates x_NAME, y_NAME and perhaps z_NAME of all bodies, with a definition for each
//! distance.

use super::CaseError;
use super::initial::{Initial, Rate, StartData, add_lift};
use super::names::{self, Taken};
use super::potential::named;
use super::quantity::Quantity;
use super::reader::{Field, Section};
use super::scenery::Scenery;
use crate::geometry::{GeometryText, Law, Place, PotentialText, value_of};

/// The mass of a body without mass, in units of the largest one: it moves nothing, and no digit shows it.
const MASSLESS: &str = "1e-90";
/// The names of a pair in its formula.
const OF_PAIR: [&str; 3] = ["r", "m_1", "m_2"];

/// A body as it is given.
struct Body<'t> {
    name: Field<'t>,
    mass: Field<'t>,
    position: Field<'t>,
    velocity: Field<'t>,
}

/// The start of a coordinate of a body: where it stands in the text, and its value.
pub(super) struct Component<'t> {
    pub(super) position: (Quantity, Field<'t>),
    pub(super) velocity: (Quantity, Field<'t>),
}

/// Reads the bodies and their potential.
pub(super) fn read<'t>(field: &Field<'t>, mut pair: Section<'t>) -> Result<Scenery<'t>, CaseError> {
    let bodies = field.tables()?.into_iter().map(body).collect::<Result<Vec<_>, _>>()?;
    let formula = pair.take("formula");
    let parameters = pair.section("parameters")?;
    let formula = formula.ok_or_else(|| {
        let help = "give the energy of a pair, for example [pair] formula = \"-m_1*m_2/r\"".to_owned();
        pair.error("missing field `formula` of [pair]").with_help(help)
    })?;
    let (mut start, mut given) = (Vec::new(), Vec::new());
    for body in &bodies {
        let components = components(body)?;
        let (name, span) = (body.name.string()?, body.name.span());
        given
            .extend(["x", "y", "z"].iter().take(components.len()).map(|axis| (format!("{axis}_{name}"), span.clone())));
        start.extend(components);
    }
    let coordinates = names::checked(field, given, &["t", "s"])?;
    let dimension = coordinates.len() / bodies.len().max(1);
    if let Some(other) = bodies.iter().find(|body| body.position.length() != Some(dimension)) {
        let message = format!("'{}' must have {dimension} numbers, as those of the first body", other.position.path);
        return Err(other.position.error(message));
    }
    let mut taken = Taken::new(&[&["t".to_owned()], coordinates.as_slice()].concat());
    let mut fields = Vec::new();
    let parameters = named(&[parameters], ("a parameter", Place::Parameter), &mut taken, &mut fields)?;
    if let Some((_, own)) = fields.iter().find(|(_, field)| OF_PAIR.contains(&field.key.as_str())) {
        let message = format!("'{}' has a meaning in the formula of a pair: its distance, or a mass", own.key);
        return Err(own.key_error(message).with_help("choose another name".to_owned()));
    }
    let masses = masses(field, &bodies, &parameters)?;
    let (expression, definitions) = energy(&formula, &bodies, &masses, &parameters, dimension)?;
    fields.push((Place::Potential, formula.clone()));
    let text = PotentialText {
        coordinates,
        expression,
        definitions,
        parameters,
        mass: "1".to_owned(),
        masses: masses.iter().flat_map(|mass| vec![mass.clone(); dimension]).collect(),
        c: "1".to_owned(),
        law: Law::Newtonian,
        ..PotentialText::default()
    };
    Ok(Scenery {
        text: GeometryText::Potential(text),
        preset: None,
        fields,
        section: pair,
        whole: Some(formula),
        coefficients: None,
        is_of_x: false,
        bodies: bodies.iter().map(|body| body.name.string().unwrap_or_default().to_owned()).collect(),
        start,
    })
}

/// The start of bodies, which their own tables have. Only the time is given here.
pub(super) fn start<'t>(mut section: Section<'t>, bodies: &[Component<'t>]) -> Result<Initial<'t>, CaseError> {
    let time = section.take("t");
    section.finish().map_err(|error| error.with_help("position and velocity are those of [[body]]".to_owned()))?;
    let first = time.as_ref().map_or(Ok(Quantity::new("0")), Field::quantity)?;
    let (mut positions, mut q) = (vec![first], vec![time]);
    let (mut rates, mut fields) = (vec![None], vec![None]);
    for Component { position, velocity } in bodies {
        positions.push(position.0.clone());
        q.push(Some(position.1.clone()));
        rates.push(Some(Rate::Velocity(velocity.0.clone())));
        fields.push(Some(velocity.1.clone()));
    }
    positions.push(Quantity::new("0"));
    q.push(None);
    rates.push(None);
    fields.push(None);
    let mut norm = None;
    add_lift(&mut rates, &mut norm, None)?;
    let data = StartData { q: positions, rates: rates.into_iter().flatten().collect(), norm };
    Ok(Initial { data, q, rates: fields, norm: None, solve: None, section, from: None })
}

fn body(mut section: Section<'_>) -> Result<Body<'_>, CaseError> {
    let fields = ["name", "mass", "position", "velocity"].map(|key| section.take(key).ok_or(key));
    section.finish()?;
    let missing = |key: &str| {
        let help = "a body is { name = \"sun\", mass = 1.0, position = [0.0, 0.0], velocity = [0.0, 0.0] }".to_owned();
        section.error(format!("missing field `{key}`")).with_help(help)
    };
    let [name, mass, position, velocity] = fields.map(|field| field.map_err(missing));
    Ok(Body { name: name?, mass: mass?, position: position?, velocity: velocity? })
}

fn components<'t>(Body { position, velocity, .. }: &Body<'t>) -> Result<Vec<Component<'t>>, CaseError> {
    let [places, speeds] = [position.quantities()?, velocity.quantities()?];
    if !(2..=3).contains(&places.len()) || speeds.len() != places.len() {
        let message = format!("position and velocity must have two or three numbers each, found {}", speeds.len());
        return Err(if speeds.len() == places.len() { position } else { velocity }.error(message));
    }
    let components = places.into_iter().zip(speeds);
    let of = |(place, speed)| Component { position: (place, position.clone()), velocity: (speed, velocity.clone()) };
    Ok(components.map(of).collect())
}

/// The masses as formulas.
fn masses(field: &Field<'_>, bodies: &[Body<'_>], parameters: &[(String, String)]) -> Result<Vec<String>, CaseError> {
    let texts = bodies.iter().map(|body| body.mass.formula()).collect::<Result<Vec<String>, _>>()?;
    let mut values = Vec::new();
    for (body, text) in bodies.iter().zip(&texts) {
        let value: f64 = value_of(text, parameters).map_err(|error| body.mass.error(format!("{error}")))?;
        if value < 0.0 {
            return Err(body.mass.error(format!("a mass must not be negative, got {value}")));
        }
        values.push(value);
    }
    let largest = (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).filter(|&a| values[a] > 0.0);
    let Some(largest) = largest else {
        return Err(field.error("at least one body must have a mass"));
    };
    let massless = format!("{MASSLESS}*({})", texts[largest]);
    Ok(texts
        .iter()
        .zip(values)
        .map(|(text, value)| if value == 0.0 { massless.clone() } else { text.clone() })
        .collect())
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
            let help = "give every body a mass, or a formula that both masses are factors of".to_owned();
            return Err(formula.error("a body without mass needs an energy that is 0 for m_1 = 0").with_help(help));
        }
    }
    let (mut terms, mut distances) = (Vec::new(), Vec::new());
    for (j, second) in bodies.iter().enumerate() {
        for (i, first) in bodies[..j].iter().enumerate().filter(|(i, _)| !(is_massless[*i] && is_massless[j])) {
            let [one, two] = [first.name.string()?, second.name.string()?];
            let squares: Vec<String> =
                ["x", "y", "z"].iter().take(dimension).map(|axis| format!("({axis}_{one} - {axis}_{two})^2")).collect();
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
