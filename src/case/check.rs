//! Checks of a case as a whole: one geometry, a start inside its domain, and a motion that its law allows.

use super::CaseError;
use super::initial::Initial;
use super::reader::{Field, Section};
use super::scenery::Scenery;
use super::start::{self, NoStart, Solved};
use super::{Case, bodies, conformal, metric, potential};
use crate::geometry::{Geometry, GeometryText, Law, OutsideGeometry, Place, PotentialText, Start, Tau};
use crate::number::Real;
use crate::solve::Quantity;

/// Reads the one of `[metric]` and `[potential]` that is given.
pub(super) fn geometry<'t>(
    root: &mut Section<'t>,
    [metric, potential, force, body]: [Option<Field<'t>>; 4],
    [particle, pair]: [Section<'t>; 2],
) -> Result<Scenery<'t>, CaseError> {
    if let Some(body) = body {
        let other = [&metric, &potential, &force].into_iter().flatten().next();
        if let Some(error) = other.map(|field| field.key_error(format!("both [[body]] and [{}] are given", field.key)))
        {
            let help = "bodies move by Newton's law in the energy of their pairs, [pair] formula";
            return Err(error.with_help(help.to_owned()));
        }
        if particle.is_given() {
            let message = "[particle] belongs to a potential, and the case has bodies";
            return Err(particle.error(message).with_help("every body has a mass of its own".to_owned()));
        }
        return bodies::read(&body, pair);
    }
    if pair.is_given() {
        return Err(pair.error("[pair] needs bodies").with_help("give [[body]], one table for each".to_owned()));
    }
    if let (Some(_), Some(force)) = (&metric, &force) {
        let help = "a force in a metric is metric.force".to_owned();
        return Err(force.key_error("[force] belongs to a potential, and the case has a metric").with_help(help));
    }
    match (metric, potential) {
        (None, None) if force.is_some() => potential::read(root.section("potential")?, force, particle),
        (Some(_), Some(potential)) => {
            let help = "a case has exactly one of [metric] and [potential]".to_owned();
            Err(potential.key_error("both a metric and a potential are given").with_help(help))
        }
        (None, None) => {
            let help = "a case has exactly one of [metric] and [potential]".to_owned();
            Err(root.error("missing field `metric` or `potential`").with_help(help))
        }
        (Some(metric), None) => {
            if particle.is_given() {
                let help = "write the mass into the metric, or take a [potential]".to_owned();
                return Err(particle
                    .error("[particle] belongs to a potential, and the case has a metric")
                    .with_help(help));
            }
            metric::read(metric.section()?)
        }
        (None, Some(potential)) => potential::read(potential.section()?, force, particle),
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

/// The initial data, if everything about them is allowed.
pub(super) struct Found<S> {
    geometry: Geometry<S>,
    /// The geometry that the data belong to, if it is not that of the case.
    bare: Option<Geometry<S>>,
    /// The start there.
    start: Start<S>,
    /// True if the two roots for the unknown rate are one.
    pub(super) is_double: bool,
    /// The coordinate that K ≠ 0 asks for.
    pub(super) tau: Option<Tau>,
}

impl<S: Real> Found<S> {
    /// The start in the geometry of the case, and this geometry, which has the coordinate tau if one is asked for.
    pub(super) fn place(
        self,
        scenery: &mut Scenery<'_>,
        initial: &Initial<'_>,
    ) -> Result<(Start<S>, Geometry<S>), CaseError> {
        let Self { geometry, bare, start, tau, .. } = self;
        scenery.add(tau);
        let (text, Some(bare)) = (&scenery.text, bare) else { return Ok((start, geometry)) };
        let start = conformal::with_factor(text, &bare, &initial.data, start);
        if start.q_dot.iter().any(|u| !u.is_finite()) {
            return Err(no_start(&NoStart::NotFinite, initial, &text.coordinates()));
        }
        let geometry = if tau.is_some() { scenery.geometry()? } else { geometry };
        let outside = Outside::of(&geometry);
        let names = geometry.names().to_vec();
        let geometry = geometry.around(&start.q).map_err(|error| outside.error(&error, initial, &names, &start.q))?;
        Ok((start, geometry))
    }
}

/// The start in `S`, if there is one that everything about it allows.
pub(super) fn start<S: Real>(
    scenery: &Scenery<'_>,
    initial: &Initial<'_>,
    geometry: Geometry<S>,
    rounding: f64,
) -> Result<Found<S>, CaseError> {
    let parameters = scenery.text.parameters();
    let number = |quantity: &super::Quantity| quantity.value::<S>(parameters);
    let q = initial.data.q.iter().map(number).collect::<Result<Vec<S>, _>>();
    let q = q.map_err(|_| initial.section.error("a coordinate is not a finite number in the digits asked for"))?;
    let names = geometry.names().to_vec();
    let outside = Outside::of(&geometry);
    check_g00(scenery, initial, &geometry, &q)?;
    let geometry = geometry.around(&q).map_err(|error| outside.error(&error, initial, &names, &q))?;
    scenery.check_factor(&q)?;
    let bare = scenery.bare()?;
    check_masses(scenery, bare.as_ref().unwrap_or(&geometry), &q)?;
    let of_data = bare.as_ref().unwrap_or(&geometry);
    let solved = start::solve(&initial.data, of_data, parameters, rounding, None);
    let Solved { start, is_double } = solved.map_err(|none| no_start(&none, initial, &names))?;
    let tau = check_motion(scenery, initial, of_data, &start, rounding)?;
    geometry.point().evaluate(&start.q, &start.p).map_err(|error| outside.error(&error, initial, &names, &q))?;
    Ok(Found { geometry, bare, start, is_double, tau })
}

/// The words for a mistake in the position.
struct Outside {
    active: Vec<usize>,
    blocks: Vec<Vec<usize>>,
}

impl Outside {
    fn of<S: Real>(geometry: &Geometry<S>) -> Self {
        Self { active: geometry.active().to_vec(), blocks: geometry.blocks().to_vec() }
    }

    fn error<S: Real>(&self, outside: &OutsideGeometry, initial: &Initial<'_>, names: &[String], q: &[S]) -> CaseError {
        let at: Vec<String> = names.iter().zip(q).map(|(name, q)| format!("{name} = {}", q.to_f64())).collect();
        let at = at.join(", ");
        let Some(block) = outside.block else {
            let message = format!("the metric, the force or a derivative is not finite at the start, {at}");
            return initial.error_in_position(&self.active, message);
        };
        let list = self.blocks[block].iter().map(|&a| names[a].as_str()).collect::<Vec<_>>().join(", ");
        let message = format!(
            "the metric is degenerate at the start: the determinant of the components of {list} is {} at {at}",
            outside.determinant
        );
        let help = "choose another start, or coordinates that are regular there".to_owned();
        initial.error_in_position(&self.active, message).with_help(help)
    }
}

fn no_start(none: &NoStart, initial: &Initial<'_>, names: &[String]) -> CaseError {
    let unknown = |a: usize| {
        let rate = &initial.data.rates[a];
        if rate.is_momentum() { format!("p_{}", names[a]) } else { format!("{}_dot", names[a]) }
    };
    match none {
        NoStart::Undetermined(block) => {
            let list: Vec<String> = block.iter().map(|&a| format!("p_{}", names[a])).collect();
            let velocities: Vec<String> = block.iter().map(|&a| format!("{}_dot", names[a])).collect();
            let message = format!("{} do not determine {}", list.join(", "), velocities.join(", "));
            let help = "the metric has no inverse in these coordinates alone: give a velocity in place of a momentum";
            initial.error_in_rate(block[0], message).with_help(help.to_owned())
        }
        NoStart::Independent(a) => {
            let message = format!("K does not depend on {}, so that norm cannot determine it", unknown(*a));
            initial.error_in_norm(message).with_help("solve for another velocity or momentum".to_owned())
        }
        NoStart::NoRoot { coordinate, norm, extreme, is_most } => {
            let unknown = unknown(*coordinate);
            let bound = if *is_most { "at most" } else { "at least" };
            let message = format!("no real {unknown} gives K = {norm}: K is {bound} {extreme} whatever {unknown} is");
            let help = format!("change the other velocities and momenta, or take a norm of {bound} {extreme}");
            initial.error_in_norm(message).with_help(help)
        }
        NoStart::OtherSign { coordinate, root } => {
            let unknown = unknown(*coordinate);
            let message = format!("the only {unknown} that gives this K is {root}, which has the other sign");
            initial.error_in_norm(message).with_help("change the sign in solve".to_owned())
        }
        NoStart::NotFinite => initial.section.error("a velocity, a momentum or K is not a finite number at the start"),
    }
}

/// Refuses masses and c that are not positive.
pub(super) fn particle(scenery: &Scenery<'_>) -> Result<(), CaseError> {
    let GeometryText::Potential(potential) = &scenery.text else { return Ok(()) };
    let masses = potential.masses.iter().enumerate().map(|(a, mass)| (Place::Mass(Some(a)), mass));
    let both = [(Place::Mass(None), &potential.mass), (Place::SpeedOfLight, &potential.c)];
    for (place, text) in both.into_iter().chain(masses) {
        let Some((_, field)) = scenery.fields.iter().find(|(other, _)| *other == place) else { continue };
        // A mass that depends on t is looked at with the start; a formula that is no number is refused elsewhere.
        let value = super::Quantity::new(text.clone()).value::<f64>(&potential.parameters);
        if let Some(value) = value.ok().filter(|value| *value <= 0.0) {
            return Err(field.error(format!("{} must be positive, got {value}", field.path)));
        }
    }
    Ok(())
}

/// Refuses masses that depend on t and are not positive at the start.
fn check_masses<S: Real>(scenery: &Scenery<'_>, geometry: &Geometry<S>, q: &[S]) -> Result<(), CaseError> {
    let GeometryText::Potential(potential) = &scenery.text else { return Ok(()) };
    let diagonal = geometry.diagonal(q);
    for a in (0..potential.coordinates.len()).filter(|a| diagonal[a + 1].to_f64() > 0.0) {
        if let Some((_, field)) = scenery.fields.iter().find(|(place, _)| *place == Place::Mass(Some(a))) {
            return Err(field.error(format!("{} must be positive, and is not at the start", field.path)));
        }
    }
    Ok(())
}

/// Refuses a start where the paper's metric is none.
fn check_g00<S: Real>(
    scenery: &Scenery<'_>,
    initial: &Initial<'_>,
    geometry: &Geometry<S>,
    q: &[S],
) -> Result<(), CaseError> {
    if !matches!(&scenery.text, GeometryText::Potential(potential) if potential.law == Law::Relativistic) {
        return Ok(());
    }
    let mut rest = vec![S::ZERO; geometry.dimension()];
    rest[0] = S::ONE;
    let g00 = geometry.norm(q, &rest).to_f64();
    if g00 > 0.0 && g00.is_finite() {
        return Ok(());
    }
    let message = format!("g00 = c^2 + 2V/m must be positive and finite at the start, got {g00}");
    let help = "choose another start, a weaker potential or a larger c".to_owned();
    Err(initial.error_in_position(geometry.active(), message).with_help(help))
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
    let size = start::size_of_norm(geometry, start);
    let is_null = k.abs() <= start::rounding_of_norm::<S>(geometry.dimension(), rounding) * size;
    let law = match &scenery.text {
        GeometryText::Metric(_) => None,
        GeometryText::Potential(PotentialText { law, .. }) => Some(*law),
    };
    if let Some(from) = &initial.from {
        // K is what that run has made of it.
        return Ok(from.has(Tau::NAME).then(|| scenery.tau(k, geometry.has_force())).transpose()?.flatten());
    }
    if law == Some(Law::Newtonian) && !is_null {
        let message = format!("a newtonian scene has K = 0, and these data give K = {}", k.to_f64());
        let help = "leave out s_dot and p_s (or p_t): they follow from the energy".to_owned();
        return Err(initial.section.error(message).with_help(help));
    }
    if is_null { Ok(None) } else { scenery.tau(k, geometry.has_force()) }
}

/// Refuses events that act where they cannot.
pub(super) fn acting(case: &Case, events: &Section<'_>) -> Result<(), CaseError> {
    let is_conformal = match case.geometry_text() {
        GeometryText::Metric(metric) => metric.conformal.is_some(),
        GeometryText::Potential(potential) => potential.conformal.is_some(),
    };
    let names = case.coordinates();
    for (event, field) in case.events().iter().zip(events.fields()).filter(|(event, _)| !event.set.is_empty()) {
        let is_added = |quantity: Quantity| match quantity {
            Quantity::Position(a) | Quantity::Velocity(a) | Quantity::Momentum(a) => {
                case.is_lifted() && (a == 0 || a + 1 == names.len())
            }
            Quantity::Parameter(_) => false,
        };
        let is_parameter = |quantity: Quantity| matches!(quantity, Quantity::Parameter(_));
        let is_t = |quantity: Quantity| matches!(quantity, Quantity::Position(a) if names[a] == "t");
        let (message, help) = if !case.solver.chooses_windows() {
            ("an event acts where windows end, and here they are given", "give solver.accuracy or solver.tolerance")
        } else if case.is_backward() {
            ("an event that acts cannot be undone, and the run goes backward", "begin at the other end")
        } else if case.solver.sensitivity {
            ("no sensitivity is carried through an event that acts", "leave solver.sensitivity out")
        } else if is_conformal {
            ("no event acts in a scene with a conformal factor, which changes the pace of gamma", "leave conformal out")
        } else if case.from.is_some() && event.set.iter().any(|(quantity, _)| is_parameter(*quantity)) {
            // The end of a run does not say what its events have made of parameters.
            ("an event sets a parameter, and the run goes on from another one", "begin at the start of that run")
        } else if event.set.iter().any(|(quantity, _)| is_added(*quantity)) {
            ("with Newton's law t runs by itself, and s follows from the energy", "set the other coordinates")
        } else if case.grid().t_f.is_some() && event.set.iter().any(|(quantity, _)| is_t(*quantity)) {
            ("an event sets t, by which the run ends", "end it at gamma_f")
        } else {
            continue;
        };
        return Err(field.key_error(format!("{message} ({})", field.path)).with_help(help.to_owned()));
    }
    Ok(())
}
