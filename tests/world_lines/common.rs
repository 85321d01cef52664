//! Scenes that several tests use.

use std::sync::Arc;

use geodesic_ivp::action::Form;
use geodesic_ivp::geometry::{Geometry, GeometryText, MetricText, Start};
use geodesic_ivp::sbp::SbpName;
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::solve::{Limit, Place, Settings, Setup, System};

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
