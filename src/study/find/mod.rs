//! The search for numbers of a case with which its run meets conditions: formulas of its end that are zero, a motion
//! that returns, or the data that it lies nearest to.
//!
//! ```
//! use geodesic_ivp::Case;
//! use geodesic_ivp::study::find::find;
//!
//! // A stone is to fall on a place 3 away after one unit of time.
//! let text = r#"
//!     potential = { coordinates = ["x", "y"], formula = "9.81*y" }
//!     particle.law = "newtonian"
//!     initial = { x = 0.0, y = 0.0, x_dot = 1.0, y_dot = 1.0 }
//!     grid.t_f = 1.0
//!     solver.accuracy = 1e-12
//!     find = { unknowns = ["initial.x_dot", "initial.y_dot"], meet = ["x - 3", "y"] }
//! "#;
//! let case = Case::parse("stone", text, &[])?;
//! let wanted = case.find.as_ref().expect("there is something to find");
//! let found = find(&case, wanted, false, &mut |_| {}).map_err(|none| none.message)?;
//! assert!((found.values[0] - 3.0).abs() < 1e-12 && (found.values[1] - 0.5 * 9.81).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod chain;
mod existence;
mod fit;
mod follow;
mod geodesic;
mod jacobian;
mod least_squares;
mod multipliers;
mod newton;
mod problem;
mod starts;
mod states;

pub use existence::Existence;
pub use fit::Fit;
pub use follow::{Ended, Family, Member, follow};
pub use geodesic::Geodesic;
pub use multipliers::Multipliers;
pub use starts::{FromStart, find_each, solutions};

use self::existence::exists;
use self::newton::{Converged, search};
use self::problem::Problem;
use self::states::Residuals;
use crate::case::{Case, Find, Goal};

/// A point of the search.
#[derive(Debug, Clone, PartialEq)]
pub struct Iterate {
    /// Its number, from 0 for the start.
    pub iteration: usize,
    /// The values of the unknowns.
    pub values: Vec<f64>,
    /// The residuals: of data in standard deviations.
    pub residuals: Vec<f64>,
    /// The length of the full step from here, every unknown divided by its value in the case, or by 1 where that is 0.
    pub step: f64,
    /// The part of the full step that led here; none at the start.
    pub damping: Option<f64>,
}

/// The root of the sum of the squares of residuals.
pub fn norm(residuals: &[f64]) -> f64 {
    residuals.iter().map(|residual| residual * residual).sum::<f64>().sqrt()
}

/// What was found.
#[derive(Debug)]
pub struct Found {
    /// The case with the numbers that were found, which has nothing to find any more.
    pub case: Case,
    /// The values of the unknowns.
    pub values: Vec<f64>,
    /// By how much each may be off: what the error of the end of the run makes of it, and the step that was left. In a
    /// direction that is not determined nothing is said.
    pub errors: Vec<f64>,
    /// The names of the residuals, none of data; their values; and by how much the error of the run may change each.
    pub residuals: Vec<(String, f64, f64)>,
    /// True if they vanish up to these errors; false if only the sum of their squares is least.
    pub is_met: bool,
    /// The number of directions of the unknowns that are determined.
    pub rank: usize,
    /// The condition of the linear system in unknowns of size 1.
    pub condition: f64,
    /// The unknowns whose derivatives are differences of runs.
    pub differenced: Vec<String>,
    /// The multipliers of a motion that was to return, if the run carries the linearised equations.
    pub multipliers: Option<Multipliers>,
    /// The statistics of a fit to data.
    pub fit: Option<Fit>,
    /// The length of a geodesic, and what is conjugate to its start.
    pub geodesic: Option<Geodesic>,
    /// The proof that there are such numbers, if one was asked for, or why there is none.
    pub existence: Option<Result<Existence, String>>,
}

/// The reason why nothing was found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct NotFound {
    /// The reason.
    pub message: String,
    /// A remedy.
    pub advice: String,
    /// True if the first run leaves the domain.
    pub is_outside: bool,
}

impl NotFound {
    fn at_start(message: &str, is_outside: bool) -> Self {
        let message = format!("there is no run to begin with: {message}");
        Self { message, advice: "begin with other numbers".to_owned(), is_outside }
    }

    fn on_the_way(message: &str, advice: &str) -> Self {
        Self { message: message.to_owned(), advice: advice.to_owned(), is_outside: false }
    }
}

/// Searches for what `wanted`, the table of `case`, asks for, and if it `proves` looks for a proof that what was found
/// exists. `tell` hears of every iterate.
///
/// # Errors
/// [`NotFound`], with the reason.
pub fn find(case: &Case, wanted: &Find, proves: bool, tell: &mut dyn FnMut(Iterate)) -> Result<Found, NotFound> {
    let problem = Problem::new(case, wanted);
    let Converged { here, jacobian, inverse, errors, is_met } = search(&problem, tell)?;
    let names = Residuals::new(&here.case, &wanted.goal).map_or_else(Vec::new, |states| states.names());
    let decimals: Vec<String> = here.values.iter().map(|value| format!("{value:?}")).collect();
    let keys = wanted.unknowns.iter().map(|unknown| unknown.key.clone());
    let residuals = names.into_iter().zip(&here.residuals).zip(&here.errors);
    let existence = proves.then(|| exists(&problem, &here.values, &errors));
    let is_between = matches!(wanted.goal, Goal::Meet(_));
    Ok(Found {
        existence,
        geodesic: if is_between { Geodesic::new(&here.case, &here.run) } else { None },
        case: problem.case(&decimals, false).expect("it was solved with these numbers"),
        errors,
        residuals: residuals.map(|((name, residual), error)| (name, *residual, *error)).collect(),
        is_met,
        rank: inverse.rank,
        condition: inverse.condition,
        differenced: keys.zip(&jacobian.is_difference).filter(|(_, is)| **is).map(|(key, _)| key).collect(),
        multipliers: if wanted.goal == Goal::Periodic { Multipliers::new(&here.run.line) } else { None },
        fit: if let Goal::Data(data) = &wanted.goal {
            Some(Fit::new(data, &here.residuals, &inverse.matrix, here.run.line.geometry().names()))
        } else {
            None
        },
        values: here.values,
    })
}
