//! `converge [CASE]`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::Context;
use clap::Args;
use geodesic_ivp::Case;
use geodesic_ivp::case::{Form, SbpName, on_grid};
use geodesic_ivp::number::Extended;
use geodesic_ivp::number::Real;
use geodesic_ivp::output::{
    OutputSet, SUMMARY, Target, convergence_summary, pictures, write_convergence, write_slopes,
};
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::study::convergence::{Convergence, ConvergencePoint, Quantity, Slope, Sweep, SweepError};
use indicatif::{ProgressBar, ProgressStyle};

use super::interrupt::{self, INTERRUPTED};
use super::out::OutArgs;
use super::{CaseArgs, base_cases, memory, report};

pub(super) const COMMAND: &str = "converge";
const CONVERGENCE: &str = "convergence.csv";
const SLOPES: &str = "slopes.csv";
const FINAL_ERRORS: &str = "errors_final.svg";
const L2_ERRORS: &str = "errors_l2.svg";

/// With more schemes than this, not all errors are drawn.
const MOST_SCHEMES: usize = 4;

#[derive(Debug, Args)]
pub(super) struct ConvergeArgs {
    #[command(flatten)]
    pub(super) case: CaseArgs,

    #[command(flatten)]
    pub(super) output: OutArgs,

    /// Numbers of nodes to sweep: of each of the case's windows; of all together for a spectral element, whose windows
    /// they fix
    #[arg(
        long,
        value_name = "N,N,…",
        value_delimiter = ',',
        value_parser = nodes,
        default_value = "16,32,64,128,256,512,1024"
    )]
    n_gamma: Vec<usize>,

    /// Operators to sweep
    #[arg(
        long,
        value_name = "SBP,SBP,…",
        value_delimiter = ',',
        value_parser = sbp_name,
        default_value = "SBP21,SBP42"
    )]
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
    if !args.case.is_given() {
        return base_cases::converge(args);
    }
    let case = args.case.read()?;
    args.output.check_standard_output()?;
    let target = args.output.target(&args.case, COMMAND)?;
    let Some(swept) = sweep_into(target, &case, args, &[], "")? else { return Ok(interrupt::before_any_result()) };
    args.output.tell(args.case.quiet, &swept.summary, || swept.table.clone() + &swept.written)?;
    Ok(swept.ending())
}

/// A sweep whose files have been written.
pub(super) struct Swept {
    /// The slopes for people.
    table: String,
    /// The text of summary.json.
    pub(super) summary: String,
    pub(super) written: String,
    /// Slopes over all grids above the rounding plateau.
    pub(super) slopes: Vec<Slope>,
    /// Slopes over each of the further ranges that were asked for.
    pub(super) beside: Vec<Vec<Slope>>,
    /// The reference's estimate of its own relative error.
    pub(super) reference_error: f64,
    /// If the sweep was interrupted, the number of grids that were finished.
    pub(super) interrupted: Option<usize>,
    /// Whether any grid has a solution.
    solved: bool,
    directory: PathBuf,
}

impl Swept {
    /// The exit code. Warns if the sweep was interrupted or no grid has a solution.
    pub(super) fn ending(&self) -> ExitCode {
        if let Some(grids) = self.interrupted {
            report::warn(&format!("interrupted: {grids} grids were finished and are in {}", self.directory.display()));
            return ExitCode::from(INTERRUPTED);
        }
        if !self.solved {
            report::warn("no grid of the sweep has a solution: raise --n-gamma, or shorten the run");
            return ExitCode::from(report::NO_CRITICAL_POINT);
        }
        ExitCode::SUCCESS
    }
}

/// Sweeps a case and writes its files; `None` if it was interrupted before there was a reference. Slopes are also
/// fitted over the ranges of `beside`. Warnings begin with `name`.
pub(super) fn sweep_into(
    target: Target,
    case: &Case,
    args: &ConvergeArgs,
    beside: &[(usize, usize)],
    name: &str,
) -> anyhow::Result<Option<Swept>> {
    let sweep = if case.is_extended() { sweep_in::<Extended> } else { sweep_in::<f64> };
    sweep(target, case, args, beside, name)
}

/// Whether the finest grids fit into memory.
fn check_memory<S: Arithmetic>(case: &Case, args: &ConvergeArgs) -> anyhow::Result<()> {
    let finest = args.n_gamma.iter().max().copied().unwrap_or(0);
    for &sbp in &args.sbp {
        let grid = on_grid(&case.setup::<S>(), (sbp, case.settings().form), finest, S::ONE).ok();
        grid.map_or(Ok(()), |grid| memory::check(&grid, false, 0))?;
    }
    Ok(())
}

/// Whether even and odd numbers of nodes are mixed where that matters.
fn mixes_parities<S>(convergence: &Convergence<S>) -> bool {
    let is_strong = |point: &&ConvergencePoint| point.form == Form::Strong && point.sbp.fixed_points().is_none();
    let mut parities = convergence.points.iter().filter(is_strong).map(|point| point.n_gamma % 2);
    let first = parities.next();
    parities.any(|parity| Some(parity) != first)
}

fn sweep_in<S: Arithmetic>(
    target: Target,
    case: &Case,
    args: &ConvergeArgs,
    beside: &[(usize, usize)],
    name: &str,
) -> anyhow::Result<Option<Swept>> {
    for warning in case.warnings() {
        report::warn(&format!("{name}{warning}"));
    }
    check_memory::<S>(case, args)?;
    let directory = target.folder.clone();
    let pictures: &[&str] = if args.plot { &[FINAL_ERRORS, L2_ERRORS] } else { &[] };
    let files = OutputSet::open(target, &[&[CONVERGENCE, SLOPES, SUMMARY], pictures].concat())?;
    let convergence = match sweep_with_progress::<S>(case, args) {
        Ok(Some(convergence)) => convergence,
        Ok(None) => return Ok(None),
        Err(error) => {
            // An impossible grid is a mistake on the command line, and nothing is changed. A case without a reference
            // has no results, so the files of an earlier sweep are removed: they must not be taken for its own.
            if matches!(error, SweepError::Reference(_)) {
                files.commit(&|_| false)?;
            }
            return Err(error.into());
        }
    };
    let n_range = args.fit_range.unwrap_or((0, usize::MAX));
    let slopes = convergence.slopes(n_range);
    if case.settings().windows == 1 && mixes_parities(&convergence) {
        report::warn(&format!(
            "{name}the grids mix even and odd numbers of nodes, which have different constants of the error at the \
             end in the strong form: fit grids of one parity"
        ));
    }
    for warning in slopes.iter().filter_map(Slope::warning) {
        report::warn(&format!("{name}{warning}"));
    }
    write_convergence(files.writer(CONVERGENCE), &convergence).context("cannot write convergence.csv")?;
    write_slopes(files.writer(SLOPES), &slopes).context("cannot write slopes.csv")?;
    let summary = convergence_summary(case.title(), case.warnings(), &convergence, &slopes);
    files.write_text(SUMMARY, &summary)?;
    let title = args.case.headed(case.title());
    if args.plot {
        draw(&title, &convergence, (&slopes, n_range), &files)?;
    }
    let kept = files.commit(&|_| true)?;
    Ok(Some(Swept {
        table: readable(&title, &convergence, &slopes),
        summary,
        written: report::written(&directory, &kept),
        beside: beside.iter().map(|&range| convergence.slopes(range)).collect(),
        slopes,
        reference_error: convergence.reference.error_estimate,
        interrupted: convergence.interrupted.then_some(convergence.points.len()),
        solved: convergence.points.iter().any(|point| point.errors.is_some()),
        directory,
    }))
}

fn draw<S: Real>(
    title: &str,
    convergence: &Convergence<S>,
    (slopes, n_range): (&[Slope], (usize, usize)),
    files: &OutputSet,
) -> anyhow::Result<()> {
    let is_one = convergence.coordinates.len() == 2 && convergence.charges.len() == 1;
    for (name, what, at_end) in [(FINAL_ERRORS, "at the end", true), (L2_ERRORS, "in the L2 norm", false)] {
        let (of_x, largest) = match at_end {
            true => (Quantity::EPS_X_FINAL, Quantity::LARGEST_FINAL),
            false => (Quantity::EPS_X_L2, Quantity::LARGEST_L2),
        };
        let shown: Vec<Slope> = if is_one {
            // With many schemes only the errors of x are drawn: twice as many curves would be too many to tell apart.
            let is_crowded = slopes.len() > MOST_SCHEMES * 4;
            let is_shown = |quantity: Quantity| quantity == of_x || (!is_crowded && quantity.is_at_end() == at_end);
            slopes.iter().filter(|slope| is_shown(slope.quantity)).cloned().collect()
        } else {
            // Of several coordinates the largest error is drawn.
            convergence.schemes().into_iter().map(|scheme| convergence.slope(scheme, largest, n_range)).collect()
        };
        let of = if is_one { "errors" } else { "largest error of a coordinate" };
        let chart = pictures::errors(&format!("{title}: {of} {what}"), convergence, &shown);
        files.write_text(name, &chart.to_svg())?;
    }
    Ok(())
}

/// What a sweep reports while it is running.
enum News<S> {
    Ready(Arc<Sweep<S>>),
    Point(usize, ConvergencePoint),
    Impossible(SweepError),
}

/// Sweeps, with a progress bar if standard error is a terminal. After an interrupt the result has the grids that were
/// finished; it is `None` if the reference was not finished.
fn sweep_with_progress<S: Arithmetic>(case: &Case, args: &ConvergeArgs) -> Result<Option<Convergence<S>>, SweepError> {
    let forms = if args.form.is_empty() { &[case.settings().form] } else { args.form.as_slice() };
    let schemes: Vec<_> = args.sbp.iter().flat_map(|&sbp| forms.iter().map(move |&form| (sbp, form))).collect();
    let grids = (args.n_gamma.len() * schemes.len()) as u64;
    let bar = if args.case.quiet { ProgressBar::hidden() } else { ProgressBar::new(grids) };
    bar.set_style(ProgressStyle::with_template("{bar:30} {pos}/{len} grids {msg}").expect("the template is valid"));
    let (case, n_gamma) = (case.clone(), args.n_gamma.clone());
    let new = move || Sweep::new(&case, &schemes, &n_gamma);
    let work = move |tell: &(dyn Fn(News<S>) + Sync)| match new() {
        Ok(sweep) => {
            let sweep = Arc::new(sweep);
            tell(News::Ready(Arc::clone(&sweep)));
            sweep.run(&AtomicBool::new(false), &|place, point| tell(News::Point(place, point.clone())));
        }
        Err(error) => tell(News::Impossible(error)),
    };
    let (mut ready, mut points) = (Ok(None), Vec::new());
    interrupt::beside_it(work, |news| match news {
        News::Ready(sweep) => ready = Ok(Some(sweep)),
        News::Impossible(error) => ready = Err(error),
        News::Point(place, point) => {
            bar.set_message(format!("last: {} N = {}", point.sbp, point.n_gamma));
            bar.inc(1);
            points.push((place, point));
        }
    });
    bar.finish_and_clear();
    Ok(ready?.map(|sweep| sweep.gathered(points)))
}

fn readable<S>(title: &str, convergence: &Convergence<S>, slopes: &[Slope]) -> String {
    let mut text = format!(
        "{title}: convergence against a Taylor trajectory (its estimated error {:.1e})\n",
        convergence.reference.error_estimate
    );
    let width = slopes.iter().map(|slope| slope.name.len()).fold(12, usize::max);
    text += &format!("  operator    {:<width$}  slope          against 1/N  fitted N        points\n", "quantity");
    for slope in slopes {
        let operator = slope.scheme();
        let quantity = &slope.name;
        let Some((fit, (n_min, n_max))) = slope.fit.as_ref().zip(slope.n_range) else {
            text += &format!("  {operator:<10}  {quantity:<width$}  -\n");
            continue;
        };
        let error = fit.standard_error.map_or(String::new(), |e| format!(" ± {e:.3}"));
        let fitted = format!("{n_min} … {n_max}");
        text += &format!(
            "  {operator:<10}  {quantity:<width$}  {:<13}  {:<11.3}  {fitted:<14}  {}\n",
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
