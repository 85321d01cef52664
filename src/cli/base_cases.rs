//! `converge` without a case: the slopes of the paper's four base cases (two potentials with two operators each) beside
//! the published ones.

use std::process::ExitCode;

use geodesic_ivp::case::Form;
use geodesic_ivp::output::json_object;
use geodesic_ivp::study::convergence::Quantity;
use geodesic_ivp::study::convergence::paper::{BASE_CASES, published};

use super::converge::{COMMAND, ConvergeArgs, Line, Swept, sweep_into, table};
use super::lines::row;
use super::report::{self, Interrupted};

/// Sweeps the base cases, writes the files of each into a folder of its name, and prints one table.
pub(super) fn converge(args: &ConvergeArgs) -> anyhow::Result<ExitCode> {
    let (case, output) = (&args.study.case, &args.study.output);
    if !case.quiet {
        report::note("no CASE is given: the paper's base cases are swept, linear and quartic");
    }
    let (mut all, mut code) = (Vec::new(), 0);
    for name in BASE_CASES {
        let (case, target) = (case.read_built_in(name)?, output.built_in_target(name, COMMAND)?);
        match sweep_into(target, &case, args, &format!("{name}: ")) {
            Ok(swept) => all.push((name, swept)),
            Err(error) if error.is::<Interrupted>() => {
                code = report::explain(&error);
                break;
            }
            Err(error) => return Err(error),
        }
        let (_, swept) = &all[all.len() - 1];
        code = Some(swept.code()).filter(|this| *this != 0).unwrap_or(code);
        if swept.placed.interrupted.is_some() {
            break;
        }
    }
    if !all.is_empty() {
        let summaries: Vec<(&str, String)> = all.iter().map(|(name, swept)| (*name, swept.summary.clone())).collect();
        output.tell(case.quiet, &json_object(&summaries), || summary_text(&all, !case.set.is_empty(), args.verbose))?;
    }
    Ok(ExitCode::from(code))
}

/// The lines of a case: its slopes over the grids of the paper or, where that has none, over all of them.
fn lines(name: &'static str, swept: &Swept, is_changed: bool) -> impl Iterator<Item = Line> {
    swept.slopes.iter().enumerate().map(move |(index, all)| {
        // The paper has no slopes in the L2 norm. They are fitted over the grids of ε_x.
        let of_x = published(name, all.sbp, Quantity::EPS_X_FINAL).filter(|_| all.form == Form::Strong);
        let fitted = of_x.map_or_else(|| all.clone(), |of_x| (swept.over)(of_x.n_range).swap_remove(index));
        Line { case: name, ..Line::new(fitted, Some(name).filter(|_| !is_changed)) }
    })
}

fn summary_text(all: &[(&'static str, Swept)], is_changed: bool, is_verbose: bool) -> String {
    let lines: Vec<Line> = all.iter().flat_map(|(name, swept)| lines(name, swept, is_changed)).collect();
    let difference = |line: &Line| Some((line.paper? - line.slope.fit.as_ref()?.slope_vs_inverse_n).abs());
    let title = match lines.iter().filter_map(difference).reduce(f64::max) {
        _ if is_changed => "The paper's base cases, changed by --set".to_owned(),
        None => "The paper's base cases".to_owned(),
        Some(most) => {
            format!("The paper's base cases: the slopes against 1/N agree with those of the paper to {most:.2}")
        }
    };
    let step = "against the step, 1/(N - 1); those of the paper are against 1/N (--verbose has both)";
    let error = all.iter().map(|(_, swept)| swept.reference_error).fold(0.0, f64::max);
    let error = row("error", &format!("against Taylor trajectories, themselves good to {error:.0e}"));
    let written: String = all.iter().map(|(_, swept)| swept.placed.written.as_str()).collect();
    format!("{title}\n{}{}{error}{written}", table(&lines, is_verbose), row("slope", step))
}
