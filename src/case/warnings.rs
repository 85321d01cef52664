//! Warnings about cases that are valid but may surprise.

use super::names::mentions;
use super::{Case, Rate};
use crate::geometry::{GeometryText, Law, Preset, Start};

/// If K is below this share of g00 ṫ², it is a small difference of large numbers and has lost digits.
const NEARLY_SPACELIKE: f64 = 1e-2;

impl Case {
    /// The warnings that a user should know before believing the result.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings: Vec<String> =
            self.unused_parameters().map(|name| format!("no formula uses the parameter '{name}'")).collect();
        if !self.scheme.regularised {
            warnings.push(
                "regularised = false: without the regularisation critical points are wrong or missing".to_owned(),
            );
        }
        if self.ignores_scheme {
            warnings.push(
                "with solver.accuracy or solver.tolerance the program chooses operator and form (weak): what [scheme] \
                 says is not used"
                    .to_owned(),
            );
        }
        if matches!(&self.geometry, GeometryText::Potential(potential) if potential.law == Law::Relativistic) {
            warnings.extend(self.warning_of_speed());
        }
        warnings
    }

    /// Says that the particle is as fast as light, or nearly so.
    fn warning_of_speed(&self) -> Option<String> {
        let geometry = self.geometry::<f64>();
        let Start { q, q_dot, .. }: Start = self.start_in(&geometry);
        let k = geometry.norm(&q, &q_dot);
        let timelike = k + q_dot[1].powi(2);
        if k < 0.0 {
            let bound = if self.is_of_x { ", and the bound on H_BVP does not hold" } else { "" };
            return Some(format!(
                "the initial tangent is spacelike (K = {k:.6} < 0): the particle starts faster than light{bound}; for \
                 a motion of matter start slower, raise particle.c, or take particle.law = \"newtonian\""
            ));
        }
        (self.is_of_x && k < NEARLY_SPACELIKE * timelike).then(|| {
            format!(
                "the initial tangent is nearly spacelike: K = {k:.2e} is below {NEARLY_SPACELIKE} of g00 t_dot^2 = \
                 {timelike:.2e}; the particle starts almost with the speed of light, and K has lost digits: start \
                 slower, or raise solver.digits"
            )
        })
    }

    /// Parameters of the case that no formula mentions.
    fn unused_parameters(&self) -> impl Iterator<Item = &str> {
        let preset = self.preset.and_then(Preset::from_name);
        let names = self.geometry.parameters().iter().map(|(name, _)| name.as_str());
        names.filter(move |name| {
            let is_of_preset = preset.is_some_and(|preset| preset.parameters().any(|other| other == *name));
            !is_of_preset && !self.is_used(name)
        })
    }

    /// Returns true if a formula mentions a name.
    pub(super) fn is_used(&self, name: &str) -> bool {
        self.formulas().iter().any(|formula| mentions(formula, name))
    }

    /// Every formula of the case.
    fn formulas(&self) -> Vec<&str> {
        let mut formulas: Vec<&str> = self.geometry.parameters().iter().map(|(_, text)| text.as_str()).collect();
        match &self.geometry {
            GeometryText::Metric(metric) => {
                formulas.extend(metric.components.iter().map(|(_, text)| text.as_str()));
                formulas.extend(metric.definitions.iter().map(|(_, text)| text.as_str()));
                formulas.extend(metric.one_form.iter().chain(&metric.force).map(|(_, text)| text.as_str()));
                formulas.extend(metric.conformal.as_deref());
            }
            GeometryText::Potential(potential) => {
                formulas.extend([&potential.expression, &potential.mass, &potential.c].map(String::as_str));
                formulas.extend(potential.masses.iter().map(String::as_str));
                formulas.extend(potential.definitions.iter().map(|(_, text)| text.as_str()));
                formulas.extend(potential.one_form.iter().chain(&potential.force).map(|(_, text)| text.as_str()));
                formulas.extend(potential.conformal.as_deref());
            }
        }
        let rates = self.initial.rates.iter().filter_map(|rate| match rate {
            Rate::Velocity(quantity) | Rate::Momentum(quantity) => Some(quantity),
            _ => None,
        });
        let ends = [Some(&self.grid.gamma_i), self.grid.gamma_f.as_ref(), self.grid.t_f.as_ref()];
        let expected = self.expect.iter().flat_map(|expect| {
            let finals = expect.finals.iter().map(|(_, quantity)| quantity);
            finals.chain(&expect.gamma_final).chain(&expect.tolerance)
        });
        let quantities = self.initial.q.iter().chain(rates).chain(&self.initial.norm);
        let floors = self.solver.floor.iter().map(|(_, quantity)| quantity);
        let quantities = quantities.chain(ends.into_iter().flatten()).chain(expected).chain(floors);
        formulas.extend(quantities.map(|quantity| quantity.text()));
        formulas.extend(self.grid.until.as_deref());
        formulas.extend(self.invariants.iter().map(|(_, text)| text.as_str()));
        formulas.extend(self.events.iter().map(|event| event.when.as_str()));
        formulas.extend(self.events.iter().flat_map(|event| event.set.iter().map(|(_, text)| text.as_str())));
        formulas.extend(self.axes.iter().flat_map(|axes| [axes.x.as_str(), axes.y.as_str()]));
        formulas
    }
}
