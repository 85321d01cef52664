//! Data, and the motion that was fitted to them.

use crate::case::{Data, Find, Goal};
use crate::output::chart::{Chart, Mark, Series, Style};
use crate::study::find::Fit;
use crate::study::run::Run;
use crate::trajectory::Sampler;

/// So many points of each curve.
const POINTS: usize = 600;
/// A curve that goes to and fro more often is a surface to the eye.
const MOST_TURNS: usize = 60;

/// The coordinates of a run, of which there are data, over t or γ, with these data and their standard deviations; or
/// what the data differ by from a motion that goes to and fro too often to be drawn. `None` if nothing was fitted.
pub fn fit(title: &str, wanted: &Find, run: &Run, fit: Option<&Fit>) -> Option<Chart> {
    let (Goal::Data(data), Some(fit)) = (&wanted.goal, fit) else { return None };
    let names = run.line.geometry().names();
    let x = data.by.map_or("γ", |a| &names[a]);
    let is_crowded = data.series.iter().any(|of| turns(run, of.coordinate) > MOST_TURNS);
    Some(if is_crowded { residuals(title, fit, x) } else { curves(title, data, run, x) })
}

/// How often a coordinate turns back between the nodes of a run.
fn turns(run: &Run, a: usize) -> usize {
    let of_line = |nodes: Vec<f64>| {
        let steps: Vec<f64> = nodes.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step != 0.0).collect();
        steps.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count()
    };
    run.parts().into_iter().map(|(line, _)| of_line(line.q(a).collect())).sum()
}

fn curves(title: &str, Data { by, places, series: observed }: &Data, run: &Run, x: &str) -> Chart {
    let place = |gamma: f64, q: &[f64]| by.map_or(gamma, |a| q[a]);
    let mut curves = vec![Vec::new(); observed.len()];
    for (line, _) in run.parts() {
        let (mut sampler, step) = (Sampler::new(line), line.length / (POINTS - 1) as f64);
        let samples = (0..POINTS).filter_map(|k| sampler.at_gamma(line.gamma_at(k as f64 * step)).ok());
        for sample in samples {
            let curves = curves.iter_mut().zip(observed);
            curves.for_each(|(curve, of)| curve.push((place(sample.gamma, &sample.q), sample.q[of.coordinate])));
        }
    }
    let name = |coordinate: usize| run.line.geometry().names()[coordinate].clone();
    let (mut series, mut errors): (Vec<Series>, Vec<(f64, f64)>) = Default::default();
    for (of, curve) in observed.iter().zip(curves) {
        let data = || places.iter().copied().zip(of.values.iter().copied());
        series.push(Series::new(name(of.coordinate), Mark::LINE, curve));
        series.push(Series::new(format!("{}, data", name(of.coordinate)), Mark::OPEN_POINTS, data().collect()));
        let bars = data().zip(of.sigmas.iter().flatten());
        bars.for_each(|(at, sigma)| errors.extend(bar(at, *sigma)));
    }
    if !errors.is_empty() {
        series.push(Series::new("one standard deviation", Mark::HAIRLINE, errors).with_look(Style::NEUTRAL));
    }
    let all: Vec<String> = observed.iter().map(|of| name(of.coordinate)).collect();
    Chart::new("The data and the motion that fits them best", title, [x, &all.join(", ")], series)
}

/// A line through a point that is interrupted behind it.
fn bar((x, y): (f64, f64), half: f64) -> [(f64, f64); 3] {
    [(x, y - half), (x, y + half), (f64::NAN, f64::NAN)]
}

fn residuals(title: &str, fit: &Fit, x: &str) -> Chart {
    let mut series: Vec<Series> = Vec::new();
    for row in &fit.rows {
        if series.last().is_none_or(|series| series.label != row.coordinate) {
            series.push(Series::new(&row.coordinate, Mark::OPEN_POINTS, Vec::new()));
        }
        series.iter_mut().last().expect("it was just put there").points.push((row.place, row.residual));
    }
    let places = || fit.rows.iter().map(|row| row.place);
    let ends = [places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max)];
    let zero = Series::new("", Mark::DOTTED, ends.map(|at| (at, 0.0)).to_vec());
    series.push(zero.with_look(Style::NEUTRAL));
    let y = if fit.has_sigmas { "run less datum, in standard deviations" } else { "run less datum" };
    Chart::new("What the motion that fits best leaves of the data", title, [x, y], series)
}
