//! Cases, scenes and starts that several of these tests use.

use std::collections::BTreeMap;
use std::sync::Arc;

use geodesic_ivp::action::Form;
use geodesic_ivp::geometry::geodesic::InitialData;
use geodesic_ivp::geometry::metric::Metric;
use geodesic_ivp::geometry::potential::{Formula, Potential};
use geodesic_ivp::geometry::{Geometry, GeometryText, Law, MetricText, PotentialText, Preset, Start};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::sbp::SbpName;
use geodesic_ivp::solve::{Arithmetic, Limit, Place, Settings, Setup, System};
use geodesic_ivp::{Case, Solution, solve};

/// The base case of the paper, quartic potential; everything else is an override of it.
pub(crate) const QUARTIC: &str = r#"
[potential]
quartic = { kappa = 0.5 }

[initial]
t = 0.0
x = 1.0
t_dot = 1.0
x_dot = 0.1

[grid]
n_gamma = 32

[scheme]
sbp = "SBP21"
"#;

/// `QUARTIC` with overrides, separated by white space.
pub(crate) fn case(overrides: &str) -> Case {
    let overrides: Vec<String> = overrides.split_whitespace().map(str::to_owned).collect();
    Case::parse("test", QUARTIC, &overrides).unwrap_or_else(|error| panic!("{error}"))
}

/// The solution of `QUARTIC` with overrides.
pub(crate) fn solved(overrides: &str) -> Solution {
    solved_in(overrides)
}

/// The solution of `QUARTIC` with overrides in another arithmetic.
pub(crate) fn solved_in<S: Arithmetic>(overrides: &str) -> Solution<S> {
    solve(&case(overrides)).unwrap_or_else(|error| panic!("{overrides}: {error}"))
}

/// A formula without parameters as the potential of one coordinate.
pub(crate) fn formula(expression: &str) -> Potential {
    Potential::Formula(Formula::new(expression, &BTreeMap::new()).unwrap_or_else(|error| panic!("{error}")))
}

/// The scene of one coordinate in a potential, and a start at t = 0.
pub(crate) fn one(potential: Potential, c: f64, [x, t_dot, x_dot]: [f64; 3]) -> (Geometry, Start) {
    let metric = Metric::new(potential, 1.0, c);
    (metric.scene().clone(), InitialData { t: 0.0, x, t_dot, x_dot }.start(&metric))
}

/// max |a − b|.
pub(crate) fn distance<S: Arithmetic>(a: &[S], b: &[S]) -> S {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(&a, &b)| (a - b).abs()).fold(S::ZERO, S::max)
}

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

/// A start by positions and velocities.
pub(crate) fn start<S: Arithmetic>(geometry: &Geometry<S>, q: &[S], q_dot: &[S]) -> Start<S> {
    Start { q: q.to_vec(), q_dot: q_dot.to_vec(), p: geometry.momenta(q, q_dot) }
}

/// A start by positions and momenta.
pub(crate) fn start_with_momenta(geometry: &Geometry, q: &[f64], p: &[f64]) -> Start {
    let q_dot = geometry.velocities(q, p).unwrap();
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

/// Random numbers by xorshift.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn between(&mut self, least: f64, most: f64) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        least + (most - least) * ((self.0 >> 11) as f64 / (1_u64 << 53) as f64)
    }

    pub(crate) fn scale(&mut self, least: f64, most: f64) -> f64 {
        self.between(least.ln(), most.ln()).exp()
    }
}

/// A metric from `"a b" = formula` pairs.
pub(crate) fn metric(coordinates: &[&str], components: &[(&str, &str)]) -> MetricText {
    let index = |name: &str| coordinates.iter().position(|other| *other == name).unwrap();
    let pair = |names: &str| {
        let (a, b) = names.split_once(' ').unwrap();
        [index(a), index(b)]
    };
    MetricText {
        coordinates: coordinates.iter().map(|name| (*name).to_owned()).collect(),
        components: components.iter().map(|(names, text)| (pair(names), (*text).to_owned())).collect(),
        ..MetricText::default()
    }
}

/// Decimals in any precision.
pub(crate) fn numbers<S: Arithmetic>(texts: &[&str]) -> Vec<S> {
    texts.iter().map(|text| S::from_decimal(text).unwrap()).collect()
}

fn place<S: Arithmetic>(text: &GeometryText, q: &[&str], q_dot: &[&str]) -> Place<S> {
    let (q, q_dot) = (numbers::<S>(q), numbers(q_dot));
    let geometry = Geometry::new(text).unwrap().around(&q).unwrap();
    let p = geometry.momenta(&q, &q_dot);
    Place { geometry: Arc::new(geometry), start: Arc::new(Start { q, q_dot, p }) }
}

/// A scene that starts at `q` with `q_dot`, on one window of `n_gamma` nodes.
pub(crate) fn setup<S: Arithmetic>(
    text: &GeometryText,
    (q, q_dot): (&[&str], &[&str]),
    length: f64,
    (sbp, form, n_gamma): (SbpName, Form, usize),
    system: System,
) -> Setup<S> {
    Setup {
        place: place(text, q, q_dot),
        rough: place(text, q, q_dot),
        origin: None,
        gamma_i: S::ZERO,
        limit: Limit::Length(S::from(length)),
        until: Vec::new(),
        regularised: true,
        settings: Settings {
            sbp,
            form,
            n_gamma,
            windows: 1,
            system,
            digits: if S::IS_EXTENDED { 40 } else { 16 },
            max_iterations: 50,
            accuracy: None,
        },
    }
}

/// The same in so many windows.
pub(crate) fn in_windows<S: Arithmetic>(mut setup: Setup<S>, windows: usize) -> Setup<S> {
    setup.settings.windows = windows;
    setup
}
