//! `[metric]`.

use super::CaseError;
use super::names::{self, Taken};
use super::reader::Field;
use super::scenery::{DEFINITION, PARAMETER, Places, Scenery};
use crate::formula::similar::nearest;
use crate::geometry::{GeometryText, MetricText, PRESETS, Place, Preset};

/// Reads `[metric]`.
pub(super) fn read(section: Field<'_>) -> Result<Scenery<'_>, CaseError> {
    let [coordinates, components] = ["coordinates", "components"].map(|key| section.get(key));
    let mut places = Places::default();
    let preset = section.read("preset", preset)?;
    let mut text = match preset {
        Some(preset) => preset.text(),
        None => metric(&section, [&coordinates, &components], &mut places)?,
    };
    let mut taken = Taken::new(&text.coordinates);
    places.keep_named(&section.table("parameters"), PARAMETER, &mut taken, &mut text.parameters)?;
    places.keep_named(&section.table("definitions"), DEFINITION, &mut taken, &mut text.definitions)?;
    text.one_form = places.keep_by_coordinate(&section.table("one_form"), &text.coordinates, Place::OneForm)?;
    text.force = places.keep_by_coordinate(&section.table("force"), &text.coordinates, Place::Force)?;
    text.conformal = section.get("conformal").map(|field| places.keep(Place::Conformal, field)).transpose()?;
    if let Some(preset) = preset {
        check_of_preset(preset, &places)?;
    }
    let whole = components.or(section.get("preset")).or(coordinates).unwrap_or_else(|| section.clone());
    Ok(Scenery { preset, ..Scenery::new(GeometryText::Metric(text), places, section, whole) })
}

/// The preset that a field names.
fn preset(field: &Field<'_>) -> Result<&'static Preset, CaseError> {
    let known = PRESETS.each_ref().map(|preset| (preset.name, preset));
    field.one_of("preset", &format!("one of {}", known.map(|(name, _)| name).join(", ")), &known)
}

/// A parameter or definition of a case with a preset: its kind, those that the preset has of this kind and of the other
/// one, its name, and where it stands.
type Own<'p, 't> = (&'static str, [&'p [(String, String)]; 2], &'p str, &'p Field<'t>);

fn own<'p, 't>(
    places: &'p Places<'t>,
    MetricText { parameters, definitions, .. }: &'p MetricText,
) -> impl Iterator<Item = Own<'p, 't>> {
    places.0.iter().filter_map(move |(place, field)| match place {
        Place::Parameter(name) => Some(("parameter", [parameters.as_slice(), definitions], name.as_str(), field)),
        Place::Definition(name) => Some(("definition", [definitions.as_slice(), parameters], name.as_str(), field)),
        _ => None,
    })
}

/// Refuses a definition with the name of a parameter of the preset, and the other way round.
fn check_of_preset(preset: &Preset, places: &Places<'_>) -> Result<(), CaseError> {
    let text = preset.text();
    let mut own = own(places, &text);
    let Some((kind, _, name, field)) =
        own.find(|(_, [_, others], name, _)| others.iter().any(|(other, _)| other == name))
    else {
        return Ok(());
    };
    let message = format!("'{name}' is no {kind} of the preset \"{}\", but has another meaning", preset.name);
    Err(field.key_error(message))
}

/// Refuses a parameter or a definition that the preset does not know and that no formula uses.
pub(super) fn check_use(preset: &Preset, places: &Places<'_>, is_used: impl Fn(&str) -> bool) -> Result<(), CaseError> {
    let text = preset.text();
    let is_strange =
        |known: &[(String, String)], name: &str| known.iter().all(|(other, _)| other != name) && !is_used(name);
    let Some((kind, [known, _], name, field)) =
        own(places, &text).find(|(_, [known, _], name, _)| is_strange(known, name))
    else {
        return Ok(());
    };
    let known: Vec<&str> = known.iter().map(|(name, _)| name.as_str()).collect();
    let list = if known.is_empty() { format!("it has no {kind}") } else { format!("it has {}", known.join(", ")) };
    let help = nearest(name, known).map_or(list, |meant| format!("did you mean '{meant}'?"));
    let message = format!("the preset \"{}\" has no {kind} '{name}', and no formula of the case uses it", preset.name);
    Err(field.key_error(message).with_help(help))
}

/// Coordinates and components.
fn metric<'t>(
    section: &Field<'t>,
    [coordinates, components]: [&Option<Field<'t>>; 2],
    places: &mut Places<'t>,
) -> Result<MetricText, CaseError> {
    let (Some(coordinates), Some(components)) = (coordinates, components) else {
        let missing = if coordinates.is_none() { "coordinates" } else { "components" };
        let both = if coordinates.is_none() && components.is_none() { " (or `preset`)" } else { "" };
        let help = "[metric] needs coordinates = [\"t\", …] and components = { \"t t\" = \"…\", … }, or a preset";
        return Err(section.error(format!("missing field `{missing}`{both}")).with_help(help));
    };
    let coordinates = names::coordinates(coordinates, &[])?;
    let mut text = MetricText { coordinates, ..MetricText::default() };
    for field in components.fields() {
        let pair = pair(&field, &text.coordinates)?;
        if let Some(earlier) = places.of(&Place::Component(pair)) {
            let (line, column) = earlier.line_and_column();
            let message = format!(
                "the component \"{}\" is given twice: here, and as \"{}\" at line {line}, column {column}",
                field.key, earlier.key
            );
            return Err(field.key_error(message).with_help("one entry stands for both orders"));
        }
        text.components.push((pair, places.keep(Place::Component(pair), field)?));
    }
    text.components.sort_by_key(|(pair, _)| *pair);
    Ok(text)
}

/// The two coordinates that the key of a component names, in ascending order.
fn pair(field: &Field<'_>, coordinates: &[String]) -> Result<[usize; 2], CaseError> {
    let names: Vec<&str> = field.key.split_whitespace().collect();
    let [first, second] = names[..] else {
        let message = format!("the component \"{}\" must name two coordinates", field.key);
        let (a, b) = (&coordinates[0], &coordinates[coordinates.len() - 1]);
        return Err(field.key_error(message).with_help(format!("for example \"{a} {a}\" or \"{a} {b}\"")));
    };
    let (a, b) = (names::index_of(first, field, coordinates)?, names::index_of(second, field, coordinates)?);
    Ok([a.min(b), a.max(b)])
}
