//! `converge [CASE]`.

use std::io::{self, Write};
use std::process::ExitCode;

use anyhow::Context;
use clap::Args;
use geodesic_ivp::Case;
use geodesic_ivp::case::{Form, SbpName};
use geodesic_ivp::output::{ConvergenceSummary, OutputSet, pictures, write_convergence, write_slopes};
use geodesic_ivp::scalar::{Extended, Real};
use geodesic_ivp::study::convergence::{Convergence, Quantity, Slope, SweepError, sweep};
use indicatif::{ProgressBar, ProgressStyle};

use super::interrupt::{self, INTERRUPTED};
use super::out::OutArgs;
use super::{CaseArgs, memory, report};

const CONVERGENCE: &str = "convergence.csv";
const SLOPES: &str = "slopes.csv";
const SUMMARY: &str = "summary.json";
const FINAL_ERRORS: &str = "errors_final.svg";
const L2_ERRORS: &str = "errors_l2.svg";

#[derive(Debug, Args)]
pub(super) struct ConvergeArgs {
    #[command(flatten)]
    case: CaseArgs,

    #[command(flatten)]
    output: OutArgs,

    /// Numbers of nodes to sweep: of each of the case's windows; of all together for a spectral element, whose windows they fix
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', value_parser = nodes, default_value = "16,32,64,128,256,512,1024")]
    n_gamma: Vec<usize>,

    /// Operators to sweep
    #[arg(long, value_name = "SBP,SBP,…", value_delimiter = ',', value_parser = sbp_name, default_value = "SBP21,SBP42")]
    sbp: Vec<SbpName>,

    /// Forms of the action to sweep [default: the case's]
    #[arg(long, value_name = "FORM,FORM", value_delimiter = ',', value_parser = form)]
    form: Vec<Form>,

    /// Also draw the errors and their fits as SVG
    #[arg(long)]
    plot: bool,

    /// Fit only grids with MIN <= N <= MAX [default: all above the rounding plateau]
    #[arg(long, value_name = "MIN:MAX", value_parser = range)]
    fit_range: Option<(usize, usize)>,
}

fn nodes(text: &str) -> Result<usize, String> {
    text.trim().parse().ok().filter(|&n| n >= 2).ok_or_else(|| "expected a number of nodes, 2 or more".to_owned())
}

fn sbp_name(name: &str) -> Result<SbpName, String> {
    SbpName::try_from(name.trim().to_owned())
}

fn form(name: &str) -> Result<Form, String> {
    Form::try_from(name.trim().to_owned())
}

fn range(text: &str) -> Result<(usize, usize), String> {
    let parsed = text.split_once(':').and_then(|(min, max)| Some((min.parse().ok()?, max.parse().ok()?)));
    parsed
        .filter(|(min, max)| min < max)
        .ok_or_else(|| "expected MIN:MAX with MIN < MAX, for example 64:256".to_owned())
}

pub(super) fn converge(args: &ConvergeArgs) -> anyhow::Result<ExitCode> {
    let case = args.case.read()?;
    if case.is_extended() { converge_in::<Extended>(&case, args) } else { converge_in::<f64>(&case, args) }
}

fn converge_in<S: Real>(case: &Case, args: &ConvergeArgs) -> anyhow::Result<ExitCode> {
    for warning in case.warnings() {
        report::warn(&warning);
    }
    let finest = args.n_gamma.iter().max().copied().unwrap_or(0);
    for grid in args.sbp.iter().filter_map(|&sbp| case.on_grid((sbp, case.scheme.form), finest, 1.0).ok()) {
        memory::check(&grid, None)?;
    }
    let target = args.output.target(&args.case, "converge")?;
    let directory = target.folder.clone();
    let pictures: &[&str] = if args.plot { &[FINAL_ERRORS, L2_ERRORS] } else { &[] };
    let files = OutputSet::open(target, &[&[CONVERGENCE, SLOPES, SUMMARY], pictures].concat())?;
    let convergence = match sweep_with_progress::<S>(case, args)? {
        Ok(convergence) => convergence,
        Err(error) => {
            // An impossible grid is a mistake on the command line and changes nothing; a case without a reference has no
            // results, and those of an earlier sweep must not stand for it.
            if matches!(error, SweepError::Reference(_)) {
                files.commit(|_| false)?;
            }
            return Err(error.into());
        }
    };
    let slopes = convergence.slopes(args.fit_range.unwrap_or((0, usize::MAX)));
    for slope in &slopes {
        if let Some(warning) = slope.warning() {
            report::warn(&warning);
        }
    }
    write_convergence(files.writer(CONVERGENCE), &convergence.points).context("cannot write convergence.csv")?;
    write_slopes(files.writer(SLOPES), &slopes).context("cannot write slopes.csv")?;
    files.write_text(SUMMARY, &ConvergenceSummary::new(case, &convergence, &slopes).to_json())?;
    if args.plot {
        let title = case.title.as_deref().unwrap_or("Convergence");
        // Of many schemes x alone: twice as many curves would be too many to tell apart.
        let first = usize::from(slopes.len() > 4 * Quantity::ALL.len());
        for (name, what, quantities) in [
            (FINAL_ERRORS, "errors at the end", [Quantity::EpsTFinal, Quantity::EpsXFinal]),
            (L2_ERRORS, "errors in the L2 norm", [Quantity::EpsTL2, Quantity::EpsXL2]),
        ] {
            let chart = pictures::errors(&format!("{title}: {what}"), &convergence, &slopes, &quantities[first..]);
            files.write_text(name, &chart.to_svg())?;
        }
    }
    let kept = files.commit(|_| true)?;
    if !args.case.quiet {
        let text = readable(case, &convergence, &slopes) + &report::written(&directory, &kept);
        io::stdout().write_all(text.as_bytes())?;
    }
    if convergence.interrupted {
        report::warn(&format!(
            "interrupted: {} grids were finished and are in {}",
            convergence.points.len(),
            directory.display()
        ));
        return Ok(ExitCode::from(INTERRUPTED));
    }
    if convergence.points.iter().all(|point| point.errors.is_none()) {
        report::warn("no grid of the sweep has a solution: raise --n-gamma, or shorten the run");
        return Ok(ExitCode::from(report::NO_CRITICAL_POINT));
    }
    Ok(ExitCode::SUCCESS)
}

/// Sweeps with a bar on a terminal's standard error; an interrupt lets running grids finish and starts no more, a
/// second one ends the program at once.
fn sweep_with_progress<S: Real>(
    case: &Case,
    args: &ConvergeArgs,
) -> anyhow::Result<Result<Convergence<S>, SweepError>> {
    let cancel = interrupt::flag()?;
    let forms = if args.form.is_empty() { &[case.scheme.form] } else { args.form.as_slice() };
    let schemes: Vec<_> = args.sbp.iter().flat_map(|&sbp| forms.iter().map(move |&form| (sbp, form))).collect();
    let grids = (args.n_gamma.len() * schemes.len()) as u64;
    let bar = if args.case.quiet { ProgressBar::hidden() } else { ProgressBar::new(grids) };
    bar.set_style(ProgressStyle::with_template("{bar:30} {pos}/{len} grids {msg}").expect("the template is valid"));
    let result = sweep(case, &schemes, &args.n_gamma, &cancel, &|point| {
        bar.set_message(format!("last: {} N = {}", point.sbp, point.n_gamma));
        bar.inc(1);
    });
    bar.finish_and_clear();
    Ok(result)
}

fn readable<S>(case: &Case, convergence: &Convergence<S>, slopes: &[Slope]) -> String {
    let title = case.title.as_deref().unwrap_or("geodesic-ivp");
    let mut text = format!(
        "{title}: convergence against a Taylor trajectory (its estimated error {:.1e})\n",
        convergence.reference.error_estimate
    );
    text += "  operator    quantity      slope         against 1/N  fitted N        points\n";
    for slope in slopes {
        let operator = slope.scheme();
        let quantity = slope.quantity.as_str();
        let Some((fit, (n_min, n_max))) = slope.fit.as_ref().zip(slope.n_range) else {
            text += &format!("  {operator:<10}  {quantity:<12}  -\n");
            continue;
        };
        let error = fit.standard_error.map_or(String::new(), |e| format!(" ± {e:.3}"));
        let fitted = format!("{n_min} … {n_max}");
        text += &format!(
            "  {operator:<10}  {quantity:<12}  {:<12}  {:<11.3}  {fitted:<14}  {}\n",
            format!("{:.3}{error}", fit.slope),
            fit.slope_vs_inverse_n,
            slope.points
        );
    }
    for point in convergence.points.iter().filter(|point| point.errors.is_none()) {
        text += &format!("  {} N = {}: {}\n", point.sbp, point.n_gamma, point.status);
    }
    text
}
