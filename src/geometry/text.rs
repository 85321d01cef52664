//! A scene as text: what a case file says about the metric, and what is wrong with it.

use crate::formula::FormulaError;
use crate::number::Real;
use crate::number::spline::Table;

/// The metric of a scene in formulas of its coordinates.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MetricText {
    /// The names of the coordinates.
    pub coordinates: Vec<String>,
    /// g_ab by the indices of a pair of coordinates. What is not given is zero; a pair stands for both orders.
    pub components: Vec<([usize; 2], String)>,
    /// Named expressions in the coordinates, the parameters and each other.
    pub definitions: Vec<(String, String)>,
    /// Named constants: numbers, or formulas in each other.
    pub parameters: Vec<(String, String)>,
    /// A_a by the index of the coordinate. What is not given is zero.
    pub one_form: Vec<(usize, String)>,
    /// F_a in the coordinates and their derivatives `NAME_dot` = dq/dγ. What is not given is zero.
    pub force: Vec<(usize, String)>,
    /// Ω in the coordinates: the metric is Ω times what the components say.
    pub conformal: Option<String>,
    /// One more coordinate, which makes K zero.
    pub tau: Option<Tau>,
    /// Functions that formulas may use.
    pub tables: Vec<(String, Table)>,
    /// Parameters that events set: no formula is simplified by their values.
    pub held: Vec<String>,
}

/// The flat coordinate `tau`, with which a particle with K ≠ 0 is one with K = 0. It is the last one, and coupled to no
/// other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tau {
    /// K > 0: its component is −Ω.
    Timelike,
    /// K < 0: its component is Ω.
    Spacelike,
}

impl Tau {
    /// Its name.
    pub const NAME: &'static str = "tau";

    /// Its component, without Ω.
    pub fn component<S: Real>(self) -> S {
        match self {
            Self::Timelike => -S::ONE,
            Self::Spacelike => S::ONE,
        }
    }
}

/// The law that a potential stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Law {
    /// The paper's metric, diag(c² + 2V/m, −m_a/m, …): Newton's law for |V| ≪ mc² and speeds far below c.
    #[default]
    Relativistic,
    /// The lift L = ½(2V ṫ² + 2 ṫ ṡ − m_a (ẋ^a)²): exactly Newton's law (L. P. Eisenhart, Ann. of Math. 30 (1928) 591).
    Newtonian,
}

/// A particle, or several, in a potential.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PotentialText {
    /// The names of the coordinates of V.
    pub coordinates: Vec<String>,
    /// V in t and these coordinates.
    pub expression: String,
    /// Named expressions in t, the coordinates, the parameters and each other.
    pub definitions: Vec<(String, String)>,
    /// Named constants: numbers, or formulas in each other.
    pub parameters: Vec<(String, String)>,
    /// m, the mass in c² + 2V/m.
    pub mass: String,
    /// m_a of every coordinate, in t.
    pub masses: Vec<String>,
    /// The speed of light; not used by [`Law::Newtonian`].
    pub c: String,
    /// The law that the potential stands for.
    pub law: Law,
    /// A_a of Newton's L = ½mv² − V + A·v in t and the coordinates, by the index of the coordinate.
    pub one_form: Vec<(usize, String)>,
    /// A force besides −∂V, in t, the coordinates and their derivatives `NAME_dot`, by the index of the coordinate. The
    /// derivatives are with respect to γ, with [`Law::Newtonian`] to t.
    pub force: Vec<(usize, String)>,
    /// Ω in t and the coordinates.
    pub conformal: Option<String>,
    /// Functions that formulas may use.
    pub tables: Vec<(String, Table)>,
    /// Parameters that events set: no formula is simplified by their values.
    pub held: Vec<String>,
}

impl PotentialText {
    /// V of x alone, of a particle of this mass, with this speed of light.
    pub fn of_x(expression: &str, mass: f64, c: f64) -> Self {
        Self {
            coordinates: vec!["x".to_owned()],
            expression: expression.to_owned(),
            mass: format!("{mass:?}"),
            masses: vec![format!("{mass:?}")],
            c: format!("{c:?}"),
            ..Self::default()
        }
    }
}

/// A scene as text.
#[derive(Debug, Clone, PartialEq)]
pub enum GeometryText {
    /// Any metric.
    Metric(MetricText),
    /// The metric of a potential.
    Potential(PotentialText),
}

impl GeometryText {
    /// The names of all coordinates, in order.
    pub fn coordinates(&self) -> Vec<String> {
        let last = match self {
            Self::Metric(metric) => metric.tau.map(|_| Tau::NAME),
            Self::Potential(potential) => (potential.law == Law::Newtonian).then_some("s"),
        };
        self.positions().into_iter().chain(last.map(str::to_owned)).collect()
    }

    /// The coordinate `tau`, if there is one.
    pub fn tau(&self) -> Option<Tau> {
        match self {
            Self::Metric(metric) => metric.tau,
            Self::Potential(_) => None,
        }
    }

    /// The definitions, by name.
    pub fn definitions(&self) -> &[(String, String)] {
        let (Self::Metric(MetricText { definitions, .. }) | Self::Potential(PotentialText { definitions, .. })) = self;
        definitions
    }

    /// The coordinates that formulas of positions may use; they are the first ones.
    pub(crate) fn positions(&self) -> Vec<String> {
        match self {
            Self::Metric(metric) => metric.coordinates.clone(),
            Self::Potential(potential) => {
                std::iter::once("t".to_owned()).chain(potential.coordinates.iter().cloned()).collect()
            }
        }
    }

    /// The tables, by name.
    pub fn tables(&self) -> &[(String, Table)] {
        let (Self::Metric(MetricText { tables, .. }) | Self::Potential(PotentialText { tables, .. })) = self;
        tables
    }

    /// Lets formulas use these tables.
    pub fn set_tables(&mut self, named: Vec<(String, Table)>) {
        let (Self::Metric(MetricText { tables, .. }) | Self::Potential(PotentialText { tables, .. })) = self;
        *tables = named;
    }

    /// The parameters, by name.
    pub fn parameters(&self) -> &[(String, String)] {
        let (Self::Metric(MetricText { parameters, .. }) | Self::Potential(PotentialText { parameters, .. })) = self;
        parameters
    }

    /// The parameters that events set, and those that depend on them.
    pub(crate) fn held(&self) -> &[String] {
        let (Self::Metric(MetricText { held, .. }) | Self::Potential(PotentialText { held, .. })) = self;
        held
    }

    /// Lets events set what of these names is a parameter.
    pub fn hold(&mut self, mut names: Vec<String>) {
        let parameters = self.parameters();
        names.retain(|name| parameters.iter().any(|(parameter, _)| parameter == name));
        let is_next = |text: &str, names: &[String]| names.iter().any(|name| uses(text, name));
        while let Some((next, _)) =
            parameters.iter().find(|(name, text)| !names.contains(name) && is_next(text, &names))
        {
            names.push(next.clone());
        }
        let (Self::Metric(MetricText { held, .. }) | Self::Potential(PotentialText { held, .. })) = self;
        *held = names;
    }

    /// Gives parameters, by their places, these values.
    pub fn set_parameters(&mut self, values: &[(usize, f64)]) {
        let (Self::Metric(MetricText { parameters, .. }) | Self::Potential(PotentialText { parameters, .. })) = self;
        values.iter().for_each(|(place, value)| parameters[*place].1 = format!("{value:e}"));
    }
}

/// Returns true if `name` occurs in the text as a word of its own.
pub(crate) fn uses(text: &str, name: &str) -> bool {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).any(|word| word == name)
}

/// One of the formulas of a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// The component of a pair of coordinates.
    Component([usize; 2]),
    /// A definition.
    Definition(String),
    /// A parameter.
    Parameter(String),
    /// A_a of a coordinate.
    OneForm(usize),
    /// F_a of a coordinate.
    Force(usize),
    /// Ω.
    Conformal,
    /// V.
    Potential,
    /// The mass, or the mass of a coordinate.
    Mass(Option<usize>),
    /// c.
    SpeedOfLight,
}

/// A mistake in a scene.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// A formula is not understood.
    #[error("{1}")]
    Formula(Place, FormulaError),
    /// A parameter or a mass is not a finite number.
    #[error("not a finite number")]
    NotFinite(Place),
    /// Definitions or parameters that refer to each other in a circle, in order.
    #[error("the definitions are circular: {}", .0.join(" -> "))]
    Circular(Vec<String>),
    /// A coordinate without any component, so that the metric has no inverse.
    #[error("a coordinate has no component, so the metric has no inverse")]
    WithoutComponent(usize),
    /// A block of the metric whose determinant is zero everywhere.
    #[error("the determinant of the metric is zero everywhere")]
    Degenerate(Vec<usize>),
    /// More coordinates are coupled by off-diagonal components than the inverse is made for.
    #[error("{coordinates} coordinates are coupled by off-diagonal components, at most {most} may be")]
    BlockTooLarge {
        /// The number of coordinates.
        coordinates: usize,
        /// The largest number of them.
        most: usize,
    },
}

impl GeometryError {
    /// The formula that it is about.
    pub fn place(&self) -> Option<&Place> {
        match self {
            Self::Formula(place, _) | Self::NotFinite(place) => Some(place),
            _ => None,
        }
    }
}
