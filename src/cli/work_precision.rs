//! `work-precision [CASE]`.

use std::fs::File;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::Context;
use clap::{Args, ValueHint};
use geodesic_ivp::output::pictures::{self, Work};
use geodesic_ivp::output::{OutputSet, drift_table, read_rows, work_precision_summary, work_precision_table};
use geodesic_ivp::study::work_precision::{
    Arena, Budget, DriftPoint, Method, Progress, Ratio, Row, WorkPrecision, drift, measure, ratios,
};

use super::lines::{row, short, wrapped};
use super::study::{self, StudyArgs, chosen, positive};
use super::{out, report};

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

/// Names of settings are wider only if they have to.
const WIDEST: usize = 31;

#[derive(Debug, Args)]
#[command(next_help_heading = "What to measure")]
pub(super) struct WorkPrecisionArgs {
    /// Lengths in gamma, four at most [default: the case's own]
    ///
    /// The errors along the longest of them are in drift.csv.
    #[arg(long, value_name = "L,L,…", value_delimiter = ',', value_parser = positive, allow_hyphen_values = true)]
    gamma_f: Vec<f64>,

    /// Methods, by the beginnings of their names (--help has them)
    #[arg(
        long,
        value_name = "NAME,NAME,…",
        value_delimiter = ',',
        long_help = study::methods_help(&Method::timed())
    )]
    methods: Vec<String>,

    /// Also rank and draw what another program measured
    ///
    /// The table has the columns of work_precision.csv.
    #[arg(long, value_name = "CSV", value_hint = ValueHint::FilePath)]
    rows: Option<PathBuf>,

    /// Seconds that a single run may take
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = Budget::default().longest,
        value_parser = positive,
        allow_hyphen_values = true
    )]
    longest: f64,

    #[command(flatten)]
    study: StudyArgs,
}

pub(super) fn work_precision(args: &WorkPrecisionArgs) -> anyhow::Result<ExitCode> {
    let (study, case) = (&args.study, args.study.case.read_for_study()?);
    case.warnings().iter().for_each(|warning| report::warn(warning));
    if args.gamma_f.len() > BY_LENGTH.len() {
        let message = format!("--gamma-f takes {} lengths at most", BY_LENGTH.len());
        return Err(report::refused(message, ""));
    }
    let (methods, _) = chosen(&case, &args.methods, Method::timed())?;
    let mut others = Vec::new();
    if let Some(path) = &args.rows {
        let cannot = || format!("cannot read the rows {}", path.display());
        others = read_rows(File::open(path).with_context(cannot)?, &case.coordinates()).with_context(cannot)?;
    }
    let by_length = BY_LENGTH.into_iter().take(args.gamma_f.len().max(1));
    let pictures: Vec<&str> =
        by_length.flat_map(|(time, evaluations)| [time, evaluations]).chain([DRIFT_K, DRIFT_ERROR]).collect();
    let target = study.output.target(&study.case, "work-precision")?;
    out::keep_source(&case, &target)?;
    let files = study.open(target, &[WORK_PRECISION, DRIFT], &pictures)?;
    let lengths = match args.gamma_f[..] {
        [] => vec![None],
        ref lengths => lengths.iter().copied().map(Some).collect(),
    };
    let (files, arenas) = study::prepared(files, {
        let case = case.clone();
        move || Ok(lengths.into_iter().map(|length| Arena::new(&case, length)).collect::<Result<Vec<_>, _>>()?)
    })?;
    let (mut measured, along) = measured(&arenas, methods, args);
    for row in &mut others {
        // Another program may write the same length with other digits.
        if let Some(arena) = arenas.iter().find(|arena| (arena.length() / row.gamma_f - 1.0).abs() < 1e-9) {
            row.gamma_f = arena.length();
        }
    }
    measured.rows.extend(others);
    let (ratios, coordinates) = (ratios(&measured.rows), case.coordinates());
    files.write_table(WORK_PRECISION, |out| work_precision_table(&coordinates, &measured.rows).write(out))?;
    files.write_table(DRIFT, |out| drift_table(&coordinates, &along).write(out))?;
    let title = study.case.headed(case.title.as_deref());
    if study.plot {
        draw(&title, &arenas, &measured, &along, &files)?;
    }
    let summary = work_precision_summary(case.title.as_deref(), &arenas, &measured, &ratios);
    let text = summary_text(&title, &arenas, &measured, &ratios);
    let finished = measured.interrupted.then(|| format!("{} settings", measured.rows.len()));
    study.finish(files, (&summary, &text), finished, || 0)
}

/// Measures every length, and the errors along the longest run, with a progress bar. After an interrupt there are the
/// rows that were finished.
fn measured(
    arenas: &Arc<Vec<Arena>>,
    methods: Vec<Method>,
    args: &WorkPrecisionArgs,
) -> (WorkPrecision, Vec<DriftPoint>) {
    let budget = Budget { longest: args.longest, ..Budget::default() };
    let length = arenas.len() * (methods.len() + budget.rounds);
    let bar = study::bar(args.study.case.quiet, length, "{bar:30} {pos}/{len} {msg}");
    let (mut measured, mut along, all) = (WorkPrecision::default(), Vec::new(), methods.clone());
    measured.interrupted = study::computed(
        &bar,
        arenas,
        move |arenas, tell| {
            let mut before = 0;
            for arena in arenas {
                before += measure(arena, &all, &budget, &mut |progress| tell((before, progress))).rows.len();
            }
        },
        |(before, progress)| match progress {
            Progress::Tried(row) => {
                if measured.rows.last().is_none_or(|last: &Row| last.method != row.method) {
                    bar.set_message(format!("trying {}", row.method.label()));
                    bar.inc(1);
                }
                measured.rows.push(row);
            }
            Progress::Retimed(index, row) => measured.rows[before + index] = row,
            Progress::Round(round, rounds) => {
                bar.set_message(format!("round {round} of {rounds}"));
                bar.inc(1);
            }
        },
    );
    if !measured.interrupted {
        let of_longest = move |arenas: &Vec<Arena>, tell: &(dyn Fn(Vec<DriftPoint>) + Sync)| {
            let longest = arenas.iter().max_by(|a, b| a.length().total_cmp(&b.length())).expect("there is a length");
            methods.iter().for_each(|method| tell(drift(longest, std::slice::from_ref(method))));
        };
        measured.interrupted = study::computed(&bar, arenas, of_longest, |points| along.extend(points));
    }
    (measured, along)
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
        write(time, pictures::work_precision(&title, arena.coordinates(), rows(), Work::SECONDS))?;
        write(evaluations, pictures::work_precision(&title, arena.coordinates(), rows(), Work::EVALUATIONS))?;
    }
    let coordinates = arenas.first().map_or(&[][..], Arena::coordinates);
    let longest = arenas.iter().map(Arena::length).fold(0.0, f64::max);
    let title = format!("{title}, γ_f − γ_i = {}", short(longest));
    write(DRIFT_K, pictures::drift(&title, coordinates, along, true))?;
    write(DRIFT_ERROR, pictures::drift(&title, coordinates, along, false))
}

/// The table for people: first who leads, then for each error the fastest setting of this program, the fastest of the
/// others, and how many times faster it is.
fn summary_text(title: &str, arenas: &[Arena], measured: &WorkPrecision, ratios: &[Ratio<'_>]) -> String {
    let mut text = wrapped(&format!("{title}: {}", lead(ratios)), 2);
    for arena in arenas {
        let of_length = || ratios.iter().filter(|ratio| ratio.gamma_f == arena.length());
        let names = of_length().map(|ratio| leader(ratio.own).1.chars().count());
        let width = names.fold(12, usize::max).min(WIDEST);
        if arenas.len() > 1 {
            text += &row("length", &format!("{} in gamma", short(arena.length())));
        }
        text += &format!(
            "  error  {:<7}  {:<width$}  {:<7}  {:<WIDEST$}  ratio\n",
            "own s", "this program", "other s", "others"
        );
        for ratio in of_length() {
            let [(own_time, own), (other_time, other)] = [ratio.own, ratio.other].map(leader);
            let times = ratio.lead().map_or("-".to_owned(), |ratio| format!("{ratio:.2}"));
            text += &format!(
                "  {:<5}  {own_time:<7}  {own:<width$}  {other_time:<7}  {other:<WIDEST$}  {times:>5}\n",
                format!("{:.0e}", ratio.error)
            );
        }
    }
    text += &row("ratio", "seconds of the others over those of this program, each with its fastest setting");
    let ranked = measured.rows.iter().filter(|row| row.rank().is_some()).count();
    text += &row("measured", &format!("{} settings, {ranked} of them with a result", measured.rows.len()));
    let error = arenas.iter().map(Arena::reference_error).fold(0.0, f64::max);
    text + &row("error", &format!("against a Taylor trajectory, itself good to {error:.0e}"))
}

/// At how many of the errors this program is the fastest, and by how much.
fn lead(ratios: &[Ratio<'_>]) -> String {
    let leads: Vec<f64> = ratios.iter().filter_map(Ratio::lead).collect();
    let ahead = leads.iter().filter(|lead| **lead > 1.0).count();
    let most = leads.iter().copied().fold(1.0, f64::max);
    let least = leads.iter().copied().fold(1.0, f64::min);
    let own = if ahead > 0 { format!(", up to {most:.1} times as fast as the others") } else { String::new() };
    match leads.len() {
        0 => "nothing to compare with".to_owned(),
        all if ahead == all => format!("this program is the fastest at all {all} errors{own}"),
        all => format!(
            "this program is the fastest at {ahead} of {all} errors{own}; at the rest the others are up to {:.1} times \
             as fast",
            1.0 / least
        ),
    }
}

/// The seconds and the name of the fastest setting.
fn leader(row: Option<&Row>) -> (String, String) {
    match row {
        Some(row) => (format!("{:.1e}", row.seconds_min), format!("{} {}", row.method.label(), row.setting)),
        None => ("-".to_owned(), "none".to_owned()),
    }
}
