//! The [`Verdict`] on a run of one coordinate, and on one of a scene.
//!
//! ```
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::diagnostics::Diagnostics;
//! use geodesic_ivp::diagnostics::verdict::Grade;
//! use geodesic_ivp::study::run_error::run_error;
//! use geodesic_ivp::study::verdict::of_solution;
//! use geodesic_ivp::{Case, Solution, solve};
//!
//! let text = builtin::text("quartic").expect("it is built in");
//! for (nodes, grade) in [(32, Grade::Trusted), (5, Grade::Doubtful)] {
//!     let case = Case::parse("quartic", text, &[format!("grid.n_gamma={nodes}")])?;
//!     let solution: Solution = solve(&case)?;
//!     let measures = Diagnostics::new(&solution).measures;
//!     let verdict = of_solution(&solution, &measures, run_error(&case, &solution).as_ref());
//!     assert_eq!(verdict.grade, grade, "{}", verdict.line());
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::run_error::RunError;
use crate::Numeric;
use crate::diagnostics::Measures;
use crate::diagnostics::scene::SceneDiagnostics;
use crate::diagnostics::verdict::{CoordinateError, Facts, Verdict, largest};
use crate::errors::SceneError;
use crate::solve::{Solution, WorldLine};

/// The verdict on `solution`, from what was measured on it and its error, if that is known.
pub fn of_solution<S: Numeric>(solution: &Solution<S>, measures: &Measures<S>, error: Option<&RunError>) -> Verdict {
    Verdict::new(&facts_of_solution(solution, measures, error))
}

/// The verdict on `line`, from what was measured on it and its distance from a reference, if there is one. With an
/// accuracy the run's own estimate is judged; a reference may contradict it.
pub fn of_world_line<S: Numeric>(
    line: &WorldLine<S>,
    diagnostics: &SceneDiagnostics<S>,
    error: Option<&SceneError>,
) -> Verdict {
    Verdict::new(&facts_of_world_line(line, diagnostics, error))
}

/// What [`of_solution`] judges.
pub fn facts_of_solution<S: Numeric>(
    solution: &Solution<S>,
    measures: &Measures<S>,
    error: Option<&RunError>,
) -> Facts {
    let [least, most] = measures.scales.x_range;
    let duration = solution.duration().to_f64().abs();
    let motions = [("t", duration, duration), ("x", least.abs().max(most.abs()), most - least)];
    let coordinates = |error: &RunError| {
        let of = |(k, (name, size, range)): (usize, (&str, f64, f64))| CoordinateError {
            name: name.to_owned(),
            end: error.end[k],
            largest: error.largest[k],
            size,
            range,
            shared: size,
        };
        motions.into_iter().enumerate().map(of).collect()
    };
    Facts {
        errors: error.map(coordinates),
        accuracy: solution.accuracy,
        reference: None,
        stepped_over: error.map_or(0.0, |error| error.stepped_over),
        digits: solution.digits,
        suspicions: measures.suspicions(solution),
    }
}

/// What [`of_world_line`] judges.
pub fn facts_of_world_line<S: Numeric>(
    line: &WorldLine<S>,
    diagnostics: &SceneDiagnostics<S>,
    error: Option<&SceneError>,
) -> Facts {
    let (geometry, n) = (line.geometry(), line.geometry().dimension());
    let motions: Vec<Motion> = (0..n).map(|a| Motion::new(line, a)).collect();
    let sizes: Vec<f64> = motions.iter().map(|motion| motion.size).collect();
    let shared = geometry.shared(&line.place.start.q, &sizes);
    let coordinate = |a: usize, end: f64, most: f64| {
        let (name, Motion { size, range }) = (geometry.names()[a].clone(), motions[a]);
        CoordinateError { name, end, largest: most, size, range, shared: shared[a] }
    };
    let own = |estimate: f64| {
        let of = |a: usize| coordinate(a, estimate * sizes[a].max(1.0), estimate * sizes[a].max(1.0));
        (0..n).map(of).collect()
    };
    let found = |error: &SceneError| {
        let of = |a: usize| {
            let of_reference = error.reference * shared[a];
            coordinate(a, error.end[a] + of_reference, error.largest[a] + of_reference)
        };
        (0..n).map(of).collect()
    };
    let relative = |error: &SceneError| {
        let shares = error.largest.iter().zip(&sizes).map(|(error, size)| error / size.max(1.0));
        [largest(shares), error.reference]
    };
    Facts {
        errors: match line.error_estimate {
            Some(estimate) => Some(own(estimate)),
            None => error.map(found),
        },
        accuracy: line.accuracy,
        reference: line.error_estimate.and(error).map(relative),
        stepped_over: error.map_or(0.0, |error| error.stepped_over),
        digits: line.digits,
        suspicions: diagnostics.suspicions(line),
    }
}

/// How far a coordinate goes.
#[derive(Clone, Copy)]
struct Motion {
    size: f64,
    range: f64,
}

impl Motion {
    fn new<S: Numeric>(line: &WorldLine<S>, a: usize) -> Self {
        let origin = if line.geometry().active().contains(&a) { S::ZERO } else { line.place.start.q[a] };
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for q in line.q(a) {
            let q = (q - origin).to_f64();
            (least, most) = (least.min(q), most.max(q));
        }
        Self { size: least.abs().max(most.abs()), range: most - least }
    }
}
