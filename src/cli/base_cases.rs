//! `converge` without a case: the slopes of the paper's four base cases (two potentials with two operators each) beside
//! the published ones.

use std::process::ExitCode;

use geodesic_ivp::case::Form;
use geodesic_ivp::output::json_object;
use geodesic_ivp::study::convergence::Quantity;
use geodesic_ivp::study::convergence::paper::{BASE_CASES, PUBLISHED_SLOPES, published};

use super::converge::{COMMAND, ConvergeArgs, Line, Swept, sweep_into, table};
use super::lines::row;
use super::{interrupt, report};

/// Sweeps the base cases, writes the files of each into a folder of its name, and prints one table.
pub(super) fn converge(args: &ConvergeArgs) -> anyhow::Result<ExitCode> {
    if !args.case.quiet {
        report::note("no CASE is given: the paper's base cases are swept, linear and quartic");
    }
    args.output.check_standard_output()?;
    let (mut found, mut summaries, mut written, mut error) = (Vec::new(), Vec::new(), String::new(), 0.0_f64);
    let is_changed = !args.case.set.is_empty();
    let mut ending = ExitCode::SUCCESS;
    for name in BASE_CASES {
        let case = args.case.read_built_in(name)?;
        let ranges = ranges(name);
        let swept = sweep_into(args.output.built_in_target(name, COMMAND), &case, args, &ranges, &format!("{name}: "))?;
        let Some(swept) = swept else {
            ending = interrupt::before_any_result();
            break;
        };
        found.extend(lines(name, &swept, is_changed));
        error = error.max(swept.reference_error);
        written += &swept.study.written;
        summaries.push((name, swept.study.summary.clone()));
        let this = swept.study.ending(|| swept.code());
        if this != ExitCode::SUCCESS {
            ending = this;
        }
        if swept.study.interrupted.is_some() {
            break;
        }
    }
    if !summaries.is_empty() {
        args.output.tell(args.case.quiet, &json_object(&summaries), || {
            readable(&found, is_changed, error, args.verbose) + &written
        })?;
    }
    Ok(ending)
}

/// The ranges of N over which a case has its published slopes.
fn ranges(case: &str) -> Vec<(usize, usize)> {
    let mut ranges: Vec<_> = PUBLISHED_SLOPES.iter().filter(|one| one.case == case).map(|one| one.n_range).collect();
    ranges.dedup();
    ranges
}

/// The lines of a case: its slopes over the grids of the paper or, where that has none, over all of them.
fn lines(name: &'static str, swept: &Swept, is_changed: bool) -> impl Iterator<Item = Line> {
    swept.slopes.iter().enumerate().map(move |(index, all)| {
        // The paper has no slopes in the L2 norm. They are fitted over the grids of ε_x.
        let of_x = published(name, all.sbp, Quantity::EPS_X_FINAL).filter(|_| all.form == Form::Strong);
        let place = ranges(name).iter().position(|one| of_x.is_some_and(|of_x| of_x.n_range == *one));
        let fitted = place.map_or(all, |place| &swept.beside[place][index]);
        Line { case: name, ..Line::new(fitted.clone(), Some(name).filter(|_| !is_changed)) }
    })
}

fn readable(lines: &[Line], is_changed: bool, error: f64, is_verbose: bool) -> String {
    let difference = |line: &Line| Some((line.paper? - line.slope.fit.as_ref()?.slope_vs_inverse_n).abs());
    let title = match lines.iter().filter_map(difference).reduce(f64::max) {
        _ if is_changed => "The paper's base cases, changed by --set".to_owned(),
        None => "The paper's base cases".to_owned(),
        Some(most) => {
            format!("The paper's base cases: the slopes against 1/N agree with those of the paper to {most:.2}")
        }
    };
    let step = "against the step, 1/(N - 1); those of the paper are against 1/N (--verbose has both)";
    let error = format!("against Taylor trajectories, themselves good to {error:.0e}");
    format!("{title}\n{}{}{}", table(lines, is_verbose), row("slope", step), row("error", &error))
}
