//! The summary of a run for people: first how good the result is, then how it was found.

use geodesic_ivp::Solution;
use geodesic_ivp::case::Form;
use geodesic_ivp::diagnostics::gaps::Gaps;
use geodesic_ivp::diagnostics::{Bound, ChargeDeviation, Diagnostics, NEGLIGIBLE, Newtonian, NormDeviation, OfX};
use geodesic_ivp::number::Real;
use geodesic_ivp::output::Summary;
use geodesic_ivp::solve::{InitialGuess, Iterations};
use geodesic_ivp::study::errors::RunError;
use geodesic_ivp::study::run::{Judged, Run};

/// A constant of motion whose relative deviation is at most this many units of 10^-digits is kept to rounding.
const ROUNDING: f64 = 1e5;

/// The summary without the list of files.
pub(super) fn readable<S: Real>(
    title: &str,
    run: &Run<S>,
    judged: &Judged,
    summary: &Summary,
    event_names: &[&str],
) -> String {
    let Run { line, diagnostics, .. } = run;
    let error = judged.error.as_ref();
    let mut lines = vec![title.to_owned()];
    match &diagnostics.of_x {
        Some(of_x) => lines.extend([
            row("end", &end(line, error)),
            row("kept", &kept(line, diagnostics, of_x, error, summary.verdict.digits)),
            row("Q_t", &charge(line, &diagnostics.charges[0])),
            row("K", &second_invariant(line, &diagnostics.norm)),
            row("Newton", &newton(&of_x.newtonian)),
            row("critical", &critical_point(line, diagnostics, &of_x.bound)),
            row("scheme", &scheme(line, summary)),
        ]),
        None => lines.extend(super::scene_readable::lines(run, error, event_names)),
    }
    lines.extend(judged.gaps.as_ref().map(between));
    lines.join("\n") + "\n"
}

/// What was found between the nodes.
fn between(gaps: &Gaps) -> String {
    let Gaps { count, unproved, accuracy, .. } = gaps;
    let found = match unproved {
        0 => format!("nothing hides in the {count} gaps between nodes"),
        _ => format!("{unproved} of {count} gaps between nodes are not explained"),
    };
    row("between", &format!("{found}, beside an accuracy of {accuracy:.0e}"))
}

/// A line with its name.
pub(super) fn row(name: &str, text: &str) -> String {
    format!("  {name:<10} {text}")
}

/// t and x at the end, with as many digits as their errors allow.
fn end<S: Real>(solution: &Solution<S>, error: Option<&RunError>) -> String {
    let (t, x) = (solution.end_state().t, solution.end_state().x);
    let Some(error) = error else {
        let all = |number: S| number.to_decimal(solution.digits);
        return format!("t = {}, x = {}; no second solve to compare with", all(t), all(x));
    };
    let (end, most) = (error.at_most_at_end(), error.at_most());
    let ([in_t, in_x], [most_t, most_x]) = ([end[0], end[1]], [most[0], most[1]]);
    // Rounding aside, the end is often where the errors are largest.
    let most = if in_t == 0.0 && most_x > 1.2 * in_x {
        format!(", at most {most_x:.1e} on the way")
    } else if in_t > 0.0 && (most_t > 1.2 * in_t || most_x > 1.2 * in_x) {
        format!(", at most {most_t:.1e} and {most_x:.1e} on the way")
    } else {
        String::new()
    };
    let off = if in_t == 0.0 { format!("x is off by {in_x:.1e}") } else { format!("off by {in_t:.1e} and {in_x:.1e}") };
    format!(
        "t = {}, x = {}; {off}{most} ({})",
        to_its_digits(t, in_t, solution.digits),
        to_its_digits(x, in_x, solution.digits),
        error.judge.describe()
    )
}

/// A number rounded at the first decimal that is affected by its error.
fn to_its_digits<S: Real>(number: S, error: f64, digits: u32) -> String {
    let size = number.to_f64().abs();
    let significant = (size.log10().floor() - error.log10().floor()) + 1.0;
    if !(size > 0.0 && error > 0.0 && size.is_finite() && significant <= f64::from(digits)) {
        return number.to_decimal(digits);
    }
    if S::IS_EXTENDED {
        return number.to_decimal(significant.max(1.0) as u32);
    }
    let decimals = (-error.log10().floor()).max(0.0) as usize;
    let number = positive_zero(number.to_f64());
    if is_readable(number) {
        format!("{number:.decimals$}")
    } else {
        format!("{number:.*e}", significant.max(1.0) as usize - 1)
    }
}

/// What is kept, and how well: the constants of motion, and the digits of t and x.
fn kept<S: Real>(
    solution: &Solution<S>,
    diagnostics: &Diagnostics<S>,
    of_x: &OfX<S>,
    error: Option<&RunError>,
    digits: Option<u32>,
) -> String {
    let rounding = ROUNDING * 10.0_f64.powi(-(solution.digits as i32));
    let kept = |name: &str, deviation: S, size: S| {
        let share = (deviation.to_f64() / size.to_f64()).abs();
        match share {
            _ if deviation == S::ZERO || share <= rounding => format!("{name} is exact"),
            _ if size == S::ZERO => format!("{name} is kept to {:.1e}", deviation.to_f64()),
            _ if share < 1.0 => format!("{name} is kept to {}", percent(share)),
            _ => format!("{name} is lost"),
        }
    };
    let k = diagnostics.norm.max_interior.max(diagnostics.norm.max_ends);
    let charge = kept("Q_t", diagnostics.charges[0].max_interior, solution.q_t());
    let second = second_kept(k.to_f64(), solution.norm().to_f64(), of_x.scales.x_dot, rounding);
    // The error of t is 0 where the run ends at a given time.
    let (what, verb) =
        if error.is_some_and(|error| error.at_most_at_end()[0] == 0.0) { ("x", "is") } else { ("t and x", "are") };
    let position = match digits {
        None => "how good t and x are is not known".to_owned(),
        Some(digits) if digits >= 2 => format!("{what} {verb} good to {digits} digits"),
        Some(1) => format!("{what} {verb} good to one digit"),
        Some(_) => format!("{what} {verb} wrong"),
    };
    format!("{charge}; {second}; {position}")
}

/// How well K is kept, relative to the largest ẋ². K itself can be as large as c², and relative to that a change of
/// speed would not be seen.
fn second_kept(deviation: f64, k: f64, x_dot: f64, rounding: f64) -> String {
    let motion = if x_dot > 0.0 { x_dot * x_dot } else { k.abs() };
    let share = deviation / motion;
    let is_rounding = deviation <= rounding * k.abs();
    match share {
        _ if deviation == 0.0 || is_rounding && share < 1e-2 => "K is kept to rounding".to_owned(),
        _ if is_rounding => "K is lost in rounding, as c is very large".to_owned(),
        _ if share < 1.0 => format!("K is kept to {}", percent(share)),
        _ => "K is lost".to_owned(),
    }
}

fn percent(share: f64) -> String {
    match share {
        0.1.. => format!("{:.0} %", 100.0 * share),
        1e-4.. => format!("{:.2} %", 100.0 * share),
        _ => format!("{share:.1e}"),
    }
}

fn charge<S: Real>(solution: &Solution<S>, charge: &ChargeDeviation<S>) -> String {
    let q_t = fixed(solution.q_t().to_f64(), 6);
    let interior = charge.max_interior.to_f64();
    if solution.form == Form::Weak {
        return format!("{q_t}; |dQ_t| <= {interior:.1e} at all nodes");
    }
    let corrected = charge.max_corrected.to_f64();
    let (last, which) = match solution.window_count {
        1 => (charge.last, "the last"),
        _ => (charge.max_last, "the last of each window"),
    };
    let last = last.to_f64().abs();
    format!(
        "{q_t}; |dQ_t| <= {interior:.1e} at all nodes but {which}, where Dt takes up the defect of D: \
         {last:.2e}, or {corrected:.1e} with its multiplier"
    )
}

fn second_invariant<S: Real>(solution: &Solution<S>, norm: &NormDeviation<S>) -> String {
    let but_last = match (solution.form, solution.window_count) {
        (Form::Weak, _) => "",
        (Form::Strong, 1) => " but the last",
        (Form::Strong, _) => " but the last of each window",
    };
    let ends = if solution.window_count == 1 { "the end" } else { "the ends" };
    format!(
        "{}; |dK| <= {:.2e} at all nodes{but_last}, {:.2e} at {ends} handed on",
        fixed(solution.norm().to_f64(), 6),
        norm.max_interior.to_f64(),
        norm.max_ends.to_f64()
    )
}

fn newton(newtonian: &Newtonian) -> String {
    let deviation = newtonian.deviation;
    if deviation == 0.0 {
        return "the motion is Newton's".to_owned();
    }
    let remedy = match newtonian.c() {
        Some(c) if deviation > 2.0 * NEGLIGIBLE => format!("; c = {c} would make that about {NEGLIGIBLE:e}"),
        _ => String::new(),
    };
    format!("the acceleration differs from Newton's by up to {}{remedy}", percent(deviation))
}

fn critical_point<S: Real>(solution: &Solution<S>, diagnostics: &Diagnostics<S>, bound: &Bound<S>) -> String {
    let action = if solution.form == Form::Weak { "E_weak" } else { "E_IVP" };
    let sawtooth =
        diagnostics.sawtooth[0].1.amplitude.map_or("not measurable".to_owned(), |s| format!("{:.1e}", s.to_f64()));
    format!(
        "|grad {action}| <= {:.1e}: a critical point of the action; sawtooth in x {sawtooth}; \
         H_BVP = {} {} {} = Q_t (t_f - t_i)",
        solution.gradient_norm.to_f64(),
        fixed(bound.h_bvp.to_f64(), 6),
        if bound.is_kept() { "<=" } else { ">" },
        fixed(bound.h_bvp_bound.to_f64(), 6)
    )
}

fn scheme<S: Real>(solution: &Solution<S>, summary: &Summary) -> String {
    let nodes = match solution.window_count {
        1 => format!("{} nodes", solution.sbp().points()),
        windows => format!("{windows} windows of {} nodes", solution.sbp().points()),
    };
    let system = if solution.is_doubled() { "doubled action" } else { "physical limit" };
    let iterations = iterations(&solution.iterations).unwrap_or("explicit".to_owned());
    let digits = if S::IS_EXTENDED { format!(", {} digits", solution.digits) } else { String::new() };
    format!(
        "{} {}, {system}, {nodes} on gamma in [{}, {}]{digits}: {iterations}, {:.3} ms",
        summary.sbp,
        solution.form.as_str(),
        plain(solution.gamma_i.to_f64()),
        plain(solution.gamma_f().to_f64()),
        1e3 * summary.solve_seconds
    )
}

/// How many iterations of which kind a run took, if it took any.
pub(super) fn iterations(&Iterations { count, initial_guess, .. }: &Iterations) -> Option<String> {
    match count {
        0 => None,
        count if initial_guess == InitialGuess::Extrapolation => Some(format!("{count} evaluations of the force")),
        1 => Some("1 Newton iteration".to_owned()),
        count => Some(format!("{count} Newton iterations")),
    }
}

/// The number, with 0 in place of −0.
fn positive_zero(number: f64) -> f64 {
    if number == 0.0 { 0.0 } else { number }
}

/// Whether a number is easy to read without an exponent.
fn is_readable(number: f64) -> bool {
    number == 0.0 || (1e-4..1e9).contains(&number.abs())
}

/// A number with the given number of decimals. Very small and very large numbers have an exponent instead.
fn fixed(number: f64, decimals: usize) -> String {
    let number = positive_zero(number);
    if is_readable(number) { format!("{number:.decimals$}") } else { format!("{number:.decimals$e}") }
}

/// A number with all its digits.
fn plain(number: f64) -> String {
    let number = positive_zero(number);
    if is_readable(number) { number.to_string() } else { format!("{number:e}") }
}
