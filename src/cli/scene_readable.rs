//! The summary of a scene's run for people.

use geodesic_ivp::action::Form;
use geodesic_ivp::diagnostics::{ChargeDeviation, Diagnostics};
use geodesic_ivp::number::Real;
use geodesic_ivp::solve::WorldLine;
use geodesic_ivp::study::errors::{Judge, RunError};
use geodesic_ivp::study::run::Run;
use geodesic_ivp::trajectory::Crossing;

use super::readable::{iterations, row};

/// The lines of a run without its title. `event_names` are those of what was watched.
pub(super) fn lines<S: Real>(run: &Run<S>, error: Option<&RunError>, event_names: &[&str]) -> Vec<String> {
    let Run { line, diagnostics, sums, .. } = run;
    let names = line.geometry().names();
    let mut lines = vec![end(line), accuracy(line, error)];
    for charge in &diagnostics.charges {
        let name = &names[charge.terms[0].0];
        lines.push(deviation(&format!("p_{name}"), charge.value, charge.max_interior, line) + &at_last(line, charge));
    }
    for (sum, charge) in sums.iter().zip(&diagnostics.sums) {
        let between = format!(", {:.1e} between windows", charge.max_ends.to_f64());
        lines.push(deviation(&sum.formula(names), charge.value, charge.max_interior, line) + &between);
    }
    for work in &diagnostics.work {
        let name = format!("p_{}", names[work.coordinate]);
        let (work, defect) = (work.work.to_f64(), work.defect.to_f64().abs());
        lines.push(row(&name, &format!("changes by the work of the force, {work:.6}, to {defect:.1e}")));
    }
    lines.push(drift(diagnostics));
    for invariant in &diagnostics.invariants {
        let [most, ends] = [invariant.max, invariant.max_ends].map(|value| value.to_f64());
        let text = format!(
            "{}; changes by at most {most:.1e} at the nodes, {ends:.1e} between windows",
            short(invariant.value)
        );
        lines.push(row(&invariant.name, &text));
    }
    lines.extend(events(event_names, &run.events, line.digits));
    lines.push(critical_point(line));
    lines.push(scheme(line));
    lines
}

/// A line for every event: how often it was met, and where. `names` are those of what was watched.
fn events<S: Real>(names: &[&str], crossings: &[Crossing<S>], digits: u32) -> Vec<String> {
    let line = |(watch, name): (usize, &&str)| {
        let gammas: Vec<S> =
            crossings.iter().filter(|crossing| crossing.watch == watch).map(|crossing| crossing.sample.gamma).collect();
        let at = |gamma: &S| gamma.to_decimal(digits);
        let text = match gammas.as_slice() {
            [] => "not met".to_owned(),
            [one] => format!("met once, at gamma = {}", at(one)),
            [first, .., last] => {
                format!("met {} times, first at gamma = {}, last at {}", gammas.len(), at(first), at(last))
            }
        };
        row(name, &text)
    };
    names.iter().enumerate().map(line).collect()
}

fn short<S: Real>(value: S) -> String {
    let value = value.to_f64();
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) { format!("{value:.6}") } else { format!("{value:.6e}") }
}

fn end<S: Real>(line: &WorldLine<S>) -> String {
    let names = line.geometry().names();
    let position = names.iter().zip(line.end().q).map(|(name, q)| format!("{name} = {}", q.to_decimal(line.digits)));
    row("end", &position.collect::<Vec<_>>().join(", "))
}

/// By how much the end is off, and how that is known.
fn accuracy<S: Real>(line: &WorldLine<S>, error: Option<&RunError>) -> String {
    let Some(error) = error else { return row("error", "unknown: no second solve reaches the end") };
    let of = line.geometry().names().iter().zip(error.at_most_at_end());
    let of: Vec<String> = of.map(|(name, error)| format!("{name} {error:.1e}")).collect();
    let estimate = |estimate| format!("; estimated at {estimate:.1e} at most, relative to sizes");
    let estimate = line.error_estimate.map_or(String::new(), estimate);
    let judge = if error.judge == Judge::OwnEstimate { String::new() } else { format!(", {}", error.judge.describe()) };
    row("error", &format!("{} at the end{judge}{estimate}", of.join(", ")))
}

/// What measures the error although the scheme does not keep it: K or, with Newton's law, the energy.
fn drift<S: Real>(diagnostics: &Diagnostics<S>) -> String {
    match diagnostics.energy {
        Some(energy) => {
            let of = "that of the positions and velocities differs from p_t/p_s";
            let most = energy.max_ends.to_f64().abs();
            row("energy", &format!("{}; {of} by at most {most:.1e} between windows", short(energy.value)))
        }
        None => {
            let ends = diagnostics.norm.max_ends.to_f64();
            row("K", &format!("{}; drifts by at most {ends:.1e} between windows", short(diagnostics.norm.value)))
        }
    }
}

fn deviation<S: Real>(name: &str, value: S, most: S, line: &WorldLine<S>) -> String {
    let nodes = match line.form {
        Form::Strong => "all nodes but the last",
        Form::Weak => "every node",
    };
    row(name, &format!("{}; |change| <= {:.1e} at {nodes}", short(value), most.to_f64()))
}

/// What the last node of the strong form takes up.
fn at_last<S: Real>(line: &WorldLine<S>, charge: &ChargeDeviation<S>) -> String {
    match line.form {
        Form::Strong => {
            let [last, corrected] = [charge.max_last, charge.max_corrected].map(|value| value.to_f64());
            format!(", where Dq takes up the defect of D: {last:.2e}, or {corrected:.1e} with its multiplier")
        }
        Form::Weak => String::new(),
    }
}

fn critical_point<S: Real>(line: &WorldLine<S>) -> String {
    let how = iterations(&line.iterations).unwrap_or("an explicit recursion".to_owned());
    row("grad E", &format!("{:.1e}, from {how}", line.gradient_norm.to_f64()))
}

fn scheme<S: Real>(line: &WorldLine<S>) -> String {
    let windows = line.window_count;
    let cut = if windows > 1 { format!(" in each of {windows} windows") } else { String::new() };
    let (name, form) = (String::from(line.sbp_name), line.form.as_str());
    row("scheme", &format!("{name}, {form} form, {} nodes{cut}", line.sbp().points()))
}
