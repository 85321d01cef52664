//! `stability [CASE]`.

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::Context;
use clap::Args;
use geodesic_ivp::Case;
use geodesic_ivp::output::{OutputSet, SUMMARY, pictures, stability_summary, write_stability};
use geodesic_ivp::reference::ReferenceEnds;
use geodesic_ivp::study::stability::{Arena, Atlas, Cell, CellStatus, Limit, Method, Pace, Plan, measure};
use indicatif::{ProgressBar, ProgressStyle};

use super::CaseArgs;
use super::interrupt::{self, INTERRUPTED};
use super::out::OutArgs;
use super::report::{self, Refusal};

const STABILITY: &str = "stability.csv";
const MAP: &str = "map.svg";
const MAP_OTHERS: &str = "map_others.svg";
const ONSET: &str = "sawtooth.svg";
const LAST_NODE: &str = "last_node.svg";
const PICTURES: [&str; 4] = [MAP, MAP_OTHERS, ONSET, LAST_NODE];

/// More steps than this on the longest world-line are taken for a typing mistake.
const MOST_STEPS: f64 = 1e7;

#[derive(Debug, Args)]
pub(super) struct StabilityArgs {
    #[command(flatten)]
    case: CaseArgs,

    #[command(flatten)]
    output: OutArgs,

    /// Methods to chart, by their names in the table (with the form) or the beginning of one [default: all]
    #[arg(long, value_name = "NAME,NAME,…", value_delimiter = ',')]
    methods: Vec<String>,

    /// Lengths in gamma [default: round numbers from a third of the fastest oscillation to some 160, and the case's
    /// own]
    #[arg(long, value_name = "L,L,…", value_delimiter = ',', value_parser = positive)]
    gamma_f: Vec<f64>,

    /// Lengths by the tangent: values of dt/dgamma at the start, with dx/dt kept [default: the case's own]; not in
    /// scenes
    #[arg(long, value_name = "T,T,…", value_delimiter = ',', value_parser = positive)]
    t_dot: Vec<f64>,

    /// Steps in gamma [default: round numbers with delta_gamma omega from 0.02 to 2]
    #[arg(long, value_name = "H,H,…", value_delimiter = ',', value_parser = positive)]
    delta_gamma: Vec<f64>,

    /// Also draw the maps, the beginning of the sawtooth and the charge at the last node as SVG
    #[arg(long)]
    plot: bool,
}

fn positive(text: &str) -> Result<f64, String> {
    let parsed = text.trim().parse().ok().filter(|&value: &f64| value > 0.0 && value.is_finite());
    parsed.ok_or_else(|| "expected a positive number".to_owned())
}

pub(super) fn stability(args: &StabilityArgs) -> anyhow::Result<ExitCode> {
    let case = &args.case.read()?;
    if !case.is_of_x() && !args.t_dot.is_empty() {
        let refusal = Refusal::usage("--t-dot is for cases of one coordinate");
        anyhow::bail!(refusal.help("the lengths of a scene are those of --gamma-f"));
    }
    let (methods, left_out) = chosen(&args.methods, case)?;
    args.output.check_standard_output()?;
    let target = args.output.target(&args.case, "stability")?;
    let directory = target.folder.clone();
    let pictures: &[&str] = if args.plot { &PICTURES } else { &[] };
    let files = OutputSet::open(target, &[&[STABILITY, SUMMARY], pictures].concat())?;
    let (arena, plan, atlas) = match measure_with_progress(case, methods, args) {
        Ok(Some(measured)) => measured,
        Ok(None) => return Ok(interrupt::before_any_result()),
        Err(Impossible::Reference(end)) => {
            // Without a reference nothing can be judged. The files of an earlier run are removed: they must not be
            // taken for results of this one.
            files.commit(&|_| false)?;
            return Err((*end).into());
        }
        Err(Impossible::Steps(steps)) => {
            anyhow::bail!(Refusal::usage(format!("--delta-gamma takes {steps:.0e} steps, {MOST_STEPS:.0e} at most")));
        }
    };
    let (arena, plan) = (arena.as_ref(), plan.as_ref());
    write_stability(files.writer(STABILITY), arena, &atlas.cells).context("cannot write stability.csv")?;
    let summary = stability_summary((case.title(), case.warnings()), arena, plan, &atlas);
    files.write_text(SUMMARY, &summary)?;
    let title = &args.case.headed(case.title());
    if args.plot {
        let own = |own: bool| plan.methods.iter().filter(|method| method.is_own() == own).cloned().collect::<Vec<_>>();
        files.write_text(MAP, &pictures::stability_map(title, arena, &own(true), &atlas.cells).to_svg())?;
        files.write_text(MAP_OTHERS, &pictures::stability_map(title, arena, &own(false), &atlas.cells).to_svg())?;
        files.write_text(ONSET, &pictures::sawtooth_onset(title, &atlas.cells).to_svg())?;
        files.write_text(LAST_NODE, &pictures::last_node(title, arena, &atlas.cells).to_svg())?;
    }
    let kept = files.commit(&|_| true)?;
    args.output.tell(args.case.quiet, &summary, || {
        readable(title, arena, plan, &atlas) + &left_out + &report::written(&directory, &kept)
    })?;
    if atlas.interrupted {
        let rows = atlas.cells.len();
        report::warn(&format!("interrupted: {rows} cells were finished and are in {}", directory.display()));
        return Ok(ExitCode::from(INTERRUPTED));
    }
    Ok(ending(&atlas))
}

/// The exit code: 3 or 4 if no cell has a result.
fn ending(atlas: &Atlas) -> ExitCode {
    let all = |statuses: &[CellStatus]| atlas.cells.iter().all(|cell| statuses.contains(&cell.status));
    if all(&[CellStatus::NoCriticalPoint]) {
        report::warn("no method has a result on any grid: choose smaller --delta-gamma, or shorter --gamma-f");
        return ExitCode::from(report::NO_CRITICAL_POINT);
    }
    if all(&[CellStatus::OutsideDomain, CellStatus::NoCriticalPoint]) {
        report::warn("the geodesic leaves the domain on every grid: choose shorter --gamma-f");
        return ExitCode::from(report::OUTSIDE_DOMAIN);
    }
    ExitCode::SUCCESS
}

fn ascending(values: &[f64]) -> Vec<f64> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// The methods whose labels begin with one of `names`, and what to say about those that are left out although nobody
/// said so.
fn chosen(names: &[String], case: &Case) -> anyhow::Result<(Vec<Method>, String)> {
    let is_separable = (!case.is_of_x()).then(|| case.geometry::<f64>().is_separable());
    let unsuitable = |method: &Method| is_separable.and_then(|is_separable| method.unsuitable(is_separable));
    let (suitable, others): (Vec<Method>, Vec<Method>) =
        Method::all().into_iter().partition(|method| unsuitable(method).is_none());
    if names.is_empty() {
        let others: Vec<String> = others.iter().filter(|method| !method.is_own()).map(Method::label).collect();
        let left_out = format!("  left out   {}: the scene is not separable\n", others.join(", "));
        return Ok((suitable, if others.is_empty() { String::new() } else { left_out }));
    }
    let begins = |method: &Method, name: &str| method.label().to_lowercase().starts_with(&name.trim().to_lowercase());
    if let Some(name) = names.iter().find(|name| !suitable.iter().any(|method| begins(method, name))) {
        let other = others.iter().find(|method| begins(method, name));
        if let Some((method, reason)) = other.and_then(|method| Some((method, unsuitable(method)?))) {
            anyhow::bail!(Refusal::usage(format!("{} {reason}", method.label())));
        }
        let known: Vec<String> = suitable.iter().map(Method::label).collect();
        anyhow::bail!(Refusal::usage(format!("no method is called '{name}'; there are {}", known.join(", "))));
    }
    let is_chosen = |method: &Method| names.iter().any(|name| begins(method, name));
    Ok((suitable.into_iter().filter(is_chosen).collect(), String::new()))
}

/// What a measurement reports while it is running.
enum News {
    Ready(Arc<Arena>, Arc<Plan>),
    Tried(usize, Option<Box<Cell>>),
    Impossible(Impossible),
}

/// The world-line, what was to be measured on it, and what was measured.
type Measured = (Arc<Arena>, Arc<Plan>, Atlas);

/// Why there is no atlas.
enum Impossible {
    /// There is no reference, so nothing can be judged.
    Reference(Box<ReferenceEnds>),
    /// The finest grid would have too many steps: this many.
    Steps(f64),
}

/// The world-line and the plan: what is to be measured on it.
fn planned(case: &Case, methods: Vec<Method>, args: &[Vec<f64>; 3]) -> Result<(Arc<Arena>, Arc<Plan>), Impossible> {
    let [gamma_f, t_dot, delta_gamma] = args;
    let own = case.start::<f64>().q_dot[0];
    let tangents = if t_dot.is_empty() { vec![1.0] } else { t_dot.iter().map(|value| value / own).collect() };
    let lengths: Vec<f64> =
        gamma_f.iter().flat_map(|length| tangents.iter().map(move |tangent| length * tangent)).collect();
    let arena = Arena::new(case, &lengths).map_err(|end| Impossible::Reference(Box::new(end)))?;
    let or = |given: &[f64], default: Vec<f64>| if given.is_empty() { default } else { ascending(given) };
    let plan = Plan {
        methods,
        lengths: or(gamma_f, arena.default_lengths()),
        tangents,
        spacings: or(delta_gamma, arena.default_spacings()),
    };
    let steps = plan.lengths.iter().copied().fold(0.0, f64::max) / plan.spacings.first().copied().unwrap_or(1.0);
    if steps > MOST_STEPS { Err(Impossible::Steps(steps)) } else { Ok((Arc::new(arena), Arc::new(plan))) }
}

/// Measures, with a progress bar if standard error is a terminal. After an interrupt the result has the cells that were
/// finished; it is `None` if the reference was not finished.
fn measure_with_progress(
    case: &Case,
    methods: Vec<Method>,
    args: &StabilityArgs,
) -> Result<Option<Measured>, Impossible> {
    let bar = if args.case.quiet { ProgressBar::hidden() } else { ProgressBar::new(0) };
    bar.set_style(ProgressStyle::with_template("{bar:30} {pos}/{len} cells {msg}").expect("the template is valid"));
    let case = case.clone();
    let args = [&args.gamma_f, &args.t_dot, &args.delta_gamma].map(Vec::clone);
    let work = move |tell: &(dyn Fn(News) + Sync)| match planned(&case, methods, &args) {
        Ok((arena, plan)) => {
            tell(News::Ready(Arc::clone(&arena), Arc::clone(&plan)));
            let tried = |place: usize, cell: Option<&Cell>| tell(News::Tried(place, cell.cloned().map(Box::new)));
            measure(&arena, &plan, &AtomicBool::new(false), &tried);
        }
        Err(impossible) => tell(News::Impossible(impossible)),
    };
    let (mut ready, mut cells) = (Ok(None), Vec::new());
    let interrupted = interrupt::beside_it(work, |news| match news {
        News::Ready(arena, plan) => {
            bar.set_length(plan.grids() as u64);
            ready = Ok(Some((arena, plan)));
        }
        News::Impossible(impossible) => ready = Err(impossible),
        News::Tried(place, cell) => {
            if let Some(cell) = cell {
                bar.set_message(format!("last: {} {}", cell.method.label(), cell.status.label()));
                cells.push((place, *cell));
            }
            bar.inc(1);
        }
    });
    bar.finish_and_clear();
    Ok(ready?.map(|(arena, plan)| (arena, plan, Atlas::gathered(cells, interrupted))))
}

fn readable(title: &str, arena: &Arena, plan: &Plan, atlas: &Atlas) -> String {
    let mut text = format!(
        "{title}: {} cells; largest local frequency {:.4e}; reference to {:.0e}\n",
        atlas.cells.len(),
        arena.omega(),
        arena.reference_error()
    );
    match arena.pace() {
        Pace::Frequency(_) => {}
        Pace::Growth(rate) => {
            text += &format!("  nothing oscillates: steps are in units of the rate of growth, {rate:.4e}\n")
        }
        Pace::Length(rate) => text += &format!("  nothing oscillates: steps are in units of 2 pi/length, {rate:.4e}\n"),
    }
    if let Some(end) = arena.ends() {
        text += &format!("  {}\n", end);
    }
    text += "  method                limit";
    for status in CellStatus::ALL {
        text += &format!("  {}", status.label());
    }
    text += "\n";
    for method in &plan.methods {
        let limit = match method.limit() {
            Limit::Step(step) => format!("{step:.3}"),
            Limit::None => "none".to_owned(),
            Limit::Adaptive => "-".to_owned(),
        };
        text += &format!("  {:<20}  {limit:>5}", method.label());
        for status in CellStatus::ALL {
            let count = atlas.cells.iter().filter(|cell| cell.method == *method && cell.status == status).count();
            text += &format!("  {count:>width$}", width = status.label().len());
        }
        text += "\n";
    }
    text
}
