//! `[initial]`: which positions, velocities and momenta are given.

use std::fs;
use std::path::PathBuf;

use serde::Deserialize;

use super::CaseError;
use super::bodies;
use super::reader::{Field, Section};
use super::scenery::{Scenery, known};
use crate::formula::similar::nearest;
use crate::geometry::{Geometry, GeometryError, GeometryText, Law, value_of};
use crate::solve::Continuation;

/// Which of two roots is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// The larger root.
    Plus,
    /// The smaller root.
    Minus,
}

/// The velocity or the momentum that is given along a coordinate: a decimal with all its digits, or a formula in the
/// parameters of the scene, such as `sqrt(19)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Rate {
    /// dq/dγ.
    Velocity(String),
    /// The momentum.
    Momentum(String),
    /// dq/dγ follows from K; without a sign the equation for it is linear.
    VelocityFromNorm(Option<Sign>),
    /// The momentum follows from K; without a sign the equation for it is linear.
    MomentumFromNorm(Option<Sign>),
}

impl Rate {
    /// Returns true if it is about the momentum.
    pub(super) fn is_momentum(&self) -> bool {
        matches!(self, Self::Momentum(_) | Self::MomentumFromNorm(_))
    }
}

/// The initial data as the case gives them, without the coordinate tau that `conformal` may add.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StartData {
    /// The position of every coordinate.
    pub q: Vec<String>,
    /// The rate of every coordinate. At most one follows from the norm.
    pub rates: Vec<Rate>,
    /// K, if a rate follows from it.
    pub norm: Option<String>,
}

/// The initial data with their places in the text.
pub(super) struct Initial<'t> {
    pub(super) data: StartData,
    /// Where the position and the rate of every coordinate stand.
    pub(super) q: Vec<Option<Field<'t>>>,
    pub(super) rates: Vec<Option<Field<'t>>>,
    pub(super) norm: Option<Field<'t>>,
    pub(super) solve: Option<Field<'t>>,
    pub(super) section: Section<'t>,
    /// The end of the run that this one continues, if it continues one.
    pub(super) from: Option<Continuation>,
}

/// Reads `[initial]`.
pub(super) fn read<'t>(
    mut section: Section<'t>,
    scenery: &Scenery<'t>,
    geometry: &Geometry,
) -> Result<Initial<'t>, CaseError> {
    let names = geometry.names();
    if let Some(field) = section.take("from") {
        return continued(&field, section, names);
    }
    if !scenery.start.is_empty() {
        return bodies::start(section, &scenery.start);
    }
    let q: Vec<Option<Field<'t>>> = names.iter().map(|name| section.take(name)).collect();
    let rates_of = |name: &String| [format!("{name}_dot"), format!("p_{name}")].map(|key| section.take(&key));
    let given: Vec<[Option<Field<'t>>; 2]> = names.iter().map(rates_of).collect();
    let (norm, solve) = (section.take("norm"), section.take("solve"));
    let velocity = if scenery.is_of_x { section.take("velocity") } else { None };
    section.finish().map_err(|error| explain_velocity(error, names))?;
    // A potential has a time that begins at 0.
    let (has_time, is_lifted) = match &scenery.text {
        GeometryText::Metric(_) => (false, false),
        GeometryText::Potential(potential) => (true, potential.law == Law::Newtonian),
    };
    let positions = positions(&section, &q, geometry, has_time)?;
    let (mut rates, mut fields): (Vec<_>, Vec<_>) = given.into_iter().map(given_rate).collect::<Result<_, _>>()?;
    if let Some(velocity) = velocity {
        rates[1] = Some(rate_of_velocity(&velocity, &fields)?);
        fields[1] = Some(velocity);
    }
    let mut value = from_norm(norm.as_ref(), solve.as_ref(), names, &fields, &mut rates)?;
    if is_lifted {
        add_lift(&mut rates, &mut value, norm.as_ref())?;
    }
    let found = |(rate, name): (Option<Rate>, &String)| rate.ok_or_else(|| missing(&section, name, &value, is_lifted));
    let rates = rates.into_iter().zip(names).map(found).collect::<Result<_, _>>()?;
    let data = StartData { q: positions, rates, norm: value };
    Ok(Initial { data, q, rates: fields, norm, solve, section, from: None })
}

/// The end of an earlier run, from its folder or its summary.
fn continued<'t>(field: &Field<'t>, section: Section<'t>, names: &[String]) -> Result<Initial<'t>, CaseError> {
    const HELP: &str =
        "initial.from is the folder of an earlier run, or the summary.json there; it stands alone in [initial]";
    let mistake = |message: String| field.error(message).with_help(HELP);
    section.finish().map_err(|error| error.with_help(HELP))?;
    let mut path = PathBuf::from(field.string()?);
    if path.is_dir() {
        path.push("summary.json");
    }
    let text =
        fs::read_to_string(&path).map_err(|error| mistake(format!("cannot read {}: {error}", path.display())))?;
    let end = serde_json::from_str(&text).map(|Ended { end_state }| end_state);
    let end = end.map_err(|error| mistake(format!("{} has no end_state: {error}", path.display())))?;
    let mut data = StartData { q: Vec::new(), rates: Vec::new(), norm: None };
    for name in names {
        let missing = || mistake(format!("{} ends without a coordinate '{name}'", path.display()));
        let [q, p] = end.formulas(name).filter(|_| end.has(name)).ok_or_else(missing)?;
        data.q.push(q);
        data.rates.push(Rate::Momentum(p));
    }
    let fields = || vec![Some(field.clone()); names.len()];
    Ok(Initial { q: fields(), rates: fields(), norm: None, solve: None, section, from: Some(end), data })
}

/// The keys of positions and rates.
pub(super) fn keys(coordinates: &[String], is_of_x: bool) -> Vec<String> {
    let velocities = coordinates.iter().map(|name| format!("{name}_dot"));
    let momenta = coordinates.iter().map(|name| format!("p_{name}"));
    let velocity = is_of_x.then(|| "velocity".to_owned());
    coordinates.iter().cloned().chain(velocities).chain(momenta).chain(velocity).collect()
}

/// These keys of a summary are read.
#[derive(Deserialize)]
struct Ended {
    end_state: Continuation,
}

/// The velocity or the momentum that is given, and where it stands.
fn given_rate(pair: [Option<Field<'_>>; 2]) -> Result<(Option<Rate>, Option<Field<'_>>), CaseError> {
    match pair {
        [Some(velocity), Some(momentum)] => {
            let message = format!("both {} and {} are given", velocity.key, momentum.key);
            let help = format!("they determine each other: keep one of {} and {}", velocity.key, momentum.key);
            Err(momentum.key_error(message).with_help(help))
        }
        [Some(field), None] => Ok((Some(Rate::Velocity(field.formula()?)), Some(field))),
        [None, Some(field)] => Ok((Some(Rate::Momentum(field.formula()?)), Some(field))),
        [None, None] => Ok((None, None)),
    }
}

/// dx/dγ, where dx/dt is given.
fn rate_of_velocity(velocity: &Field<'_>, fields: &[Option<Field<'_>>]) -> Result<Rate, CaseError> {
    if let Some(other) = &fields[1] {
        let help = "keep exactly one of initial.x_dot (dx/dgamma) and initial.velocity (dx/dt)";
        return Err(velocity.key_error(format!("both {} and velocity are given", other.key)).with_help(help));
    }
    let t_dot = fields[0].as_ref().filter(|t_dot| t_dot.key == "t_dot");
    let t_dot =
        t_dot.ok_or_else(|| velocity.key_error("velocity needs t_dot").with_help("give x_dot or p_x in its place"))?;
    Ok(Rate::Velocity(format!("({})*({})", velocity.formula()?, t_dot.formula()?)))
}

/// The norm, if a rate follows from it, which is then marked.
fn from_norm(
    norm: Option<&Field<'_>>,
    solve: Option<&Field<'_>>,
    names: &[String],
    given: &[Option<Field<'_>>],
    rates: &mut [Option<Rate>],
) -> Result<Option<String>, CaseError> {
    let (norm, solve) = match (norm, solve) {
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
    let (a, rate) = unknown(solve, names)?;
    if let Some(given) = &given[a] {
        let message = format!("'{}' is given, so there is nothing to solve for", given.path);
        return Err(solve.error(message).with_help("leave out one of the two"));
    }
    rates[a] = Some(rate);
    norm_value(norm).map(Some)
}

/// The position of every coordinate; that of one that nothing depends on, and of the time, is 0 if it is left out.
fn positions(
    section: &Section<'_>,
    fields: &[Option<Field<'_>>],
    geometry: &Geometry,
    has_time: bool,
) -> Result<Vec<String>, CaseError> {
    if !section.is_given() {
        let help = "[initial] needs every coordinate that the metric depends on, and for each coordinate q one of \
                    q_dot (dq/dgamma) and p_q (its momentum)";
        return Err(section.error("missing field `initial`").with_help(help));
    }
    // A force may act on a coordinate that nothing depends on, as on t of a damped motion.
    let needed = (usize::from(has_time)..fields.len()).filter(|&a| geometry.depends_on(a));
    let missing: Vec<&str> = needed.filter(|&a| fields[a].is_none()).map(|a| geometry.names()[a].as_str()).collect();
    if !missing.is_empty() {
        let list = missing.join("`, `");
        let (field, them) = if missing.len() == 1 { ("field", "it") } else { ("fields", "them") };
        let help = format!("the scene depends on {them}; only a coordinate that nothing depends on may be left out");
        return Err(section.error(format!("missing {field} `{list}`")).with_help(help));
    }
    fields.iter().map(|field| field.as_ref().map_or(Ok("0".to_owned()), Field::formula)).collect()
}

/// The rate that `solve` names.
fn unknown(solve: &Field<'_>, names: &[String]) -> Result<(usize, Rate), CaseError> {
    let fields = solve.section()?.fields();
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
    match field.item.as_str() {
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

fn missing(section: &Section<'_>, name: &str, norm: &Option<String>, is_lifted: bool) -> CaseError {
    let help = if is_lifted && name == "s" {
        "where norm determines another coordinate, give the energy as p_t, or s_dot".to_owned()
    } else {
        let or = if norm.is_some() { "" } else { &format!(", or norm with solve = {{ {name}_dot = \"+\" }}") };
        format!("give exactly one of {name}_dot (d{name}/dgamma) and p_{name} (its momentum){or}")
    };
    section.error(format!("neither {name}_dot nor p_{name} is given")).with_help(help)
}

/// Says what a case takes in place of the velocity of one in x alone.
pub(super) fn explain_velocity(error: CaseError, names: &[String]) -> CaseError {
    if !error.message.starts_with("unknown field `velocity`") {
        return error;
    }
    let name = names.get(1).unwrap_or(&names[0]);
    error.with_help(format!("this case takes {name}_dot = d{name}/dgamma, and so on, or the momentum p_{name}"))
}

impl Initial<'_> {
    /// Refuses what is not a finite number.
    pub(super) fn check_numbers(&self, parameters: &[(String, String)]) -> Result<(), CaseError> {
        let positions = self.data.q.iter().zip(&self.q);
        let rates = self.data.rates.iter().zip(&self.rates).filter_map(|(rate, field)| match rate {
            Rate::Velocity(number) | Rate::Momentum(number) => Some((number, field)),
            _ => None,
        });
        let norm = self.data.norm.iter().zip([&self.norm]);
        let mut all = positions.chain(rates).chain(norm);
        all.try_for_each(|(number, field)| check_number(number, field.as_ref(), parameters))
    }

    /// A mistake in the position, of which only the `active` coordinates matter.
    pub(super) fn error_in_position(&self, active: &[usize], message: String) -> CaseError {
        let mut given = active.iter().filter_map(|&a| self.q[a].as_ref());
        self.error_at(given.next().filter(|_| given.next().is_none()), message)
    }

    /// A mistake in the rate of a coordinate.
    pub(super) fn error_in_rate(&self, a: usize, message: String) -> CaseError {
        self.error_at(self.rates[a].as_ref().or(self.solve.as_ref()), message)
    }

    /// A mistake in `solve` and `norm`.
    pub(super) fn error_in_norm(&self, message: String) -> CaseError {
        self.error_at(self.solve.as_ref(), message)
    }

    fn error_at(&self, field: Option<&Field<'_>>, message: String) -> CaseError {
        field.map_or_else(|| self.section.error(message.clone()), |field| field.error(message.clone()))
    }
}

/// Refuses what is not a finite number in the parameters.
pub(super) fn check_number(
    number: &str,
    field: Option<&Field<'_>>,
    parameters: &[(String, String)],
) -> Result<(), CaseError> {
    let Some(field) = field else { return Ok(()) };
    value_of::<f64>(number, parameters).map(drop).map_err(|error| match error {
        GeometryError::Formula(_, formula) => {
            field.formula_error(&formula, known(parameters.iter().map(|(name, _)| name.clone()).collect()))
        }
        _ => field.error(format!("'{}' is not a finite number", field.path)),
    })
}
