//! `stability [CASE]`.

use std::process::ExitCode;
use std::sync::Arc;

use clap::Args;
use geodesic_ivp::Case;
use geodesic_ivp::output::{OutputSet, pictures, stability_summary, stability_table};
use geodesic_ivp::study::stability::{Arena, Atlas, Cell, CellStatus, Limit, Method, Pace, Plan, measure};

use super::lines::{row, wrapped};
use super::study::{self, StudyArgs, chosen, positive};
use super::{out, report};

const STABILITY: &str = "stability.csv";
/// The maps of this program's methods and of the others, where there are such.
const MAPS: [(&str, bool); 2] = [("map.svg", true), ("map_others.svg", false)];
const ONSET: &str = "sawtooth.svg";
const LAST_NODE: &str = "last_node.svg";

/// More steps than this on the longest world-line are taken for a typing mistake.
const MOST_STEPS: f64 = 1e7;

#[derive(Debug, Args)]
#[command(next_help_heading = "What to measure")]
pub(super) struct StabilityArgs {
    /// Methods, by the beginnings of their names (--help has them)
    #[arg(
        long,
        value_name = "NAME,NAME,…",
        value_delimiter = ',',
        long_help = study::methods_help(&Method::charted())
    )]
    methods: Vec<String>,

    /// Lengths in gamma [default: a third of the fastest oscillation to 160]
    ///
    /// Without it round numbers are taken, and the case's own length.
    #[arg(long, value_name = "L,L,…", value_delimiter = ',', value_parser = positive, allow_hyphen_values = true)]
    gamma_f: Vec<f64>,

    /// Values of dt/dgamma at the start, with dx/dt kept; not in scenes
    ///
    /// A longer tangent makes the run longer, as a longer range of gamma does [default: the case's own].
    #[arg(long, value_name = "T,T,…", value_delimiter = ',', value_parser = positive, allow_hyphen_values = true)]
    t_dot: Vec<f64>,

    /// Steps in gamma [default: 0.02 to 2, over the largest frequency]
    #[arg(long, value_name = "H,H,…", value_delimiter = ',', value_parser = positive, allow_hyphen_values = true)]
    delta_gamma: Vec<f64>,

    #[command(flatten)]
    study: StudyArgs,
}

pub(super) fn stability(args: &StabilityArgs) -> anyhow::Result<ExitCode> {
    let (study, case) = (&args.study, args.study.case.read_for_study()?);
    if !case.is_of_x && !args.t_dot.is_empty() {
        let help = "the lengths of a scene are those of --gamma-f";
        return Err(report::refused("--t-dot is for cases of one coordinate", help));
    }
    let (methods, left_out) = chosen(&case, &args.methods, Method::charted())?;
    let pictures: Vec<&str> = maps(&methods).map(|(name, _)| name).chain([ONSET, LAST_NODE]).collect();
    let target = study.output.target(&study.case, "stability")?;
    out::keep_source(&case, &target)?;
    let files = study.open(target, &[STABILITY], &pictures)?;
    let lists = [&args.gamma_f, &args.t_dot, &args.delta_gamma].map(Vec::clone);
    let (files, measured) = study::prepared(files, {
        let case = case.clone();
        move || planned(&case, methods, &lists)
    })?;
    let atlas = measured_cells(&measured, study.case.quiet);
    let (arena, plan) = measured.as_ref();
    files.write_table(STABILITY, |out| stability_table(arena, &atlas.cells).write(out))?;
    let title = study.case.headed(case.title.as_deref());
    if study.plot {
        draw(&files, &title, arena, plan, &atlas)?;
    }
    let summary = stability_summary((case.title.as_deref(), case.warnings()), arena, plan, &atlas);
    let text = summary_text(&title, arena, plan, &atlas, &left_out);
    let finished = atlas.interrupted.then(|| format!("{} cells", atlas.cells.len()));
    study.finish(files, (&summary, &text), finished, || ending(&atlas))
}

/// The names of the maps that there are, with their methods.
fn maps(methods: &[Method]) -> impl Iterator<Item = (&'static str, Vec<Method>)> {
    let of = |is_own| methods.iter().filter(|method| method.is_own() == is_own).cloned().collect::<Vec<_>>();
    MAPS.map(|(name, is_own)| (name, of(is_own))).into_iter().filter(|(_, methods)| !methods.is_empty())
}

fn draw(files: &OutputSet, title: &str, arena: &Arena, plan: &Plan, atlas: &Atlas) -> anyhow::Result<()> {
    for (name, methods) in maps(&plan.methods) {
        files.write_text(name, &pictures::stability_map(title, arena, &methods, &atlas.cells).to_svg())?;
    }
    files.write_text(ONSET, &pictures::sawtooth_onset(title, &atlas.cells).to_svg())?;
    files.write_text(LAST_NODE, &pictures::last_node(title, arena, &atlas.cells).to_svg())
}

/// The exit code: 3 or 4 if no cell has a result.
fn ending(atlas: &Atlas) -> u8 {
    let all = |statuses: &[CellStatus]| atlas.cells.iter().all(|cell| statuses.contains(&cell.status));
    if all(&[CellStatus::NoCriticalPoint]) {
        report::warn("no method has a result on any grid: choose smaller --delta-gamma, or shorter --gamma-f");
        return report::NO_CRITICAL_POINT;
    }
    if all(&[CellStatus::OutsideDomain, CellStatus::NoCriticalPoint]) {
        report::warn("the geodesic leaves the domain on every grid: choose shorter --gamma-f");
        return report::OUTSIDE_DOMAIN;
    }
    0
}

fn ascending(values: &[f64]) -> Vec<f64> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// The world-line and the plan: what is to be measured on it.
fn planned(case: &Case, methods: Vec<Method>, args: &[Vec<f64>; 3]) -> anyhow::Result<(Arena, Plan)> {
    let [gamma_f, t_dot, delta_gamma] = args;
    let own = case.start::<f64>().q_dot[0];
    let tangents = if t_dot.is_empty() { vec![1.0] } else { t_dot.iter().map(|value| value / own).collect() };
    let lengths: Vec<f64> =
        gamma_f.iter().flat_map(|length| tangents.iter().map(move |tangent| length * tangent)).collect();
    let arena = Arena::new(case, &lengths)?;
    let or = |given: &[f64], default: Vec<f64>| if given.is_empty() { default } else { ascending(given) };
    let plan = Plan {
        methods,
        lengths: or(gamma_f, arena.default_lengths()),
        tangents,
        spacings: or(delta_gamma, arena.default_spacings()),
    };
    let steps = plan.lengths.iter().copied().fold(0.0, f64::max) / plan.spacings.first().copied().unwrap_or(1.0);
    if steps > MOST_STEPS {
        let message = format!("--delta-gamma takes {steps:.0e} steps, {MOST_STEPS:.0e} at most");
        return Err(report::refused(message, ""));
    }
    Ok((arena, plan))
}

/// Measures all cells, with a progress bar. After an interrupt there are those that were finished.
fn measured_cells(measured: &Arc<(Arena, Plan)>, is_quiet: bool) -> Atlas {
    let bar = study::bar(is_quiet, measured.1.grids(), "{bar:30} {pos}/{len} cells {msg}");
    let mut cells = Vec::new();
    let interrupted = study::computed(
        &bar,
        measured,
        |(arena, plan), tell| {
            let tried = |place: usize, cell: Option<&Cell>| tell((place, cell.cloned().map(Box::new)));
            measure(arena, plan, &tried);
        },
        |(place, cell)| {
            if let Some(cell) = cell {
                bar.set_message(format!("last: {} {}", cell.method.label(), cell.status.label()));
                cells.push((place, *cell));
            }
            bar.inc(1);
        },
    );
    Atlas::gathered(cells, interrupted)
}

/// The words for statuses in the table, which is narrow.
fn heading(status: CellStatus) -> &'static str {
    match status {
        CellStatus::NoCriticalPoint => "failed",
        CellStatus::OutsideDomain => "outside",
        status => status.label(),
    }
}

fn summary_text(title: &str, arena: &Arena, plan: &Plan, atlas: &Atlas, left_out: &[Method]) -> String {
    let count = |status: CellStatus, method: Option<&Method>| {
        let is_one = |cell: &&Cell| cell.status == status && method.is_none_or(|method| cell.method == *method);
        atlas.cells.iter().filter(is_one).count()
    };
    let accurate = count(CellStatus::Accurate, None);
    let mut text = wrapped(&format!("{title}: {accurate} of {} runs are accurate", atlas.cells.len()), 2);
    let met: Vec<CellStatus> = CellStatus::ALL.into_iter().filter(|status| count(*status, None) > 0).collect();
    text += &format!("  {:<20}  {:>5}", "method", "limit");
    text.extend(met.iter().map(|status| format!("  {}", heading(*status))));
    for method in &plan.methods {
        let limit = match method.limit() {
            Limit::Step(step) => format!("{step:.3}"),
            Limit::None => "none".to_owned(),
            Limit::Adaptive => "-".to_owned(),
        };
        text += &format!("\n  {:<20}  {limit:>5}", method.label());
        for status in &met {
            text += &format!("  {:>width$}", count(*status, Some(method)), width = heading(*status).len());
        }
    }
    text.push('\n');
    let unit = match arena.pace {
        Pace::Frequency(omega) => format!("the largest local frequency, {omega:.4}"),
        Pace::Growth(rate) => format!("the rate of growth, {rate:.4}: nothing oscillates"),
        Pace::Length(rate) => format!("2 pi over the length, {rate:.4}: nothing oscillates"),
    };
    text += &row("limit", &format!("of the step by linear theory, times {unit}"));
    for (status, meaning) in [
        (CellStatus::NoCriticalPoint, "no critical point, or an implicit step that does not converge"),
        (CellStatus::OutsideDomain, "the run leaves the domain"),
    ] {
        if met.contains(&status) {
            text += &row(heading(status), meaning);
        }
    }
    if let Some(end) = arena.ends.as_ref() {
        text += &row("ends", &end.to_string());
    }
    let others: Vec<String> = left_out.iter().filter(|method| !method.is_own()).map(Method::label).collect();
    if !others.is_empty() {
        text += &row("left out", &format!("{}: the scene is not separable", others.join(", ")));
    }
    text + &row("error", &format!("against a Taylor trajectory, itself good to {:.0e}", arena.reference_error()))
}
