//! What rests where a force jumps: it is doubted if it may stay and leave, and not if it can do one of them only.

use crate::common::parsed;
use crate::random_scenes::random::Random;
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
    let case = parsed(&text, &further.split(' ').chain([HILL]).collect::<Vec<_>>());
    let setup = case.setup::<S>();
    let found = run(&case, &setup, Wanted::default()).0.unwrap_or_else(|none| panic!("{force}: {none:?}"));
    let judged = found.judged(&setup, false, false);
    let told = judged.verdict.reasons.iter().any(|reason| reason.reason.contains("it may stay and it may leave"));
    assert!(!told || judged.verdict.grade == Grade::Doubtful, "{force}");
    told
}

const HILL: &str = "tables.hill={x=[-9.0,0.0,1.0,9.0],y=[0.0,0.0,0.5,0.0]}";
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
        ["sqrt(abs(x))", "0"],
        ["sign(x)*abs(x)^0.99", "0"],
        ["sign(x)*abs(x)^0.99 + x", "0"],
        ["sign(x) + hill(y)", "hill(y)"],
        ["max(sign(x), 0) + min(sign(x), 0)", "0"],
        ["sign(sign(x))", "0"],
        ["sign(x^3)", "0"],
        ["sign(x^3) + 0.1", "0"],
        ["step(x^3) - 0.5", "0"],
        ["sign(x*abs(x))", "0"],
        ["max(sign(x_dot), 0)", "0"],
        ["sign(x^3 + x_dot^3)", "0"],
        ["max(step(x) - 0.5, 0)", "0"],
        ["sign(max(x, 0)) - sign(max(-x, 0))", "0"],
        ["3*sign(x - (t - 2)^2)", "0"],
        ["(t - 2)^2*sign(x)", "0"],
        ["step(t - 2.2)*sign(x)", "0"],
        ["sign(x + y)/2 - 1/9", "1"],
    ] {
        assert!(is_undecided::<f64>(forces, ["0.0", "0.0"], ACCURATE), "{forces:?}");
        assert!(is_undecided::<f64>(forces, ["0.0", "0.0"], GIVEN), "{forces:?}");
    }
    assert!(is_undecided::<f64>(["sign(x - 0.1)", "0"], ["0.1", "0.0"], ACCURATE));
    assert!(is_undecided::<f64>(["sqrt(abs(x - 0.1))", "0"], ["0.1", "0.0"], ACCURATE));
    assert!(is_undecided::<Extended>(["sign(x)", "0"], ["0.0", "0.0"], &format!("{GIVEN} solver.digits=30")));
}

/// A body that rests after friction may have moved before, and a force that leads away does so on both ways.
#[test]
fn on_the_way_back_friction_leads_away() {
    let back = format!("{ACCURATE} grid.t_f=1.5");
    let told = |force: &str| is_undecided::<f64>([force, "0"], ["0.0", "0.0"], &back);
    assert!(told("-sign(x_dot)") && told("sign(x)") && told("-sign(x_dot)/3 + hill(x)"));
    assert!(told("-max(sign(x_dot), 0) - min(sign(x_dot), 0)") && told("-sign(x_dot^3)"));
    assert!(!told("sign(x_dot)") && !told("-sign(x)") && !told("2 - sign(x_dot)"));
}

#[test]
fn a_start_at_rest_on_a_kink_of_a_potential_is_doubted_on_its_top_only() {
    let tops = ["-abs(x)", "-max(x, 0)", "-max(min(x, 1), -x)", "-min(max(x, -x), 5)", "-max(x, max(-x, 0))"];
    let others = ["abs(x)", "max(x, 0)", "max(min(x, 1), -x)", "max(x, x^2)", "-abs(x - 1)", "x - max(x, 0)/2"];
    for (potential, is_top) in tops.map(|top| (top, true)).into_iter().chain(others.map(|other| (other, false))) {
        let text = format!(
            "potential.coordinates = [\"x\"]\npotential.formula = \"{potential}\"\nparticle.law = \"newtonian\"\n\
             initial = {{ x = 0.0, x_dot = 0.0 }}\ngrid.t_f = 0.5\nsolver.accuracy = 1e-8"
        );
        let case = parsed(&text, &[]);
        let setup = case.setup::<f64>();
        // In a hollow it may be refused, where it stays.
        let Ok(found) = run(&case, &setup, Wanted::default()).0 else {
            assert!(!is_top, "{potential}");
            continue;
        };
        let reasons = found.judged(&setup, false, false).verdict.reasons;
        let told = reasons.iter().any(|reason| reason.reason.contains("it may stay and it may leave"));
        assert_eq!(told, is_top, "{potential}: {reasons:?}");
    }
}

/// What comes to rest on a ridge may go on, stay and return: rounding decides what a run shows.
#[test]
fn a_ridge_that_is_reached_at_rest_is_no_run_to_trust() {
    let (mut random, mut doubtful) = (Random(5), 0);
    for draw in 0..60 {
        // Quarters, so that many of the starts are doubles.
        let [push, speed] = [(); 2].map(|()| (1 + (random.next() >> 11) % 12) as f64 / 4.0);
        let top = [0.0, 0.3, 1.0, -0.25][draw % 4];
        let text = format!(
            "potential.coordinates = [\"x\"]\npotential.formula = \"-{push}*abs(x - ({top}))\"\n\
             particle.law = \"newtonian\"\ninitial = {{ x = {:?}, x_dot = {speed} }}\ngrid.t_f = {:?}\n\
             solver.accuracy = 1e-{}",
            top - speed * speed / (2.0 * push),
            1.5 * speed / push,
            4 + draw % 10
        );
        let case = parsed(&text, &[]);
        let setup = case.setup::<f64>();
        // It may be refused.
        let Ok(found) = run(&case, &setup, Wanted::default()).0 else { continue };
        assert_eq!(found.judged(&setup, false, false).verdict.grade, Grade::Doubtful, "{text}");
        doubtful += 1;
    }
    assert!(doubtful > 0);
}

/// A ball that is brought to rest on a ridge, and one under which the ridge is turned on.
#[test]
fn what_an_event_leaves_on_a_ridge_is_doubted() {
    let told = |event: &str| {
        let text = format!(
            "potential.coordinates = [\"x\"]\npotential.formula = \"-k*abs(x)\"\nparticle.law = \"newtonian\"\n\
             parameters.k = 1.0\ninitial = {{ x = 1.0, x_dot = 0.0 }}\nsolver.accuracy = 1e-8\ngrid.t_f = 1.0\n\
             [events]\nstop = {{ when = \"t - 0.5\", set = {{ {event} }} }}"
        );
        let case = parsed(&text, &[]);
        let setup = case.setup::<f64>();
        // It may be refused.
        let Ok(found) = run(&case, &setup, Wanted::default()).0 else { return false };
        let reasons = found.judged(&setup, false, false).verdict.reasons;
        reasons.iter().any(|reason| reason.reason.starts_with("at gamma = 0.500000 the motion is where a force"))
    };
    assert!(told("x = \"0\", x_dot = \"0\""));
    assert!(!told("x = \"0\", x_dot = \"1\"") && !told("x = \"0.1\", x_dot = \"0\""));
    assert!(!told("x = \"0\", x_dot = \"0\", k = \"-1\""));
}

/// The place where an event leaves a body is a double, and the ridge there may be none.
#[test]
fn what_an_event_leaves_beside_a_ridge_by_rounding_is_doubted() {
    for (top, force) in
        [("0.3", "-2.5 + 3.54*sign(x - 0.3)"), ("0.3", "1 - 3*sign(0.3 - x)"), ("1.7", "4*sign(x - 1.7)")]
    {
        let text = format!(
            "potential.coordinates = [\"x\"]\npotential.formula = \"0\"\npotential.force.x = \"{force}\"\n\
             particle.law = \"newtonian\"\ninitial = {{ x = 2.69, x_dot = 0.52 }}\ngrid.t_f = 1.0\n\
             solver.accuracy = 1e-6\nevents.stop = {{ when = \"t - 0.5\", set = {{ x = \"{top}\", x_dot = \"0\" }} }}"
        );
        let case = parsed(&text, &[]);
        let setup = case.setup::<f64>();
        // It may be refused.
        let Ok(found) = run(&case, &setup, Wanted::default()).0 else { continue };
        assert_eq!(found.judged(&setup, false, false).verdict.grade, Grade::Doubtful, "{text}");
    }
}

/// A tolerance promises nothing, also where the judge of a run meets other events: a ball that is sent back in a
/// potential where neighbouring motions part.
#[test]
fn a_run_whose_judge_meets_other_events_is_doubtful() {
    let mut doubtful = 0;
    for y in ["0.1", "0.15", "0.2"] {
        let text = format!(
            "potential.coordinates = [\"x\", \"y\"]\npotential.formula = \"(x^2 + y^2)/2 + x^2*y - y^3/3\"\n\
             particle.law = \"newtonian\"\ninitial = {{ x = 0.0, y = {y}, x_dot = 0.5, y_dot = 0.1 }}\n\
             solver.tolerance = 1e-4\ngrid.t_f = 500.0\n\
             events.turn = {{ when = \"x - 0.2\", set = {{ x_dot = \"-x_dot\" }} }}"
        );
        let case = parsed(&text, &[]);
        let setup = case.setup::<f64>();
        let found = run(&case, &setup, Wanted::default()).0.unwrap_or_else(|none| panic!("{y}: {none:?}"));
        let judged = found.judged(&setup, false, false);
        let is_known = judged.verdict.error.is_some_and(f64::is_finite);
        assert!(is_known || judged.verdict.grade == Grade::Doubtful, "{text}");
        doubtful += usize::from(!is_known);
    }
    assert!(doubtful > 0);
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
        ["sign(x + y) + 2", "0"],
        ["(t - 2)*step(x) + (t - 2)^2", "0"],
        ["sqrt(abs(x)) + 1", "0"],
        ["abs(x)^1.01", "0"],
        ["x + hill(x) - sign(x)", "1"],
        ["-max(sign(x), 0) - min(sign(x), 0)", "0"],
        ["2 + sign(sign(x))", "0"],
        ["-sign(x^3)", "0"],
        ["step(x^2)", "0"],
    ] {
        assert!(!is_undecided::<f64>(forces, ["0.0", "0.0"], ACCURATE), "{forces:?}");
    }
    // What moves has left the place at once, and what is beside it is on one side.
    assert!(!is_undecided::<f64>(["sign(x - y)", "0"], ["0.0", "0.7"], ACCURATE));
    assert!(!is_undecided::<f64>(["sign(x)", "0"], ["1e-9", "0.0"], ACCURATE));
}

/// A force that is so high gives in a short window what no motion has that passes by later.
#[test]
fn a_thin_slab_that_is_passed_is_no_place_to_stay() {
    let text = "potential.coordinates = [\"x\"]\npotential.formula = \"0\"\nparticle.law = \"newtonian\"\n\
                potential.force.x = \"-27169.38207704975*step(x - 9.474780975701895)*step(9.474791231129096 - x)\"\n\
                initial = { x = 0.0, x_dot = 1.5722950139034708 }\ngrid.gamma_f = 12.559985806345239\n\
                solver.accuracy = 7.242631601251633e-9";
    let case = parsed(text, &[]);
    let setup = case.setup::<f64>();
    let found = run(&case, &setup, Wanted::default()).0.unwrap_or_else(|none| panic!("{none:?}"));
    let judged = found.judged(&setup, false, false);
    assert_eq!(judged.verdict.grade, Grade::Trusted, "{:?}", judged.verdict.reasons);
}

/// Where a decimal is, which is no double, one side of a surface has what rounding makes of a formula there.
#[test]
fn a_start_on_the_surface_of_a_jump_is_no_loss_of_digits() {
    for (x, x_dot, wanted) in [("0.7", 1.0, 0.7), ("-1.843", 0.5, -1.843), ("0.387", -2.0, 0.387)] {
        let text = format!(
            "potential.coordinates = [\"x\"]\npotential.formula = \"0\"\n\
             potential.force.x = \"3 - 2*sign(x - ({x}))\"\n\
             particle.law = \"newtonian\"\ninitial = {{ x = {x}, x_dot = {x_dot} }}\ngrid.t_f = 0.5\n\
             solver.accuracy = 1e-9"
        );
        let case = parsed(&text, &[]);
        let setup = case.setup::<f64>();
        let found = run(&case, &setup, Wanted::default()).0.unwrap_or_else(|none| panic!("{x}: {none:?}"));
        let judged = found.judged(&setup, false, false);
        assert_eq!(judged.verdict.grade, Grade::Trusted, "{x}: {:?}", judged.verdict.reasons);
        // Above the surface the force is 1, and below it 5, where the last one turns and stays.
        let push = if x_dot > 0.0 { 1.0 } else { 5.0 };
        let end = wanted + x_dot * 0.5 + push * 0.125;
        assert!((found.line.end().q[1] - end).abs() < 1e-9, "{x}");
    }
}
