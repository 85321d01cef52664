//! Data, and the motion that was fitted to them.

use crate::case::{Data, Find, Goal};
use crate::output::chart::{Chart, Mark, Series};
use crate::study::run::Run;
use crate::trajectory::Sampler;

/// So many points of each curve.
const POINTS: usize = 600;

/// The coordinates of a run, of which there are data, over t or γ, with these data.
pub fn fit(title: &str, wanted: &Find, run: &Run) -> Option<Chart> {
    let Goal::Data(Data { by, places, series: observed }) = &wanted.goal else { return None };
    let names = run.line.geometry().names();
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
    let name = |coordinate: usize| names[coordinate].clone();
    let mut series: Vec<Series> = Vec::new();
    for (of, curve) in observed.iter().zip(curves) {
        let data = places.iter().copied().zip(of.values.iter().copied()).collect();
        series.push(Series::new(name(of.coordinate), Mark::LINE, curve));
        series.push(Series::new(format!("{}, data", name(of.coordinate)), Mark::OPEN_POINTS, data));
    }
    let all: Vec<String> = observed.iter().map(|of| name(of.coordinate)).collect();
    let x = by.map_or_else(|| "γ".to_owned(), name);
    Some(Chart::new("The data and the motion that fits them best", title, [&x, &all.join(", ")], series))
}
