//! Statements about motions that one can cite: each is a theorem that a proof shows.

use geodesic_ivp::case::builtin;
use geodesic_ivp::study::proof::{ProofOfRun, Status, prove_run};
use geodesic_ivp::study::run::{Judged, Wanted, run};

use crate::common::parsed;

/// A run that is judged, and then by a proof.
fn judged(text: &str, set: &[&str]) -> Judged {
    let case = parsed(text, set);
    let setup = case.setup();
    let run = run::<f64>(&case, &setup, Wanted::default()).0.unwrap_or_else(|none| panic!("{set:?}: {none:?}"));
    let mut judged = run.judged(&setup, false, false);
    prove_run(&case, &run, &mut judged, f64::INFINITY, &mut |_| true);
    judged
}

fn proof(judged: &Judged) -> &ProofOfRun {
    let proof = judged.proof.as_ref().expect("it was asked for");
    assert_eq!(proof.status, Status::Proved, "{proof:?}");
    proof
}

/// Light from r = 50 M falls into a black hole if its impact parameter is below √27 M by a part in 1e10, and escapes if
/// it is above by as much (C. Darwin, Proc. R. Soc. A 249 (1959) 180). Errors grow to 1e10 of what they were.
#[test]
fn light_is_captured_below_the_critical_impact_parameter_and_escapes_above_it() {
    let text = r#"
        metric.preset = "schwarzschild"
        parameters = { e = 1e-10, b = "sqrt(27)*(1 - e)" }
        initial = { r = 50.0, p_t = 1.0, p_phi = "-b", norm = "null", solve = { r_dot = "-" } }
        grid.gamma_f = 250.0
        solver.tolerance = 1e-12
        events.captured = { when = "r - 2.05", direction = "down", until = true }
        events.escaped = { when = "r - 50", direction = "up", until = true }
    "#;
    for (e, wanted) in [("1e-10", "captured"), ("-1e-10", "escaped")] {
        let judged = judged(text, &[&format!("parameters.e={e}")]);
        assert_eq!(proof(&judged).ended_by.as_deref(), Some(wanted), "{e}");
    }
}

/// More than a hundred points of a curve that a regular orbit of Hénon and Heiles' fills in its section x = 0.
#[test]
fn a_hundred_points_of_an_invariant_curve_are_proved() {
    let text = builtin::text("henon-heiles").expect("it is built in");
    let judged = judged(text, &["solver.accuracy=1e-12", "grid.gamma_f=620", "solver.error=false"]);
    let events = &proof(&judged).events;
    let y = 2;
    let most =
        events.iter().map(|radii| radii.as_ref().map_or(f64::INFINITY, |radii| radii[1 + y])).fold(0.0, f64::max);
    assert!(events.len() > 100 && most < 1e-12, "{} points, {most:e}", events.len());
}
