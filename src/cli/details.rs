//! `run --verbose` also tells every reason for doubt, every charge, the critical point, and the bounds of the paper.

use geodesic_ivp::action::Form;
use geodesic_ivp::diagnostics::{ChargeDeviation, OfX};
use geodesic_ivp::number::Real;
use geodesic_ivp::solve::{InitialGuess, Iterations, WorldLine};
use geodesic_ivp::study::run::{Judged, Run};

use super::lines::row;
use super::told::doubt;

/// The lines.
pub(super) fn details<S: Real>(run: &Run<S>, judged: &Judged) -> String {
    let Run { line, diagnostics, sums, .. } = run;
    let names = line.geometry().names();
    let mut lines: Vec<String> = judged.verdict.reasons.iter().skip(1).map(doubt).collect();
    for charge in &diagnostics.charges {
        lines.push(row("charge", &deviation(&format!("p_{}", names[charge.terms[0].0]), charge, line)));
    }
    for (sum, charge) in sums.iter().zip(&diagnostics.sums) {
        lines.push(row("sum", &deviation(&sum.formula(names), charge, line)));
    }
    let norm = &diagnostics.norm;
    let [value, interior, ends] = [norm.value, norm.max_interior, norm.max_ends].map(|value| value.to_f64());
    lines.push(row(
        "K",
        &format!("{value:.6}; changes by at most {interior:.2e} at nodes, {ends:.2e} at ends of windows"),
    ));
    for invariant in &diagnostics.invariants {
        let [value, most, ends] = [invariant.value, invariant.max, invariant.max_ends].map(|value| value.to_f64());
        let name = &invariant.name;
        lines
            .push(row("drift", &format!("{name} = {value:.6}, by {most:.1e} at nodes, {ends:.1e} at ends of windows")));
    }
    for work in &diagnostics.work {
        let (name, [work, defect]) = (&names[work.coordinate], [work.work, work.defect].map(|value| value.to_f64()));
        lines.push(row(
            "work",
            &format!("p_{name} changes by the work of the force, {work:.6}, to {:.1e}", defect.abs()),
        ));
    }
    if let Some(OfX { newtonian, bound, .. }) = &diagnostics.of_x {
        let relation = if bound.is_kept() { "<=" } else { ">" };
        let [h_bvp, most] = [bound.h_bvp, bound.h_bvp_bound].map(|value| value.to_f64());
        lines.push(row("motion", &format!("the acceleration differs from Newton's by {:.1e}", newtonian.deviation)));
        lines.push(row("bound", &format!("H_BVP = {h_bvp:.6} {relation} {most:.6} = Q_t (t_f - t_i)")));
    }
    for (a, sawtooth) in &diagnostics.sawtooth {
        let size = sawtooth.amplitude.map_or("not measurable".to_owned(), |size| format!("{:.1e}", size.to_f64()));
        lines.push(row("sawtooth", &format!("in {}: {size}", names[*a])));
    }
    let action = if line.form == Form::Weak { "E_weak" } else { "E_IVP" };
    let how = iterations(&line.iterations).unwrap_or("an explicit recursion".to_owned());
    let system = if line.is_doubled() { "doubled action" } else { "physical limit" };
    lines.push(row("critical", &format!("|grad {action}| = {:.1e}, {system}, {how}", line.gradient_norm.to_f64())));
    lines.concat()
}

/// The value of a charge, and by how much it changes at the nodes.
fn deviation<S: Real>(name: &str, charge: &ChargeDeviation<S>, line: &WorldLine<S>) -> String {
    let of = |value: S| value.to_f64();
    let at_last = match line.form {
        Form::Strong => {
            let [last, corrected] = [charge.max_last, charge.max_corrected].map(of);
            format!(", at the last node of a window by {last:.2e}, or {corrected:.1e} with its multiplier")
        }
        Form::Weak => String::new(),
    };
    let [value, interior, ends] = [charge.value, charge.max_interior, charge.max_ends].map(of);
    format!("{name} = {value:.6}; changes by {interior:.1e} at nodes{at_last}; {ends:.1e} between windows")
}

/// The number of iterations that a run took, with their kind, if it took any.
fn iterations(&Iterations { count, initial_guess, .. }: &Iterations) -> Option<String> {
    match count {
        0 => None,
        count if initial_guess == InitialGuess::Extrapolation => Some(format!("{count} evaluations of the force")),
        1 => Some("1 Newton iteration".to_owned()),
        count => Some(format!("{count} Newton iterations")),
    }
}
