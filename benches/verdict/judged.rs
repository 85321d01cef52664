//! The judge compares the verdict of a run with its true error.

use std::sync::Arc;

use geodesic_ivp::case::Case;
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::diagnostics::verdict::{CoordinateError, Grade, Verdict, VerdictInput};
use geodesic_ivp::solve;
use geodesic_ivp::solve::WorldLine;
use geodesic_ivp::study::errors::run_error;
use geodesic_ivp::study::facts::facts_of_run;
use geodesic_ivp::trajectory::Sampler;

use super::truth::Truth;

/// A run is compared with what is known to this share of its estimate, or to [`KNOWN`] relative to max(1, size).
const SHARE: f64 = 0.1;
const KNOWN: f64 = 1e-12;

/// A judged run.
pub(crate) struct Judged {
    pub(crate) verdict: Verdict,
    /// The truth about its result.
    pub(crate) found: Option<Found>,
    /// The accuracy that was promised, as a multiple of the estimate.
    promised: f64,
}

/// The truth about a result.
pub(crate) enum Found {
    /// It is not known well enough.
    NoReference,
    Error {
        /// The largest error of a coordinate over all places, as a share of its estimate; infinite without an estimate.
        ratio: f64,
        /// True if every estimate is small beside the motion.
        is_small: bool,
    },
}

impl Judged {
    pub(crate) fn of(case: &Case) -> Self {
        let setup = case.setup::<f64>();
        // A scene is judged at equal γ.
        let t_f = case.t_f::<f64>().filter(|_| case.is_of_x);
        let duration = t_f.map(|t_f| t_f - case.value::<f64>(&case.initial.q[0]));
        let Ok(line): Result<WorldLine, _> = solve(&setup) else {
            return Self { verdict: Verdict::refused(), found: None, promised: f64::INFINITY };
        };
        let error = run_error(&setup, &line, &[]);
        let diagnostics = Diagnostics::of(&line, &[], &mut [], case.is_lifted());
        let facts = facts_of_run(&line, &diagnostics, error.as_ref(), None);
        let verdict = Verdict::new(&facts);
        assert_ne!(verdict.grade, Grade::Refused);
        let truth = Truth::new(&Arc::new(line.geometry().clone()), &line.place.start, line.length);
        let found = truth.map_or(Found::NoReference, |truth| {
            let mut nodes = nodes(&line, setup.origin);
            if let (Some(duration), Some(last)) = (duration, nodes.iter_mut().find(|node| node.is_last)) {
                // The error of x at the time that was asked for.
                let exact = truth.at(last.gamma);
                let end = line.end_state();
                let velocity = end.x_dot * line.geometry().g00(&[0.0, exact[1]]).unwrap_or(f64::NAN) / end.q_t;
                last.q = vec![exact[0], last.q[1] - velocity * (duration - exact[0])];
            }
            compare(&facts, &truth, &nodes)
        });
        let promised = setup.settings.accuracy.zip(line.error_estimate);
        let promised = promised.map_or(f64::INFINITY, |(accuracy, estimate)| accuracy.value() / estimate);
        Self { verdict, found: Some(found), promised }
    }

    /// Returns true if the error is above the accuracy that was asked for.
    pub(crate) fn is_broken(&self) -> bool {
        matches!(self.found, Some(Found::Error { ratio, .. }) if ratio > self.promised)
    }
}

/// A node: γ − γ_i and the coordinates, or what they differ by from the truth where that is not the one at this γ.
struct Node {
    gamma: f64,
    q: Vec<f64>,
    is_last: bool,
}

/// The nodes of a run and, where it promises an accuracy, places half way between them; coordinates are from `origin`.
fn nodes(line: &WorldLine, origin: Option<(usize, f64)>) -> Vec<Node> {
    let from = |mut q: Vec<f64>| {
        origin.iter().for_each(|&(a, origin)| q[a] -= origin);
        q
    };
    let mut rows: Vec<_> = (0..line.geometry().dimension()).map(|a| line.q(a)).collect();
    let mut of_node = || from(rows.iter_mut().filter_map(Iterator::next).collect());
    let mut nodes: Vec<Node> =
        line.gamma_from_start().map(|gamma| Node { gamma, q: of_node(), is_last: false }).collect();
    nodes.iter_mut().last().expect("a run has nodes").is_last = true;
    if line.error_estimate.is_some() {
        let (gammas, mut sampler): (Vec<f64>, _) = (line.gamma().collect(), Sampler::new(line));
        for pair in gammas.windows(2) {
            let sample = sampler.at_gamma(0.5 * (pair[0] + pair[1])).expect("it is inside the run");
            nodes.push(Node { gamma: sample.gamma - line.gamma_i, q: from(sample.q), is_last: false });
        }
    }
    nodes
}

fn compare(facts: &VerdictInput, truth: &Truth, nodes: &[Node]) -> Found {
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
