//! `summary.json` of `run`: what was solved, how the solve ended, and the numbers that a study needs. Keys that do not
//! apply are absent. The page `docs/results.md` says what each of them means.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::json::{self, ByName, merged, present};
use crate::case::{Case, Event};
use crate::diagnostics::verdict::Verdict;
use crate::diagnostics::{ChargeDeviation, Deviation, Diagnostics, OfX, WorkBalance};
use crate::engine::{Accuracy, GOOD_DIGITS, Sensitivity};
use crate::geometry::Geometry;
use crate::number::Real;
use crate::solve::{Continuation, Domain, Iterations, NoSolution, Settings, Status, WorldLine};
use crate::study::errors::RunError;
use crate::study::run::{Judged, Run};

/// The summary of a run of `case`, which is judged so. It took these seconds to solve it, and to format and write its
/// tables.
pub fn run_summary<S: Real>(case: &Case, run: &Run<S>, judged: &Judged, seconds: Seconds) -> String {
    json::json(&value_of_run(case, run, judged, seconds))
}

/// Seconds of the solve, and of writing tables.
pub(super) type Seconds = [f64; 2];

/// The same as a value.
pub(super) fn value_of_run<S: Real>(
    case: &Case,
    run: &Run<S>,
    judged: &Judged,
    [solve_seconds, write_seconds]: Seconds,
) -> Value {
    let Run { line, diagnostics, .. } = run;
    let error = judged.error.as_ref();
    let of_x = diagnostics.of_x.as_ref().map(|of_x| numbers_of_x(line, diagnostics, of_x));
    let growth = line.sensitivity.as_ref().map(Sensitivity::growth);
    let further = json!({
        "error_estimate": line.error_estimate,
        "good_until": good_until(line),
        "windows_unproved": line.windows_unproved,
        "sensitivity": growth.map(|growth| json!({"lyapunov": growth.lyapunov, "megno": growth.megno})),
        "acting_events": case.has_acting_events().then_some(run.acting_events),
        "exactness": diagnostics.exactness(),
        "defect_max": diagnostics.defect.as_ref().map(|defect| defect.most),
        "defect_gamma": diagnostics.defect.as_ref().map(|defect| defect.gamma),
    });
    let warnings = [case.warnings().as_slice(), &judged.suspicions].concat();
    // The end, from which `initial.from` continues the run.
    let names = line.geometry().names();
    let end = json!({"end_state": Continuation::new(line).off_by(names, judged.left.as_ref())});
    // With an accuracy the scheme is the one that was chosen.
    let settings = Settings {
        sbp: line.sbp_name,
        form: line.form,
        n_gamma: line.sbp().points(),
        windows: line.window_count,
        ..case.settings
    };
    merged([
        json!({"status": Status::Converged}),
        json!(judged.verdict),
        problem(case, line.geometry(), settings, &line.iterations),
        json!({"iterations": line.iterations.count, "solve_seconds": solve_seconds}),
        numbers(run, &case.events, error),
        json!(of_x),
        end,
        present(further),
        json!(judged.gaps),
        present(json!({"proof": proof(judged)})),
        json!({"diagnostics_seconds": run.seconds, "write_seconds": write_seconds}),
        // The iterations are those of the window that took most.
        json!({"warnings": warnings, "history": line.iterations.history}),
    ])
}

/// The summary of a solve that failed: the place to which it came, in words and numbers.
pub fn failure_summary<S: Real>(
    case: &Case,
    geometry: &Geometry<S>,
    failure: &NoSolution,
    solve_seconds: f64,
) -> String {
    let point: BTreeMap<_, _> = failure.point.iter().cloned().collect();
    let g00 = match failure.domain {
        Domain::G00(g00) | Domain::Overflow(g00) => json!({"g00": g00}),
        Domain::Determinant { .. } | Domain::Scene => json!({}),
    };
    let accuracy = (failure.status == Status::AccuracyNotReached)
        .then(|| json!({"accuracy_asked": failure.asked, "accuracy_estimated": failure.residual}));
    let Iterations { count, history, .. } = &*failure.iterations;
    // Evaluations of the force up to a limit are not counted.
    let count = if case.is_of_x { history.len() } else { *count };
    json::json(&merged([
        json!({"status": failure.status}),
        json!(Verdict::refused()),
        problem(case, geometry, case.settings, &failure.iterations),
        json!({"iterations": count, "solve_seconds": solve_seconds}),
        json!({"message": failure.to_string(), "advice": failure.advice(), "gamma": failure.gamma}),
        json!({"point": point}),
        g00,
        json!({"residual": failure.residual}),
        json!(accuracy),
        json!({"warnings": case.warnings(), "history": history}),
    ]))
}

/// The space-time and the scheme.
fn problem<S: Real>(case: &Case, geometry: &Geometry<S>, settings: Settings, iterations: &Iterations) -> Value {
    let Settings { sbp, form, regularised, n_gamma, windows, system, digits, accuracy, .. } = settings;
    let names = geometry.names();
    let some = |indices: &mut dyn Iterator<Item = usize>| indices.map(|a| &names[a]).collect::<Vec<_>>();
    let coordinates = json!({
        "coordinates": names,
        "ignorable": some(&mut geometry.ignorable()),
        "active": some(&mut geometry.active().iter().copied()),
    });
    merged([
        json!({"version": env!("CARGO_PKG_VERSION")}),
        present(json!({"title": case.title.as_deref()})),
        coordinates,
        json!({
            "sbp": sbp.to_string(),
            "form": form,
            "system": system,
            "regularised": regularised,
            "digits": digits,
            "n_gamma": n_gamma,
            "windows": windows,
        }),
        present(json!({
            "accuracy": accuracy.filter(|accuracy| accuracy.is_promised()).map(Accuracy::value),
            "tolerance": accuracy.filter(|accuracy| !accuracy.is_promised()).map(Accuracy::value),
        })),
        json!({"initial_guess": iterations.initial_guess}),
    ])
}

/// In a run to a tolerance γ until which so many digits are good, by their number.
fn good_until<S: Real>(line: &WorldLine<S>) -> Option<BTreeMap<String, f64>> {
    let gamma = |until: f64| line.gamma_at(S::from(until)).to_f64();
    let until = GOOD_DIGITS.iter().zip(line.good_until);
    let has_tolerance = line.accuracy.is_some_and(|accuracy| !accuracy.is_promised());
    has_tolerance.then(|| until.map(|(digits, until)| (digits.to_string(), gamma(until))).collect())
}

/// What the paper calls some numbers of a run in a potential of x alone, and what only such a motion has.
fn numbers_of_x<S: Real>(line: &WorldLine<S>, diagnostics: &Diagnostics<S>, of_x: &OfX<S>) -> Value {
    let number = |value: S| json::number(value, line.digits);
    let (charge, end) = (&diagnostics.charges[0], line.end_state());
    merged([
        present(json!({"multipliers": line.multipliers().map(|lambda| lambda.map(number))})),
        json!({
            "t_final": number(end.t),
            "x_final": number(end.x),
            "x_dot_final": number(end.x_dot),
            "q_t": number(line.q_t()),
            "max_abs_delta_q_t_interior": number(charge.max_interior),
            "delta_q_t_last": number(charge.last),
            "max_abs_delta_q_t_corrected": number(charge.max_corrected),
            "h_bvp": number(of_x.h_bvp),
            "h_bvp_bound": number(of_x.h_bvp_bound),
            "h_bvp_bound_kept": of_x.is_kept(),
            "h_bvp_defect": number(of_x.defect()),
        }),
        present(json!({
            "max_abs_delta_q_x": of_x.free_particle.map(|[q_x, _]| number(q_x)),
            "max_abs_delta_q_eta": of_x.free_particle.map(|[_, q_eta]| number(q_eta)),
        })),
        json!({"newtonian_deviation": of_x.deviation}),
        present(json!({"newtonian_c": of_x.c()})),
    ])
}

/// The numbers of a run, by the names of its coordinates.
fn numbers<S: Real>(run: &Run<S>, events: &[Event], error: Option<&RunError>) -> Value {
    let Run { line, diagnostics, sums, .. } = run;
    let names = line.geometry().names();
    let number = |value: S| json::number(value, line.digits);
    let all = |values: &[S]| -> ByName { names.iter().cloned().zip(values.iter().map(|&v| number(v))).collect() };
    let of_charges = |value: fn(&ChargeDeviation<S>) -> S| -> ByName {
        let charges = diagnostics.charges.iter();
        charges.map(|charge| (names[charge.terms[0].0].clone(), number(value(charge)))).collect()
    };
    let of_sums = |value: fn(&ChargeDeviation<S>) -> S| -> ByName {
        let sums = sums.iter().zip(&diagnostics.sums);
        sums.map(|(sum, charge)| (sum.formula(names), number(value(charge)))).collect()
    };
    let of_invariants = |value: fn(&Deviation<S>) -> S| -> ByName {
        diagnostics.invariants.iter().map(|(name, invariant)| (name.clone(), number(value(invariant)))).collect()
    };
    let work = |value: fn(&WorkBalance<S>) -> S| -> ByName {
        diagnostics.work.iter().map(|work| (names[work.coordinate].clone(), number(value(work)))).collect()
    };
    let sawtooth = diagnostics.sawtooth.iter().map(|(a, sawtooth)| (&names[*a], sawtooth.amplitude.map(number)));
    let count = |watch: usize| run.events.iter().filter(|crossing| crossing.watch == watch).count();
    let (end, norm, energy) = (line.end(), &diagnostics.norm, diagnostics.energy.as_ref());
    let momenta: Vec<S> = end.p.iter().enumerate().map(|(a, &p)| line.geometry().seen(a, p)).collect();
    merged([
        json!({
            "gradient_norm": number(line.gradient_norm),
            "gamma_final": number(line.gamma_f()),
            "final": all(&end.q),
            "q_dot_final": all(&end.q_dot),
            "p_final": all(&momenta),
            "charges": of_charges(|charge| charge.value),
            "max_abs_delta_q_interior": of_charges(|charge| charge.max_interior),
            "max_abs_delta_q_last": of_charges(|charge| charge.max_last),
            "max_abs_delta_q_corrected": of_charges(|charge| charge.max_corrected),
            "conserved_sums": of_sums(|charge| charge.max_interior),
            "conserved_sums_ends": of_sums(|charge| charge.max_ends),
            "k": number(norm.value),
            "max_abs_delta_g_interior": number(diagnostics.max_delta_g),
            "max_abs_delta_k": number(norm.max_interior),
            "max_abs_delta_k_ends": number(norm.max_ends),
        }),
        present(json!({
            "energy": energy.map(|energy| number(energy.value)),
            "max_abs_delta_energy": energy.map(|energy| number(energy.max_interior)),
            "max_abs_delta_energy_ends": energy.map(|energy| number(energy.max_ends)),
        })),
        json!({"sawtooth": sawtooth.collect::<BTreeMap<_, _>>()}),
        present(json!({
            "work": work(|work| work.work),
            "work_defect": work(|work| work.defect),
            "invariants": of_invariants(|invariant| invariant.value),
            "max_abs_delta_invariant": of_invariants(|invariant| invariant.max_interior),
            "max_abs_delta_invariant_ends": of_invariants(|invariant| invariant.max_ends),
            "events": events.iter().enumerate().map(|(k, event)| (&event.name, count(k))).collect::<BTreeMap<_, _>>(),
            "branch_distance": diagnostics.branch_distance.map(number),
        })),
        error.map_or_else(|| json!({}), |error| errors_by_name(&names[..line.geometry().results()], error)),
    ])
}

/// The proof of the end, and that of the ends from the intervals of a case.
fn proof(Judged { proof, hull, .. }: &Judged) -> Option<Value> {
    let hull = hull.as_ref().map(|hull| match &hull.ends {
        Ok(ends) => {
            let ends: ByName = ends.iter().map(|(name, ends)| (name.clone(), json!(ends))).collect();
            json!({"hull": ends})
        }
        Err(reason) => json!({"hull_reason": reason}),
    });
    (proof.is_some() || hull.is_some()).then(|| merged([json!(proof), json!(hull)]))
}

/// The errors of the coordinates that are results: s of Newton's law is none.
fn errors_by_name(names: &[String], error: &RunError) -> Value {
    let by_name =
        |values: Vec<f64>| -> ByName { names.iter().cloned().zip(values.into_iter().map(Value::from)).collect() };
    present(json!({
        "error_final": by_name(error.at_most_at_end()),
        "error_max": by_name(error.at_most()),
        "error_from": error.judge.describe(),
        "reference_error": error.judge.reference_error(),
    }))
}
