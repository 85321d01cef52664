//! What a run says of itself, and what is true.

use std::sync::Arc;

use geodesic_ivp::case::{Case, End};
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::diagnostics::verdict::{CoordinateError, Facts, Grade, Verdict};
use geodesic_ivp::solve::WorldLine;
use geodesic_ivp::study::errors::run_error;
use geodesic_ivp::study::verdict::facts_of_run;
use geodesic_ivp::{Solution, solve};

use super::truth::Truth;

/// A run is compared with what is known to this share of its estimate, or to [`KNOWN`] relative to max(1, size).
const SHARE: f64 = 0.1;
const KNOWN: f64 = 1e-12;

/// A judged run.
pub(crate) struct Judged {
    pub(crate) verdict: Verdict,
    /// What is true of a result.
    pub(crate) found: Option<Found>,
}

/// What is true of a result.
pub(crate) enum Found {
    /// It is not known well enough.
    NoReference,
    Error {
        /// The largest error of a coordinate over the nodes, as a share of its estimate; infinite without an estimate.
        ratio: f64,
        /// Whether every estimate is small beside the motion.
        is_small: bool,
    },
}

impl Judged {
    pub(crate) fn of(case: &Case) -> Self {
        if case.is_of_x() { one(case) } else { scene(case) }
    }

    fn refused() -> Self {
        Self { verdict: Verdict::refused(), found: None }
    }

    fn new(facts: &Facts, found: Found) -> Self {
        let verdict = Verdict::new(facts);
        assert_ne!(verdict.grade, Grade::Refused);
        Self { verdict, found: Some(found) }
    }
}

/// A node: γ − γ_i and the coordinates, or what they differ by from the truth where that is not the one at this γ.
struct Node {
    gamma: f64,
    q: Vec<f64>,
}

fn one(case: &Case) -> Judged {
    let setup = case.setup::<f64>();
    let Ok(solution): Result<Solution, _> = solve(&setup) else { return Judged::refused() };
    let measures = Diagnostics::new(&solution);
    let error = run_error(&setup, &solution, &[]);
    let facts = facts_of_run(&solution, &measures, error.as_ref(), None);
    let length = solution.length;
    let Some(truth) = Truth::new(&solution.place.geometry, &solution.place.start, length) else {
        return Judged::new(&facts, Found::NoReference);
    };
    let elapsed = solution.t().map(|t| t - solution.t_i());
    let gamma = solution.gamma_from_start();
    let mut nodes: Vec<Node> =
        gamma.zip(elapsed.zip(solution.x())).map(|(gamma, (t, &x))| Node { gamma, q: vec![t, x] }).collect();
    if let End::Duration(duration) = case.end::<f64>()
        && let Some(last) = nodes.last_mut()
    {
        // The error of x at the time that was asked for.
        let exact = truth.at(last.gamma);
        let [t, x] = [exact[0], exact[1]];
        let velocity = solution.end_state().x_dot * solution.geometry().g00(&[0.0, x]).unwrap_or(f64::NAN)
            / solution.end_state().q_t;
        last.q = vec![t, last.q[1] - velocity * (duration - t)];
    }
    let found = compare(&facts, &truth, &nodes);
    Judged::new(&facts, found)
}

fn scene(case: &Case) -> Judged {
    let setup = case.setup::<f64>();
    let Ok(line): Result<WorldLine, _> = solve(&setup) else { return Judged::refused() };
    let diagnostics = Diagnostics::of(&line, &[], &mut [], case.is_lifted());
    let facts = facts_of_run(&line, &diagnostics, run_error(&setup, &line, &[]).as_ref(), None);
    let geometry = Arc::new(line.geometry().clone());
    let Some(truth) = Truth::new(&geometry, &line.place.start, line.length) else {
        return Judged::new(&facts, Found::NoReference);
    };
    let n = geometry.dimension();
    let mut rows: Vec<_> = (0..n).map(|a| line.q(a)).collect();
    let nodes: Vec<Node> = (line.gamma())
        .map(|gamma| Node { gamma: gamma - line.gamma_i, q: rows.iter_mut().filter_map(Iterator::next).collect() })
        .collect();
    let found = compare(&facts, &truth, &nodes);
    Judged::new(&facts, found)
}

fn compare(facts: &Facts, truth: &Truth, nodes: &[Node]) -> Found {
    let mut errors = vec![0.0_f64; truth.uncertain.len()];
    for node in nodes {
        let exact = truth.at(node.gamma);
        for (error, (q, exact)) in errors.iter_mut().zip(node.q.iter().zip(exact)) {
            let here = (q - exact).abs();
            *error = if here <= *error || error.is_nan() { *error } else { here };
        }
    }
    let Some(estimates) = &facts.errors else {
        return Found::Error { ratio: f64::INFINITY, is_small: false };
    };
    let known = |(estimate, uncertain): (&CoordinateError, &f64)| {
        *uncertain <= (SHARE * estimate.largest).max(KNOWN * estimate.size.max(1.0))
    };
    if !estimates.iter().zip(&truth.uncertain).all(known) {
        return Found::NoReference;
    }
    let ratio = |(estimate, (error, uncertain)): (&CoordinateError, (&f64, &f64))| {
        let beyond = error - uncertain;
        if beyond <= 0.0 { 0.0 } else { beyond / estimate.largest }
    };
    let ratios = estimates.iter().zip(errors.iter().zip(&truth.uncertain)).map(ratio);
    Found::Error {
        ratio: ratios.fold(0.0, |most, ratio| if ratio <= most || most.is_nan() { most } else { ratio }),
        is_small: estimates.iter().all(|estimate| estimate.largest <= estimate.allowed()),
    }
}
