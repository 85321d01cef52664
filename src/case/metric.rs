//! `[metric]`.

use super::CaseError;
use super::names::{self, Taken};
use super::reader::{Field, Section};
use super::scenery::Scenery;
use crate::formula::similar::nearest;
use crate::geometry::{GeometryText, MetricText, PRESETS, Place, Preset};

/// The values of `[metric]`.
struct Fields<'t> {
    coordinates: Option<Field<'t>>,
    components: Option<Field<'t>>,
    definitions: Section<'t>,
    parameters: Section<'t>,
    one_form: Section<'t>,
    force: Section<'t>,
    conformal: Option<Field<'t>>,
    preset: Option<Field<'t>>,
}

/// Reads `[metric]`.
pub(super) fn read(mut section: Section<'_>) -> Result<Scenery<'_>, CaseError> {
    let fields = Fields {
        coordinates: section.take("coordinates"),
        components: section.take("components"),
        definitions: section.section("definitions")?,
        parameters: section.section("parameters")?,
        one_form: section.section("one_form")?,
        force: section.section("force")?,
        conformal: section.take("conformal"),
        preset: section.take("preset"),
    };
    let mut places = Vec::new();
    let preset = fields.preset.as_ref().map(|field| preset(field, &fields)).transpose()?;
    let mut text = match preset {
        Some(preset) => preset.text(),
        None => metric(&section, &fields, &mut places)?,
    };
    let mut taken = Taken::new(&text.coordinates);
    for field in fields.parameters.fields() {
        taken.take(&field, "a parameter")?;
        set(&mut text.parameters, &field.key, field.formula()?);
        places.push((Place::Parameter(field.key.clone()), field));
    }
    for field in fields.definitions.fields() {
        taken.take(&field, "a definition")?;
        set(&mut text.definitions, &field.key, field.formula()?);
        places.push((Place::Definition(field.key.clone()), field));
    }
    text.one_form = by_coordinate(&fields.one_form, &text.coordinates, Place::OneForm, &mut places)?;
    text.force = by_coordinate(&fields.force, &text.coordinates, Place::Force, &mut places)?;
    if let Some(field) = fields.conformal {
        text.conformal = Some(field.formula()?);
        places.push((Place::Conformal, field));
    }
    if let Some(preset) = preset {
        check_of_preset(preset, &places)?;
    }
    let whole = fields.components.or(fields.preset).or(fields.coordinates);
    let text = GeometryText::Metric(text);
    let (bodies, start) = (Vec::new(), Vec::new());
    Ok(Scenery { text, preset, fields: places, section, whole, coefficients: None, is_of_x: false, bodies, start })
}

/// The formulas below the names of coordinates.
pub(super) fn by_coordinate<'t>(
    section: &Section<'t>,
    coordinates: &[String],
    place: impl Fn(usize) -> Place,
    places: &mut Vec<(Place, Field<'t>)>,
) -> Result<Vec<(usize, String)>, CaseError> {
    let mut formulas = Vec::new();
    for field in section.fields() {
        let a = names::index(&field, coordinates)?;
        formulas.push((a, field.formula()?));
        places.push((place(a), field));
    }
    formulas.sort_by_key(|(a, _)| *a);
    Ok(formulas)
}

/// Replaces the text of a name, or appends it.
fn set(texts: &mut Vec<(String, String)>, name: &str, text: String) {
    match texts.iter_mut().find(|(other, _)| other == name) {
        Some((_, old)) => *old = text,
        None => texts.push((name.to_owned(), text)),
    }
}

fn preset(field: &Field<'_>, fields: &Fields<'_>) -> Result<&'static Preset, CaseError> {
    let name = field.string()?;
    if let Some(other) = fields.coordinates.as_ref().or(fields.components.as_ref()) {
        let message = format!("'{}' and 'metric.preset' are both given", other.path);
        return Err(other.key_error(message).with_help("a preset has its own coordinates and components".to_owned()));
    }
    Preset::from_name(name).ok_or_else(|| {
        let known = PRESETS.map(|preset| preset.name);
        let meant = nearest(name, known).map(|meant| format!("did you mean \"{meant}\"?"));
        field.error(format!("unknown preset \"{name}\", expected one of {}", known.join(", "))).with_help(meant)
    })
}

/// Refuses a definition with the name of a parameter of the preset, and the other way round.
fn check_of_preset(preset: &Preset, places: &[(Place, Field<'_>)]) -> Result<(), CaseError> {
    let own = preset.text();
    for (place, field) in places {
        let (kind, others, name) = match place {
            Place::Parameter(name) => ("parameter", &own.definitions, name),
            Place::Definition(name) => ("definition", &own.parameters, name),
            _ => continue,
        };
        if others.iter().any(|(other, _)| other == name) {
            let message = format!("'{name}' is no {kind} of the preset \"{}\", but has another meaning", preset.name);
            return Err(field.key_error(message));
        }
    }
    Ok(())
}

/// Refuses a parameter or a definition that the preset does not know and that no formula uses.
pub(super) fn check_use(
    preset: &Preset,
    places: &[(Place, Field<'_>)],
    is_used: impl Fn(&str) -> bool,
) -> Result<(), CaseError> {
    let own = preset.text();
    for (place, field) in places {
        let (kind, known, name) = match place {
            Place::Parameter(name) => ("parameter", &own.parameters, name),
            Place::Definition(name) => ("definition", &own.definitions, name),
            _ => continue,
        };
        if known.iter().any(|(other, _)| other == name) || is_used(name) {
            continue;
        }
        let known: Vec<&str> = known.iter().map(|(name, _)| name.as_str()).collect();
        let meant = nearest(name, known.iter().copied()).map(|meant| format!("did you mean '{meant}'?"));
        let list = if known.is_empty() { format!("it has no {kind}") } else { format!("it has {}", known.join(", ")) };
        let message =
            format!("the preset \"{}\" has no {kind} '{name}', and no formula of the case uses it", preset.name);
        return Err(field.key_error(message).with_help(meant.unwrap_or(list)));
    }
    Ok(())
}

/// Coordinates and components.
fn metric<'t>(
    section: &Section<'t>,
    fields: &Fields<'t>,
    places: &mut Vec<(Place, Field<'t>)>,
) -> Result<MetricText, CaseError> {
    let (coordinates, components) = match (&fields.coordinates, &fields.components) {
        (Some(coordinates), Some(components)) => (coordinates, components),
        (coordinates, components) => {
            let missing = if coordinates.is_none() { "coordinates" } else { "components" };
            let both = if coordinates.is_none() && components.is_none() { " (or `preset`)" } else { "" };
            let help = "[metric] needs coordinates = [\"t\", …] and components = { \"t t\" = \"…\", … }, or a preset";
            return Err(section.error(format!("missing field `{missing}`{both}")).with_help(help.to_owned()));
        }
    };
    let coordinates = names::coordinates(coordinates, &[])?;
    let mut text = MetricText { coordinates, ..MetricText::default() };
    let mut seen: Vec<([usize; 2], Field<'t>)> = Vec::new();
    for field in components.section()?.fields() {
        let pair = pair(&field, &text.coordinates)?;
        let formula = field.formula()?;
        if let Some((_, earlier)) = seen.iter().find(|(other, _)| *other == pair) {
            let (line, column) = earlier.line_and_column();
            let message = format!(
                "the component \"{}\" is given twice: here, and as \"{}\" at line {line}, column {column}",
                field.key, earlier.key
            );
            return Err(field.key_error(message).with_help("one entry stands for both orders".to_owned()));
        }
        seen.push((pair, field.clone()));
        text.components.push((pair, formula));
        places.push((Place::Component(pair), field));
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
