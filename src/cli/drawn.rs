//! The pictures of `run --plot`.

use geodesic_ivp::Case;
use geodesic_ivp::number::Real;
use geodesic_ivp::output::pictures::PlotAxes;
use geodesic_ivp::output::{Chart, OutputSet, Summary, pictures};
use geodesic_ivp::reference::{ReferenceTrajectory, time_parametrised};
use geodesic_ivp::solve::Place;
use geodesic_ivp::study::run::Run;

use super::run::event_names;

/// Draws the pictures of a run.
pub(super) fn draw<S: Real>(
    files: &OutputSet,
    title: &str,
    case: &Case,
    run: &Run<S>,
    summary: &Summary,
) -> anyhow::Result<()> {
    let windows = if summary.windows > 1 { format!(", {} windows", summary.windows) } else { String::new() };
    let title = format!("{title} ({}, N = {}{windows})", summary.sbp, summary.n_gamma);
    let names = picture_names(case).iter();
    names.zip(pictures(&title, case, run)).try_for_each(|(name, chart)| files.write_text(name, &chart.to_svg()))
}

/// The names of a run's pictures.
pub(super) fn picture_names(case: &Case) -> &'static [&'static str] {
    const OF_X: [&str; 5] = ["world_line.svg", "t_dot.svg", "trajectory.svg", "delta_q_t.svg", "delta_g.svg"];
    const OF_SCENE: [&str; 4] = ["orbit.svg", "charges.svg", "mesh.svg", "section.svg"];
    match case.is_of_x() {
        true => &OF_X,
        false if case.events().is_empty() => &OF_SCENE[..3],
        false => &OF_SCENE,
    }
}

/// The pictures, in the order of their names.
fn pictures<S: Real>(title: &str, case: &Case, run: &Run<S>) -> Vec<Chart> {
    let Run { line, diagnostics, sums, events, .. } = run;
    if case.is_of_x() {
        let runs = [pictures::Run { label: "", solution: line, diagnostics }];
        // If the reference does not reach the end, the picture is drawn without it. For a line f64 is precise enough.
        let Place { geometry, start } = case.setup::<f64>().place;
        let reference = ReferenceTrajectory::new(&geometry, &start, line.length.to_f64(), f64::MOST_DIGITS).ok();
        let duration = (line.end_state().t - line.t_i()).to_f64();
        let in_time = time_parametrised(&geometry, &start, duration, 400);
        return vec![
            pictures::world_line(title, line),
            pictures::time_mesh(title, &runs),
            pictures::trajectory(title, &runs, reference.as_ref(), &in_time),
            pictures::noether_charge(title, &runs),
            pictures::geodesic_residuals(title, &runs),
        ];
    }
    let (formulas, labels) = case.plot_axes(line.geometry());
    let axes = PlotAxes { formulas, labels };
    let mut drawn = vec![
        pictures::orbit(title, line, &axes),
        pictures::charges(title, line, diagnostics, sums),
        pictures::mesh(title, line),
    ];
    if !case.events().is_empty() {
        drawn.push(pictures::section(title, line, &axes, &event_names(case), events));
    }
    drawn
}
