//! Warnings about cases that are valid but may surprise.

use super::keys::PARAMETERS;
use super::source::is_used;
use super::{Case, Interval};
use crate::formula::similar::nearest;
use crate::geometry::{Law, Preset, Start};

/// If K is below this share of g00 ṫ², it is a small difference of large numbers and has lost digits.
const NEARLY_SPACELIKE: f64 = 1e-2;

impl Case {
    /// The warnings that a user should know before believing the result.
    pub fn warnings(&self) -> Vec<String> {
        let given = || self.geometry_text.parameters.iter().map(|(name, _)| name.as_str());
        // A run that continues another one has no start in which they stand.
        let unused = self.unused_parameters().filter(|_| self.from.is_none()).map(|name| {
            // An override may have given one that is called nearly as another.
            let meant = nearest(name, given().filter(|other| *other != name));
            let meant = meant.map_or_else(String::new, |meant| format!("; there is '{meant}', too"));
            format!("no formula uses the parameter '{name}'{meant}")
        });
        let unregularised = "regularised = false: without the regularisation critical points are wrong or missing";
        let unread = "with solver.accuracy or solver.tolerance the program chooses operator and form (weak): what \
                      [scheme] says is not used";
        let fixed = [(!self.settings.regularised, unregularised), (self.ignores_scheme, unread)];
        let fixed = fixed.into_iter().filter(|(holds, _)| *holds).map(|(_, warning)| warning.to_owned());
        unused.chain(fixed).chain(self.warning_of_speed()).collect()
    }

    /// Notes on what the case is written in and the next version does not read.
    pub fn notes(&self) -> Vec<String> {
        let note = |place: &&str| {
            format!("{place} goes in the next version: [{PARAMETERS}] has the parameters of all formulas")
        };
        let middle = |Interval { key, .. }: &Interval| format!("{key} is an interval: a run takes its middle");
        self.former.iter().map(note).chain(self.intervals.iter().map(middle)).collect()
    }

    /// Says that a particle of the paper's metric is as fast as light, or nearly so.
    fn warning_of_speed(&self) -> Option<String> {
        if self.geometry_text.law() != Some(Law::Relativistic) {
            return None;
        }
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
        let names = self.geometry_text.parameters.iter().map(|(name, _)| name.as_str());
        names.filter(move |name| {
            let is_of_preset = preset.is_some_and(|preset| preset.parameters().any(|other| other == *name));
            !is_of_preset && !is_used(&self.text, name)
        })
    }
}
