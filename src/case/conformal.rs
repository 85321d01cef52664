//! A conformal factor Ω: the initial data are those of the metric without it.
//!
//! Momenta are the same with Ω and without, velocities are divided by Ω. A particle with K ≠ 0 is one with K = 0 that
//! has one more flat coordinate, tau. Without Ω its component is −1 for K > 0 and 1 for K < 0, and dtau/dγ = √|K|.

use super::CaseError;
use super::initial::StartData;
use super::scenery::Scenery;
use crate::geometry::{Geometry, GeometryText, Law, Observable, Place, Start, Tau};
use crate::number::Real;

/// The geometry that the initial data belong to, if it is another one: that without Ω. With Newton's law they are those
/// of the geometry with Ω.
pub(super) fn bare(text: &GeometryText) -> Option<GeometryText> {
    let mut bare = text.clone();
    let conformal = match &mut bare {
        GeometryText::Metric(metric) => {
            metric.tau = None;
            &mut metric.conformal
        }
        GeometryText::Potential(potential) if potential.law == Law::Newtonian => return None,
        GeometryText::Potential(potential) => &mut potential.conformal,
    };
    conformal.take().map(|_| bare)
}

/// The start in the geometry of `text` that belongs to `start`, which is that in the geometry `of_data`.
pub(super) fn with_factor<S: Real>(
    text: &GeometryText,
    of_data: &Geometry<S>,
    data: &StartData,
    mut start: Start<S>,
) -> Start<S> {
    if bare(text).is_none() {
        return start;
    }
    if let Some(tau) = text.tau() {
        let given = data.norm.as_ref().map(|norm| norm.value(text.parameters()).expect("K is a finite number"));
        let k: S = given.unwrap_or_else(|| of_data.norm(&start.q, &start.q_dot));
        let rate = k.abs().sqrt();
        start.q.push(S::ZERO);
        start.q_dot.push(rate);
        start.p.push(tau.component::<S>() * rate);
    }
    let omega = factor(text, &start.q).unwrap_or(S::ONE);
    start.q_dot.iter_mut().for_each(|u| *u = *u / omega);
    start
}

/// Ω at a point, if there is one.
fn factor<S: Real>(text: &GeometryText, q: &[S]) -> Option<S> {
    let formula = match text {
        GeometryText::Metric(metric) => metric.conformal.as_deref(),
        GeometryText::Potential(potential) => potential.conformal.as_deref(),
    }?;
    let mut omega = Observable::new(formula, text, Place::Conformal).expect("a geometry that compiles has such an Ω");
    let zeros = vec![S::ZERO; q.len()];
    Some(omega.at(q, &zeros, &zeros, S::ZERO))
}

impl Scenery<'_> {
    /// The coordinate tau that a start with K = `k` ≠ 0 needs, if there is a factor Ω.
    pub(super) fn tau<S: Real>(&self, k: S, has_force: bool) -> Result<Option<Tau>, CaseError> {
        let Some((_, conformal)) = self.fields.iter().find(|(place, _)| *place == Place::Conformal) else {
            return Ok(None);
        };
        let found = format!("these data give K = {}", k.to_f64());
        if matches!(self.text, GeometryText::Potential(_)) {
            let message = format!("conformal needs a null start, K = 0, and {found}");
            let help =
                "take law = \"newtonian\", or write the metric as [metric], where a particle with mass may have it";
            return Err(conformal.error(message).with_help(help.to_owned()));
        }
        if has_force {
            let message = format!("conformal and a force need a null start, K = 0, and {found}");
            let help = "a force may change K, and with conformal K is that of the start: leave out one of the two";
            return Err(conformal.error(message).with_help(help.to_owned()));
        }
        self.check_names()?;
        Ok(Some(if k > S::ZERO { Tau::Timelike } else { Tau::Spacelike }))
    }

    /// Adds the coordinate tau, if there is to be one.
    pub(super) fn add(&mut self, tau: Option<Tau>) {
        if let GeometryText::Metric(metric) = &mut self.text {
            metric.tau = tau;
        }
    }

    /// Refuses what has the name of the coordinate tau, of its velocity or of its momentum.
    fn check_names(&self) -> Result<(), CaseError> {
        let is_taken = |name: &str| name.strip_prefix("p_").or(name.strip_suffix("_dot")).unwrap_or(name) == Tau::NAME;
        let message = |kind: &str, name: &str| {
            format!(
                "the {kind} '{name}' has the name of what conformal adds, the coordinate tau of a start with K not 0"
            )
        };
        let help = || "choose another name".to_owned();
        for (place, field) in &self.fields {
            let kind = match place {
                Place::Parameter(_) => "parameter",
                Place::Definition(_) => "definition",
                _ => continue,
            };
            if is_taken(&field.key) {
                return Err(field.key_error(message(kind, &field.key)).with_help(help()));
            }
        }
        let Some(field) = self.section.fields().into_iter().find(|field| field.key == "coordinates") else {
            return Ok(());
        };
        match field.strings()?.into_iter().find(|(name, _)| is_taken(name)) {
            Some((name, span)) => Err(field.error_at(span, message("coordinate", &name)).with_help(help())),
            None => Ok(()),
        }
    }

    /// Refuses an Ω at a point that is not positive: it would turn the direction of γ.
    pub(super) fn check_factor<S: Real>(&self, q: &[S]) -> Result<(), CaseError> {
        let omega = factor(&self.text, q).filter(|_| bare(&self.text).is_some());
        let Some(omega) = omega.filter(|omega| *omega <= S::ZERO) else { return Ok(()) };
        let message = format!("conformal must be positive at the start, and it is {}", omega.to_f64());
        let field = self.fields.iter().find(|(place, _)| *place == Place::Conformal).map(|(_, field)| field);
        let error = field.map_or_else(|| self.section.error(message.clone()), |field| field.error(message.clone()));
        Err(error.with_help("take a factor that is positive along the whole orbit".to_owned()))
    }
}
