//! The [`Verdict`] on a run of one coordinate, and on one of a scene.
//!
//! ```
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::diagnostics::Diagnostics;
//! use geodesic_ivp::diagnostics::verdict::Grade;
//! use geodesic_ivp::solve::Setup;
//! use geodesic_ivp::study::errors::run_error;
//! use geodesic_ivp::study::verdict::of_solution;
//! use geodesic_ivp::{Case, Solution, solve};
//!
//! let text = builtin::text("quartic").expect("it is built in");
//! for (nodes, grade) in [(32, Grade::Trusted), (5, Grade::Doubtful)] {
//!     let case = Case::parse("quartic", text, &[format!("grid.n_gamma={nodes}")])?;
//!     let solution: Solution = solve(&case)?;
//!     let measures = Diagnostics::new(&solution).measures;
//!     let verdict = of_solution(&solution, &measures, run_error(&Setup::from(&case), &solution, &[]).as_ref());
//!     assert_eq!(verdict.grade, grade, "{}", verdict.line());
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::errors::RunError;
use crate::diagnostics::scene::SceneMeasures;
use crate::diagnostics::verdict::{CoordinateError, Facts, Verdict, largest};
use crate::diagnostics::{Diagnostics, Measures};
use crate::number::Real;
use crate::solve::{Solution, WorldLine};
use crate::study::errors::Reach;

/// The verdict on `solution`, from what was measured on it and its error, if that is known.
pub fn of_solution<S: Real>(solution: &Solution<S>, measures: &Measures<S>, error: Option<&RunError>) -> Verdict {
    Verdict::new(&facts_of_solution(solution, measures, error))
}

/// The verdict on `line`, from what was measured on it and its error, if that is known. The estimate of a run to an
/// accuracy may be contradicted by a reference, if there is one.
pub fn of_world_line<S: Real>(
    line: &WorldLine<S>,
    diagnostics: &Diagnostics<S, SceneMeasures<S>>,
    error: Option<&RunError>,
    reference: Option<&RunError>,
) -> Verdict {
    Verdict::new(&facts_of_world_line(line, diagnostics, error, reference))
}

/// What [`of_solution`] judges.
pub fn facts_of_solution<S: Real>(solution: &Solution<S>, measures: &Measures<S>, error: Option<&RunError>) -> Facts {
    let [least, most] = measures.scales.x_range;
    let duration = solution.duration().to_f64().abs();
    let reaches =
        [Reach { size: duration, range: duration }, Reach { size: least.abs().max(most.abs()), range: most - least }];
    let reaches = own_sizes(reaches, &solution.sizes);
    let shared = reaches.map(|reach| reach.size);
    let coordinates = |error: &RunError| {
        let names = solution.geometry().names();
        coordinate_errors(names, &reaches, &shared, &error.at_most_at_end(), &error.at_most())
    };
    Facts {
        errors: error.map(coordinates),
        accuracy: solution.accuracy,
        good_until: solution.good_until.map(|until| solution.gamma_i.to_f64() + until),
        reference: None,
        stepped_over: error.map_or(0.0, |error| error.stepped_over),
        digits: solution.digits,
        suspicions: measures.suspicions(solution),
    }
}

/// What [`of_world_line`] judges.
pub fn facts_of_world_line<S: Real>(
    line: &WorldLine<S>,
    diagnostics: &Diagnostics<S, SceneMeasures<S>>,
    error: Option<&RunError>,
    reference: Option<&RunError>,
) -> Facts {
    let (geometry, n) = (line.geometry(), line.geometry().dimension());
    let reaches = own_sizes((0..n).map(|a| Reach::new(line, a)).collect::<Vec<_>>(), &line.sizes);
    let sizes: Vec<f64> = reaches.iter().map(|reach| reach.size).collect();
    let shared = geometry.shared(&line.place.start.q, &sizes);
    let errors = |end: &[f64], most: &[f64]| coordinate_errors(geometry.names(), &reaches, &shared, end, most);
    let found = |error: &RunError| errors(&error.at_most_at_end(), &error.at_most());
    let relative = |error: &RunError| {
        let shares = error.largest.iter().zip(&line.sizes).filter(|(_, size)| **size > 0.0);
        let shares = shares.map(|(error, size)| error / size);
        [largest(shares), error.judge.relative_error()]
    };
    Facts {
        errors: error.map(found),
        accuracy: line.accuracy,
        good_until: line.good_until.map(|until| line.gamma_i.to_f64() + until),
        reference: reference.map(relative),
        stepped_over: error.map_or(0.0, |error| error.stepped_over),
        digits: line.digits,
        suspicions: diagnostics.suspicions(line),
    }
}

/// The same with the sizes that a run to an accuracy has found, if it is one.
fn own_sizes<R: AsMut<[Reach]>>(mut reaches: R, sizes: &[f64]) -> R {
    reaches.as_mut().iter_mut().zip(sizes).for_each(|(reach, &size)| reach.size = size);
    reaches
}

/// The errors of all coordinates, with the size that each shares with others of its unit.
fn coordinate_errors(
    names: &[String],
    reaches: &[Reach],
    shared: &[f64],
    end: &[f64],
    largest: &[f64],
) -> Vec<CoordinateError> {
    let of = |(a, &Reach { size, range }): (usize, &Reach)| CoordinateError {
        name: names[a].clone(),
        end: end[a],
        largest: largest[a],
        size,
        range,
        shared: shared[a],
    };
    reaches.iter().enumerate().map(of).collect()
}
