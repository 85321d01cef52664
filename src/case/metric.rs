//! `[metric]`.

use super::CaseError;
use super::names::{self, NameTable};
use super::reader::Field;
use super::scenery::{DEFINITION, Places, Scenery};
use super::source::is_used;
use crate::formula::similar::nearest;
use crate::geometry::{GeometryText, PRESETS, Place, Preset};

/// Reads `[metric]`, which is `section`.
pub(super) fn read<'t>(root: &Field<'t>, section: Field<'t>) -> Result<Scenery<'t>, CaseError> {
    let [coordinates, components] = ["coordinates", "components"].map(|key| section.get(key));
    let mut places = Places::default();
    let preset = section.read("preset", preset)?;
    let mut text = match preset {
        Some(preset) => preset.text(),
        None => metric(&section, [&coordinates, &components], &mut places)?,
    };
    let mut taken = NameTable::new(&text.coordinates);
    places.keep_parameters(root, &mut taken, &mut text.parameters)?;
    places.keep_named(&section.table("definitions"), DEFINITION, &mut taken, &mut text.definitions)?;
    text.one_form = places.keep_by_coordinate(&section.table("one_form"), &text.coordinates, Place::OneForm)?;
    text.force = places.keep_by_coordinate(&section.table("force"), &text.coordinates, Place::Force)?;
    text.conformal = section.get("conformal").map(|field| places.keep(Place::Conformal, field)).transpose()?;
    if let Some(preset) = preset {
        check_own(preset, &places)?;
    }
    let whole = components.or(section.get("preset")).or(coordinates).unwrap_or_else(|| section.clone());
    Ok(Scenery { preset, ..Scenery::new(text, places, section, whole) })
}

/// The preset that a field names.
fn preset(field: &Field<'_>) -> Result<&'static Preset, CaseError> {
    let known = PRESETS.each_ref().map(|preset| (preset.name, preset));
    field.one_of("preset", &format!("one of {}", known.map(|(name, _)| name).join(", ")), &known)
}

/// Refuses a parameter or a definition that is a definition or a parameter of the preset, and one that the preset does
/// not know and that no formula uses.
fn check_own(preset: &Preset, places: &Places<'_>) -> Result<(), CaseError> {
    let GeometryText { parameters, definitions, .. } = preset.text();
    for (place, field) in &places.0 {
        let (kind, known, others) = match place {
            Place::Parameter(_) => ("parameter", &parameters, &definitions),
            Place::Definition(_) => ("definition", &definitions, &parameters),
            _ => continue,
        };
        let (name, preset) = (&field.key, preset.name);
        let has = |formulas: &[(String, String)]| formulas.iter().any(|(other, _)| other == name);
        if has(others) {
            let message = format!("'{name}' is no {kind} of the preset \"{preset}\", but has another meaning");
            return Err(field.key_error(message));
        }
        if !has(known) && !is_used(&field.source.text, name) {
            let known: Vec<&str> = known.iter().map(|(name, _)| name.as_str()).collect();
            let list =
                if known.is_empty() { format!("it has no {kind}") } else { format!("it has {}", known.join(", ")) };
            let help = nearest(name, known).map_or(list, |meant| format!("did you mean '{meant}'?"));
            let message = format!("the preset \"{preset}\" has no {kind} '{name}', and no formula of the case uses it");
            return Err(field.key_error(message).with_help(help));
        }
    }
    Ok(())
}

/// Coordinates and components.
fn metric<'t>(
    section: &Field<'t>,
    [coordinates, components]: [&Option<Field<'t>>; 2],
    places: &mut Places<'t>,
) -> Result<GeometryText, CaseError> {
    let (Some(coordinates), Some(components)) = (coordinates, components) else {
        let missing = if coordinates.is_none() { "coordinates" } else { "components" };
        let both = if coordinates.is_none() && components.is_none() { " (or `preset`)" } else { "" };
        let help = "[metric] needs coordinates = [\"t\", …] and components = { \"t t\" = \"…\", … }, or a preset";
        return Err(section.error(format!("missing field `{missing}`{both}")).with_help(help));
    };
    let coordinates = names::coordinates(coordinates, &[])?;
    let mut text = GeometryText { coordinates, ..GeometryText::default() };
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
