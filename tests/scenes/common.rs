//! What several test files need.

use geodesic_ivp::geometry::{Geometry, GeometryText, Law, MetricText, PotentialText, Preset, Start};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::solve::Arithmetic;

/// The preset of that name with other parameters.
pub(crate) fn preset(name: &str, parameters: &[(&str, &str)]) -> MetricText {
    let mut text = Preset::from_name(name).unwrap().text();
    for (name, value) in parameters {
        text.parameters.iter_mut().find(|(other, _)| other == name).unwrap().1 = (*value).to_owned();
    }
    text
}

/// The preset of that name with one definition replaced.
pub(crate) fn preset_with(name: &str, definition: &str, formula: &str) -> MetricText {
    let mut text = Preset::from_name(name).unwrap().text();
    text.definitions.iter_mut().find(|(other, _)| other == definition).unwrap().1 = formula.to_owned();
    text
}

/// Any metric from texts.
pub(crate) fn metric(coordinates: &[&str], components: &[([usize; 2], &str)]) -> MetricText {
    MetricText {
        coordinates: coordinates.iter().map(|name| (*name).to_owned()).collect(),
        components: components.iter().map(|(ab, text)| (*ab, (*text).to_owned())).collect(),
        ..MetricText::default()
    }
}

/// Newtonian motion of unit masses.
pub(crate) fn newtonian(coordinates: &[&str], expression: &str) -> PotentialText {
    PotentialText {
        coordinates: coordinates.iter().map(|name| (*name).to_owned()).collect(),
        expression: expression.to_owned(),
        mass: "1".to_owned(),
        masses: vec!["1".to_owned(); coordinates.len()],
        c: "1".to_owned(),
        law: Law::Newtonian,
        ..PotentialText::default()
    }
}

/// The geometry of a metric.
pub(crate) fn geometry<S: Arithmetic>(text: &MetricText) -> Geometry<S> {
    Geometry::new(&GeometryText::Metric(text.clone())).unwrap_or_else(|error| panic!("{error}"))
}

/// The geometry of a potential.
pub(crate) fn of_potential<S: Arithmetic>(text: &PotentialText) -> Geometry<S> {
    Geometry::new(&GeometryText::Potential(text.clone())).unwrap_or_else(|error| panic!("{error}"))
}

/// Decimals in any precision.
pub(crate) fn numbers<S: Arithmetic>(decimals: &[&str]) -> Vec<S> {
    decimals.iter().map(|text| S::from_decimal(text).unwrap()).collect()
}

/// A start by positions and velocities.
pub(crate) fn start<S: Arithmetic>(geometry: &Geometry<S>, q: &[S], q_dot: &[S]) -> Start<S> {
    Start { q: q.to_vec(), q_dot: q_dot.to_vec(), p: geometry.momenta(q, q_dot) }
}

/// A start by positions and momenta.
pub(crate) fn start_with_momenta(geometry: &Geometry, q: &[f64], p: &[f64]) -> Start {
    let (field, mut rates) = (geometry.field(), geometry.field().room());
    field.evaluate(q, p, &mut rates).unwrap();
    let q_dot = (0..q.len()).map(|a| field.q_dot(&rates, a)).collect();
    Start { q: q.to_vec(), q_dot, p: p.to_vec() }
}

/// A Newtonian start at t = s = 0 with dt/dγ = 1; ds/dγ makes K zero.
pub(crate) fn newtonian_start<S: Arithmetic>(geometry: &Geometry<S>, x: &[S], v: &[S]) -> Start<S> {
    let q: Vec<S> = [S::ZERO].iter().chain(x).copied().chain([S::ZERO]).collect();
    let mut q_dot: Vec<S> = [S::ONE].iter().chain(v).copied().chain([S::ZERO]).collect();
    *q_dot.last_mut().unwrap() = -geometry.norm(&q, &q_dot).half();
    start(geometry, &q, &q_dot)
}

/// The reference in `f64`.
pub(crate) fn reference(geometry: &Geometry, start: &Start, length: f64) -> ReferenceTrajectory<f64, Geometry> {
    ReferenceTrajectory::new(geometry, start, length, 16).unwrap_or_else(|error| panic!("{error}"))
}

/// |got − want| ≤ tolerance · max(1, |want|).
#[track_caller]
pub(crate) fn assert_near(got: f64, want: f64, tolerance: f64, what: &str) {
    let error = (got - want).abs();
    assert!(error <= tolerance * want.abs().max(1.0), "{what}: {got} against {want}, error {error:e}");
}
