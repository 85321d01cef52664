//! `converge [CASE]`.

use std::process::ExitCode;

use clap::Args;
use geodesic_ivp::Case;
use geodesic_ivp::case::{Form, SbpName, on_grid};
use geodesic_ivp::number::Extended;
use geodesic_ivp::number::Real;
use geodesic_ivp::output::{OutputSet, Target, convergence_summary, convergence_table, pictures, slopes_table};
use geodesic_ivp::study::convergence::paper::published;
use geodesic_ivp::study::convergence::{Convergence, ConvergencePoint, Quantity, Slope, Sweep, SweepError};

use super::lines::{listed, row, wrapped};
use super::memory;
use super::out::{self, RESULTS};
use super::report;
use super::study::{self, Placed, StudyArgs};

pub(super) const COMMAND: &str = "converge";
const CONVERGENCE: &str = "convergence.csv";
const SLOPES: &str = "slopes.csv";
const FINAL_ERRORS: &str = "errors_final.svg";
const L2_ERRORS: &str = "errors_l2.svg";

/// With more schemes than this, not all errors are drawn.
const MOST_SCHEMES: usize = 4;

#[derive(Debug, Args)]
#[command(next_help_heading = "What to measure")]
pub(super) struct ConvergeArgs {
    /// Numbers of nodes
    ///
    /// They are per window for SBP operators, and in total for spectral elements.
    #[arg(
        long,
        value_name = "N,N,…",
        value_delimiter = ',',
        value_parser = nodes,
        default_value = "16,32,64,128,256,512,1024"
    )]
    n_gamma: Vec<usize>,

    #[arg(
        long,
        help = format!("Operators: {}, GLL<n>", SbpName::stencils()),
        value_name = "SBP,SBP,…",
        value_delimiter = ',',
        value_parser = |name: &str| SbpName::try_from(name.trim().to_owned()),
        default_value = "SBP21,SBP42"
    )]
    sbp: Vec<SbpName>,

    /// Forms of the action: strong, weak [default: the case's]
    #[arg(
        long,
        value_name = "FORM,FORM",
        value_delimiter = ',',
        value_parser = |name: &str| Form::try_from(name.trim().to_owned())
    )]
    form: Vec<Form>,

    /// Fit only grids of MIN to MAX nodes, e.g. 64:1024
    ///
    /// Without it all grids are fitted whose errors lie above those of rounding.
    #[arg(long, value_name = "MIN:MAX", value_parser = range)]
    fit_range: Option<(usize, usize)>,

    #[command(flatten)]
    pub(super) study: StudyArgs,

    #[arg(long, short, help_heading = RESULTS)]
    pub(super) verbose: bool,
}

fn nodes(text: &str) -> Result<usize, String> {
    text.trim().parse().ok().filter(|&n| n >= 2).ok_or_else(|| "expected a number of nodes, 2 or more".to_owned())
}

fn range(text: &str) -> Result<(usize, usize), String> {
    let parsed = text.split_once(':').and_then(|(min, max)| Some((min.parse().ok()?, max.parse().ok()?)));
    parsed
        .filter(|(min, max)| min < max)
        .ok_or_else(|| "expected MIN:MAX with MIN < MAX, for example 64:256".to_owned())
}

pub(super) fn converge(args: &ConvergeArgs) -> anyhow::Result<ExitCode> {
    let case = args.study.case.read_for_study()?;
    let target = args.study.output.target(&args.study.case, COMMAND)?;
    out::keep_source(&case, &target)?;
    let swept = sweep_into(target, &case, args, "")?;
    args.study
        .output
        .tell(args.study.case.quiet, &swept.summary, || format!("{}{}", swept.text, swept.placed.written))?;
    Ok(ExitCode::from(swept.code()))
}

/// A sweep whose files are in their places.
pub(super) struct Swept {
    pub(super) placed: Placed,
    /// The text of summary.json.
    pub(super) summary: String,
    /// The lines for people.
    text: String,
    /// Slopes over all grids above the rounding plateau, or over those that were asked for.
    pub(super) slopes: Vec<Slope>,
    /// The slopes over another range of N.
    pub(super) over: Box<dyn Fn((usize, usize)) -> Vec<Slope>>,
    /// The reference's estimate of its own relative error.
    pub(super) reference_error: f64,
    /// True if any grid has a solution.
    solved: bool,
}

impl Swept {
    /// The exit code. Warns if the sweep was interrupted, or no grid has a solution.
    pub(super) fn code(&self) -> u8 {
        self.placed.code(|| {
            if self.solved {
                return 0;
            }
            report::warn("no grid of the sweep has a solution: raise --n-gamma, or shorten the run");
            report::NO_CRITICAL_POINT
        })
    }
}

/// Sweeps a case and writes its files. Warnings begin with `name`.
///
/// # Errors
/// Also if it was interrupted before there was a reference.
pub(super) fn sweep_into(target: Target, case: &Case, args: &ConvergeArgs, name: &str) -> anyhow::Result<Swept> {
    let sweep = if case.settings.is_extended() { sweep_in::<Extended> } else { sweep_in::<f64> };
    sweep(target, case, args, name)
}

/// Returns true if the finest grids fit into memory.
fn check_memory<S: Real>(case: &Case, args: &ConvergeArgs) -> anyhow::Result<()> {
    let finest = args.n_gamma.iter().max().copied().unwrap_or(0);
    for &sbp in &args.sbp {
        let grid = on_grid(&case.setup::<S>(), (sbp, case.settings.form), finest, S::ONE).ok();
        grid.map_or(Ok(()), |grid| memory::check(&grid, false, 0))?;
    }
    Ok(())
}

/// Returns true if even and odd numbers of nodes are mixed where that matters.
fn mixes_parities<S>(convergence: &Convergence<S>) -> bool {
    let is_strong = |point: &&ConvergencePoint| point.form == Form::Strong && point.sbp.fixed_points().is_none();
    let mut parities = convergence.points.iter().filter(is_strong).map(|point| point.n_gamma % 2);
    let first = parities.next();
    parities.any(|parity| Some(parity) != first)
}

fn sweep_in<S: Real>(target: Target, case: &Case, args: &ConvergeArgs, name: &str) -> anyhow::Result<Swept> {
    let warn = |warning: &str| report::warn(&format!("{name}{warning}"));
    case.warnings().iter().for_each(|warning| warn(warning));
    check_memory::<S>(case, args)?;
    let files = args.study.open(target, &[CONVERGENCE, SLOPES], &[FINAL_ERRORS, L2_ERRORS])?;
    let (files, convergence) = measured::<S>(files, case, args)?;
    let n_range = args.fit_range.unwrap_or((0, usize::MAX));
    let slopes = convergence.slopes(n_range);
    if case.settings.windows == 1 && mixes_parities(&convergence) {
        warn(
            "even and odd numbers of nodes have different errors at the end in the strong form: give --n-gamma of one \
             parity",
        );
    }
    Slope::warnings(&slopes).iter().for_each(|warning| warn(warning));
    files.write_table(CONVERGENCE, |out| convergence_table(&convergence).write(out))?;
    files.write_table(SLOPES, |out| slopes_table(&slopes).write(out))?;
    let title = args.study.case.headed(case.title.as_deref());
    if args.study.plot {
        draw(&title, &convergence, (&slopes, n_range), &files)?;
    }
    let summary = convergence_summary(case.title.as_deref(), case.warnings(), &convergence, &slopes);
    let finished = convergence.interrupted.then(|| format!("{} grids", convergence.points.len()));
    Ok(Swept {
        placed: Placed::new(files, &summary, finished)?,
        summary,
        text: summary_text(&title, &convergence, &slopes, args),
        slopes,
        reference_error: convergence.reference.error_estimate,
        solved: convergence.points.iter().any(|point| point.errors.is_some()),
        over: Box::new(move |range| convergence.slopes(range)),
    })
}

fn draw<S: Real>(
    title: &str,
    convergence: &Convergence<S>,
    (slopes, n_range): (&[Slope], (usize, usize)),
    files: &OutputSet,
) -> anyhow::Result<()> {
    let is_one = convergence.coordinates.len() == 2 && convergence.charges.len() == 1;
    for (name, what, of_x, largest) in [
        (FINAL_ERRORS, "at the end", Quantity::EPS_X_FINAL, Quantity::LARGEST_FINAL),
        (L2_ERRORS, "in the L2 norm", Quantity::EPS_X_L2, Quantity::LARGEST_L2),
    ] {
        let shown: Vec<Slope> = if is_one {
            // With many schemes only the errors of x are drawn: twice as many curves would be too many to tell apart.
            let is_crowded = slopes.len() > MOST_SCHEMES * 4;
            let is_shown =
                |quantity: Quantity| quantity == of_x || (!is_crowded && quantity.is_at_end == of_x.is_at_end);
            slopes.iter().filter(|slope| is_shown(slope.quantity)).cloned().collect()
        } else {
            // The largest error of several coordinates is drawn.
            convergence.schemes().into_iter().map(|scheme| convergence.slope(scheme, largest, n_range)).collect()
        };
        let of = if is_one { "errors" } else { "largest error of a coordinate" };
        let chart = pictures::errors(&format!("{title}: {of} {what}"), convergence, &shown);
        files.write_text(name, &chart.to_svg())?;
    }
    Ok(())
}

/// Sweeps, with a progress bar. After an interrupt the result has the grids that were finished.
fn measured<S: Real>(
    files: OutputSet,
    case: &Case,
    args: &ConvergeArgs,
) -> anyhow::Result<(OutputSet, Convergence<S>)> {
    let forms = if args.form.is_empty() { &[case.settings.form] } else { args.form.as_slice() };
    let schemes: Vec<_> = args.sbp.iter().flat_map(|&sbp| forms.iter().map(move |&form| (sbp, form))).collect();
    let (case, n_gamma, mut points) = (case.clone(), args.n_gamma.clone(), Vec::new());
    let grids = n_gamma.len() * schemes.len();
    let (files, sweep) = study::prepared(files, move || {
        Sweep::<S>::new(&case, &schemes, &n_gamma).map_err(|error| match error {
            SweepError::Reference(end) => end.into(),
            // An impossible grid is a mistake on the command line, and nothing is changed.
            SweepError::Grid(message) => {
                report::refused(message, "choose other numbers for --n-gamma, or fewer operators for --sbp")
            }
        })
    })?;
    let bar = study::bar(args.study.case.quiet, grids, "{bar:30} {pos}/{len} grids {msg}");
    study::computed(
        &bar,
        &sweep,
        |sweep, tell| {
            sweep.run(&|place, point| tell((place, point.clone())));
        },
        |(place, point): (usize, ConvergencePoint)| {
            bar.set_message(format!("last: {} N = {}", point.sbp, point.n_gamma));
            bar.inc(1);
            points.push((place, point));
        },
    );
    Ok((files, sweep.gathered(points)))
}

/// A line of the table of slopes.
pub(super) struct Line {
    /// The case, where there are several.
    pub(super) case: &'static str,
    pub(super) slope: Slope,
    /// The slope that the paper reports.
    pub(super) paper: Option<f64>,
}

impl Line {
    /// A slope with that of the paper, if `case` is one of its cases.
    pub(super) fn new(slope: Slope, case: Option<&str>) -> Self {
        let found = case.and_then(|case| published(case, slope.sbp, slope.quantity));
        let paper = found.filter(|_| slope.form == Form::Strong).map(|paper| paper.slope);
        Self { case: "", slope, paper }
    }
}

/// The table of slopes.
pub(super) fn table(lines: &[Line], is_verbose: bool) -> String {
    let width = lines.iter().map(|line| line.slope.name.len()).fold(11, usize::max);
    let is_published = lines.iter().any(|line| line.paper.is_some());
    let several = lines.iter().any(|line| !line.case.is_empty());
    let row = |[case, operator, error, slope, paper, grids, inverse, points]: [&str; 8]| {
        let case = if several { format!("  {case:<9}") } else { String::new() };
        let paper = if is_published { format!("  {paper:>5}") } else { String::new() };
        let more = if is_verbose { format!("  {inverse:<11}  {points}") } else { String::new() };
        let text = format!("{case}  {operator:<10}  {error:<width$}  {slope:<13}{paper}  {grids:<12}{more}");
        format!("{}\n", text.trim_end())
    };
    let mut text = row(["potential", "operator", "error", "slope", "paper", "grids", "against 1/N", "points"]);
    for Line { case, slope, paper } in lines {
        let (fit, none) = (slope.fit.as_ref(), || "-".to_owned());
        let error = fit.and_then(|fit| fit.standard_error).map_or(String::new(), |error| format!(" ± {error:.3}"));
        let found = fit.map_or_else(none, |fit| format!("{:.3}{error}", fit.slope));
        let paper = paper.map_or_else(none, |paper| format!("{paper:.2}"));
        let grids = slope.n_range.filter(|_| fit.is_some()).map_or_else(none, |(min, max)| format!("{min} … {max}"));
        let inverse = fit.map_or_else(none, |fit| format!("{:.3}", fit.slope_vs_inverse_n));
        let points = slope.points.to_string();
        text += &row([case, &slope.scheme(), &slope.name, &found, &paper, &grids, &inverse, &points]);
    }
    text
}

/// The slopes for people: first the orders, then a line for each error.
fn summary_text<S>(title: &str, convergence: &Convergence<S>, slopes: &[Slope], args: &ConvergeArgs) -> String {
    let lines: Vec<Line> = slopes.iter().map(|slope| Line::new(slope.clone(), args.study.case.unchanged())).collect();
    let mut text = wrapped(&format!("{title}: the order is {}", orders(slopes)), 2) + &table(&lines, args.verbose);
    for point in convergence.points.iter().filter(|point| point.errors.is_none()) {
        text += &row("failed", &format!("{} N = {}: {}", point.sbp, point.n_gamma, point.status));
    }
    let error = convergence.reference.error_estimate;
    text + &row("error", &format!("against a Taylor trajectory, itself good to {error:.0e}"))
}

/// The orders of all operators: the range of their slopes.
fn orders(slopes: &[Slope]) -> String {
    let mut schemes: Vec<String> = slopes.iter().map(Slope::scheme).collect();
    schemes.dedup();
    let order = |scheme: String| {
        let found = slopes.iter().filter(|slope| slope.scheme() == scheme).filter_map(|slope| slope.fit.as_ref());
        let (least, most) = found
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), fit| (fit.slope.min(least), fit.slope.max(most)));
        match most - least {
            f64::NEG_INFINITY => format!("unknown for {scheme}"),
            0.05.. => format!("{least:.1} to {most:.1} for {scheme}"),
            _ => format!("{most:.1} for {scheme}"),
        }
    };
    listed(schemes.into_iter().map(order))
}
