//! The pictures of `run --plot`.

use geodesic_ivp::Case;
use geodesic_ivp::case::Axes;
use geodesic_ivp::number::Real;
use geodesic_ivp::output::pictures::PlotAxes;
use geodesic_ivp::output::{Chart, OutputSet, pictures};
use geodesic_ivp::reference::{ReferenceTrajectory, time_parametrised};
use geodesic_ivp::solve::Place;
use geodesic_ivp::study::run::Run;

/// Draws the pictures of a run.
pub(super) fn draw<S: Real>(files: &OutputSet, title: &str, case: &Case, run: &Run<S>) -> anyhow::Result<()> {
    let line = &run.line;
    let windows = if line.window_count > 1 { format!(", {} windows", line.window_count) } else { String::new() };
    let title = format!("{title} ({}, N = {}{windows})", String::from(line.sbp_name), line.sbp().points());
    let names = picture_names(case).into_iter();
    names.zip(pictures(&title, case, run)).try_for_each(|(name, chart)| files.write_text(name, &chart.to_svg()))
}

/// The names of a run's pictures: those of every run, then those of the paper, which has t and x.
pub(super) fn picture_names(case: &Case) -> Vec<&'static str> {
    let section = (!case.events.is_empty()).then_some("section.svg");
    let of_x = ["world_line.svg", "t_dot.svg", "trajectory.svg", "delta_q_t.svg", "delta_g.svg"];
    let of_x = of_x.into_iter().filter(|_| case.is_of_x);
    ["orbit.svg", "charges.svg", "mesh.svg"].into_iter().chain(section).chain(of_x).collect()
}

/// The pictures, in the order of their names.
fn pictures<S: Real>(title: &str, case: &Case, run: &Run<S>) -> Vec<Chart> {
    let Run { line, sums, events, .. } = run;
    let parts = run.parts();
    let axes = |(name, Axes { x, y }): (String, Axes)| {
        let (formulas, is_lone) = ([&x, &y].map(|formula| case.axis(formula)), name.is_empty());
        let labels = if is_lone { [x, y] } else { ["x", "y"].map(str::to_owned) };
        // The parameter of Newton's law is t, but for a factor.
        (name, PlotAxes { formulas, labels, parameter: if case.is_lifted() { "t" } else { "γ" } })
    };
    let orbits: Vec<(String, PlotAxes<S>)> = case.orbits(line.geometry()).into_iter().map(axes).collect();
    let mut drawn = vec![
        pictures::orbit(title, &parts, &orbits),
        pictures::charges(title, &parts, sums),
        pictures::mesh(title, &parts),
    ];
    if !case.events.is_empty() {
        drawn.push(pictures::section(title, &parts, &orbits[0].1, &case.event_names(), events));
    }
    if case.is_of_x {
        drawn.extend(pictures_of_x(title, case, run));
    }
    drawn
}

/// The pictures of the paper.
fn pictures_of_x<S: Real>(title: &str, case: &Case, Run { line, diagnostics, .. }: &Run<S>) -> [Chart; 5] {
    // If the reference does not reach the end, the picture is drawn without it. For a line f64 is precise enough.
    let Place { geometry, start } = case.setup::<f64>().place;
    let reference = ReferenceTrajectory::new(&geometry, &start, line.length.to_f64(), f64::MOST_DIGITS).ok();
    let duration = (line.end_state().t - line.t_i()).to_f64();
    let in_time = time_parametrised(&geometry, &start, duration, 400);
    [
        pictures::world_line(title, line),
        pictures::time_mesh(title, line, diagnostics),
        pictures::trajectory(title, line, reference.as_ref(), &in_time),
        pictures::noether_charge(title, line, diagnostics),
        pictures::geodesic_residuals(title, line, diagnostics),
    ]
}
