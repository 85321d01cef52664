//! The numbers of a run: in a potential of x alone by the paper's names, in any other space-time by the coordinates'.
//! The page `docs/results.md` says what each of them means.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::case::Event;
use crate::diagnostics::{ChargeDeviation, Diagnostics, InvariantDeviation, OfX, WorkBalance};
use crate::number::Real;
use crate::output::json::{self, ByName, without};
use crate::solve::WorldLine;
use crate::study::errors::RunError;
use crate::study::run::Run;

/// The numbers of a critical point in a potential of x.
pub(super) fn of_paper<S: Real>(
    line: &WorldLine<S>,
    diagnostics: &Diagnostics<S>,
    of_x: &OfX<S>,
    error: Option<&RunError>,
) -> Value {
    let number = |value: S| json::number(value, line.digits);
    let (charge, norm, end) = (&diagnostics.charges[0], &diagnostics.norm, line.end_state());
    let at_end = |a: usize| error.map(|error| error.at_most_at_end()[a]);
    let largest = |a: usize| error.map(|error| error.at_most()[a]);
    let numbers = json!({
        "gradient_norm": number(line.gradient_norm),
        "multipliers": line.multipliers().map(|lambda| lambda.map(number)),
        "gamma_final": number(line.gamma_f()),
        "t_final": number(end.t),
        "x_final": number(end.x),
        "x_dot_final": number(end.x_dot),
        "q_t": number(line.q_t()),
        "k": number(line.norm()),
        "max_abs_delta_q_t_interior": number(charge.max_interior),
        "delta_q_t_last": number(charge.last),
        "max_abs_delta_q_t_corrected": number(charge.max_corrected),
        "max_abs_delta_g_interior": number(diagnostics.max_delta_g),
        "max_abs_delta_k": number(norm.max_interior),
        "max_abs_delta_k_ends": number(norm.max_ends),
        "sawtooth": diagnostics.sawtooth[0].1.amplitude.map(number),
        "h_bvp": number(of_x.bound.h_bvp),
        "h_bvp_bound": number(of_x.bound.h_bvp_bound),
        "h_bvp_bound_kept": of_x.bound.is_kept(),
        "h_bvp_defect": number(of_x.bound.defect()),
        "branch_distance": diagnostics.branch_distance.map(number),
        "max_abs_delta_q_x": of_x.free_particle.map(|f| number(f.max_abs_delta_q_x)),
        "max_abs_delta_q_eta": of_x.free_particle.map(|f| number(f.max_abs_delta_q_eta)),
        "error_t_final": at_end(0),
        "error_x_final": at_end(1),
        "error_t_max": largest(0),
        "error_x_max": largest(1),
        "error_from": error.map(|error| error.judge.describe()),
        "newtonian_deviation": of_x.newtonian.deviation,
        "newtonian_c": of_x.newtonian.c(),
    });
    let optional = ["multipliers", "branch_distance", "max_abs_delta_q_x", "max_abs_delta_q_eta", "newtonian_c"];
    let errors = ["error_t_final", "error_x_final", "error_t_max", "error_x_max", "error_from"];
    without(without(numbers, &optional), if error.is_none() { &errors } else { &[] })
}

/// The keys of a world-line in any space-time that may be absent.
const OPTIONAL: [&str; 14] = [
    "energy",
    "max_abs_delta_energy",
    "max_abs_delta_energy_ends",
    "work",
    "work_defect",
    "invariants",
    "max_abs_delta_invariant",
    "max_abs_delta_invariant_ends",
    "events",
    "branch_distance",
    "error_final",
    "error_max",
    "error_from",
    "reference_error",
];

/// The numbers of a world-line in any space-time.
pub(super) fn by_name<S: Real>(run: &Run<S>, events: &[Event], error: Option<&RunError>) -> Value {
    let Run { line, diagnostics, sums, .. } = run;
    let names = line.geometry().names();
    let number = |value: S| json::number(value, line.digits);
    let all = |values: &[S]| -> ByName { names.iter().cloned().zip(values.iter().map(|&v| number(v))).collect() };
    let errors =
        |values: Vec<f64>| -> ByName { names.iter().cloned().zip(values.into_iter().map(Value::from)).collect() };
    let of_charges = |value: fn(&ChargeDeviation<S>) -> S| -> ByName {
        let charges = diagnostics.charges.iter();
        charges.map(|charge| (names[charge.terms[0].0].clone(), number(value(charge)))).collect()
    };
    let of_sums = |value: fn(&ChargeDeviation<S>) -> S| -> ByName {
        let sums = sums.iter().zip(&diagnostics.sums);
        sums.map(|(sum, charge)| (sum.formula(names), number(value(charge)))).collect()
    };
    let of_invariants = |value: fn(&InvariantDeviation<S>) -> S| -> ByName {
        diagnostics.invariants.iter().map(|invariant| (invariant.name.clone(), number(value(invariant)))).collect()
    };
    let work = |value: fn(&WorkBalance<S>) -> S| -> ByName {
        diagnostics.work.iter().map(|work| (names[work.coordinate].clone(), number(value(work)))).collect()
    };
    let sawtooth = diagnostics.sawtooth.iter().map(|(a, sawtooth)| (&names[*a], sawtooth.amplitude.map(number)));
    let count = |watch: usize| run.events.iter().filter(|crossing| crossing.watch == watch).count();
    let (end, norm, energy) = (line.end(), &diagnostics.norm, diagnostics.energy);
    let numbers = json!({
        "gradient_norm": number(line.gradient_norm),
        "gamma_final": number(line.gamma_f()),
        "final": all(&end.q),
        "q_dot_final": all(&end.q_dot),
        "p_final": all(&end.p),
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
        "energy": energy.map(|energy| number(energy.value)),
        "max_abs_delta_energy": energy.map(|energy| number(energy.max)),
        "max_abs_delta_energy_ends": energy.map(|energy| number(energy.max_ends)),
        "sawtooth": sawtooth.collect::<BTreeMap<_, _>>(),
        "work": work(|work| work.work),
        "work_defect": work(|work| work.defect),
        "invariants": of_invariants(|invariant| invariant.value),
        "max_abs_delta_invariant": of_invariants(|invariant| invariant.max),
        "max_abs_delta_invariant_ends": of_invariants(|invariant| invariant.max_ends),
        "events": events.iter().enumerate().map(|(k, event)| (&event.name, count(k))).collect::<BTreeMap<_, _>>(),
        "branch_distance": diagnostics.branch_distance.map(number),
        "error_final": error.map(|error| errors(error.at_most_at_end())),
        "error_max": error.map(|error| errors(error.at_most())),
        "error_from": error.map(|error| error.judge.describe()),
        "reference_error": error.and_then(|error| error.judge.reference_error()),
    });
    without(numbers, &OPTIONAL)
}
