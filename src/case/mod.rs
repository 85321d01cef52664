//! Case files: the strict TOML schema, its defaults, and the space-time, the start and the end that a case stands for.
//!
//! [`Case::parse`] turns a text and overrides into a [`Case`], or into a [`CaseError`] with its place in the text. A
//! parsed case is valid: its formulas compile, every number is finite, the metric has an inverse at the start, and the
//! initial data determine one start.
//!
//! ```
//! use geodesic_ivp::Case;
//! use geodesic_ivp::geometry::Start;
//!
//! let text = r#"
//!     metric.preset = "schwarzschild"
//!     initial = { r = 10.0, t_dot = 1.2, r_dot = -0.05, p_phi = -3.0 }
//!     grid.gamma_f = 40.0
//!     scheme.sbp = "GLL12"
//! "#;
//! let case = Case::parse("example", text, &[])?;
//! let start: Start = case.start();
//! assert!((start.p[0] - 0.96).abs() < 1e-15 && (start.q_dot[2] - 0.03).abs() < 1e-15);
//! # Ok::<(), geodesic_ivp::CaseError>(())
//! ```

mod bodies;
pub mod builtin;
mod check;
mod compiled;
mod condition;
mod contents;
mod dotted;
mod effective;
mod error;
mod files;
mod find;
mod hint;
mod initial;
mod intervals;
mod keys;
mod limits;
mod metric;
mod missing;
mod mistakes;
mod names;
mod observables;
mod parameters;
mod parse;
mod potential;
mod reader;
mod scenery;
mod schema;
mod settings;
mod setup;
mod source;
mod start;
mod start_data;
mod tables;
mod warnings;

use std::path::PathBuf;
use std::sync::Arc;

pub use crate::action::Form;
pub use crate::geometry::Direction;
pub use crate::sbp::SbpName;
pub use crate::solve::System;
pub use condition::Condition;
pub use contents::named;
pub use error::CaseError;
pub use files::{MOST_OF_CASE, MOST_OF_SUMMARY, MOST_OF_TABLE, read_at_most, read_file, read_text};
pub use find::{Data, Find, Goal, Series, Unknown};
pub use intervals::Interval;
pub use keys::{Cases, KEYS, Key};
pub use limits::on_grid;
pub use observables::{Axes, Event};
pub use schema::{choices, schema};
pub use settings::{Expect, Grid, default_iterations};
pub(crate) use setup::WatchedFormula;
pub use source::{key_of, overridden};
pub use start_data::{Rate, Sign, StartData};

use self::compiled::Compiled;
use crate::geometry::{Geometry, GeometryText, Start, WrittenRates, value_of};
use crate::number::{Extended, Kind, Real};
use crate::solve::{Carried, Continuation, Limit, Settings};

/// A whole case file.
#[derive(Debug, Clone)]
pub struct Case {
    /// A name for people, on one line.
    pub title: Option<String>,
    /// The metric or the potential as formulas; those of a preset, with what the case replaces.
    pub geometry_text: GeometryText,
    /// The same, compiled.
    compiled: Arc<Compiled>,
    /// The compiled geometry in doubles, whose determinants must keep the signs that they have at the start.
    rough: Geometry,
    /// The preset, if the case names one.
    pub preset: Option<&'static str>,
    /// True if it is a particle in a potential of x alone and what is asked for is what the paper has: no formulas of
    /// the case's own, no other law, force or one-form. Its t counts from the start, and its summary has the paper's
    /// names.
    pub is_of_x: bool,
    /// The coefficients of V, lowest power first, if it is given by them.
    coefficients: Option<Vec<String>>,
    /// The names of the bodies, if it is made of these.
    bodies: Vec<String>,
    /// The initial data as they are given.
    pub initial: StartData,
    /// The numbers of the start that are intervals, of which a run takes the middle.
    pub intervals: Vec<Interval>,
    /// The end of the run that it continues, if it continues one.
    from: Option<Continuation>,
    /// The summary of that run.
    pub continues: Option<PathBuf>,
    /// dt/dγ at the start, if there is a coordinate t; otherwise 0.
    t_dot: f64,
    /// True if the two roots for the rate that follows from K are one.
    is_double: bool,
    /// True if it has a scheme that is not used, since an accuracy is asked for.
    ignores_scheme: bool,
    /// `[grid]`, but for its numbers of nodes and windows.
    pub grid: Grid,
    /// The settings by which its world-line is computed.
    pub settings: Settings,
    /// True if a run also proves where its motion ends; `None`: if that [costs little](crate::study::proof::FREE).
    pub proof: Option<bool>,
    /// Sizes of coordinates, by their index, below which an accuracy is absolute.
    floors: Vec<(usize, String)>,
    /// The results that this case must have.
    pub expect: Option<Expect>,
    /// Names and formulas of `[invariants]`, in positions, velocities, momenta, `norm`, parameters and definitions.
    pub invariants: Vec<(String, String)>,
    /// `[events]`.
    pub events: Vec<Event>,
    /// `[plot]`.
    pub axes: Option<Axes>,
    /// The former tables of parameters that it is given in.
    former: Vec<&'static str>,
    /// `[find]`.
    pub find: Option<Find>,
    /// The folder of its file, from which the paths of tables are counted.
    folder: PathBuf,
    /// The text as it was read, with its overrides.
    text: String,
}

/// The geometry of a case.
struct OfGeometry;

impl Kind for OfGeometry {
    type Of<S: Real> = Geometry<S>;
}

/// Two cases are equal if they are the same text once every default is filled in.
impl PartialEq for Case {
    fn eq(&self, other: &Self) -> bool {
        self.to_toml() == other.to_toml()
    }
}

impl Case {
    /// The names of its events, in order.
    pub fn event_names(&self) -> Vec<&str> {
        self.events.iter().map(|event| event.name.as_str()).collect()
    }

    /// True if a number of it is an interval, and a proof says where all motions are.
    pub fn has_hull(&self) -> bool {
        !self.intervals.is_empty() && self.proof != Some(false)
    }

    /// The names of all coordinates, in order, with those that the space-time adds itself.
    pub fn coordinates(&self) -> Vec<String> {
        self.geometry_text.names()
    }

    /// The compiled geometry, whose determinants must keep the signs that they have at the start.
    pub fn geometry<S: Real>(&self) -> Geometry<S> {
        let exact = || {
            let geometry = self.compiled.geometry::<Extended>().expect("a valid case has valid formulas");
            let tau = self.geometry_text.tau.map(|_| Extended::ZERO);
            let q: Vec<Extended> = self.initial.q.iter().map(|q| self.value(q)).chain(tau).collect();
            geometry
                .with_domain_of(&q)
                .unwrap_or_else(|outside| panic!("a valid case starts inside its domain: {outside:?}"))
        };
        S::choose::<OfGeometry>(|| self.rough.clone(), exact)
    }

    /// Hamilton's equations as they are written, of the motion that the solver computes, in 70 digits; `None` if these
    /// have none.
    pub(crate) fn written_rates(&self, is_backward: bool) -> Option<WrittenRates<Extended>> {
        self.compiled.rates(is_backward)
    }

    /// The coefficients of g00(x) = c² + 2V/m, lowest power first, if V is given by its coefficients.
    pub fn g00(&self) -> Option<Vec<f64>> {
        let potential = self.geometry_text.potential.as_ref()?;
        let number = |text: &String| value_of::<f64>(text, &self.geometry_text.parameters).ok();
        let twice = 2.0 / number(&potential.mass)?;
        let coefficients = self.coefficients.as_ref()?.iter();
        let mut g00: Vec<f64> = coefficients.map(|c| Some(number(c)? * twice)).collect::<Option<_>>()?;
        g00.resize(g00.len().max(1), 0.0);
        g00[0] += number(&potential.c)?.powi(2);
        Some(g00)
    }

    /// The start: positions, velocities and momenta, with what follows from K. In a potential of x alone t counts from
    /// it.
    pub fn start<S: Real>(&self) -> Start<S> {
        self.start_in(&self.geometry())
    }

    /// The start in the geometry of this case, which [`Self::geometry`] has compiled.
    pub fn start_in<S: Real>(&self, geometry: &Geometry<S>) -> Start<S> {
        if let Some((start, _)) = self.carried(geometry) {
            return start;
        }
        let (text, rounding) = (&self.geometry_text, rounding(self.settings.digits));
        let start = scenery::start(text, geometry, &self.initial, rounding, Some(self.is_double));
        let mut start = start.unwrap_or_else(|none| panic!("a valid case has a start: {none:?}"));
        if self.counts_from_start() {
            start.q[0] = S::ZERO;
        }
        start
    }

    /// Returns true if the start is the one that the decimals of the case determine. A rate that follows from K is
    /// taken as a double root where the roots agree in the digits of the run, as at a turning point, though the last
    /// digits of the numbers may say otherwise.
    pub fn is_determined(&self) -> bool {
        if self.from.is_some() || !self.initial.rates.iter().any(Rate::is_from_norm) {
            return true;
        }
        let geometry: Geometry<Extended> = self.geometry();
        let taken = self.start_in(&geometry);
        let rounding = Extended::EPSILON.to_f64();
        let exact = scenery::start(&self.geometry_text, &geometry, &self.initial, rounding, None);
        let is_near =
            |(one, two): (&Extended, &Extended)| (*one - *two).abs().to_f64() <= DETERMINED * one.abs().to_f64();
        exact.is_ok_and(|exact| taken.q_dot.iter().zip(&exact.q_dot).all(is_near))
    }

    /// The end of the run that this one continues, with what it takes over besides.
    fn carried<S: Real>(&self, geometry: &Geometry<S>) -> Option<(Start<S>, Carried<S>)> {
        let from = self.from.as_ref()?;
        let (start, carried) = from.state(geometry, self.is_backward())?;
        let keeps_energy = || from.norm().is_none_or(|norm| start::has_norm(geometry, &start, norm));
        let start = if self.is_lifted() && !keeps_energy() { start::with_energy(geometry, start)? } else { start };
        Some((start, carried))
    }

    /// A number of this case, rounded once if it is written as a decimal.
    pub fn value<S: Real>(&self, number: &str) -> S {
        value_of(number, &self.geometry_text.parameters).expect("the numbers of a valid case are finite")
    }

    /// The first value of γ.
    pub fn gamma_i<S: Real>(&self) -> S {
        self.value(&self.grid.gamma_i)
    }

    /// Where the run ends: after a length of γ, or at a value of the coordinate t. With `grid.until` it may end
    /// before.
    pub fn limit<S: Real>(&self) -> Limit<S> {
        if let Some(value) = self.t_f() {
            let t = self.coordinates().iter().position(|name| name == "t");
            return Limit::Value { coordinate: t.expect("t_f needs a coordinate t"), value };
        }
        let gamma_f = self.grid.gamma_f.as_deref().expect("a run without t_f ends at gamma_f");
        Limit::Length((self.value::<S>(gamma_f) - self.gamma_i()).abs())
    }

    /// The value of the coordinate t at which the run ends, if that is given.
    pub fn t_f<S: Real>(&self) -> Option<S> {
        self.grid.t_f.as_ref().map(|t_f| self.value(t_f))
    }
}

/// Rates that are determined agree to this part of them.
const DETERMINED: f64 = 1e-60;

/// The relative accuracy of data of so many digits.
fn rounding(digits: u32) -> f64 {
    if digits > f64::MOST_DIGITS { 10.0_f64.powi(-(digits as i32)) } else { f64::EPSILON }
}
