//! `work-precision [CASE]`.

use std::fs::File;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::Context;
use clap::{Args, ValueHint};
use geodesic_ivp::Case;
use geodesic_ivp::output::pictures::{self, WorkAxis};
use geodesic_ivp::output::{OutputSet, SUMMARY, read_rows, work_precision_summary, write_drift, write_work_precision};
use geodesic_ivp::reference::ReferenceEnds;
use geodesic_ivp::study::work_precision::{
    Arena, Budget, DriftPoint, Family, Leader, Progress, Ratio, Row, WorkPrecision, drift, measure, ratios,
};
use indicatif::{ProgressBar, ProgressStyle};

use super::CaseArgs;
use super::interrupt::{self, INTERRUPTED};
use super::out::OutArgs;
use super::report::{self, Refusal};

const WORK_PRECISION: &str = "work_precision.csv";
const DRIFT: &str = "drift.csv";
const DRIFT_K: &str = "drift_k.svg";
const DRIFT_ERROR: &str = "drift_error.svg";
/// The pictures of each length, in the order of `--gamma-f`.
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
    #[arg(long, value_name = "CSV", value_hint = ValueHint::FilePath)]
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
        anyhow::bail!(Refusal::usage(format!("--gamma-f takes {} lengths at most", BY_LENGTH.len())));
    }
    let families = chosen(&args.methods, families_of(case))?;
    let mut others = Vec::new();
    if let Some(path) = &args.rows {
        let name = path.display();
        let table = File::open(path).with_context(|| format!("cannot read the rows {name}"))?;
        others = read_rows(table, &case.coordinates()).with_context(|| format!("cannot read the rows {name}"))?;
    }
    args.output.check_standard_output()?;
    let target = args.output.target(&args.case, "work-precision")?;
    let directory = target.folder.clone();
    let by_length =
        BY_LENGTH.into_iter().take(args.gamma_f.len().max(1)).flat_map(|(time, evaluations)| [time, evaluations]);
    let pictures = by_length.chain([DRIFT_K, DRIFT_ERROR]).filter(|_| args.plot).collect::<Vec<_>>();
    let files = OutputSet::open(target, &[&[WORK_PRECISION, DRIFT, SUMMARY], &pictures[..]].concat())?;
    let (arenas, mut measured, along) = match measure_all(case, families, args) {
        Ok(Some(all)) => all,
        Ok(None) => return Ok(interrupt::before_any_result()),
        Err(end) => {
            // Without a reference there are no results. The files of an earlier run are removed: they must not be taken
            // for results of this one.
            files.commit(&|_| false)?;
            return Err(end.into());
        }
    };
    for row in &mut others {
        // Another program may write the same length with other digits.
        if let Some(arena) = arenas.iter().find(|arena| (arena.length() / row.gamma_f - 1.0).abs() < 1e-9) {
            row.gamma_f = arena.length();
        }
    }
    measured.rows.extend(others);
    let ratios = ratios(&measured.rows);
    write_work_precision(files.writer(WORK_PRECISION), &case.coordinates(), &measured.rows)
        .context("cannot write work_precision.csv")?;
    write_drift(files.writer(DRIFT), &case.coordinates(), &along).context("cannot write drift.csv")?;
    let summary = work_precision_summary(case.title(), &arenas, &measured, &ratios);
    files.write_text(SUMMARY, &summary)?;
    let title = args.case.headed(case.title());
    if args.plot {
        draw(&title, &arenas, &measured, &along, &files)?;
    }
    let kept = files.commit(&|_| true)?;
    args.output.tell(args.case.quiet, &summary, || {
        readable(&title, &arenas, &measured, &ratios) + &report::written(&directory, &kept)
    })?;
    if measured.interrupted {
        let rows = measured.rows.len();
        report::warn(&format!("interrupted: {rows} settings were finished and are in {}", directory.display()));
        return Ok(ExitCode::from(INTERRUPTED));
    }
    Ok(ExitCode::SUCCESS)
}

/// The methods that suit a case.
fn families_of(case: &Case) -> Vec<Family> {
    if case.is_of_x() { Family::all() } else { Family::of_scene(case.geometry::<f64>().is_separable()) }
}

/// Those of `all` methods whose names begin with one of `names`.
fn chosen(names: &[String], all: Vec<Family>) -> anyhow::Result<Vec<Family>> {
    if names.is_empty() {
        return Ok(all);
    }
    let begins = |family: &Family, name: &str| family.name().to_lowercase().starts_with(&name.trim().to_lowercase());
    if let Some(name) = names.iter().find(|name| !all.iter().any(|family| begins(family, name))) {
        let known: Vec<String> = all.iter().map(Family::name).collect();
        anyhow::bail!(Refusal::usage(format!("no method is called '{name}'; there are {}", known.join(", "))));
    }
    Ok(all.into_iter().filter(|family| names.iter().any(|name| begins(family, name))).collect())
}

/// What a measurement reports while it is running.
enum News {
    Ready(Arc<Vec<Arena>>),
    Tried(Row),
    /// The row with this index was timed again.
    Retimed(usize, Row),
    /// A round over all rows of a length has ended: its number, and the number of all rounds.
    Round(usize, usize),
    /// Errors along the longest run.
    Along(Vec<DriftPoint>),
    Impossible(ReferenceEnds),
}

/// The lengths, the measured rows, and the errors along the longest run.
type Chart = (Arc<Vec<Arena>>, WorkPrecision, Vec<DriftPoint>);

/// Measures every length, with a progress bar if standard error is a terminal. After an interrupt the result has the
/// rows that were finished; it is `None` if the references were not finished.
fn measure_all(case: &Case, families: Vec<Family>, args: &WorkPrecisionArgs) -> Result<Option<Chart>, ReferenceEnds> {
    let budget = Budget { longest: args.longest, ..Budget::default() };
    let lengths: Vec<Option<f64>> = match args.gamma_f[..] {
        [] => vec![None],
        ref lengths => lengths.iter().copied().map(Some).collect(),
    };
    let total = (lengths.len() * (families.len() + budget.rounds)) as u64;
    let bar = if args.case.quiet { ProgressBar::hidden() } else { ProgressBar::new(total) };
    bar.set_style(ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}").expect("the template is valid"));
    let case = case.clone();
    let arena = move |length| Arena::new(&case, length);
    let work = move |tell: &(dyn Fn(News) + Sync)| match lengths.into_iter().map(&arena).collect() {
        Ok(arenas) => chart(&Arc::new(arenas), &families, &budget, tell),
        Err(end) => tell(News::Impossible(end)),
    };
    let (mut ready, mut measured, mut along) = (Ok(None), WorkPrecision::default(), Vec::new());
    measured.interrupted = interrupt::beside_it(work, |news| match news {
        News::Ready(arenas) => ready = Ok(Some(arenas)),
        News::Impossible(end) => ready = Err(end),
        News::Tried(row) => {
            if measured.rows.last().is_none_or(|last: &Row| last.family != row.family) {
                bar.set_message(format!("trying {}", row.family.name()));
                bar.inc(1);
            }
            measured.rows.push(row);
        }
        News::Retimed(index, row) => measured.rows[index] = row,
        News::Round(round, rounds) => {
            bar.set_message(format!("round {round} of {rounds}"));
            bar.inc(1);
        }
        News::Along(points) => along.extend(points),
    });
    bar.finish_and_clear();
    Ok(ready?.map(|arenas| (arenas, measured, along)))
}

/// Measures every length, and then the errors along the longest run.
fn chart(arenas: &Arc<Vec<Arena>>, families: &[Family], budget: &Budget, tell: &(dyn Fn(News) + Sync)) {
    let never = AtomicBool::new(false);
    tell(News::Ready(Arc::clone(arenas)));
    let mut before = 0;
    for arena in arenas.iter() {
        let one = measure(arena, families, budget, &never, &mut |progress| match progress {
            Progress::Tried(row) => tell(News::Tried(row.clone())),
            Progress::Retimed(index, row) => tell(News::Retimed(before + index, row.clone())),
            Progress::Round(round, rounds) => tell(News::Round(round, rounds)),
        });
        before += one.rows.len();
    }
    if let Some(longest) = arenas.iter().max_by(|a, b| a.length().total_cmp(&b.length())) {
        families.iter().for_each(|family| tell(News::Along(drift(longest, std::slice::from_ref(family), &never))));
    }
}

/// Draws all pictures.
fn draw(
    title: &str,
    arenas: &[Arena],
    measured: &WorkPrecision,
    along: &[DriftPoint],
    files: &OutputSet,
) -> anyhow::Result<()> {
    let write = |name, chart: geodesic_ivp::output::Chart| files.write_text(name, &chart.to_svg());
    for (arena, (time, evaluations)) in arenas.iter().zip(BY_LENGTH) {
        let length = arena.length();
        let rows = || measured.rows.iter().filter(|row| row.gamma_f == length);
        let title = format!("{title}, γ_f − γ_i = {}", short(length));
        write(time, pictures::work_precision(&title, arena.coordinates(), rows(), WorkAxis::Seconds))?;
        write(evaluations, pictures::work_precision(&title, arena.coordinates(), rows(), WorkAxis::Evaluations))?;
    }
    let coordinates = arenas.first().map_or(&[][..], Arena::coordinates);
    let longest = arenas.iter().map(Arena::length).fold(0.0, f64::max);
    let title = format!("{title}, γ_f − γ_i = {}", short(longest));
    write(DRIFT_K, pictures::drift(&title, coordinates, along, true))?;
    write(DRIFT_ERROR, pictures::drift(&title, coordinates, along, false))
}

/// A length with few digits, for display.
fn short(length: f64) -> String {
    let rounded = format!("{length:.6}");
    rounded.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn readable(title: &str, arenas: &[Arena], measured: &WorkPrecision, ratios: &[Ratio]) -> String {
    let ranked = measured.rows.iter().filter(|row| row.rank().is_some()).count();
    let mut text = format!("{title}: {} settings, {ranked} of them with a result\n", measured.rows.len());
    for arena in arenas {
        let length = arena.length();
        text += &format!(
            "  gamma_f - gamma_i = {}; reference to {:.0e}; the fastest that is as accurate, and its ratio others / \
             own\n",
            short(length),
            arena.reference_error()
        );
        text += "  error  seconds  own                              seconds  others                           \
                 ratio  of solve\n";
        for ratio in ratios.iter().filter(|ratio| ratio.gamma_f == length) {
            let times = |ratio: Option<f64>| ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}"));
            text += &format!(
                "  {:<5}  {}  {}  {:>5}  {:>8}\n",
                format!("{:.0e}", ratio.error),
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
