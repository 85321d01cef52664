//! What rests where a force jumps: it is doubted if it may stay and leave, and not if it can do one of them only.

use crate::common::parsed;
use geodesic_ivp::diagnostics::verdict::Grade;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::study::run::{Wanted, run};

/// Whether a run of two coordinates, from rest at (x, 0) or with y moving at `y_dot`, is doubted for two motions. A
/// force acts on x, and on y the one that `force_y` is.
fn is_undecided<S: Real>([force, force_y]: [&str; 2], [x, y_dot]: [&str; 2], further: &str) -> bool {
    let text = format!(
        "potential.coordinates = [\"x\", \"y\"]\npotential.formula = \"0\"\n\
         potential.force = {{ x = \"{force}\", y = \"{force_y}\" }}\n\
         particle.law = \"newtonian\"\nparticle.masses = {{ x = 1.0, y = 100.0 }}\n\
         initial = {{ t = 2.0, x = {x}, y = 0.0, x_dot = 0.0, y_dot = {y_dot} }}\ngrid.t_f = 2.5\n"
    );
    let case = parsed(&text, &further.split(' ').collect::<Vec<_>>());
    let setup = case.setup::<S>();
    let found = run(&case, &setup, Wanted::default()).0.unwrap_or_else(|none| panic!("{force}: {none:?}"));
    let judged = found.judged(&setup, false, false);
    let told = judged.verdict.reasons.iter().any(|reason| reason.reason.contains("it may stay and it may leave"));
    assert!(!told || judged.verdict.grade == Grade::Doubtful, "{force}");
    told
}

const ACCURATE: &str = "solver.accuracy=1e-8";
const GIVEN: &str = "grid.n_gamma=16 grid.windows=4 scheme.sbp=GLL16 scheme.form=weak";

#[test]
fn a_motion_that_may_stay_and_leave_is_doubted() {
    for forces in [
        ["sign(x)", "0"],
        ["sign(x) + 1/2", "0"],
        ["step(x)", "0"],
        ["sign(x_dot)", "0"],
        ["sign(x - y)", "-sign(x - y)"],
        ["sign(y)", "sign(x)"],
        ["sign(x)*abs(x)^0.4", "0"],
    ] {
        assert!(is_undecided::<f64>(forces, ["0.0", "0.0"], ACCURATE), "{forces:?}");
        assert!(is_undecided::<f64>(forces, ["0.0", "0.0"], GIVEN), "{forces:?}");
    }
    assert!(is_undecided::<f64>(["sign(x - 0.1)", "0"], ["0.1", "0.0"], ACCURATE));
    assert!(is_undecided::<Extended>(["sign(x)", "0"], ["0.0", "0.0"], &format!("{GIVEN} solver.digits=30")));
}

#[test]
fn a_motion_that_is_the_only_one_is_not() {
    for forces in [
        ["-sign(x)", "0"],
        ["sign(x)*x^2", "0"],
        ["max(x, 0)", "0"],
        ["x", "sign(x - 1)"],
        ["-sign(x - 3*y)", "0"],
        ["-sign(x - 3*y)", "3*sign(x - 3*y)"],
        ["-sign(x_dot)", "0"],
        ["abs(x) + 1", "0"],
    ] {
        assert!(!is_undecided::<f64>(forces, ["0.0", "0.0"], ACCURATE), "{forces:?}");
    }
    // What moves has left the place at once, and what is beside it is on one side.
    assert!(!is_undecided::<f64>(["sign(x - y)", "0"], ["0.0", "0.7"], ACCURATE));
    assert!(!is_undecided::<f64>(["sign(x)", "0"], ["1e-9", "0.0"], ACCURATE));
}
