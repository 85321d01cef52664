//! Scenes: cases with a metric, or with a potential of several coordinates, a one-form, a force, masses or another law.
//!
//! [`SceneCase::parse`] turns a text and overrides into a [`SceneCase`], or into a [`CaseError`] with its place in the
//! text. A parsed scene is valid: its formulas compile, every number is finite, the metric has an inverse at the start,
//! and the initial data determine one start.
//!
//! ```
//! use geodesic_ivp::case::SceneCase;
//! use geodesic_ivp::geometry::Start;
//!
//! let text = r#"
//!     metric.preset = "schwarzschild"
//!     initial = { r = 10.0, t_dot = 1.2, r_dot = -0.05, p_phi = -3.0 }
//!     grid.gamma_f = 40.0
//!     scheme.sbp = "GLL12"
//! "#;
//! assert!(SceneCase::is_scene(text, &[]));
//! let scene = SceneCase::parse("example", text, &[])?;
//! let start: Start = scene.start();
//! assert!((start.p[0] - 0.96).abs() < 1e-15 && (start.q_dot[2] - 0.03).abs() < 1e-15);
//! # Ok::<(), geodesic_ivp::CaseError>(())
//! ```

mod axes;
mod check;
mod conformal;
mod initial;
mod keys;
mod metric;
mod names;
mod observables;
mod potential;
mod quantity;
mod reader;
mod scenery;
mod settings;
mod setup;
mod start;
mod warnings;
mod write;

pub use initial::{Rate, SceneInitial, Sign};
pub use observables::{Axes, Event};
pub use quantity::Quantity;
pub use settings::{SceneExpect, SceneGrid, SceneSolver};

pub use crate::geometry::Direction;

use toml_edit::{Item, Table};

use self::observables::Formulas;
use self::reader::Section;
use self::settings::Context;
use super::CaseError;
use super::end::End;
use super::parse::Source;
use super::setup::wanted;
use crate::action::Form;
use crate::geometry::{Geometry, GeometryText, Start};
use crate::number::{Extended, Real};
use crate::sbp::SbpName;
use crate::solve::{Limit, Settings};

/// A whole case file with a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneCase {
    title: Option<String>,
    geometry: GeometryText,
    preset: Option<&'static str>,
    initial: SceneInitial,
    /// Whether the two roots for the rate that follows from K are one.
    is_double: bool,
    /// Whether it has a scheme that is not used, since an accuracy is asked for.
    ignores_scheme: bool,
    grid: SceneGrid,
    sbp: SbpName,
    form: Form,
    solver: SceneSolver,
    expect: Option<SceneExpect>,
    invariants: Vec<(String, String)>,
    events: Vec<Event>,
    axes: Option<Axes>,
}

/// Whether the tables are those of a scene.
pub(super) fn is_scene_table(root: &Table) -> bool {
    let table = |name: &str| root.get(name).and_then(Item::as_table_like);
    let has =
        |name: &str, keys: &[&str]| table(name).is_some_and(|table| keys.iter().any(|key| table.contains_key(key)));
    root.contains_key("metric")
        || has("potential", &["coordinates", "one_form", "force", "conformal"])
        || has("particle", &["masses", "law"])
}

impl SceneCase {
    /// Whether a text with these overrides is a scene and no case of one coordinate in a potential: it has a table
    /// `metric`, or `coordinates`, `one_form`, `force` or `conformal` of a potential, or `masses` or `law` of a
    /// particle. A text that cannot be read is none.
    pub fn is_scene(text: &str, overrides: &[String]) -> bool {
        let source = Source::new("", text, overrides);
        source.is_ok_and(|source| source.document().is_ok_and(|document| is_scene_table(document.as_table())))
    }

    /// Reads a scene from TOML `text` after applying `overrides` of the form `dotted.key=value`.
    ///
    /// # Errors
    /// [`CaseError`] for anything that is not a complete, valid scene.
    pub fn parse(source_name: &str, text: &str, overrides: &[String]) -> Result<Self, CaseError> {
        Self::from_source(&Source::new(source_name, text, overrides)?)
    }

    /// Reads a scene from its text.
    pub(super) fn from_source(source: &Source) -> Result<Self, CaseError> {
        let document = source.document()?;
        Self::read(source, Section::root(source, document.as_table()))
    }

    fn read<'t>(source: &'t Source, mut root: Section<'t>) -> Result<Self, CaseError> {
        let (title, metric, potential) = (root.take("title"), root.take("metric"), root.take("potential"));
        let [particle, initial, grid, scheme] = ["particle", "initial", "grid", "scheme"].map(|key| root.section(key));
        let [solver, expect, invariants] = ["solver", "expect", "invariants"].map(|key| root.section(key));
        let [events, plot] = ["events", "plot"].map(|key| root.section(key));
        root.finish()?;
        let mut scenery = check::geometry(&root, metric, potential, particle?)?;
        // First, because an accuracy in an override takes the scheme away.
        let solver = settings::solver(solver?, source)?;
        let scheme = scheme?;
        let ignores_scheme = solver.chooses_windows() && scheme.is_given();
        let (sbp, form) = settings::scheme(scheme, &solver)?;
        let operator = solver.chosen_by().map_or(Ok(sbp), Err);
        check::particle(&scenery)?;
        let compiled = scenery.geometry::<f64>()?;
        let initial = initial::read(initial?, &scenery, &compiled)?;
        initial.check_numbers(scenery.text.parameters())?;
        let found = check::start(&scenery, &initial, compiled, rounding(solver.digits))?;
        let (is_double, tau) = if solver.digits > f64::MOST_DIGITS {
            let geometry = scenery.geometry()?;
            let found = check::start::<Extended>(&scenery, &initial, geometry, rounding(solver.digits))?;
            (found.is_double, found.tau)
        } else {
            (found.is_double, found.tau)
        };
        scenery.add(tau);
        let start = found.start(&scenery.text, &initial)?;
        let (names, parameters) = (scenery.text.coordinates(), scenery.text.parameters());
        let formulas = Formulas { coordinates: &names, parameters, definitions: scenery.definitions() };
        let context = Context { source, names: &names, parameters, formulas: &formulas, start: &start };
        let case = Self {
            title: title.map(|field| check::title(&field)).transpose()?,
            grid: settings::grid(grid?, operator, &context)?,
            expect: settings::expect(expect?, &context)?,
            invariants: formulas.invariants(&invariants?)?,
            events: formulas.events(&events?)?,
            axes: formulas.axes(plot?)?,
            preset: scenery.preset.map(|preset| preset.name),
            initial: initial.data,
            geometry: scenery.text.clone(),
            is_double,
            ignores_scheme,
            sbp,
            form,
            solver,
        };
        if let Some(preset) = scenery.preset {
            metric::check_use(preset, &scenery.fields, |name| case.is_used(name))?;
        }
        Ok(case)
    }

    /// The same without its `[expect]` table.
    pub fn without_expectations(&self) -> Self {
        Self { expect: None, ..self.clone() }
    }

    /// A name for people, on one line.
    pub fn title(&self) -> Option<&str> {
        self.title.as_deref()
    }

    /// The metric or the potential as formulas; those of a preset, with what the case replaces.
    pub fn geometry_text(&self) -> &GeometryText {
        &self.geometry
    }

    /// The preset, if the case names one.
    pub fn preset(&self) -> Option<&'static str> {
        self.preset
    }

    /// The names of all coordinates, in order, with those that the scene adds itself.
    pub fn coordinates(&self) -> Vec<String> {
        self.geometry.coordinates()
    }

    /// The initial data as they are given.
    pub fn initial(&self) -> &SceneInitial {
        &self.initial
    }

    /// The compiled geometry, whose determinants must keep the signs that they have at the start.
    pub fn geometry<S: Real>(&self) -> Geometry<S> {
        let geometry = Geometry::new(&self.geometry).expect("a valid scene has valid formulas");
        let tau = self.geometry.tau().map(|_| S::ZERO);
        let q: Vec<S> = self.initial.q.iter().map(|q| self.value(q)).chain(tau).collect();
        geometry.around(&q).unwrap_or_else(|outside| panic!("a valid scene starts inside its domain: {outside:?}"))
    }

    /// The start: positions, velocities and momenta, with what follows from K.
    pub fn start<S: Real>(&self) -> Start<S> {
        self.start_in(&self.geometry())
    }

    /// The start in the geometry of this scene, which [`Self::geometry`] has compiled.
    pub fn start_in<S: Real>(&self, geometry: &Geometry<S>) -> Start<S> {
        let (parameters, rounding) = (self.geometry.parameters(), rounding(self.solver.digits));
        let bare = conformal::bare(&self.geometry);
        let bare = bare.map(|text| Geometry::new(&text).expect("a valid scene has valid formulas"));
        let of_data = bare.as_ref().unwrap_or(geometry);
        let solved = start::solve(&self.initial, of_data, parameters, rounding, Some(self.is_double));
        let start = solved.unwrap_or_else(|none| panic!("a valid scene has a start: {none:?}")).start;
        conformal::with_factor(&self.geometry, of_data, &self.initial, start)
    }

    /// A number of this scene, rounded once if it is written as a decimal.
    pub fn value<S: Real>(&self, quantity: &Quantity) -> S {
        quantity.value(self.geometry.parameters()).expect("the numbers of a valid scene are finite")
    }

    /// The first value of γ.
    pub fn gamma_i<S: Real>(&self) -> S {
        self.value(&self.grid.gamma_i)
    }

    /// Where the run ends: the length of its range of γ, or its duration in the coordinate t. With [`Self::until`] it
    /// may end before.
    pub fn end<S: Real>(&self) -> End<S> {
        End::new(self.limit(), |t| self.value(&self.initial.q[t]))
    }

    /// The same, as the solver is told.
    fn limit<S: Real>(&self) -> Limit<S> {
        match (self.t_f(), &self.grid.gamma_f) {
            (Some(value), _) => {
                let t = self.coordinates().iter().position(|name| name == "t");
                Limit::Value { coordinate: t.expect("t_f needs a coordinate t"), value }
            }
            (None, gamma_f) => {
                let default = || S::from(super::DEFAULT_GAMMA_F);
                Limit::Length(gamma_f.as_ref().map_or_else(default, |last| self.value(last)) - self.gamma_i())
            }
        }
    }

    /// The value of the coordinate t at which the run ends, if that is given.
    pub fn t_f<S: Real>(&self) -> Option<S> {
        self.grid.t_f.as_ref().map(|t_f| self.value(t_f))
    }

    /// A formula of positions and velocities: the run ends where it changes its sign.
    pub fn until(&self) -> Option<&str> {
        self.grid.until.as_deref()
    }

    /// `[grid]`.
    pub fn grid(&self) -> &SceneGrid {
        &self.grid
    }

    /// How its world-line is computed.
    pub fn settings(&self) -> Settings {
        let SceneSolver { system, digits, max_iterations, ref accuracy, ref tolerance } = self.solver;
        let value = |number: &Option<Quantity>| number.as_ref().map(|number| self.value(number));
        Settings {
            sbp: self.sbp,
            form: self.form,
            n_gamma: self.grid.n_gamma,
            windows: self.grid.windows,
            system,
            digits,
            max_iterations,
            accuracy: wanted([value(accuracy), value(tolerance)]),
        }
    }

    /// Whether the scene asks for more digits than `f64` has.
    pub fn is_extended(&self) -> bool {
        self.settings().is_extended()
    }

    /// The results that this scene must have.
    pub fn expect(&self) -> Option<&SceneExpect> {
        self.expect.as_ref()
    }

    /// Names and formulas of `[invariants]`, in positions, velocities, momenta, `norm`, parameters and definitions.
    pub fn invariants(&self) -> &[(String, String)] {
        &self.invariants
    }

    /// `[events]`.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// `[plot]`.
    pub fn axes(&self) -> Option<&Axes> {
        self.axes.as_ref()
    }
}

/// The relative accuracy of data of so many digits.
fn rounding(digits: u32) -> f64 {
    if digits > f64::MOST_DIGITS { 10.0_f64.powi(-(digits as i32)) } else { f64::EPSILON }
}
