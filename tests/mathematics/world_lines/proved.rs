//! What a proof makes of the verdict of a run.

use geodesic_ivp::Case;
use geodesic_ivp::diagnostics::verdict::Grade;
use geodesic_ivp::study::proof::prove_run;
use geodesic_ivp::study::run::{Judged, Run, Wanted, run};

use crate::common::parsed;

/// Judges a run as if its errors at the end were these times what they are, and then by a proof.
fn judged(case: &Case, run: &Run, factor: f64) -> Judged {
    let mut judged = run.judged(&case.setup(), false, false);
    let mut honest = run.judged(&case.setup(), false, false);
    prove_run(case, run, &mut honest, f64::INFINITY, &mut |_| true);
    let ends = honest.proof.expect("it was asked for").ends;
    let error = judged.error.as_mut().expect("a second solve reaches the end");
    for (name, (end, own)) in run.line.geometry().names().iter().zip(error.end.iter_mut().zip(&mut error.own)) {
        let proved = ends.iter().find(|end| end.name == *name);
        (*end, *own) = (proved.map_or(0.0, |end| factor * end.run_off_by), 0.0);
    }
    prove_run(case, run, &mut judged, f64::INFINITY, &mut |_| true);
    judged
}

/// The run is off by 1e-3, of which an estimate knows all, nearly all, or nothing.
#[test]
fn a_proof_that_contradicts_the_estimate_makes_the_run_doubtful() {
    let text = "potential.formula = \"x^4/2\"\npotential.coordinates = [\"x\"]\nscheme.sbp = \"SBP42\"\n\
                initial = { x = 1, t_dot = 1, x_dot = 0.1 }\ngrid = { n_gamma = 32, gamma_f = 1 }";
    let case = parsed(text, &[]);
    let run = run::<f64>(&case, &case.setup(), Wanted::default()).0.unwrap_or_else(|none| panic!("{none:?}"));
    for (factor, is_doubtful) in [(1.01, false), (0.98, true), (0.0, true)] {
        let judged = judged(&case, &run, factor);
        let said = judged.verdict.reasons.first().map(ToString::to_string).unwrap_or_default();
        let is_said = said.contains("more than the estimate of the run");
        assert_eq!(is_said, is_doubtful, "{factor}: {said}");
        assert_eq!(judged.suspicions.contains(&said), is_doubtful, "{factor}: {:?}", judged.suspicions);
        if is_doubtful {
            assert_eq!(judged.verdict.grade, Grade::Doubtful);
            assert!(said.starts_with("the proved end is ") && said.contains(" away in "), "{said}");
        }
    }
}
