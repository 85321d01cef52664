//! Formulas that a search makes zero: of the state at the end of a run and, in `start(…)`, of that at its start.

use super::observables::Formulas;
use super::scenery::known;
use super::setup::observable;
use super::{Case, Grid, Rate};
use crate::formula::FormulaError;
use crate::geometry::{Degrees, GeometryText, Jets, OfEnds, Start, StartTexts, observed, uses};
use crate::number::{Extended, Real};

/// The word that a formula of the start stands behind.
const START: &str = "start";

/// A formula in positions, velocities, momenta and `norm` at the end of a run; what stands in `start(…)` is a formula
/// of the same at its start.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Condition {
    /// The formula as it is written.
    pub text: String,
    /// The same with a name in the place of each `start(…)`.
    end: String,
    /// These names, with the formulas of the start.
    starts: Vec<(String, String)>,
}

impl Condition {
    /// Reads a formula.
    ///
    /// # Errors
    /// A message, and what to do, if it is none.
    pub(super) fn read(text: &str, formulas: &Formulas<'_>) -> Result<Self, (String, String)> {
        let (coordinates, scene) = (formulas.coordinates, formulas.scene);
        let explained = |(error, names): (FormulaError, Vec<String>)| {
            let message = format!("{} (character {} of {})", error.message, error.character(), error.expression);
            (message, error.hint.unwrap_or_else(|| known(names)))
        };
        let names = observed(coordinates).into_iter().chain(scene.definitions.iter().map(|(name, _)| name.clone()));
        let taken: Vec<String> = names.chain(scene.parameters.iter().map(|(name, _)| name.clone())).collect();
        let unbalanced = || (format!("a parenthesis is missing in {text}"), "write start(x) for x at the start".into());
        let (end, starts) = split(text, &taken).ok_or_else(unbalanced)?;
        for (_, inner) in &starts {
            formulas.understand(inner, observed(coordinates)).map_err(explained)?;
        }
        let names = observed(coordinates).into_iter().chain(starts.iter().map(|(name, _)| name.clone()));
        formulas.understand(&end, names.collect()).map_err(explained)?;
        Ok(Self { text: text.to_owned(), end, starts })
    }

    /// The value for a run of `case` from one state to another.
    pub fn at<S: Real>(&self, case: &Case, start: &Start<S>, end: &Start<S>, norm: S) -> S {
        let mut scene = case.geometry_text.clone();
        for (name, formula) in &self.starts {
            let value = observable::<S>(&case.geometry_text, formula).at(&start.q, &start.q_dot, &start.p, norm);
            scene.parameters.push((name.clone(), value.to_decimal(S::MOST_DIGITS)));
        }
        observable::<S>(&scene, &self.end).at(&end.q, &end.q_dot, &end.p, norm)
    }
}

impl Condition {
    /// Returns true if the formula has this name in it.
    pub(crate) fn uses(&self, name: &str) -> bool {
        uses(&self.text, name)
    }
}

impl Case {
    /// The degrees of the start in the unknown parameters of the scene, and of the first and the last γ or t.
    pub(crate) fn start_degrees(&self) -> Degrees {
        let rates = &self.initial.rates;
        let given = |rate: &'_ Rate| match rate {
            Rate::Velocity(text) => (Some(text.clone()), None),
            Rate::Momentum(text) => (None, Some(text.clone())),
            _ => (None, None),
        };
        let (velocities, momenta) = rates.iter().map(given).unzip();
        let Grid { gamma_i, gamma_f, t_f, .. } = &self.grid;
        // The data are those without a factor of the metric, but by Newton's law.
        let text = match self.is_lifted() {
            true => self.geometry_text.clone(),
            false => GeometryText { conformal: None, ..self.geometry_text.clone() },
        };
        let start = StartTexts {
            q: self.initial.q.clone(),
            velocities,
            momenta,
            others: [gamma_i].into_iter().chain(gamma_f).chain(t_f).cloned().collect(),
        };
        Degrees::new(&text, &start).expect("a valid case has valid formulas")
    }

    /// Conditions with their derivatives by the states at both ends of a run, where K is `norm` at its start.
    pub(crate) fn jets(&self, conditions: &[Condition], norm: Extended) -> Jets {
        let of: Vec<OfEnds<'_>> =
            conditions.iter().map(|Condition { end, starts, .. }| OfEnds { end, starts }).collect();
        self.jets_of(&of, norm)
    }

    /// The same of any formulas that the case has been read with.
    pub(crate) fn jets_of(&self, formulas: &[OfEnds<'_>], norm: Extended) -> Jets {
        Jets::new(&self.geometry_text, formulas, norm, self.is_backward()).expect("a valid case has valid formulas")
    }
}

/// The formula with new names in the place of `start(…)`, and these with what stands there. `None` where a parenthesis
/// is not closed.
fn split(text: &str, taken: &[String]) -> Option<(String, Vec<(String, String)>)> {
    let (mut end, mut starts, mut rest) = (String::new(), Vec::new(), text);
    while let Some(place) = rest.find(START) {
        let (before, behind) = (&rest[..place], &rest[place + START.len()..]);
        let is_begun = before.ends_with(|c: char| c.is_ascii_alphanumeric() || c == '_');
        end += before;
        let Some(inner) = behind.trim_start().strip_prefix('(').filter(|_| !is_begun) else {
            end += START;
            rest = behind;
            continue;
        };
        let mut depth = 1;
        let close = inner.find(|c| {
            depth += i32::from(c == '(') - i32::from(c == ')');
            depth == 0
        })?;
        let mut name = format!("{START}_{}", starts.len() + 1);
        while taken.contains(&name) {
            name.push('_');
        }
        end += &name;
        starts.push((name, inner[..close].to_owned()));
        rest = &inner[close + 1..];
    }
    Some((end + rest, starts))
}

#[cfg(test)]
mod tests {
    use super::split;

    #[test]
    fn what_is_of_the_start_is_split_off() {
        let (end, starts) = split("x - start(x*(y + 1)) + restart + 2*start (y)", &["start_1".to_owned()]).unwrap();
        assert_eq!(end, "x - start_1_ + restart + 2*start_2");
        assert_eq!(starts, [("start_1_", "x*(y + 1)"), ("start_2", "y")].map(|(a, b)| (a.to_owned(), b.to_owned())));
        assert_eq!(split("start(x", &[]), None);
    }
}
