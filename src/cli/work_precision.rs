//! `work-precision [CASE]`.

use std::fs::File;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use clap::Args;
use geodesic_ivp::Case;
use geodesic_ivp::output::pictures::{self, WorkAxis};
use geodesic_ivp::output::{OutputSet, WorkPrecisionSummary, read_rows, write_drift, write_work_precision};
use geodesic_ivp::study::work_precision::{
    Arena, Budget, DriftPoint, Family, Leader, Progress, Ratio, WorkPrecision, drift, measure, ratios,
};
use indicatif::{ProgressBar, ProgressStyle};

use super::interrupt::{self, INTERRUPTED};
use super::out::OutArgs;
use super::{CaseArgs, report};

const WORK_PRECISION: &str = "work_precision.csv";
const DRIFT: &str = "drift.csv";
const SUMMARY: &str = "summary.json";
const DRIFT_K: &str = "drift_k.svg";
const DRIFT_ERROR: &str = "drift_error.svg";
/// Pictures of every length, in the order of `--gamma-f`.
const BY_LENGTH: [(&str, &str); 4] = [
    ("error_time.svg", "error_evaluations.svg"),
    ("error_time_2.svg", "error_evaluations_2.svg"),
    ("error_time_3.svg", "error_evaluations_3.svg"),
    ("error_time_4.svg", "error_evaluations_4.svg"),
];

#[derive(Debug, Args)]
pub(super) struct WorkPrecisionArgs {
    #[command(flatten)]
    case: CaseArgs,

    #[command(flatten)]
    output: OutArgs,

    /// Lengths in gamma to chart, four at most [default: the case's own]; errors along the longest are in drift.csv
    #[arg(long, value_name = "L,L,…", value_delimiter = ',', value_parser = length)]
    gamma_f: Vec<f64>,

    /// Methods to measure, by their names in the table or the beginning of one [default: all]
    #[arg(long, value_name = "NAME,NAME,…", value_delimiter = ',')]
    methods: Vec<String>,

    /// Also rank and draw the rows of this table, which another program measured
    #[arg(long, value_name = "CSV")]
    rows: Option<PathBuf>,

    /// Seconds that a single run may take
    #[arg(long, value_name = "SECONDS", default_value_t = Budget::default().longest, value_parser = length)]
    longest: f64,

    /// Also draw errors against time and evaluations, and along the run, as SVG
    #[arg(long)]
    plot: bool,
}

fn length(text: &str) -> Result<f64, String> {
    let parsed = text.trim().parse().ok().filter(|&length: &f64| length > 0.0 && length.is_finite());
    parsed.ok_or_else(|| "expected a positive number".to_owned())
}

pub(super) fn work_precision(args: &WorkPrecisionArgs) -> anyhow::Result<ExitCode> {
    let case = &args.case.read()?;
    for warning in case.warnings() {
        report::warn(&warning);
    }
    if args.gamma_f.len() > BY_LENGTH.len() {
        anyhow::bail!(report::Usage(format!("--gamma-f takes {} lengths at most", BY_LENGTH.len())));
    }
    let families = chosen(&args.methods)?;
    let mut others = Vec::new();
    if let Some(path) = &args.rows {
        let name = path.display();
        let table = File::open(path).with_context(|| format!("cannot read the rows {name}"))?;
        others = read_rows(table).with_context(|| format!("cannot read the rows {name}"))?;
    }
    let target = args.output.target(&args.case, "work-precision")?;
    let directory = target.folder.clone();
    let by_length =
        BY_LENGTH.into_iter().take(args.gamma_f.len().max(1)).flat_map(|(time, evaluations)| [time, evaluations]);
    let pictures = by_length.chain([DRIFT_K, DRIFT_ERROR]).filter(|_| args.plot).collect::<Vec<_>>();
    let files = OutputSet::open(target, &[&[WORK_PRECISION, DRIFT, SUMMARY], &pictures[..]].concat())?;
    let cancel = interrupt::flag()?;
    let lengths: Vec<Option<f64>> = match args.gamma_f[..] {
        [] => vec![None],
        ref lengths => lengths.iter().copied().map(Some).collect(),
    };
    let arenas: Result<Vec<Arena>, _> = lengths.into_iter().map(|length| Arena::new(case, length)).collect();
    let arenas = match arenas {
        Ok(arenas) => arenas,
        Err(end) => {
            // Without a reference there are no results, and those of an earlier run must not stand for them.
            files.commit(|_| false)?;
            return Err(geodesic_ivp::study::convergence::SweepError::from(end).into());
        }
    };
    let (mut measured, along) = measure_all(&arenas, &families, args, &cancel);
    for row in &mut others {
        // Another program writes the length in its own way.
        if let Some(arena) = arenas.iter().find(|arena| (arena.length() / row.gamma_f - 1.0).abs() < 1e-9) {
            row.gamma_f = arena.length();
        }
    }
    measured.rows.extend(others);
    let ratios = ratios(&measured.rows);
    write_work_precision(files.writer(WORK_PRECISION), &measured.rows).context("cannot write work_precision.csv")?;
    write_drift(files.writer(DRIFT), &along).context("cannot write drift.csv")?;
    files.write_text(SUMMARY, &WorkPrecisionSummary::new(case, &arenas, &measured, &ratios).to_json())?;
    if args.plot {
        draw(case, &arenas, &measured, &along, &files)?;
    }
    let kept = files.commit(|_| true)?;
    if !args.case.quiet {
        let text = readable(case, &arenas, &measured, &ratios) + &report::written(&directory, &kept);
        io::stdout().write_all(text.as_bytes())?;
    }
    if measured.interrupted {
        let rows = measured.rows.len();
        report::warn(&format!("interrupted: {rows} settings were finished and are in {}", directory.display()));
        return Ok(ExitCode::from(INTERRUPTED));
    }
    Ok(ExitCode::SUCCESS)
}

/// The methods whose names begin with one of `names`.
fn chosen(names: &[String]) -> anyhow::Result<Vec<Family>> {
    let all = Family::all();
    if names.is_empty() {
        return Ok(all);
    }
    let begins = |family: &Family, name: &str| family.name().to_lowercase().starts_with(&name.trim().to_lowercase());
    if let Some(name) = names.iter().find(|name| !all.iter().any(|family| begins(family, name))) {
        let known: Vec<String> = all.iter().map(Family::name).collect();
        anyhow::bail!(report::Usage(format!("no method is called '{name}'; there are {}", known.join(", "))));
    }
    Ok(all.into_iter().filter(|family| names.iter().any(|name| begins(family, name))).collect())
}

/// Measures every length, with a bar on a terminal's standard error; an interrupt ends it with what is there.
fn measure_all(
    arenas: &[Arena],
    families: &[Family],
    args: &WorkPrecisionArgs,
    cancel: &AtomicBool,
) -> (WorkPrecision, Vec<DriftPoint>) {
    let budget = Budget { longest: args.longest, ..Budget::default() };
    let total = (arenas.len() * (families.len() + budget.rounds)) as u64;
    let bar = if args.case.quiet { ProgressBar::hidden() } else { ProgressBar::new(total) };
    bar.set_style(ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}").expect("the template is valid"));
    let mut measured = WorkPrecision::default();
    for arena in arenas {
        let mut before = None;
        let one = measure(arena, families, &budget, cancel, &mut |progress| match progress {
            Progress::Tried(family) => {
                if before.replace(family.clone()).as_ref() != Some(family) {
                    bar.set_message(format!("trying {}", family.name()));
                    bar.inc(1);
                }
            }
            Progress::Timed(round, rounds) => {
                bar.set_message(format!("round {round} of {rounds}"));
                bar.inc(1);
            }
        });
        measured.rows.extend(one.rows);
        measured.interrupted |= one.interrupted;
    }
    let longest = arenas.iter().max_by(|a, b| a.length().total_cmp(&b.length()));
    bar.set_message("errors along the run");
    let along = longest.map(|arena| drift(arena, families, cancel)).unwrap_or_default();
    measured.interrupted |= cancel.load(Ordering::Relaxed);
    bar.finish_and_clear();
    (measured, along)
}

/// Draws all pictures.
fn draw(
    case: &Case,
    arenas: &[Arena],
    measured: &WorkPrecision,
    along: &[DriftPoint],
    files: &OutputSet,
) -> anyhow::Result<()> {
    let title = case.title.as_deref().unwrap_or("Work and precision");
    let write = |name, chart: geodesic_ivp::output::Chart| files.write_text(name, &chart.to_svg());
    for (arena, (time, evaluations)) in arenas.iter().zip(BY_LENGTH) {
        let length = arena.length();
        let rows = || measured.rows.iter().filter(|row| row.gamma_f == length);
        let title = format!("{title}, Δγ = {}", short(length));
        write(time, pictures::work_precision(&title, rows(), WorkAxis::Seconds))?;
        write(evaluations, pictures::work_precision(&title, rows(), WorkAxis::Evaluations))?;
    }
    write(DRIFT_K, pictures::drift(&format!("{title}: K along the run"), along, true))?;
    write(DRIFT_ERROR, pictures::drift(&format!("{title}: errors along the run"), along, false))
}

/// A length for people.
fn short(length: f64) -> String {
    let rounded = format!("{length:.6}");
    rounded.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn readable(case: &Case, arenas: &[Arena], measured: &WorkPrecision, ratios: &[Ratio]) -> String {
    let title = case.title.as_deref().unwrap_or("geodesic-ivp");
    let ranked = measured.rows.iter().filter(|row| row.rank().is_some()).count();
    let mut text = format!("{title}: {} settings, {ranked} of them with a result\n", measured.rows.len());
    for arena in arenas {
        let length = arena.length();
        text += &format!(
            "  gamma_f - gamma_i = {}; reference to {:.0e}; the fastest that is as accurate, and its ratio others / own\n",
            short(length),
            arena.reference_error()
        );
        text += "  error  seconds  own                              seconds  others                           ratio  of solve\n";
        for ratio in ratios.iter().filter(|ratio| ratio.gamma_f == length) {
            let times = |ratio: Option<f64>| ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}"));
            text += &format!(
                "  {:.0e}   {}  {}  {:>5}  {:>8}\n",
                ratio.error,
                leader(&ratio.own),
                leader(&ratio.other),
                times(ratio.lead()),
                times(ratio.certified_lead())
            );
        }
    }
    text
}

fn leader(leader: &Option<Leader>) -> String {
    let (seconds, name) = match leader {
        Some(Leader { method, setting, seconds }) => (format!("{seconds:.1e}"), format!("{method} {setting}")),
        None => ("-".to_owned(), "none".to_owned()),
    };
    format!("{seconds:<7}  {name:<31}")
}
