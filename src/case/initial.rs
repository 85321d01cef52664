//! `[initial]`: which positions, velocities and momenta are given.

use std::path::PathBuf;

use serde::Deserialize;

use super::CaseError;
use super::files::{MOST_OF_SUMMARY, read_text};
use super::keys;
use super::reader::Field;
use super::scenery::{Scenery, known};
use super::start_data::{Given, Rate, Sign, StartData};
use crate::formula::similar::nearest;
use crate::geometry::{Geometry, GeometryError, Law, value_of};
use crate::solve::Continuation;

const FROM: &str =
    "initial.from is the folder of an earlier run, or the summary.json there; it stands alone in [initial]";

/// The key of dq/dt.
const VELOCITY: &str = "velocity";

/// The initial data with their places in the text.
pub(super) struct Initial<'t> {
    pub(super) data: StartData,
    given: Vec<Given<'t>>,
    pub(super) section: Field<'t>,
    /// The end of the run that this one continues, if it continues one, and the summary that has it.
    pub(super) from: Option<(Continuation, PathBuf)>,
}

/// Reads `[initial]`.
pub(super) fn read<'t>(
    section: Field<'t>,
    scenery: &Scenery<'t>,
    geometry: &Geometry,
) -> Result<Initial<'t>, CaseError> {
    let names = geometry.names();
    // A potential has a time that begins at 0.
    let (has_time, is_lifted) = (scenery.text.potential.is_some(), scenery.text.law() == Some(Law::Newtonian));
    let mut from = None;
    let given: Vec<Given<'t>> = if let Some(field) = section.get("from") {
        section.finish(&["from"]).map_err(|error| error.with_help(FROM))?;
        let (end, path, given) = continued(&field, geometry).map_err(|message| field.error(message).with_help(FROM))?;
        from = Some((end, path));
        given
    } else if scenery.start.is_empty() {
        section.finish(&keys::named_in("initial", &own_keys(names)))?;
        check_positions(&section, geometry, has_time)?;
        let mut given = names.iter().map(|name| self::given(&section, name)).collect::<Result<Vec<_>, _>>()?;
        add_velocity(&section, names, is_lifted, &mut given)?;
        given
    } else {
        section
            .finish(&["from", "t"])
            .map_err(|error| error.with_help("position and velocity are those of [[body]]"))?;
        let time = Given { position: position(&section, "t")?, rate: None };
        [&[time], scenery.start.as_slice(), &[Given::default()]].concat()
    };
    let mut rates: Vec<_> = given.iter().map(|given| given.rate.as_ref().map(|(rate, _)| rate.clone())).collect();
    let mut norm = from_norm(&section, names, &mut rates)?;
    if is_lifted {
        add_lift(&mut rates, &mut norm, section.get("norm").as_ref())?;
    }
    let found = |(rate, name): (Option<Rate>, &String)| rate.ok_or_else(|| missing(&section, name, &norm, is_lifted));
    let rates = rates.into_iter().zip(names).map(found).collect::<Result<_, _>>()?;
    let position = |given: &Given<'_>| given.position.as_ref().map_or("0".to_owned(), |(text, _)| text.clone());
    let data = StartData { q: given.iter().map(position).collect(), rates, norm };
    Ok(Initial { data, given, section, from })
}

/// The end of an earlier run, from its folder or its summary, with the path of the latter, and what it gives.
fn continued<'t>(field: &Field<'t>, geometry: &Geometry) -> Result<(Continuation, PathBuf, Vec<Given<'t>>), String> {
    let mut path = PathBuf::from(field.as_str().unwrap_or_default());
    if path.is_dir() {
        path.push("summary.json");
    }
    let text = read_text(&path, MOST_OF_SUMMARY);
    let text = text.map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    let end = serde_json::from_str(&text).map(|Ended { end_state }| end_state);
    let end = end.map_err(|error| format!("{} has no end_state: {error}", path.display()))?;
    let given = |(a, name): (usize, &String)| {
        let missing = || format!("{} ends without a coordinate '{name}'", path.display());
        let [q, p] = end.formulas(a, geometry).filter(|_| end.has(name)).ok_or_else(missing)?;
        Ok(Given { position: Some((q, field.clone())), rate: Some((Rate::Momentum(p), field.clone())) })
    };
    let given = geometry.names().iter().enumerate().map(given).collect::<Result<_, String>>()?;
    Ok((end, path, given))
}

/// The keys of positions and rates.
pub(super) fn own_keys(coordinates: &[String]) -> Vec<String> {
    let velocities = coordinates.iter().map(|name| format!("{name}_dot"));
    let momenta = coordinates.iter().map(|name| format!("p_{name}"));
    coordinates.iter().cloned().chain(velocities).chain(momenta).collect()
}

/// These keys of a summary are read.
#[derive(Deserialize)]
struct Ended {
    end_state: Continuation,
}

fn position<'t>(section: &Field<'t>, name: &str) -> Result<Option<(String, Field<'t>)>, CaseError> {
    section.read(name, |field| Ok((field.number_of_start()?, field.clone())))
}

/// The position and the rate of a coordinate as they are given.
fn given<'t>(section: &Field<'t>, name: &str) -> Result<Given<'t>, CaseError> {
    let velocity =
        section.read(&format!("{name}_dot"), |field| Ok((Rate::Velocity(field.number_of_start()?), field.clone())))?;
    let momentum =
        section.read(&format!("p_{name}"), |field| Ok((Rate::Momentum(field.number_of_start()?), field.clone())))?;
    if let (Some((_, velocity)), Some((_, momentum))) = (&velocity, &momentum) {
        let message = format!("both {} and {} are given", velocity.key, momentum.key);
        let help = format!("they determine each other: keep one of {} and {}", velocity.key, momentum.key);
        return Err(momentum.key_error(message).with_help(help));
    }
    Ok(Given { position: position(section, name)?, rate: velocity.or(momentum) })
}

/// The rate dq/dγ of the one coordinate besides t, and s of Newton's law, where dq/dt is given.
fn add_velocity<'t>(
    section: &Field<'t>,
    names: &[String],
    is_lifted: bool,
    given: &mut [Given<'t>],
) -> Result<(), CaseError> {
    let Some(field) = section.get(VELOCITY).filter(|_| !names.iter().any(|name| name == VELOCITY)) else {
        return Ok(());
    };
    let last = names.len() - 1;
    let others: Vec<usize> = (0..=last).filter(|&a| names[a] != "t" && !(is_lifted && a == last)).collect();
    let &[q] = others.as_slice() else {
        let others = others.iter().map(|&a| names[a].as_str()).collect::<Vec<_>>();
        let message = format!("velocity is that of one coordinate, and there are {}", others.join(", "));
        let help =
            format!("give {}_dot, the rates by gamma, or momenta p_{}", others.join("_dot, "), others.join(", p_"));
        return Err(field.key_error(message).with_help(help));
    };
    let name = &names[q];
    if given[q].rate.is_some() {
        let help = format!("keep one of {name}_dot (d{name}/dgamma), p_{name} and velocity (d{name}/dt)");
        return Err(field.key_error(format!("velocity and another rate of {name} are given")).with_help(help));
    }
    // By Newton's law dt/dγ is 1 unless something else is given.
    let t_dot = section.read("t_dot", Field::number_of_start)?;
    let t_dot = t_dot.or_else(|| (is_lifted && section.get("p_t").is_none()).then(|| "1".to_owned()));
    let t_dot = t_dot.ok_or_else(|| {
        let help = format!("give {name}_dot or p_{name} in its place");
        field.key_error("velocity needs t_dot").with_help(help)
    })?;
    given[q].rate = Some((Rate::Velocity(format!("({})*({t_dot})", field.number_of_start()?)), field));
    Ok(())
}

/// Refuses initial data without the position of a coordinate that something depends on, but for the time.
fn check_positions(section: &Field<'_>, geometry: &Geometry, has_time: bool) -> Result<(), CaseError> {
    if !section.is_table() {
        let help = "[initial] needs every coordinate that the metric depends on, and for each coordinate q one of \
                    q_dot (dq/dgamma) and p_q (its momentum)";
        return Err(section.error("missing field `initial`").with_help(help));
    }
    // A force may act on a coordinate that nothing depends on, as on t of a damped motion.
    let names = geometry.names().iter().enumerate().skip(usize::from(has_time));
    let needed = names.filter(|&(a, name)| geometry.depends_on(a) && section.get(name).is_none());
    let missing: Vec<&str> = needed.map(|(_, name)| name.as_str()).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let (field, them) = if missing.len() == 1 { ("field", "it") } else { ("fields", "them") };
    let help = format!("the scene depends on {them}; only a coordinate that nothing depends on may be left out");
    Err(section.error(format!("missing {field} `{}`", missing.join("`, `"))).with_help(help))
}

/// The norm, if a rate follows from it, which is then marked.
fn from_norm(section: &Field<'_>, names: &[String], rates: &mut [Option<Rate>]) -> Result<Option<String>, CaseError> {
    let (norm, solve) = match (section.get("norm"), section.get("solve")) {
        (None, None) => return Ok(None),
        (Some(norm), Some(solve)) => (norm, solve),
        (Some(norm), None) => {
            let help = "add solve = { r_dot = \"+\" } with the velocity or the momentum that is to be found, or leave \
                        out norm";
            return Err(norm.key_error("norm is given, and nothing to solve for").with_help(help));
        }
        (None, Some(solve)) => {
            let help = "add norm = \"timelike\" (1), \"null\" (0) or a number: the K that the start must have";
            return Err(solve.key_error("solve is given without norm").with_help(help));
        }
    };
    let (a, rate) = unknown(&solve, names)?;
    if rates[a].is_some() {
        let keys = [format!("{}_dot", names[a]), format!("p_{}", names[a]), "velocity".to_owned()];
        let given = keys.iter().find_map(|key| section.get(key)).map_or(String::new(), |field| field.path);
        let message = format!("'{given}' is given, so there is nothing to solve for");
        return Err(solve.error(message).with_help("leave out one of the two"));
    }
    rates[a] = Some(rate);
    norm_value(&norm).map(Some)
}

/// The rate that `solve` names.
fn unknown(solve: &Field<'_>, names: &[String]) -> Result<(usize, Rate), CaseError> {
    let fields = solve.fields();
    let [field] = fields.as_slice() else {
        let message =
            format!("'{}' must name exactly one velocity or momentum, and names {}", solve.path, fields.len());
        return Err(solve.error(message).with_help("for example solve = { r_dot = \"+\" }"));
    };
    let sign = match field.string()? {
        "+" => Some(Sign::Plus),
        "-" => Some(Sign::Minus),
        other => return Err(field.error(format!("the sign of a root is \"+\" or \"-\", got \"{other}\""))),
    };
    let known: Vec<String> = names.iter().flat_map(|name| [format!("{name}_dot"), format!("p_{name}")]).collect();
    if let Some(place) = known.iter().position(|known| *known == field.key) {
        return Ok((place / 2, [Rate::VelocityFromNorm, Rate::MomentumFromNorm][place % 2](sign)));
    }
    let meant = nearest(&field.key, known.iter().map(String::as_str)).map(|meant| format!("did you mean `{meant}`?"));
    let message = format!("unknown velocity or momentum `{}`, expected one of {}", field.key, known.join(", "));
    Err(field.key_error(message).with_hint(meant))
}

/// The K that `norm` asks for.
pub(super) fn norm_value(field: &Field<'_>) -> Result<String, CaseError> {
    match field.as_str() {
        Some("timelike") => Ok("1".to_owned()),
        Some("null") => Ok("0".to_owned()),
        _ => field.formula(),
    }
}

/// Sets the rates that follow from Newton's law: that of t is 1, and that of s makes K zero.
pub(super) fn add_lift(
    rates: &mut [Option<Rate>],
    norm: &mut Option<String>,
    field: Option<&Field<'_>>,
) -> Result<(), CaseError> {
    let (last, zero, one) = (rates.len() - 1, || "0".to_owned(), || "1".to_owned());
    let given = norm.as_ref().zip(field).filter(|(value, _)| value_of(value, &[]) != Ok(0.0));
    if let Some((value, field)) = given {
        let message = format!("a newtonian case has norm = 0, got {value}");
        return Err(field.error(message).with_help("the lift of Newton's law is made of null geodesics"));
    }
    let is_free = norm.is_none();
    match (&rates[0], &rates[last]) {
        (None, Some(Rate::Momentum(_))) if is_free => {
            rates[0] = Some(Rate::MomentumFromNorm(None));
            *norm = Some(zero());
        }
        (Some(Rate::Momentum(_)), None) => rates[last] = Some(Rate::Momentum(one())),
        (time, None) if is_free => {
            rates[0] = Some(time.clone().unwrap_or(Rate::Velocity(one())));
            rates[last] = Some(Rate::VelocityFromNorm(None));
            *norm = Some(zero());
        }
        (None, _) => rates[0] = Some(Rate::Velocity(one())),
        _ => {}
    }
    Ok(())
}

fn missing(section: &Field<'_>, name: &str, norm: &Option<String>, is_lifted: bool) -> CaseError {
    let help = if is_lifted && name == "s" {
        "where norm determines another coordinate, give the energy as p_t, or s_dot".to_owned()
    } else {
        let or = if norm.is_some() { "" } else { &format!(", or norm with solve = {{ {name}_dot = \"+\" }}") };
        format!("give exactly one of {name}_dot (d{name}/dgamma) and p_{name} (its momentum){or}")
    };
    section.error(format!("neither {name}_dot nor p_{name} is given")).with_help(help)
}

impl Initial<'_> {
    /// Refuses what is not a finite number.
    pub(super) fn check_numbers(&self, parameters: &[(String, String)]) -> Result<(), CaseError> {
        let positions = self.given.iter().filter_map(|given| given.position.as_ref());
        positions.clone().try_for_each(|(number, field)| check_number(number, field, parameters))?;
        for (rate, field) in self.given.iter().filter_map(|given| given.rate.as_ref()) {
            if let Rate::Velocity(number) | Rate::Momentum(number) = rate {
                check_number(number, field, parameters)?;
            }
        }
        let norm = self.data.norm.as_ref().zip(self.section.get("norm"));
        norm.map_or(Ok(()), |(number, field)| check_number(number, &field, parameters))
    }

    /// A mistake in the position, of which only the `active` coordinates matter.
    pub(super) fn error_in_position(&self, active: &[usize], message: String) -> CaseError {
        let mut given = active.iter().filter_map(|&a| self.given.get(a)?.position.as_ref());
        let single = given.next().filter(|_| given.next().is_none());
        single.map_or(&self.section, |(_, field)| field).error(message)
    }
}

/// Refuses what is not a finite number in the parameters.
pub(super) fn check_number(number: &str, field: &Field<'_>, parameters: &[(String, String)]) -> Result<(), CaseError> {
    value_of::<f64>(number, parameters).map(drop).map_err(|error| match error {
        GeometryError::Formula(_, formula) => {
            field.formula_error(&formula, known(parameters.iter().map(|(name, _)| name.clone()).collect()))
        }
        _ => field.error(format!("'{}' is not a finite number", field.path)),
    })
}
