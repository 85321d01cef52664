//! From a scene's case to what a solver is told.

use std::sync::Arc;

use super::SceneCase;
use crate::action::Form;
use crate::case::validate::{check_nodes, check_spacing};
use crate::geometry::{GeometryText, Law, Observable, Place as FormulaPlace};
use crate::sbp::SbpName;
use crate::scalar::Real;
use crate::solve::End;
use crate::solve::scene::{Place, SceneLimit, SceneSetup, Until};

impl SceneCase {
    fn place<S: Real>(&self) -> Place<S> {
        let geometry = self.geometry();
        let start = self.start_in(&geometry);
        Place { geometry: Arc::new(geometry), start }
    }

    /// Whether the scene is the lift of Newton's law: its first coordinate is t, its last one s.
    pub fn is_lifted(&self) -> bool {
        matches!(self.geometry_text(), GeometryText::Potential(potential) if potential.law == Law::Newtonian)
    }

    /// The formulas of `[invariants]`, compiled, with their names, in their order.
    pub fn observables<S: Real>(&self) -> Vec<(String, Observable<S>)> {
        let compiled = |(name, formula): &(String, String)| (name.clone(), observable(self.geometry_text(), formula));
        self.invariants().iter().map(compiled).collect()
    }

    /// What the solver of scenes is told.
    pub fn setup<S: Real>(&self) -> SceneSetup<S> {
        let place = self.place::<S>();
        let limit = match self.end::<S>() {
            End::Length(length) => SceneLimit::Length(length),
            End::Duration(duration) => {
                let t = place.geometry.names().iter().position(|name| name == "t");
                let coordinate = t.expect("t_f needs a coordinate t");
                SceneLimit::Value { coordinate, value: place.start.q[coordinate] + duration }
            }
        };
        let text = self.geometry_text();
        let until =
            self.until().map(|formula| Until { formula: observable(text, formula), rough: observable(text, formula) });
        SceneSetup {
            place,
            rough: self.place(),
            gamma_i: self.gamma_i(),
            limit,
            until,
            sbp: self.sbp(),
            form: self.form(),
            n_gamma: self.n_gamma(),
            windows: self.windows(),
            system: self.system(),
            digits: if S::IS_EXTENDED { self.digits() } else { f64::MOST_DIGITS },
            max_iterations: self.max_iterations(),
        }
    }
}

/// What the solver is told on another grid: with that operator and form and so many nodes in each window, over γ − γ_i up
/// to `length`. A spectral element gets as many windows as make about that number of nodes in all.
///
/// # Errors
/// A message that says what is wrong with that grid.
pub fn on_grid<S: Real>(
    setup: &SceneSetup<S>,
    (sbp, form): (SbpName, Form),
    n_gamma: usize,
    length: S,
) -> Result<SceneSetup<S>, String> {
    let (n_gamma, windows) = match sbp.fixed_points() {
        Some(nodes) => (nodes, (n_gamma.saturating_sub(1) / (nodes - 1)).max(1)),
        None => (n_gamma, setup.windows),
    };
    let intervals = n_gamma.max(2).saturating_sub(1).saturating_mul(windows);
    let spaced = || check_spacing("grid.gamma_f", setup.gamma_i.to_f64(), intervals, length.to_f64());
    check_nodes(Some(sbp), n_gamma, windows).and_then(|()| spaced()).map_err(|invalid| invalid.message)?;
    Ok(SceneSetup { limit: SceneLimit::Length(length), until: None, sbp, form, n_gamma, windows, ..setup.clone() })
}

fn observable<S: Real>(text: &GeometryText, formula: &str) -> Observable<S> {
    let place = FormulaPlace::Definition(String::new());
    Observable::new(formula, text, place).expect("a valid scene has valid formulas")
}
