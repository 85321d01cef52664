//! Case files: the strict TOML schema, its defaults, and what a valid case means.
//!
//! [`Case::parse`] turns text and overrides into a [`Case`] or one [`CaseError`] with its place in the text. A parsed
//! `Case` is valid: every number is finite, the grid fits the operator, and g00 is positive at the start.

mod error;
mod parse;
mod validate;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use error::CaseError;

use crate::geodesic::InitialData;
use crate::metric::Metric;
use crate::potential::{Formula, Potential};
use crate::sbp::{Coefficients, coefficients};
use crate::solve::Status;

/// A whole case file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// A line for people.
    pub title: Option<String>,
    /// V(x).
    pub potential: PotentialSpec,
    /// Mass and speed of light.
    #[serde(default)]
    pub particle: Particle,
    /// The world-line's first point and tangent.
    pub initial: Initial,
    /// The world-line parameter.
    pub grid: Grid,
    /// Operator and form of the action.
    pub scheme: Scheme,
    /// How the critical point is computed.
    #[serde(default)]
    pub solver: Solver,
    /// Numbers this case must meet.
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
        alpha: f64,
    },
    /// V = κ x⁴.
    Quartic {
        /// κ.
        kappa: f64,
    },
    /// V = Σ_k c_k x^k.
    Polynomial {
        /// c_0, c_1, …
        coefficients: Vec<f64>,
    },
    /// V from an expression; see [`Formula`].
    Formula {
        /// The expression in x and the parameters.
        expression: String,
        /// Values of the names used in it.
        #[serde(default)]
        parameters: BTreeMap<String, f64>,
    },
}

/// `[particle]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Particle {
    /// m > 0.
    pub mass: f64,
    /// Speed of light c > 0.
    pub c: f64,
}

impl Default for Particle {
    fn default() -> Self {
        Self { mass: 1.0, c: 1.0 }
    }
}

/// `[initial]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Initial {
    /// t_i.
    pub t: f64,
    /// x_i.
    pub x: f64,
    /// dt/dγ at γ_i.
    pub t_dot: f64,
    /// dx/dγ at γ_i; this or `velocity`.
    pub x_dot: Option<f64>,
    /// dx/dt at γ_i; this or `x_dot`.
    pub velocity: Option<f64>,
}

/// `[grid]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// First value of γ.
    #[serde(default)]
    pub gamma_i: f64,
    /// Last value of γ; 1 if neither this nor `t_f` is given.
    pub gamma_f: Option<f64>,
    /// Physical time at which to end, instead of `gamma_f`.
    pub t_f: Option<f64>,
    /// Number of nodes N.
    pub n_gamma: usize,
    /// Number of windows (more than one is not available yet).
    #[serde(default = "one")]
    pub windows: usize,
}

/// γ_f of a case that gives neither γ_f nor t_f.
const DEFAULT_GAMMA_F: f64 = 1.0;

fn one() -> usize {
    1
}

/// The SBP operators that can be asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum SbpName {
    /// Second order inside.
    Sbp21,
    /// Fourth order inside.
    Sbp42,
}

impl SbpName {
    /// The coefficients of that name.
    pub fn coefficients(self) -> &'static Coefficients {
        match self {
            Self::Sbp21 => &coefficients::SBP21,
            Self::Sbp42 => &coefficients::SBP42,
        }
    }
}

impl TryFrom<String> for SbpName {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let is_gll = |n: &str| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit());
        match name.as_str() {
            "SBP21" => Ok(Self::Sbp21),
            "SBP42" => Ok(Self::Sbp42),
            "SBP63" | "SBP84" => Err(format!("{name} is not available yet; use SBP21 or SBP42")),
            other if other.strip_prefix("GLL").is_some_and(is_gll) => {
                Err(format!("{name} is not available yet; use SBP21 or SBP42"))
            }
            _ => Err(format!(
                "unknown operator \"{name}\", expected SBP21, SBP42 (SBP63, SBP84 and GLL<n> are not available yet)"
            )),
        }
    }
}

impl From<SbpName> for String {
    fn from(name: SbpName) -> Self {
        name.coefficients().name.to_owned()
    }
}

/// The form of the action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(try_from = "String", rename_all = "lowercase")]
pub enum Form {
    /// The paper's: initial and connecting conditions by Lagrange multipliers.
    #[default]
    Strong,
}

impl Form {
    /// The name used in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Strong => "strong",
        }
    }
}

impl TryFrom<String> for Form {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        match name.as_str() {
            "strong" => Ok(Self::Strong),
            "weak" => Err("form = \"weak\" is not available yet; use \"strong\"".to_owned()),
            _ => Err(format!("unknown form \"{name}\", expected strong or weak")),
        }
    }
}

/// `[scheme]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scheme {
    /// The SBP operator.
    pub sbp: SbpName,
    /// The form of the action.
    #[serde(default)]
    pub form: Form,
    /// D̄ (true) or D (false, the ablation) in the action.
    #[serde(default = "yes")]
    pub regularised: bool,
}

fn yes() -> bool {
    true
}

/// What is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum System {
    /// The collocation system that the critical point is, certified on the doubled action.
    #[default]
    PhysicalLimit,
    /// ∇E_IVP = 0 in all 4N + 8 unknowns.
    Doubled,
}

/// `[solver]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Solver {
    /// Which system.
    pub system: System,
    /// Significant decimal digits; 16 means `f64` (more is not available yet).
    pub digits: u32,
    /// Most Newton iterations.
    pub max_iterations: usize,
    /// Accuracy asked for (not available yet).
    pub accuracy: Option<f64>,
}

impl Default for Solver {
    fn default() -> Self {
        Self { system: System::default(), digits: 16, max_iterations: 50, accuracy: None }
    }
}

/// `[expect]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// How the solve must end (default `converged`).
    #[serde(default = "converged")]
    pub status: Status,
    /// t at the last node.
    pub t_final: Option<f64>,
    /// x at the last node.
    pub x_final: Option<f64>,
    /// Largest absolute difference allowed in `t_final` and `x_final`.
    pub tolerance: Option<f64>,
}

fn converged() -> Status {
    Status::Converged
}

/// Where a run ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// At γ_f: the length γ_f − γ_i of the world-line parameter's range.
    Length(f64),
    /// At a physical time: the duration t_f − t_i.
    Duration(f64),
}

impl Case {
    /// Where the run ends, counted from its start.
    pub fn end(&self) -> End {
        match (self.grid.t_f, self.grid.gamma_f) {
            (Some(t_f), _) => End::Duration(t_f - self.initial.t),
            (None, gamma_f) => End::Length(gamma_f.unwrap_or(DEFAULT_GAMMA_F) - self.grid.gamma_i),
        }
    }

    /// The case with another operator and number of nodes, on γ ∈ [0, `length`].
    ///
    /// # Errors
    /// What is wrong with that grid.
    pub fn on_grid(&self, sbp: SbpName, n_gamma: usize, length: f64) -> Result<Self, String> {
        let mut case = self.clone();
        case.scheme.sbp = sbp;
        case.grid = Grid { gamma_i: 0.0, gamma_f: Some(length), t_f: None, n_gamma, ..self.grid };
        case.check_grid().map_err(|invalid| invalid.message)?;
        Ok(case)
    }

    /// V(x).
    pub fn potential(&self) -> Potential {
        match &self.potential {
            PotentialSpec::Free {} => Potential::free(),
            PotentialSpec::Linear { alpha } => Potential::linear(*alpha),
            PotentialSpec::Quartic { kappa } => Potential::quartic(*kappa),
            PotentialSpec::Polynomial { coefficients } => Potential::polynomial(coefficients.clone()),
            PotentialSpec::Formula { expression, parameters } => {
                Potential::Formula(Formula::new(expression, parameters).expect("a valid case has a valid formula"))
            }
        }
    }

    /// The metric of the case's space-time.
    pub fn metric(&self) -> Metric {
        Metric::new(self.potential(), self.particle.mass, self.particle.c)
    }

    /// Start and tangent, with ẋ_i = velocity · ṫ_i where the velocity is given.
    pub fn initial_data(&self) -> InitialData {
        let Initial { t, x, t_dot, x_dot, velocity } = self.initial;
        let x_dot = x_dot.or(velocity.map(|v| v * t_dot)).expect("a valid case has x_dot or velocity");
        InitialData { t, x, t_dot, x_dot }
    }

    /// What a user should know before believing the result.
    pub fn warnings(&self) -> Vec<String> {
        let invariants = self.initial_data().invariants(&self.metric());
        let mut warnings = Vec::new();
        if !self.scheme.regularised {
            warnings.push(
                "regularised = false: without the regularisation critical points are wrong or missing".to_owned(),
            );
        }
        if invariants.k < 0.0 {
            warnings.push(format!(
                "the initial tangent is spacelike (K = g00 t_dot^2 - x_dot^2 = {:.6} < 0): the particle starts faster than \
                 light, and the bound on H_BVP does not hold",
                invariants.k
            ));
        }
        warnings
    }

    /// The case with every default filled in, as TOML; reading it again gives the same case.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("every case can be written as TOML")
    }
}
