//! Case files: the strict TOML schema, its defaults, and the metric, initial data and end that a case stands for.
//!
//! [`Case::parse`] turns a text and overrides into a [`Case`], or into a [`CaseError`] with its place in the text. A
//! parsed `Case` is valid: every number is finite, the grid fits the operator, and g00 is positive at the start.

mod any;
pub mod builtin;
mod decimal;
mod end;
mod error;
mod formula_spec;
mod grid;
mod hint;
mod keys;
mod parse;
pub mod scene;
mod setup;
mod validate;
mod warnings;
mod write;

use serde::{Deserialize, Serialize};

pub use crate::action::Form;
pub use crate::sbp::SbpName;
pub use crate::solve::System;
pub use any::AnyCase;
pub use decimal::Decimal;
pub use end::End;
pub use error::CaseError;
pub use formula_spec::FormulaSpec;
pub use grid::on_grid;
pub use keys::{KEYS, Key, SCENE_KEYS};
pub use parse::{key_of, overridden};
pub use scene::SceneCase;

use crate::geometry::{Geometry, GeometryError, PotentialText, Start};
use crate::number::Real;
use crate::solve::{Limit, Status};

/// The place of t among the coordinates t and x.
const T: usize = 0;

/// A whole case file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// A name for people, on one line.
    pub title: Option<String>,
    /// The potential V(x).
    pub potential: PotentialSpec,
    /// Mass and speed of light.
    #[serde(default)]
    pub particle: Particle,
    /// The world-line's first point and tangent.
    pub initial: Initial,
    /// The range of the world-line parameter γ, its nodes and its windows.
    #[serde(default)]
    pub grid: Grid,
    /// Operator and form of the action; required unless an accuracy is asked for.
    #[serde(default)]
    pub scheme: Scheme,
    /// How the critical point is computed.
    #[serde(default)]
    pub solver: Solver,
    /// The results that this case must have.
    pub expect: Option<Expect>,
}

/// `[potential]`: exactly one of these.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum PotentialSpec {
    /// V = 0.
    Free {},
    /// V = α x.
    Linear {
        /// α.
        alpha: Decimal,
    },
    /// V = κ x⁴.
    Quartic {
        /// κ.
        kappa: Decimal,
    },
    /// V = Σ_k c_k x^k.
    Polynomial {
        /// c_0, c_1, …
        coefficients: Vec<Decimal>,
    },
    /// V from an expression; see [`FormulaSpec`].
    Formula(FormulaSpec),
}

/// `[particle]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Particle {
    /// The mass m > 0.
    pub mass: Decimal,
    /// The speed of light c > 0.
    pub c: Decimal,
}

impl Default for Particle {
    fn default() -> Self {
        Self { mass: Decimal::from(1.0), c: Decimal::from(1.0) }
    }
}

/// `[initial]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Initial {
    /// t_i.
    #[serde(default = "zero")]
    pub t: Decimal,
    /// x_i.
    pub x: Decimal,
    /// dt/dγ at γ_i.
    pub t_dot: Decimal,
    /// dx/dγ at γ_i. A case has either this or `velocity`.
    pub x_dot: Option<Decimal>,
    /// dx/dt at γ_i. A case has either this or `x_dot`.
    pub velocity: Option<Decimal>,
}

/// `[grid]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// First value of γ.
    #[serde(default = "zero")]
    pub gamma_i: Decimal,
    /// Last value of γ; 1 if neither this nor `t_f` is given.
    pub gamma_f: Option<Decimal>,
    /// The physical time at which the run ends; an alternative to `gamma_f`.
    pub t_f: Option<Decimal>,
    /// Number of nodes N of each window. It may be left out for a spectral element, which fixes it. It is 0 if the case
    /// asks for an accuracy.
    #[serde(default)]
    pub n_gamma: usize,
    /// Number of windows into which γ_f − γ_i is divided. Each has N nodes of its own and continues the one before.
    #[serde(default = "one")]
    pub windows: usize,
}

impl Default for Grid {
    /// The grid of a case that leaves its choice to the program.
    fn default() -> Self {
        Self { gamma_i: zero(), gamma_f: None, t_f: None, n_gamma: 0, windows: one() }
    }
}

/// γ_f of a case that gives neither γ_f nor t_f.
const DEFAULT_GAMMA_F: f64 = 1.0;

fn zero() -> Decimal {
    Decimal::from(0.0)
}

fn one() -> usize {
    1
}

/// `[scheme]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scheme {
    /// The SBP operator.
    #[serde(default = "chosen")]
    pub sbp: SbpName,
    /// The form of the action.
    #[serde(default)]
    pub form: Form,
    /// Whether the action has the regularised operator D̄ or, to show what that is for, D.
    #[serde(default = "yes")]
    pub regularised: bool,
}

/// A stand-in where the case asks for an accuracy: the operators that are chosen then are of this kind.
fn chosen() -> SbpName {
    SbpName::Gll(24)
}

impl Default for Scheme {
    /// The scheme of a case that asks for an accuracy.
    fn default() -> Self {
        Self { sbp: chosen(), form: Form::Weak, regularised: true }
    }
}

fn yes() -> bool {
    true
}

/// `[solver]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Solver {
    /// The system that is solved.
    pub system: System,
    /// Significant decimal digits of the results, 16 to 70: 16 means `f64`, and more means
    /// [`Extended`](crate::number::Extended).
    pub digits: u32,
    /// Largest number of Newton iterations in a window. The fixed-point iteration of weak spectral elements has its own
    /// limit.
    pub max_iterations: usize,
    /// The error allowed in t and x at any node, relative to their sizes. With it the program chooses operator and
    /// windows, and `grid.n_gamma`, `grid.windows` and `scheme` are left out.
    pub accuracy: Option<Decimal>,
    /// The same for every window by itself: the run goes on whatever errors grow to. At most one of the two is given.
    pub tolerance: Option<Decimal>,
}

impl Solver {
    /// True if the program chooses operator and windows.
    pub fn chooses_windows(&self) -> bool {
        self.accuracy.is_some() || self.tolerance.is_some()
    }
}

impl Default for Solver {
    fn default() -> Self {
        Self { system: System::default(), digits: 16, max_iterations: 50, accuracy: None, tolerance: None }
    }
}

/// `[expect]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// How the run must end (default `converged`).
    #[serde(default = "converged")]
    pub status: Status,
    /// t at the last node.
    pub t_final: Option<Decimal>,
    /// x at the last node.
    pub x_final: Option<Decimal>,
    /// Largest absolute difference allowed in `t_final` and `x_final`.
    pub tolerance: Option<Decimal>,
}

fn converged() -> Status {
    Status::Converged
}

impl Case {
    /// Where the run ends: the length of its range of γ, or its duration.
    pub fn end<S: Real>(&self) -> End<S> {
        End::new(self.limit(), |_| self.initial.t.to())
    }

    /// Where the run ends, as the solver is told.
    fn limit<S: Real>(&self) -> Limit<S> {
        match (&self.grid.t_f, &self.grid.gamma_f) {
            (Some(t_f), _) => Limit::Value { coordinate: T, value: t_f.to() },
            (None, gamma_f) => {
                let gamma_f = gamma_f.as_ref().map_or(S::from(DEFAULT_GAMMA_F), Decimal::to);
                Limit::Length(gamma_f - self.grid.gamma_i.to())
            }
        }
    }

    /// Whether the case asks for more digits than `f64` has, and is therefore to be solved in
    /// [`Extended`](crate::number::Extended).
    pub fn is_extended(&self) -> bool {
        self.settings().is_extended()
    }

    /// The potential with the particle, as text. A polynomial is written by Horner's rule.
    fn potential_text(&self) -> PotentialText {
        let number = |number: &Decimal| format!("({})", number.literal());
        let mut parameters = Vec::new();
        let expression = match &self.potential {
            PotentialSpec::Free {} => "0".to_owned(),
            PotentialSpec::Linear { alpha } => format!("{}*x", number(alpha)),
            PotentialSpec::Quartic { kappa } => format!("{}*x*x*x*x", number(kappa)),
            PotentialSpec::Polynomial { coefficients } => {
                let horner = |sum: String, c: &Decimal| format!("({sum}*x + {})", number(c));
                coefficients.iter().rev().fold("0".to_owned(), horner)
            }
            PotentialSpec::Formula(FormulaSpec { expression, parameters: given }) => {
                parameters.extend(given.iter().map(|(name, value)| (name.clone(), number(value))));
                expression.clone()
            }
        };
        let mass = number(&self.particle.mass);
        PotentialText {
            coordinates: vec!["x".to_owned()],
            expression,
            parameters,
            masses: vec![mass.clone()],
            mass,
            c: number(&self.particle.c),
            ..PotentialText::default()
        }
    }

    /// The case's space-time of t and x.
    ///
    /// # Panics
    /// If the case is not valid: g00 is 0 everywhere.
    pub fn geometry<S: Real>(&self) -> Geometry<S> {
        self.compiled().expect("a valid case has a valid geometry")
    }

    fn compiled<S: Real>(&self) -> Result<Geometry<S>, GeometryError> {
        Geometry::of_x(self.potential_text())
    }

    /// The coefficients of g00(x) = c² + 2V/m, lowest power first, if V is given by its coefficients.
    pub fn g00(&self) -> Option<Vec<f64>> {
        let mut g00: Vec<f64> = match &self.potential {
            PotentialSpec::Free {} => Vec::new(),
            PotentialSpec::Linear { alpha } => vec![0.0, alpha.value()],
            PotentialSpec::Quartic { kappa } => vec![0.0, 0.0, 0.0, 0.0, kappa.value()],
            PotentialSpec::Polynomial { coefficients } => coefficients.iter().map(Decimal::value).collect(),
            PotentialSpec::Formula(_) => return None,
        };
        g00.iter_mut().for_each(|c| *c *= 2.0 / self.particle.mass.value());
        g00.resize(g00.len().max(1), 0.0);
        g00[0] += self.particle.c.value().powi(2);
        Some(g00)
    }

    /// The start, from which t is counted, in the case's space-time; ẋ_i = velocity · ṫ_i if the case gives a velocity.
    pub fn start<S: Real>(&self) -> Start<S> {
        self.start_in(&self.geometry())
    }

    fn start_in<S: Real>(&self, geometry: &Geometry<S>) -> Start<S> {
        let Initial { x, t_dot, x_dot, velocity, .. } = &self.initial;
        let t_dot = t_dot.to::<S>();
        let by_velocity = || velocity.as_ref().map(|velocity| velocity.to::<S>() * t_dot);
        let x_dot = x_dot.as_ref().map(Decimal::to).or_else(by_velocity).expect("a valid case has x_dot or velocity");
        let (q, q_dot) = (vec![S::ZERO, x.to()], vec![t_dot, x_dot]);
        let p = geometry.momenta(&q, &q_dot);
        Start { q, q_dot, p }
    }
}
