//! Every numerical figure of the paper, as SVG, on one page beside the paper's statement and this program's number.
//!
//! `cargo run --release --example paper_figures -- DIRECTORY` writes the pictures and `index.html` into DIRECTORY.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result};
use geodesic_ivp::case::{Form, SbpName};
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::output::Chart;
use geodesic_ivp::output::pictures::{self, Run};
use geodesic_ivp::reference::{ReferenceTrajectory, time_parametrised};
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::study::convergence::paper::published;
use geodesic_ivp::study::convergence::{Quantity, Slope, sweep};
use geodesic_ivp::{Case, Solution, solve};

const OPERATORS: [&str; 2] = ["SBP21", "SBP42"];

/// A potential of the paper's section 4, with what the paper says of it.
struct Scene {
    name: &'static str,
    text: &'static str,
    /// Of ΔE at the last node, SBP21 and SBP42.
    delta_e: [&'static str; 2],
}

const SCENES: [Scene; 2] = [
    Scene {
        name: "linear",
        text: include_str!("../cases/linear.toml"),
        delta_e: [
            "below 2 permille at the last node, zero elsewhere",
            "of order 1e-6 at the last node, zero elsewhere",
        ],
    },
    Scene {
        name: "quartic",
        text: include_str!("../cases/quartic.toml"),
        delta_e: ["zero but at the last node, where dt/dγ = 2.06 and t = 1.47", "zero but at the last node"],
    },
];

/// A solved case with its diagnostics.
struct Solved<S: Real = f64> {
    label: String,
    solution: Solution<S>,
    diagnostics: Diagnostics<S>,
}

impl<S: Arithmetic> Solved<S> {
    /// The paper solves the doubled system, so the pictures do.
    fn new(label: String, scene: &Scene, sbp: &str, settings: &str) -> Result<Self> {
        let settings = format!("solver.system=doubled scheme.sbp={sbp} {settings}");
        let settings: Vec<String> = settings.split_whitespace().map(str::to_owned).collect();
        let solution = solve(&Case::parse(scene.name, scene.text, &settings)?)?;
        let diagnostics = Diagnostics::new(&solution);
        Ok(Self { label, solution, diagnostics })
    }

    fn run(&self) -> Run<'_, S> {
        Run { label: &self.label, solution: &self.solution, diagnostics: &self.diagnostics }
    }
}

/// x(t) of the last of these runs with the reference and the time-parametrised motion, beside the others.
fn trajectory(title: &str, solved: &Solved, runs: &[Run<'_>]) -> Result<Chart> {
    let solution = &solved.solution;
    let (geometry, start, length) = (solution.geometry(), &solution.place.start, solution.gamma_f() - solution.gamma_i);
    let reference = ReferenceTrajectory::new(geometry, start, length, f64::MOST_DIGITS)?;
    let in_time = time_parametrised(geometry, start, solution.end_state().t - solution.t_i(), 400);
    Ok(pictures::trajectory(title, runs, Some(&reference), &in_time))
}

/// The page, written as the pictures are made.
struct Page {
    directory: PathBuf,
    body: String,
}

impl Page {
    fn section(&mut self, heading: &str) {
        let _ = writeln!(self.body, "<h2>{heading}</h2>");
    }

    /// One row: pictures on the left, statement and number on the right.
    fn row(&mut self, charts: &[(String, Chart)], paper: &str, here: &str) -> Result<()> {
        self.body += "<div class=\"row\"><div class=\"pictures\">\n";
        for (name, chart) in charts {
            let file = format!("{name}.svg");
            let path = self.directory.join(&file);
            fs::write(&path, chart.to_svg()).with_context(|| format!("cannot write {}", path.display()))?;
            let _ = writeln!(self.body, "<img src=\"{file}\" alt=\"{}, {}\">", chart.title, chart.subtitle);
        }
        let _ = writeln!(
            self.body,
            "</div><dl><dt>The paper</dt><dd>{paper}</dd><dt>This program</dt><dd>{here}</dd></dl></div>"
        );
        Ok(())
    }

    fn finish(self) -> Result<PathBuf> {
        let path = self.directory.join("index.html");
        let page = format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
             <title>geodesic-ivp: the paper's figures</title>\n\
             <style>body{{font:16px/1.5 sans-serif;max-width:1500px;margin:2em auto;padding:0 1em}}\
             .row{{display:flex;gap:2em;align-items:flex-start;border-top:1px solid #ddd;padding:1em 0}}\
             .pictures{{flex:3;display:flex;flex-wrap:wrap;gap:.5em}}\
             .pictures img{{flex:1 1 30%;min-width:300px;max-width:480px}}\
             dl{{flex:0 0 18em;min-width:16em}}dt{{font-weight:bold}}dd{{margin:0 0 1em 0}}</style></head><body>\n\
             <h1>The numerical figures of the paper</h1>\n\
             <p>A. Rothkopf, J. Nordström, <em>A symmetry and Noether charge preserving discretization of initial \
             value problems</em>, arXiv:2307.04490 (2023), section 4. Every picture and number below was computed by \
             geodesic-ivp {} when this page was made. ΔE and ΔQₜ are the same quantity.</p>\n{}</body></html>\n",
            env!("CARGO_PKG_VERSION"),
            self.body
        );
        fs::write(&path, page).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(path)
    }
}

/// Degrees of freedom, dt/dγ, x(t), ΔG and ΔE of the base run with one operator.
fn base_run(page: &mut Page, scene: &Scene, operator: usize) -> Result<()> {
    let sbp = OPERATORS[operator];
    let solved = Solved::new(String::new(), scene, sbp, "")?;
    let (runs, name) = ([solved.run()], format!("{}-{sbp}", scene.name));
    let of = format!("{} potential, {sbp}, N = 32", scene.name);
    let (end, d) = (&solved.solution.end_state(), &solved.diagnostics);
    let last = d.q_dot[0].len() - 1;
    page.row(
        &[
            (format!("{name}-dofs"), pictures::world_line(&of, &solved.solution)),
            (format!("{name}-dt-dgamma"), pictures::time_mesh(&of, &runs)),
            (format!("{name}-x-of-t"), trajectory(&of, &solved, &runs)?),
        ],
        "t(γ) and x(γ) emerge together, both branches agree, and the time mesh is non-uniform.",
        &format!(
            "t[N] = {:.12}, x[N] = {:.12}, (Dt)[N] = {:.3}; the branches differ by at most {:.0e}.",
            end.t,
            end.x,
            d.q_dot[0][last],
            solved.solution.branch_distance()
        ),
    )?;
    page.row(
        &[
            (format!("{name}-delta-g"), pictures::geodesic_residuals(&of, &runs)),
            (format!("{name}-delta-e"), pictures::noether_charge(&of, &runs)),
        ],
        &format!("ΔG is zero but at the last nodes; ΔE is {}.", scene.delta_e[operator]),
        &format!(
            "Interior |ΔG| ≤ {:.1e}, |ΔE| ≤ {:.1e}; at the last node ΔE = {:.3e}, with the multiplier correction \
             {:.1e}.",
            d.max_delta_g, d.charges[0].max_interior, d.charges[0].last, d.charges[0].corrected[last]
        ),
    )
}

/// |ΔE| in double and in 60-digit arithmetic: where it is rounding, it goes with the rounding.
fn exactness(page: &mut Page, scene: &Scene) -> Result<()> {
    let (mut charts, mut numbers) = (Vec::new(), Vec::new());
    for sbp in OPERATORS {
        let double: Solved = Solved::new("16 digits".to_owned(), scene, sbp, "")?;
        let extended = Solved::<Extended>::new("60 digits".to_owned(), scene, sbp, "solver.digits=60")?;
        let title = format!("{} potential, {sbp}, N = 32, in 16 and in 60 digits", scene.name);
        let mut chart = pictures::noether_charge(&title, &[double.run()]);
        // Of each precision only the charge itself, without its correction.
        chart.series.truncate(1);
        chart.series.extend(pictures::noether_charge("", &[extended.run()]).series.into_iter().take(1));
        charts.push((format!("{}-{sbp}-exact", scene.name), chart));
        numbers.push(format!(
            "{sbp}: {:.0e} and {:.0e}, at the last node {:.6e} in both",
            double.diagnostics.charges[0].max_interior,
            extended.diagnostics.charges[0].max_interior.to_f64(),
            extended.diagnostics.charges[0].last.to_f64()
        ));
    }
    page.row(
        &charts,
        "ΔE vanishes exactly within machine precision (40 digits there), but at the last node.",
        &format!("Interior |ΔE| in 16 and in 60 digits. {}.", numbers.join(". ")),
    )
}

/// ΔE for three numbers of nodes.
fn refinement(page: &mut Page, scene: &Scene) -> Result<()> {
    let (mut charts, mut numbers) = (Vec::new(), Vec::new());
    for sbp in OPERATORS {
        let solve_with = |n| Solved::new(format!("N = {n}"), scene, sbp, &format!("grid.n_gamma={n}"));
        let solved: Vec<Solved> = [16, 32, 64].map(solve_with).into_iter().collect::<Result<_>>()?;
        let runs: Vec<Run<'_>> = solved.iter().map(Solved::run).collect();
        let title = format!("{} potential, {sbp}, N = 16, 32, 64", scene.name);
        charts.push((format!("{}-{sbp}-delta-e-n", scene.name), pictures::noether_charge(&title, &runs)));
        let last = solved.iter().map(|s| format!("{:.3e}", s.diagnostics.charges[0].last));
        numbers.push(format!("{sbp}: {}", last.collect::<Vec<_>>().join(", ")));
    }
    page.row(
        &charts,
        "The deviation of the last node diminishes under refinement; everywhere else ΔE is exactly zero.",
        &format!("ΔE at the last node for N = 16, 32, 64. {}.", numbers.join(". ")),
    )
}

/// ΔE and x(t) for longer and longer runs of the quartic oscillator.
fn longer_runs(page: &mut Page, scene: &Scene) -> Result<()> {
    for sbp in OPERATORS {
        let solve_with = |(t_dot, n)| {
            let start = format!("initial.t_dot={t_dot} initial.x_dot={}", 0.1 * f64::from(t_dot));
            Solved::new(format!("ṫ_i = {t_dot}, N = {n}"), scene, sbp, &format!("grid.n_gamma={n} {start}"))
        };
        let solved: Vec<Solved> = [(1, 32), (4, 32), (8, 64)].map(solve_with).into_iter().collect::<Result<_>>()?;
        let runs: Vec<Run<'_>> = solved.iter().map(Solved::run).collect();
        let (of, name) = (format!("quartic potential, {sbp}, ṫ_i = 1, 4, 8"), format!("quartic-{sbp}-long"));
        let found = solved.iter().map(|s| &s.diagnostics);
        let ends = found.map(|d| format!("{:.3} ({:.1e})", d.charges[0].last, d.norm.max_interior));
        page.row(
            &[
                (format!("{name}-delta-e"), pictures::noether_charge(&of, &runs)),
                (format!("{name}-x-of-t"), trajectory(&of, &solved[2], &runs)?),
            ],
            "Longer runs keep ΔE = 0 in the interior, and ΔE at the last node changes only marginally.",
            &format!(
                "{sbp}: ΔE at the last node (and max |ΔK|) for ṫ_i = 1, 4, 8: {}. The last node's deviation does \
                 not stay marginal.",
                ends.collect::<Vec<_>>().join(", ")
            ),
        )?;
    }
    Ok(())
}

/// Errors against Δγ on the paper's grids, with the fits.
fn convergence(page: &mut Page, scene: &Scene) -> Result<()> {
    let case = Case::parse(scene.name, scene.text, &[])?;
    let operators = [SbpName::Sbp21, SbpName::Sbp42];
    let convergence = sweep::<f64>(
        &case,
        &operators.map(|sbp| (sbp, Form::Strong)),
        &[16, 32, 64, 128, 256],
        &AtomicBool::new(false),
        &|_| {},
    )?;
    let [coarse, fine] = [(16, 64), (64, 256)].map(|range| convergence.slopes(range));
    let name = scene.name;
    let fit = |slopes: &[Slope], sbp, quantity| {
        slopes.iter().find(|s| s.sbp == sbp && s.quantity == quantity).and_then(|s| s.fit.clone())
    };
    let slope = |slope: Option<f64>| slope.map_or("none".to_owned(), |slope| format!("{slope:.2}"));
    let mut table = "Slopes on N = 16, 32, 64 against Δγ (against 1/N), then on N = 64, 128, 256: ".to_owned();
    let mut stated = Vec::new();
    for sbp in operators {
        for quantity in [Quantity::EPS_X_FINAL, Quantity::EPS_T_FINAL] {
            let paper = published(name, sbp, quantity).context("the paper has this slope")?.slope;
            let symbol = quantity.symbol(&convergence.coordinates);
            stated.push(format!("{sbp} {symbol} {paper:.2}"));
            let (first, then) = (fit(&coarse, sbp, quantity), fit(&fine, sbp, quantity));
            let [first, inverse] =
                [first.as_ref().map(|f| f.slope), first.as_ref().map(|f| f.slope_vs_inverse_n)].map(slope);
            let _ = write!(table, "{sbp} {symbol} {first} ({inverse}), {}; ", slope(then.map(|f| f.slope)));
        }
    }
    let (at_end, over_all): (Vec<Slope>, Vec<Slope>) = coarse.into_iter().partition(|slope| slope.quantity.is_at_end());
    let chart =
        |what: &str, slopes: &[Slope]| pictures::errors(&format!("{name} potential: {what}"), &convergence, slopes);
    page.row(
        &[
            (format!("{name}-convergence"), chart("errors at γ_f", &at_end)),
            (format!("{name}-convergence-l2"), chart("L2 errors", &over_all)),
        ],
        &format!("Slopes: {}.", stated.join(", ")),
        &format!("{table}the paper's fits are against 1/N; against Δγ the orders are 2 and 3."),
    )
}

fn main() -> Result<()> {
    let directory = std::env::args().nth(1).context("usage: paper_figures DIRECTORY")?;
    fs::create_dir_all(&directory).with_context(|| format!("cannot create {directory}"))?;
    let mut page = Page { directory: Path::new(&directory).to_owned(), body: String::new() };
    for scene in &SCENES {
        for (operator, sbp) in OPERATORS.into_iter().enumerate() {
            page.section(&format!("The {} potential with {sbp}", scene.name));
            base_run(&mut page, scene, operator)?;
        }
        page.section(&format!("The {} potential: refinement and convergence", scene.name));
        exactness(&mut page, scene)?;
        refinement(&mut page, scene)?;
        convergence(&mut page, scene)?;
    }
    page.section("The quartic potential: longer runs");
    longer_runs(&mut page, &SCENES[1])?;
    println!("{}", page.finish()?.display());
    Ok(())
}
