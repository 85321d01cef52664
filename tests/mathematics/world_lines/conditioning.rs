//! What rounding takes from the formulas of a case is part of the error, and is named.

use geodesic_ivp::Case;
use geodesic_ivp::case::builtin;
use geodesic_ivp::diagnostics::verdict::Grade;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::study::errors::run_error;
use geodesic_ivp::study::run::{Judged, NoRun, Run, Wanted, run};

use crate::common::{end, parsed};

/// A particle at rest at x = 1 in the force `force`.
fn pushed(force: &str, rest: &str) -> Case {
    let text = format!(
        "particle.law = \"newtonian\"\ngrid.gamma_f = 3.0\n{rest}\ninitial = {{ x = 1.0, x_dot = 0.0 }}\n\
         potential = {{ coordinates = [\"x\"], formula = \"0\", force = {{ x = \"{force}\" }} }}\n"
    );
    parsed(&text, &[])
}

fn judged<S: Real>(case: &Case, is_streamed: bool) -> (Run<S>, Judged) {
    let setup = case.setup::<S>();
    let wanted = Wanted { is_streamed, ..Wanted::default() };
    let run = run(case, &setup, wanted).0.unwrap_or_else(|none| panic!("{none:?}"));
    let judged = run.judged(&setup, false, false);
    (run, judged)
}

/// The first reason of a case that must be doubtful, or the formula that keeps it from its accuracy.
#[track_caller]
fn doubt(case: &Case) -> String {
    let setup = case.setup::<f64>();
    let run: Run = match run(case, &setup, Wanted::default()).0 {
        Err(NoRun::Unsolved(failure, _)) => {
            return failure.reasons.lost.as_ref().unwrap_or_else(|| panic!("{failure}")).finding.clone();
        }
        run => run.unwrap_or_else(|none| panic!("{none:?}")),
    };
    let judged = run.judged(&setup, false, false);
    assert_eq!(judged.verdict.grade, Grade::Doubtful, "{:?}", judged.error);
    judged.verdict.reasons[0].to_string()
}

const ACCURATE: &str = "solver.accuracy = 1e-8";
const LOST: &str = "-1e18*(1 - cos(1e-9*x))";

/// Formulas that lose about 1e-16/e of their digits, and the same without a difference of what is nearly the same.
const PAIRS: [(&str, &str); 5] = [
    ("-K*(sqrt(1 + E*x) - 1)/E", "-K*x/(sqrt(1 + E*x) + 1)"),
    ("-K*(exp(E*x) - 1)/E", "-2*K*exp(E*x/2)*sinh(E*x/2)/E"),
    ("-K*(1/(1 - E*x) - 1)/E", "-K*x/(1 - E*x)"),
    ("-K*(sin(0.5 + E*x) - sin(0.5))/E", "-2*K*cos(0.5 + E*x/2)*sin(E*x/2)/E"),
    ("-K*((1 + E*x)^2 - 1)/E", "-K*x*(2 + E*x)"),
];

#[test]
fn a_formula_that_loses_more_than_the_accuracy_is_named_and_its_error_is_in_the_result() {
    for (seed, (badly, well)) in PAIRS.iter().enumerate() {
        for (k, e) in [(0.3 + 0.4 * seed as f64, 1.3e-9), (1.7 - 0.2 * seed as f64, 2.9e-9)] {
            let written = |formula: &str, rest: &str| {
                let formula = formula.replace('K', &format!("{k}")).replace('E', &format!("{e:e}"));
                pushed(&formula, rest)
            };
            let (good, of_good) = judged::<f64>(&written(well, ACCURATE), false);
            assert_eq!(of_good.verdict.grade, Grade::Trusted, "{well}: {:?}", of_good.verdict);
            let reason = doubt(&written(badly, ACCURATE));
            assert!(reason.starts_with("the formula force.x loses "), "{badly} {e:e}: {reason}");
            let (bad, of_bad) = judged::<f64>(&written(badly, "solver.tolerance = 1e-6"), false);
            let (off, error) = ((end(&bad.line, "x") - end(&good.line, "x")).abs(), of_bad.error.unwrap());
            let found = error.at_most_at_end()[1];
            assert!(off <= found && found < 1e3 * off.max(1e-8), "{badly} {e:e}: {off:e} {found:e}");
        }
    }
}

#[test]
fn a_formula_that_loses_less_than_the_accuracy_is_trusted() {
    for (badly, _) in PAIRS {
        let case = pushed(&badly.replace('K', "0.7").replace('E', "1e-3"), ACCURATE);
        let (_, judged) = judged::<f64>(&case, false);
        assert_eq!(judged.verdict.grade, Grade::Trusted, "{badly}: {:?}", judged.verdict);
    }
}

/// A particle in a double well under a force of `t - start`, or of t with the phase that makes it the same.
fn clocked(start: f64, phase: &str, rest: &str) -> Case {
    let force =
        if phase.is_empty() { format!("0.4*cos(1.3*(t - {start:?}))") } else { format!("0.4*cos(1.3*t{phase})") };
    let text = format!(
        "particle.law = \"newtonian\"\ngrid.gamma_f = 20.0\n{rest}\n\
         initial = {{ t = {start:?}, x = 0.7, x_dot = 0.3 }}\n\
         potential = {{ coordinates = [\"x\"], formula = \"x^4/4 - x^2/2\", force = {{ x = \"{force}\" }} }}\n"
    );
    parsed(&text, &[])
}

/// A time of 10⁶ is a double to 10⁻¹⁰, and so is what a force makes of it.
#[test]
fn a_clock_that_is_far_from_zero_has_the_error_of_its_rounding() {
    let (near, _) = judged::<f64>(&clocked(0.0, "", "solver.accuracy = 1e-12"), false);
    // Times that are sums of powers of two, so that differences from them are exact.
    for start in [1_048_576.187_5, -7_340_031.5, 2.0_f64.powi(33) + 0.375] {
        let (far, of_far) = judged::<f64>(&clocked(start, "", "solver.tolerance = 1e-13"), false);
        let (off, error) = ((end(&far.line, "x") - end(&near.line, "x")).abs(), of_far.error.unwrap());
        assert!(off <= error.at_most_at_end()[1], "{start}: {off:e} of {error:?}");
        for phase in ["", " + 0.2"] {
            let reason = doubt(&clocked(start, phase, "solver.accuracy = 1e-11"));
            assert!(reason.starts_with("t is far from 0 beside what it moves by"), "{start}: {reason}");
        }
        let (_, judged) = judged::<f64>(&clocked(start, "", "solver.accuracy = 1e-3"), false);
        assert_eq!(judged.verdict.grade, Grade::Trusted, "{start}: {:?}", judged.verdict);
    }
}

/// A jump next to a place that is looked at is no loss, and an event by the clock is as uncertain as the clock is.
#[test]
fn a_clock_that_is_far_from_zero_may_have_switches_and_events() {
    let mut known_events = 0;
    let cases: [(f64, f64); 4] = [(1e3, 0.5), (1e6, 0.5), (1e6, 0.0), (1e9, 0.0)];
    for (start, force) in cases {
        let (switch, t_f) = (start + 1.2345, start + 4.0);
        let text = format!(
            "particle.law = \"newtonian\"\ngrid.t_f = {t_f:?}\nsolver.accuracy = 1e-10\n\
             initial = {{ t = {start:?}, x = 0.5, x_dot = 0.3 }}\nevents.beat.when = \"sin(3*t)\"\n\
             potential = {{ coordinates = [\"x\"], formula = \"0\", \
             force = {{ x = \"{force}*step(t - {switch:?})\" }} }}\n"
        );
        let text = if force == 0.0 { text.replace(&format!("0*step(t - {switch:?})"), "0") } else { text };
        let accuracy = if force == 0.0 { "solver.accuracy=1e-10" } else { "solver.accuracy=1e-4" };
        let case = parsed(&text, &[accuracy]);
        let (run, judged) = judged::<f64>(&case, false);
        assert_eq!(judged.verdict.grade, Grade::Trusted, "{start}: {:?}", judged.verdict);
        let x = 0.5 + 0.3 * 4.0 + 0.5 * force * (t_f - switch).powi(2);
        assert!((end(&run.line, "x") - x).abs() < 1e-9, "{start}");
        assert!(run.events.len() >= 3, "{start}");
        for event in &run.events {
            let Some(known) = &event.off else { continue };
            // sin 3t changes its sign at multiples of π/3, to which t is compared in 70 digits.
            let beats = Extended::from(3.0) * (Extended::from(start) + Extended::from(event.sample.gamma))
                / <Extended as Real>::PI;
            let off = (beats - Extended::from(beats.to_f64().round())).to_f64().abs() * std::f64::consts::PI / 3.0;
            assert!(off <= known[0] + f64::EPSILON * start, "{start}: {off:e} {known:?}");
            assert!(known[0] >= f64::EPSILON * start, "{start}: {known:?}");
            known_events += 1;
        }
    }
    assert!(known_events > 4, "{known_events}");
}

/// x and the width of a force 0.3/w in between have 16 digits, so that 10⁻¹⁶ x/w of what it does is open.
#[test]
fn the_place_of_a_jump_is_known_to_its_rounding() {
    let (mut largest, mut is_doubted) = (0.0_f64, false);
    for k in 1..=12_u32 {
        let (begin, width, v) =
            (5.0 + 0.3 * f64::from(k), 1e-5 * (1.0 + 0.1 * f64::from(k)), 0.8 + 0.01 * f64::from(k));
        let (end, length, force) = (begin + width, 25.0, 0.3 / width);
        // The doubles that stand in the case are what the place and the width are.
        let exact = |number: f64| Extended::from(number);
        let (width, two) = (exact(end) - exact(begin), exact(2.0));
        let out = (exact(v) * exact(v) + two * exact(force) * width).sqrt();
        let inside = two * width / (exact(v) + out);
        let x = exact(end) + out * (exact(length) - exact(begin) / exact(v) - inside);
        for accuracy in ["solver.tolerance = 1e-13", "solver.accuracy = 1e-11"] {
            let text = format!(
                "particle.law = \"newtonian\"\ngrid.gamma_f = {length:?}\n{accuracy}\n\
                 initial = {{ x = 0.0, x_dot = {v:?} }}\npotential = {{ coordinates = [\"x\"], formula = \"0\", \
                 force = {{ x = \"{force:?}*step(x - {begin:?})*step({end:?} - x)\" }} }}\n"
            );
            let (case, wanted) = (parsed(&text, &[]), Wanted::default());
            let setup = case.setup::<f64>();
            // What is refused is not wrong.
            let Ok(run) = run(&case, &setup, wanted).0 else { continue };
            let judged = run.judged(&setup, false, false);
            let off = (exact(self::end(&run.line, "x")) - x).to_f64().abs();
            let most = judged.error.unwrap().at_most_at_end()[1];
            assert!(off <= most, "{k} {accuracy}: {off:e} of {most:e}");
            largest = largest.max(off / x.to_f64());
            let reason = judged.verdict.reasons.first().map_or(String::new(), ToString::to_string);
            is_doubted |= reason.starts_with("where a force jumps is known to rounding alone");
        }
    }
    assert!(largest > 1e-12 && is_doubted, "{largest:e}");
}

/// The same where the force depends on time alone, and the coordinate is small beside the way that it goes: ẋ behind a
/// pulse is v + F w, for the doubles that its ends are.
#[test]
fn the_place_of_a_jump_in_time_is_known_to_its_rounding() {
    for k in 1..=12_u32 {
        let (begin, width, v) = (1.5 + 0.03 * f64::from(k), 1e-7 / f64::from(k), 0.7 + 0.03 * f64::from(k));
        let (end, force, x) = (begin + width, 1.0 / width, -v * begin * 1.000_1);
        let exact = |number: f64| Extended::from(number);
        let kick = exact(force) * (exact(end) - exact(begin));
        let middle = (exact(end) + exact(begin)) / exact(2.0);
        let known = exact(x) + exact(v) * exact(3.0) + kick * (exact(3.0) - middle);
        let text = format!(
            "particle.law = \"newtonian\"\ngrid.t_f = 3.0\nsolver.tolerance = 1e-11\n\
             initial = {{ x = {x:?}, x_dot = {v:?} }}\npotential = {{ coordinates = [\"x\"], formula = \"0\", \
             force = {{ x = \"{force:?}*step(t - {begin:?})*step({end:?} - t)\" }} }}\n"
        );
        let (run, judged) = judged::<f64>(&parsed(&text, &[]), false);
        let off = (exact(self::end(&run.line, "x")) - known).to_f64().abs();
        let most = judged.error.unwrap().at_most_at_end()[1];
        assert!(off <= most, "{k}: {off:e} of {most:e}");
    }
}

#[test]
fn the_formula_that_loses_is_named_wherever_it_stands() {
    let rest = "particle.law = \"newtonian\"\ngrid.gamma_f = 3.0\ninitial = { x = 1.0, x_dot = 0.0 }\n";
    for (kind, name) in [
        ("force.x = \"-k*x\"\nparameters.k = \"(1e16 + 1) - 1e16\"", "of the parameter k"),
        ("force.x = \"-f\"\ndefinitions.f = \"1e10*(1 - cos(1e-5*x))\"", "of the definition f"),
        ("one_form.x = \"x\"\nforce.x = \"-1e18*(1 - cos(1e-9*x))\"", "force.x"),
    ] {
        let text = format!("{rest}{ACCURATE}\n[potential]\nformula = \"0\"\n{kind}");
        let reason = doubt(&parsed(&text, &[]));
        assert!(reason.starts_with(&format!("the formula {name} loses ")), "{text}: {reason}");
    }
    // The paper's metric has V itself, and not its slope alone.
    let rest = format!("grid.gamma_f = 3.0\ninitial = {{ x = 1.0, t_dot = 1.0, x_dot = 0.3 }}\n{ACCURATE}\n");
    let v = "1e9*(sqrt(1 + 2e-10*x^2) - 1)";
    let reason = doubt(&parsed(&format!("{rest}potential.formula.expression = \"{v}\""), &[]));
    assert!(reason.starts_with("the formula of the potential loses "), "{reason}");
    let components = format!("{{ \"t t\" = \"1 + {v}\", \"x x\" = \"-1\" }}");
    let metric = format!("metric = {{ coordinates = [\"t\", \"x\"], components = {components} }}");
    let reason = doubt(&parsed(&format!("{rest}{metric}"), &["solver.accuracy=3e-8"]));
    assert!(reason.starts_with("the formula of the component \"t t\" loses "), "{reason}");
}

#[test]
fn every_run_of_sixteen_digits_is_looked_at() {
    let event = "events.kick = { when = \"t - 1\", set = { x_dot = \"x_dot + 0.1\" } }";
    for rest in [
        ACCURATE,
        "solver.tolerance = 1e-8",
        "scheme = { sbp = \"GLL16\", form = \"weak\" }\ngrid.windows = 4",
        "scheme.sbp = \"SBP42\"\ngrid.n_gamma = 100",
        &format!("{ACCURATE}\n{event}"),
        &format!("{ACCURATE}\ngrid.gamma_i = 4.0"),
    ] {
        let case = pushed(LOST, rest);
        assert!(doubt(&case).starts_with("the formula force.x loses all of its digits to rounding near "), "{rest}");
        let (_, streamed) = judged::<f64>(&case, true);
        assert!(streamed.verdict.reasons[0].reason.starts_with("the formula force.x loses all"), "{rest}");
    }
    let relativistic = parsed(
        &format!(
            "potential.formula.expression = \"0.0\"\npotential.force.x = \"{LOST}\"\ngrid.gamma_f = 1.0\n\
                  initial = {{ x = 0.5, t_dot = 1.0, x_dot = 0.1 }}\n{ACCURATE}"
        ),
        &[],
    );
    assert!(doubt(&relativistic).starts_with("the formula force.x loses all"));
}

/// A run that rounding keeps from an accuracy says which formula is rounded.
#[test]
fn a_formula_that_keeps_a_run_from_its_accuracy_is_named() {
    let rest = "grid.gamma_f = 3.0\ninitial = { x = 1.0, t_dot = 1.0, x_dot = 0.3 }\nsolver.accuracy = 1e-10\n";
    let components = "{ \"t t\" = \"1 + 1e9*(sqrt(1 + 2e-10*x^2) - 1)\", \"x x\" = \"-1\" }";
    let case = parsed(&format!("{rest}metric = {{ coordinates = [\"t\", \"x\"], components = {components} }}"), &[]);
    let Err(NoRun::Unsolved(failure, _)) = run(&case, &case.setup::<f64>(), Wanted::default()).0 else {
        panic!("1e-10 cannot be reached")
    };
    assert!(failure.to_string().contains("; the formula of the component \"t t\" loses "), "{failure}");
    assert!(failure.advice().starts_with("write that formula so that nothing cancels"), "{failure}");
}

#[test]
fn more_digits_are_the_remedy() {
    let grid = "scheme = { sbp = \"GLL16\", form = \"weak\" }\ngrid.windows = 4";
    for (badly, well) in PAIRS {
        let [badly, well] = [badly, well].map(|formula| formula.replace('K', "0.7").replace('E', "1e-9"));
        let case = pushed(&badly, ACCURATE);
        assert!(doubt(&case).starts_with("the formula force.x loses "), "{badly}");
        let (run, judged) = judged::<Extended>(&pushed(&badly, &format!("{grid}\nsolver.digits = 32")), false);
        assert_eq!(judged.verdict.grade, Grade::Trusted, "{badly}: {:?}", judged.verdict);
        let (well, _) = self::judged::<f64>(&pushed(&well, ACCURATE), false);
        let x = run.line.end().q[1].to_f64();
        assert!((x - end(&well.line, "x")).abs() < 1e-8, "{badly}: {x}");
    }
    // What has no digit at all is not solved in more of them either.
    assert!(doubt(&pushed(LOST, "solver.tolerance = 1e-8")).ends_with("; write it so that nothing cancels"));
}

#[test]
fn formulas_that_are_written_well_add_nothing_to_an_error() {
    let mut seen = 0;
    for builtin::BuiltIn { name, folder, text, .. } in builtin::ALL.iter() {
        let case = parsed(text, &[]);
        let is_long = case.settings.windows > 1000 || *folder == "hard";
        if case.settings.is_extended() || case.has_acting_events() || is_long {
            continue;
        }
        let setup = case.setup::<f64>();
        let Ok(run) = run(&case, &setup, Wanted::default()).0 else { continue };
        let own = run_error(&setup, &run.line, &[]);
        let judged = run.judged(&setup, false, false).error;
        if run.line.ended_by.is_none() {
            assert_eq!(judged, own, "{name}");
        } else {
            // The judge has met what ended the run, which tells more of the place than the errors there.
            let pairs = judged.iter().zip(&own).flat_map(|(judged, own)| judged.end.iter().zip(&own.end));
            pairs.for_each(|(judged, own)| assert!(judged <= own, "{name}: {judged:e} {own:e}"));
        }
        seen += 1;
    }
    assert!(seen > 30, "{seen} cases");
}
