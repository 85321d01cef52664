//! Checks of a case as a whole: one geometry, a start inside its domain, and a motion that its law allows.

use super::CaseError;
use super::compiled::Compiled;
use super::initial::Initial;
use super::keys::{EXCLUSIVE, Exclusion};
use super::reader::Field;
use super::scenery::{self, Scenery};
use super::start::{self, NoStart};
use super::{Case, bodies, metric, potential};
use crate::geometry::{Geometry, Jump, Law, Observable, OutsideGeometry, Place, Start, Tau, value_of};
use crate::number::{Extended, Real};
use crate::solve::Quantity;

/// Refuses keys that exclude each other.
pub(super) fn excluded(root: &Field<'_>) -> Result<(), CaseError> {
    let find = |path: &str| match path.split_once('.') {
        Some((table, key)) => root.get(table)?.get(key),
        None => root.get(path),
    };
    let both =
        |pair: &Exclusion| Some(find(pair.one).and(find(pair.other))?.key_error(pair.message).with_help(pair.help));
    EXCLUSIVE.iter().find_map(both).map_or(Ok(()), Err)
}

/// Reads the one of `[metric]`, `[potential]` and bodies that is given.
pub(super) fn geometry<'t>(root: &Field<'t>) -> Result<Scenery<'t>, CaseError> {
    let [metric, body, particle] = ["metric", "body", "particle"].map(|key| root.get(key));
    if let Some(particle) = particle.filter(|_| metric.is_some() || body.is_some()) {
        let (of, help) = match &body {
            Some(_) => ("bodies", "every body has a mass of its own"),
            None => ("a metric", "write the mass into the metric, or take a [potential]"),
        };
        let error = particle.error(format!("[particle] belongs to a potential, and the case has {of}"));
        return Err(error.with_help(help));
    }
    if let Some(pair) = root.get("pair").filter(|_| body.is_none()) {
        return Err(pair.error("[pair] needs bodies").with_help("give [[body]], one table for each"));
    }
    match (body, metric) {
        (Some(body), _) => bodies::read(root, &body),
        (None, Some(metric)) => metric::read(root, metric),
        (None, None) if root.get("potential").or(root.get("force")).is_none() => {
            let error = root.error("missing field `metric` or `potential`");
            Err(error.with_help("a case has exactly one of [metric] and [potential]"))
        }
        (None, None) => potential::read(root),
    }
}

/// A name for people.
pub(super) fn title(field: &Field<'_>) -> Result<String, CaseError> {
    let title = field.string()?;
    if title.contains(char::is_control) {
        return Err(field.error("the title must be one line without control characters"));
    }
    Ok(title.to_owned())
}

/// Refuses initial data that describe no start in `S`. Returns true if the two roots for the unknown rate are one, and
/// the coordinate that K ≠ 0 asks for.
pub(super) fn start<S: Real>(
    scenery: &Scenery<'_>,
    initial: &Initial<'_>,
    geometry: Geometry<S>,
    rounding: f64,
) -> Result<(bool, Option<Tau>), CaseError> {
    let parameters = &scenery.text.parameters;
    let q = initial.data.q.iter().map(|text| value_of(text, parameters)).collect::<Result<Vec<S>, _>>();
    let q = q.map_err(|_| initial.section.error("a coordinate is not a finite number in the digits asked for"))?;
    check_g00(scenery, initial, &geometry, &q)?;
    let geometry = around(geometry, initial, &q)?;
    scenery.check_factor(&q)?;
    let bare = scenery.bare()?;
    let of_data = bare.as_ref().unwrap_or(&geometry);
    check_masses(scenery, of_data, &q)?;
    let solved = start::solve(&initial.data, of_data, parameters, rounding, None);
    let (start, is_double) = solved.map_err(|none| no_start(none, initial))?;
    let tau = check_motion(scenery, initial, of_data, &start, rounding)?;
    geometry.point().evaluate(&start.q, &start.p).map_err(|error| outside(&error, &geometry, initial, &q))?;
    Ok((is_double, tau))
}

/// The start in the geometry of the case, and this geometry around it.
pub(super) fn placed(
    scenery: &Scenery<'_>,
    initial: &Initial<'_>,
    compiled: &Compiled,
    rounding: f64,
    is_double: bool,
) -> Result<(Start, Geometry), CaseError> {
    let geometry: Geometry = scenery.geometry(compiled)?;
    let start = scenery::start(&scenery.text, &geometry, &initial.data, rounding, Some(is_double));
    let start = start.map_err(|none| no_start(none, initial))?;
    if start.q_dot.iter().any(|u| !u.is_finite()) {
        return Err(no_start(NoStart::not_finite(), initial));
    }
    let geometry = around(geometry, initial, &start.q)?;
    Ok((start, geometry))
}

/// The geometry around a point, which has to lie inside its domain.
fn around<S: Real>(geometry: Geometry<S>, initial: &Initial<'_>, q: &[S]) -> Result<Geometry<S>, CaseError> {
    geometry.clone().with_domain_of(q).map_err(|error| outside(&error, &geometry, initial, q))
}

/// The words for a mistake in the position.
fn outside<S: Real>(outside: &OutsideGeometry, geometry: &Geometry<S>, initial: &Initial<'_>, q: &[S]) -> CaseError {
    let names = geometry.names();
    let at: Vec<String> = names.iter().zip(q).map(|(name, q)| format!("{name} = {}", q.to_f64())).collect();
    let at = at.join(", ");
    let Some(block) = outside.block else {
        if let Some(off) = geometry.off_table(q) {
            let help = "begin where it has a value, or give it outside = \"linear\"";
            return initial.error_in_position(geometry.active(), format!("{off} at the start")).with_help(help);
        }
        let message = format!("the metric, the force or a derivative is not finite at the start, {at}");
        return initial.error_in_position(geometry.active(), message);
    };
    let list = geometry.blocks[block].iter().map(|&a| names[a].as_str()).collect::<Vec<_>>().join(", ");
    let message = format!(
        "the metric is degenerate at the start: the determinant of the components of {list} is {} at {at}",
        outside.determinant
    );
    let error = initial.error_in_position(geometry.active(), message);
    error.with_help("choose another start, or coordinates that are regular there")
}

fn no_start(none: NoStart, initial: &Initial<'_>) -> CaseError {
    initial.section.at(&none.key).error(none.message).with_hint(none.help)
}

/// Refuses masses and c that are not positive.
pub(super) fn particle(scenery: &Scenery<'_>) -> Result<(), CaseError> {
    for (place, field) in &scenery.places.0 {
        if !matches!(place, Place::Mass(_) | Place::SpeedOfLight) {
            continue;
        }
        // A mass that depends on t is looked at with the start; a formula that is no number is refused elsewhere.
        let value = value_of::<f64>(&field.formula()?, &scenery.text.parameters);
        if let Some(value) = value.ok().filter(|value| *value <= 0.0) {
            return Err(field.error(format!("{} must be positive, got {value}", field.path)));
        }
    }
    Ok(())
}

/// Refuses masses that depend on t and are not positive at the start.
fn check_masses<S: Real>(scenery: &Scenery<'_>, geometry: &Geometry<S>, q: &[S]) -> Result<(), CaseError> {
    if scenery.text.potential.is_none() {
        return Ok(());
    }
    let diagonal = geometry.diagonal(q);
    let mut wrong = (0..scenery.text.coordinates.len()).filter(|a| diagonal[a + 1].to_f64() > 0.0);
    match wrong.find_map(|a| scenery.places.of(&Place::Mass(Some(a)))) {
        Some(field) => Err(field.error(format!("{} must be positive, and is not at the start", field.path))),
        None => Ok(()),
    }
}

/// Refuses a start where the paper's metric is none.
fn check_g00<S: Real>(
    scenery: &Scenery<'_>,
    initial: &Initial<'_>,
    geometry: &Geometry<S>,
    q: &[S],
) -> Result<(), CaseError> {
    if scenery.text.law() != Some(Law::Relativistic) {
        return Ok(());
    }
    let mut rest = vec![S::ZERO; geometry.dimension()];
    rest[0] = S::ONE;
    let g00 = geometry.norm(q, &rest).to_f64();
    if g00 > 0.0 && g00.is_finite() {
        return Ok(());
    }
    let message = format!("g00 = c^2 + 2V/m must be positive and finite at the start, got {g00}");
    let error = initial.error_in_position(geometry.active(), message);
    Err(error.with_help("choose another start, a weaker potential or a larger c"))
}

/// Refuses a world-line that is a point, and a K that the law does not allow. The coordinate that K asks for.
fn check_motion<S: Real>(
    scenery: &Scenery<'_>,
    initial: &Initial<'_>,
    geometry: &Geometry<S>,
    start: &Start<S>,
    rounding: f64,
) -> Result<Option<Tau>, CaseError> {
    if start.q_dot.iter().all(|u| *u == S::ZERO) && !geometry.has_force() {
        return Err(initial.section.error("all velocities are zero: the world-line would be a point"));
    }
    let k = geometry.norm(&start.q, &start.q_dot);
    if let Some((from, _)) = &initial.from {
        // K is what that run has made of it.
        return if from.has(Tau::NAME) { scenery.tau(k, geometry.has_force()) } else { Ok(None) };
    }
    let size = start::size_of_norm(geometry, start);
    if k.abs() <= start::rounding_of_norm::<S>(geometry.dimension(), rounding) * size {
        return Ok(None);
    }
    if scenery.text.law() == Some(Law::Newtonian) {
        let message = format!("a newtonian scene has K = 0, and these data give K = {}", k.to_f64());
        let help = "leave out s_dot and p_s (or p_t): they follow from the energy";
        return Err(initial.section.error(message).with_help(help));
    }
    scenery.tau(k, geometry.has_force())
}

/// Refuses formulas that in as many digits as are asked for depend on other coordinates than in 16, or have no value
/// where they have one in 16: guesses are made in 16 digits.
pub(super) fn digits(case: &Case, whole: &Field<'_>) -> Result<(), CaseError> {
    let digits = case.settings.digits;
    if digits <= 16 {
        return Ok(());
    }
    let exact = case.compiled.geometry::<Extended>().ok();
    let tau = case.geometry_text.tau.map(|_| Extended::ZERO);
    let q: Vec<Extended> = case.initial.q.iter().map(|q| case.value(q)).chain(tau).collect();
    let exact = exact.and_then(|geometry| geometry.with_domain_of(&q).ok());
    let rough: Geometry = case.geometry();
    let message = match exact {
        None => format!("in {digits} digits the formulas have no value at the start, where they have one in 16"),
        Some(exact) if exact.active() != rough.active() => {
            format!("in {digits} digits the formulas depend on other coordinates than in 16")
        }
        Some(_) => return Ok(()),
    };
    Err(whole.error(message).with_help("a number in them is 0 in 16 digits: write what it comes to"))
}

/// Refuses a metric or a potential that jumps, unless an event acts there.
pub(super) fn jumping(case: &Case, whole: &Field<'_>, q: &[f64]) -> Result<(), CaseError> {
    let scene = &case.geometry_text;
    let acting = case.events.iter().filter(|event| !event.set.is_empty());
    let mut acting: Vec<Observable> =
        acting.filter_map(|event| Observable::new(&event.when, scene, Place::Potential).ok()).collect();
    let rest = vec![0.0; q.len()];
    let is_met = |jump: &Jump, event: &mut Observable| {
        let mut size = |q: &[f64]| event.at(q, &rest, &rest, 0.0).abs();
        size(&jump.at) <= 1e-9 * jump.beside.iter().map(|q| size(q)).fold(0.0, f64::max)
    };
    let jumps = case.compiled.jumps(q);
    let Some(jump) = jumps.iter().find(|jump| !acting.iter_mut().any(|event| is_met(jump, event))) else {
        return Ok(());
    };
    let what = if scene.potential.is_some() { "potential" } else { "metric" };
    let names = case.coordinates();
    let moved = jump.at.iter().zip(q).zip(&names).filter(|((at, q), _)| at != q);
    let place: Vec<String> = moved.map(|((at, _), name)| format!("{name} = {at:.6}")).collect();
    let message = format!(
        "the {what} jumps where the argument of {} is 0, as at {}: no force does that",
        jump.function,
        place.join(", ")
    );
    let help = "make it a slope, such as tanh(x/w) with a small w, let an event there `set` the velocity, or give what \
                is switched on at a time as a force: the energy jumps with the potential";
    Err(whole.error(message).with_help(help))
}

/// Refuses events that act where they cannot.
pub(super) fn acting(case: &Case, events: &Field<'_>) -> Result<(), CaseError> {
    let names = case.coordinates();
    for (event, field) in case.events.iter().zip(events.fields()).filter(|(event, _)| !event.set.is_empty()) {
        let sets = |is: &dyn Fn(Quantity) -> bool| event.set.iter().any(|(quantity, _)| is(*quantity));
        let is_added = |quantity: Quantity| match quantity {
            Quantity::Position(a) | Quantity::Velocity(a) | Quantity::Momentum(a) => {
                case.is_lifted() && (a == 0 || a + 1 == names.len())
            }
            Quantity::Parameter(_) => false,
        };
        let saltation = || case.settings.sensitivity.then(|| case.saltation(event, Extended::ZERO).err()).flatten();
        let (message, help) = if case.settings.accuracy.is_none() {
            ("an event acts where windows end, and here they are given", "give solver.accuracy or solver.tolerance")
        } else if case.is_backward() {
            ("an event that acts cannot be undone, and the run goes backward", "begin at the other end")
        } else if case.geometry_text.conformal.is_some() {
            ("no event acts in a scene with a conformal factor, which changes the pace of gamma", "leave conformal out")
        } else if case.from.is_some() && sets(&|quantity| matches!(quantity, Quantity::Parameter(_))) {
            // The end of a run does not say what its events have made of parameters.
            ("an event sets a parameter, and the run goes on from another one", "begin at the start of that run")
        } else if sets(&is_added) {
            ("with Newton's law t runs by itself, and s follows from the energy", "set the other coordinates")
        } else if case.grid.t_f.is_some() && sets(&|it| matches!(it, Quantity::Position(a) if names[a] == "t")) {
            ("an event sets t, by which the run ends", "end it at gamma_f")
        } else if let Some(reason) = saltation() {
            let message = format!("no sensitivity is carried through the event '{}': {reason}", event.name);
            return Err(field.key_error(message).with_help("leave solver.sensitivity out"));
        } else {
            continue;
        };
        return Err(field.key_error(format!("{message} ({})", field.path)).with_help(help));
    }
    Ok(())
}
